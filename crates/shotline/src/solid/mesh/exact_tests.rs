//! Crossings compared with exact arithmetic: meshes and rays of small integers, where all results are fractions.

use std::sync::Arc;

use super::shapes::{ball, cubes, ring};
use super::{MeshSolid, TriangleMesh};
use crate::crossing::{Crossing, are_coincident, is_alternating};
use crate::math::{Affine, Dd, HALF_ULP, Vec3, two_prod};
use crate::ray::{Line, Span};
use crate::scratch::Scratch;
use crate::solid::Solid;
use crate::testkit::random::Random;

type Point = [i64; 3];

fn minus(a: Point, b: Point) -> Point {
    std::array::from_fn(|i| a[i] - b[i])
}

fn cross(a: Point, b: Point) -> Point {
    std::array::from_fn(|i| a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3])
}

fn dot(a: Point, b: Point) -> i64 {
    (0..3).map(|i| a[i] * b[i]).sum()
}

fn real(p: Point) -> Vec3 {
    Vec3::from(p.map(|x| x as f64))
}

/// A mesh with integer coordinates.
#[derive(Clone)]
struct Whole {
    vertices: Vec<Point>,
    faces: Vec<[u32; 3]>,
}

impl Whole {
    /// A mesh of reals, enlarged and rounded. It stays closed; all coordinates are even.
    fn rounded(mesh: &TriangleMesh, size: f64) -> Whole {
        let even = |x: f64| 2 * (x * size * 0.5).round() as i64;
        let vertices = mesh.vertices.iter().map(|v| v.to_array().map(even)).collect();
        Whole { vertices, faces: mesh.faces.clone() }
    }

    fn moved(mut self, by: Point) -> Whole {
        self.vertices.iter_mut().for_each(|v| *v = std::array::from_fn(|i| v[i] + by[i]));
        self
    }

    fn with(mut self, other: &Whole) -> Whole {
        let offset = self.vertices.len() as u32;
        self.vertices.extend(&other.vertices);
        self.faces.extend(other.faces.iter().map(|face| face.map(|v| v + offset)));
        self
    }

    fn inside_out(mut self) -> Whole {
        self.faces.iter_mut().for_each(|face| face.swap(1, 2));
        self
    }

    fn real(&self) -> TriangleMesh {
        TriangleMesh::new(self.vertices.iter().copied().map(real).collect(), self.faces.clone())
    }

    fn corners(&self, face: usize) -> [Point; 3] {
        self.faces[face].map(|v| self.vertices[v as usize])
    }

    /// A corner, the middle of an edge, or a point of a face.
    fn aim(&self, random: &mut Random) -> Point {
        let [a, b, c] = self.corners(random.below(self.faces.len()));
        match random.below(3) {
            0 => a,
            1 => std::array::from_fn(|i| (a[i] + b[i]) / 2),
            _ => std::array::from_fn(|i| (a[i] + b[i] + 2 * c[i]) / 4),
        }
    }

    /// All hits of the line; `None` if it meets an edge or runs in the plane of a face.
    fn exact_hits(&self, o: Point, d: Point) -> Option<Vec<ExactHit>> {
        let mut hits = Vec::new();
        for face in 0..self.faces.len() {
            let [a, b, c] = self.corners(face).map(|v| minus(v, o));
            let sides = [dot(d, cross(b, c)), dot(d, cross(c, a)), dot(d, cross(a, b))].map(i64::signum);
            if sides.contains(&1) && sides.contains(&-1) {
                continue;
            }
            if sides.contains(&0) {
                return None;
            }
            let normal = cross(minus(b, a), minus(c, a));
            let (num, den) = (dot(normal, a), dot(normal, d));
            let entering = den < 0;
            hits.push(ExactHit { face: face as u32, entering, num: num * den.signum(), den: den.abs() });
        }
        hits.sort_by(|a, b| a.compare(b).then(a.face.cmp(&b.face)));
        Some(hits)
    }
}

/// A hit at `num / den`.
#[derive(Clone, Copy, Debug)]
struct ExactHit {
    face: u32,
    entering: bool,
    num: i64,
    den: i64,
}

impl ExactHit {
    fn compare(&self, other: &ExactHit) -> std::cmp::Ordering {
        let product = |a: i64, b: i64| i128::from(a) * i128::from(b);
        product(self.num, other.den).cmp(&product(other.num, self.den))
    }

    /// The error of a `t`. Numerator and denominator have fewer than 53 bits, so no digit is lost.
    fn error_of(&self, t: f64) -> f64 {
        assert!(self.num.abs().max(self.den) < 1 << 53);
        ((two_prod(t, self.den as f64) - Dd::from(self.num as f64)).hi / self.den as f64).abs()
    }
}

/// The crossings: where the winding number, which begins at zero, leaves zero and returns to it.
fn exact_crossings(hits: &[ExactHit]) -> Vec<(ExactHit, bool)> {
    let (mut winding, mut out) = (0, Vec::new());
    for event in hits.chunk_by(|a, b| a.compare(b).is_eq()) {
        let before = winding;
        winding += event.iter().map(|h| if h.entering { 1 } else { -1 }).sum::<i32>();
        if (before == 0) != (winding == 0) {
            out.push((event[0], winding != 0));
        }
    }
    assert_eq!(winding, 0);
    out
}

