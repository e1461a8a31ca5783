//! What is right and wrong with a mesh.

use std::collections::HashMap;

use super::probe::Size;
use super::{MeshError, TriangleMesh};
use crate::math::{Vec3, difference_of_products};

/// An edge along which not as many faces run one way as the other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OpenEdge {
    /// Its vertices; of vertices in one place, the first.
    pub vertices: [u32; 2],
    /// Where it begins.
    pub from: Vec3,
    /// Where it ends.
    pub to: Vec3,
}

/// A report on a mesh. Vertices in exactly the same place count as one everywhere, so that the separate
/// triangles of an STL file are seen as the surface they make.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Topology {
    /// Vertices given.
    pub vertices: usize,
    /// Vertices in the place of an earlier one.
    pub repeated_vertices: usize,
    /// Faces given.
    pub faces: usize,
    /// Faces two corners of which are in one place. They are left out of everything else, and nothing is
    /// open for want of them: their two other edges are one edge, run through both ways.
    pub degenerate_faces: usize,
    /// Faces without area, whose three corners lie on a line.
    pub zero_area_faces: usize,
    /// Faces with the corners of an earlier face, in whatever order.
    pub duplicate_faces: usize,
    /// Edges along which not as many faces run one way as the other.
    pub open_edges: usize,
    /// The first of them.
    pub first_open_edge: Option<OpenEdge>,
    /// Edges of more than two faces.
    pub crowded_edges: usize,
    /// Edges of two faces that run along it the same way: one of the two is the wrong way round.
    pub inconsistent_edges: usize,
    /// Parts that have no vertex in common.
    pub shells: usize,
    /// The volume enclosed, by the winding number; negative where faces are wound inward.
    pub signed_volume: f64,
    /// Vertices less edges plus faces: 2 for each shell that is like a sphere, 0 for each like a torus.
    pub euler_characteristic: i64,
}

impl Topology {
    /// Examines a mesh.
    ///
    /// # Errors
    /// [`MeshError`] for indices out of range, coordinates that are not finite, and nothing to examine.
    pub fn of(mesh: &TriangleMesh) -> Result<Topology, MeshError> {
        check(mesh)?;
        let places = places(&mesh.vertices);
        let at = |v: u32| mesh.vertices[v as usize];
        let faces: Vec<[u32; 3]> = (mesh.faces.iter())
            .map(|face| face.map(|v| places[v as usize]))
            .filter(|[a, b, c]| a != b && b != c && c != a)
            .collect();
        if faces.is_empty() {
            return Err(MeshError::Empty);
        }
        let size = Size::of(&mesh.vertices);
        let scaled = |v: u32| size.scale(at(v));
        let mut shells = Shells::new(mesh.vertices.len());
        for [a, b, c] in &faces {
            shells.join(*a, *b);
            shells.join(*b, *c);
        }
        let mut report = Topology {
            vertices: mesh.vertices.len(),
            repeated_vertices: (0..).zip(&places).filter(|(v, place)| v != *place).count(),
            faces: mesh.faces.len(),
            degenerate_faces: mesh.faces.len() - faces.len(),
            zero_area_faces: faces.iter().filter(|face| is_flat(face.map(scaled))).count(),
            duplicate_faces: duplicates(&faces),
            signed_volume: size.volume(signed_volume(&faces, scaled)),
            ..Topology::default()
        };
        let edges = report.count_edges(&faces, at);
        let (used, roots) = shells.count(&faces);
        report.shells = roots;
        report.euler_characteristic = used as i64 - edges as i64 + faces.len() as i64;
        Ok(report)
    }

    /// What keeps the mesh from being closed, in words; empty if it is closed.
    pub fn why_open(&self) -> String {
        match &self.first_open_edge {
            None => String::new(),
            Some(edge) => {
                let [a, b] = edge.vertices;
                let place = |v: Vec3| format!("({}, {}, {})", v.x, v.y, v.z);
                format!(
                    "{} open edges, the first between vertices {a} at {} and {b} at {}",
                    self.open_edges,
                    place(edge.from),
                    place(edge.to),
                )
            }
        }
    }

    /// Whether along every edge as many faces run one way as the other. Such a mesh has an inside.
    pub fn is_closed(&self) -> bool {
        self.open_edges == 0
    }

