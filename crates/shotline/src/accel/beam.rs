//! Beams: some rays of one frame that run close together. A structure tests all of them at once against each of its boxes,
//! and only the boxes of items are tested ray by ray, many rays at a time.

use super::Child;
use crate::aabb::{Aabb, BoxRay};
use crate::lanes::BoxLanes;
use crate::simd::{Doubles, Simd, Task, dispatch};

/// The most rays of a beam.
pub const BEAM_RAYS: usize = 32;

/// A number of each ray.
pub type ByRay = [[f64; 8]; BEAM_RAYS / 8];

/// The rays of a beam, number by number. Unused places hold a copy of another ray.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct BeamRays {
    pub(super) ahead: [ByRay; 3],
    pub(super) behind: [ByRay; 3],
    pub(super) inverse: [ByRay; 3],
    pub(super) shrink: ByRay,
    pub(super) grow: ByRay,
    pub(super) t_min: f64,
    pub(super) t_max: f64,
}

/// The rays that meet a box.
#[derive(Clone, Debug)]
pub struct MetRays {
    /// Where each of them enters it.
    pub enter: ByRay,
    /// A mask of them.
    pub rays: u32,
}

/// Some rays of a beam.
#[derive(Clone, Copy, Debug)]
pub struct BeamSome<'a> {
    /// All rays of the beam, and bounds on them.
    pub rays: &'a BeamRays,
    /// Bounds on all of them.
    pub beam: &'a Beam,
    /// A mask of the rays that count.
    pub places: u32,
    /// How far each of them looks.
    pub limits: &'a ByRay,
}

/// A child that rays of a beam may meet.
#[derive(Clone, Copy, Debug)]
pub struct BeamEntry {
    /// No ray enters it before.
    pub t: f64,
    /// The child.
    pub child: Child,
    /// A mask of the rays.
    pub places: u32,
}

/// Bounds on the numbers of all rays of a beam.
#[derive(Clone, Debug, Default)]
pub struct Beam {
    /// For each axis the end of the origins from which near planes come first, and that from which far planes come last.
    pub(super) ahead: [f64; 3],
    pub(super) behind: [f64; 3],
    /// The least and the greatest reciprocal; NaN where an axis does not cull.
    pub(super) inverse: [[f64; 2]; 3],
    pub(super) shrink: f64,
    pub(super) grow: f64,
    pub(super) t_min: f64,
    pub(super) t_max: f64,
    /// Whether the rays run apart. Each of them is then tested alone, since the bounds would cull nothing.
    pub is_loose: bool,
}

impl Beam {
    /// The beam of rays that run apart, without bounds.
    pub fn loose(t_min: f64, t_max: f64) -> Beam {
        Beam { is_loose: true, t_min, t_max, ..Beam::default() }
    }
}

impl Default for BeamRays {
    /// Rays that mean nothing.
    fn default() -> BeamRays {
        let zeros = [[0.0; 8]; BEAM_RAYS / 8];
        let [ahead, behind, inverse] = [[zeros; 3]; 3];
        BeamRays { ahead, behind, inverse, shrink: zeros, grow: zeros, t_min: 0.0, t_max: 0.0 }
    }
}

impl BeamRays {
    /// Sets all places to the same ray.
    pub fn fill(&mut self, ray: &BoxRay) {
        (self.t_min, self.t_max) = (ray.span.t_min(), ray.span.t_max());
        (0..BEAM_RAYS).for_each(|place| self.set(place, ray));
    }

    /// Sets rays without errors, given by their origins and directions. All get the span of `of`, a ray without errors.
    /// Returns `false` if this has to be done ray by ray.
    pub fn set_exact(&mut self, origins: &[ByRay; 3], directions: &[ByRay; 3], of: &BoxRay) -> bool {
        (self.t_min, self.t_max) = (of.span.t_min(), of.span.t_max());
        let all = |number: f64| [[number; 8]; BEAM_RAYS / 8];
        (self.shrink, self.grow) = (all(of.shrink), all(of.grow));
        (self.ahead, self.inverse) = (*origins, *directions);
        dispatch(Invert(self))
    }

