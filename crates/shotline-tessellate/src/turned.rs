//! Profiles that are turned about the z axis.

use std::f64::consts::PI;

use shotline::math::Vec3;
use shotline::polygon::triangulate;
use shotline::solid::mesh::TriangleMesh;

use crate::profile::{Arcs, Profile};
use crate::refine::Refined;

/// The most triangles.
const MOST_TRIANGLES: usize = 1 << 22;

/// The numbers of the vertices of the corners of a profile, at each step around the axis.
struct Vertices {
    /// The first vertex of each corner, and whether it has one at each step or, on the axis, only one.
    corners: Vec<(u32, bool)>,
    /// The number of steps, and whether the last is followed by the first.
    steps: u32,
    is_whole: bool,
}

impl Vertices {
    fn number(&self, corner: usize, step: u32) -> u32 {
        let step = if self.is_whole && step == self.steps { 0 } else { step };
        match self.corners[corner] {
            (first, true) => first + step,
            (only, false) => only,
        }
    }
}

/// The mesh of a profile that is turned about the axis; `None` if it would be too large.
pub fn turned(profile: &Profile, arcs: Arcs) -> Option<Refined> {
    let corners = &profile.corners;
    let [from, angle] = profile.sector.unwrap_or([0.0, 2.0 * PI]);
    let radius = corners.iter().map(|[r, _]| *r).fold(0.0, f64::max);
    let (steps, deviation) = arcs.steps(radius, angle)?;
    if steps * 2 * corners.len() > MOST_TRIANGLES {
        return None;
    }
    let is_whole = profile.sector.is_none();
    let mut vertices = Vertices { corners: Vec::new(), steps: steps as u32, is_whole };
    let mut points = Vec::new();
    for [r, z] in corners {
        let is_off_axis = *r > 0.0;
        vertices.corners.push((points.len() as u32, is_off_axis));
        let count = if !is_off_axis { 1 } else { steps + usize::from(!is_whole) };
        points.extend((0..count).map(|step| {
            let (sine, cosine) = (from + angle * step as f64 / steps as f64).sin_cos();
            Vec3::new(r * cosine, r * sine, *z)
        }));
    }
    let mut faces = walls(&vertices, corners.len());
    if !is_whole {
        faces.extend(ends(corners, &vertices)?);
    }
    let mesh = TriangleMesh::new(points, faces);
    Some(Refined { mesh, deviation: deviation + profile.deviation })
}

/// The faces that the sides of a profile sweep over. A side on the axis sweeps over none.
fn walls(vertices: &Vertices, corners: usize) -> Vec<[u32; 3]> {
    let mut faces = Vec::new();
    for corner in 0..corners {
        let next = (corner + 1) % corners;
        for step in 0..vertices.steps {
            let [a, b] = [step, step + 1].map(|step| vertices.number(corner, step));
            let [d, c] = [step, step + 1].map(|step| vertices.number(next, step));
            if a != b {
                faces.push([a, b, c]);
            }
            if c != d {
                faces.push([a, c, d]);
            }
        }
    }
    faces
}

/// The faces at both ends of a sector; `None` if the profile cannot be divided into triangles, or is at the axis in several places:
/// a side between two of them would belong to both ends.
fn ends(corners: &[[f64; 2]], vertices: &Vertices) -> Option<Vec<[u32; 3]>> {
    let is_on_axis = |corner: usize| corners[corner % corners.len()][0] == 0.0;
    let places = (0..corners.len()).filter(|corner| is_on_axis(*corner) && !is_on_axis(corner + 1)).count();
    if places > 1 {
        return None;
    }
    let flat: Vec<Vec3> = corners.iter().map(|[r, z]| Vec3::new(*r, *z, 0.0)).collect();
    let division = triangulate(&flat);
    let at = |triangle: &[u32; 3], step: u32| triangle.map(|corner| vertices.number(corner as usize, step));
    let first = division.triangles.iter().map(|triangle| at(triangle, 0));
    let last = division.triangles.iter().map(|triangle| {
        let [a, b, c] = at(triangle, vertices.steps);
        [a, c, b]
    });
    division.is_proper.then(|| first.chain(last).collect())
}
