//! Where a mesh passes through itself.
//!
//! Two triangles pass through each other where their interiors have a point in common and they are not coplanar. Mere
//! contact does not count, neither along a shared edge nor with a corner on a face. Coplanar triangles do not count
//! even if they overlap: nothing passes through there. All of this is decided by exact signs (J. R. Shewchuk 1997,
//! "Adaptive precision floating-point arithmetic and fast robust geometric predicates"), so neither size nor position
//! of a mesh matters.

use robust::{Coord, Coord3D, orient2d, orient3d};

use crate::math::Vec3;

/// Returns the ends, up to rounding, of the segment that the interiors of two triangles have in common; `None` if they
/// have no point in common or are coplanar (P. Guigue and O. Devillers 2003, "Fast and robust triangle-triangle overlap
/// test using orientation predicates", without its cases of touching).
pub(super) fn common_segment(a: [Vec3; 3], b: [Vec3; 3]) -> Option<[Vec3; 2]> {
    let (mut a, heights_a) = with_lone_corner_first(a, b)?;
    let (mut b, heights_b) = with_lone_corner_first(b, a)?;
    // The planes intersect in a line, of which each triangle covers an interval.
    let ([i, j], [k, l]) = (ends(a, heights_a), ends(b, heights_b));
    // Orient each triangle so that the lone corner of the other is on its positive side.
    if heights_a[0] < 0.0 {
        b.swap(1, 2);
    }
    if heights_b[0] < 0.0 {
        a.swap(1, 2);
    }
    // Nothing is in common if one interval ends before or where the other begins.
    if orient(a[0], a[1], b[0], b[1]) >= 0.0 || orient(a[0], a[2], b[2], b[0]) >= 0.0 {
        return None;
    }
    let mut segment = [i, j, k, l];
    segment.sort_by(|p, q| (j - i).dot(*p).total_cmp(&(j - i).dot(*q)));
    Some([segment[1], segment[2]])
}

/// Rotates the corners so that the first is the one that is alone on its side of the other triangle's plane. Returns
/// them with their heights over that plane; `None` if the plane does not cut the triangle.
fn with_lone_corner_first(corners: [Vec3; 3], other: [Vec3; 3]) -> Option<([Vec3; 3], [f64; 3])> {
    let heights = corners.map(|p| height(p, other));
    let splits = |k: usize| {
        let [p, q, r] = [0, 1, 2].map(|i| heights[(k + i) % 3]);
        let sides = (p < 0.0 && q >= 0.0 && r >= 0.0) || (p > 0.0 && q <= 0.0 && r <= 0.0);
        sides && (q != 0.0 || r != 0.0)
    };
    let k = (0..3).find(|&k| splits(k))?;
    Some(([0, 1, 2].map(|i| corners[(k + i) % 3]), [0, 1, 2].map(|i| heights[(k + i) % 3])))
}

/// A value proportional to the height of a point over a triangle's plane, with the exact sign.
fn height(p: Vec3, [a, b, c]: [Vec3; 3]) -> f64 {
    // Neighbours share corners, which are known to lie in the plane.
    if p == a || p == b || p == c { 0.0 } else { orient(a, b, c, p) }
}

/// Returns where the two edges at the first corner pass through the plane over which the corners have these heights, up
/// to rounding.
fn ends([p, q, r]: [Vec3; 3], heights: [f64; 3]) -> [Vec3; 2] {
    [(q, heights[1]), (r, heights[2])]
        .map(|(end, height)| p + (end - p) * (heights[0] / (heights[0] - height)))
}

/// Whether a triangle has no area. Then nothing passes through it.
pub(super) fn has_no_area([a, b, c]: [Vec3; 3]) -> bool {
    let turn = |i: usize, j: usize| {
        let [a, b, c] = [a, b, c].map(|v| Coord { x: v[i], y: v[j] });
        orient2d(a, b, c)
    };
    turn(0, 1) == 0.0 && turn(1, 2) == 0.0 && turn(2, 0) == 0.0
}

