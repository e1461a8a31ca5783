//! The parts of a surface within each cell. The surface may pass through a cell more than once; each part gets a vertex of its
//! own, so that no edge of the mesh has more than two triangles (S. Schaefer, T. Ju and J. Warren, "Manifold Dual Contouring",
//! IEEE Transactions on Visualization and Computer Graphics 13, 2007).
//!
//! A part is a set of crossings on edges of the cell. Around each face of a cell, the boundary enters the object and leaves it
//! in turn; the surface in the face joins crossings in pairs, without passing through itself, and those of a pair belong to one part on
//! both sides of the face. Which pairs: those whose points and normals fit best. So a wall that is thinner than a cell has
//! two parts, one for each of its sides.

use std::collections::HashMap;

use crate::disjoint_sets::DisjointSets;
use crate::octree::{Edge, Octree, key};
use crate::pairs::paired;
use crate::samples::{Crossing, Samples};

/// A crossing of the surface on an edge that no cell divides.
#[derive(Clone, Copy, Debug)]
pub struct EdgeCrossing {
    pub edge: Edge,
    /// Its number on the edge.
    pub ordinal: usize,
    pub crossing: Crossing,
    /// The cells around the edge, as [`Octree::around_edge`] returns them.
    pub cells: [u32; 4],
}

/// All crossings of edges.
#[derive(Debug, Default)]
pub struct EdgeCrossings {
    pub all: Vec<EdgeCrossing>,
    /// The first one of each edge and their number, by the middle of the edge.
    index: HashMap<u64, (u32, u32)>,
}

impl EdgeCrossings {
    /// Finds them.
    pub fn of(octree: &Octree, samples: &Samples) -> EdgeCrossings {
        let mut found = EdgeCrossings::default();
        for cell in octree.cells.iter().filter(|cell| cell.is_whole()) {
            for edge in cell.edges() {
                let crossings = samples.crossings(&edge);
                if !crossings.is_empty() && !is_divided(samples, &edge) {
                    found.add(octree, edge, crossings);
                }
            }
        }
        found
    }

    fn add(&mut self, octree: &Octree, edge: Edge, crossings: &[Crossing]) {
        let first = self.all.len() as u32;
        self.index.entry(key(edge.middle())).or_insert_with(|| {
            let cells = octree.around_edge(&edge);
            let numbered = crossings.iter().enumerate();
            self.all.extend(numbered.map(|(ordinal, crossing)| EdgeCrossing {
                edge,
                ordinal,
                crossing: *crossing,
                cells,
            }));
            (first, crossings.len() as u32)
        });
    }

    /// For each crossing and each of the cells around it, the part of the surface in this cell that it belongs to: parts have
    /// numbers from 0. Also their count.
    pub fn parts(&self, octree: &Octree, samples: &Samples) -> (Vec<[u32; 4]>, usize) {
        let mut sets = DisjointSets::of(4 * self.all.len());
        for (number, crossing) in self.all.iter().enumerate() {
            for side in 0..4 {
                let next = (side + 1) % 4;
                let (here, there) = (crossing.cells[side], crossing.cells[next]);
                if here == there {
                    sets.join(4 * number + side, 4 * number + next);
                    continue;
                }
                let Some(partner) = self.partner(octree, samples, number as u32, side) else { continue };
                for (side, cell) in [(side, here), (next, there)] {
                    let place = self.all[partner as usize].cells.iter().position(|other| *other == cell);
                    if let Some(place) = place {
                        sets.join(4 * number + side, 4 * partner as usize + place);
                    }
                }
            }
        }
        let (numbers, count) = sets.numbered();
        (numbers.as_chunks().0.to_vec(), count)
    }

    /// The crossing with which a crossing makes a pair, in the face between two of the cells around it.
    fn partner(&self, octree: &Octree, samples: &Samples, number: u32, side: usize) -> Option<u32> {
        let EdgeCrossing { edge, cells, .. } = self.all[number as usize];
        let [here, there] = [cells[side], cells[(side + 1) % 4]].map(|cell| octree.cells[cell as usize]);
        // The order of the cells is such that the first two, and the last two, lie beside each other along the first axis after
        // that of the edge.
        let normal = (edge.axis + 1 + side % 2) % 3;
        let smaller = if there.size < here.size { there } else { here };
        let mut corner = smaller.low;
        corner[normal] = edge.start[normal];
        let around = self.around_face(samples, corner, smaller.size, normal);
        let place = around.iter().position(|other| *other == number)?;
        let crossings: Vec<Crossing> =
            around.iter().map(|number| self.all[*number as usize].crossing).collect();
        Some(around[paired(&crossings, place)])
    }

    /// The crossings around a face, in order.
    fn around_face(&self, samples: &Samples, corner: [u32; 3], size: u32, normal: usize) -> Vec<u32> {
        let (u, v) = ((normal + 1) % 3, (normal + 2) % 3);
        let (mut upper_u, mut upper_v) = (corner, corner);
        upper_u[u] += size;
        upper_v[v] += size;
        let sides = [(u, corner, true), (v, upper_u, true), (u, upper_v, false), (v, corner, false)];
        let mut found = Vec::new();
        for (axis, start, forward) in sides {
            self.along(samples, Edge { axis, start, size }, forward, &mut found);
        }
        found
    }

    /// Adds the crossings along an edge, which may be divided.
    fn along(&self, samples: &Samples, edge: Edge, forward: bool, found: &mut Vec<u32>) {
        if is_divided(samples, &edge) {
            let [first, second] = edge.halves();
            let halves = if forward { [first, second] } else { [second, first] };
            halves.into_iter().for_each(|half| self.along(samples, half, forward, found));
        } else if let Some(&(first, count)) = self.index.get(&key(edge.middle())) {
            let numbers = first..first + count;
            if forward { found.extend(numbers) } else { found.extend(numbers.rev()) }
        }
    }
}

/// Whether a cell has a corner in the middle of an edge.
fn is_divided(samples: &Samples, edge: &Edge) -> bool {
    samples.inside(edge.middle()).is_some()
}
