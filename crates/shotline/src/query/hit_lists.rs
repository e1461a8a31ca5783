//! The hits of a block of rays at one mesh, as a list of crossings for each ray.

use std::ops::{ControlFlow, Range};

use super::Scope;
use super::placed_mesh::{PlacedMesh, box_holds_start};
use super::row_hit::RowHit;
use crate::crossing::{Crossing, is_alternating};
use crate::csg::{Boundary, HitKind, SingleLeaf};
use crate::ray::Span;
use crate::solid::mesh::kernel::KernelMemory;
use crate::solid::mesh::{MeshHit, MeshSolid, hits_to_crossings};

/// The hits of each ray, one after the other.
#[derive(Debug, Default)]
pub(super) struct HitLists {
    /// The end of each ray's hits.
    ends: Vec<u32>,
    hits: Vec<MeshHit>,
    /// Whether the plain path has to cast the ray.
    is_plain: Vec<bool>,
    crossings: Vec<Crossing>,
    sources: Vec<Option<u32>>,
}

impl HitLists {
    /// Takes all hits of the last cast, and sorts those of each ray by `t` and then by triangle.
    pub fn take(&mut self, rays: usize, kernel: &mut KernelMemory) {
        let HitLists { ends, hits, is_plain, .. } = self;
        is_plain.clear();
        is_plain.resize(rays, false);
        kernel.plain_rows().iter().for_each(|&row| is_plain[row as usize] = true);
        kernel.swap_hits(hits);
        ends.clear();
        let mut end = 0;
        for row in 0..rays as u32 {
            let start = end;
            end += hits[start..].iter().take_while(|hit| hit.row == row).count();
            hits[start..end].sort_unstable_by(|a, b| {
                let (a, b) = (&a.crossing, &b.crossing);
                a.t.total_cmp(&b.t).then(a.primitive.cmp(&b.primitive))
            });
            ends.push(end as u32);
        }
    }

    fn range(&self, ray: usize) -> Range<usize> {
        let start = if ray == 0 { 0 } else { self.ends[ray - 1] as usize };
        start..self.ends[ray] as usize
    }

    /// The number of hits of a ray.
    pub fn count(&self, ray: usize) -> usize {
        self.range(ray).len()
    }

    /// The hits of a ray; `None` if the plain path has to find them.
    pub fn hits(&self, ray: usize) -> Option<&[MeshHit]> {
        (!self.is_plain[ray]).then(|| &self.hits[self.range(ray)])
    }

    /// The crossings of a ray with a closed mesh, in whose frame `line` is; `None` if the plain path
    /// has to find them.
    pub fn crossings(
        &mut self,
        mesh: &MeshSolid,
        span: Span,
        ray: usize,
        line: &[f64; 6],
    ) -> Option<&[Crossing]> {
        if self.is_plain[ray] {
            return None;
        }
        let range = self.range(ray);
        let HitLists { hits, crossings, sources, .. } = self;
        crossings.clear();
        sources.clear();
        hits_to_crossings(&hits[range], crossings, sources);
        let begins_inside = crossings.first().is_some_and(|first| first.t == f64::NEG_INFINITY);
        let is_certain = !begins_inside || box_holds_start(mesh, line, span.t_min());
        (is_certain && is_alternating(crossings)).then_some(&crossings[..])
    }

    /// Passes the boundaries of a ray with a closed mesh, of the kinds that count, to `take` until it breaks, each with
    /// the hit if there is a surface. `line` is the ray's line in the frame of the mesh. Returns `false` if the plain
    /// path has to find them.
    pub fn boundaries(
        &mut self,
        mesh: &MeshSolid,
        scope: Scope,
        ray: usize,
        line: &[f64; 6],
        mut take: impl FnMut(Boundary, Option<&MeshHit>) -> ControlFlow<()>,
    ) -> bool {
        if self.is_plain[ray] {
            return false;
        }
        let hits = &self.hits[self.range(ray)];
        if are_crossings(hits, scope.span) {
            for hit in hits {
                if take(Boundary::of_leaf(hit.crossing), Some(hit)).is_break() {
                    break;
                }
            }
            return true;
        }
        if self.crossings(mesh, scope.span, ray, line).is_none() {
            return false;
        }
        let hits = &self.hits[self.range(ray)];
        let Some(mut single) = SingleLeaf::begin(&self.crossings, scope.span) else { return false };
        while let Some(boundary) = single.next(&self.crossings) {
            // The boundary is the crossing that was passed last, unless it is an end of the span.
            let is_surface = boundary.kind == HitKind::Surface;
            let source = self.sources.get(single.passed().wrapping_sub(1)).copied().flatten();
            let hit = source.filter(|_| is_surface).map(|hit| &hits[hit as usize]);
            if scope.kinds.hold(boundary.kind) && take(boundary, hit).is_break() {
                break;
            }
        }
        true
    }

