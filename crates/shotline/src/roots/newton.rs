//! Newton's method that never leaves a bracket.

/// An interval in which a continuous function changes its sign once.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Piece {
    /// The lower end.
    pub lo: f64,
    /// The upper end.
    pub hi: f64,
    /// Whether the function is negative at the lower end.
    pub rising: bool,
}

/// Maximum number of Newton steps. Where Newton's method converges it needs far fewer.
const NEWTON_STEPS: usize = 40;

/// The zero in a piece, by Newton steps where they stay in the bracket and by bisection elsewhere. Stops at a step of
/// `tolerance` or of an ulp. `value_and_slope` is called only for points of the piece. It may return both numbers
/// multiplied by any positive factor.
#[inline(always)]
pub fn bracketed_newton(
    piece: Piece,
    start: f64,
    tolerance: f64,
    value_and_slope: impl Fn(f64) -> (f64, f64),
) -> f64 {
    let Piece { mut lo, mut hi, rising } = piece;
    let mut x = start;
    for tried in 0.. {
        let (value, slope) = value_and_slope(x);
        if value == 0.0 {
            break;
        }
        if (value < 0.0) == rising {
            lo = x;
        } else {
            hi = x;
        }
        let step = value / slope;
        let next = x - step;
        if step.abs() <= tolerance.max(f64::EPSILON * x.abs()) {
            return next.clamp(piece.lo, piece.hi);
        }
        if lo < next && next < hi && tried < NEWTON_STEPS {
            x = next;
        } else {
            x = between(lo, hi);
            if x <= lo || x >= hi {
                break;
            }
        }
    }
    x
}

/// A number between two others: zero if they differ in sign, else the middle one of all doubles between them. So
/// bisection exhausts any interval after about a hundred steps, whatever the magnitudes of its ends. The result
/// scales exactly with powers of two.
fn between(lo: f64, hi: f64) -> f64 {
    if lo < 0.0 && hi > 0.0 {
        return 0.0;
    }
    let next_to_zero = |x: f64| x * 2f64.powi(-32);
    let (lo, hi) = match (lo == 0.0, hi == 0.0) {
        (true, true) => return 0.0,
        (true, false) => return next_to_zero(hi),
        (false, true) => return next_to_zero(lo),
        (false, false) => (lo.to_bits(), hi.to_bits()),
    };
    // They have the same sign, so their order is that of their bits, or the reverse.
    f64::from_bits(lo.min(hi) + lo.abs_diff(hi) / 2)
}
