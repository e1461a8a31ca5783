//! The units of GDML, as factors to the millimetre, and of angles to the degree.

use std::f64::consts::PI;

/// Lengths in millimetres: those of Geant4, and the inch and the foot, which files of other programs have.
const LENGTHS: &[(&[&str], f64)] = &[
    (&["mm", "millimeter"], 1.0),
    (&["cm", "centimeter"], 10.0),
    (&["m", "meter", "metre"], 1e3),
    (&["km", "kilometer"], 1e6),
    (&["um", "micrometer", "micron"], 1e-3),
    (&["nm", "nanometer"], 1e-6),
    (&["Ang", "angstrom"], 1e-7),
    (&["fm", "fermi"], 1e-12),
    (&["dm", "decimeter"], 100.0),
    (&["in", "inch"], 25.4),
    (&["ft", "foot"], 304.8),
    (&["pc", "parsec"], 3.085_677_580_7e19),
];

/// Angles in degrees.
const ANGLES: &[(&[&str], f64)] =
    &[(&["deg", "degree"], 1.0), (&["rad", "radian"], 180.0 / PI), (&["mrad", "milliradian"], 0.18 / PI)];

/// Densities in g/cm^3.
const DENSITIES: &[(&[&str], f64)] =
    &[(&["g/cm3", "g/cm^3"], 1.0), (&["mg/cm3", "mg/cm^3"], 1e-3), (&["kg/m3", "kg/m^3"], 1e-3)];

/// Other units, in those of Geant4: MeV, ns, mm, elementary charge, kelvin, mole and steradian. Geometry does not depend on them,
/// but files define optical properties by them.
const OTHERS: &[(&[&str], f64)] = &[
    (&["eV", "electronvolt"], 1e-6),
    (&["keV", "kiloelectronvolt"], 1e-3),
    (&["MeV", "megaelectronvolt"], 1.0),
    (&["GeV", "gigaelectronvolt"], 1e3),
    (&["TeV", "teraelectronvolt"], 1e6),
    (&["J", "joule"], 6.241_509_074e12),
    (&["ns", "nanosecond"], 1.0),
    (&["ps", "picosecond"], 1e-3),
    (&["us", "microsecond"], 1e3),
    (&["ms", "millisecond"], 1e6),
    (&["s", "second"], 1e9),
    (&["minute"], 6e10),
    (&["hour"], 3.6e12),
    (&["day"], 8.64e13),
    (&["year"], 3.1536e16),
    (&["Hz", "hertz", "Bq", "becquerel"], 1e-9),
    (&["kHz", "kilohertz"], 1e-6),
    (&["MHz", "megahertz"], 1e-3),
    (&["Ci", "curie"], 37.0),
    (&["kg", "kilogram"], 6.241_509_074e24),
    (&["g", "gram"], 6.241_509_074e21),
    (&["mg", "milligram"], 6.241_509_074e18),
    (&["K", "kelvin", "mol", "mole", "sr", "steradian", "cd", "candela", "lumen"], 1.0),
    (&["V", "volt"], 1e-6),
    (&["T", "tesla"], 1e-3),
    (&["gauss"], 1e-7),
    (&["C", "coulomb"], 6.241_509_074e18),
    (&["A", "ampere"], 6.241_509_074e9),
    (&["N", "newton"], 6.241_509_074e9),
    (&["W", "watt"], 6.241_509_074e3),
    (&["Pa", "pascal"], 6.241_509_074e3),
    (&["bar"], 6.241_509_074e8),
    (&["atm", "atmosphere"], 6.324_209_069e8),
    (&["barn"], 1e-22),
    (&["L", "liter", "litre"], 1e6),
    (&["mL"], 1e3),
];

/// What a unit measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Measure {
    Length,
    Angle,
    Density,
}

impl Measure {
    fn table(self) -> &'static [(&'static [&'static str], f64)] {
        match self {
            Measure::Length => LENGTHS,
            Measure::Angle => ANGLES,
            Measure::Density => DENSITIES,
        }
    }

    /// The factor of a unit to millimetres, degrees or g/cm^3.
    pub(super) fn factor(self, unit: &str) -> Option<f64> {
        self.table().iter().find(|(names, _)| names.contains(&unit)).map(|(_, factor)| *factor)
    }

    /// The factor of a file that names no unit: that of millimetres, radians or g/cm^3.
    pub(super) fn default_factor(self) -> f64 {
        if self == Measure::Angle { 180.0 / PI } else { 1.0 }
    }

    /// The names of the units, for messages.
    pub(super) fn names(self) -> impl Iterator<Item = &'static str> {
        self.table().iter().flat_map(|(names, _)| names.iter().copied())
    }

    /// What it is called in messages.
    pub(super) fn noun(self) -> &'static str {
        match self {
            Measure::Length => "length",
            Measure::Angle => "angle",
            Measure::Density => "density",
        }
    }
}

/// The value of a unit in an expression, where lengths are in millimetres and angles in radians.
pub(super) fn in_expressions(name: &str) -> Option<f64> {
    let angle = || Measure::Angle.factor(name).map(|degrees| degrees * (PI / 180.0));
    let volume = || {
        let (edge, power) = name.split_at_checked(name.len().checked_sub(1)?)?;
        let edge = Measure::Length.factor(edge)?;
        match power {
            "2" => Some(edge * edge),
            "3" => Some(edge * edge * edge),
            _ => None,
        }
    };
    let other = || OTHERS.iter().find(|(names, _)| names.contains(&name)).map(|(_, factor)| *factor);
    Measure::Length.factor(name).or_else(angle).or_else(volume).or_else(other)
}

/// The factor of a quantity's unit: that of a length or an angle in an expression, or of a density; 1 for other quantities,
/// which have nothing to do with geometry.
pub(super) fn of_quantity(unit: &str) -> f64 {
    Measure::Density.factor(unit).or_else(|| in_expressions(unit)).unwrap_or(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_have_their_factors() {
        assert_eq!(Measure::Length.factor("cm"), Some(10.0));
        assert_eq!(Measure::Length.factor("furlong"), None);
        assert_eq!(PI * Measure::Angle.factor("rad").unwrap(), 180.0);
        assert_eq!(std::f64::consts::FRAC_PI_2 * Measure::Angle.default_factor(), 90.0);
        assert_eq!(in_expressions("cm3"), Some(1000.0));
        assert_eq!(in_expressions("deg"), Some(PI / 180.0));
        assert_eq!(of_quantity("mg/cm3"), 1e-3);
        assert_eq!(of_quantity("eV"), 1e-6);
        assert_eq!(of_quantity("furlong"), 1.0);
        assert_eq!(in_expressions("keV"), Some(1e-3));
    }
}
