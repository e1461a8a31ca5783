//! Leaves in whose surface a ray runs: a face that two operands share belongs to the interior of their union.
//!
//! A ray in a face is not in the interior of the solid, but on one side of it is. A regularised combination
//! contains the ray where it is inside on every side around the ray. So the plane across the ray is cut into
//! sectors by the faces that the ray touches, and the expression is judged once in each (the neighbourhoods of
//! Requicha and Voelcker, Boolean operations in solid modeling, 1985).

use std::f64::consts::{FRAC_PI_2, PI};

use super::{Program, ProgramState};
use crate::math::{Vec3, unit};

/// Sectors narrower than this many radians lie between faces that only rounding tells apart.
const NARROW: f64 = 1e-6;

/// The leaves that one ray touches.
#[derive(Debug, Default)]
pub(super) struct Contacts {
    /// Of each leaf one entry for each face that the ray lies in: the angle of the outward normal in the plane
    /// across the ray.
    normals: Vec<(u32, f64)>,
    /// Two directions that span that plane.
    across: Option<(Vec3, Vec3)>,
    /// The leaves that the ray touches just now.
    touched: Vec<u32>,
    /// The angles at which a sector begins: memory only.
    borders: Vec<f64>,
}

impl Contacts {
    pub fn clear(&mut self) {
        self.normals.clear();
        self.across = None;
        self.touched.clear();
    }

    /// Whether the ray touches nothing just now.
    pub fn is_empty(&self) -> bool {
        self.touched.is_empty()
    }

    /// Adds a face of a leaf in which the ray lies somewhere.
    pub fn add(&mut self, leaf: u32, normal: Vec3, direction: Vec3) {
        let (x, y) = *self.across.get_or_insert_with(|| unit(direction).any_orthonormal_pair());
        let normal = unit(normal);
        self.normals.push((leaf, libm::atan2(normal.dot(y), normal.dot(x))));
    }

    /// Begins or ends the contact with a leaf.
    pub fn toggle(&mut self, leaf: u32) {
        match self.touched.iter().position(|&l| l == leaf) {
            Some(place) => {
                self.touched.swap_remove(place);
            }
            None => self.touched.push(leaf),
        }
    }

    /// Whether the expression is in on all sides of the ray. The state is left as it was.
    pub fn value(&mut self, program: &Program, state: &mut ProgramState) -> bool {
        self.borders.clear();
        for &(leaf, normal) in &self.normals {
            if self.touched.contains(&leaf) {
                self.borders
                    .extend([normal + FRAC_PI_2, normal - FRAC_PI_2].map(|a| libm::remainder(a, 2.0 * PI)));
            }
        }
        self.borders.sort_by(f64::total_cmp);
        let Some(&first) = self.borders.first() else { return state.value(program) };
        let ends = self.borders.iter().skip(1).copied().chain([first + 2.0 * PI]);
        self.borders
            .iter()
            .zip(ends)
            .all(|(&from, to)| to - from < NARROW || self.value_towards(0.5 * (from + to), program, state))
    }

    fn value_towards(&self, angle: f64, program: &Program, state: &mut ProgramState) -> bool {
        let is_behind = |normal: f64| libm::cos(normal - angle) < 0.0;
        let is_in = |leaf: u32| self.normals.iter().all(|&(l, normal)| l != leaf || is_behind(normal));
        let inside = || self.touched.iter().copied().filter(|&leaf| is_in(leaf));
        inside().for_each(|leaf| state.toggle(program, leaf));
        let value = state.value(program);
        inside().for_each(|leaf| state.toggle(program, leaf));
        value
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Op, Tree, TreeNode};
    use super::*;

    fn program(op: Op, leaf_count: u32) -> Program {
        let mut nodes: Vec<TreeNode> = (0..leaf_count).map(TreeNode::Leaf).collect();
        nodes.push(TreeNode::Op(op, (0..leaf_count).collect()));
        Program::new(&Tree { nodes }, leaf_count, leaf_count as usize)
    }

    /// Whether a ray along z lies in the combination of boxes that it touches with the given outward normals.
    fn holds(op: Op, leaves: &[&[Vec3]]) -> bool {
        let program = program(op, leaves.len() as u32);
        let (mut contacts, mut state) = (Contacts::default(), ProgramState::default());
        state.reset(&program);
        for (leaf, normals) in (0..).zip(leaves) {
            normals.iter().for_each(|&n| contacts.add(leaf, n, Vec3::Z));
            contacts.toggle(leaf);
        }
        contacts.value(&program, &mut state)
    }

    #[test]
    fn a_shared_face_is_inside_a_union_and_a_free_one_is_not() {
        assert!(!holds(Op::Union, &[&[Vec3::X]]));
        assert!(holds(Op::Union, &[&[Vec3::X], &[Vec3::NEG_X]]));
        // Up to rounding.
        assert!(holds(Op::Union, &[&[Vec3::X], &[Vec3::new(-1.0, 1e-15, 0.0)]]));
        // On the same side, one upon the other, and at an angle that leaves a gap.
        assert!(!holds(Op::Union, &[&[Vec3::X], &[Vec3::X]]));
        assert!(!holds(Op::Union, &[&[Vec3::X], &[Vec3::Y]]));
        assert!(!holds(Op::Intersection, &[&[Vec3::X], &[Vec3::NEG_X]]));
        assert!(!holds(Op::Difference, &[&[Vec3::X], &[Vec3::NEG_X]]));
    }

    #[test]
    fn four_boxes_close_around_an_edge_and_three_do_not() {
        let (x, y) = (Vec3::X, Vec3::Y);
        let corners: [&[Vec3]; 4] = [&[x, y], &[-x, y], &[-x, -y], &[x, -y]];
        assert!(holds(Op::Union, &corners));
        assert!(!holds(Op::Union, &corners[..3]));
        assert!(holds(Op::Union, &[corners[0], corners[1], &[-y]]));
    }
}
