//! No acceleration: proposes every item to every ray. Tests compare the other structures with it.

use super::{Accelerator, Child, QueueEntry, Visitor};
use crate::aabb::{Aabb, BoxRay};
use crate::counters::Counters;

/// Proposes everything at once.
#[derive(Clone, Debug)]
pub(super) struct Brute {
    items: Vec<u32>,
}

impl Brute {
    pub(super) fn build(boxes: &[Aabb]) -> Brute {
        let items = (0..).zip(boxes).filter(|(_, b)| !b.is_empty()).map(|(item, _)| item).collect();
        Brute { items }
    }
}

impl Accelerator for Brute {
    fn roots(&self, ray: &BoxRay, out: &mut Vec<QueueEntry>, _counters: &mut Counters) {
        let t = ray.span().t_min();
        out.extend(self.items.iter().map(|&item| QueueEntry { t, child: Child::Item(item) }));
    }

    fn expand(
        &self,
        _node: u64,
        _t: f64,
        _ray: &BoxRay,
        _out: &mut Vec<QueueEntry>,
        _counters: &mut Counters,
    ) {
    }

    fn traverse(&self, _ray: &BoxRay, counters: &mut Counters, visit: &mut Visitor) {
        visit(&self.items, counters);
    }

    fn has_duplicate_refs(&self) -> bool {
        false
    }

    fn memory(&self) -> usize {
        size_of_val(self.items.as_slice())
    }
}
