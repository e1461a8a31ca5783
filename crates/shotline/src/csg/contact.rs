//! Leaves in whose surface a ray runs: a face that two operands share belongs to the interior of their union.
//!
//! A ray in a face is not in the interior of the solid, but one side of the ray is. A regularised combination contains
//! the ray where every side of the ray is inside. So the surfaces that contain the ray cut the plane perpendicular to
//! it into sectors, and the expression is evaluated once in each sector (the neighbourhoods of Requicha and Voelcker,
//! Boolean operations in solid modeling, 1985).
//!
//! Along a ruling of a hyperboloid or a saddle the tangent plane rotates around the ray. The expression is evaluated
//! again where borders of two sectors exchange their order.

use std::f64::consts::{PI, TAU};

use super::border::{Curve, FlatBorder, SAME_DIRECTION};
use super::{Program, ProgramState};
use crate::contact::Contact;
use crate::crossing::Crossing;
use crate::math::{Vec3, unit};

/// A sector in which a leaf has its interior.
#[derive(Clone, Copy, Debug)]
struct SectorContact {
    leaf: u32,
    from: FlatBorder,
    to: FlatBorder,
    /// Where the contact begins and ends.
    interval: [f64; 2],
    /// Where the ray enters the bounds of the leaf.
    enter: f64,
}

/// A sector at one `t` of the ray.
#[derive(Clone, Copy, Debug)]
struct SectorAt {
    leaf: u32,
    from: Curve,
    to: Curve,
}

impl SectorAt {
    fn width(&self) -> f64 {
        (self.to.angle - self.from.angle).rem_euclid(TAU)
    }

    /// Whether a curve that is not one of the borders runs in the sector.
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

/// A point where two surfaces in which the ray runs exchange their order around it.
#[derive(Clone, Copy, Debug)]
pub struct OrderExchange {
    /// The leaf of one of the surfaces.
    pub leaf: u32,
    /// The `t` of the point and its bound.
    pub crossing: Crossing,
    /// Where the ray has entered the bounds of both leaves.
    pub enter: f64,
}

/// One side of a `t` of the ray, closer to it than any other change.
#[derive(Clone, Copy, Debug)]
pub(super) enum OneSided {
    Before(f64),
    After(f64),
}

/// The surfaces in which one ray runs.
#[derive(Debug, Default)]
pub(super) struct Contacts {
    sectors: Vec<SectorContact>,
    /// Whether any sector has borders that rotate.
    turning: bool,
    /// Where the borders of two sectors exchange their order: the numbers of the sectors, and `t`.
    order_exchanges: Vec<([u32; 2], f64)>,
    /// Two directions that span the plane perpendicular to the ray. With the ray they form a right-handed frame.
    plane_basis: Option<(Vec3, Vec3)>,
    /// The sectors whose interval contains the current `t`.
    open: Vec<u32>,
    /// The open sectors at one `t`, and their borders; kept only to reuse the memory.
    sectors_at: Vec<SectorAt>,
    borders: Vec<Curve>,
}

impl Contacts {
    pub fn clear(&mut self) {
        self.sectors.clear();
        self.turning = false;
        self.order_exchanges.clear();
        self.plane_basis = None;
        self.open.clear();
    }

    /// Whether the ray currently runs in no surface.
    pub fn is_empty(&self) -> bool {
        self.open.is_empty()
    }

    /// Adds a sector in which a leaf has its interior on an interval of the ray; returns its number. Appends the
    /// points where its borders exchange their order with those of other leaves.
    pub fn add(
        &mut self,
        leaf: u32,
        contact: &Contact,
        direction: Vec3,
        enter: f64,
        order_exchanges: &mut Vec<OrderExchange>,
    ) -> u32 {
        let plane_basis = *self.plane_basis.get_or_insert_with(|| unit(direction).any_orthonormal_pair());
        let Contact { sector, .. } = contact;
        let [from, to] = [sector.from, sector.to].map(|border| FlatBorder::new(&border, plane_basis));
        let (number, sector) = (
            self.sectors.len() as u32,
            SectorContact { leaf, from, to, interval: [contact.enter.t, contact.exit.t], enter },
        );
        self.turning |= sector.turns();
        let others = if self.turning { &self.sectors[..] } else { &[] };
        for (other_number, other) in (0..).zip(others).filter(|(_, other)| other.leaf != leaf) {
            // In the order of the leaves, whichever was found first, so that the bits are the same with all
            // accelerators.
            let [a, b] = if other.leaf < leaf { [other, &sector] } else { [&sector, other] };
            for crossing in a.exchanges(b) {
                self.order_exchanges.push(([other_number, number], crossing.t));
                order_exchanges.push(OrderExchange { leaf: a.leaf, crossing, enter: a.enter.max(b.enter) });
            }
        }
        self.sectors.push(sector);
        number
    }

    /// Begins or ends the interval of a sector.
    pub fn toggle(&mut self, sector: u32) {
        match self.open.iter().position(|&p| p == sector) {
            Some(side) => {
                self.open.swap_remove(side);
            }
            None => self.open.push(sector),
        }
    }

