//! Parts edges that more than two triangles share, so that readers that expect two at each edge take the mesh as closed: all but one
//! pair of triangles get a vertex of their own in the edge. Two triangles that lie back to back, where an edge of a cell grazes the
//! surface, are left out.

use std::collections::{HashMap, HashSet};
use std::f64::consts::TAU;

use shotline::aabb::Aabb;
use shotline::math::Vec3;
use shotline::solid::mesh::TriangleMesh;

/// A side of a triangle.
#[derive(Clone, Copy, Debug)]
struct Side {
    face: u32,
    /// Its ends, in the order of the corners of the triangle.
    ends: [u32; 2],
    /// The third corner.
    apex: u32,
}

/// The mesh with two triangles at each edge, also for readers that take vertices of one position as one. Triangles keep their
/// places but for cuts along new vertices.
pub fn with_two_triangles_an_edge(mesh: TriangleMesh) -> TriangleMesh {
    let (mut vertices, mut faces) = (mesh.vertices.clone(), without_back_to_back(&welded(&mesh)));
    // A triangle can have several such edges: one is parted in a round.
    loop {
        let shared = shared_edges(&faces);
        if shared.is_empty() {
            return with_used_vertices(&vertices, faces);
        }
        let mut changed = HashSet::new();
        for sides in shared {
            if sides.iter().all(|side| !changed.contains(&side.face)) {
                changed.extend(sides.iter().map(|side| side.face));
                part(&mut vertices, &mut faces, &sides);
            }
        }
    }
}

/// Vertices that are closer than this part of the size of a mesh become one: an edge between them would be too short to be parted.
const CLOSEST: f64 = 1.0 / (1u64 << 40) as f64;

/// The triangles with one vertex for each position, without those that have two corners in one.
fn welded(mesh: &TriangleMesh) -> Vec<[u32; 3]> {
    let size = Aabb::around(mesh.vertices.iter().copied()).size().max_element();
    let step = CLOSEST * size;
    let mut of_position = HashMap::new();
    let first: Vec<u32> = (0..)
        .zip(&mesh.vertices)
        .map(|(number, vertex)| {
            // -0 and 0 are one position.
            let place = vertex.to_array().map(|x| ((x / step).round() + 0.0).to_bits());
            *of_position.entry(place).or_insert(number)
        })
        .collect();
    let welded = mesh.faces.iter().map(|face| face.map(|vertex| first[vertex as usize]));
    welded.filter(|[a, b, c]| a != b && b != c && c != a).collect()
}

/// A mesh of those of the vertices that triangles have.
fn with_used_vertices(vertices: &[Vec3], mut faces: Vec<[u32; 3]>) -> TriangleMesh {
    let mut used = Vec::new();
    let mut new = vec![None; vertices.len()];
    for vertex in faces.iter_mut().flatten() {
        *vertex = *new[*vertex as usize].get_or_insert_with(|| {
            used.push(vertices[*vertex as usize]);
            used.len() as u32 - 1
        });
    }
    TriangleMesh::new(used, faces)
}

/// The triangles without pairs of the same corners in opposite orders.
fn without_back_to_back(faces: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let sorted = |[a, b, c]: [u32; 3]| {
        let least = a.min(b).min(c);
        let first = if least == a {
            [a, b, c]
        } else if least == b {
            [b, c, a]
        } else {
            [c, a, b]
        };
        let is_reversed = first[1] > first[2];
        (if is_reversed { [first[0], first[2], first[1]] } else { first }, is_reversed)
    };
    let mut order: Vec<usize> = (0..faces.len()).collect();
    order.sort_by_key(|face| (sorted(faces[*face]), *face));
    let mut is_kept = vec![true; faces.len()];
    for same in order.chunk_by(|one, other| sorted(faces[*one]).0 == sorted(faces[*other]).0) {
        // Those of one order come first.
        let reversed = same.iter().filter(|face| sorted(faces[**face]).1).count();
        let pairs = reversed.min(same.len() - reversed);
        same[..pairs].iter().chain(&same[same.len() - pairs..]).for_each(|face| is_kept[*face] = false);
    }
    faces.iter().zip(is_kept).filter(|(_, kept)| *kept).map(|(face, _)| *face).collect()
}

/// The sides of triangles at each edge that has more than two.
fn shared_edges(faces: &[[u32; 3]]) -> Vec<Vec<Side>> {
    let of_face = |(face, &[a, b, c]): (u32, &[u32; 3])| {
        [(a, b, c), (b, c, a), (c, a, b)].map(|(start, end, apex)| Side { face, ends: [start, end], apex })
    };
    let edge = |side: &Side| [side.ends[0].min(side.ends[1]), side.ends[0].max(side.ends[1])];
    let mut sides: Vec<Side> = (0..).zip(faces).flat_map(of_face).collect();
    sides.sort_by_key(|side| (edge(side), side.face));
    let runs = sides.chunk_by(|one, other| edge(one) == edge(other));
    runs.filter(|run| run.len() > 2).map(<[Side]>::to_vec).collect()
}

/// Gives the pairs of triangles at an edge vertices of their own; the first pair keeps the edge.
fn part(vertices: &mut Vec<Vec3>, faces: &mut Vec<[u32; 3]>, sides: &[Side]) {
    let pairs = pairs(vertices, sides);
    let count = pairs.len();
    for (number, pair) in pairs.into_iter().enumerate().skip(1) {
        let [start, end] = pair[0].ends.map(|end| vertices[end as usize]);
        let middle = vertices.len() as u32;
        vertices.push(start + (end - start) * (number as f64 / count as f64));
        for Side { face, ends: [start, end], apex } in pair {
            faces[face as usize] = [start, middle, apex];
            faces.push([middle, end, apex]);
        }
    }
}

