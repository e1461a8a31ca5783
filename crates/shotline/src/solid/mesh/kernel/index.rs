//! The tree over the triangles of a mesh, with the triangles in the order of its leaves.

use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};

use super::block::{self, Block, Coordinate};
use crate::aabb::Aabb;
use crate::accel::wide::{self, LEAF_SIZE, NONE, WideBvh};
use crate::math::Vec3;
use crate::solid::mesh::distribute::CHUNK;
use crate::solid::mesh::mesh_line::Triangle;
use crate::solid::mesh::triangles::Triangles;

/// The tree and the triangles of a mesh.
#[derive(Debug)]
pub(in crate::solid::mesh) struct WideIndex {
    pub tree: WideBvh,
    pub(super) blocks: Blocks,
}

/// The triangles in the order of the leaves.
#[derive(Debug)]
pub(super) enum Blocks {
    Single(Vec<Block<f32>>),
    Double(Vec<Block<f64>>),
}

impl WideIndex {
    /// Builds the tree over triangles within bounds.
    pub fn of(triangles: &Triangles, bounds: &Aabb) -> WideIndex {
        let (tree, leaves) = wide::build(bounds, triangles.len(), |item| triangles.get(item).bounds());
        let is_single = |v: Vec3| v.to_array().into_iter().all(block::is_single);
        let blocks = if triangles.par_iter().all(|t| t.corners.into_iter().all(is_single)) {
            Blocks::Single(blocks(triangles, &leaves))
        } else {
            Blocks::Double(blocks(triangles, &leaves))
        };
        WideIndex { tree, blocks }
    }

    /// The triangles of a leaf, then anything, and their number.
    pub fn triangles(&self, leaf: u32) -> ([Triangle; LEAF_SIZE], usize) {
        match &self.blocks {
            Blocks::Single(blocks) => blocks[leaf as usize].triangles(),
            Blocks::Double(blocks) => blocks[leaf as usize].triangles(),
        }
    }

    /// Bytes used.
    pub fn memory(&self) -> usize {
        size_of_val(self.tree.nodes.as_slice())
            + match &self.blocks {
                Blocks::Single(blocks) => size_of_val(blocks.as_slice()),
                Blocks::Double(blocks) => size_of_val(blocks.as_slice()),
            }
    }
}

/// The triangles of leaves, given as items.
fn blocks<C: Coordinate>(triangles: &Triangles, leaves: &[[u32; LEAF_SIZE]]) -> Vec<Block<C>> {
    let triangle = |item: u32| (item != NONE).then(|| triangles.get(item));
    leaves.par_iter().with_min_len(CHUNK).map(|leaf| Block::of(leaf.map(triangle))).collect()
}