    /// Fills in what is counted by edges and answers how many there are.
    fn count_edges(&mut self, faces: &[[u32; 3]], at: impl Fn(u32) -> Vec3) -> usize {
        // Each edge with its lower vertex first, and whether the face runs along it that way.
        let mut edges: Vec<([u32; 2], bool)> = Vec::with_capacity(3 * faces.len());
        for [a, b, c] in faces {
            for (from, to) in [(*a, *b), (*b, *c), (*c, *a)] {
                edges.push(([from.min(to), from.max(to)], from < to));
            }
        }
        edges.sort_unstable();
        let mut count = 0;
        for uses in edges.chunk_by(|a, b| a.0 == b.0) {
            count += 1;
            let forward = uses.iter().filter(|(_, forward)| *forward).count();
            let vertices = uses[0].0;
            if 2 * forward != uses.len() {
                self.open_edges += 1;
                self.first_open_edge.get_or_insert_with(|| {
                    let [from, to] = vertices.map(&at);
                    OpenEdge { vertices, from, to }
                });
            }
            self.crowded_edges += usize::from(uses.len() > 2);
            self.inconsistent_edges += usize::from(uses.len() == 2 && forward != 1);
        }
        count
    }
}

fn check(mesh: &TriangleMesh) -> Result<(), MeshError> {
    if mesh.faces.len() >= u32::MAX as usize {
        return Err(MeshError::TooManyFaces { faces: mesh.faces.len() });
    }
    if let Some((vertex, position)) = mesh.vertices.iter().enumerate().find(|(_, v)| !v.is_finite()) {
        return Err(MeshError::NotFinite { vertex, position: *position });
    }
    let count = mesh.vertices.len();
    for (face, corners) in mesh.faces.iter().enumerate() {
        if let Some(&vertex) = corners.iter().find(|&&v| v as usize >= count) {
            return Err(MeshError::VertexOutOfRange { face, vertex, count });
        }
    }
    Ok(())
}

/// For each vertex the first one in exactly the same place.
fn places(vertices: &[Vec3]) -> Vec<u32> {
    let mut first = HashMap::with_capacity(vertices.len());
    // Adding zero makes one of both zeros.
    let key = |v: &Vec3| v.to_array().map(|x| (x + 0.0).to_bits());
    (0..).zip(vertices).map(|(i, v)| *first.entry(key(v)).or_insert(i)).collect()
}

/// Whether three points lie on a line, as far as correctly rounded differences can tell.
fn is_flat([a, b, c]: [Vec3; 3]) -> bool {
    let (u, v) = (b - a, c - a);
    let area = |i: usize, j: usize| difference_of_products(u[i], v[j], u[j], v[i]);
    area(0, 1) == 0.0 && area(1, 2) == 0.0 && area(2, 0) == 0.0
}

/// How many faces have the corners of an earlier one.
fn duplicates(faces: &[[u32; 3]]) -> usize {
    let mut corners = faces.to_vec();
    corners.iter_mut().for_each(|face| face.sort_unstable());
    corners.sort_unstable();
    corners.windows(2).filter(|pair| pair[0] == pair[1]).count()
}

/// The sum of the tetrahedra between the faces and one of the vertices.
fn signed_volume(faces: &[[u32; 3]], at: impl Fn(u32) -> Vec3) -> f64 {
    let tip = at(faces[0][0]);
    let tetrahedron = |[a, b, c]: [Vec3; 3]| (a - tip).dot((b - tip).cross(c - tip));
    faces.iter().map(|face| tetrahedron(face.map(&at))).sum::<f64>() / 6.0
}

/// Which vertices hang together: a forest of parents, with paths halved on the way.
struct Shells {
    parents: Vec<u32>,
}

impl Shells {
    fn new(vertices: usize) -> Shells {
        Shells { parents: (0..).take(vertices).collect() }
    }

    fn root(&mut self, mut v: u32) -> u32 {
        while self.parents[v as usize] != v {
            let grandparent = self.parents[self.parents[v as usize] as usize];
            self.parents[v as usize] = grandparent;
            v = grandparent;
        }
        v
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.parents[a.max(b) as usize] = a.min(b);
    }

