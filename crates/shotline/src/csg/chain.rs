//! Chains: events of which each coincides with the next within the bounds, but the first does not coincide with the
//! last.
//!
//! A thousand abutting layers, each thinner than the bounds of its faces, still form one body. So a chain is not one
//! event. Its boundaries are taken in the order of their `t`. Then the intervals that are too thin to be resolved are
//! removed: first the gaps between extents, so that connected extents become one, then the extents that are still too
//! thin. So everything that is wider than the bounds remains.

use super::event::Boundary;
use crate::crossing::are_coincident;

/// Keeps those of the alternating boundaries of a chain that bound resolved intervals.
pub(super) fn resolve(chain: &mut Vec<Boundary>) {
    let (Some(first), Some(last)) = (chain.first(), chain.last()) else { return };
    // The first boundary leads away from the side before the chain. If the last leads back to it, the extent is what
    // lies on the other side. Otherwise the chain ends on the other side, and the extent is the wider of the two
    // sides.
    let extent = if first.entering != last.entering { first.entering } else { wider(chain) };
    join(chain, !extent);
    join(chain, extent);
}

/// Removes the intervals of one side that are too thin to be resolved: for `true` those from an entry to an exit.
fn join(chain: &mut Vec<Boundary>, side: bool) {
    let mut kept = 0;
    for i in 0..chain.len() {
        let thin = kept > 0 && chain[kept - 1].entering == side && {
            let (from, to) = (&chain[kept - 1].crossing, &chain[i].crossing);
            are_coincident(from, to)
        };
        if thin {
            kept -= 1;
        } else {
            chain[kept] = chain[i];
            kept += 1;
        }
    }
    chain.truncate(kept);
}

/// The side with the greater total length in a chain: inside (`true`) or outside.
fn wider(chain: &[Boundary]) -> bool {
    let inside: f64 = chain
        .windows(2)
        .map(|w| (w[1].crossing.t - w[0].crossing.t) * if w[0].entering { 1.0 } else { -1.0 })
        .sum();
    inside >= 0.0
}

#[cfg(test)]
mod tests {
    use super::super::event::HitKind;
    use super::*;
    use crate::crossing::Crossing;

    /// The boundaries that are left of those at the given `t`, with bounds of 1/16: intervals thinner than 1 are not
    /// resolved.
    fn resolved(entering: bool, ts: &[f64]) -> Vec<f64> {
        let boundary = |(i, t): (usize, &f64)| {
            let entering = entering ^ (i % 2 == 1);
            let crossing = Crossing::new(*t, 0.0625, entering, 0);
            Boundary { kind: HitKind::Surface, entering, leaf: 0, crossing }
        };
        let mut chain: Vec<Boundary> = ts.iter().enumerate().map(boundary).collect();
        resolve(&mut chain);
        chain.iter().map(|b| b.crossing.t).collect()
    }

    #[test]
    fn layers_are_one_extent() {
        assert_eq!(resolved(true, &[0.0, 0.4, 0.4, 0.8, 0.8, 1.2]), [0.0, 1.2]);
        // With gaps as wide as the layers.
        assert_eq!(resolved(true, &[0.0, 0.4, 0.8, 1.2]), [0.0, 1.2]);
        // Adjacent slots cut out of a block.
        assert_eq!(resolved(false, &[0.0, 0.4, 0.4, 0.8, 0.8, 1.2]), [0.0, 1.2]);
    }

    #[test]
    fn what_is_not_resolved_is_nothing() {
        assert_eq!(resolved(true, &[0.0, 0.4]), []);
        assert_eq!(resolved(true, &[0.0, 0.2, 0.4, 0.6]), []);
        // A sliver beside a body.
        assert_eq!(resolved(true, &[0.0, 0.4, 1.6, 3.0]), [1.6, 3.0]);
    }

    #[test]
    fn a_chain_that_ends_on_the_other_side_keeps_one_boundary() {
        // Layers on a body, and slots at the end of a body.
        assert_eq!(resolved(true, &[0.0, 0.6, 0.6, 1.2, 1.2]), [0.0]);
        assert_eq!(resolved(false, &[0.0, 0.6, 0.6, 1.2, 1.2]), [0.0]);
    }
}