fn orient(a: Vec3, b: Vec3, c: Vec3, d: Vec3) -> f64 {
    let [a, b, c, d] = [a, b, c, d].map(|v| Coord3D { x: v.x, y: v.y, z: v.z });
    orient3d(a, b, c, d)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use proptest::prelude::*;

    use super::*;
    use crate::math::Affine;
    use crate::solid::mesh::TriangleMesh;
    use crate::solid::mesh::shapes::{ball, cubes, ring};
    use crate::solid::mesh::{Intersection, MeshSolid, Tally};

    fn intersections(mesh: TriangleMesh) -> Tally<Intersection> {
        let mesh = Arc::new(mesh);
        let found = MeshSolid::new(mesh.clone(), "bvh").unwrap().self_intersections().unwrap();
        assert_eq!(MeshSolid::new(mesh, "brute").unwrap().self_intersections(), Some(found));
        found
    }

    #[test]
    fn sound_meshes_do_not_pass_through_themselves() {
        let folded = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [1, 1, 1], [0, 0, 2]];
        for mesh in
            [ball(3), ring(9, 5), ring(40, 30).unwelded(), cubes(&folded), cubes(&[[0, 0, 0], [1, 1, 0]])]
        {
            assert_eq!(intersections(mesh), Tally::default());
        }
    }

    #[test]
    fn balls_that_overlap_pass_through_each_other_on_a_circle() {
        for scale in [1.0, 1e-200, 1e200] {
            let other = ball(3).moved(&Affine::translation(Vec3::new(1.0, 0.013, 0.007)));
            let count = ball(3).faces.len() as u32;
            let scaled = ball(3).with(&other).moved(&Affine::scaling(Vec3::splat(scale)));
            let found = intersections(scaled);
            assert!((40..120).contains(&found.count), "{found:?}");
            let first = found.first.unwrap();
            assert!(first.faces[0] < count && first.faces[1] >= count);
            let p = first.point / scale;
            assert!((p.x - 0.5).abs() < 0.05 && (p.y.hypot(p.z) - 0.866).abs() < 0.05, "{first:?}");
        }
    }

    #[test]
    fn only_exactly_collinear_corners_have_no_area() {
        for at in [Vec3::ZERO, Vec3::new(1e9, -3.0, 7.0)] {
            let [a, b] = [at, at + Vec3::new(3.0, 1.0, 0.5)];
            let c = a + (b - a) * 8.0;
            assert!(has_no_area([a, b, c]) && has_no_area([a, a, c]));
            for axis in 0..3 {
                let mut off = c;
                off[axis] = off[axis].next_up();
                assert!(!has_no_area([a, b, off]));
            }
        }
    }

    #[test]
    fn faces_that_lie_in_each_other_do_not_pass_through() {
        // Shells that touch, face on face and corner on face, and the same cube twice.
        let at = |x: f64, y: f64| cubes(&[[0, 0, 0]]).moved(&Affine::translation(Vec3::new(x, y, 0.25)));
        for other in [at(1.0, 0.0), at(1.0, 0.5), cubes(&[[0, 0, 0]]), cubes(&[[0, 0, 0]]).inside_out()] {
            assert_eq!(intersections(cubes(&[[0, 0, 0]]).with(&other)).count, 0);
        }
        // But pushed into each other they do.
        assert!(intersections(cubes(&[[0, 0, 0]]).with(&at(0.5, 0.5))).count > 0);
    }

    /// The reference in exact fractions, by the points where the edges of each triangle meet the plane of the other.
    fn crosses(a: [[i64; 3]; 3], b: [[i64; 3]; 3]) -> bool {
        type V = [i64; 3];
        let minus = |p: V, q: V| -> V { std::array::from_fn(|i| p[i] - q[i]) };
        let dot = |p: V, q: V| (0..3).map(|i| p[i] * q[i]).sum::<i64>();
        let cross = |p: V, q: V| -> V {
            std::array::from_fn(|i| p[(i + 1) % 3] * q[(i + 2) % 3] - p[(i + 2) % 3] * q[(i + 1) % 3])
        };
        let normal = |t: [V; 3]| cross(minus(t[1], t[0]), minus(t[2], t[0]));
        // The interval that a triangle covers of the line of both planes, as fractions along `along`.
        let along = cross(normal(a), normal(b));
        let segment = |t: [V; 3], plane: [V; 3]| {
            let height = |p: V| dot(normal(plane), minus(p, plane[0]));
            let mut ends: Vec<(i64, i64)> = Vec::new();
            for (p, q) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
                let (hp, hq) = (height(p), height(q));
                if hp * hq < 0 {
                    let sign = (hp - hq).signum();
                    ends.push(((dot(along, q) * hp - dot(along, p) * hq) * sign, (hp - hq) * sign));
                }
                if hp == 0 {
                    ends.push((dot(along, p), 1));
                }
            }
            let split = t.iter().any(|&p| height(p) > 0) && t.iter().any(|&p| height(p) < 0);
            split.then_some(ends)
        };
        let less = |x: (i64, i64), y: (i64, i64)| {
            i128::from(x.0) * i128::from(y.1) < i128::from(y.0) * i128::from(x.1)
        };
        let (Some(s), Some(t)) = (segment(a, b), segment(b, a)) else { return false };
        let low =
            |ends: &[(i64, i64)]| ends.iter().copied().reduce(|x, y| if less(x, y) { x } else { y }).unwrap();
        let high =
            |ends: &[(i64, i64)]| ends.iter().copied().reduce(|x, y| if less(x, y) { y } else { x }).unwrap();
        less(low(&s), high(&t)) && less(low(&t), high(&s))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4000))]

        #[test]
        fn pairs_agree_with_fractions(
            corners in prop::array::uniform6(prop::array::uniform3(-3..=3i64)), far in prop_oneof![Just(0i64), Just(1 << 40)],
        ) {
            let [p, q, r, u, v, w] = corners;
            let (a, b) = ([p, q, r], [u, v, w]);
            let real = |t: [[i64; 3]; 3]| t.map(|p| Vec3::from(p.map(|x| (x + far) as f64)));
            let point = common_segment(real(a), real(b)).map(|[p, q]| 0.5 * p + 0.5 * q);
            prop_assert_eq!(point.is_some(), crosses(a, b));
            prop_assert_eq!(common_segment(real(b), real(a)).is_some(), point.is_some());
            let inside = |p: Vec3| (p - Vec3::splat(far as f64)).abs().max_element() <= 3.0;
            prop_assert!(point.is_none_or(inside), "{point:?}");
            // The same two triangles as a mesh.
            let vertices = real(a).into_iter().chain(real(b)).collect();
            let mesh = TriangleMesh::new(vertices, vec![[0, 1, 2], [3, 4, 5]]);
            if let Ok(solid) = MeshSolid::new(Arc::new(mesh), "bvh") {
                let count = solid.self_intersections().map(|crossings| crossings.count);
                prop_assert_eq!(count, Some(usize::from(point.is_some())));
            }
        }
    }
}