    /// Appends the crossings of a ray; `line` is its line in the frame of the mesh. Returns `false` if the plain path has
    /// to find them.
    pub fn make(
        &mut self,
        placed: &PlacedMesh,
        scope: Scope,
        ray: usize,
        line: &[f64; 6],
        out: &mut Vec<RowHit>,
    ) -> bool {
        if placed.is_solid {
            return self.boundaries(placed.mesh, scope, ray, line, |boundary, hit| {
                out.push(placed.row_boundary(&boundary, hit));
                ControlFlow::Continue(())
            });
        }
        let Some(hits) = self.hits(ray) else { return false };
        out.extend(hits.iter().map(|hit| placed.row_hit(hit, &hit.crossing)));
        true
    }
}

/// Whether the sorted hits of a ray at a closed mesh are its crossings, which are then its boundaries: no two of them are
/// one event, none is near an end of the span, and they enter and leave in turn. Almost all rays are so.
fn are_crossings(hits: &[MeshHit], span: Span) -> bool {
    let is_within = |hit: &MeshHit| hit.crossing.low() > span.t_min() && hit.crossing.high() < span.t_max();
    hits.len().is_multiple_of(2)
        && hits.iter().enumerate().all(|(i, hit)| is_within(hit) && hit.crossing.entering == (i % 2 == 0))
        && hits.windows(2).all(|pair| pair[1].crossing.low() > pair[0].crossing.high())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::testkit::random::Random;

    #[test]
    fn hits_that_are_taken_as_they_are_make_the_boundaries_of_the_sweep() {
        let mut random = Random::new(5);
        let mut taken = 0;
        for _ in 0..100_000 {
            // Few distinct `t`, and bounds that reach from one hit to the next.
            let hit = |i: usize, t: f64, t_err: f64, entering: bool| MeshHit {
                row: 0,
                crossing: Crossing::new(t, t_err, entering, i as u32),
                is_off_edges: false,
                normal: Vec3::X,
                is_against: entering,
            };
            let mut hits: Vec<MeshHit> = (0..random.below(5))
                .map(|i| {
                    let (t, t_err) =
                        (random.below(9) as f64 / 2.0, [0.0, 1e-17, 0.01, 0.04][random.below(4)]);
                    hit(i, t, t_err, if random.below(8) == 0 { i % 2 == 1 } else { i % 2 == 0 })
                })
                .collect();
            let mut ts: Vec<f64> = hits.iter().map(|hit| hit.crossing.t).collect();
            ts.sort_by(f64::total_cmp);
            hits.iter_mut().zip(ts).for_each(|(hit, t)| hit.crossing.t = t);
            let [a, b] = [0, 1].map(|_| random.below(9) as f64 / 2.0 - 1.0);
            let t_max = if random.below(2) == 0 { f64::INFINITY } else { a.max(b) };
            let span = Span::new(a.min(b), t_max).expect("a span");
            if !are_crossings(&hits, span) {
                continue;
            }
            taken += usize::from(!hits.is_empty());
            let (mut crossings, mut sources) = (Vec::new(), Vec::new());
            hits_to_crossings(&hits, &mut crossings, &mut sources);
            assert!(is_alternating(&crossings));
            let mut single = SingleLeaf::begin(&crossings, span).expect("hits that are apart");
            let boundaries: Vec<Boundary> = std::iter::from_fn(|| single.next(&crossings)).collect();
            let expected: Vec<Boundary> = hits.iter().map(|hit| Boundary::of_leaf(hit.crossing)).collect();
            assert_eq!(boundaries, expected, "{hits:?} {span:?}");
        }
        assert!(taken > 5_000, "{taken}");
    }
}
