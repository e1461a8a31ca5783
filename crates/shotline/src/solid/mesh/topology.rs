//! A report on the defects of a mesh.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::iter::{IndexedParallelIterator, IntoParallelIterator, IntoParallelRefIterator, ParallelIterator};

use super::corners::Corners;
use super::distribute::{CHUNK, divided};
use super::edge_report::EdgeReport;
use super::mesh_line::PowerOfTwoScale;
use super::shells::{self, Shells};
use super::tetrahedra::signed_volume;
use super::welded::{Face, first_at, welded};
use super::{Edge, MeshError, Tally, TriangleMesh};
use crate::math::{Vec3, difference_of_products};

/// A report on a mesh. Vertices at exactly the same position count as one everywhere, so the separate triangles of an
/// STL file count as the surface that they form.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Topology {
    /// The number of vertices.
    pub vertices: usize,
    /// Vertices that no face uses, with the first of them. They may have any value and affect nothing.
    pub unused_vertices: Tally<u32>,
    /// Used vertices at the position of an earlier one, with that one.
    pub duplicate_vertices: Tally<[u32; 2]>,
    /// The number of faces.
    pub faces: usize,
    /// Faces with two coincident corners. They are excluded from everything else, and no edge is open because of that:
    /// their other two edges are one edge, used in both directions.
    pub degenerate_faces: Tally<u32>,
    /// Faces without area: their three corners are collinear.
    pub zero_area_faces: Tally<u32>,
    /// Faces with the corners of an earlier face, in any order, with that face.
    pub duplicate_faces: Tally<[u32; 2]>,
    /// Edges along which the numbers of faces in the two directions differ.
    pub open_edges: Tally<Edge>,
    /// Non-manifold edges: those of more than two faces.
    pub non_manifold_edges: Tally<Edge>,
    /// Edges of two faces that run along it in the same direction: one of the two is flipped.
    pub inconsistent_edges: Tally<Edge>,
    /// Shells, which have no vertex in common, with the first face of the second one.
    pub shells: Tally<u32>,
    /// The enclosed volume, weighted by the winding number; negative where faces are wound inward.
    pub signed_volume: f64,
    /// Vertices minus edges plus faces: 2 for each shell like a sphere, 0 for each like a torus.
    pub euler_characteristic: i64,
}

impl Topology {
    /// Examines a mesh.
    ///
    /// # Errors
    /// [`MeshError`] if an index is out of range, a face's corner has a coordinate that is not finite, or no face
    /// remains.
    pub fn of(mesh: &TriangleMesh) -> Result<Topology, MeshError> {
        Corners::of(mesh)?;
        divided(mesh.elements(), || Topology::of_valid(mesh))
    }

    /// Examines a mesh whose corners are valid.
    ///
    /// # Errors
    /// [`MeshError`] if no face remains.
    pub(super) fn of_valid(mesh: &TriangleMesh) -> Result<Topology, MeshError> {
        let first_at = first_at(&mesh.vertices);
        let faces = welded(mesh, &first_at);
        if faces.is_empty() {
            return Err(MeshError::Empty);
        }
        let count = mesh.vertices.len();
        let in_use = used(count, &mesh.faces, |face| *face);
        let is_duplicate = |v: u32| first_at[v as usize] != v && in_use[v as usize];
        let all_vertices = || (0..count as u32).into_par_iter().with_min_len(CHUNK);
        let duplicate_vertices =
            Tally::of(all_vertices().map(|v| is_duplicate(v).then(|| [v, first_at[v as usize]])));
        let degenerate = mesh.faces.len() - faces.len();
        // Whether vertices are in use at faces that are not degenerate, as the first ones at their positions.
        let is_corner = if degenerate == 0 && duplicate_vertices.count == 0 {
            in_use.clone()
        } else {
            used(count, &faces, |face| face.corners)
        };
        let corners = || all_vertices().filter(|v| is_corner[*v as usize]);
        let largest =
            corners().map(|v| mesh.vertices[v as usize].abs().max_element()).reduce(|| 0.0, f64::max);
        let size = PowerOfTwoScale::of(largest);
        let scaled = |v: u32| size.scale(mesh.vertices[v as usize]);
        let edges = EdgeReport::of(&faces, &mesh.vertices);
        let roots = Shells::of(count, &faces).into_roots();
        let signed = signed_volume(&faces, |face| roots[face.corners[0] as usize], scaled);
        let report = Topology {
            vertices: count,
            unused_vertices: Tally::of(all_vertices().map(|v| (!in_use[v as usize]).then_some(v))),
            duplicate_vertices,
            faces: mesh.faces.len(),
            degenerate_faces: Tally { count: degenerate, first: first_left_out(&faces, mesh.faces.len()) },
            zero_area_faces: Tally::of(
                (faces.par_iter().with_min_len(CHUNK))
                    .map(|f| is_flat(f.corners.map(scaled)).then_some(f.number)),
            ),
            duplicate_faces: edges.duplicate_faces,
            open_edges: edges.open,
            non_manifold_edges: edges.non_manifold,
            inconsistent_edges: edges.inconsistent,
            shells: shells::count(&roots, &faces, corners()),
            signed_volume: size.volume(signed),
            euler_characteristic: corners().count() as i64 - edges.edges as i64 + faces.len() as i64,
        };
        Ok(report)
    }

