//! Why a transform has no inverse.

/// Transforms with a condition number above this are rejected. At a condition number `c` the bounds of crossings are
/// about `c` times 10^-15 of the size of the solid, and crossings within 8 times the sum of their bounds are one
/// event. So above this limit all crossings of a solid could be one event, and the solid would vanish.
pub const MAX_CONDITION: f64 = 1e12;

/// A transform that is singular, or so nearly singular that its inverse is not reliable.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{}", self.why())]
pub struct SingularTransform {
    /// The condition number of the linear part; infinite for a singular one, NaN for a matrix with NaN. At most
    /// [`MAX_CONDITION`] if the inverse has numbers beyond the range of float64.
    pub condition: f64,
}

impl SingularTransform {
    fn why(&self) -> String {
        let condition = self.condition;
        if self.is_beyond_range() {
            return "the inverse of the transform is beyond the range of numbers, since it scales so much"
                .into();
        }
        let limit = format!("(condition number {condition:.3e}, at most {MAX_CONDITION:.0e} is accepted)");
        format!("the transform is singular or nearly so {limit}")
    }

    /// Whether the transform does not flatten space, but scales by so little or so much that its inverse overflows.
    pub fn is_beyond_range(&self) -> bool {
        self.condition <= MAX_CONDITION
    }
}
