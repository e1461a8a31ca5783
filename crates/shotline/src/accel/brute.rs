//! No structure at all: every item is proposed to every ray. The oracle of the others.

use super::{Accelerator, Offer, Pending, Visit, Work};
use crate::aabb::{Aabb, BoxRay};

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
    fn start(&self, ray: &BoxRay, out: &mut Vec<Pending>, _work: &mut Work) {
        let t = ray.span().t_min();
        out.extend(self.items.iter().map(|&item| Pending { t, what: Offer::Item(item) }));
    }

    fn open(&self, _part: u64, _t: f64, _ray: &BoxRay, _out: &mut Vec<Pending>, _work: &mut Work) {}

    fn walk(&self, _ray: &BoxRay, work: &mut Work, visit: &mut Visit) {
        visit(&self.items, work);
    }

    fn repeats(&self) -> bool {
        false
    }

    fn memory(&self) -> usize {
        size_of_val(self.items.as_slice())
    }
}