    /// Describes why the mesh is not closed; empty if it is closed.
    pub fn why_open(&self) -> String {
        match &self.open_edges.first {
            None => String::new(),
            Some(edge) => {
                let [a, b] = edge.vertices;
                let place = |v: Vec3| format!("({}, {}, {})", v.x, v.y, v.z);
                format!(
                    "{} open edges, the first between vertices {a} at {} and {b} at {}",
                    self.open_edges.count,
                    place(edge.from),
                    place(edge.to),
                )
            }
        }
    }

    /// Whether along every edge equally many faces run in both directions. Such a mesh has an inside.
    pub fn is_closed(&self) -> bool {
        self.open_edges.count == 0
    }
}

/// Returns the first of so many faces that is not listed.
fn first_left_out(faces: &[Face], count: usize) -> Option<u32> {
    (faces.len() < count).then(|| {
        let first = (0..).zip(faces).find(|(number, face)| face.number != *number);
        first.map_or(faces.len() as u32, |(number, _)| number)
    })
}

/// Returns for each vertex whether a face uses it.
fn used<F: Sync>(vertices: usize, faces: &[F], corners: impl Fn(&F) -> [u32; 3] + Sync) -> Vec<bool> {
    let used: Vec<AtomicBool> = (0..vertices).map(|_| AtomicBool::new(false)).collect();
    let mark = |v: u32| used[v as usize].store(true, Ordering::Relaxed);
    faces.par_iter().with_min_len(CHUNK).for_each(|face| corners(face).into_iter().for_each(mark));
    used.into_iter().map(AtomicBool::into_inner).collect()
}

