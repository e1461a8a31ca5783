//! Leaves in whose surface a ray runs: a face that two operands share belongs to the interior of their union.
//!
//! A ray in a face is not in the interior of the solid, but on one side of it is. A regularised combination
//! contains the ray where it is inside on every side around the ray. So the plane across the ray is cut into
//! sectors by the surfaces that the ray lies in, and the expression is judged once in each (the neighbourhoods of
//! Requicha and Voelcker, Boolean operations in solid modeling, 1985).
//!
//! Along a ruling of a hyperboloid or a saddle the tangent plane turns around the ray. The expression is judged again
//! where borders of two sectors exchange their order.

use std::f64::consts::{PI, TAU};

use super::border::{Curve, FlatBorder, ONE_DIRECTION};
use super::{Program, ProgramState};
use crate::contact::Contact;
use crate::crossing::Crossing;
use crate::math::{Vec3, unit};

/// A sector in which a leaf has its interior.
#[derive(Clone, Copy, Debug)]
struct Part {
    leaf: u32,
    from: FlatBorder,
    to: FlatBorder,
    /// Where the contact begins and ends.
    stretch: [f64; 2],
    /// Where the ray enters the bounds of the leaf.
    enter: f64,
}

/// The same at one place of the ray.
#[derive(Clone, Copy, Debug)]
struct Slice {
    leaf: u32,
    from: Curve,
    to: Curve,
}

impl Slice {
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

/// Where two surfaces in which the ray runs exchange their order around it.
#[derive(Clone, Copy, Debug)]
pub struct Turn {
    /// The leaf of one of them.
    pub leaf: u32,
    /// The place.
    pub crossing: Crossing,
    /// Where the ray has entered the bounds of both leaves.
    pub enter: f64,
}

/// A place on the ray, on one side of a `t`, before anything else changes there.
#[derive(Clone, Copy, Debug)]
pub(super) enum Place {
    Before(f64),
    After(f64),
}

/// The surfaces in which one ray runs.
#[derive(Debug, Default)]
pub(super) struct Contacts {
    parts: Vec<Part>,
    /// Whether a part has borders that turn.
    turning: bool,
    /// Where the borders of two parts exchange their order: the numbers of the parts, and `t`.
    turns: Vec<([u32; 2], f64)>,
    /// Two directions that span the plane across the ray, and with it form a right-handed frame.
    across: Option<(Vec3, Vec3)>,
    /// The parts beside which the ray runs just now.
    open: Vec<u32>,
    /// Those at one place, and their borders: memory only.
    slices: Vec<Slice>,
    borders: Vec<Curve>,
}

impl Contacts {
    pub fn clear(&mut self) {
        self.parts.clear();
        self.turning = false;
        self.turns.clear();
        self.across = None;
        self.open.clear();
    }

    /// Whether the ray runs in no surface just now.
    pub fn is_empty(&self) -> bool {
        self.open.is_empty()
    }

    /// Adds a sector in which a leaf has its interior on some stretch of the ray; returns its number. Appends where its
    /// borders exchange their order with those of other leaves.
    pub fn add(
        &mut self,
        leaf: u32,
        contact: &Contact,
        direction: Vec3,
        enter: f64,
        turns: &mut Vec<Turn>,
    ) -> u32 {
        let across = *self.across.get_or_insert_with(|| unit(direction).any_orthonormal_pair());
        let Contact { sector, .. } = contact;
        let [from, to] = [sector.from, sector.to].map(|border| FlatBorder::new(&border, across));
        let (number, part) = (
            self.parts.len() as u32,
            Part { leaf, from, to, stretch: [contact.enter.t, contact.exit.t], enter },
        );
        self.turning |= part.turns();
        let others = if self.turning { &self.parts[..] } else { &[] };
        for (other_number, other) in (0..).zip(others).filter(|(_, other)| other.leaf != leaf) {
            // In one order, whichever leaf was found first: so the bits are the same with all accelerators.
            let [a, b] = if other.leaf < leaf { [other, &part] } else { [&part, other] };
            for crossing in a.exchanges(b) {
                self.turns.push(([other_number, number], crossing.t));
                turns.push(Turn { leaf: a.leaf, crossing, enter: a.enter.max(b.enter) });
            }
        }
        self.parts.push(part);
        number
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
    pub fn value(&mut self, program: &Program, state: &mut ProgramState, place: Place) -> bool {
        let t = self.sample(place);
        let mut slices = std::mem::take(&mut self.slices);
        slices.clear();
        slices.extend(self.open.iter().map(|&part| self.parts[part as usize].slice(t)));
        // No sector is wider than half a turn: what seems so is one without width.
        slices.retain(|slice| (ONE_DIRECTION..PI + ONE_DIRECTION).contains(&slice.width()));
        let mut borders = std::mem::take(&mut self.borders);
        borders.clear();
        for border in slices.iter().flat_map(|slice| [slice.from, slice.to]) {
            if !borders.iter().any(|other| border.is_one_with(other)) {
                borders.push(border);
            }
        }
        let mut curves = borders.iter().map(|border| behind(&borders, border));
        let value = curves.all(|curve| value_along(&slices, &curve, program, state));
        (self.slices, self.borders) = (slices, borders);
        value
    }

    /// Returns a `t` at which the borders have the same order as at a place. It lies at most half way to the next `t` where
    /// borders exchange their order or end. Within that it is far enough for borders that turn to be clearly apart.
    fn sample(&self, place: Place) -> f64 {
        let (t, way) = match place {
            Place::Before(t) => (t, -1.0),
            Place::After(t) => (t, 1.0),
        };
        let is_open = |part: &u32| self.open.contains(part);
        let turns = self.turns.iter().filter(|(parts, _)| parts.iter().all(is_open));
        let parts = || self.open.iter().map(|&part| &self.parts[part as usize]);
        let changes = turns.map(|(_, turn)| *turn).chain(parts().flat_map(|part| part.stretch));
        let steps = changes.map(|change| way * (change - t)).filter(|step| *step > 0.0);
        let next = steps.fold(f64::INFINITY, f64::min);
        let borders = parts().flat_map(|part| [&part.from, &part.to]);
        let step = borders.map(|border| border.step(t)).fold(0.5 * next, f64::min);
        if step.is_finite() { t + way * step } else { t }
    }
}

impl Part {
    fn slice(&self, t: f64) -> Slice {
        Slice { leaf: self.leaf, from: self.from.curve(t), to: self.to.curve(t) }
    }