    /// Whether the ray is inside the expression on all of its sides. The state is left as it was.
    ///
    /// Around the ray, membership changes only at borders, so the expression is evaluated just past each border.
    /// Borders that differ by rounding only count as one.
    pub fn value(&mut self, program: &Program, state: &mut ProgramState, side: OneSided) -> bool {
        let t = self.sample(side);
        let mut sectors_at = std::mem::take(&mut self.sectors_at);
        sectors_at.clear();
        sectors_at.extend(self.open.iter().map(|&sector| self.sectors[sector as usize].sector_at(t)));
        // No sector is wider than half a turn: one that seems wider has no width.
        sectors_at.retain(|sector_at| (SAME_DIRECTION..PI + SAME_DIRECTION).contains(&sector_at.width()));
        let mut borders = std::mem::take(&mut self.borders);
        borders.clear();
        for border in sectors_at.iter().flat_map(|sector_at| [sector_at.from, sector_at.to]) {
            if !borders.iter().any(|other| border.coincides_with(other)) {
                borders.push(border);
            }
        }
        let mut curves = borders.iter().map(|border| behind(&borders, border));
        let value = curves.all(|curve| value_along(&sectors_at, &curve, program, state));
        (self.sectors_at, self.borders) = (sectors_at, borders);
        value
    }

    /// Returns a `t` at which the borders have the same order as on a side. It lies at most half way to the next `t`
    /// at which borders exchange their order or end. Within that limit it is far enough for rotating borders to be
    /// clearly apart.
    fn sample(&self, side: OneSided) -> f64 {
        let (t, way) = match side {
            OneSided::Before(t) => (t, -1.0),
            OneSided::After(t) => (t, 1.0),
        };
        let is_open = |sector: &u32| self.open.contains(sector);
        let order_exchanges = self.order_exchanges.iter().filter(|(sectors, _)| sectors.iter().all(is_open));
        let sectors = || self.open.iter().map(|&sector| &self.sectors[sector as usize]);
        let changes =
            order_exchanges.map(|(_, turn)| *turn).chain(sectors().flat_map(|sector| sector.interval));
        let steps = changes.map(|change| way * (change - t)).filter(|step| *step > 0.0);
        let next = steps.fold(f64::INFINITY, f64::min);
        let borders = sectors().flat_map(|sector| [&sector.from, &sector.to]);
        let step = borders.map(|border| border.step(t)).fold(0.5 * next, f64::min);
        if step.is_finite() { t + way * step } else { t }
    }
}

impl SectorContact {
    fn sector_at(&self, t: f64) -> SectorAt {
        SectorAt { leaf: self.leaf, from: self.from.curve(t), to: self.to.curve(t) }
    }

    fn turns(&self) -> bool {
        self.from.turns() || self.to.turns()
    }

    /// The points where borders of this sector and of another may exchange their order. The two borders of one sheet
    /// have the same points.
    fn exchanges(&self, other: &SectorContact) -> Vec<Crossing> {
        let sheets = |sector: &SectorContact| {
            if sector.from.is_opposite(&sector.to) { vec![sector.from] } else { vec![sector.from, sector.to] }
        };
        let mut out = Vec::new();
        for a in sheets(self) {
            sheets(other).iter().for_each(|b| a.exchanges(b, &mut out));
        }
        out
    }
}

/// A curve between a border and the next border counter-clockwise.
fn behind(borders: &[Curve], border: &Curve) -> Curve {
    let next = borders.iter().filter(|other| other.is_along(border) && other.is_behind(border));
    let next = next.map(|other| other.curvature).fold(f64::INFINITY, f64::min);
    Curve { curvature: 0.5 * border.curvature + 0.5 * next, ..*border }
}

fn value_along(sectors_at: &[SectorAt], curve: &Curve, program: &Program, state: &mut ProgramState) -> bool {
    let inside =
        || sectors_at.iter().filter(|sector_at| sector_at.contains(curve)).map(|sector_at| sector_at.leaf);
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

    /// Whether a ray along z is inside the combination of boxes in whose faces, given by outward normals, it runs.
    fn holds(op: Op, leaves: &[&[Vec3]]) -> bool {
        let program = program(op, leaves.len() as u32);
        let (mut contacts, mut state) = (Contacts::default(), ProgramState::default());
        state.reset(&program);
        for (leaf, normals) in (0..).zip(leaves) {
            let sheets: Vec<Sheet> = normals.iter().copied().map(Sheet::plane).collect();
            let sector = contacts.add(
                leaf,
                &contact(Sector::behind(&sheets, Vec3::Z).unwrap()),
                Vec3::Z,
                0.0,
                &mut Vec::new(),
            );
            contacts.toggle(sector);
        }
        contacts.value(&program, &mut state, OneSided::After(0.0))
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
        // On the same side, and at an angle that leaves a gap.
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
            let sector = contacts.add(leaf, &contact(sector), Vec3::Z, 0.0, &mut Vec::new());
            contacts.toggle(sector);
        }
        assert!(contacts.value(&program, &mut state, OneSided::After(0.0)));
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
