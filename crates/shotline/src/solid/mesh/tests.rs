//! Properties that hold for every mesh and every ray, aimed at features or not.

use std::sync::Arc;

use proptest::prelude::*;

use super::shapes::{ball, cubes, ring, sheet};
use super::{MeshSolid, TriangleMesh};
use crate::accel;
use crate::crossing::{Crossing, is_alternating};
use crate::math::{Affine, Vec3, tests_support::affine_strategy};
use crate::ray::{Line, Span};
use crate::scratch::Scratch;
use crate::solid::{Solid, Wanted};

fn solid(mesh: TriangleMesh, accel: &str) -> MeshSolid {
    MeshSolid::new(Arc::new(mesh), accel).unwrap()
}

fn crossings(solid: &MeshSolid, line: &Line) -> Vec<Crossing> {
    let mut out = Vec::new();
    solid.crossings(line, &mut out);
    assert!(is_alternating(&out), "{out:?}");
    assert!(out.iter().all(|c| c.t.is_finite() && c.t_err >= 0.0 && c.t_err.is_finite()), "{out:?}");
    out
}

fn within(solid: &MeshSolid, line: &Line, span: Span, wanted: Wanted) -> Vec<Crossing> {
    let mut out = Vec::new();
    solid.crossings_within(line, span, wanted, &mut out, &mut Scratch::default());
    assert!(is_alternating(&out), "{out:?}");
    out
}

fn hits(solid: &MeshSolid, line: &Line, span: Span) -> Vec<Crossing> {
    let mut out = Vec::new();
    solid.hits(line, span, &mut out, &mut Scratch::default());
    out
}

/// Reduces a list to what rounding can distinguish, as `(t, entering)`: crossings that agree within 8 times the sum of
/// their bounds are one event, and an even number of them changes nothing.
fn folded(list: &[Crossing]) -> Vec<(f64, bool)> {
    let (mut out, mut inside, mut i) = (Vec::new(), false, 0);
    while i < list.len() {
        let start = i;
        i += 1;
        while i < list.len() && list[i].t - list[i - 1].t <= 8.0 * (list[i].t_err + list[i - 1].t_err) {
            i += 1;
        }
        if (i - start) % 2 == 1 {
            inside = !inside;
            out.push((list[start].t, inside));
        }
    }
    out
}

/// The expected result from `t_min` on, folded.
fn from_start(list: &[Crossing], t_min: f64) -> Vec<(f64, bool)> {
    let all = folded(list);
    let inside = all.iter().rfind(|(t, _)| *t < t_min).is_some_and(|c| c.1);
    let start = inside.then_some((t_min, true));
    start.into_iter().chain(all.into_iter().filter(|(t, _)| *t >= t_min)).collect()
}

/// Closed meshes: round, with a hole, with edges of four faces, with nested and touching shells, with flaps of zero
/// thickness; transformed or not, and some of them inside out.
fn closed_mesh() -> impl Strategy<Value = TriangleMesh> {
    let place = prop::array::uniform3(-1..=1i32);
    let blocks = prop::collection::btree_set(place, 1..8);
    let shape = prop_oneof![
        Just(ball(2)),
        Just(ring(9, 5)),
        blocks.clone().prop_map(|set| cubes(&Vec::from_iter(set))),
        // Block by block: faces between neighbours exist twice, once in each direction.
        blocks.prop_map(|set| set.iter().fold(TriangleMesh::default(), |m, b| m.with(&cubes(&[*b])))),
        Just(ball(1).with(&ball(2).moved(&Affine::scaling(Vec3::splat(0.5))))),
        Just(ball(1).with(&ball(1).moved(&Affine::scaling(Vec3::splat(0.5))).inside_out())),
        Just(ball(1).with(&sheet(2)).with(&sheet(2).inside_out())),
    ];
    let facing = prop_oneof![Just(Affine::IDENTITY), affine_strategy()];
    (shape, facing, any::<bool>()).prop_map(|(mesh, facing, inside_out)| {
        let mesh = mesh.moved(&facing);
        if inside_out { mesh.inside_out() } else { mesh }
    })
}