    /// The vertices of faces, and the parts they make.
    fn count(&self, faces: &[[u32; 3]]) -> (usize, usize) {
        let mut used = vec![false; self.parents.len()];
        faces.iter().flatten().for_each(|&v| used[v as usize] = true);
        let vertices = used.iter().filter(|u| **u).count();
        let roots = (0..).zip(&self.parents).filter(|(v, parent)| v == *parent && used[*v as usize]).count();
        (vertices, roots)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solid::mesh::shapes::{ball, cubes, ring, sheet};

    fn report(mesh: &TriangleMesh) -> Topology {
        Topology::of(mesh).unwrap()
    }

    #[test]
    fn sound_meshes_are_closed() {
        let ball = report(&ball(3));
        assert!(ball.is_closed() && (4.0..4.19).contains(&ball.signed_volume), "{ball:?}");
        assert_eq!((ball.euler_characteristic, ball.shells, ball.crowded_edges), (2, 1, 0));
        let ring = report(&ring(9, 5));
        assert!(ring.is_closed());
        assert_eq!((ring.euler_characteristic, ring.shells, ring.first_open_edge), (0, 1, None));
    }

    #[test]
    fn shells_that_share_no_vertex_are_told_apart() {
        let apart = report(&cubes(&[[0, 0, 0], [2, 0, 0], [3, 0, 0]]));
        assert_eq!((apart.shells, apart.euler_characteristic, apart.signed_volume), (2, 4, 3.0));
        // An edge of four faces is closed all the same.
        let corner = report(&cubes(&[[0, 0, 0], [1, 1, 0]]));
        assert_eq!((corner.shells, corner.crowded_edges, corner.open_edges), (1, 1, 0));
        assert_eq!(report(&ball(1).inside_out()).signed_volume, -report(&ball(1)).signed_volume);
    }

    #[test]
    fn an_open_sheet_has_its_rim_open() {
        let sheet = report(&sheet(3));
        assert_eq!((sheet.open_edges, sheet.is_closed(), sheet.euler_characteristic), (12, false, 1));
        let (from, to) = (Vec3::ZERO, Vec3::new(0.0, 1.0, 0.0));
        assert_eq!(sheet.first_open_edge, Some(OpenEdge { vertices: [0, 1], from, to }));
    }

    #[test]
    fn a_face_the_wrong_way_round_shows_at_its_edges() {
        let mut mesh = ball(1);
        mesh.faces[7].swap(0, 1);
        let report = report(&mesh);
        assert_eq!((report.inconsistent_edges, report.open_edges, report.duplicate_faces), (3, 3, 0));
    }

    #[test]
    fn odd_faces_are_counted_and_open_nothing() {
        let mut mesh = ball(1);
        let [a, b, c] = mesh.faces[0];
        mesh.faces.extend([[a, b, c], [c, b, a], [a, a, b], [c, c, c]]);
        let odd = report(&mesh);
        assert_eq!((odd.duplicate_faces, odd.degenerate_faces), (2, 2));
        assert_eq!((odd.open_edges, odd.crowded_edges), (0, 3));
        let line = |x: f64| Vec3::new(x, 2.0 * x, -x);
        let vertices = vec![line(0.0), line(1.0), line(3.0)];
        let flat = report(&TriangleMesh { vertices, faces: vec![[0, 1, 2]] });
        assert_eq!((flat.zero_area_faces, flat.open_edges), (1, 3));
    }

    #[test]
    fn separate_triangles_are_seen_as_the_surface_they_make() {
        let mut mesh = ring(6, 4).unwelded();
        mesh.vertices.iter_mut().filter(|v| v.z == 0.0).for_each(|v| v.z = 0.0);
        let zeros = mesh.vertices.iter().position(|v| v.z == 0.0).unwrap();
        mesh.vertices[zeros].z = -0.0;
        let (welded, separate) = (report(&ring(6, 4)), report(&mesh));
        assert!(separate.is_closed());
        assert_eq!(separate.repeated_vertices, 3 * 48 - 24);
        assert_eq!(separate.euler_characteristic, welded.euler_characteristic);
        assert_eq!((separate.shells, separate.signed_volume), (1, welded.signed_volume));
    }

    #[test]
    fn sizes_far_from_one_are_seen_the_same() {
        for size in [1e-200, 1e200] {
            let mut mesh = ball(1).inside_out();
            mesh.vertices.iter_mut().for_each(|v| *v *= size);
            let report = report(&mesh);
            assert!(report.signed_volume.is_sign_negative());
            assert_eq!(report.zero_area_faces, 0);
        }
    }

    #[test]
    fn what_is_not_a_mesh_is_refused_with_the_place() {
        let broken = |change: fn(&mut TriangleMesh)| {
            let mut mesh = ball(0);
            change(&mut mesh);
            Topology::of(&mesh).unwrap_err()
        };
        let outside = broken(|m| m.faces[3][1] = 6);
        assert_eq!(outside, MeshError::VertexOutOfRange { face: 3, vertex: 6, count: 6 });
        assert!(outside.to_string().contains("face 3 names vertex 6, but there are only 6"), "{outside}");
        let nan = broken(|m| m.vertices[2].y = f64::NAN);
        assert!(nan.to_string().contains("vertex 2 is (0, NaN, 1)"), "{nan}");
        assert_eq!(broken(|m| m.faces.clear()), MeshError::Empty);
        assert_eq!(broken(|m| m.faces.iter_mut().for_each(|f| f[0] = f[1])), MeshError::Empty);
    }
}
