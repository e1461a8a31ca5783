//! Directions halfway between two axes, in addition to the axes.

use super::direction::{Axis, Direction};
use crate::aabb::{Aabb, BoxRay, Slope};
use crate::accel::prim_ref::PrimRef;
use crate::math::{Dd, Vec3, two_sum};

/// The cost of crossing an oblique plane, in units of an item test.
const PLANE_COST: f64 = 1.5;
/// The factor by which an oblique plane must be better than one perpendicular to an axis. Cells are measured as if
/// they were boxes, and oblique planes do not clip the boxes of items, so more items extend across the plane than the
/// cost assumes.
const HANDICAP: f64 = 1.25;

/// A direction. The height along it is a coordinate, or the sum or the difference of two.
#[derive(Clone, Copy, Debug)]
pub(in crate::accel) enum Oblique {
    Axis(Axis),
    /// The first coordinate plus the second.
    Sum(u8, u8),
    /// The first coordinate minus the second.
    Difference(u8, u8),
}

use Oblique::{Difference, Sum};

impl Direction for Oblique {
    const ALL: &'static [Oblique] = &[
        Oblique::Axis(Axis(0)),
        Oblique::Axis(Axis(1)),
        Oblique::Axis(Axis(2)),
        Sum(0, 1),
        Sum(0, 2),
        Sum(1, 2),
        Difference(0, 1),
        Difference(0, 2),
        Difference(1, 2),
    ];

    fn display(self) -> String {
        match self {
            Oblique::Axis(axis) => axis.display(),
            Sum(i, j) => format!("{} + {}", Axis(i).display(), Axis(j).display()),
            Difference(i, j) => format!("{} - {}", Axis(i).display(), Axis(j).display()),
        }
    }

    fn normal(self) -> Vec3 {
        match self {
            Oblique::Axis(axis) => axis.normal(),
            Sum(i, j) => Axis(i).normal() + Axis(j).normal(),
            Difference(i, j) => Axis(i).normal() - Axis(j).normal(),
        }
    }

    #[inline]
    fn index(self) -> usize {
        usize::from(match self {
            Oblique::Axis(Axis(i)) => i,
            Sum(i, j) => 2 + i + j,
            Difference(i, j) => 5 + i + j,
        })
    }

    fn slope(self, ray: &BoxRay) -> Slope {
        match self {
            Oblique::Axis(axis) => axis.slope(ray),
            Sum(i, j) => ray.oblique_slope([i.into(), j.into()], 1.0),
            Difference(i, j) => ray.oblique_slope([i.into(), j.into()], -1.0),
        }
    }

    type Slopes = [Slope; 9];

    fn slopes(ray: &BoxRay) -> [Slope; 9] {
        std::array::from_fn(|index| Self::ALL[index].slope(ray))
    }

    fn extent(self, b: &Aabb) -> (f64, f64) {
        match self {
            Oblique::Axis(axis) => axis.extent(b),
            Sum(i, j) => {
                let (i, j) = (usize::from(i), usize::from(j));
                (sum_down(b.min[i], b.min[j]), -sum_down(-b.max[i], -b.max[j]))
            }
            Difference(i, j) => {
                let (i, j) = (usize::from(i), usize::from(j));
                (sum_down(b.min[i], -b.max[j]), -sum_down(-b.max[i], b.min[j]))
            }
        }
    }

    fn cut(self, b: &Aabb, at: f64) -> (Aabb, Aabb) {
        let (mut low, mut high) = (*b, *b);
        match self {
            Oblique::Axis(axis) => return axis.cut(b, at),
            Sum(i, j) => {
                let (i, j) = (usize::from(i), usize::from(j));
                low.max[i] = low.max[i].min(at - b.min[j]);
                low.max[j] = low.max[j].min(at - b.min[i]);
                high.min[i] = high.min[i].max(at - b.max[j]);
                high.min[j] = high.min[j].max(at - b.max[i]);
            }
            Difference(i, j) => {
                let (i, j) = (usize::from(i), usize::from(j));
                low.max[i] = low.max[i].min(at + b.max[j]);
                low.min[j] = low.min[j].max(b.min[i] - at);
                high.min[i] = high.min[i].max(at + b.min[j]);
                high.max[j] = high.max[j].min(b.max[i] - at);
            }
        }
        (low, high)
    }

    /// Only planes perpendicular to an axis clip boxes. An oblique plane leaves pieces that are not boxes. Boxes
    /// around them would be rounded, by more or less than the `t` at which a ray crosses the plane.
    fn partition_by_plane(self, items: &[PrimRef], at: f64) -> (Vec<PrimRef>, Vec<PrimRef>) {
        if let Oblique::Axis(axis) = self {
            return axis.partition_by_plane(items, at);
        }
        let (mut below, mut above) = (Vec::new(), Vec::new());
        for &item in items {
            let (low, high) = self.extent(&item.bounds);
            let is_above = high > at;
            if is_above {
                above.push(item);
            }
            if low < at || !is_above {
                below.push(item);
            }
        }
        (below, above)
    }

    fn cost(self, b: &Aabb, at: f64, items: [usize; 2]) -> f64 {
        let size = b.size();
        let (i, j) = match self {
            Oblique::Axis(axis) => return axis.cost(b, at, items),
            Sum(i, j) | Difference(i, j) => (usize::from(i), usize::from(j)),
        };
        let sides = [size[i], size[j], size[3 - i - j]];
        let height = at - self.extent(b).0;
        let below = prism(sides, height) * items[0] as f64;
        let above = prism(sides, sides[0] + sides[1] - height) * items[1] as f64;
        // A box without area gives NaN, and so no plane.
        PLANE_COST + HANDICAP * (below + above) / b.half_area()
    }
}

