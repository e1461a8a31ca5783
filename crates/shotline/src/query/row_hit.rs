//! The numbers of a crossing that a batch has columns for.

use super::Hit;
use crate::csg::HitKind;
use crate::math::Vec3;

/// The numbers of a crossing that a batch has columns for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RowHit {
    pub t: f64,
    pub t_err: f64,
    pub normal: Vec3,
    pub object: u32,
    pub surface: Option<u32>,
    pub primitive: Option<u32>,
    pub path: u64,
    pub entering: bool,
    pub kind: HitKind,
}

impl From<&Hit> for RowHit {
    fn from(hit: &Hit) -> RowHit {
        let &Hit { t, t_err, normal, object, surface, primitive, path, entering, kind, .. } = hit;
        RowHit { t, t_err, normal, object, surface, primitive, path, entering, kind }
    }
}