/// Whether three points are collinear, by differences of products within 1.5 ulp.
fn is_flat([a, b, c]: [Vec3; 3]) -> bool {
    let (u, v) = (b - a, c - a);
    // Most triangles are far from it: rounding changes these differences by less.
    let is_certain = |i: usize, j: usize| {
        let (p, q) = (u[i] * v[j], u[j] * v[i]);
        (p - q).abs() > 1e-14 * (p.abs() + q.abs()) + 1e-290
    };
    if is_certain(0, 1) || is_certain(1, 2) || is_certain(2, 0) {
        return false;
    }
    let area = |i: usize, j: usize| difference_of_products(u[i], v[j], u[j], v[i]);
    area(0, 1) == 0.0 && area(1, 2) == 0.0 && area(2, 0) == 0.0
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
        assert_eq!((ball.euler_characteristic, ball.shells.count, ball.non_manifold_edges.count), (2, 1, 0));
        let ring = report(&ring(9, 5));
        assert!(ring.is_closed());
        assert_eq!((ring.euler_characteristic, ring.shells.count, ring.open_edges.first), (0, 1, None));
    }

    #[test]
    fn shells_that_share_no_vertex_are_told_apart() {
        let apart = report(&cubes(&[[0, 0, 0], [2, 0, 0], [3, 0, 0]]));
        assert_eq!((apart.shells.count, apart.euler_characteristic, apart.signed_volume), (2, 4, 3.0));
        // An edge of four faces is closed all the same.
        let corner = report(&cubes(&[[0, 0, 0], [1, 1, 0]]));
        assert_eq!(
            (corner.shells.count, corner.non_manifold_edges.count, corner.open_edges.count),
            (1, 1, 0)
        );
        assert_eq!(report(&ball(1).inside_out()).signed_volume, -report(&ball(1)).signed_volume);
    }

    #[test]
    fn an_open_sheet_has_its_rim_open() {
        let sheet = report(&sheet(3));
        assert_eq!((sheet.open_edges.count, sheet.is_closed(), sheet.euler_characteristic), (12, false, 1));
        let (from, to) = (Vec3::ZERO, Vec3::new(0.0, 1.0, 0.0));
        assert_eq!(sheet.open_edges.first, Some(Edge { vertices: [0, 1], from, to, faces: [1, 1] }));
    }

    #[test]
    fn a_face_the_wrong_way_round_shows_at_its_edges() {
        let mut mesh = ball(1);
        mesh.faces[7].swap(0, 1);
        let report = report(&mesh);
        let counts = (report.inconsistent_edges.count, report.open_edges.count, report.duplicate_faces.count);
        assert_eq!(counts, (3, 3, 0));
        assert!(report.inconsistent_edges.first.unwrap().faces.contains(&7));
    }

    #[test]
    fn odd_faces_are_counted_and_open_nothing() {
        let mut mesh = ball(1);
        let [a, b, c] = mesh.faces[0];
        mesh.faces.extend([[a, b, c], [c, b, a], [a, a, b], [c, c, c]]);
        let odd = report(&mesh);
        assert_eq!(odd.duplicate_faces, Tally { count: 2, first: Some([32, 0]) });
        assert_eq!(odd.degenerate_faces, Tally { count: 2, first: Some(34) });
        assert_eq!((odd.open_edges.count, odd.non_manifold_edges.count), (0, 3));
        assert_eq!(odd.non_manifold_edges.first.unwrap().faces, [0, 33]);
        let line = |x: f64| Vec3::new(x, 2.0 * x, -x);
        let vertices = vec![line(0.0), line(1.0), line(3.0)];
        let flat = report(&TriangleMesh::new(vertices, vec![[0, 1, 2]]));
        assert_eq!((flat.zero_area_faces, flat.open_edges.count), (Tally { count: 1, first: Some(0) }, 3));
    }

    #[test]
    fn separate_triangles_are_seen_as_the_surface_they_make() {
        let mut mesh = ring(6, 4).unwelded();
        mesh.vertices.iter_mut().filter(|v| v.z == 0.0).for_each(|v| v.z = 0.0);
        let zeros = mesh.vertices.iter().position(|v| v.z == 0.0).unwrap();
        mesh.vertices[zeros].z = -0.0;
        let (welded, separate) = (report(&ring(6, 4)), report(&mesh));
        assert!(separate.is_closed());
        assert_eq!(separate.duplicate_vertices, Tally { count: 3 * 48 - 24, first: Some([3, 0]) });
        assert_eq!(separate.euler_characteristic, welded.euler_characteristic);
        assert_eq!((separate.shells.count, separate.signed_volume), (1, welded.signed_volume));
    }

    /// Many programs leave unused vertices behind, and mark them by values that are not points.
    #[test]
    fn unused_vertices_are_counted_and_may_be_anything() {
        let mut mesh = ball(1);
        let plain = report(&mesh);
        let (count, twin) = (mesh.vertices.len() as u32, mesh.vertices[0]);
        mesh.vertices.extend([Vec3::NAN, Vec3::splat(1e30), twin, Vec3::INFINITY, Vec3::splat(1e30)]);
        let with_unused = report(&mesh);
        assert_eq!(with_unused.unused_vertices, Tally { count: 5, first: Some(count) });
        let expected = Topology {
            vertices: with_unused.vertices,
            unused_vertices: with_unused.unused_vertices,
            ..plain.clone()
        };
        assert_eq!((with_unused, plain.unused_vertices), (expected, Tally::default()));
    }

    #[test]
    fn the_report_is_the_same_for_any_number_of_threads() {
        // Separate triangles, some of them twice, some flipped, one missing.
        let mut mesh = ring(200, 150).unwelded();
        mesh.faces.extend_from_within(777..1000);
        mesh.faces[50_000].swap(0, 1);
        mesh.faces.swap_remove(20_000);
        let with_threads = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| report(&mesh))
        };
        let expected = with_threads(1);
        assert!(expected.duplicate_faces.count == 223 && expected.open_edges.count > 0);
        assert!([2, 3].into_iter().all(|threads| with_threads(threads) == expected));
    }

    #[test]
    fn sizes_far_from_one_are_seen_the_same() {
        for size in [1e-200, 1e200] {
            let mut mesh = ball(1).inside_out();
            mesh.vertices.iter_mut().for_each(|v| *v *= size);
            let report = report(&mesh);
            assert!(report.signed_volume.is_sign_negative());
            assert_eq!(report.zero_area_faces.count, 0);
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
        assert!(nan.to_string().contains("face 0 uses it"), "{nan}");
        assert_eq!(broken(|m| m.faces.clear()), MeshError::Empty);
        assert_eq!(broken(|m| m.faces.iter_mut().for_each(|f| f[0] = f[1])), MeshError::Empty);
    }
}
