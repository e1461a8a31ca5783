//! Meshes with thin walls compared to exact arithmetic, at any distance from the origin and from any start of the
//! ray.

use num_rational::BigRational;
use num_traits::{Signed, Zero};

use super::*;
use crate::aabb::Aabb;
use crate::accel;
use crate::math::HALF_ULP;
use crate::ray::Line;
use crate::solid::mesh::MeshSolid;
use crate::testkit::agreement::{check_scene, spans_of};
use crate::testkit::meshes::{Thin, cuboid, joined, rays_at};

type Exact = [BigRational; 3];

fn number(x: f64) -> BigRational {
    BigRational::from_float(x).expect("finite")
}

fn exact(v: Vec3) -> Exact {
    v.to_array().map(number)
}

fn minus(a: &Exact, b: &Exact) -> Exact {
    std::array::from_fn(|i| &a[i] - &b[i])
}

fn cross(a: &Exact, b: &Exact) -> Exact {
    std::array::from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        &a[j] * &b[k] - &a[k] * &b[j]
    })
}

fn dot(a: &Exact, b: &Exact) -> BigRational {
    (0..3).map(|i| &a[i] * &b[i]).fold(BigRational::zero(), |sum, x| sum + x)
}

/// Whether rounded arithmetic proves that a line misses a triangle.
fn surely_missed(corners: [Vec3; 3], o: Vec3, d: Vec3) -> bool {
    let [a, b, c] = corners.map(|v| v - o);
    let side = |p: Vec3, q: Vec3| (d.dot(p.cross(q)), 1e-13 * d.length() * p.length() * q.length());
    let sides = [side(b, c), side(c, a), side(a, b)];
    sides.iter().any(|(s, err)| s > err) && sides.iter().any(|(s, err)| *s < -err)
}

/// Where a line crosses the faces of a mesh, with the change of the winding number there; `None` if it hits an edge
/// or runs in a face.
fn exact_hits(mesh: &TriangleMesh, ray: &Ray) -> Option<Vec<(BigRational, i32)>> {
    let (o, d) = (exact(ray.origin()), exact(ray.direction()));
    let mut hits = Vec::new();
    for face in 0..mesh.faces.len() as u32 {
        if surely_missed(mesh.corners(face), ray.origin(), ray.direction()) {
            continue;
        }
        let [a, b, c] = mesh.corners(face).map(|v| minus(&exact(v), &o));
        let sides = [(&b, &c), (&c, &a), (&a, &b)].map(|(p, q)| dot(&d, &cross(p, q)));
        if sides.iter().any(|s| s.is_positive()) && sides.iter().any(|s| s.is_negative()) {
            continue;
        }
        if sides.iter().any(|s| s.is_zero()) {
            return None;
        }
        let normal = cross(&minus(&b, &a), &minus(&c, &a));
        hits.push((dot(&normal, &a) / dot(&normal, &d), if sides[0].is_negative() { 1 } else { -1 }));
    }
    hits.sort();
    Some(hits)
}

/// Where the line enters and leaves the inside.
fn exact_crossings(hits: &[(BigRational, i32)]) -> Vec<(BigRational, bool)> {
    let (mut winding, mut out) = (0, Vec::new());
    for event in hits.chunk_by(|a, b| a.0 == b.0) {
        let before = winding;
        winding += event.iter().map(|hit| hit.1).sum::<i32>();
        if (before == 0) != (winding == 0) {
            out.push((event[0].0.clone(), winding != 0));
        }
    }
    assert_eq!(winding, 0);
    out
}

/// The expected list of a span: the exact `t`, whether the ray enters, and the kind.
fn expected(all: &[(BigRational, bool)], span: Span) -> Vec<(BigRational, bool, HitKind)> {
    let (t_min, t_max) = (number(span.t_min()), span.t_max());
    let ends = |t: &BigRational| t_max.is_finite() && *t > number(t_max);
    let (mut rows, mut inside) = (Vec::new(), false);
    let before = all.iter().filter(|(t, _)| *t < t_min).count();
    let began_inside = before % 2 == 1;
    let at_start = all.get(before).filter(|(t, _)| *t == t_min);
    if began_inside && at_start.is_none() {
        rows.push((t_min, true, HitKind::Start));
        inside = true;
    }
    for (t, entering) in all[before..].iter().filter(|(t, _)| !ends(t)) {
        if !(began_inside && at_start.is_some_and(|(start, _)| start == t)) {
            rows.push((t.clone(), *entering, HitKind::Surface));
        }
        inside = *entering;
    }
    if inside {
        rows.push((number(t_max), false, HitKind::End));
    }
    rows
}

