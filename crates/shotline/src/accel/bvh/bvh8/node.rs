//! A node, and the test of a ray against the boxes of its children.

use crate::aabb::{Aabb, BoxRay};
use crate::accel::collapse::WIDTH;
use crate::accel::{Beam, BeamSome};
use crate::math::Vec3;
use crate::simd::Doubles;

/// A node: the boxes of its children, plane by plane. They are not rounded, so the box of an item is tested here once and
/// for all.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct Node {
    /// For each axis the lower and then the upper plane of every child.
    planes: [[f64; WIDTH]; 6],
    /// The numbers of the children: first those that are nodes, then items.
    pub children: [u32; WIDTH],
    /// How many children there are, and how many of them are nodes.
    pub count: u8,
    pub nodes: u8,
}

/// The children that a ray meets.
pub(super) struct Met {
    /// Where it enters each child.
    pub enter: [f64; WIDTH],
    /// A mask of the children that it meets.
    pub children: u8,
}

/// The children that rays of a beam meet.
pub(super) struct MetByEach {
    /// Those that any of them meets, and where the first of them enters each child.
    pub any: Met,
    /// For each child a mask of the rays that meet it.
    pub places: [u32; WIDTH],
}

impl Met {
    const NONE: Met = Met { enter: [0.0; WIDTH], children: 0 };

    /// Sets the children from a position on. Each test has its own loop over positions: a closure passed to a shared one would
    /// not be compiled for the instructions of its caller.
    #[inline(always)]
    fn set<F: Doubles>(&mut self, first: usize, (enter, children): (F, u8)) {
        enter.store_some(&mut self.enter, first);
        self.children |= children << first;
    }
}

impl Node {
    pub const EMPTY: Node = Node { planes: [[0.0; WIDTH]; 6], children: [0; WIDTH], count: 0, nodes: 0 };

    /// Adds a child behind the others.
    pub fn push(&mut self, child: u32, bounds: &Aabb) {
        let slot = usize::from(self.count);
        self.children[slot] = child;
        self.count += 1;
        self.set_box(slot, bounds);
    }

    /// The children that are items.
    pub fn items(&self) -> &[u32] {
        &self.children[usize::from(self.nodes)..usize::from(self.count)]
    }

    pub fn set_box(&mut self, slot: usize, bounds: &Aabb) {
        for axis in 0..3 {
            self.planes[2 * axis][slot] = bounds.min[axis];
            self.planes[2 * axis + 1][slot] = bounds.max[axis];
        }
    }

    pub fn child_box(&self, slot: usize) -> Aabb {
        let corner =
            |side: usize| Vec3::from([0, 1, 2].map(|axis: usize| self.planes[2 * axis + side][slot]));
        Aabb::new(corner(0), corner(1))
    }

    /// The box around all children.
    pub fn bounds(&self) -> Aabb {
        (0..usize::from(self.count)).fold(Aabb::EMPTY, |all, slot| all.union(&self.child_box(slot)))
    }

    /// Tests the boxes of all children: [`BoxRay::enter_exit`] lane by lane, so every `t` is the same.
    #[inline(always)]
    pub fn test<F: Doubles>(&self, ray: &BoxRay) -> Met {
        let mut met = Met::NONE;
        for first in (0..WIDTH).step_by(F::LANES) {
            met.set(first, self.test_some::<F>(ray, first));
        }
        self.used(met)
    }

    /// Tests the boxes of all children against all rays of a beam: a child is met if any ray may meet it, and no ray enters
    /// it before.
    #[inline(always)]
    pub fn test_beam<F: Doubles>(&self, beam: &Beam) -> Met {
        let mut met = Met::NONE;
        for first in (0..WIDTH).step_by(F::LANES) {
            met.set(first, self.test_some_by_beam::<F>(beam, first));
        }
        self.used(met)
    }

    /// Tests the boxes of all children against each ray of some up to its limit.
    #[inline(always)]
    pub fn test_each<F: Doubles>(&self, some: &BeamSome) -> MetByEach {
        let mut places = [0; WIDTH];
        let mut met = Met::NONE;
        for first in (0..WIDTH).step_by(F::LANES) {
            let mut least = F::splat(f64::INFINITY);
            let (mut any, mut rest) = (0, some.places);
            while rest != 0 {
                let place = rest.trailing_zeros() as usize;
                let (enter, met) = self.test_some_by_place::<F>(some, place, first);
                least = enter.where_set(met & enter.is_less(least), least);
                any |= met;
                for (lane, places) in places[first..first + F::LANES].iter_mut().enumerate() {
                    *places |= u32::from(met >> lane & 1) << place;
                }
                rest &= rest - 1;
            }
            met.set(first, (least, any));
        }
        MetByEach { any: self.used(met), places }
    }

