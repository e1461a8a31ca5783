//! Levels whose placements are mostly turned in one way: their boxes are computed in a frame in which they are not turned.
//!
//! A thin wire that runs obliquely has a large box, and a plane of a thousand of them has a thousand that overlap. In a
//! frame along the wires each box is as thin as its wire. Only boxes are in that frame; the lines that are cast at what is
//! in them are transformed as ever, so crossings have the same bits.

use std::collections::HashMap;

use super::placements::{Level, Placement};
use super::world::World;
use crate::aabb::Aabb;
use crate::math::{Affine, HALF_ULP, Vec3};

/// Fewer placements are tested one by one, or nearly so.
const FEWEST: usize = 16;

/// Boxes are turned if the sum of their surfaces then is at most this part of what it was.
const GAIN: f64 = 0.6;

/// Transforms of a greater condition are not turned.
const MAX_CONDITION: f64 = 8.0;

/// Turns the boxes of a level, if that makes them much smaller. Its box stays in its own frame.
pub(super) fn turn_boxes(level: &mut Level, world: &World) {
    let Some(frame) = common_turn(&level.placements) else { return };
    let bounds: Option<Vec<Aabb>> =
        level.placements.iter().map(|placed| in_frame(&frame, placed, world)).collect();
    let Some(bounds) = bounds else { return };
    let area = |boxes: &mut dyn Iterator<Item = Aabb>| boxes.map(|b| b.half_area()).sum::<f64>();
    // A frame that enlarges would enlarge surfaces too.
    let scale = libm::cbrt(frame.determinant().abs());
    let before = area(&mut level.placements.iter().map(|placed| placed.bounds));
    if area(&mut bounds.iter().copied()) > GAIN * before * scale * scale {
        return;
    }
    for (placed, bounds) in level.placements.iter_mut().zip(bounds) {
        placed.bounds = bounds;
    }
    level.box_frame = Some(Box::new(frame));
}

/// The linear part of the transforms into most placements, if it is not along the axes.
fn common_turn(placements: &[Placement]) -> Option<Affine> {
    let is_fit = |placed: &Placement| placed.local_from_parent.condition() < MAX_CONDITION;
    if placements.len() < FEWEST || !placements.iter().all(is_fit) {
        return None;
    }
    let linear = |placed: &Placement| placed.local_from_parent.rows.map(|row| [row[0], row[1], row[2]]);
    let mut counts: HashMap<[[u64; 3]; 3], usize> = HashMap::new();
    for placed in placements {
        *counts.entry(linear(placed).map(|row| row.map(f64::to_bits))).or_default() += 1;
    }
    let (_, most) =
        counts.iter().map(|(bits, count)| (bits, *count)).max_by_key(|(bits, count)| (*count, **bits))?;
    let common =
        placements.iter().find(|placed| counts[&linear(placed).map(|row| row.map(f64::to_bits))] == most)?;
    let is_straight = linear(common).iter().all(|row| row.iter().filter(|x| **x != 0.0).count() == 1);
    let rows = linear(common).map(|[x, y, z]| [x, y, z, 0.0]);
    (2 * most >= placements.len() && !is_straight).then_some(Affine { rows })
}

/// The box of what is placed, in a frame of the level. `None` if it is not bounded.
fn in_frame(frame: &Affine, placed: &Placement, world: &World) -> Option<Aabb> {
    let bounds = world.bounds_of(placed.target);
    if bounds.is_empty() {
        return Some(bounds);
    }
    // This matrix is itself an inverse, so it can be inverted, except for rounding.
    let parent_from_local = placed.local_from_parent.inverse().ok()?;
    let turned = bounds.transformed(&frame.then_after(&parent_from_local));
    let moved = rounding(&parent_from_local, &bounds);
    let pad = Vec3::from(sizes(frame).map(|[x, y, z, _]| Vec3::new(x, y, z).dot(moved)));
    let padded = Aabb { min: turned.min - pad, max: turned.max + pad };
    padded.is_finite().then_some(padded)
}

fn sizes(map: &Affine) -> [[f64; 4]; 3] {
    map.rows.map(|row| row.map(f64::abs))
}

/// A bound on how far the corners of a box are from where they should be, under a transform that is the inverse of a rounded
/// inverse. Its entries are off by the condition number times the rounding.
fn rounding(parent_from_local: &Affine, bounds: &Aabb) -> Vec3 {
    let reach = bounds.min.abs().max(bounds.max.abs());
    let moved = sizes(parent_from_local).map(|[x, y, z, shift]| Vec3::new(x, y, z).dot(reach) + shift);
    8.0 * MAX_CONDITION * HALF_ULP * Vec3::from(moved)
}

impl World {
    /// The box of a placement, in the frame of its level.
    pub(crate) fn placed_bounds(&self, level: &Level, number: u32) -> Aabb {
        if level.box_frame.is_none() {
            return level.bounds_of(number);
        }
        let placed = &level.placements[number as usize];
        let bounds = self.bounds_of(placed.target);
        match placed.local_from_parent.inverse() {
            Ok(parent_from_local) if !bounds.is_empty() => {
                let (own, pad) =
                    (bounds.transformed(&parent_from_local), rounding(&parent_from_local, &bounds));
                Aabb { min: own.min - pad, max: own.max + pad }
            }
            _ => bounds,
        }
    }
}
