use std::f64::consts::TAU;

use crate::math::Vec3;

use super::invariants::{check, is_simple};
use super::{Triangulation, triangulate};

/// Checks the triangulation of a polygon with each corner as the first, in both directions, in several planes.
fn check_all(corners: &[[i64; 2]]) {
    for first in 0..corners.len() {
        let mut corners = corners.to_vec();
        corners.rotate_left(first);
        for _ in 0..2 {
            for axis in 0..3 {
                check(&corners, axis, [0, 0]);
                check(&corners, axis, [3, -7]);
            }
            corners.reverse();
        }
    }
}

const L: [[i64; 2]; 6] = [[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]];

#[test]
fn triangles_of_concave_polygons_stay_inside_the_outline() {
    let dart = [[0, 0], [4, 4], [0, 8], [2, 4]];
    let u = [[0, 0], [3, 0], [3, 3], [2, 3], [2, 1], [1, 1], [1, 3], [0, 3]];
    let plus =
        [[1, 0], [2, 0], [2, 1], [3, 1], [3, 2], [2, 2], [2, 3], [1, 3], [1, 2], [0, 2], [0, 1], [1, 1]];
    for simple in [&L[..], &dart, &u, &plus, &star(9), &comb(7), &spiral(3)] {
        assert!(is_simple(simple), "{simple:?}");
        check_all(simple);
    }
}

#[test]
fn corners_on_a_straight_edge_stay_corners_of_triangles_with_area() {
    let square = [[0, 0], [1, 0], [2, 0], [2, 1], [2, 2], [1, 2], [0, 2], [0, 1]];
    let triangle = [[0, 0], [1, 0], [2, 0], [3, 0], [4, 0], [2, 3]];
    let both = [[0, 0], [2, 0], [4, 0], [3, 3], [2, 6], [1, 3]];
    for corners in [&square[..], &triangle, &both] {
        assert!(is_simple(corners));
        check_all(corners);
    }
}

/// No triangle is inverted for slits, holes reached by a slit, equal corners, and outlines that touch themselves.
#[test]
fn outlines_that_touch_themselves_are_triangulated_without_overlap() {
    let hole = [[0, 0], [6, 0], [6, 6], [0, 6], [0, 0], [2, 2], [2, 4], [4, 4], [4, 2], [2, 2]];
    let slit = [[0, 0], [4, 0], [4, 4], [2, 4], [2, 2], [2, 4], [0, 4]];
    let twice = [[0, 0], [0, 0], [2, 0], [2, 2], [2, 2], [2, 2], [0, 2]];
    let pinched = [[0, 0], [2, 2], [4, 0], [4, 4], [2, 2], [0, 4]];
    let touching = [[0, 0], [4, 0], [4, 4], [2, 0], [0, 4]];
    let spike = [[0, 0], [2, 0], [2, 2], [2, 5], [2, 2], [0, 2]];
    let two_holes = [
        [0, 0],
        [9, 0],
        [9, 4],
        [0, 4],
        [0, 0],
        [1, 1],
        [1, 3],
        [3, 3],
        [3, 1],
        [5, 1],
        [5, 3],
        [7, 3],
        [7, 1],
        [5, 1],
        [3, 1],
        [1, 1],
    ];
    for corners in [&hole[..], &slit, &twice, &pinched, &touching, &spike, &two_holes] {
        check_all(corners);
        is_proper_from_each_corner(corners);
    }
}

/// Asserts a proper triangulation with each corner as the first, in both directions.
fn is_proper_from_each_corner(corners: &[[i64; 2]]) {
    let mut corners = corners.to_vec();
    for _ in 0..2 {
        for _ in 0..corners.len() {
            corners.rotate_left(1);
            let points: Vec<Vec3> =
                corners.iter().map(|[x, y]| Vec3::new(*x as f64, *y as f64, 0.0)).collect();
            assert!(triangulate(&points).is_proper, "{corners:?}: {:?}", triangulate(&points));
        }
        corners.reverse();
    }
}

