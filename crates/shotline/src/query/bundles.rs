//! How the rays of a block are bundled.

use std::ops::Range;

use crate::accel::BEAM_RAYS;
use crate::compile::World;
use crate::math::Vec3;

/// Fewer rays are cheaper one by one.
const FEWEST: usize = 4;

/// The square of the cosine of the largest angle between the first ray of a bundle and another: about two degrees.
const SQUARED_COSINE: f64 = 0.9988;

/// How far origins may be apart in a bundle, as a share of the size of the scene.
const SPREAD: f64 = 1.0 / 128.0;

/// Decides which rays are bundled.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bundling {
    /// The largest distance between origins along an axis; negative if there are no bundles of several rays.
    spread: f64,
}

impl Bundling {
    /// The bundles for a world: only of one ray each if the accelerator of the root takes no beams.
    pub fn of(world: &World) -> Bundling {
        let takes_beams = world.root().accel.as_ref().is_some_and(|accel| accel.takes_beams());
        let size = world.finite_bounds().size();
        if takes_beams { Bundling::of_size(size) } else { Bundling { spread: -1.0 } }
    }

    /// The bundles for a scene in a box of a size.
    fn of_size(size: Vec3) -> Bundling {
        Bundling { spread: (SPREAD * size.max_element()).min(f64::MAX) }
    }

    /// The rows of the next bundle, which begins at a row: of adjacent rays that run close together, or of one ray.
    pub fn next(&self, rays: &[[f64; 6]], start: usize) -> Range<usize> {
        let first = Start::of(&rays[start]);
        let is_near = |ray: &&[f64; 6]| self.are_near(&first, &Start::of(ray));
        let some = &rays[start + 1..rays.len().min(start + BEAM_RAYS)];
        let count = 1 + some.iter().take_while(is_near).count();
        start..start + if count < FEWEST { 1 } else { count }
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
        let bundling = Bundling::of_size(Vec3::ONE);
        assert_eq!(bundling.next(&rays, 0), 0..BEAM_RAYS);
        assert_eq!(bundling.next(&rays, 30), 30..40);
        assert_eq!(bundling.next(&rays, 38), 38..39);
        assert_eq!(Bundling { spread: -1.0 }.next(&rays, 0), 0..1);
        let mut turned = rays.clone();
        turned[10][3] = -1.0;
        assert_eq!(bundling.next(&turned, 0), 0..10);
        assert_eq!(bundling.next(&turned, 8), 8..9);
        let mut moved = rays;
        moved[5][2] = 0.5;
        assert_eq!(bundling.next(&moved, 0), 0..5);
        assert_eq!(bundling.next(&moved, 5), 5..6);
        assert_eq!(bundling.next(&[[1e200; 6]; 8], 0), 0..1);
    }
}
