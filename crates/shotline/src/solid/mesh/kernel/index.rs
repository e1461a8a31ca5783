//! The tree over the triangles of a mesh, with the triangles in the order of its leaves.

use rayon::iter::{IndexedParallelIterator, IntoParallelIterator, ParallelIterator};

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
    /// Whether a triangle may be in several leaves.
    pub(super) has_duplicates: bool,
}

/// The triangles in the order of the leaves.
#[derive(Debug)]
pub(super) enum Blocks {
    Single(Vec<Block<f32>>),
    Double(Vec<Block<f64>>),
}

impl Blocks {
    /// The triangles of so many leaves, given by their faces.
    fn of(
        triangles: &Triangles,
        leaves: usize,
        faces_of: impl Fn(usize) -> [u32; LEAF_SIZE] + Sync,
    ) -> Blocks {
        let is_single = |v: Vec3| v.to_array().into_iter().all(block::is_single);
        // It is faster to look at all vertices first, although those that no face uses do not matter.
        if triangles.vertices().all(is_single)
            || triangles.par_iter().all(|t| t.corners.into_iter().all(is_single))
        {
            Blocks::Single(blocks(triangles, leaves, faces_of))
        } else {
            Blocks::Double(blocks(triangles, leaves, faces_of))
        }
    }

    /// The faces of a leaf, then [`NONE`].
    fn faces(&self, leaf: usize) -> [u32; LEAF_SIZE] {
        match self {
            Blocks::Single(blocks) => blocks[leaf].faces,
            Blocks::Double(blocks) => blocks[leaf].faces,
        }
    }
}

impl WideIndex {
    /// Builds the tree over triangles within bounds.
    pub fn of(triangles: &Triangles, bounds: &Aabb) -> WideIndex {
        let (tree, leaves) = wide::build(bounds, triangles.len(), |item| triangles.get(item).bounds());
        WideIndex::with_leaves(tree, &leaves, triangles)
    }

    /// Builds the tree with spatial splits: triangles may be in several leaves.
    pub fn with_spatial_splits(triangles: &Triangles, bounds: &Aabb) -> WideIndex {
        let corners = |item: u32| triangles.get(item).corners;
        let (tree, leaves) = wide::build_with_spatial_splits(bounds, triangles.len(), corners);
        WideIndex::with_leaves(tree, &leaves, triangles)
    }

    fn with_leaves(tree: WideBvh, leaves: &[[u32; LEAF_SIZE]], triangles: &Triangles) -> WideIndex {
        let faces_of =
            |leaf: usize| leaves[leaf].map(|item| if item == NONE { NONE } else { triangles.face(item) });
        let references = leaves.iter().flatten().filter(|item| **item != NONE).count();
        let has_duplicates = references > triangles.len();
        WideIndex { tree, blocks: Blocks::of(triangles, leaves.len(), faces_of), has_duplicates }
    }

    /// The same tree over triangles that have moved, now within given bounds. Returns `None` if it would become too
    /// slow.
    pub fn refitted(&self, triangles: &Triangles, bounds: &Aabb) -> Option<WideIndex> {
        let faces_of = |leaf: usize| self.blocks.faces(leaf);
        let leaf_box = |leaf: u32| {
            let faces = faces_of(leaf as usize).into_iter().take_while(|face| *face != NONE);
            Aabb::around(faces.flat_map(|face| triangles.of_face(face).corners))
        };
        let tree = self.tree.refitted(bounds, leaf_box)?;
        let blocks = Blocks::of(triangles, self.block_count(), faces_of);
        Some(WideIndex { tree, blocks, has_duplicates: self.has_duplicates })
    }

    fn block_count(&self) -> usize {
        match &self.blocks {
            Blocks::Single(blocks) => blocks.len(),
            Blocks::Double(blocks) => blocks.len(),
        }
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

fn blocks<C: Coordinate>(
    triangles: &Triangles,
    leaves: usize,
    faces_of: impl Fn(usize) -> [u32; LEAF_SIZE] + Sync,
) -> Vec<Block<C>> {
    let triangle = |face: u32| (face != NONE).then(|| triangles.of_face(face));
    let block = |leaf: usize| Block::of(faces_of(leaf).map(triangle));
    (0..leaves).into_par_iter().with_min_len(CHUNK).map(block).collect()
}
