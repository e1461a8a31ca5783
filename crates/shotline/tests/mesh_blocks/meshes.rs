//! Meshes that are difficult for the kernel: thin, narrow, degenerate, overlapping, tiny and large ones.

use shotline::math::Vec3;
use shotline::solid::mesh::TriangleMesh;
use shotline::testkit::meshes::{Thin, annulus, cuboid, hollow, joined, tray};
use shotline::testkit::random::Random;

/// A family of meshes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    Tetrahedron,
    Cube,
    Ball,
    Plate,
    Nested,
    InsideOut,
    Overlapping,
    Coincident,
    Flaps,
    Star,
    Fan,
    Thin,
    Ring,
    Triangle,
    Sheet,
    Soup,
    Degenerate,
    Large,
    LargeSheet,
}

/// All families, the expensive ones last.
pub const FAMILIES: [Family; 19] = [
    Family::Tetrahedron,
    Family::Cube,
    Family::Ball,
    Family::Plate,
    Family::Nested,
    Family::InsideOut,
    Family::Overlapping,
    Family::Coincident,
    Family::Flaps,
    Family::Star,
    Family::Fan,
    Family::Thin,
    Family::Ring,
    Family::Triangle,
    Family::Sheet,
    Family::Soup,
    Family::Degenerate,
    Family::Large,
    Family::LargeSheet,
];

impl Family {
    /// A random mesh of the family, about one unit wide.
    pub fn mesh(self, random: &mut Random) -> TriangleMesh {
        match self {
            Family::Tetrahedron => tetrahedron(random),
            Family::Cube => cuboid(Vec3::splat(-0.5), Vec3::splat(0.5)),
            Family::Ball => ball(3 + random.below(16) as u32, 2 + random.below(12) as u32),
            Family::Plate => {
                cuboid(Vec3::ZERO, Vec3::new(1.0, 1.0, [1e-9, 1e-12, 1e-15, 1e-5][random.below(4)]))
            }
            Family::Nested => nested(random),
            Family::InsideOut => inside_out(some_closed(random)),
            Family::Overlapping => joined(some_closed(random), &moved(some_closed(random), random)),
            Family::Coincident => coincident(random),
            Family::Flaps => with_flaps(some_closed(random), random),
            Family::Star => star(random),
            Family::Fan => fan(200, random),
            Family::Thin => Thin::near(random).mesh(random),
            Family::Ring => {
                [annulus(20, 1e-3), tray(1e-6), hollow(ball(12, 6), 1e-4)][random.below(3)].clone()
            }
            Family::Triangle => soup(1 + random.below(5), 0.0, random),
            Family::Sheet => sheet(1 + random.below(12) as u32, random),
            Family::Soup => {
                let count = [7, 30, 300][random.below(3)];
                soup(count, [0.0, 1.0, 6.0][random.below(3)], random)
            }
            Family::Degenerate => with_degenerate_faces(some_closed(random), random),
            Family::Large => ball(50, 50),
            Family::LargeSheet => sheet(50, random),
        }
    }
}

fn some_closed(random: &mut Random) -> TriangleMesh {
    match random.below(4) {
        0 => tetrahedron(random),
        1 => cuboid(Vec3::splat(-0.5), Vec3::splat(0.5)),
        2 => ball(6, 4),
        _ => ball(11, 7),
    }
}