#[test]
fn lobes_that_meet_in_a_corner_are_not_reported_as_crossing() {
    let uneven = [[0, 0], [2, 1], [4, 0], [4, 4], [2, 1], [0, 4]];
    // The outer corner at the origin turns left; the other corner at the origin lies between its sides.
    let nested = [[-4, 1], [0, 0], [4, 1], [1, 4], [0, 0], [-1, 4]];
    let three = [[0, 0], [4, -1], [4, 1], [0, 0], [1, 4], [-1, 4], [0, 0], [-4, 1], [-4, -1]];
    let chain = [[0, 0], [2, 1], [4, 0], [6, 1], [8, 0], [8, 4], [6, 1], [4, 3], [2, 1], [0, 4]];
    let inside = [[0, 0], [8, 0], [8, 8], [0, 0], [3, 5], [2, 6], [0, 0], [0, 9], [-3, 9]];
    for corners in [&uneven[..], &nested, &three, &chain, &inside] {
        check_all(corners);
        is_proper_from_each_corner(corners);
    }
}

#[test]
fn outlines_that_cross_themselves_keep_their_edges_and_are_reported() {
    let bow_tie = [[0, 0], [2, 2], [2, 0], [0, 2]];
    let uneven = [[0, 0], [4, 4], [4, 0], [0, 2]];
    let pentagram = [[0, 30], [18, -24], [-29, 9], [29, 9], [-18, -24]];
    for corners in [&bow_tie[..], &uneven, &pentagram] {
        check_all(corners);
        let points: Vec<Vec3> = corners.iter().map(|[x, y]| Vec3::new(*x as f64, *y as f64, 0.0)).collect();
        assert!(!triangulate(&points).is_proper, "{corners:?}");
    }
}

#[test]
fn polygons_without_area_are_not_reported() {
    let on_a_line = [[0, 0], [1, 1], [2, 2], [5, 5], [3, 3]];
    let there_and_back = [[0, 0], [1, 1], [4, 0], [1, 1]];
    for corners in [&[[1, 1]; 7][..], &on_a_line, &there_and_back] {
        check_all(corners);
        for z in [0.0, 1.0] {
            let point = |[x, y]: &[i64; 2]| Vec3::new(*x as f64, *y as f64, z * *x as f64);
            assert!(triangulate(&corners.iter().map(point).collect::<Vec<_>>()).is_proper, "{corners:?}");
        }
    }
}

/// Projected along its plane, a bow tie with rounded coordinates may look like a thin quadrilateral.
#[test]
fn crossings_are_detected_in_slanted_planes_too() {
    for i in 0..300 {
        let (a, b) = (f64::from(i) * 0.37, f64::from(i) * 0.23 + 0.1);
        let u = Vec3::new(a.cos(), a.sin() * b.cos(), a.sin() * b.sin());
        let v = Vec3::new(0.0, -b.sin(), b.cos());
        let round = |x: f64| (x * 1e6).round() / 1e6;
        let point = |[x, y]: [f64; 2]| Vec3::from((u * x + v * y + 5.0).to_array().map(round));
        let corners = [[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.0]].map(point);
        assert!(!triangulate(&corners).is_proper, "{corners:?}");
    }
}

#[test]
fn random_outlines_are_valid() {
    let mut random = crate::testkit::random::Random::new(5);
    let mut simple = 0;
    for i in 0..6000u64 {
        let (n, size) = (3 + i % 11, [2.0, 4.0, 9.0, 60.0][i as usize % 4]);
        let corners: Vec<[i64; 2]> = (0..n)
            .map(|_| {
                let p = random.point(-size, size);
                [p.x.round() as i64, p.y.round() as i64]
            })
            .collect();
        simple += usize::from(is_simple(&corners));
        check(&corners, i as usize % 3, [i as i64 % 5 - 2, i as i64 % 7 - 3]);
    }
    assert!(simple > 300, "{simple}");
}

