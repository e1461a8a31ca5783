//! Moments of intersections of half-spaces and boxes.

use crate::aabb::Aabb;
use crate::compile::SolidBody;
use crate::math::{Affine, Dd, Plane, Vec3, power_of_two_near};
use crate::region::Polytope;
use crate::solid::{Moments, tetrahedron};

/// Bodies with more faces than this are measured by rays.
const MAX_FACES: usize = 2000;

/// The moments of a body that is a bounded polytope: an intersection of half-spaces and boxes, also with half-spaces
/// subtracted.
pub(super) fn moments(body: &SolidBody) -> Option<Moments> {
    if body.bounds.is_empty() {
        return Some(Moments::EMPTY);
    }
    if !body.bounds.is_finite() || !body.program.is_conjunction() {
        return None;
    }
    let mut planes: Vec<Plane> = Vec::new();
    for (number, leaf) in (0..).zip(&body.leaves) {
        let own = leaf.solid.half_spaces()?.into_iter().map(|plane| plane.transformed(&leaf.local_from_body));
        let before = planes.len();
        planes.extend(own);
        if body.program.is_taken(number) {
            let [plane] = &mut planes[before..] else { return None };
            *plane = Plane::new(-plane.normal, -plane.offset);
        }
        if planes.len() > MAX_FACES {
            return None;
        }
    }
    // The box has a margin, so that a plane cuts every face and none is left by the box. Coordinates are relative to
    // the centre and of size 1, so that neither distance nor size costs accuracy.
    let (centre, size) = (body.bounds.centre(), body.bounds.size());
    let unit = power_of_two_near(size.max_element());
    let mut polytope = Polytope::of_box(&Aabb::new(-size / unit, size / unit));
    for plane in planes {
        polytope.cut(&Plane::new(plane.normal, plane.evaluate(centre) / unit));
    }
    let mut sums = [Dd::ZERO; 10];
    for triangle in polytope.triangles() {
        let part = tetrahedron(triangle);
        sums = std::array::from_fn(|i| sums[i] + Dd::from(part[i]));
    }
    let moments = Moments::from_integrals(sums.map(|sum| sum.hi));
    let place = Affine::translation(centre).then_after(&Affine::scaling(Vec3::splat(unit)));
    Some(moments.placed(&place))
}
