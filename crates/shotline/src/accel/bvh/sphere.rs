//! Spheres instead of boxes, in the same trees. Whitted (1980) used spheres first.

use super::{Bvh, MAX_LEAF, Node, Volume, binned_sah};
use crate::aabb::{Aabb, BoxRay, SphereRay};
use crate::accel::display;
use crate::math::{HALF_ULP, Vec3, length};
use crate::outline::Outline;

/// A closed ball.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::accel) struct Sphere {
    centre: Vec3,
    radius: f64,
}

/// Builds the tree of `binned_sah` and replaces each box by the smaller of two spheres: one around the box, and one
/// around the spheres of the children or the boxes of the items.
pub(super) fn build(boxes: &[Aabb]) -> Bvh<Sphere> {
    let Bvh { nodes, items, unbounded, has_duplicate_refs, .. } = binned_sah::build(boxes, MAX_LEAF);
    let sphere = |node: &Node<Aabb>| Node {
        bounds: Sphere::around(std::iter::once(node.bounds)),
        first: node.first,
        count: node.count,
    };
    let mut tree = Bvh {
        nodes: nodes.iter().map(sphere).collect(),
        items,
        unbounded,
        has_duplicate_refs,
        refit_data: None,
    };
    for index in (0..nodes.len()).rev() {
        let tighter = tree.node_bounds(index as u32, &|item| boxes[item as usize]);
        let bounds = &mut tree.nodes[index].bounds;
        if tighter.radius < bounds.radius {
            *bounds = tighter;
        }
    }
    tree
}

/// Increases `x` by enough to cover the rounding of a length or of a few operations.
fn outward(x: f64) -> f64 {
    x * (1.0 + 8.0 * HALF_ULP) + f64::MIN_POSITIVE
}

impl Volume for Sphere {
    /// Its centre is that of the box around all boxes; its radius is the distance of the farthest corner.
    fn around(boxes: impl Iterator<Item = Aabb> + Clone) -> Sphere {
        let centre = Aabb::around(boxes.clone().flat_map(|b| [b.min, b.max])).centre();
        let farthest = |b: Aabb| length((b.max - centre).abs().max((centre - b.min).abs()));
        Sphere { centre, radius: outward(boxes.map(farthest).fold(0.0, f64::max)) }
    }

    fn union(&self, other: &Sphere) -> Sphere {
        let (small, large) = if self.radius < other.radius { (self, other) } else { (other, self) };
        let way = small.centre - large.centre;
        let distance = length(way);
        if outward(outward(distance) + small.radius) <= large.radius {
            return *large;
        }
        let radius = 0.5 * (distance + small.radius + large.radius);
        let centre = if distance > 0.0 {
            large.centre + way * ((radius - large.radius) / distance)
        } else {
            large.centre
        };
        // The radius is computed from the rounded centre, so it is valid whatever the rounding error.
        let reach = |s: &Sphere| outward(outward(length(s.centre - centre)) + s.radius);
        Sphere { centre, radius: reach(small).max(reach(large)) }
    }

    type Ray<'r> = SphereRay;

    fn prepare(ray: &BoxRay) -> SphereRay {
        SphereRay::new(ray)
    }

    #[inline]
    fn enter(&self, ray: &SphereRay) -> Option<f64> {
        ray.enter(self.centre, self.radius)
    }

    const IS_BOX: bool = false;

    fn area(&self) -> f64 {
        self.radius * self.radius
    }

    fn display(&self) -> String {
        let [x, y, z] = self.centre.to_array().map(display::number);
        format!("sphere of radius {} at ({x}, {y}, {z})", display::number(self.radius))
    }

    fn outline(&self) -> Outline {
        Outline::Sphere { centre: self.centre, radius: self.radius }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testkit::random::Random;

    #[test]
    fn spheres_hold_what_they_are_around() {
        let mut random = Random::new(5);
        for size in [1e-200, 1e-3, 1.0, 1e100] {
            let mut one = || {
                let p = random.point(-1.0, 1.0);
                let b = Aabb::new(p * size, (p + random.point(0.0, 0.3)) * size);
                (b, Sphere::around(std::iter::once(b)))
            };
            for _ in 0..200 {
                let (a, b) = (one(), one());
                for sphere in [a.1.union(&b.1), Sphere::around([a.0, b.0].into_iter())] {
                    for corner in [a.0.min, a.0.max, b.0.min, b.0.max] {
                        assert!(length(corner - sphere.centre) <= sphere.radius, "{a:?} {b:?} {sphere:?}");
                    }
                    assert!(sphere.radius <= (a.1.radius + b.1.radius) * 4.0 + 3.5 * size);
                }
            }
        }
    }
}