    /// Sets the span of all rays.
    pub(crate) fn set_span(&mut self, t_min: f64, t_max: f64) {
        (self.t_min, self.t_max) = (t_min, t_max);
    }

    /// Sets the rays at the places from `first` on, which is a multiple of the number of lanes.
    #[inline(always)]
    pub(crate) fn set_lanes<F: Doubles>(&mut self, first: usize, rays: &BoxLanes<F>) {
        let (chunk, lane) = (first / 8, first % 8);
        for axis in 0..3 {
            rays.ahead[axis].store_some(&mut self.ahead[axis][chunk], lane);
            rays.behind[axis].store_some(&mut self.behind[axis][chunk], lane);
            rays.inverse[axis].store_some(&mut self.inverse[axis][chunk], lane);
        }
        rays.shrink.store_some(&mut self.shrink[chunk], lane);
        rays.grow.store_some(&mut self.grow[chunk], lane);
    }

    /// Sets one ray, which must have the span of the others.
    #[inline]
    pub fn set(&mut self, place: usize, ray: &BoxRay) {
        let (chunk, lane) = (place / 8, place % 8);
        for axis in 0..3 {
            self.ahead[axis][chunk][lane] = ray.ahead[axis];
            self.behind[axis][chunk][lane] = ray.behind[axis];
            self.inverse[axis][chunk][lane] = ray.inverse[axis];
        }
        self.shrink[chunk][lane] = ray.shrink;
        self.grow[chunk][lane] = ray.grow;
    }

    /// The rays that meet a box at or before their limits, with the numbers of [`BoxRay::enter_exit`].
    #[inline]
    pub fn enter(&self, bounds: &Aabb, limits: &ByRay) -> MetRays {
        dispatch(Enter { rays: self, bounds, limits })
    }

    /// As [`BeamRays::enter`], by the instructions of the caller.
    #[inline(always)]
    pub(crate) fn enter_by<S: Simd>(&self, bounds: &Aabb, limits: &ByRay) -> MetRays {
        Enter { rays: self, bounds, limits }.run::<S>()
    }

    /// Bounds on the numbers of all rays.
    pub fn beam(&self) -> Beam {
        dispatch(Bound(self))
    }
}

/// Makes rays of the origins in `ahead` and the directions in `inverse`, as [`BoxRay::new`] does of lines without errors.
/// Returns `false` if an axis does not cull.
struct Invert<'a>(&'a mut BeamRays);

impl Task for Invert<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(self) -> bool {
        let BeamRays { ahead, behind, inverse, .. } = self.0;
        let mut cull = true;
        for axis in 0..3 {
            for chunk in 0..BEAM_RAYS / 8 {
                for first in (0..8).step_by(S::Wide::LANES) {
                    cull &= invert::<S::Wide>(
                        first,
                        &mut ahead[axis][chunk],
                        &mut behind[axis][chunk],
                        &mut inverse[axis][chunk],
                    );
                }
            }
        }
        cull
    }
}

#[inline(always)]
fn invert<F: Doubles>(
    first: usize,
    ahead: &mut [f64; 8],
    behind: &mut [f64; 8],
    inverse: &mut [f64; 8],
) -> bool {
    let (o, d) = (F::load_some(ahead, first), F::load_some(inverse, first));
    let reciprocal = F::splat(1.0) / d;
    let forward = F::splat(-0.0).where_negative(reciprocal, F::splat(0.0));
    let numbers = [o + forward, o - forward, reciprocal].map(F::store);
    for lane in 0..F::LANES {
        ahead[first + lane] = numbers[0][lane];
        behind[first + lane] = numbers[1][lane];
        inverse[first + lane] = numbers[2][lane];
    }
    let is_parallel = d.abs().is_at_most(F::splat(0.0));
    let is_finite = reciprocal.abs().is_at_most(F::splat(f64::MAX));
    (is_parallel | is_finite) & F::ALL == F::ALL
}

struct Enter<'a> {
    rays: &'a BeamRays,
    bounds: &'a Aabb,
    limits: &'a ByRay,
}

