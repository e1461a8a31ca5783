//! The f64 vector, plane and affine types used everywhere, in one place.

mod affine;
mod angle;
mod dd;
mod lattice;
mod length;
mod plane;
mod power_of_two;
mod shifts;
mod singular_transform;
mod split_mix;

pub use affine::{Affine, ComposedTransform, TransformPair};
pub use angle::sin_cos_degrees_wide;
pub use dd::{Dd, Real, difference_of_products, quick_two_sum, sum, two_prod, two_sum};
pub use glam::DVec3 as Vec3;
pub use lattice::{Lattice, MAX_CELLS, Row};
pub(crate) use length::UNIT_RANGE;
pub use length::{length, unit};
pub use plane::Plane;
pub use power_of_two::{PowerOfTwo, binary_exponent, power_of_two, power_of_two_below, power_of_two_near};
pub use shifts::ShiftedTransform;
pub use singular_transform::{MAX_CONDITION, SingularTransform};
pub use split_mix::{SPLIT_MIX64_STEP, split_mix64};

/// Half a unit in the last place of 1: the largest relative error of one rounded operation.
pub const HALF_ULP: f64 = f64::EPSILON / 2.0;

#[cfg(test)]
pub(crate) mod tests_support {
    pub(crate) use super::affine::tests::affine_strategy;
}
