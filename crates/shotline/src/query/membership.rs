//! Tests whether a body contains a point. The accelerator finds the leaves whose boxes contain the point; the point
//! is outside all others.

use crate::aabb::BoxRay;
use crate::accel::{Child, QueueEntry};
use crate::compile::SolidBody;
use crate::csg::ProgramState;
use crate::math::Vec3;
use crate::ray::{Line, Span};
use crate::scratch::Scratch;
use crate::tags::Tags;

/// The memory of a membership test; reused from point to point.
#[derive(Debug, Default)]
pub(super) struct Membership {
    state: ProgramState,
    pending: Vec<QueueEntry>,
    tags: Tags,
}

/// A point as a line: its span has no length, so it hits a box if and only if the box contains the point. Boxes and
/// bounds are conservative: rounding may include a box too many, but never leaves one out.
pub(super) fn line_at(p: Vec3) -> Line {
    Line::exact(p, Vec3::X)
}

impl Membership {
    /// Returns whether a body contains the origin of a line, in the frame of the body. Invalid if the budget has
    /// ended.
    ///
    /// A leaf cannot change the result outside its effective bounds (see `Program::effective_bounds`), so it is not
    /// tested there: the cost grows with the number of leaves whose boxes contain the point.
    pub(super) fn holds(&mut self, body: &SolidBody, line: &Line, here: Span, below: &mut Scratch) -> bool {
        self.state.reset(&body.program);
        match &body.accel {
            None if body.leaves.len() == 1 => self.toggle_if_inside(body, 0, line.o, below),
            None => {
                let ray = BoxRay::new(line, here);
                for (number, leaf) in (0..).zip(&body.leaves) {
                    below.counters.boxes += 1;
                    if !leaf.bounds.is_empty() && ray.enter_exit(&leaf.bounds).is_some() {
                        self.toggle_if_inside(body, number, line.o, below);
                    }
                }
            }
            Some(accel) => {
                let ray = BoxRay::new(line, here);
                self.tags.begin();
                if accel.has_duplicate_refs() {
                    self.tags.reserve(body.leaves.len());
                }
                self.pending.clear();
                accel.roots(&ray, &mut self.pending, &mut below.counters);
                while let Some(next) = self.pending.pop() {
                    if !below.budget.step() {
                        break;
                    }
                    match next.child {
                        Child::Node(node) => {
                            accel.expand(node, next.t, &ray, &mut self.pending, &mut below.counters);
                        }
                        Child::Item(leaf) if self.tags.is_first(leaf as usize) => {
                            below.counters.boxes += 1;
                            if ray.enter_exit(&body.leaves[leaf as usize].bounds).is_some() {
                                self.toggle_if_inside(body, leaf, line.o, below);
                            }
                        }
                        Child::Entered(leaf) => self.toggle_if_inside(body, leaf, line.o, below),
                        Child::Item(_) => below.counters.tags_saved += 1,
                    }
                }
            }
        }
        let inside = self.state.value(&body.program);
        self.state.clear(&body.program);
        inside
    }

    fn toggle_if_inside(&mut self, body: &SolidBody, leaf: u32, p: Vec3, below: &mut Scratch) {
        let leaf_data = &body.leaves[leaf as usize];
        below.counters.primitive_tests += 1;
        let p = leaf_data.local_from_body.point(p);
        let is_inside = match leaf_data.solid.as_mesh() {
            Some(mesh) => mesh.contains_one_of_many(p),
            None => leaf_data.solid.contains(p),
        };
        if is_inside {
            self.state.toggle(&body.program, leaf);
        }
    }
}
