//! All real roots of cubics and quartics. Production code solves quadratics, and solves cubics and quartics only
//! between bounds (`crate::roots`, `crate::solid::torus`).

use crate::roots::{Roots, cubic_between, quadratic, root_bound, sign_changes, unit_sized};

/// The roots of `c[0] + c[1] x + c[2] x^2 + c[3] x^3`.
pub fn cubic(c: [f64; 4]) -> Roots {
    if c[3] == 0.0 {
        return quadratic([c[0], c[1], c[2]]);
    }
    let reach = root_bound(&c);
    cubic_between(c, -reach, reach, 0.0)
}

/// The roots of `c[0] + c[1] x + ... + c[4] x^4`.
pub fn quartic(c: [f64; 5]) -> Roots {
    if c[4] == 0.0 {
        return cubic([c[0], c[1], c[2], c[3]]);
    }
    let reach = root_bound(&c);
    quartic_between(c, -reach, reach, 0.0)
}

/// The roots of a quartic strictly between `lo` and `hi`, with a `tolerance` as in [`cubic_between`].
pub fn quartic_between(c: [f64; 5], lo: f64, hi: f64, tolerance: f64) -> Roots {
    let c = unit_sized(c);
    let extrema = cubic_between([c[1], 2.0 * c[2], 3.0 * c[3], 4.0 * c[4]], lo, hi, tolerance);
    sign_changes(&c, &extrema, lo, hi, tolerance)
}
