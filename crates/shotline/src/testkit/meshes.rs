//! Random closed meshes that are difficult for rounding: thin walls, far from the origin for their size, shells
//! of very different sizes, and vertices that no face uses.

use super::random::Random;
use crate::math::{Affine, Vec3};
use crate::ray::Ray;
use crate::solid::mesh::TriangleMesh;

/// The randomly chosen parameters of a mesh.
#[derive(Clone, Copy, Debug)]
pub struct Thin {
    /// The thinnest wall, as a fraction of the size.
    pub wall: f64,
    /// The offset of the mesh from the origin along each axis, in multiples of the size.
    pub offset: Vec3,
    /// The size.
    pub size: f64,
    /// Whether the mesh is rotated, so that no face is perpendicular to an axis.
    pub turned: bool,
}

impl Thin {
    /// Walls from 1e-1 to 1e-9, offsets from 0 to 1e8, sizes from 0.001 to 1000.
    pub fn any(random: &mut Random) -> Thin {
        let wall = 10f64.powi(-1 - random.below(9) as i32);
        let far = if random.below(2) == 0 { 0.0 } else { 10f64.powi(random.below(9) as i32) };
        let size = [1e-3, 0.1, 1.0, 25.4, 1000.0][random.below(5)];
        Thin { wall, offset: random.point(-far, far), size, turned: random.below(2) == 0 }
    }

    /// About one unit wide and near the origin, with walls from 1e-1 to 1e-6.
    pub fn near(random: &mut Random) -> Thin {
        let wall = 10f64.powi(-1 - random.below(6) as i32);
        Thin { wall, offset: random.point(-0.3, 0.3), size: 1.0, turned: random.below(2) == 0 }
    }

    /// A mesh with these parameters: a box or an octahedron with a cavity, a tray, an annulus, a stack of plates,
    /// or nested boxes, often with unused vertices. The corners are rounded in their final position. So walls
    /// thinner than the rounding error may have zero or negative thickness, but the mesh is still closed.
    pub fn mesh(&self, random: &mut Random) -> TriangleMesh {
        let mut mesh = match random.below(6) {
            0 => hollow(cuboid(Vec3::ZERO, Vec3::ONE), self.wall),
            1 => hollow(octahedron(), self.wall),
            2 => tray(self.wall),
            3 => annulus(5 + random.below(8) as u32, self.wall),
            4 => plates(1 + random.below(4) as u32, self.wall),
            _ => nested(2 + random.below(3) as i32, self.wall),
        };
        let turn =
            if self.turned { Affine::rotation_xyz(random.point(-180.0, 180.0)) } else { Affine::IDENTITY };
        for v in &mut mesh.vertices {
            *v = (turn.point(*v - Vec3::splat(0.5)) + self.offset) * self.size;
        }
        if random.below(2) == 0 {
            with_unused_vertices(&mut mesh, random);
        }
        mesh
    }
}

/// Rays from walls, near them, inside them and far away, along axes, edges and faces, and across.
pub fn rays_at(random: &mut Random, mesh: &TriangleMesh, thin: &Thin, n: usize) -> Vec<Ray> {
    let mut rays = Vec::new();
    while rays.len() < n {
        let [a, b, c] = mesh.corners(random.below(mesh.faces.len()) as u32);
        let (v, w) = (random.number(0.0, 0.5), random.number(0.0, 0.5));
        let on_face = a + (b - a) * v + (c - a) * w;
        let normal = (b - a).cross(c - a).normalize_or(Vec3::X);
        let step = [0.0, 0.3, -0.3, 3.0, -3.0, 1e-6 / thin.wall][random.below(6)] * thin.wall;
        let far = 10f64.powi(random.below(5) as i32 - 1);
        let o = match random.below(4) {
            0 => on_face,
            1 | 2 => on_face + normal * (step * thin.size),
            _ => on_face + random.direction() * (far * thin.size),
        };
        let [p, q, r] = mesh.corners(random.below(mesh.faces.len()) as u32);
        let d = match random.below(6) {
            0 => Vec3::AXES[random.below(3)],
            1 => normal,
            2 => p * 0.5 + q * 0.25 + r * 0.25 - o,
            3 => p - o,
            4 => b - a,
            _ => random.direction(),
        };
        let factor = [1.0, -1.0, 1e-3, 1e3][random.below(4)];
        rays.extend(Ray::new(o, d * factor));
    }
    rays
}

/// Inserts vertices that no face uses among the others.
pub fn with_unused_vertices(mesh: &mut TriangleMesh, random: &mut Random) {
    let odd = [Vec3::NAN, Vec3::splat(1e30), Vec3::new(1e6, -1e14, 0.0), Vec3::INFINITY, Vec3::ZERO];
    let place = random.below(mesh.vertices.len() + 1);
    mesh.vertices.splice(place..place, odd);
    for v in mesh.faces.iter_mut().flatten().filter(|v| **v as usize >= place) {
        *v += odd.len() as u32;
    }
}

