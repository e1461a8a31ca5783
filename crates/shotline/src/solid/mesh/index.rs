//! The structure by which rays find the triangles of a mesh.

use rayon::iter::ParallelIterator;

use super::kernel::WideIndex;
use super::mesh_line::Triangle;
use super::triangles::Triangles;
use crate::aabb::{Aabb, BoxRay};
use crate::accel::{self, Accelerator, Items};
use crate::counters::Counters;
use crate::tags::Tags;

/// The accelerator that takes longer to build.
const BEST: &str = "bvh_best";

/// A structure over the triangles of a mesh.
#[derive(Debug)]
pub(super) enum MeshIndex {
    /// The default: a wide hierarchy with the triangles in its leaves, which also casts blocks of rays.
    Wide(WideIndex),
    /// `bvh_best`: a wide hierarchy with spatial splits casts blocks of rays. Single lines, which also find the faces in
    /// whose planes they run by the boxes of whole triangles, traverse the accelerator.
    Best { blocks: WideIndex, lines: Box<dyn Accelerator> },
    /// Any other accelerator. Its items are the numbers of triangles.
    Other(Box<dyn Accelerator>),
}

/// Called with the triangles of a leaf or a cell. Returns the scaled `t` beyond which no more are needed.
pub(super) type Visitor<'a> = dyn FnMut(&[Triangle], &mut Counters) -> f64 + 'a;

impl MeshIndex {
    /// Builds the structure with a name, over triangles within bounds. Returns `None` if there is no such name.
    pub(super) fn build(name: &str, triangles: &Triangles, bounds: &Aabb) -> Option<MeshIndex> {
        if name == accel::DEFAULT {
            return Some(MeshIndex::Wide(WideIndex::of(triangles, bounds)));
        }
        let boxes: Vec<Aabb> = triangles.par_iter().map(|t| t.bounds()).collect();
        let lines = accel::build(name, Items { boxes: &boxes, groups: None })?;
        if name == BEST {
            let blocks = WideIndex::with_spatial_splits(triangles, bounds);
            return Some(MeshIndex::Best { blocks, lines });
        }
        Some(MeshIndex::Other(lines))
    }

    /// The structure over the same triangles after they have moved, now within given bounds. Returns `None` if the
    /// structure cannot be refitted or would become too slow; the caller must rebuild it.
    pub(super) fn refitted(&self, triangles: &Triangles, bounds: &Aabb) -> Option<MeshIndex> {
        match self {
            MeshIndex::Wide(index) => index.refitted(triangles, bounds).map(MeshIndex::Wide),
            MeshIndex::Best { .. } => None,
            MeshIndex::Other(accelerator) => {
                let mut accelerator = accelerator.clone();
                let items: Vec<u32> = (0..triangles.len() as u32).collect();
                accelerator
                    .refit(&items, &|item| triangles.get(item).bounds())
                    .then_some(MeshIndex::Other(accelerator))
            }
        }
    }

    pub(super) fn as_wide(&self) -> Option<&WideIndex> {
        match self {
            MeshIndex::Wide(index) | MeshIndex::Best { blocks: index, .. } => Some(index),
            MeshIndex::Other(_) => None,
        }
    }

    /// Whether a traversal may visit a triangle more than once, for which there should be tags.
    pub(super) fn has_duplicate_refs(&self) -> bool {
        match self {
            MeshIndex::Wide(_) => false,
            MeshIndex::Best { lines, .. } | MeshIndex::Other(lines) => lines.has_duplicate_refs(),
        }
    }

    /// Visits triangles whose boxes a line may meet, roughly the nearest first, each once if there are tags for them.
    pub(super) fn traverse(
        &self,
        triangles: &Triangles,
        ray: &BoxRay,
        counters: &mut Counters,
        (tags, pending): (&mut Tags, &mut Vec<(f64, u32)>),
        visit: &mut Visitor,
    ) {
        match self {
            MeshIndex::Wide(index) => index.tree.traverse(ray, counters, pending, |leaf, counters| {
                let (triangles, count) = index.triangles(leaf);
                visit(&triangles[..count], counters)
            }),
            MeshIndex::Best { lines, .. } | MeshIndex::Other(lines) => {
                lines.traverse(ray, counters, &mut |items, counters| {
                    let mut run = Vec::with_capacity(items.len());
                    for &item in items {
                        if tags.is_first(item as usize) {
                            run.push(triangles.get(item));
                        } else {
                            counters.tags_saved += 1;
                        }
                    }
                    visit(&run, counters)
                })
            }
        }
    }

    /// Bytes used.
    pub(super) fn memory(&self) -> usize {
        match self {
            MeshIndex::Wide(index) => index.memory(),
            MeshIndex::Best { blocks, lines } => blocks.memory() + lines.memory(),
            MeshIndex::Other(accelerator) => accelerator.memory(),
        }
    }
}
