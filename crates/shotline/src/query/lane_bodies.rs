//! The bodies at which lines are cast in lanes: one for all lanes, or a body of each lane.

use super::lane_leaf::LeafMemory;
use crate::aabb::Aabb;
use crate::compile::SolidBody;
use crate::lanes::{BoxLanes, InsideLanes, LineLanes};
use crate::math::Affine;
use crate::ray::Span;
use crate::scratch::Scratch;
use crate::simd::Doubles;
use crate::solid::lanes::InLanes;

/// The body of each lane.
#[derive(Clone, Copy)]
pub(super) enum Bodies<'b> {
    Same(&'b SolidBody),
    /// Bodies of one [`World::lane_group`](crate::compile::World::lane_group) that differ: they have the same program, and
    /// leaves of the same kinds, all of which take lanes.
    Each(&'b [&'b SolidBody; 8]),
}

impl<'b> Bodies<'b> {
    /// The body of the first lane, whose program is that of all.
    #[inline(always)]
    pub fn first(&self) -> &'b SolidBody {
        match self {
            Bodies::Same(body) => body,
            Bodies::Each(bodies) => bodies[0],
        }
    }

    /// Where lines enter and leave the box of a leaf, and the lanes in which they do. Leaves with empty boxes never matter.
    #[inline(always)]
    pub fn enter_exit<F: Doubles>(&self, leaf: usize, boxes: &BoxLanes<F>) -> (F, F, u8) {
        let (enter, exit, filled) = match self {
            Bodies::Same(body) => {
                let bounds = &body.leaves[leaf].bounds;
                let (enter, exit) = boxes.enter_exit(bounds);
                (enter, exit, if bounds.is_empty() { 0 } else { u8::MAX })
            }
            Bodies::Each(bodies) => {
                let mut bounds = [&Aabb::EMPTY; 8];
                let mut filled = 0;
                for (lane, (to, body)) in bounds.iter_mut().zip(*bodies).enumerate() {
                    *to = &body.leaves[leaf].bounds;
                    filled |= u8::from(!to.is_empty()) << lane;
                }
                let (enter, exit) = boxes.enter_exit_each(&bounds);
                (enter, exit, filled)
            }
        };
        (enter, exit, filled & enter.is_at_most(exit))
    }

    /// Where lines of some lanes are inside a leaf.
    #[inline(always)]
    pub fn inside<F: Doubles>(
        &self,
        leaf: u32,
        (line, lanes): (&LineLanes<F>, u8),
        span: Span,
        memory: &mut LeafMemory,
        scratch: &mut Scratch,
    ) -> InsideLanes<F> {
        if let Bodies::Each(bodies) = self
            && let (Some(solids), frames) = leaves_in_lanes(bodies, leaf)
        {
            return InLanes::inside_each(&solids, &line.in_frames(&frames), lanes);
        }
        let (body, is_lone) = (self.first(), self.first().leaves.len() == 1);
        let leaf = &body.leaves[leaf as usize];
        let local = line.in_frame(&leaf.local_from_body);
        memory.inside(leaf, is_lone, (&local, lanes), span, scratch)
    }
}

/// A leaf of each body, and its frame; `None` if one does not take lanes.
#[inline(always)]
pub(super) fn leaves_in_lanes<'b>(
    bodies: &[&'b SolidBody; 8],
    leaf: u32,
) -> (Option<[InLanes<'b>; 8]>, [&'b Affine; 8]) {
    let of = |body: &'b SolidBody| &body.leaves[leaf as usize];
    let mut frames = [&of(bodies[0]).local_from_body; 8];
    let Some(first) = of(bodies[0]).solid.in_lanes() else { return (None, frames) };
    let mut solids = [first; 8];
    for (lane, body) in bodies.iter().enumerate() {
        let Some(solid) = of(body).solid.in_lanes() else { return (None, frames) };
        (solids[lane], frames[lane]) = (solid, &of(body).local_from_body);
    }
    (Some(solids), frames)
}
