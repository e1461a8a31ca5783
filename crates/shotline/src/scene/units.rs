//! Units of length.

use std::fmt::{self, Display, Formatter};

/// The unit of length that a scene is written in. shotline never converts lengths; the unit is printed with them, and
/// turns densities, which are in g/cm^3, into masses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Units {
    /// Nanometres.
    Nanometres,
    /// Micrometres.
    Micrometres,
    /// Millimetres.
    Millimetres,
    /// Centimetres.
    Centimetres,
    /// Metres.
    Metres,
    /// Kilometres.
    Kilometres,
    /// Inches of 2.54 cm.
    Inches,
    /// Feet of 30.48 cm.
    Feet,
}

impl Units {
    /// All of them, with their names in scene files.
    pub const ALL: [(&'static str, Units); 8] = [
        ("nm", Units::Nanometres),
        ("um", Units::Micrometres),
        ("mm", Units::Millimetres),
        ("cm", Units::Centimetres),
        ("m", Units::Metres),
        ("km", Units::Kilometres),
        ("in", Units::Inches),
        ("ft", Units::Feet),
    ];

    /// What scene files call a scene without units.
    pub const NONE: &'static str = "none";

    /// The name in scene files: its usual symbol.
    pub fn name(self) -> &'static str {
        Units::ALL.iter().find(|(_, units)| *units == self).map_or(Units::NONE, |(name, _)| name)
    }

    /// How many cubic centimetres a cube of this unit holds: the grams in a cubed unit of density 1 g/cm^3.
    pub fn cubic_centimetres(self) -> f64 {
        match self {
            Units::Nanometres => 1e-21,
            Units::Micrometres => 1e-12,
            Units::Millimetres => 1e-3,
            Units::Centimetres => 1.0,
            Units::Metres => 1e6,
            Units::Kilometres => 1e15,
            Units::Inches => 16.387_064,
            Units::Feet => 28_316.846_592,
        }
    }
}

impl Display for Units {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cubes_hold_what_their_edges_say() {
        let centimetres = [1e-7, 1e-4, 0.1, 1.0, 100.0, 1e5, 2.54, 30.48];
        for ((name, units), edge) in Units::ALL.into_iter().zip(centimetres) {
            assert!((units.cubic_centimetres() / f64::powi(edge, 3) - 1.0).abs() < 1e-15, "{name}");
            assert_eq!(units.to_string(), name);
        }
    }
}
