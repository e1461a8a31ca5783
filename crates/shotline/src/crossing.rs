//! What a solid returns: the crossings of a whole line with its surface.

/// Stands for the triangle of a crossing that has none.
pub const NO_PRIMITIVE: u32 = u32::MAX;

/// A point at which a line crosses the surface of one solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// The parameter on the line; infinite where the interior is unbounded.
    pub t: f64,
    /// A bound on the error of `t`, from the rounding of the inputs and of the arithmetic.
    pub t_err: f64,
    /// Whether the line enters the interior.
    pub entering: bool,
    /// Which surface of the solid: an index into [`crate::solid::Solid::surfaces`].
    pub surface: u32,
    /// The triangle of a mesh, else [`NO_PRIMITIVE`].
    pub primitive: u32,
    /// The crossing is one event with others within this many times its bound: [`GROUPING`], or less where the sign
    /// of the implicit function is certain closer to `t` than that. A root near infinity has a bound as large as its
    /// own distance, which must not extend back to where the line is certainly inside or outside.
    pub reach: f32,
}

impl Crossing {
    /// A crossing with a surface that has no triangles.
    pub fn new(t: f64, t_err: f64, entering: bool, surface: u32) -> Crossing {
        Crossing { t, t_err, entering, surface, primitive: NO_PRIMITIVE, reach: GROUPING as f32 }
    }

    /// The lower end of the interval in which the crossing is one event with others.
    pub fn low(&self) -> f64 {
        self.t - f64::from(self.reach) * self.t_err
    }

    /// The upper end of that interval.
    pub fn high(&self) -> f64 {
        self.t + f64::from(self.reach) * self.t_err
    }
}

/// Crossings are coincident, that is one event, if their `t` differ by at most this many times the sum of their
/// bounds.
pub const GROUPING: f64 = 8.0;

/// Whether two crossings, the first not after the second, are coincident.
pub fn are_coincident(a: &Crossing, b: &Crossing) -> bool {
    b.t == a.t || b.low() <= a.high()
}

/// Whether a list is valid as the result of a solid: ascending, alternating from an entry, and of even length.
pub fn is_alternating(list: &[Crossing]) -> bool {
    list.len().is_multiple_of(2)
        && list.iter().enumerate().all(|(i, c)| c.entering == (i % 2 == 0))
        && list.windows(2).all(|w| w[0].t <= w[1].t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn odd_and_unsorted_lists_are_seen() {
        let (a, b) = (Crossing::new(1.0, 0.0, true, 0), Crossing::new(2.0, 0.0, false, 0));
        assert!(is_alternating(&[]));
        assert!(is_alternating(&[a, b]));
        assert!(!is_alternating(&[a]));
        assert!(!is_alternating(&[b, a]));
        assert!(!is_alternating(&[Crossing { t: 3.0, ..a }, b]));
    }
}