/// Half the surface area of the prism that a plane at a height above an edge cuts off a box. The arguments are the
/// two sides of the box perpendicular to the edge, and the side along it.
fn prism([a, b, along]: [f64; 3], height: f64) -> f64 {
    let (over_a, over_b) = ((height - a).max(0.0), (height - b).max(0.0));
    let face = 0.5 * (height * height - over_a * over_a - over_b * over_b);
    let cut = (height.min(a) - over_b).max(0.0) * std::f64::consts::SQRT_2;
    let around = height.min(a) + height.min(b) + over_a.min(b) + over_b.min(a) + cut;
    face + 0.5 * around * along
}

/// A sum rounded down.
fn sum_down(a: f64, b: f64) -> f64 {
    let Dd { hi, lo } = two_sum(a, b);
    if lo < 0.0 { hi.next_down() } else { hi }
}

#[cfg(test)]
mod tests {
    use super::super::{Bsp, Node};
    use super::*;
    use crate::math::Vec3;
    use crate::ray::{Line, Span};
    use crate::testkit::random::Random;

    #[test]
    fn indices() {
        assert!(Oblique::ALL.iter().enumerate().all(|(i, direction)| direction.index() == i));
    }

    #[test]
    fn parts_of_a_box() {
        let b = Aabb::new(Vec3::new(1.0, 2.0, -1.0), Vec3::new(3.0, 5.0, 0.0));
        assert_eq!(Sum(0, 1).extent(&b), (3.0, 8.0));
        assert_eq!(Difference(0, 2).extent(&b), (1.0, 4.0));
        let (low, high) = Difference(0, 1).cut(&b, -3.0);
        assert_eq!((low.max, low.min), (Vec3::new(2.0, 5.0, 0.0), Vec3::new(1.0, 4.0, -1.0)));
        assert_eq!((high.max, high.min), (b.max, b.min));
        // A prism of length 1 over a triangle with legs of 1: the area of the triangle, and half of its perimeter.
        assert_eq!(prism([2.0, 3.0, 1.0], 1.0), 0.5 + 0.5 * (2.0 + 2f64.sqrt()));
        assert_eq!(prism([2.0, 3.0, 1.0], 5.0), b.half_area());
    }

    /// A ray meets a box on one side of a plane within the bounds of the plane, and nothing is lost between the
    /// bounds.
    #[test]
    fn planes_bound_what_lies_behind_them() {
        let mut random = Random::new(6);
        let mut culled = 0;
        for case in 0..40_000 {
            let p = random.point(-1.0, 1.0);
            let b = Aabb::new(p, p + random.point(0.0, 0.2) * [0.0, 1.0, 1e-9][case % 3]);
            let o = random.point(-1.0, 1.0) * [1.0, 3.0, 1e9][case / 3 % 3];
            let mut line = Line::exact(o, b.centre() - o);
            if case % 4 == 0 {
                line.d = [Vec3::X, Vec3::Y, Vec3::NEG_Z, Vec3::new(1.0, -1.0, 0.0)][case / 4 % 4];
                line.o = b.max - line.d * [2.0, 1e9][case / 16 % 2];
            }
            if case % 5 == 0 {
                line.o_err = random.point(0.0, 1.0) * 1e-9;
                line.d_err = line.d.abs() * random.number(0.0, 0.1) + Vec3::splat(1e-17);
            }
            let ray = BoxRay::new(&line, Span::new(-1e30, f64::INFINITY).expect("an interval"));
            let Some((enter, exit)) = ray.enter_exit(&b) else { continue };
            for direction in Oblique::ALL {
                let (slope, (low, high)) = (direction.slope(&ray), direction.extent(&b));
                let (first, last) = if slope.ascends() { (low, high) } else { (high, low) };
                let context = format!("{direction:?} {line:?} {b:?} {slope:?} {enter} {exit}");
                assert!(slope.earliest(first) <= enter, "{context}");
                assert!(slope.latest(last) >= exit, "{context}");
                assert!(slope.earliest(low) <= slope.latest(low), "{context}");
                culled += u32::from(slope.latest(last) < f64::INFINITY);
            }
        }
        assert!(culled > 100_000, "{culled}");
    }

    /// Small boxes along two diagonal walls.
    #[test]
    fn walls_are_cut_along() {
        let at = |i: usize, wall: f64| Vec3::new((i % 40) as f64 + wall, (i % 40) as f64, (i / 40) as f64);
        let wall = |wall: f64| (0..400).map(move |i| Aabb::new(at(i, wall), at(i, wall) + Vec3::splat(0.9)));
        let tree = Bsp::<Oblique>::build(&wall(0.0).chain(wall(9.0)).collect::<Vec<_>>());
        let along = |node: &&Node<Oblique>| matches!(node, Node::Plane { direction: Difference(0, 1), .. });
        assert!(tree.nodes.iter().filter(along).count() > 8, "{:?}", tree.nodes);
    }
}