    /// As [`BoxRay::enter_exit`], for the ray at a place.
    #[inline(always)]
    fn test_some_by_place<F: Doubles>(&self, some: &BeamSome, place: usize, first: usize) -> (F, u8) {
        let (rays, chunk, lane) = (some.rays, place / 8, place % 8);
        let (mut enter, mut exit) = (F::splat(f64::NEG_INFINITY), F::splat(f64::INFINITY));
        for axis in 0..3 {
            let inverse = rays.inverse[axis][chunk][lane];
            let upper_is_near = usize::from(inverse < 0.0);
            let near = F::load_some(&self.planes[2 * axis + upper_is_near], first);
            let far = F::load_some(&self.planes[2 * axis + 1 - upper_is_near], first);
            let inverse = F::splat(inverse);
            // A NaN leaves the bound: such an axis does not cull.
            enter = ((near - F::splat(rays.ahead[axis][chunk][lane])) * inverse).greater(enter);
            exit = ((far - F::splat(rays.behind[axis][chunk][lane])) * inverse).lesser(exit);
        }
        let (shrink, grow) = (F::splat(rays.shrink[chunk][lane]), F::splat(rays.grow[chunk][lane]));
        let end = F::splat(rays.t_max.min(some.limits[chunk][lane]));
        let enter = (enter * shrink).lesser(enter * grow).greater(F::splat(rays.t_min));
        let exit = (exit * shrink).greater(exit * grow).lesser(end);
        (enter, enter.is_at_most(exit) & F::ALL)
    }

    /// Leaves out unused slots, whose planes mean nothing.
    #[inline(always)]
    fn used(&self, mut met: Met) -> Met {
        met.children &= ((1u32 << self.count) - 1) as u8;
        met
    }

    #[inline(always)]
    fn test_some<F: Doubles>(&self, ray: &BoxRay, first: usize) -> (F, u8) {
        let (mut enter, mut exit) = (F::splat(f64::NEG_INFINITY), F::splat(f64::INFINITY));
        for axis in 0..3 {
            let upper_is_near = usize::from(ray.inverse[axis] < 0.0);
            let near = F::load_some(&self.planes[2 * axis + upper_is_near], first);
            let far = F::load_some(&self.planes[2 * axis + 1 - upper_is_near], first);
            let inverse = F::splat(ray.inverse[axis]);
            // A NaN leaves the bound: such an axis does not cull.
            enter = ((near - F::splat(ray.ahead[axis])) * inverse).greater(enter);
            exit = ((far - F::splat(ray.behind[axis])) * inverse).lesser(exit);
        }
        let (shrink, grow) = (F::splat(ray.shrink), F::splat(ray.grow));
        let enter = (enter * shrink).lesser(enter * grow).greater(F::splat(ray.span.t_min()));
        let exit = (exit * shrink).greater(exit * grow).lesser(F::splat(ray.span.t_max()));
        (enter, enter.is_at_most(exit) & F::ALL)
    }

    /// Every rounded operation is monotone, so the bounds of the beam give bounds on what each ray gives.
    #[inline(always)]
    fn test_some_by_beam<F: Doubles>(&self, beam: &Beam, first: usize) -> (F, u8) {
        let (mut enter, mut exit) = (F::splat(f64::NEG_INFINITY), F::splat(f64::INFINITY));
        for axis in 0..3 {
            let [least, greatest] = beam.inverse[axis];
            let upper_is_near = usize::from(least < 0.0);
            let near = F::load_some(&self.planes[2 * axis + upper_is_near], first);
            let far = F::load_some(&self.planes[2 * axis + 1 - upper_is_near], first);
            let (least, greatest) = (F::splat(least), F::splat(greatest));
            let near = near - F::splat(beam.ahead[axis]);
            let far = far - F::splat(beam.behind[axis]);
            // A NaN leaves the bound: such an axis does not cull.
            enter = (near * least).lesser(near * greatest).greater(enter);
            exit = (far * least).greater(far * greatest).lesser(exit);
        }
        let (shrink, grow) = (F::splat(beam.shrink), F::splat(beam.grow));
        let enter = (enter * shrink).lesser(enter * grow).greater(F::splat(beam.t_min));
        let exit = (exit * shrink).greater(exit * grow).lesser(F::splat(beam.t_max));
        (enter, enter.is_at_most(exit) & F::ALL)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::BeamRays;
    use crate::ray::{Line, Span};
    use crate::simd::{Portable, Simd, Task, dispatch};
    use crate::testkit::random::Random;

    struct Test<'a>(&'a Node, &'a BoxRay);

    impl Task for Test<'_> {
        type Output = Met;

        #[inline(always)]
        fn run<S: Simd>(self) -> Met {
            self.0.test::<S::Wide>(self.1)
        }
    }

