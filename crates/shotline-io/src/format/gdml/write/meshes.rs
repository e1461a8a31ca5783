//! Meshes to tessellated solids, whose facets name defined positions.

use std::collections::HashMap;

use shotline::math::Vec3;
use shotline::solid::mesh::{Topology, TriangleMesh};

use super::Writer;
use super::report::Reported;
use super::shapes::Placed;

impl Writer<'_> {
    /// A closed mesh.
    pub(super) fn mesh(&mut self, mesh: &TriangleMesh) -> Result<Placed, Reported> {
        let topology = Topology::of(mesh).map_err(|error| self.refuse(&error.to_string()))?;
        if !topology.is_closed() {
            let why = format!("a mesh is not closed, and GDML has solids only: {}", topology.why_open());
            return Err(self.refuse(&why));
        }
        let Some(is_inward) = direction(mesh) else {
            let why = "some shells of a mesh face inwards, around a cavity, which GDML's tessellated solid does not have";
            return Err(self.refuse(why));
        };
        let (vertices, faces) = used_vertices(mesh);
        let names = self.positions(&vertices);
        let solid = self.solid("tessellated", |element| {
            let mut element = element.in_millimetres();
            for [a, b, c] in faces {
                let corners = if is_inward { [a, c, b] } else { [a, b, c] };
                let mut facet = element.inner("triangular");
                for (key, corner) in ["vertex1", "vertex2", "vertex3"].iter().zip(corners) {
                    facet = facet.text(key, &names[corner as usize]);
                }
                element.add(facet.text("type", "ABSOLUTE"));
            }
            element
        });
        Ok(Placed::centred(solid))
    }
}

/// The vertices that faces with three different corners use, each position once, and these faces.
fn used_vertices(mesh: &TriangleMesh) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let mut vertices: Vec<Vec3> = Vec::new();
    let mut numbers: HashMap<[u64; 3], u32> = HashMap::new();
    let mut number = |v: Vec3| {
        // The addition makes zeros equal.
        *numbers.entry((v + Vec3::ZERO).to_array().map(f64::to_bits)).or_insert_with(|| {
            vertices.push(v);
            (vertices.len() - 1) as u32
        })
    };
    let corners = (0..mesh.faces.len() as u32).map(|face| mesh.corners(face));
    let real = corners.filter(|[a, b, c]| a != b && b != c && c != a);
    let faces = real.map(|corners| corners.map(&mut number)).collect();
    (vertices, faces)
}

/// Whether the shells of a mesh face inwards; `None` if they differ. A shell is made of faces that share vertices.
fn direction(mesh: &TriangleMesh) -> Option<bool> {
    let (vertices, faces) = used_vertices(mesh);
    let mut parents: Vec<u32> = (0..vertices.len() as u32).collect();
    for [a, b, c] in &faces {
        for (one, other) in [(*a, *b), (*b, *c)] {
            let (one, other) = (root(&mut parents, one), root(&mut parents, other));
            parents[one.max(other) as usize] = one.min(other);
        }
    }
    let mut volumes: HashMap<u32, f64> = HashMap::new();
    for face in &faces {
        let shell = root(&mut parents, face[0]);
        let [a, b, c] = face.map(|v| vertices[v as usize] - vertices[shell as usize]);
        *volumes.entry(shell).or_default() += a.dot(b.cross(c));
    }
    let inward = volumes.values().filter(|volume| **volume < 0.0).count();
    match inward {
        0 => Some(false),
        all if all == volumes.len() => Some(true),
        _ => None,
    }
}

/// The representative of a vertex, with path halving.
fn root(parents: &mut [u32], mut v: u32) -> u32 {
    while parents[v as usize] != v {
        let grandparent = parents[parents[v as usize] as usize];
        parents[v as usize] = grandparent;
        v = grandparent;
    }
    v
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cavities_are_told_from_shells_that_face_inwards() {
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
        let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let turned = faces.map(|[a, b, c]| [a, c, b]);
        let second = corners.map(|v| v * 0.1 + Vec3::splat(0.1));
        let of = |a: [[u32; 3]; 4], b: [[u32; 3]; 4]| {
            let faces = a.into_iter().chain(b.map(|face| face.map(|v| v + 4)));
            direction(&TriangleMesh::new([corners, second].concat(), faces.collect()))
        };
        assert_eq!(
            [of(faces, faces), of(turned, turned), of(faces, turned)],
            [Some(false), Some(true), None]
        );
    }
}
