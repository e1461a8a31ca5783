//! What is wrong with the edges of a mesh, and faces with the same corners, which are found at their edges.

use rayon::iter::{IntoParallelIterator, ParallelIterator};

use super::distribute::Groups;
use super::welded::Face;
use super::{Edge, Tally};
use crate::math::Vec3;

/// The use of an edge by a face.
#[derive(Clone, Copy, Debug, Default)]
struct EdgeUse {
    /// Twice the number of the lower vertex in its range, plus 1 if the face runs from the lower to the higher.
    low: u32,
    high: u32,
    /// The face's corner that is not on the edge.
    third: u32,
    face: u32,
}

impl EdgeUse {
    fn is_forward(&self) -> bool {
        self.low & 1 == 1
    }
}

/// The counts of a report on a mesh that are found at edges.
#[derive(Debug, Default)]
pub(super) struct EdgeReport {
    pub(super) edges: usize,
    pub(super) open: Tally<Edge>,
    pub(super) non_manifold: Tally<Edge>,
    pub(super) inconsistent: Tally<Edge>,
    /// Faces with the corners of an earlier face, with the first such face.
    pub(super) duplicate_faces: Tally<[u32; 2]>,
}

/// Vertices are divided into ranges, of at least so many vertices, and at most so many.
const RANGE_BITS: u32 = 12;
const MAX_RANGES: usize = 2048;

impl EdgeReport {
    /// Examines the edges of faces in ascending order.
    pub(super) fn of(faces: &[Face], vertices: &[Vec3]) -> EdgeReport {
        let per_range = vertices.len().div_ceil(MAX_RANGES).max(1 << RANGE_BITS).next_power_of_two();
        let bits = per_range.ilog2();
        let uses = Groups::new(faces.len(), vertices.len().div_ceil(per_range), |face| {
            let Face { number: face, corners: [a, b, c] } = faces[face];
            [(a, b, c), (b, c, a), (c, a, b)].map(|(from, to, third)| {
                let (low, high) = (from.min(to), from.max(to));
                let low_in_range = low & (per_range as u32 - 1);
                let low_and_direction = low_in_range << 1 | u32::from(from < to);
                ((low >> bits) as usize, EdgeUse { low: low_and_direction, high, third, face })
            })
        });
        let of_range = |range: usize| {
            let mut report = EdgeReport::default();
            let (sorted, starts) = by_low_vertex(uses.group(range), per_range);
            let mut sorted = sorted;
            for low in 0..per_range {
                let uses = &mut sorted[starts[low] as usize..starts[low + 1] as usize];
                // The sort is stable: faces ascend.
                uses.sort_by_key(|edge_use| edge_use.high);
                for uses in uses.chunk_by(|a, b| a.high == b.high) {
                    report.add((range << bits | low) as u32, uses, vertices);
                }
            }
            report
        };
        (0..uses.count).into_par_iter().map(of_range).reduce(EdgeReport::default, EdgeReport::merged)
    }

    /// Takes an edge with all its uses.
    fn add(&mut self, low: u32, uses: &[EdgeUse], vertices: &[Vec3]) {
        self.edges += 1;
        let forward = uses.iter().filter(|edge_use| edge_use.is_forward()).count();
        if let [first, second] = uses
            && forward == 1
            && first.third != second.third
        {
            return;
        }
        let ends = [low, uses[0].high];
        let [from, to] = ends.map(|v| vertices[v as usize]);
        let edge = Edge { vertices: ends, from, to, faces: [uses[0].face, uses[uses.len() - 1].face] };
        if 2 * forward != uses.len() {
            self.open.add(edge);
        }
        if uses.len() > 2 {
            self.non_manifold.add(edge);
        }
        if uses.len() == 2 && forward != 1 {
            self.inconsistent.add(edge);
        }
        // Each face is examined at the edge of its two lowest corners.
        let mut others: Vec<(u32, u32)> = uses
            .iter()
            .filter(|edge_use| edge_use.third > ends[1])
            .map(|edge_use| (edge_use.third, edge_use.face))
            .collect();
        others.sort_unstable();
        for alike in others.chunk_by(|a, b| a.0 == b.0) {
            alike[1..].iter().for_each(|later| self.add_duplicate([later.1, alike[0].1]));
        }
    }

    fn add_duplicate(&mut self, faces: [u32; 2]) {
        let Tally { count, first } = &mut self.duplicate_faces;
        *count += 1;
        *first = Some(first.map_or(faces, |first| first.min(faces)));
    }

    /// Adds a report on edges behind these.
    fn merged(mut self, later: EdgeReport) -> EdgeReport {
        let duplicates = [self.duplicate_faces.first, later.duplicate_faces.first];
        self.duplicate_faces.count += later.duplicate_faces.count;
        self.duplicate_faces.first = duplicates.into_iter().flatten().min();
        EdgeReport {
            edges: self.edges + later.edges,
            open: self.open.merged(later.open),
            non_manifold: self.non_manifold.merged(later.non_manifold),
            inconsistent: self.inconsistent.merged(later.inconsistent),
            ..self
        }
    }
}

/// Sorts uses by the number of their lower vertex in its range; returns them with the start of each number.
fn by_low_vertex<'a>(
    uses: impl Iterator<Item = &'a EdgeUse> + Clone,
    per_range: usize,
) -> (Vec<EdgeUse>, Vec<u32>) {
    let vertex = |edge_use: &EdgeUse| (edge_use.low >> 1) as usize;
    let mut starts = vec![0; per_range + 1];
    uses.clone().for_each(|edge_use| starts[vertex(edge_use) + 1] += 1);
    (0..per_range).for_each(|v| starts[v + 1] += starts[v]);
    let mut ends = starts.clone();
    let mut sorted = vec![EdgeUse::default(); starts[per_range] as usize];
    for edge_use in uses {
        let end = &mut ends[vertex(edge_use)];
        sorted[*end as usize] = *edge_use;
        *end += 1;
    }
    (sorted, starts)
}