/// Whether hits coincide, by their bounds, with each other or with an end of the span, but not exactly. `reach` is
/// the distance of the mesh's farthest corner in lengths of the direction.
fn is_close(hits: &[(BigRational, i32)], span: Span, reach: f64) -> bool {
    let ends = [span.t_min(), span.t_max()].into_iter().filter(|t| t.is_finite()).map(number);
    let mut places: Vec<BigRational> = hits.iter().map(|hit| hit.0.clone()).chain(ends).collect();
    places.sort();
    places.windows(2).any(|pair| {
        let gap = &pair[1] - &pair[0];
        let size = pair.iter().map(|t| t.abs()).max().unwrap_or_default();
        !gap.is_zero() && gap < size * number(17.0 * HALF_ULP) + number(reach * HALF_ULP / 16.0)
    })
}

/// Spans that begin at crossings or between them, and end between them.
fn spans(world: &World, ray: &Ray) -> Vec<Span> {
    let whole = Span::new(-1e15, f64::INFINITY).expect("an interval");
    let ts: Vec<f64> = crossings(world, ray, whole).iter().map(|hit| hit.t).collect();
    let between: Vec<f64> = ts.windows(2).map(|w| 0.5 * w[0] + 0.5 * w[1]).collect();
    let ends = between.windows(2).map(|w| (w[0], w[1]));
    let begins = ts.iter().chain(&between).map(|t| (*t, f64::INFINITY));
    begins.chain(ends).chain([(0.0, f64::INFINITY)]).filter_map(|(a, b)| Span::new(a, b).ok()).collect()
}

#[test]
fn thin_walls_are_as_exact_arithmetic_says() {
    let mut random = Random::new(31);
    let (mut checked, mut rows, mut starts, mut thin_walls) = (0, 0, 0, 0);
    for case in 0..100 {
        let thin = Thin::any(&mut random);
        let mesh = thin.mesh(&mut random);
        let mut scene = Scene::default();
        let node = scene.add(Node::Mesh { mesh: Arc::new(mesh.clone()), file: None });
        scene.add_object("mesh", None, node);
        let world = world(&scene, "bvh");
        let bounds = Aabb::around((0..mesh.faces.len() as u32).flat_map(|face| mesh.corners(face)));
        let mut rays = Vec::new();
        for ray in rays_at(&mut random, &mesh, &thin, 16) {
            let Some(hits) = exact_hits(&mesh, &ray) else { continue };
            let all = exact_crossings(&hits);
            let o = ray.origin();
            let far = (bounds.min - o).abs().max((bounds.max - o).abs()).max_element();
            let reach = far / ray.direction().abs().max_element();
            let odd_spans = spans_of(&world, &ray);
            rays.push((ray, odd_spans[random.below(odd_spans.len())]));
            for span in spans(&world, &ray) {
                rays.push((ray, span));
                if is_close(&hits, span, reach)
                    || all.iter().any(|(t, _)| span.t_max().is_finite() && *t == number(span.t_max()))
                {
                    continue;
                }
                let (list, right) = (crossings(&world, &ray, span), expected(&all, span));
                let context = format!("case {case}, {thin:?}, {ray:?}, {span:?}\n{list:#?}\n{hits:?}");
                assert_eq!(list.len(), right.len(), "{context}");
                for (hit, (t, entering, kind)) in list.iter().zip(&right) {
                    assert_eq!((hit.entering, hit.kind), (*entering, *kind), "{context}");
                    assert!((number(hit.t) - t).abs() <= number(hit.t_err), "{context}");
                    let tight = 1.01 * HALF_ULP * hit.t.abs() + reach * HALF_ULP / 64.0;
                    assert!(hit.t_err <= tight, "{tight} {context}");
                    starts += usize::from(hit.kind == HitKind::Start);
                }
                let gaps = all.windows(2).map(|w| &w[1].0 - &w[0].0);
                thin_walls += gaps.filter(|gap| *gap < number(1e-6 * reach)).count();
                (checked, rows) = (checked + 1, rows + right.len());
            }
        }
        if case % 5 == 0 {
            assert!(check_scene(&scene, &rays));
        }
    }
    assert!(
        checked > 3_000 && rows > 4_000 && starts > 500 && thin_walls > 500,
        "{checked} {rows} {starts} {thin_walls}"
    );
}