impl Task for Enter<'_> {
    type Output = MetRays;

    #[inline(always)]
    fn run<S: Simd>(self) -> MetRays {
        let mut met = MetRays { enter: [[0.0; 8]; BEAM_RAYS / 8], rays: 0 };
        for chunk in 0..BEAM_RAYS / 8 {
            for first in (0..8).step_by(S::Wide::LANES) {
                let (enter, rays) = self.some::<S::Wide>(chunk, first);
                enter.store_some(&mut met.enter[chunk], first);
                met.rays |= u32::from(rays) << (8 * chunk + first);
            }
        }
        met
    }
}

impl Enter<'_> {
    #[inline(always)]
    fn some<F: Doubles>(&self, chunk: usize, first: usize) -> (F, u8) {
        let Enter { rays, bounds, limits } = self;
        let load = |numbers: &ByRay| F::load_some(&numbers[chunk], first);
        let vector = |of: &[ByRay; 3]| [load(&of[0]), load(&of[1]), load(&of[2])];
        let boxes = BoxLanes {
            ahead: vector(&rays.ahead),
            behind: vector(&rays.behind),
            inverse: vector(&rays.inverse),
            shrink: load(&rays.shrink),
            grow: load(&rays.grow),
            t_min: rays.t_min,
            t_max: rays.t_max,
        };
        let (enter, exit) = boxes.enter_exit(bounds);
        (enter, enter.is_at_most(exit.lesser(load(limits))) & F::ALL)
    }
}

struct Bound<'a>(&'a BeamRays);

impl Task for Bound<'_> {
    type Output = Beam;

    #[inline(always)]
    fn run<S: Simd>(self) -> Beam {
        let Bound(rays) = self;
        let mut beam = Beam {
            ahead: [0.0; 3],
            behind: [0.0; 3],
            inverse: [[f64::NAN; 2]; 3],
            shrink: ends::<S::Wide>(&rays.shrink)[0],
            grow: ends::<S::Wide>(&rays.grow)[1],
            t_min: rays.t_min,
            t_max: rays.t_max,
            is_loose: false,
        };
        for axis in 0..3 {
            let all = [&rays.inverse[axis], &rays.ahead[axis], &rays.behind[axis]];
            let [inverse, ahead, behind] = all.map(ends::<S::Wide>);
            let [least, greatest] = inverse;
            let have_one_sign = least > 0.0 || greatest < 0.0;
            // Beside a ray that is parallel to the planes, others are not.
            let are_alike = least == greatest || (least.is_finite() && greatest.is_finite());
            if have_one_sign && are_alike && all.map(is_ordered::<S::Wide>) == [true; 3] {
                let forward = usize::from(least > 0.0);
                beam.ahead[axis] = ahead[forward];
                beam.behind[axis] = behind[1 - forward];
                beam.inverse[axis] = inverse;
            }
        }
        beam
    }
}

/// The least and the greatest number. Where any is NaN they mean nothing.
#[inline(always)]
fn ends<F: Doubles>(numbers: &ByRay) -> [f64; 2] {
    let (mut least, mut greatest) = (F::splat(f64::INFINITY), F::splat(f64::NEG_INFINITY));
    for numbers in numbers {
        for first in (0..8).step_by(F::LANES) {
            let some = F::load_some(numbers, first);
            (least, greatest) = (some.lesser(least), some.greater(greatest));
        }
    }
    let (least, greatest) = (least.store(), greatest.store());
    let mut ends = [least[0], greatest[0]];
    for lane in 1..F::LANES {
        ends = [ends[0].min(least[lane]), ends[1].max(greatest[lane])];
    }
    ends
}

