//! Lines in lanes, prepared for slab tests against boxes: [`BoxRay`](crate::aabb::BoxRay) lane by lane, with the same bits.

use super::LineLanes;
use super::vector::{Vectors, gather_vectors, splat};
use crate::aabb::Aabb;
use crate::math::HALF_ULP;
use crate::ray::Span;
use crate::simd::Doubles;

/// The lines, number by number.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BoxLanes<F> {
    pub ahead: [F; 3],
    pub behind: [F; 3],
    pub inverse: [F; 3],
    pub shrink: F,
    pub grow: F,
    pub t_min: f64,
    pub t_max: f64,
}

impl<F: Doubles> BoxLanes<F> {
    /// Prepares lines.
    #[inline(always)]
    pub fn new(line: &LineLanes<F>, span: Span) -> BoxLanes<F> {
        let (zero, most) = (F::splat(0.0), F::splat(f64::MAX));
        let [x, y, z] = line.d_err;
        let is_exact = x.is_at_most(zero) & y.is_at_most(zero) & z.is_at_most(zero);
        let (mut ahead, mut behind, mut inverses) = (line.o, line.o, line.d);
        let mut worst = zero;
        for axis in 0..3 {
            let (o, d, o_err, d_err) = (line.o[axis], line.d[axis], line.o_err[axis], line.d_err[axis]);
            let inverse = F::splat(1.0) / d;
            let forward = o_err.where_set(zero.is_at_most(inverse), -o_err);
            let doubt = zero.where_set(is_exact, d_err / d.abs());
            let parallel = d.abs().is_at_most(zero) & d_err.is_at_most(zero);
            let bounded = doubt.is_less(F::splat(0.25)) & inverse.abs().is_at_most(most);
            worst = (F::splat(2.0) * doubt).where_set(bounded, zero).greater(worst);
            ahead[axis] = o + forward;
            behind[axis] = o - forward;
            inverses[axis] = inverse.where_set(parallel | bounded, F::splat(f64::NAN));
        }
        let relative = worst + F::splat(6.0 * HALF_ULP);
        let one = F::splat(1.0);
        BoxLanes {
            ahead,
            behind,
            inverse: inverses,
            shrink: one - relative,
            grow: one + relative,
            t_min: span.t_min(),
            t_max: span.t_max(),
        }
    }

    /// Where the lines enter and leave a box, within the span. They miss it where they do not enter before they leave.
    #[inline(always)]
    pub fn enter_exit(&self, bounds: &Aabb) -> (F, F) {
        self.enter_exit_between(&splat(bounds.min), &splat(bounds.max))
    }

    /// As [`BoxLanes::enter_exit`], of a box of each lane.
    #[inline(always)]
    pub fn enter_exit_each(&self, bounds: &[&Aabb; 8]) -> (F, F) {
        let corners = [gather_vectors(|lane| bounds[lane].min), gather_vectors(|lane| bounds[lane].max)];
        self.enter_exit_between(&corners[0], &corners[1])
    }

    #[inline(always)]
    fn enter_exit_between(&self, min: &Vectors<F>, max: &Vectors<F>) -> (F, F) {
        let (mut enter, mut exit) = (F::splat(f64::NEG_INFINITY), F::splat(f64::INFINITY));
        for axis in 0..3 {
            let inverse = self.inverse[axis];
            let (lower, upper) = (min[axis], max[axis]);
            let near = upper.where_negative(inverse, lower);
            let far = lower.where_negative(inverse, upper);
            // A NaN leaves the bound: such an axis does not cull.
            enter = ((near - self.ahead[axis]) * inverse).greater(enter);
            exit = ((far - self.behind[axis]) * inverse).lesser(exit);
        }
        let (shrink, grow) = (self.shrink, self.grow);
        let enter = (enter * shrink).lesser(enter * grow).greater(F::splat(self.t_min));
        let exit = (exit * shrink).greater(exit * grow).lesser(F::splat(self.t_max));
        (enter, exit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::aabb::BoxRay;
    use crate::math::Vec3;
    use crate::ray::Line;
    use crate::simd::{Simd, Task, dispatch};
    use crate::testkit::random::Random;

    struct Test<'a>(&'a [Line; 8], Span, &'a Aabb);

    impl Task for Test<'_> {
        type Output = Vec<Option<f64>>;

        #[inline(always)]
        fn run<S: Simd>(self) -> Vec<Option<f64>> {
            let mut out = Vec::new();
            for first in (0..8).step_by(S::Wide::LANES) {
                let lines = LineLanes::<S::Wide>::from_fn(|lane| self.0[first + lane]);
                let (enter, exit) = BoxLanes::new(&lines, self.1).enter_exit(self.2);
                let met = enter.is_at_most(exit);
                let enter = enter.store();
                out.extend((0..S::Wide::LANES).map(|lane| (met >> lane & 1 == 1).then_some(enter[lane])));
            }
            out
        }
    }

    fn coordinate(random: &mut Random) -> f64 {
        match random.below(6) {
            0 => [0.0, -0.0, 1e-300, 1e150, -1e150, 0.5][random.below(6)],
            1 | 2 => random.number(-1.0, 1.0),
            _ => f64::from(random.below(5) as i32 - 2),
        }
    }

    #[test]
    fn lines_in_lanes_meet_boxes_as_one_by_one() {
        let mut random = Random::new(17);
        let point =
            |random: &mut Random| Vec3::new(coordinate(random), coordinate(random), coordinate(random));
        let mut met = 0;
        for _ in 0..5000 {
            let lines = [0; 8].map(|_| {
                let mut line = Line::exact(point(&mut random), point(&mut random));
                if random.below(2) == 0 {
                    line.o_err = point(&mut random).abs() * [1e-15, 0.1][random.below(2)];
                    line.d_err = line.d.abs() * [0.0, 1e-15, 0.1, 1.0][random.below(4)];
                }
                line
            });
            let span = [Span::FORWARD, Span::new(-1.0, 0.5).expect("a span")][random.below(2)];
            let b = Aabb::around([point(&mut random), point(&mut random)]);
            let found = dispatch(Test(&lines, span, &b));
            for (line, found) in lines.iter().zip(found) {
                let expected = BoxRay::new(line, span).enter_exit(&b).map(|(enter, _)| enter);
                assert_eq!(found, expected, "{line:?} {b:?}");
                met += usize::from(expected.is_some());
            }
        }
        assert!(met > 4000, "{met}");
    }
}