fn tetrahedron(random: &mut Random) -> TriangleMesh {
    let corners: [Vec3; 4] = std::array::from_fn(|_| random.point(-0.5, 0.5));
    TriangleMesh::new(corners.to_vec(), vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
}

/// A ball of meridians and circles of latitude, with a fan at each pole.
pub fn ball(meridians: u32, bands: u32) -> TriangleMesh {
    let mut mesh = TriangleMesh::new(vec![Vec3::new(0.0, 0.0, -0.5), Vec3::new(0.0, 0.0, 0.5)], Vec::new());
    for (band, i) in (1..bands).flat_map(|band| (0..meridians).map(move |i| (band, i))) {
        let (sin, cos) = (std::f64::consts::PI * f64::from(band) / f64::from(bands)).sin_cos();
        let (y, x) = (std::f64::consts::TAU * f64::from(i) / f64::from(meridians)).sin_cos();
        mesh.vertices.push(Vec3::new(x * sin, y * sin, -cos) * 0.5);
    }
    let at = |band: u32, i: u32| 2 + (band - 1) * meridians + i % meridians;
    for i in 0..meridians {
        mesh.faces.push([0, at(1, i + 1), at(1, i)]);
        mesh.faces.push([1, at(bands - 1, i), at(bands - 1, i + 1)]);
        for band in 1..bands - 1 {
            let (a, b) = (at(band, i), at(band, i + 1));
            let (c, d) = (at(band + 1, i + 1), at(band + 1, i));
            mesh.faces.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

fn inside_out(mut mesh: TriangleMesh) -> TriangleMesh {
    mesh.faces.iter_mut().for_each(|face| face.swap(0, 1));
    mesh
}

fn moved(mut mesh: TriangleMesh, random: &mut Random) -> TriangleMesh {
    let (by, factor) = (random.point(-0.4, 0.4), random.number(0.3, 1.2));
    mesh.vertices.iter_mut().for_each(|v| *v = *v * factor + by);
    mesh
}

fn nested(random: &mut Random) -> TriangleMesh {
    let outer = some_closed(random);
    let mut inner = outer.clone();
    let factor = [0.5, 1.0 - 1e-6, 1.0 - 1e-12, 1e-4][random.below(4)];
    inner.vertices.iter_mut().for_each(|v| *v *= factor);
    joined(outer, &if random.below(2) == 0 { inside_out(inner) } else { inner })
}

/// Shells with common faces: neighbours, the same shell twice, or a shell and its inverse.
fn coincident(random: &mut Random) -> TriangleMesh {
    let cube = cuboid(Vec3::ZERO, Vec3::splat(0.5));
    let neighbour = cuboid(Vec3::X * 0.5, Vec3::new(1.0, 0.5, 0.5));
    let ball = ball(8, 5);
    match random.below(4) {
        0 => joined(cube, &neighbour),
        1 => joined(cube, &inside_out(neighbour)),
        2 => joined(ball.clone(), &ball),
        _ => joined(joined(ball.clone(), &ball), &inside_out(ball)),
    }
}

/// Adds faces that are there twice, from both sides: some of the mesh, and some in its inside and outside.
fn with_flaps(mut mesh: TriangleMesh, random: &mut Random) -> TriangleMesh {
    for _ in 0..3 {
        let first = mesh.vertices.len() as u32;
        let [a, b, c] = if random.below(2) == 0 {
            mesh.faces[random.below(mesh.faces.len())]
        } else {
            mesh.vertices.extend([0; 3].map(|_| random.point(-0.8, 0.8)));
            [first, first + 1, first + 2]
        };
        mesh.faces.extend([[a, b, c], [a, c, b]]);
    }
    mesh
}

/// A double pyramid over a star with rays that are needles.
fn star(random: &mut Random) -> TriangleMesh {
    let narrow = 10f64.powf(random.number(-14.0, -9.0));
    let height = [0.3, 1e-3, narrow][random.below(3)];
    double_pyramid(2 * (3 + random.below(20) as u32), height, |i| if i % 2 == 0 { 0.5 } else { narrow })
}

/// A double pyramid: both tips have so many faces.
fn fan(degree: u32, random: &mut Random) -> TriangleMesh {
    let radii: Vec<f64> = (0..degree).map(|_| random.number(0.3, 0.5)).collect();
    double_pyramid(degree, random.number(0.0, 0.4) + 1e-3, |i| radii[i as usize])
}

fn double_pyramid(sides: u32, height: f64, radius: impl Fn(u32) -> f64) -> TriangleMesh {
    let mut mesh = TriangleMesh::new(vec![Vec3::Z * height, Vec3::Z * -height], Vec::new());
    for i in 0..sides {
        let (y, x) = (std::f64::consts::TAU * f64::from(i) / f64::from(sides)).sin_cos();
        mesh.vertices.push(Vec3::new(x, y, 0.0) * radius(i));
        let (a, b) = (2 + i, 2 + (i + 1) % sides);
        mesh.faces.extend([[0, a, b], [1, b, a]]);
    }
    mesh
}

/// A square of so many squares, flat or bumpy.
fn sheet(n: u32, random: &mut Random) -> TriangleMesh {
    let bump = [0.0, 1e-9, 0.05][random.below(3)];
    let mut mesh = TriangleMesh::default();
    for (i, j) in (0..=n).flat_map(|i| (0..=n).map(move |j| (i, j))) {
        let place = Vec3::new(f64::from(i), f64::from(j), 0.0) / f64::from(n) - Vec3::new(0.5, 0.5, 0.0);
        mesh.vertices.push(place + Vec3::Z * random.number(-bump, bump + 1e-300));
    }
    let at = |i: u32, j: u32| i * (n + 1) + j;
    for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        mesh.faces.extend([[a, b, c], [a, c, d]]);
    }
    mesh
}

/// Random triangles, with sizes over so many powers of ten.
fn soup(count: usize, decades: f64, random: &mut Random) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    for i in 0..count as u32 {
        let size = 10f64.powf(-random.number(0.0, decades + 1e-9));
        let centre = random.point(-0.5, 0.5);
        mesh.vertices.extend([0; 3].map(|_| centre + random.point(-0.5, 0.5) * size));
        mesh.faces.push([3 * i, 3 * i + 1, 3 * i + 2]);
    }
    mesh
}

/// Adds faces without an area: with corners on a line, or two equal ones.
fn with_degenerate_faces(mut mesh: TriangleMesh, random: &mut Random) -> TriangleMesh {
    for _ in 0..6 {
        let [a, b, _] = mesh.faces[random.below(mesh.faces.len())];
        let (p, q) = (mesh.vertices[a as usize], mesh.vertices[b as usize]);
        let new = mesh.vertices.len() as u32;
        mesh.vertices.push(if random.below(2) == 0 { p } else { p * 0.5 + q * 0.5 });
        mesh.faces.extend([[a, b, new], [a, new, b]]);
    }
    mesh
}

/// How the coordinates of a mesh are changed after it was made.
#[derive(Clone, Copy, Debug)]
pub struct Coordinates {
    /// The offset, in sizes of the mesh.
    pub offset: Vec3,
    pub scale: f64,
    /// Whether the offset coordinates are rounded to float32 before scaling.
    pub single: bool,
}

impl Coordinates {
    /// Coordinates near the origin and of usual size half of the time.
    pub fn any(random: &mut Random) -> Coordinates {
        let far = [0.0, 0.0, 0.0, 0.3, 1e3, 1e8, 1e12][random.below(7)];
        let scale = [1.0, 1.0, 1.0, 25.4, 1e-30, 1e30, 1e-200, 1e150][random.below(8)];
        Coordinates { offset: random.point(-far, far), scale, single: random.below(2) == 0 }
    }

    pub fn apply(&self, mesh: &mut TriangleMesh) {
        for v in &mut mesh.vertices {
            *v += self.offset;
            if self.single {
                *v = Vec3::from(v.to_array().map(|x| f64::from(x as f32)));
            }
            // A power of two keeps float32 values representable.
            *v *= if self.single { 2f64.powi(self.scale.log2() as i32) } else { self.scale };
        }
    }
}
