//! How the rays of a block are bundled.

use std::ops::Range;

use crate::accel::BEAM_RAYS;
use crate::compile::{Placement, Target, World};
use crate::math::Vec3;

/// Fewer rays are cheaper one by one.
const FEWEST: usize = 4;

/// The square of the cosine of the largest angle between the first ray of a bundle and another: about two degrees.
const SQUARED_COSINE: f64 = 0.9988;

/// How far origins may be apart in a bundle, as a share of the size of the scene.
const SPREAD: f64 = 1.0 / 128.0;

/// With more bodies than this at the root, rays that do not run close together are not bundled.
const FEW_PLACEMENTS: usize = 8;

/// Decides which rays are bundled.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bundling {
    /// The largest distance between origins along an axis; negative if there are no bundles of several rays.
    spread: f64,
    others: Others,
}

/// What is done with rays that do not run close together.
#[derive(Clone, Copy, Debug)]
enum Others {
    /// Each is a bundle of its own.
    Single,
    /// They are bundled nevertheless: there are so few bodies that all rays may be tested against each of them.
    Loose,
    /// They are cast in waves.
    Wave,
    /// They are cast one by one.
    Plain,
}

/// The rows of a bundle.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Rows {
    /// Rays that run close together.
    Close(Range<usize>),
    /// Rays that run anywhere.
    Loose(Range<usize>),
    Single(usize),
    /// Rays that are cast in waves instead.
    Wave(Range<usize>),
    /// Rays that are cast one by one instead.
    Plain(Range<usize>),
}

impl Bundling {
    /// The bundles for a world: only of one ray each if the accelerator of the root takes no beams.
    pub fn of(world: &World) -> Bundling {
        let root = world.root();
        let takes_beams = root.accel.as_ref().is_some_and(|accel| accel.takes_beams());
        let takes_lanes = |placed: &Placement| match placed.target {
            Target::Body(body) => world.body(body).takes_lanes(),
            Target::Level(_) => false,
        };
        let size = world.finite_bounds().size().max_element();
        let others = if world.casts_blocks() {
            Others::Single
        } else if root.placements.len() <= FEW_PLACEMENTS && root.placements.iter().all(takes_lanes) {
            Others::Loose
        } else if world.casts_waves() {
            Others::Wave
        } else {
            Others::Plain
        };
        Bundling { spread: if takes_beams { (SPREAD * size).min(f64::MAX) } else { -1.0 }, others }
    }

    /// The next bundle, which begins at a row.
    pub fn next(&self, rays: &[[f64; 6]], start: usize) -> Rows {
        if self.spread < 0.0 {
            return Rows::Single(start);
        }
        let first = Start::of(&rays[start]);
        let is_near = |ray: &&[f64; 6]| self.are_near(&first, &Start::of(ray));
        let some = &rays[start + 1..rays.len().min(start + BEAM_RAYS)];
        let count = 1 + some.iter().take_while(is_near).count();
        match self.others {
            _ if count >= FEWEST => Rows::Close(start..start + count),
            Others::Single => Rows::Single(start),
            Others::Loose => Rows::Loose(start..start + 1 + some.len()),
            Others::Wave => Rows::Wave(start..start + count),
            Others::Plain => Rows::Plain(start..start + count),
        }
    }

    fn are_near(&self, first: &Start, other: &Start) -> bool {
        let cosine = first.d.dot(other.d);
        let lengths = first.d.length_squared() * other.d.length_squared();
        // NaN compares as false, and infinite products do.
        (other.o - first.o).abs().cmple(Vec3::splat(self.spread)).all()
            && cosine > 0.0
            && cosine * cosine >= SQUARED_COSINE * lengths
            && lengths < f64::INFINITY
    }
}

/// Where a ray starts, and its direction.
struct Start {
    o: Vec3,
    d: Vec3,
}

impl Start {
    fn of(ray: &[f64; 6]) -> Start {
        Start { o: Vec3::new(ray[0], ray[1], ray[2]), d: Vec3::new(ray[3], ray[4], ray[5]) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_that_run_close_together_are_bundled() {
        let rays: Vec<[f64; 6]> = (0..40).map(|i| [0.0, 0.0, 0.0, 1.0, 1e-3 * f64::from(i), 0.0]).collect();
        let bundling = Bundling { spread: SPREAD, others: Others::Single };
        assert_eq!(bundling.next(&rays, 0), Rows::Close(0..BEAM_RAYS));
        assert_eq!(bundling.next(&rays, 30), Rows::Close(30..40));
        assert_eq!(bundling.next(&rays, 38), Rows::Single(38));
        assert_eq!(Bundling { spread: -1.0, ..bundling }.next(&rays, 0), Rows::Single(0));
        let mut turned = rays.clone();
        turned[10][3] = -1.0;
        assert_eq!(bundling.next(&turned, 0), Rows::Close(0..10));
        assert_eq!(bundling.next(&turned, 8), Rows::Single(8));
        assert_eq!(Bundling { others: Others::Loose, ..bundling }.next(&turned, 8), Rows::Loose(8..40));
        assert_eq!(Bundling { others: Others::Plain, ..bundling }.next(&turned, 8), Rows::Plain(8..10));
        let mut moved = rays;
        moved[5][2] = 0.5;
        assert_eq!(bundling.next(&moved, 0), Rows::Close(0..5));
        assert_eq!(bundling.next(&moved, 5), Rows::Single(5));
        assert_eq!(bundling.next(&[[1e200; 6]; 8], 0), Rows::Single(0));
    }
}