/// A point of a mesh: a corner, on an edge, or on a face.
fn aim(mesh: &TriangleMesh, (face, what): (prop::sample::Index, usize)) -> Vec3 {
    let [a, b, c] = mesh.corners(face.index(mesh.faces.len()) as u32);
    [a, 0.5 * a + 0.5 * b, 0.75 * a + 0.25 * b, 0.25 * (a + b) + 0.5 * c][what]
}

type Aim = (prop::sample::Index, usize);

/// Lines through two points of the mesh, or through one of them from anywhere, or along an axis.
fn line_of(mesh: &TriangleMesh, aims: [Aim; 2], from: [f64; 3], kind: usize) -> Line {
    let (p, q, o) = (aim(mesh, aims[0]), aim(mesh, aims[1]), Vec3::from(from));
    let axis = Vec3::AXES[kind % 3];
    match kind {
        0..3 => Line::exact(p - axis * 8.0, axis),
        3 => Line::exact(o, p - o),
        4 => Line::exact(p, o - p),
        5 if p != q => Line::exact(p, q - p),
        6 if p != q => Line::exact(p - 4.0 * (q - p), q - p),
        7 => Line { o_err: Vec3::splat(1e-15), d_err: Vec3::splat(1e-16), ..Line::exact(o, p - o) },
        _ => Line::exact(o, 1e3 * (p - o)),
    }
}

fn aims() -> impl Strategy<Value = [Aim; 2]> {
    let aim = || (any::<prop::sample::Index>(), 0..4usize);
    (aim(), aim()).prop_map(|(a, b)| [a, b])
}