/// Whether no number is NaN.
#[inline(always)]
fn is_ordered<F: Doubles>(numbers: &ByRay) -> bool {
    let is_ordered = |numbers: &[f64; 8], first: usize| {
        let some = F::load_some(numbers, first);
        some.is_at_most(some) & F::ALL == F::ALL
    };
    numbers.iter().all(|numbers| (0..8).step_by(F::LANES).all(|first| is_ordered(numbers, first)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::ray::{Line, Span};
    use crate::testkit::random::Random;

    fn rays(random: &mut Random, is_exact: bool) -> Vec<(Vec3, Vec3, BoxRay)> {
        let span = [Span::FORWARD, Span::new(-1.0, 2.5).expect("a span")][random.below(2)];
        let (o, d) = (random.point(-3.0, 3.0), random.direction());
        let spread = [0.0, 1e-3, 0.1, 2.0][random.below(4)];
        let (axis, count) = (random.below(6), 1 + random.below(BEAM_RAYS));
        let ray = |_| {
            let mut line = Line::exact(
                o + random.point(-1.0, 1.0) * spread,
                d + random.point(-1.0, 1.0) * [0.0, spread][random.below(2)],
            );
            if axis < 3 {
                line.d[axis] = [0.0, -0.0, 1e-310, 1e-9][random.below(4)];
                line.o[axis] = [0.0, -0.0, 1.0][random.below(3)];
            }
            if !is_exact {
                line.o_err = random.point(0.0, 1.0) * [0.0, 1e-15, 0.1][random.below(3)];
                line.d_err = random.point(0.0, 1.0) * [0.0, 1e-15, 0.1][random.below(3)];
            }
            (line.o, line.d, BoxRay::new(&line, span))
        };
        (0..count).map(ray).collect()
    }

    fn beam_of(rays: &[(Vec3, Vec3, BoxRay)]) -> BeamRays {
        let mut beam = BeamRays::default();
        beam.fill(&rays[0].2);
        rays.iter().enumerate().for_each(|(place, (_, _, ray))| beam.set(place, ray));
        beam
    }

    fn a_box(random: &mut Random) -> Aabb {
        let corner = |random: &mut Random| {
            let mut corner = random.point(-2.0, 2.0);
            corner[random.below(3)] = [0.0, 1.0, f64::INFINITY][random.below(3)];
            corner
        };
        let b = Aabb::around([corner(random), corner(random)]);
        if random.below(8) == 0 { Aabb::EVERYTHING } else { b }
    }

    /// Every ray has the numbers of a test of it alone, and the rays of the same lines are the same however they are set.
    #[test]
    fn rays_of_a_beam_are_tested_as_one_by_one() {
        let mut random = Random::new(21);
        let mut met = 0;
        for case in 0..4000 {
            let is_exact = case % 2 == 0;
            let rays = rays(&mut random, is_exact);
            let mut beams = vec![beam_of(&rays)];
            let (mut origins, mut directions): ([ByRay; 3], [ByRay; 3]) = Default::default();
            for place in 0..BEAM_RAYS {
                let (o, d, _) = rays[place % rays.len()];
                for axis in 0..3 {
                    origins[axis][place / 8][place % 8] = o[axis];
                    directions[axis][place / 8][place % 8] = d[axis];
                }
            }
            let mut exact = BeamRays::default();
            if is_exact && exact.set_exact(&origins, &directions, &rays[0].2) {
                beams.push(exact);
            }
            let b = a_box(&mut random);
            let limit = |_: usize| [f64::INFINITY, 2.0, f64::NEG_INFINITY][random.below(3)];
            let limits: Vec<f64> = (0..BEAM_RAYS).map(limit).collect();
            let mut by_ray: ByRay = Default::default();
            limits.iter().enumerate().for_each(|(place, limit)| by_ray[place / 8][place % 8] = *limit);
            for beam in beams {
                let found = beam.enter(&b, &by_ray);
                for (place, (_, _, ray)) in rays.iter().enumerate() {
                    let expected = ray.enter_exit(&b).map(|(enter, _)| enter);
                    let expected = expected.filter(|enter| *enter <= limits[place]);
                    let enter = found.enter[place / 8][place % 8];
                    let enter = (found.rays >> place & 1 == 1).then_some(enter);
                    assert_eq!(enter, expected, "{ray:?} {b:?}");
                    met += usize::from(expected.is_some());
                }
            }
        }
        assert!(met > 2000, "{met} boxes were met");
    }
}