/// Outlines without self-crossings, grown from a triangle by one corner at a time.
#[test]
fn random_simple_outlines_are_valid() {
    let mut random = crate::testkit::random::Random::new(6);
    for i in 0..150u64 {
        let mut corners = vec![[0, 0], [40, 0], [0, 40]];
        for _ in 0..400 {
            let p = random.point(-60.0, 60.0);
            let at = 1 + (random.point(0.0, 1.0).x * corners.len() as f64) as usize;
            corners.insert(at, [p.x.round() as i64, p.y.round() as i64]);
            if !is_simple(&corners) {
                corners.remove(at);
            }
            if corners.len() > 24 {
                break;
            }
        }
        assert!(corners.len() == 3 || is_simple(&corners));
        check(&corners, i as usize % 3, [1, -2]);
    }
}

/// A slanted prism with coordinates of six digits: the corners of a face are not coplanar, and no triangle covers the
/// notch.
#[test]
fn nearly_flat_polygons_are_triangulated_as_flat_ones() {
    for i in 0..400 {
        let (a, b) = (f64::from(i) * 0.37, f64::from(i) * 0.23 + 0.1);
        let (u, v) =
            (Vec3::new(a.cos(), a.sin() * b.cos(), a.sin() * b.sin()), Vec3::new(0.0, -b.sin(), b.cos()));
        for digits in [1e3, 1e6, 1e9] {
            let round = |x: f64| (x * digits).round() / digits;
            let point = |[x, y]: &[i64; 2]| {
                let p = u * *x as f64 + v * *y as f64 + Vec3::new(7.0, -3.0, 0.5);
                Vec3::new(round(p.x), round(p.y), round(p.z))
            };
            let points: Vec<Vec3> = L.iter().map(point).collect();
            let cut = triangulate(&points);
            assert!(cut.is_proper);
            for t in &cut.triangles {
                let middle = t.iter().fold([0, 0], |m, i| {
                    let [x, y] = L[*i as usize];
                    [m[0] + x, m[1] + y]
                });
                assert!(middle[0] <= 3 || middle[1] <= 3, "{t:?} lies in the notch");
            }
        }
    }
}

/// Thousands of corners in shapes that are hard for ear clipping. With quadratic work the test would take too long.
#[test]
fn polygons_of_many_corners_are_triangulated() {
    let n = 20_000;
    let round = (0..n).map(|i| (TAU * f64::from(i) / f64::from(n)).sin_cos());
    let circle: Vec<Vec3> = round.clone().map(|(y, x)| Vec3::new(x, y, 1.0)).collect();
    let jagged =
        round.enumerate().map(|(i, (y, x))| Vec3::new(x, y, 1.0) * if i % 2 == 0 { 1.0 } else { 0.3 });
    let whole =
        |corners: Vec<[i64; 2]>| corners.iter().map(|[x, y]| Vec3::new(*x as f64, 0.0, *y as f64)).collect();
    for corners in [circle, jagged.collect(), whole(comb(5_000)), whole(spiral(2_000)), whole(saw(8_000))] {
        let Triangulation { triangles, is_proper } = triangulate(&corners);
        assert!(is_proper && triangles.len() == corners.len() - 2);
    }
}

/// Nearly all edges cross others: the work is still bounded.
#[test]
fn polygons_of_many_crossings_are_triangulated() {
    let mut random = crate::testkit::random::Random::new(1);
    let corners: Vec<Vec3> = (0..3000).map(|_| random.point(-1.0, 1.0)).collect();
    assert_eq!(triangulate(&corners).triangles.len(), 2998);
}

#[test]
fn the_triangulation_does_not_depend_on_size() {
    let at = |size: f64| triangulate(&L.map(|[x, y]| Vec3::new(x as f64, y as f64, 1.0) * size));
    for size in [5e-324, 1e-300, 1e-120, 1e120, 1e300, 8e307] {
        assert_eq!(at(size), at(1.0), "{size}");
    }
}

fn star(tips: i64) -> Vec<[i64; 2]> {
    let at = |i: i64| {
        let (angle, r) = (TAU * i as f64 / (2 * tips) as f64, if i % 2 == 0 { 50.0 } else { 17.0 });
        [(angle.cos() * r).round() as i64, (angle.sin() * r).round() as i64]
    };
    (0..2 * tips).map(at).collect()
}

