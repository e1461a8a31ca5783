//! Moments that are exact, or exact except for a part that was sampled.

use std::sync::Arc;

use super::estimate::SHIFTS;
use crate::math::Affine;
use crate::solid::Moments;

/// The moments of a part of an object.
#[derive(Clone, Debug)]
pub(super) enum KnownMoments {
    /// Exact but for rounding.
    Exactly(Moments),
    /// One estimate for each of the randomised samples.
    Sampled(Arc<Sampled>),
}

/// The result of sampling.
#[derive(Clone, Debug)]
pub(super) struct Sampled {
    pub(super) moments: [Moments; SHIFTS],
    /// The estimates by the rays along each axis.
    pub(super) axes: [Moments; 3],
    /// A volume that may have been missed, because few rays met anything.
    pub(super) unseen: f64,
    /// The solids sampled, in ascending order.
    pub(super) solids: Vec<u32>,
}

impl KnownMoments {
    /// Transforms the moments by an affine map.
    pub(super) fn placed(&self, map: &Affine) -> KnownMoments {
        match self {
            KnownMoments::Exactly(moments) => KnownMoments::Exactly(moments.placed(map)),
            KnownMoments::Sampled(sampled) => KnownMoments::Sampled(Arc::new(Sampled {
                moments: sampled.moments.map(|moments| moments.placed(map)),
                axes: sampled.axes.map(|moments| moments.placed(map)),
                unseen: sampled.unseen * map.determinant().abs(),
                solids: sampled.solids.clone(),
            })),
        }
    }

    /// Adds the moments of disjoint parts. If one solid has several placements, its errors add up without cancelling,
    /// because each sample includes all parts.
    pub(super) fn total(parts: &[KnownMoments]) -> KnownMoments {
        let sampled = || parts.iter().filter_map(KnownMoments::sampled);
        if sampled().next().is_none() {
            return KnownMoments::Exactly(total_of(parts, |sampled| sampled.moments[0]));
        }
        let mut solids: Vec<u32> = sampled().flat_map(|s| s.solids.iter().copied()).collect();
        solids.sort_unstable();
        solids.dedup();
        KnownMoments::Sampled(Arc::new(Sampled {
            moments: std::array::from_fn(|i| total_of(parts, |sampled| sampled.moments[i])),
            axes: std::array::from_fn(|i| total_of(parts, |sampled| sampled.axes[i])),
            unseen: sampled().map(|s| s.unseen).sum(),
            solids,
        }))
    }

    fn sampled(&self) -> Option<&Sampled> {
        match self {
            KnownMoments::Exactly(_) => None,
            KnownMoments::Sampled(sampled) => Some(sampled),
        }
    }
}

/// The total moments of all parts; a sampled part contributes one of its samples.
fn total_of(parts: &[KnownMoments], sample: impl Fn(&Sampled) -> Moments) -> Moments {
    let own = |part: &KnownMoments| match part {
        KnownMoments::Exactly(moments) => *moments,
        KnownMoments::Sampled(sampled) => sample(sampled),
    };
    Moments::total(&parts.iter().map(own).collect::<Vec<_>>())
}