fn solid(mesh: TriangleMesh) -> MeshSolid {
    let solid = MeshSolid::new(Arc::new(mesh), "bvh").unwrap();
    assert!(solid.is_closed());
    solid
}

fn crossings(solid: &MeshSolid, line: &Line) -> Vec<Crossing> {
    let mut out = Vec::new();
    solid.crossings(line, &mut out);
    assert!(is_alternating(&out) && out.iter().all(|c| c.t.is_finite()), "{out:?}");
    // Events of an even number of crossings change nothing.
    let mut folded = Vec::new();
    for event in out.chunk_by(are_coincident) {
        if event.len() % 2 == 1 {
            folded.push(Crossing { entering: folded.len() % 2 == 0, ..event[0] });
        }
    }
    folded
}

/// Round meshes, one with a hole, blocks that meet along edges, nested shells wound either way, balls that pass through
/// each other, and a shell inside out beside one that is not.
fn meshes() -> Vec<Whole> {
    let block = |places: &[[i32; 3]]| Whole::rounded(&cubes(places), 48.0);
    let (large, small) = (Whole::rounded(&ball(2), 100.0), Whole::rounded(&ball(1), 40.0));
    let shapes = vec![
        block(&[[0, 0, 0]]),
        block(&[[0, 0, 0], [1, 0, 0], [1, 1, 1], [-1, 0, 0], [-1, -1, 0]]),
        block(&[[0, 0, 0]]).with(&block(&[[1, 0, 0]])),
        Whole::rounded(&ring(9, 5), 40.0),
        large.clone(),
        large.clone().with(&small),
        large.clone().with(&small.clone().inside_out()),
        large.clone().with(&large.clone().moved([70, 12, -8])),
        small.clone().moved([60, 0, 0]).with(&small.inside_out().moved([-60, 10, 0])),
    ];
    let inward: Vec<Whole> = shapes.iter().cloned().map(Whole::inside_out).collect();
    let far: Vec<Whole> =
        shapes.iter().cloned().map(|m| m.moved([100_000_000, -90_000_000, 70_000_000])).collect();
    [shapes, inward, far].concat()
}

/// The origin and direction of a ray from around a mesh to a target, sometimes from far away along the line.
fn origin(random: &mut Random, mesh: &Whole, aim: Point) -> (Point, Point) {
    let middle = mesh.vertices[0];
    let o: Point = std::array::from_fn(|i| middle[i] + random.below(601) as i64 - 300);
    let d = minus(aim, o);
    let back = if random.below(3) == 0 { random.below(10_000) as i64 } else { 0 };
    (std::array::from_fn(|i| o[i] - back * d[i]), d)
}

/// For lines that avoid edges and corners: the same triangles, every `t` correctly rounded or nearly, within its bound.
#[test]
fn lists_agree_with_fractions() {
    let mut random = Random::new(1);
    let (mut rays, mut met, mut tight) = (0, 0, 0);
    for mesh in meshes() {
        let solid = solid(mesh.real());
        for _ in 0..400 {
            let target: Point = std::array::from_fn(|i| mesh.vertices[0][i] + random.below(241) as i64 - 120);
            let (o, d) = origin(&mut random, &mesh, target);
            let Some(exact) = mesh.exact_hits(o, d).filter(|_| d != [0; 3]) else { continue };
            let line = Line::exact(real(o), real(d));
            let mut hits = Vec::new();
            solid.hits(
                &line,
                Span::new(-f64::MAX, f64::INFINITY).unwrap(),
                &mut hits,
                &mut Scratch::default(),
            );
            hits.sort_by_key(|h| h.primitive);
            let mut by_face = exact.clone();
            by_face.sort_by_key(|h| h.face);
            assert_eq!(hits.len(), by_face.len(), "{o:?} {d:?}");
            for (hit, exact) in hits.iter().zip(&by_face) {
                assert_eq!((hit.primitive, hit.entering), (exact.face, exact.entering));
                let error = exact.error_of(hit.t);
                assert!(error <= 1.001 * HALF_ULP * hit.t.abs() && error <= hit.t_err, "{hit:?} {error}");
                tight += usize::from(hit.t_err <= 4.0 * HALF_ULP * hit.t.abs());
            }
            let list = crossings(&solid, &line);
            let exact = exact_crossings(&exact);
            assert_eq!(list.len(), exact.len(), "{o:?} {d:?}");
            for (c, (exact, entering)) in list.iter().zip(&exact) {
                assert!(exact.error_of(c.t) <= c.t_err && c.entering == *entering, "{c:?} {exact:?}");
            }
            (rays, met) = (rays + 1, met + hits.len());
        }
    }
    assert!(rays > 9_000 && met > 7_000 && 100 * tight > 99 * met, "{rays} {met} {tight}");
}