/// Both meshes as one mesh.
pub fn joined(mut first: TriangleMesh, second: &TriangleMesh) -> TriangleMesh {
    let offset = first.vertices.len() as u32;
    first.vertices.extend(&second.vertices);
    first.faces.extend(second.faces.iter().map(|face| face.map(|v| v + offset)));
    first
}

/// Adds the two triangles of a quadrilateral.
fn quad(mesh: &mut TriangleMesh, [a, b, c, d]: [u32; 4]) {
    mesh.faces.extend([[a, b, c], [a, c, d]]);
}

/// A box as a mesh, wound outward.
pub fn cuboid(min: Vec3, max: Vec3) -> TriangleMesh {
    let ends = [min, max];
    let corner = |i: usize| Vec3::new(ends[i & 1].x, ends[(i >> 1) & 1].y, ends[i >> 2].z);
    let mut mesh = TriangleMesh::new((0..8).map(corner).collect(), Vec::new());
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    quads.into_iter().for_each(|corners| quad(&mut mesh, corners));
    mesh
}

fn octahedron() -> TriangleMesh {
    let axes = [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z];
    let vertices = axes.iter().map(|v| *v * 0.5 + Vec3::splat(0.5)).collect();
    let faces = vec![[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]];
    TriangleMesh::new(vertices, faces)
}

/// A convex mesh around the middle of the unit cube with a similar cavity. The wall has the given thickness, only
/// approximately where faces are slanted.
pub fn hollow(outer: TriangleMesh, wall: f64) -> TriangleMesh {
    let middle = Vec3::splat(0.5);
    let mut cavity = outer.clone();
    cavity.vertices.iter_mut().for_each(|v| *v = middle + (*v - middle) * (1.0 - 2.0 * wall));
    cavity.faces.iter_mut().for_each(|face| face.swap(1, 2));
    joined(outer, &cavity)
}

/// The unit square with walls around it, open at the top.
pub fn tray(wall: f64) -> TriangleMesh {
    let square = |low: f64, z: f64| {
        let high = 1.0 - low;
        [(low, low), (high, low), (high, high), (low, high)].map(|(x, y)| Vec3::new(x, y, z))
    };
    let rings = [square(0.0, 0.0), square(0.0, 0.5), square(wall, 0.5), square(wall, wall)];
    let mut mesh = TriangleMesh::new(rings.concat(), Vec::new());
    quad(&mut mesh, [3, 2, 1, 0]);
    quad(&mut mesh, [12, 13, 14, 15]);
    for (ring, i) in (0..3).flat_map(|ring| (0..4).map(move |i| (ring, i))) {
        let at = |ring: u32, i: u32| 4 * ring + i % 4;
        quad(&mut mesh, [at(ring, i), at(ring, i + 1), at(ring + 1, i + 1), at(ring + 1, i)]);
    }
    mesh
}

/// A pipe with the given wall thickness.
pub fn annulus(sides: u32, wall: f64) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    for i in 0..sides {
        let (sin, cos) = libm::sincos(f64::from(i) / f64::from(sides) * std::f64::consts::TAU);
        for (r, z) in [(0.5, 0.25), (0.5, 0.75), (0.5 - wall, 0.75), (0.5 - wall, 0.25)] {
            mesh.vertices.push(Vec3::new(0.5 + r * cos, 0.5 + r * sin, z));
        }
    }
    for (i, k) in (0..sides).flat_map(|i| (0..4).map(move |k| (i, k))) {
        let at = |i: u32, k: u32| 4 * (i % sides) + k % 4;
        quad(&mut mesh, [at(i, k), at(i + 1, k), at(i + 1, k + 1), at(i, k + 1)]);
    }
    mesh
}

/// A stack of plates with gaps of the same thickness.
fn plates(count: u32, wall: f64) -> TriangleMesh {
    let plate = |i: u32| {
        let z = 2.0 * wall * f64::from(i);
        cuboid(Vec3::new(0.0, 0.0, z), Vec3::new(1.0, 0.7, z + wall))
    };
    (1..count).fold(plate(0), |mesh, i| joined(mesh, &plate(i)))
}

/// Nested boxes with the same winding, each smaller than the enclosing one by the same factor.
fn nested(count: i32, factor: f64) -> TriangleMesh {
    let shell = |i: i32| {
        let half = Vec3::splat(0.5 * factor.max(1e-4).powi(i));
        cuboid(Vec3::splat(0.5) - half, Vec3::splat(0.5) + half)
    };
    (1..count).fold(shell(0), |mesh, i| joined(mesh, &shell(i)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solid::mesh::Topology;

    #[test]
    fn meshes_are_closed_and_wound_outward() {
        let mut random = Random::new(1);
        for _ in 0..300 {
            let thin = Thin { offset: Vec3::ZERO, ..Thin::any(&mut random) };
            let report = Topology::of(&thin.mesh(&mut random)).expect("a mesh");
            assert!(report.is_closed() && report.signed_volume > 0.0, "{thin:?} {report:?}");
        }
    }
}
