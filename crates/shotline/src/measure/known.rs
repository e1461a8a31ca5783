//! Moments that are exact, or known but for a part that was sampled.

use std::sync::Arc;

use super::estimate::SHIFTS;
use crate::math::Affine;
use crate::solid::Moments;

/// The moments of a part of an object.
#[derive(Clone, Debug)]
pub(super) enum Known {
    /// Exact but for rounding.
    Exactly(Moments),
    /// As each of the randomised samples has them.
    Sampled(Arc<Sampled>),
}

/// What samples tell.
#[derive(Clone, Debug)]
pub(super) struct Sampled {
    pub(super) moments: [Moments; SHIFTS],
    /// A volume that may have been overlooked, where few rays met anything.
    pub(super) unseen: f64,
    /// The solids sampled, in ascending order.
    pub(super) solids: Vec<u32>,
}

impl Known {
    /// Those under an affine map.
    pub(super) fn placed(&self, map: &Affine) -> Known {
        match self {
            Known::Exactly(moments) => Known::Exactly(moments.placed(map)),
            Known::Sampled(sampled) => Known::Sampled(Arc::new(Sampled {
                moments: sampled.moments.map(|moments| moments.placed(map)),
                unseen: sampled.unseen * map.determinant().abs(),
                solids: sampled.solids.clone(),
            })),
        }
    }

    /// Those of parts apart from each other taken together. Where one solid is placed several times its errors add up as
    /// they are: each sample is taken of all parts.
    pub(super) fn total(parts: &[Known]) -> Known {
        let sampled = || parts.iter().filter_map(Known::sampled);
        if sampled().next().is_none() {
            let exact: Vec<Moments> = parts.iter().map(|part| part.sample(0)).collect();
            return Known::Exactly(Moments::total(&exact));
        }
        let mut solids: Vec<u32> = sampled().flat_map(|s| s.solids.iter().copied()).collect();
        solids.sort_unstable();
        solids.dedup();
        let total = |i: usize| Moments::total(&parts.iter().map(|part| part.sample(i)).collect::<Vec<_>>());
        let unseen = sampled().map(|s| s.unseen).sum();
        Known::Sampled(Arc::new(Sampled { moments: std::array::from_fn(total), unseen, solids }))
    }

    fn sampled(&self) -> Option<&Sampled> {
        match self {
            Known::Exactly(_) => None,
            Known::Sampled(sampled) => Some(sampled),
        }
    }

    fn sample(&self, i: usize) -> Moments {
        match self {
            Known::Exactly(moments) => *moments,
            Known::Sampled(sampled) => sampled.moments[i],
        }
    }
}
