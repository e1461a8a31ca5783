//! Rays aimed at edges and vertices of closed meshes. All coordinates lie on a dyadic grid, so that the rays pass
//! exactly through the targets.
//!
//! For a mesh without self-intersections, the hits of a ray from outside alternate between entries and exits and
//! are even in number. From a point inside there is one more exit. A single leak or duplicate breaks that. From
//! the far end the list must be mirrored, and the list must be independent of the accelerator.

use std::sync::Arc;

use shotline::crossing::{Crossing, is_alternating};
use shotline::math::Vec3;
use shotline::ray::{Line, Span};
use shotline::scratch::Scratch;
use shotline::solid::Solid;
use shotline::solid::mesh::{MeshSolid, TriangleMesh};
use shotline::testkit::meshes::{cuboid, hollow, tray};
use shotline::testkit::random::Random;

use super::Tally;

/// Coordinates are multiples of this, so that differences and small multiples are exact.
const GRID: f64 = 1.0 / (1 << 20) as f64;

/// A mesh with its accelerated and its brute-force solid.
struct Pair {
    mesh: Arc<TriangleMesh>,
    fast: MeshSolid,
    brute: MeshSolid,
    /// A point inside the mesh.
    inside: Vec3,
    convex: bool,
}

/// The meshes under test.
pub struct Meshes(Vec<Pair>);

impl Meshes {
    /// Balls, rings, a cube, a hollow cube and a tray with thin walls, near the origin and far from it.
    pub fn new() -> Meshes {
        let mut pairs = Vec::new();
        for shift in [Vec3::ZERO, Vec3::new(1000.0, -2000.0, 500.0), Vec3::new(-1e6, 3e5, 1e6)] {
            let wall = 4.0 * GRID;
            let in_the_floor = Vec3::new(0.5, 0.5, 0.5 * wall);
            let box_with_cavity = hollow(cuboid(Vec3::ZERO, Vec3::ONE), wall);
            pairs.push(Pair::new(box_with_cavity, shift, in_the_floor, false));
            pairs.push(Pair::new(tray(wall), shift, in_the_floor, false));
            pairs.push(Pair::new(surface(24, 12, ball), shift, Vec3::ZERO, false));
            pairs.push(Pair::new(surface(20, 16, ring), shift, Vec3::new(2.0, 0.0, 0.0), false));
            pairs.push(Pair::new(cube(), shift, Vec3::ZERO, true));
        }
        Meshes(pairs)
    }

    /// Tests the given number of rays.
    pub fn run(&self, random: &mut Random, rays: u64, tally: &mut Tally) {
        let mut lists = Lists::default();
        for i in 0..rays {
            let pair = &self.0[random.below(self.0.len())];
            let (o, d) = pair.ray(random);
            tally.rays += 1;
            if let Err(why) = pair.check(o, d, i % 16 == 0, &mut lists) {
                if why.allowed_in_face && pair.runs_in_a_face(o, d) {
                    tally.undecidable += 1;
                    continue;
                }
                let faces = pair.mesh.faces.len();
                tally.fail(format!("{faces} faces, from {o} along {d}: {}: {:?}", why.what, lists.all));
            }
            tally.crossings += lists.all.len() as u64;
        }
    }
}

/// What is wrong with a list.
struct Wrong {
    what: String,
    /// Whether it is allowed for a ray that runs in a face, where the ray is in and out at once.
    allowed_in_face: bool,
}

impl Wrong {
    fn plainly(what: String) -> Wrong {
        Wrong { what, allowed_in_face: false }
    }
}

/// Reused memory for the lists of one ray.
#[derive(Default)]
struct Lists {
    all: Vec<Crossing>,
    other: Vec<Crossing>,
}

impl Pair {
    fn new(mut mesh: TriangleMesh, shift: Vec3, inside: Vec3, convex: bool) -> Pair {
        mesh.vertices.iter_mut().for_each(|v| *v = snapped(*v) + shift);
        // No face uses these.
        mesh.vertices.extend([Vec3::splat(1e30), Vec3::NAN]);
        let mesh = Arc::new(mesh);
        let solid = |accel| MeshSolid::new(mesh.clone(), accel).expect("a mesh");
        let (fast, brute) = (solid("bvh"), solid("brute"));
        assert!(fast.is_closed() && fast.topology().signed_volume > 0.0);
        Pair { fast, brute, inside: inside + shift, convex, mesh }
    }

    /// Returns a ray from outside or inside that passes exactly through a vertex or a point of an edge. Some rays
    /// run along an edge or through two vertices.
    fn ray(&self, random: &mut Random) -> (Vec3, Vec3) {
        let corners = self.mesh.corners(random.below(self.mesh.faces.len()) as u32);
        let (a, b) = (corners[0], corners[1]);
        let target = match random.below(3) {
            0 => a,
            1 => a + (b - a) * (random.below(9) as f64 / 8.0),
            _ => a + (b - a) * (random.below(1025) as f64 / 1024.0),
        };
        let d = match random.below(8) {
            0 => target - self.inside,
            1 => b - a,
            2 => target - self.mesh.corners(random.below(self.mesh.faces.len()) as u32)[0],
            3 => Vec3::AXES[random.below(3)],
            _ => snapped(random.point(-1.0, 1.0)),
        };
        let d = if d == Vec3::ZERO { Vec3::X } else { d };
        if random.below(8) == 0 && target != self.inside {
            return (self.inside, target - self.inside);
        }
        // Far enough to be outside. A power of two, so that it is exact.
        let steps = (12.0 / d.length()).log2().ceil().exp2();
        (target - d * steps, d)
    }

