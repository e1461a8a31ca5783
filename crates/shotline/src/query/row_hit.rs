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

/// What was found along rays, one ray after the other.
#[derive(Debug)]
pub(super) struct ByRow<T> {
    pub items: Vec<T>,
    /// Where those of each ray end.
    pub ends: Vec<usize>,
}

impl<T> Default for ByRow<T> {
    fn default() -> ByRow<T> {
        ByRow { items: Vec::new(), ends: Vec::new() }
    }
}

/// The crossings of some rays that follow each other.
#[derive(Clone, Copy)]
pub(super) struct ListsOfRows<'l> {
    pub hits: &'l [RowHit],
    /// Where those of each ray end, counted with `before` others.
    pub ends: &'l [usize],
    pub before: usize,
}

impl<T> ByRow<T> {
    /// Those of a ray.
    pub fn row(&self, row: usize) -> &[T] {
        let start = row.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.items[start..self.ends[row]]
    }

    /// Those of a ray.
    pub fn row_mut(&mut self, row: usize) -> &mut [T] {
        let start = row.checked_sub(1).map_or(0, |before| self.ends[before]);
        &mut self.items[start..self.ends[row]]
    }
}