/// All hits of a mesh on a line; every accelerator must return the same bits.
fn hits(mesh: &TriangleMesh, line: &Line) -> Vec<(u64, u64, bool)> {
    let mut lists = accel::NAMES.iter().map(|name| {
        let solid = MeshSolid::new(Arc::new(mesh.clone()), name).expect("a mesh");
        let mut list = Vec::new();
        crate::solid::Solid::crossings(&solid, line, &mut list);
        list.iter().map(|c| (c.t.to_bits(), c.t_err.to_bits(), c.entering)).collect::<Vec<_>>()
    });
    let first = lists.next().expect("brute");
    assert!(lists.all(|list| list == first), "{line:?}");
    first
}

/// Regression: the error bounds were computed from the largest coordinate of any vertex, so that a far vertex made
/// the mesh vanish.
#[test]
fn far_and_unused_vertices_change_no_bit() {
    let plain = cuboid(Vec3::new(0.1, 0.2, 0.3), Vec3::new(1.1, 1.2, 1.3));
    for odd in
        [Vec3::splat(1e14), Vec3::X * 1e16, Vec3::splat(1e30), Vec3::splat(1e300), Vec3::NAN, -Vec3::INFINITY]
    {
        let mut mesh = plain.clone();
        mesh.vertices.insert(3, odd);
        mesh.faces.iter_mut().flatten().filter(|v| **v >= 3).for_each(|v| *v += 1);
        for (o, d) in
            [(Vec3::new(0.5, 0.6, -1.0), Vec3::Z), (Vec3::new(-2.0, 0.7, 0.9), Vec3::new(3.0, -0.1, 0.03))]
        {
            let line = Line::exact(o, d);
            let list = hits(&plain, &line);
            assert!(list.len() == 2 && hits(&mesh, &line) == list, "{odd:?}");
        }
        let bounds = |mesh: &TriangleMesh| {
            crate::solid::Solid::bounds(&MeshSolid::new(Arc::new(mesh.clone()), "bvh").expect("a mesh"))
        };
        assert_eq!(bounds(&mesh), bounds(&plain));
    }
}

#[test]
fn shells_of_all_sizes_in_one_mesh_answer_as_each_alone() {
    // Side by side along x, each shell ten times as large as the one before.
    let shell = |k: i32| {
        let (size, middle) = (10f64.powi(k), Vec3::new(3.0 * 10f64.powi(k), 0.0, 0.0));
        let half = Vec3::new(0.5, 0.31, 0.43) * size;
        (cuboid(middle - half, middle + half), middle, size)
    };
    let all = (1..=15).fold(shell(0).0, |mesh, k| joined(mesh, &shell(k).0));
    let mut random = Random::new(32);
    let mut met = 0;
    for k in 0..=15 {
        let (alone, middle, size) = shell(k);
        for _ in 0..12 {
            // In a plane perpendicular to x, so that the line hits no other shell.
            let o = middle + Vec3::new(random.number(-0.4, 0.4), -2.0, random.number(-1.0, 1.0)) * size;
            let target = Vec3::new(o.x, 0.0, random.number(-0.4, 0.4) * size);
            let line = Line::exact(o, target - o);
            let list = hits(&alone, &line);
            assert_eq!(list, hits(&all, &line), "shell {k}: {line:?}");
            met += list.len();
        }
    }
    assert!(met > 300, "{met}");
}