/// Teeth on a bar, with four corners each.
fn comb(teeth: i64) -> Vec<[i64; 2]> {
    let tooth = |i: i64| [[2 * i, 1], [2 * i, 60], [2 * i + 1, 60], [2 * i + 1, 1]];
    let right = 2 * teeth - 1;
    (0..teeth).flat_map(tooth).chain([[right, 0], [0, 0]]).collect()
}

/// Narrow teeth without a bar.
fn saw(teeth: i64) -> Vec<[i64; 2]> {
    let tooth = |i: i64| [[2 * i, 0], [2 * i + 1, 1_000]];
    (0..teeth).flat_map(tooth).chain([[2 * teeth, 0], [teeth, -1]]).collect()
}

/// A square spiral, inwards and back.
fn spiral(turns: i64) -> Vec<[i64; 2]> {
    let out = |k: i64, r: i64| match k % 4 {
        0 => [r, -r],
        1 => [r, r],
        2 => [-r, r],
        _ => [-r, -r - 4],
    };
    let outer = |k: i64| out(k, 4 * (k / 4) + 4);
    let inner = |k: i64| {
        let r = 4 * (k / 4) + 2;
        if k % 4 == 3 { [-r, -r - 4] } else { out(k, r) }
    };
    (0..4 * turns).map(outer).chain((0..4 * turns).rev().map(inner)).collect()
}

/// Each outline surrounds random cells of a grid, which may meet in corners. It is one loop that does not cross itself.
#[test]
fn random_outlines_that_touch_themselves_in_corners_are_triangulated_without_overlap() {
    let mut random = crate::testkit::random::Random::new(8);
    let (mut outlines, mut touching) = (0, 0);
    for _ in 0..6000 {
        let mut cells = vec![[0, 0]];
        for _ in 0..2 + random.below(9) {
            let [x, y] = cells[random.below(cells.len())];
            let cell = [x + random.below(3) as i64 - 1, y + random.below(3) as i64 - 1];
            if !cells.contains(&cell) {
                cells.push(cell);
            }
        }
        let Some(corners) = outline_of(&cells, &mut random) else { continue };
        outlines += 1;
        touching += usize::from((1..corners.len()).any(|i| corners[..i].contains(&corners[i])));
        // A skew map, so that few corners lie on a line.
        let skewed: Vec<[i64; 2]> =
            corners.iter().map(|[x, y]| [7 * x + 2 * y + x * x % 2, 6 * y - x]).collect();
        for corners in [corners, skewed] {
            check(&corners, 0, [0, 0]);
            is_proper_from_each_corner(&corners);
        }
    }
    assert!(outlines > 3000 && touching > 1000, "{outlines} {touching}");
}

/// The outline of cells, if it is one loop. Where two cells meet in a corner only, it randomly stays at its cell or
/// continues along the other.
fn outline_of(cells: &[[i64; 2]], random: &mut crate::testkit::random::Random) -> Option<Vec<[i64; 2]>> {
    let mut edges = Vec::new();
    for &[x, y] in cells {
        let corners = [[x, y], [x + 1, y], [x + 1, y + 1], [x, y + 1]];
        let beside = [[x, y - 1], [x + 1, y], [x, y + 1], [x - 1, y]];
        edges.extend(
            (0..4).filter(|i| !cells.contains(&beside[*i])).map(|i| (corners[i], corners[(i + 1) % 4])),
        );
    }
    let mut stays = std::collections::HashMap::new();
    let (start, mut at) = edges[0];
    let mut from = start;
    let mut outline = vec![start];
    loop {
        let left = [at[0] - (at[1] - from[1]), at[1] + (at[0] - from[0])];
        let out: Vec<[i64; 2]> = edges.iter().filter(|(a, _)| *a == at).map(|(_, b)| *b).collect();
        let stay = *stays.entry(at).or_insert_with(|| random.below(2) == 0);
        let next = if out.len() == 1 { out[0] } else { *out.iter().find(|b| (**b == left) == stay)? };
        if (at, next) == edges[0] {
            break;
        }
        outline.push(at);
        (from, at) = (at, next);
    }
    (outline.len() == edges.len()).then_some(outline)
}