/// The winding number at a point by the solid angles of all faces (A. van Oosterom and J. Strackee 1983);
/// `None` on the surface, where it is not an integer.
fn winding(mesh: &TriangleMesh, p: Vec3) -> Option<i32> {
    let angle = |face: &[u32; 3]| {
        let [a, b, c] = face.map(|v| mesh.vertices[v as usize] - p);
        let (x, y, z) = (a.length(), b.length(), c.length());
        let below = x * y * z + a.dot(b) * z + b.dot(c) * x + c.dot(a) * y;
        let above = a.dot(b.cross(c));
        // In a face and on its edges the angle jumps between the sides.
        if above.abs().max(below) < 1e-9 * x * y * z { f64::NAN } else { 2.0 * above.atan2(below) }
    };
    let turns = mesh.faces.iter().map(angle).sum::<f64>() / (4.0 * std::f64::consts::PI);
    ((turns - turns.round()).abs() < 1e-3).then_some(turns.round() as i32)
}

/// For lines aimed at corners, middles of edges and faces: nothing leaks or counts twice, and the reverse agrees.
#[test]
fn aimed_lists_agree_with_solid_angles_from_both_ends() {
    let (mut random, mut checked, mut mirrored) = (Random::new(2), 0, 0);
    for mesh in meshes() {
        let solid = solid(mesh.real());
        // Points on a line and angles are computed near the origin, where rounding is small.
        let home = mesh.vertices[0].map(|x| -x);
        let whole = mesh.clone().moved(home).real();
        for _ in 0..150 {
            let p = mesh.aim(&mut random);
            let q = mesh.aim(&mut random);
            let (o, d) = if random.below(2) == 0 { (p, minus(q, p)) } else { origin(&mut random, &mesh, p) };
            if d == [0; 3] {
                continue;
            }
            let line = Line::exact(real(o), real(d));
            let list = crossings(&solid, &line);
            let local = |p: Point, d: Vec3| Line::exact(real(std::array::from_fn(|i| p[i] + home[i])), d);
            let at_home = local(o, line.d);
            let ends = whole.vertices.iter().map(|v| (*v - at_home.o).dot(line.d) / line.d.length_squared());
            let (low, high) = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), t| (l.min(t), h.max(t)));
            for _ in 0..12 {
                let t = random.number(low, high);
                if list.iter().all(|c| (c.t - t).abs() > 1e-3 * (high - low))
                    && let Some(winding) = winding(&whole, at_home.at(t))
                {
                    let inside = list.iter().filter(|c| c.t < t).count() % 2 == 1;
                    assert_eq!(inside, winding != 0, "{o:?} {d:?} at {t}: {list:?}");
                    checked += 1;
                }
            }
            let there = 7;
            let end: Point = std::array::from_fn(|i| o[i] + there * d[i]);
            let backward = Line::exact(real(end), -real(d));
            let back = crossings(&solid, &backward);
            // Where the line runs along a face or an edge, the result of either side is valid.
            let on_surface = |list: &[Crossing], line: &Line| {
                let mut middles = list.windows(2).map(|w| line.at(0.5 * w[0].t + 0.5 * w[1].t));
                middles.any(|p| winding(&whole, p).is_none())
            };
            if on_surface(&list, &at_home) || on_surface(&back, &local(end, backward.d)) {
                continue;
            }
            mirrored += 1;
            assert_eq!(back.len(), list.len(), "{o:?} {d:?}");
            for (a, b) in list.iter().zip(back.iter().rev()) {
                let (sum, bound) = (a.t + b.t, a.t_err + b.t_err + 2.0 * f64::EPSILON * there as f64);
                assert!((sum - there as f64).abs() <= bound && a.entering != b.entering, "{a:?} {b:?}");
            }
        }
    }
    assert!(checked > 25_000 && mirrored > 2_500, "{checked} {mirrored}");
}

/// Also if they are tiny, or far away for their size.
#[test]
fn convex_meshes_are_crossed_twice_or_not_at_all() {
    let mut random = Random::new(3);
    let shapes = [cubes(&[[0, 0, 0]]), ball(0), ball(1), ball(3)];
    for (shape, k) in shapes.iter().flat_map(|shape| [(shape, 0), (shape, -900), (shape, 300)]) {
        let size = 2f64.powi(k);
        for far in [0.0, 1e6] {
            // The move rounds the vertices.
            let place = Affine::translation(Vec3::new(far, -far, 0.5 * far));
            let mesh = shape.clone().moved(&place).moved(&Affine::scaling(Vec3::splat(size)));
            let solid = solid(mesh.clone());
            let mut met = 0;
            for _ in 0..300 {
                let [a, b, c] = mesh.corners(random.below(mesh.faces.len()) as u32);
                let aim = [a, 0.5 * a + 0.5 * b, 0.25 * a + 0.25 * b + 0.5 * c][random.below(3)];
                let o = place.point(random.point(-4.0, 4.0)) * size;
                let list = crossings(&solid, &Line::exact(o, aim - o));
                assert!(list.is_empty() || list.len() == 2, "{list:?}");
                met += list.len() / 2;
            }
            assert!(met > 100, "{met}");
        }
    }
}