    fn turns(&self) -> bool {
        self.from.turns() || self.to.turns()
    }

    /// Where borders of this part and of another may exchange their order. Those of one sheet have the same places.
    fn exchanges(&self, other: &Part) -> Vec<Crossing> {
        let sheets = |part: &Part| {
            if part.from.is_opposite(&part.to) { vec![part.from] } else { vec![part.from, part.to] }
        };
        let mut out = Vec::new();
        for a in sheets(self) {
            sheets(other).iter().for_each(|b| a.exchanges(b, &mut out));
        }
        out
    }
}

/// A curve between a border and the next one counter-clockwise.
fn behind(borders: &[Curve], border: &Curve) -> Curve {
    let next = borders.iter().filter(|other| other.is_along(border) && other.is_behind(border));
    let next = next.map(|other| other.curvature).fold(f64::INFINITY, f64::min);
    Curve { curvature: 0.5 * border.curvature + 0.5 * next, ..*border }
}

fn value_along(slices: &[Slice], curve: &Curve, program: &Program, state: &mut ProgramState) -> bool {
    let inside = || slices.iter().filter(|slice| slice.contains(curve)).map(|slice| slice.leaf);
    inside().for_each(|leaf| state.toggle(program, leaf));
    let value = state.value(program);
    inside().for_each(|leaf| state.toggle(program, leaf));
    value
}

#[cfg(test)]
mod tests {
    use super::super::{Op, Tree, TreeNode};
    use super::*;
    use crate::contact::{Sector, Sheet};
    use crate::crossing::Crossing;

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
            let part = contacts.add(
                leaf,
                &contact(Sector::behind(&sheets, Vec3::Z).unwrap()),
                Vec3::Z,
                0.0,
                &mut Vec::new(),
            );
            contacts.toggle(part);
        }
        contacts.value(&program, &mut state, Place::After(0.0))
    }

    /// A contact along the whole ray.
    fn contact(sector: Sector) -> Contact {
        let at = |t: f64, entering: bool| Crossing::new(t, 0.0, entering, 0);
        Contact { enter: at(f64::NEG_INFINITY, true), exit: at(f64::INFINITY, false), sector }
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
    fn each_direction_is_judged_once_however_many_operands_share_a_face() {
        let program = program(Op::Union, 100);
        let (mut contacts, mut state) = (Contacts::default(), ProgramState::default());
        state.reset(&program);
        for leaf in 0..100 {
            let normal = Vec3::new(if leaf % 2 == 0 { 1.0 } else { -1.0 }, f64::from(leaf) * 1e-15, 0.0);
            let sector = Sector::behind(&[Sheet::plane(normal)], Vec3::Z).unwrap();
            let part = contacts.add(leaf, &contact(sector), Vec3::Z, 0.0, &mut Vec::new());
            contacts.toggle(part);
        }
        assert!(contacts.value(&program, &mut state, Place::After(0.0)));
        assert_eq!(contacts.borders.len(), 2);
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
