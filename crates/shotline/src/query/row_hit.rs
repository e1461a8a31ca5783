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

/// The crossings of rays, one ray after the other.
#[derive(Debug, Default)]
pub(super) struct RowLists {
    pub hits: Vec<RowHit>,
    /// Where those of each ray end.
    pub ends: Vec<usize>,
}

/// The crossings of some rays that follow each other.
#[derive(Clone, Copy)]
pub(super) struct ListsOfRows<'l> {
    pub hits: &'l [RowHit],
    /// Where those of each ray end, counted with `before` others.
    pub ends: &'l [usize],
    pub before: usize,
}

impl RowLists {
    /// The crossings of a ray.
    pub fn row_mut(&mut self, row: usize) -> &mut [RowHit] {
        let start = row.checked_sub(1).map_or(0, |before| self.ends[before]);
        &mut self.hits[start..self.ends[row]]
    }
}