    fn check(&self, o: Vec3, d: Vec3, slowly: bool, lists: &mut Lists) -> Result<(), Wrong> {
        let line = Line::exact(o, d);
        let whole = Span::new(-f64::MAX, f64::INFINITY).expect("an interval");
        let mut work = Scratch::default();
        let hits =
            |solid: &MeshSolid, line: &Line, span: Span, out: &mut Vec<Crossing>, work: &mut Scratch| {
                out.clear();
                solid.hits(line, span, out, work);
            };
        hits(&self.fast, &line, whole, &mut lists.all, &mut work);
        check_winding(&lists.all, 0)?;
        if o == self.inside {
            hits(&self.fast, &line, Span::FORWARD, &mut lists.other, &mut work);
            check_winding(&lists.other, 1)?;
        }
        lists.other.clear();
        self.fast.crossings(&line, &mut lists.other);
        if !is_alternating(&lists.other) || lists.other.iter().any(|c| !c.t.is_finite()) {
            return Err(Wrong::plainly(format!("does not alternate: {:?}", lists.other)));
        }
        if self.convex && folded(&lists.other).count() > 2 {
            return Err(Wrong::plainly(format!("a convex mesh met more than twice: {:?}", lists.other)));
        }
        let far = Line::exact(o + d * FAR, -d);
        let count = folded(&lists.other).count();
        let mirrored: Vec<f64> = folded(&lists.other).map(|c| FAR - c.t).collect();
        lists.other.clear();
        self.fast.crossings(&far, &mut lists.other);
        let back: Vec<(f64, f64)> = folded(&lists.other).map(|c| (c.t, c.t_err)).collect();
        let near = |(t, err): &(f64, f64), m: &f64| (t - m).abs() <= 16.0 * err + 1e-15 * FAR;
        if back.len() != count || !back.iter().rev().zip(&mirrored).all(|(b, m)| near(b, m)) {
            return Err(Wrong { what: format!("not mirrored: {:?}", lists.other), allowed_in_face: true });
        }
        if slowly {
            hits(&self.brute, &line, whole, &mut lists.other, &mut work);
            if lists.other != lists.all {
                return Err(Wrong::plainly(format!("not the hits of every triangle: {:?}", lists.other)));
            }
        }
        Ok(())
    }
}

impl Pair {
    /// Whether the ray lies in the plane of some face, exactly or within rounding.
    fn runs_in_a_face(&self, o: Vec3, d: Vec3) -> bool {
        (0..self.mesh.faces.len() as u32).any(|face| {
            let [a, b, c] = self.mesh.corners(face);
            let n = (b - a).cross(c - a);
            let small = 1e-12 * n.length();
            n.dot(d).abs() <= small * d.length() && n.dot(a - o).abs() <= small * (a - o).length()
        })
    }
}

/// The `t` at which the reversed ray begins. A power of two, so that it passes exactly through the same points.
const FAR: f64 = 1024.0;

/// Checks that the winding number along the ray is always 0 or 1, as for a mesh without self-intersections.
/// Coincident hits are combined.
fn check_winding(hits: &[Crossing], before: i32) -> Result<(), Wrong> {
    let mut winding = before;
    for together in hits.chunk_by(|a, b| b.t - a.t <= 8.0 * (a.t_err + b.t_err)) {
        winding += together.iter().map(|c| if c.entering { 1 } else { -1 }).sum::<i32>();
        if !(0..=1).contains(&winding) {
            return Err(Wrong::plainly(format!("{winding} times inside after t = {}", together[0].t)));
        }
    }
    if winding == 0 { Ok(()) } else { Err(Wrong::plainly(format!("{winding} times inside at the end"))) }
}

/// Crossings without coincident pairs.
fn folded(list: &[Crossing]) -> impl Iterator<Item = &Crossing> {
    list.chunk_by(|a, b| b.t - a.t <= 8.0 * (a.t_err + b.t_err)).filter(|c| c.len() % 2 == 1).map(|c| &c[0])
}

fn snapped(v: Vec3) -> Vec3 {
    (v / GRID).round() * GRID
}

fn ball(a: f64, b: f64) -> Vec3 {
    Vec3::new(b.sin() * a.cos(), b.sin() * a.sin(), b.cos())
}

fn ring(a: f64, b: f64) -> Vec3 {
    let r = 2.0 + 0.75 * b.cos();
    Vec3::new(r * a.cos(), r * a.sin(), -0.75 * b.sin())
}

/// A closed surface over two angles. If a whole row is one point (a pole), some triangles there are degenerate.
fn surface(n: u32, m: u32, at: impl Fn(f64, f64) -> Vec3) -> TriangleMesh {
    use std::f64::consts::{PI, TAU};
    let pole = snapped(at(0.0, 0.0)) == snapped(at(1.0, 0.0));
    let (rows, turn) = if pole { (m + 1, PI) } else { (m, TAU) };
    let mut mesh = TriangleMesh::default();
    for i in 0..n {
        for j in 0..rows {
            let (a, b) = (f64::from(i) / f64::from(n) * TAU, f64::from(j) / f64::from(m) * turn);
            mesh.vertices.push(snapped(at(a, b)));
        }
    }
    let number = |i: u32, j: u32| (i % n) * rows + j % rows;
    for i in 0..n {
        for j in 0..m {
            let (p, q) = (number(i, j), number(i, j + 1));
            let (r, s) = (number(i + 1, j + 1), number(i + 1, j));
            mesh.faces.extend([[p, q, r], [p, r, s]]);
        }
    }
    mesh
}

fn cube() -> TriangleMesh {
    let vertices =
        (0..8).map(|i| Vec3::from([0, 1, 2].map(|k| f64::from((i >> k) & 1) * 2.0 - 1.0))).collect();
    let squares = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let faces = squares.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    TriangleMesh::new(vertices, faces)
}
