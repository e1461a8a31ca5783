//! Leaves in whose surface a ray runs: a face that two operands share belongs to the interior of their union.
//!
//! A ray in a face is not in the interior of the solid, but on one side of it is. A regularised combination
//! contains the ray where it is inside on every side around the ray. So the plane across the ray is cut into
//! sectors by the surfaces that the ray lies in, and the expression is judged once in each (the neighbourhoods of
//! Requicha and Voelcker, Boolean operations in solid modeling, 1985).

use std::f64::consts::{PI, TAU};

use super::{Program, ProgramState};
use crate::crossing::{Border, Sector};
use crate::math::{Vec3, unit};

/// Borders at a smaller angle, in radians, have one direction.
const ONE_DIRECTION: f64 = 1e-6;

/// Curvatures that differ by less than this part of them are one.
const ONE_CURVATURE: f64 = 1e-6;

/// Where a sector begins or ends in the plane across the ray: a curve that leaves the ray at an angle, with a curvature,
/// positive if it bends counter-clockwise.
#[derive(Clone, Copy, Debug)]
struct Curve {
    angle: f64,
    curvature: f64,
}

impl Curve {
    /// Whether it leaves the ray in the same direction as another.
    fn is_along(&self, other: &Curve) -> bool {
        libm::remainder(self.angle - other.angle, TAU).abs() < ONE_DIRECTION
    }

    /// Whether it bends more than another in the same direction.
    fn is_behind(&self, other: &Curve) -> bool {
        let doubt = ONE_CURVATURE * self.curvature.abs().max(other.curvature.abs());
        self.curvature == f64::INFINITY || self.curvature - other.curvature > doubt
    }
}

/// A sector in which a leaf has its interior.
#[derive(Clone, Copy, Debug)]
struct Part {
    leaf: u32,
    from: Curve,
    to: Curve,
}

impl Part {
    fn width(&self) -> f64 {
        (self.to.angle - self.from.angle).rem_euclid(TAU)
    }

    /// Whether a curve other than the borders runs in the sector.
    fn contains(&self, curve: &Curve) -> bool {
        if curve.is_along(&self.from) {
            curve.is_behind(&self.from)
        } else if curve.is_along(&self.to) {
            self.to.is_behind(curve)
        } else {
            (curve.angle - self.from.angle).rem_euclid(TAU) < self.width()
        }
    }
}

/// The surfaces in which one ray runs.
#[derive(Debug, Default)]
pub(super) struct Contacts {
    parts: Vec<Part>,
    /// Two directions that span the plane across the ray, and with it form a right-handed frame.
    across: Option<(Vec3, Vec3)>,
    /// The parts beside which the ray runs just now.
    open: Vec<u32>,
}

impl Contacts {
    pub fn clear(&mut self) {
        self.parts.clear();
        self.across = None;
        self.open.clear();
    }

    /// Whether the ray runs in no surface just now.
    pub fn is_empty(&self) -> bool {
        self.open.is_empty()
    }

    /// Adds a sector in which a leaf has its interior on some stretch of the ray; returns its number.
    pub fn add(&mut self, leaf: u32, sector: Sector, direction: Vec3) -> u32 {
        let (x, y) = *self.across.get_or_insert_with(|| unit(direction).any_orthonormal_pair());
        let curve = |border: Border| {
            let v = border.direction;
            let along = unit(x * v.dot(x) + y * v.dot(y));
            let left = y * along.dot(x) - x * along.dot(y);
            let length = v.dot(along);
            Curve {
                angle: libm::atan2(along.dot(y), along.dot(x)),
                curvature: border.bend.dot(left) / length / length,
            }
        };
        self.parts.push(Part { leaf, from: curve(sector.from), to: curve(sector.to) });
        self.parts.len() as u32 - 1
    }

    /// Begins or ends the stretch of a sector.
    pub fn toggle(&mut self, part: u32) {
        match self.open.iter().position(|&p| p == part) {
            Some(place) => {
                self.open.swap_remove(place);
            }
            None => self.open.push(part),
        }
    }

    /// Whether the expression is in on all sides of the ray. The state is left as it was.
    ///
    /// What is around the ray changes at borders only, so it is judged behind each of them. Borders that differ
    /// by rounding only count as one.
    pub fn value(&self, program: &Program, state: &mut ProgramState) -> bool {
        let mut borders = self.open_parts().flat_map(|part| [part.from, part.to]);
        borders.all(|border| self.value_along(&self.behind(border), program, state))
    }

    /// The sectors beside which the ray runs. No sector is wider than half a turn: what seems so is one without width.
    fn open_parts(&self) -> impl Iterator<Item = &Part> + Clone {
        let parts = self.open.iter().map(|&part| &self.parts[part as usize]);
        parts.filter(|part| (ONE_DIRECTION..PI + ONE_DIRECTION).contains(&part.width()))
    }

    /// A curve between a border and the next one counter-clockwise.
    fn behind(&self, border: Curve) -> Curve {
        let others = self.open_parts().flat_map(|part| [part.from, part.to]);
        let next = others.filter(|other| other.is_along(&border) && other.is_behind(&border));
        let next = next.map(|other| other.curvature).fold(f64::INFINITY, f64::min);
        Curve { curvature: 0.5 * border.curvature + 0.5 * next, ..border }
    }

    fn value_along(&self, curve: &Curve, program: &Program, state: &mut ProgramState) -> bool {
        let inside = || self.open_parts().filter(|part| part.contains(curve)).map(|part| part.leaf);
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
    use crate::crossing::Sheet;

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
            let sheets: Vec<Sheet> = normals.iter().copied().map(Sheet::plane).collect();
            let part = contacts.add(leaf, Sector::behind(&sheets, Vec3::Z).unwrap(), Vec3::Z);
            contacts.toggle(part);
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