    /// Coordinates that boxes share with origins, so that rays run in planes and begin on them.
    fn coordinate(random: &mut Random) -> f64 {
        match random.below(6) {
            0 => [0.0, -0.0, 1e-300, 1e150, -1e150, 0.5][random.below(6)],
            1 | 2 => random.number(-1.0, 1.0),
            _ => f64::from(random.below(5) as i32 - 2),
        }
    }

    fn point(random: &mut Random) -> Vec3 {
        Vec3::new(coordinate(random), coordinate(random), coordinate(random))
    }

    fn line(random: &mut Random) -> Line {
        let mut line = Line::exact(point(random), point(random));
        if random.below(3) == 0 {
            line.o_err = point(random).abs() * [1e-15, 0.1][random.below(2)];
            line.d_err = line.d.abs() * [0.0, 1e-15, 0.1, 1.0][random.below(4)];
        }
        line
    }

    /// Both sets of instructions give the `t` of a test of a single box, and meet the same boxes.
    #[test]
    fn eight_boxes_are_tested_as_one_by_one() {
        let mut random = Random::new(11);
        let mut met = 0;
        for _ in 0..20_000 {
            let mut node = Node::EMPTY;
            let boxes: Vec<Aabb> = (0..random.below(WIDTH + 1))
                .map(|_| Aabb::around([point(&mut random), point(&mut random)]))
                .collect();
            boxes.iter().for_each(|b| node.push(0, b));
            let span = [Span::FORWARD, Span::new(-1.0, 0.5).expect("a span")][random.below(2)];
            let ray = BoxRay::new(&line(&mut random), span);
            let (fast, plain) = (dispatch(Test(&node, &ray)), node.test::<<Portable as Simd>::Wide>(&ray));
            assert_eq!(fast.children, plain.children, "{ray:?} {boxes:?}");
            assert_eq!(fast.enter.map(f64::to_bits), plain.enter.map(f64::to_bits), "{ray:?} {boxes:?}");
            for (slot, b) in boxes.iter().enumerate() {
                let expected = ray.enter_exit(b).map(|(enter, _)| enter);
                let enter = (plain.children >> slot & 1 == 1).then_some(plain.enter[slot]);
                assert_eq!(enter, expected, "{ray:?} {b:?}");
                met += usize::from(expected.is_some());
            }
            assert_eq!(u32::from(plain.children) >> boxes.len(), 0);
        }
        assert!(met > 5000, "{met} boxes were met");
    }

    struct TestBeam<'a>(&'a Node, &'a Beam);

    impl Task for TestBeam<'_> {
        type Output = Met;

        #[inline(always)]
        fn run<S: Simd>(self) -> Met {
            self.0.test_beam::<S::Wide>(self.1)
        }
    }

    /// A beam meets whatever one of its rays meets, and not behind it.
    #[test]
    fn a_beam_bounds_its_rays() {
        let mut random = Random::new(12);
        let (mut met, mut missed) = (0, 0);
        for _ in 0..20_000 {
            let mut node = Node::EMPTY;
            let a_box = |random: &mut Random| Aabb::around([point(random), point(random)]);
            (0..WIDTH).for_each(|_| node.push(0, &a_box(&mut random)));
            let span = [Span::FORWARD, Span::new(-1.0, 0.5).expect("a span")][random.below(2)];
            let (first, spread) = (line(&mut random), [0.0, 1e-6, 0.1, 1.0][random.below(4)]);
            let ray = |_| {
                let mut line = if random.below(20) == 0 { line(&mut random) } else { first };
                line.o += random.point(-1.0, 1.0) * spread;
                line.d += random.point(-1.0, 1.0) * spread * [0.0, 0.1][random.below(2)];
                BoxRay::new(&line, span)
            };
            let rays: Vec<BoxRay> = (0..5).map(ray).collect();
            let mut beam = BeamRays::default();
            beam.fill(&rays[0]);
            rays.iter().enumerate().for_each(|(place, ray)| beam.set(place, ray));
            let beam = beam.beam();
            let by_beam = dispatch(TestBeam(&node, &beam));
            for ray in &rays {
                let by_ray = dispatch(Test(&node, ray));
                assert_eq!(by_ray.children & !by_beam.children, 0, "{ray:?} {beam:?} {node:?}");
                for slot in (0..WIDTH).filter(|slot| by_ray.children >> slot & 1 == 1) {
                    assert!(by_beam.enter[slot] <= by_ray.enter[slot], "{ray:?} {beam:?} {node:?}");
                    met += 1;
                }
            }
            missed += by_beam.children.count_zeros();
        }
        assert!(met > 5000 && missed > 5000, "{met} {missed}");
    }
}