fn origin() -> impl Strategy<Value = [f64; 3]> {
    prop_oneof![
        prop::array::uniform3(-6.0..6.0f64),
        prop::array::uniform3((-12..12i32).prop_map(|i| f64::from(i) * 0.5)),
        prop::array::uniform3(-1e5..1e5f64),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    /// Lists alternate and are even for every line, have the same bits for every accelerator, and agree with queries
    /// that request less.
    #[test]
    fn aimed_rays_neither_leak_nor_double(
        mesh in closed_mesh(), aims in aims(), from in origin(), kind in 0..9usize, t_min in -0.5..1.5f64,
    ) {
        let line = line_of(&mesh, aims, from, kind);
        let oracle = solid(mesh.clone(), "brute");
        prop_assert!(oracle.is_closed());
        let all = crossings(&oracle, &line);
        for name in accel::NAMES {
            let other = solid(mesh.clone(), name);
            prop_assert_eq!(&crossings(&other, &line), &all, "{}", name);
            for t_min in [0.0, t_min] {
                let span = Span::new(t_min, f64::INFINITY).unwrap();
                let expected = from_start(&all, t_min);
                let list = within(&other, &line, span, Wanted::All);
                prop_assert_eq!(&from_start(&list, t_min), &expected, "{}", name);
                let first = within(&other, &line, span, Wanted::First);
                let first = from_start(&first, t_min);
                prop_assert_eq!(first.first(), expected.first(), "{}", name);
            }
        }
    }

    /// The result for a span does not depend on what lies behind it.
    #[test]
    fn spans_end(mesh in closed_mesh(), aims in aims(), from in origin(), kind in 0..9usize, length in 0.0..2.0f64) {
        let line = line_of(&mesh, aims, from, kind);
        let solid = solid(mesh, "bvh");
        let in_span = |list: Vec<Crossing>| {
            from_start(&list, 0.0).into_iter().filter(|(t, _)| *t <= length).collect::<Vec<_>>()
        };
        let expected = in_span(crossings(&solid, &line));
        let span = Span::new(0.0, length).unwrap();
        prop_assert_eq!(&in_span(within(&solid, &line, span, Wanted::All)), &expected);
        let first = in_span(within(&solid, &line, span, Wanted::First));
        prop_assert_eq!(first.first(), expected.first());
    }

    /// A reversed ray hits the same triangles in the opposite direction, at the same points.
    #[test]
    fn a_reversed_ray_gives_the_mirrored_list(
        mesh in closed_mesh(), aims in aims(), from in origin(), kind in 0..9usize,
    ) {
        let line = line_of(&mesh, aims, from, kind);
        let solid = solid(mesh, "bvh");
        let there = hits(&solid, &line, Span::new(-f64::MAX, f64::INFINITY).unwrap());
        let mut back = hits(&solid, &Line { d: -line.d, ..line }, Span::new(-f64::MAX, f64::INFINITY).unwrap());
        for hit in &mut back {
            (hit.t, hit.entering) = (0.0 - hit.t, !hit.entering);
        }
        back.sort_by(super::winding::order);
        prop_assert_eq!(there, back);
    }

    /// Powers of two scale meshes and rays exactly.
    #[test]
    fn sizes_do_not_matter(mesh in closed_mesh(), aims in aims(), from in origin(), k in -300..300i32, j in -300..300i32) {
        let line = line_of(&mesh, aims, from, 3);
        let (size, speed) = (2f64.powi(k), 2f64.powi(j));
        let list = crossings(&solid(mesh.clone(), "bvh"), &line);
        let scaled = solid(mesh.moved(&Affine::scaling(Vec3::splat(size))), "bvh");
        let other = crossings(&scaled, &Line::exact(line.o * size, line.d * size * speed));
        prop_assert_eq!(list.len(), other.len());
        for (a, b) in list.iter().zip(&other) {
            prop_assert_eq!((a.t, a.t_err, a.primitive), (b.t * speed, b.t_err * speed, b.primitive));
        }
    }

    /// Membership by winding number agrees with the crossings of any line through the point that does not run in a
    /// face.
    #[test]
    fn points_inside_lie_between_an_entry_and_an_exit(
        mesh in closed_mesh(), from in prop::array::uniform3(-6.0..6.0f64), aims in aims(),
    ) {
        let line = line_of(&mesh, aims, from, 3);
        let solid = solid(mesh, "bvh");
        for (i, pair) in crossings(&solid, &line).windows(2).enumerate() {
            let room = pair[1].t - pair[0].t;
            if room > 1e-6 {
                prop_assert_eq!(solid.contains(line.at(pair[0].t + 0.414 * room)), i % 2 == 0);
            }
        }
    }

    /// An open sheet is hit exactly once, wherever the ray hits it; the nearest hit is the first of all.
    #[test]
    fn a_sheet_is_hit_once(
        facing in affine_strategy(), aims in aims(), from in prop::array::uniform3(-6.0..6.0f64), tilt in any::<bool>(),
    ) {
        let mesh = if tilt { sheet(4).moved(&facing) } else { sheet(4) };
        let inner = mesh.corners(10).into_iter().chain(mesh.corners(13)).collect::<Vec<_>>();
        let p = inner[aims[0].0.index(inner.len())];
        let line = Line::exact(Vec3::from(from), p - Vec3::from(from));
        let normal = (mesh.corners(0)[1] - mesh.corners(0)[0]).cross(mesh.corners(0)[2] - mesh.corners(0)[0]);
        prop_assume!(line.d.length() > 0.1 && normal.normalize().dot(line.d.normalize()).abs() > 1e-2);
        for name in accel::NAMES {
            let solid = solid(mesh.clone(), name);
            prop_assert!(!solid.is_closed());
            let all = hits(&solid, &line, Span::FORWARD);
            prop_assert_eq!(all.len(), 1);
            prop_assert!((all[0].t - 1.0).abs() <= 1e-11);
            prop_assert_eq!(all[0].entering, normal.dot(line.d) < 0.0);
            prop_assert_eq!(solid.nearest(&line, Span::FORWARD, &mut Scratch::default()), Some(all[0]));
            prop_assert!(solid.nearest(&line, Span::FORWARD, &mut Scratch::default()).is_some());
        }
    }
}

#[test]
fn the_normal_points_out_also_where_faces_are_wound_inward() {
    for mesh in [ball(2), ball(2).inside_out()] {
        let solid = solid(mesh, "bvh");
        let line = Line::exact(Vec3::new(0.1, 0.2, -3.0), Vec3::Z);
        let list = crossings(&solid, &line);
        assert_eq!(list.len(), 2);
        for c in list {
            let p = line.at(c.t);
            assert_eq!(solid.normal(p, 0, c.primitive).z < 0.0, c.entering);
            assert!(solid.implicit(p * 0.9, 0, c.primitive) < 0.0);
            assert!(solid.implicit(p * 1.1, 0, c.primitive) > 0.0);
        }
    }
}

/// Vertices that are repeated for each face, as in STL files, change nothing.
#[test]
fn separate_triangles_are_hit_like_a_mesh() {
    let (mesh, line) = (ring(9, 5), Line::exact(Vec3::new(-5.0, 0.1, 0.2), Vec3::X));
    let (a, b) = (solid(mesh.unwelded(), "bvh"), solid(mesh, "bvh"));
    assert!(a.is_closed());
    assert_eq!(crossings(&a, &line), crossings(&b, &line));
    assert_eq!(crossings(&a, &line).len(), 4);
}

#[test]
fn an_unknown_accelerator_is_named() {
    let error = MeshSolid::new(Arc::new(ball(0)), "hbv").unwrap_err().to_string();
    assert!(error.contains("'hbv'") && error.contains("brute"), "{error}");
}

#[test]
fn barycentric_coordinates_give_the_point_back() {
    let mesh = ball(1);
    let solid = solid(mesh.clone(), "bvh");
    let line = Line::exact(Vec3::new(0.3, 0.2, 3.0), Vec3::new(0.0, 0.1, -1.0));
    for c in crossings(&solid, &line) {
        let p = line.at(c.t);
        let [v, w] = solid.barycentric(p, c.primitive).unwrap();
        let [a, b, c] = mesh.corners(c.primitive);
        assert!((a * (1.0 - v - w) + b * v + c * w - p).length() < 1e-15);
        assert!(v > 0.0 && w > 0.0 && v + w < 1.0);
    }
}

/// Where a face on one side of an edge is split and that on the other is not, modellers leave a triangle without area.
/// A ray aimed at it gets a `t` on it, and the surface is closed.
#[test]
fn triangles_without_area_are_met_where_they_are() {
    let (a, b) = (Vec3::new(0.1, -0.3, 0.7), Vec3::new(1.1, 1.7, 3.7));
    let vertices = vec![a, b, Vec3::new(2.0, -1.0, 1.0), Vec3::new(-2.0, 1.0, 2.0), 0.5 * (a + b)];
    let faces = vec![[0, 2, 4], [4, 2, 1], [0, 4, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    let solid = solid(TriangleMesh::new(vertices, faces), "bvh");
    assert!(solid.is_closed());
    let (o, mut met) = (Vec3::new(0.3, 0.7, -20.0), 0);
    for k in 1..1000 {
        let aim = a + (b - a) * (f64::from(k) / 1000.0);
        for c in crossings(&solid, &Line::exact(o, aim - o)) {
            if c.primitive == 2 {
                met += 1;
                assert!((c.t - 1.0).abs() <= c.t_err && c.t_err < 1e-11, "{c:?}");
            }
        }
    }
    assert!(met > 0);
}

#[test]
fn extreme_rays_have_an_answer() {
    let solid = solid(ball(2), "bvh");
    let count = |o: Vec3, d: Vec3| {
        let mut out = Vec::new();
        solid.crossings(&Line::exact(o, d), &mut out);
        assert!(is_alternating(&out));
        out.len()
    };
    let o = Vec3::new(0.1, 0.2, -3.0);
    assert_eq!(count(o, Vec3::Z * 1e-300), 2);
    assert_eq!(count(o, Vec3::Z * f64::from_bits(1)), 2);
    assert_eq!(count(o, Vec3::new(1e-310, -0.0, f64::MAX)), 2);
    assert_eq!(count(Vec3::new(0.1, 0.2, -1e140), Vec3::Z), 2);
    assert_eq!(count(Vec3::splat(f64::MAX), Vec3::splat(-f64::MAX)), 0);
    assert_eq!(count(o, Vec3::ZERO), 0);
    assert_eq!(count(o, Vec3::NAN), 0);
}
