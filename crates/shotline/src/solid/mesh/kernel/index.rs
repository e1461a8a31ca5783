//! The tree over the triangles of a mesh, with the triangles in the order of its leaves.

use super::block::{self, Block};
use crate::aabb::Aabb;
use crate::accel::wide::{self, LEAF_SIZE, NONE, WideBvh};
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
    /// Builds the tree over triangles.
    pub fn of(triangles: &Triangles, boxes: &[Aabb]) -> WideIndex {
        let (tree, leaves) = wide::build(boxes);
        let is_single =
            triangles.iter().flat_map(|t| t.corners).flat_map(|v| v.to_array()).all(block::is_single);
        let triangle = |item: u32| (item != NONE).then(|| triangles.get(item));
        let blocks = if is_single {
            Blocks::Single(leaves.iter().map(|leaf| Block::of(leaf.map(triangle))).collect())
        } else {
            Blocks::Double(leaves.iter().map(|leaf| Block::of(leaf.map(triangle))).collect())
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