/// The triangles at an edge in pairs of opposite directions, so that what is between those of a pair is inside.
fn pairs(vertices: &[Vec3], sides: &[Side]) -> Vec<[Side; 2]> {
    let [first, second] = sides[0].ends.map(|end| vertices[end as usize]);
    let axis = (second - first).normalize_or_zero();
    let across = axis.any_orthogonal_vector();
    let angle = |side: &Side| {
        let to_apex = vertices[side.apex as usize] - first;
        to_apex.dot(axis.cross(across)).atan2(to_apex.dot(across))
    };
    let (forward, mut backward): (Vec<Side>, Vec<Side>) =
        sides.iter().partition(|side| side.ends == sides[0].ends);
    let mut pairs = Vec::new();
    for one in forward {
        // A triangle that runs along the axis has its inside where the angle falls.
        let turn = |other: &Side| (angle(&one) - angle(other)).rem_euclid(TAU);
        let nearest = (0..backward.len()).min_by(|a, b| turn(&backward[*a]).total_cmp(&turn(&backward[*b])));
        if let Some(nearest) = nearest {
            pairs.push([one, backward.swap_remove(nearest)]);
        }
    }
    pairs
}

#[cfg(test)]
mod tests {
    use shotline::solid::mesh::Topology;

    use super::*;

    #[test]
    fn triangles_back_to_back_are_left_out() {
        let faces = [[0, 1, 2], [4, 3, 1], [2, 1, 0], [1, 3, 4], [1, 2, 0], [5, 6, 7]];
        assert_eq!(without_back_to_back(&faces), [[1, 2, 0], [5, 6, 7]]);
    }

    /// Vertices of one position, which an STL file does not tell apart, made an edge of four triangles when it was read.
    #[test]
    fn vertices_of_one_position_are_one() {
        let at = |x: f64, y: f64| Vec3::new(x, y, 0.0);
        let vertices =
            vec![at(0.0, 0.0), at(1.0, 0.0), at(0.0, 1.0), at(-0.0, 0.0), at(9.0, 9.0), at(5.0, 0.0)];
        let faces = vec![[0, 1, 2], [0, 3, 1], [3, 2, 1], [5, 1, 2]];
        let mesh = with_two_triangles_an_edge(TriangleMesh::new(vertices, faces));
        assert_eq!(mesh.faces, [[0, 1, 2]]);
        assert_eq!(mesh.vertices, [at(5.0, 0.0), at(1.0, 0.0), at(0.0, 1.0)]);
    }

    /// An edge of a few units in the last place was parted at one of its ends.
    #[test]
    fn vertices_that_are_too_close_are_one() {
        let at = |x: f64, y: f64| Vec3::new(x, y, 0.0);
        let vertices = vec![at(0.0, 0.0), at(1.0, 0.0), at(0.0, 1.0), at(1.0 + 1e-15, 0.0)];
        let mesh = TriangleMesh::new(vertices, vec![[0, 1, 2], [1, 3, 2]]);
        assert_eq!(with_two_triangles_an_edge(mesh).faces, [[0, 1, 2]]);
    }

    /// Two tetrahedra that touch along an edge get a vertex in it, which one of them has.
    #[test]
    fn bodies_that_touch_along_an_edge_are_parted() {
        let at = |x: f64, y: f64, z: f64| Vec3::new(x, y, z);
        let vertices = vec![
            at(0.0, 0.0, 0.0),
            at(0.0, 0.0, 1.0),
            at(1.0, -0.2, 0.5),
            at(1.0, 0.2, 0.5),
            at(-1.0, 0.2, 0.5),
            at(-1.0, -0.2, 0.5),
        ];
        let tetrahedron = |a, b, c, d| [[a, c, b], [a, b, d], [a, d, c], [b, c, d]];
        let faces = [tetrahedron(0, 1, 2, 3), tetrahedron(0, 1, 4, 5)].concat();
        let touching = TriangleMesh::new(vertices, faces);
        assert!(Topology::of(&touching).unwrap().is_closed());
        let parted = with_two_triangles_an_edge(touching.clone());
        assert_eq!((parted.vertices.len(), parted.faces.len()), (7, 10));
        assert!(shared_edges(&parted.faces).is_empty() && Topology::of(&parted).unwrap().is_closed());
        // The new vertex is in triangles of one of the two bodies only.
        let side = |face: &[u32; 3]| {
            let corners = face.map(|vertex| parted.vertices[vertex as usize]);
            let has_it = corners.contains(&at(0.0, 0.0, 0.5));
            has_it.then(|| corners.iter().map(|corner| corner.x).sum::<f64>() > 0.0)
        };
        let sides: Vec<bool> = parted.faces.iter().filter_map(side).collect();
        assert!(sides.len() == 4 && sides.iter().all(|side| *side == sides[0]));
        let volume = |mesh: &TriangleMesh| -> f64 {
            (0..mesh.faces.len() as u32)
                .map(|face| mesh.corners(face))
                .map(|[a, b, c]| a.dot(b.cross(c)))
                .sum()
        };
        assert!((volume(&parted) - volume(&touching)).abs() < 1e-15);
    }
}
