//! Moments that are exact, or known but for a part that was sampled.

use std::sync::Arc;

use super::estimate::SHIFTS;
use crate::math::Affine;
use crate::solid::Moments;

/// The moments of a part of an object.
#[derive(Clone, Debug)]
pub(super) enum KnownMoments {
    /// Exact but for rounding.
    Exactly(Moments),
    /// As each of the randomised samples has them.
    Sampled(Arc<Sampled>),
}

/// What samples tell.
#[derive(Clone, Debug)]
pub(super) struct Sampled {
    pub(super) moments: [Moments; SHIFTS],
    /// As the rays along each axis have them.
    pub(super) axes: [Moments; 3],
    /// A volume that may have been overlooked, where few rays met anything.
    pub(super) unseen: f64,
    /// The solids sampled, in ascending order.
    pub(super) solids: Vec<u32>,
}

impl KnownMoments {
    /// Those under an affine map.
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

    /// Those of parts apart from each other taken together. Where one solid is placed several times its errors add up as
    /// they are: each sample is taken of all parts.
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

/// The moments of all parts, of a part that was sampled those of one sample.
fn total_of(parts: &[KnownMoments], sample: impl Fn(&Sampled) -> Moments) -> Moments {
    let own = |part: &KnownMoments| match part {
        KnownMoments::Exactly(moments) => *moments,
        KnownMoments::Sampled(sampled) => sample(sampled),
    };
    Moments::total(&parts.iter().map(own).collect::<Vec<_>>())
}
