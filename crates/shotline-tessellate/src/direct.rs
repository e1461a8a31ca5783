//! Meshes of single solids, straight from their parameters: boxes, solids that are meshes themselves, and profiles that are turned
//! about an axis.

use shotline::math::Vec3;
use shotline::solid::mesh::TriangleMesh;
use shotline::solid::{Kind, Params};

use crate::profile::{Arcs, Profile};
use crate::refine::Refined;
use crate::turned::turned;

/// The mesh of a solid within a tolerance; `None` if its kind has no such mesh.
pub fn of_solid(kind: &Kind, params: &Params, tolerance: f64) -> Option<Refined> {
    let parts = kind.build(params).ok()?;
    if let Some(mesh) = parts.single().and_then(|solid| solid.as_mesh()) {
        return Some(Refined { mesh: mesh.triangle_mesh().clone(), deviation: 0.0 });
    }
    if kind.name == "box" {
        let mesh = cuboid(params.vector("min").ok()?, params.vector("max").ok()?);
        return Some(Refined { mesh, deviation: 0.0 });
    }
    // Half for the arcs of the profile, and half for its way around the axis.
    let arcs = Arcs { tolerance: 0.5 * tolerance };
    let profile = Profile::of(kind.name, params, arcs)?;
    let around = if profile.deviation > 0.0 { 0.5 * tolerance } else { tolerance };
    turned(&profile, Arcs { tolerance: around })
}

/// A box: corners by the bits of their numbers, x first.
fn cuboid(min: Vec3, max: Vec3) -> TriangleMesh {
    let side = |corner: u32, axis: usize| if corner >> axis & 1 == 1 { max[axis] } else { min[axis] };
    let corners = (0..8).map(|corner| Vec3::from([0, 1, 2].map(|axis| side(corner, axis)))).collect();
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    TriangleMesh::new(corners, sides.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect())
}
