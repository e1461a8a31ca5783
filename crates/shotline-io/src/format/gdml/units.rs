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
    Measure::Length.factor(name).or_else(angle).or_else(volume)
}

/// The factor of a quantity's unit: that of a length or an angle in an expression, or of a density; 1 for other quantities,
/// which have nothing to do with geometry.
pub(super) fn of_quantity(unit: &str) -> f64 {
    in_expressions(unit).or_else(|| Measure::Density.factor(unit)).unwrap_or(1.0)
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
        assert_eq!(of_quantity("MeV"), 1.0);
    }
}
