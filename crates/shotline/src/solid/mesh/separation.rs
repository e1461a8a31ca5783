//! Proofs in floating point that triangles are apart.
//!
//! Each test here returns `true` only if it finds a plane between the two, with a margin larger than any rounding. So
//! the exact predicates are left with the few pairs that touch, cross or are within about rounding of each other.

use super::mesh_line::Triangle;
use crate::math::Vec3;

/// An upper bound on the relative error of the sums of a projection.
const MARGIN: f64 = 32.0 * f64::EPSILON;

/// Whether two closed triangles have no point in common.
pub(super) fn are_apart(a: &Triangle, b: &Triangle) -> bool {
    are_apart_by(0.0, a, b)
}

/// Whether all points of two closed triangles are farther apart than a distance.
pub(super) fn are_apart_by(distance: f64, a: &Triangle, b: &Triangle) -> bool {
    let from = a.corners[0];
    let (a, b) = (a.corners.map(|p| p - from), b.corners.map(|p| p - from));
    let reach = a.iter().chain(&b).fold(0.0, |most: f64, p| most.max(p.abs().max_element()));
    let separates = |axis: Vec3| {
        let (low, high) = (f64::INFINITY, f64::NEG_INFINITY);
        let extent = |t: &[Vec3; 3]| {
            t.iter().fold((low, high), |(l, h), p| (l.min(axis.dot(*p)), h.max(axis.dot(*p))))
        };
        let (of_a, of_b) = (extent(&a), extent(&b));
        let gap = (of_b.0 - of_a.1).max(of_a.0 - of_b.1);
        gap > (MARGIN * reach + distance) * axis.abs().element_sum()
    };
    let edges = |t: &[Vec3; 3]| [t[1] - t[0], t[2] - t[1], t[0] - t[2]];
    let (edges_a, edges_b) = (edges(&a), edges(&b));
    let normals = [edges_a[0].cross(edges_a[1]), edges_b[0].cross(edges_b[1])];
    normals.iter().any(|n| separates(*n))
        || edges_a.iter().any(|e| edges_b.iter().any(|f| separates(e.cross(*f))))
        // Coplanar triangles.
        || edges_a.iter().any(|e| separates(normals[0].cross(*e)))
        || edges_b.iter().any(|e| separates(normals[1].cross(*e)))
}

/// Whether two triangles that share the corner `tip` have no other point in common, given their other corners.
///
/// They have none if the sectors of their directions from the tip have none, that is if `0` is not in the hull of the
/// directions of one and the negated directions of the other. The normal of a plane between the sectors is the point of
/// that hull nearest to `0`. It is on a face, an edge or a corner of the hull: each of these is tried.
pub(super) fn sectors_are_apart(tip: Vec3, [a, b]: [Vec3; 2], [c, d]: [Vec3; 2]) -> bool {
    let p = [(a - tip).normalize(), (b - tip).normalize(), -(c - tip).normalize(), -(d - tip).normalize()];
    let separates = |normal: Vec3| {
        let margin = MARGIN * normal.abs().element_sum();
        p.iter().all(|p| p.dot(normal) > margin)
    };
    if p.iter().any(|p| !p.is_finite()) {
        return false;
    }
    if separates(p[0] + p[1] + p[2] + p[3]) {
        return true;
    }
    for (i, j) in [(0, 2), (0, 3), (1, 2), (1, 3), (0, 1), (2, 3)] {
        let edge = p[j] - p[i];
        let along = -p[i].dot(edge) / edge.length_squared();
        if separates(p[i] + edge * along) {
            return true;
        }
    }
    for [i, j, k] in [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]] {
        let normal = (p[j] - p[i]).cross(p[k] - p[i]);
        if separates(normal) || separates(-normal) {
            return true;
        }
    }
    p.iter().any(|p| separates(*p))
}

/// Whether two triangles that share the edge from `u` to `v` have no other point in common. They have others if one is
/// folded onto the other.
pub(super) fn wings_are_apart(u: Vec3, v: Vec3, [c, d]: [Vec3; 2]) -> bool {
    let edge = v - u;
    let across = |p: Vec3| {
        let p = p - u;
        let out = p - edge * (p.dot(edge) / edge.length_squared());
        (out.normalize(), p.length() / out.length())
    };
    let ((c, doubt_c), (d, doubt_d)) = (across(c), across(d));
    (c - d).length() > MARGIN * (doubt_c + doubt_d)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle(corners: [[f64; 3]; 3]) -> Triangle {
        Triangle { corners: corners.map(Vec3::from), face: 0 }
    }

    #[test]
    fn only_what_is_apart_is_said_to_be() {
        let base = triangle([[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]]);
        let others = [
            (triangle([[0., 0., 1e-9], [1., 0., 1e-9], [0., 1., 1e-9]]), true),
            (triangle([[0.6, 0.5, 0.], [2., 0., 0.], [0., 2., 0.]]), true),
            (triangle([[0.5, 0.5, 0.], [2., 0., 0.], [0., 2., 0.]]), false),
            (triangle([[0.2, 0.2, -1.], [0.2, 0.2, 1.], [0.3, 0.3, 0.]]), false),
            (triangle([[0.6, 0.6, -1.], [0.6, 0.6, 1.], [0.7, 0.9, 0.]]), true),
            (base, false),
        ];
        for (other, apart) in others {
            assert_eq!((are_apart(&base, &other), are_apart(&other, &base)), (apart, apart), "{other:?}");
        }
    }

    #[test]
    fn sectors_that_only_share_their_tip_are_apart() {
        let v = |x: f64, y: f64, z: f64| Vec3::new(x, y, z);
        let quarter = [v(1., 0., 0.), v(0., 1., 0.)];
        let apart = |other: [Vec3; 2]| sectors_are_apart(Vec3::ZERO, quarter, other);
        // In one plane, beside it, above it.
        assert!(apart([v(-1., 0.1, 0.), v(-1., -1., 0.)]) && apart([v(1., 1., 1.), v(-1., 2., 0.1)]));
        // Through it, along its edge, within it.
        assert!(!apart([v(1., 1., 1.), v(1., 1., -1.)]) && !apart([v(2., 0., 0.), v(1., 0., 1.)]));
        assert!(!apart([v(1., 1., 0.), v(0.5, 3., 0.)]) && !apart(quarter));
        // Thin slices beside each other.
        let at = |degrees: f64| v(degrees.to_radians().cos(), degrees.to_radians().sin(), 0.3);
        let thin = [at(10.0), at(10.01)];
        assert!(sectors_are_apart(Vec3::ZERO, thin, [at(10.02), at(10.03)]));
        assert!(!sectors_are_apart(Vec3::ZERO, thin, [at(10.01), at(10.02)]));
    }

    #[test]
    fn wings_that_are_folded_together_are_not_apart() {
        let (u, v, c) = (Vec3::ZERO, Vec3::X, Vec3::new(0.3, 1.0, 0.0));
        assert!(wings_are_apart(u, v, [c, Vec3::new(0.5, -1.0, 0.0)]));
        assert!(wings_are_apart(u, v, [c, Vec3::new(0.5, 1.0, 1e-9)]));
        assert!(!wings_are_apart(u, v, [c, Vec3::new(0.5, 2.0, 0.0)]) && !wings_are_apart(u, v, [c, c]));
    }
}
