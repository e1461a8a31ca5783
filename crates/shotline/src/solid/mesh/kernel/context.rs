//! What one run of the kernel needs.

use super::block::{Block, Coordinate};
use super::frame::MeshFrame;
use super::lines::{Lines, RayBlock};
use super::prepare::{AT_A_TIME, Preparation, Prepare};
use super::ray::{KernelRay, Prepared};
use crate::accel::wide::{LEAF_SIZE, WideBvh};
use crate::crossing::Crossing;
use crate::simd::Simd;
use crate::solid::mesh::mesh_line::MeshLine;

/// A block of rays, and the mesh at which it is cast.
#[derive(Clone, Copy)]
pub(super) struct Kernel<'a, C> {
    pub frame: &'a MeshFrame,
    pub tree: &'a WideBvh,
    pub blocks: &'a [Block<C>],
    /// Whether a triangle may be in several leaves.
    pub has_duplicates: bool,
    pub preparation: Preparation,
    pub block: &'a RayBlock<'a>,
}

impl<C: Coordinate> Kernel<'_, C> {
    pub fn lines(&self) -> &Lines<'_> {
        &self.block.lines
    }

    /// Prepares the rays of some rows in some slots.
    #[inline(always)]
    pub fn prepare<S: Simd>(
        &self,
        rows: [usize; AT_A_TIME],
        slots: [usize; AT_A_TIME],
        rays: &mut [KernelRay],
    ) -> Prepared {
        let Kernel { frame: mesh, block, preparation, .. } = self;
        S::call(Prepare { preparation, mesh, block, rows, slots, rays })
    }

    /// The face of a triangle.
    pub fn face(&self, leaf: u32, lane: usize) -> u32 {
        self.blocks[leaf as usize].faces[lane % LEAF_SIZE]
    }

    /// The hit of a triangle by the plain path, and the `t` of it after scaling. Calls `in_plane` if the line runs in the
    /// triangle's plane.
    pub fn plain_hit(
        &self,
        row: usize,
        leaf: u32,
        lane: usize,
        in_plane: impl FnOnce(),
    ) -> Option<(Crossing, f64)> {
        let line = MeshLine::new(&self.lines().line(row), &self.frame.size, &self.frame.scaled_bounds)?;
        let hit = line.hit(&self.blocks[leaf as usize].triangle(lane), in_plane)?;
        Some((hit, line.scaled(hit.t)))
    }
}
