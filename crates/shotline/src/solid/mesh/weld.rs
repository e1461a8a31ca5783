//! Welding: merges vertices that nearly coincide.
//!
//! First the vertices that stay are chosen: in their order, each vertex that is farther than the distance from all
//! vertices chosen before it. Then each of the others is merged into the nearest vertex that stays, or the first of
//! several. So the result is deterministic, no vertex moves farther than the distance, and those that stay are farther
//! apart than that: welding again changes nothing. A chain of vertices, each near the next, is cut into pieces of that
//! size, not collapsed into one.

use std::collections::HashMap;

use super::corners::Corners;
use super::nearest::Nearest;
use super::welded::{first_at, has_three_corners};
use super::{MeshError, TriangleMesh};
use crate::math::{Vec3, length};

/// `auto` treats a distance as noise only if the next larger one is at least this many times larger.
const CLEAR: f64 = 1000.0;

/// `auto` merges two vertices only within this many units in the last place of the largest coordinate of their faces.
/// That is the rounding that a chain of transforms in float64 leaves; anything wider may be a feature of the model.
const ROUNDING: f64 = 64.0;

/// Which vertices to weld.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Weld {
    /// Those at most this distance apart, in the unit of the mesh; 0 welds those that coincide exactly.
    Within(f64),
    /// Those within rounding of each other: at most 64 units in the last place (float64) of the largest coordinate of
    /// their faces apart, and all other vertices at least a thousand times farther apart. Welds nothing if there is no
    /// such gap.
    Auto,
}

/// A text or number that is not a valid welding distance.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{given} is not a distance to weld within; give a finite number of at least 0, or auto")]
pub struct WeldError {
    /// The input: a number as it was written, a text in quotes.
    pub given: String,
}

impl Weld {
    /// Welds vertices at most a distance apart.
    ///
    /// # Errors
    /// [`WeldError`] if the distance is negative or not finite.
    pub fn within(distance: f64) -> Result<Weld, WeldError> {
        let valid = distance >= 0.0 && distance.is_finite();
        if valid { Ok(Weld::Within(distance)) } else { Err(WeldError { given: distance.to_string() }) }
    }
}

impl std::str::FromStr for Weld {
    type Err = WeldError;

    fn from_str(text: &str) -> Result<Weld, WeldError> {
        match text.parse() {
            _ if text == "auto" => Ok(Weld::Auto),
            Ok(distance) => Weld::within(distance).map_err(|_| WeldError { given: text.into() }),
            Err(_) => Err(WeldError { given: format!("'{text}'") }),
        }
    }
}

/// The result of welding.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Welded {
    /// The distance within which vertices were welded; `None` if [`Weld::Auto`] welded nothing.
    pub distance: Option<f64>,
    /// Vertices within rounding of another, but not exactly at its position, that [`Weld::Auto`] did not merge because
    /// there is no clear gap.
    pub unclear: usize,
    /// Vertices merged into another at exactly the same position.
    pub repeated: usize,
    /// Vertices merged into another at a different position.
    pub merged: usize,
    /// The largest distance that one of these moved.
    pub farthest: f64,
    /// The smallest distance between vertices afterwards; only for [`Weld::Auto`], else `None`.
    pub apart: Option<f64>,
    /// Faces that had three distinct corners before and have fewer after; they are dropped.
    pub collapsed: usize,
}

impl TriangleMesh {
    /// Welds vertices. Returns the new mesh and a report. Vertices that no face uses stay as they are.
    ///
    /// # Errors
    /// [`MeshError`] if an index is out of range or a corner is not finite.
    pub fn welded(&self, weld: Weld) -> Result<(TriangleMesh, Welded), MeshError> {
        Corners::of(self)?;
        let used = Used::of(self);
        let targets = match weld {
            Weld::Within(distance) => Some((used.targets(distance), distance, None)),
            Weld::Auto => used.clear_gap(self),
        };
        let Some((targets, distance, apart)) = targets else {
            return Ok((self.clone(), Welded { unclear: used.within_rounding(), ..Welded::default() }));
        };
        let mut report = Welded { distance: Some(distance), apart, ..Welded::default() };
        for (&vertex, &target) in used.vertices.iter().zip(&targets) {
            let moved = length(self.vertices[vertex as usize] - self.vertices[target as usize]);
            report.merged += usize::from(moved > 0.0);
            report.farthest = report.farthest.max(moved);
        }
        let welded = self.with_vertices_replaced(|v| used.target(&targets, v), &mut report);
        Ok((welded, report))
    }

    /// Returns the mesh with its corners replaced, without the faces that collapse and the vertices that were replaced.
    fn with_vertices_replaced(&self, target: impl Fn(u32) -> u32, report: &mut Welded) -> TriangleMesh {
        let first_at = first_at(&self.vertices);
        let mut number = vec![u32::MAX; self.vertices.len()];
        let mut welded = TriangleMesh::default();
        for (v, vertex) in (0..).zip(&self.vertices) {
            if target(v) == v {
                number[v as usize] = welded.vertices.len() as u32;
                welded.vertices.push(*vertex);
            }
        }
        let mut kept = Vec::with_capacity(self.faces.len());
        let replaced = self.vertices.len() - welded.vertices.len();
        report.repeated = replaced - report.merged;
        for (face, corners) in (0..).zip(&self.faces) {
            let new = corners.map(|v| number[target(v) as usize]);
            if has_three_corners(&corners.map(|v| first_at[v as usize])) && !has_three_corners(&new) {
                report.collapsed += 1;
                continue;
            }
            welded.faces.push(new);
            welded.polygons.push(self.polygon(face));
            kept.push(face);
        }
        if report.collapsed == 0 && self.polygons.is_empty() {
            welded.polygons.clear();
        }
        welded.attributes = self.attributes.iter().map(|a| a.of_faces(&self.faces, &kept)).collect();
        welded
    }
}

/// The used vertices, one for each position.
struct Used<'a> {
    mesh: &'a TriangleMesh,
    /// The first used vertex at each position.
    vertices: Vec<u32>,
    /// For each vertex of the mesh its position, as an index into `vertices`; `u32::MAX` if it is unused.
    position: Vec<u32>,
    /// For each position the largest coordinate of the faces there. Near the origin, rounding is that of the numbers
    /// from which the small coordinates were computed.
    largest: Vec<f64>,
}

impl<'a> Used<'a> {
    fn of(mesh: &'a TriangleMesh) -> Used<'a> {
        let first_at = first_at(&mesh.vertices);
        let mut in_use = vec![false; mesh.vertices.len()];
        mesh.faces.iter().flatten().for_each(|v| in_use[*v as usize] = true);
        let mut number = vec![u32::MAX; mesh.vertices.len()];
        let (mut vertices, mut position) = (Vec::new(), vec![u32::MAX; mesh.vertices.len()]);
        for v in (0..mesh.vertices.len()).filter(|v| in_use[*v]) {
            // Number the used vertices: the first vertex at a position may be unused.
            let known = &mut number[first_at[v] as usize];
            if *known == u32::MAX {
                *known = vertices.len() as u32;
                vertices.push(v as u32);
            }
            position[v] = *known;
        }
        let mut largest = vec![0.0; vertices.len()];
        for corners in &mesh.faces {
            let of_face = corners.map(|v| mesh.vertices[v as usize].abs().max_element());
            let of_face = of_face.into_iter().fold(0.0, f64::max);
            for v in corners {
                let of_place: &mut f64 = &mut largest[position[*v as usize] as usize];
                *of_place = of_place.max(of_face);
            }
        }
        Used { mesh, vertices, position, largest }
    }

    fn at(&self, position: usize) -> Vec3 {
        self.mesh.vertices[self.vertices[position] as usize]
    }

    fn target(&self, targets: &[u32], vertex: u32) -> u32 {
        match self.position[vertex as usize] {
            u32::MAX => vertex,
            position => targets[position as usize],
        }
    }

    /// Returns for each position the vertex that it is merged into.
    fn targets(&self, distance: f64) -> Vec<u32> {
        if distance == 0.0 {
            return self.vertices.clone();
        }
        // Cells are twice as wide as needed, so that rounding cannot put near vertices two cells apart. Where cells are
        // finer than the spacing of coordinates, cell numbers are coordinates themselves and neighbouring cells are
        // equal.
        let cell = |v: Vec3| (v / (2.0 * distance)).floor() + Vec3::ZERO;
        let key = |v: Vec3| v.to_array().map(f64::to_bits);
        let mut staying: HashMap<[u64; 3], Vec<u32>> = HashMap::new();
        let nearest = |p: Vec3, staying: &HashMap<[u64; 3], Vec<u32>>| {
            let own = cell(p);
            let mut keys: Vec<[u64; 3]> = Vec::with_capacity(27);
            for i in 0..27 {
                let step = Vec3::new(f64::from(i % 3 - 1), f64::from(i / 3 % 3 - 1), f64::from(i / 9 - 1));
                let key = key(own + step + Vec3::ZERO);
                if !keys.contains(&key) {
                    keys.push(key);
                }
            }
            let near = keys.iter().filter_map(|key| staying.get(key)).flatten();
            let distances = near.map(|v| (length(self.mesh.vertices[*v as usize] - p), *v));
            let within = distances.filter(|(d, _)| *d <= distance);
            within.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))).map(|(_, v)| v)
        };
        let mut goes = Vec::new();
        for (position, &vertex) in self.vertices.iter().enumerate() {
            let p = self.at(position);
            if nearest(p, &staying).is_some() {
                goes.push(position);
            } else {
                staying.entry(key(cell(p))).or_default().push(vertex);
            }
        }
        let mut targets = self.vertices.clone();
        for position in goes {
            // A vertex that stays is within the distance; otherwise this vertex would stay itself.
            targets[position] = nearest(self.at(position), &staying).unwrap_or(targets[position]);
        }
        targets
    }

    /// The largest distance to another position that rounding alone can explain.
    fn rounding(&self, position: usize) -> f64 {
        let largest = self.largest[position];
        ROUNDING * (largest.next_up() - largest)
    }

    /// Returns the distances from positions to the nearest other, ascending, each with whether rounding explains it.
    fn nearest_distances(&self) -> Vec<(f64, bool)> {
        let points: Vec<Vec3> = (0..self.vertices.len()).map(|position| self.at(position)).collect();
        let distances = Nearest::of(&points).distances();
        let finite = distances.into_iter().enumerate().filter(|(_, d)| d.is_finite());
        let mut found: Vec<(f64, bool)> = finite.map(|(i, d)| (d, d <= self.rounding(i))).collect();
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        found
    }

    /// The number of positions within rounding of another.
    fn within_rounding(&self) -> usize {
        self.nearest_distances().iter().filter(|(_, is_rounding)| *is_rounding).count()
    }

    /// Finds the clear gap. Returns the targets, a distance within the gap, and the smallest distance above it.
    fn clear_gap(&self, mesh: &TriangleMesh) -> Option<(Vec<u32>, f64, Option<f64>)> {
        let distances = self.nearest_distances();
        let noise = distances.iter().take_while(|(_, is_rounding)| *is_rounding).count();
        // Where the next larger distance is that much larger, or is unknown because each vertex has another near it.
        let ends = (1..=noise)
            .filter(|&i| distances.get(i).is_none_or(|(next, _)| *next >= CLEAR * distances[i - 1].0));
        // The widest noise first.
        ends.rev().find_map(|i| {
            let noise = distances[i - 1].0;
            let distance = noise * CLEAR.sqrt();
            let targets = self.targets(distance);
            let mut farthest = noise;
            for (position, target) in targets.iter().enumerate() {
                let moved = length(self.at(position) - mesh.vertices[*target as usize]);
                // The same distance may be rounding of large coordinates and far more than that of small ones.
                if moved > self.rounding(position) {
                    return None;
                }
                farthest = farthest.max(moved);
            }
            let mut staying = targets.clone();
            staying.sort_unstable();
            staying.dedup();
            let staying: Vec<Vec3> = staying.iter().map(|v| mesh.vertices[*v as usize]).collect();
            let apart = Nearest::of(&staying).distances().into_iter().fold(f64::INFINITY, f64::min);
            let clear = apart >= CLEAR * farthest && !self.loses_parts(&targets);
            clear.then_some((targets, distance, Some(apart)))
        })
    }

    /// Whether some vertex loses all its faces: then a feature of the mesh is as small as the noise.
    fn loses_parts(&self, targets: &[u32]) -> bool {
        let (mut before, mut after) =
            (vec![false; self.mesh.vertices.len()], vec![false; self.mesh.vertices.len()]);
        for corners in &self.mesh.faces {
            let new = corners.map(|v| self.target(targets, v));
            if has_three_corners(&corners.map(|v| self.position[v as usize])) {
                new.iter().for_each(|v| before[*v as usize] = true);
            }
            if has_three_corners(&new) {
                new.iter().for_each(|v| after[*v as usize] = true);
            }
        }
        before != after
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::math::Affine;
    use crate::ray::{Line, Span};
    use crate::scratch::Scratch;
    use crate::solid::mesh::shapes::{ball, cubes, ring};
    use crate::solid::mesh::{MeshSolid, Topology};
    use crate::testkit::random::Random;

    fn noisy(mesh: &TriangleMesh, noise: f64) -> TriangleMesh {
        let mut random = Random::new(4);
        let mut mesh = mesh.unwelded();
        for v in &mut mesh.vertices {
            // Some vertices do not move.
            *v += random.point(-noise, noise) * f64::from(random.below(2) as u32);
        }
        mesh
    }

    #[test]
    fn noise_is_welded_away_where_the_gap_is_clear() {
        for (noise, size) in [(1e-15, 1.0), (1e-12, 1e3), (1e-19, 1e-4)] {
            let map = Affine::scaling(Vec3::splat(size));
            let mesh = noisy(&ring(12, 8).moved(&map), noise);
            assert!(!Topology::of(&mesh).unwrap().is_closed());
            let (welded, report) = mesh.welded(Weld::Auto).unwrap();
            assert!(Topology::of(&welded).unwrap().is_closed(), "{report:?}");
            assert_eq!((welded.vertices.len(), report.collapsed), (96, 0));
            assert!(report.farthest <= 4.0 * noise && report.apart.unwrap() > 0.1 * size, "{report:?}");
            assert_eq!(mesh.welded(Weld::within(report.farthest * 2.0).unwrap()).unwrap().0, welded);
        }
    }

    #[test]
    fn where_no_gap_is_clear_auto_welds_nothing() {
        let mut random = Random::new(9);
        // Distances of every size down to noise, features as small as noise, and no noise at all.
        let mut every = ring(12, 8).unwelded();
        for v in &mut every.vertices {
            *v += random.point(-1.0, 1.0) * 10f64.powf(random.number(-14.0, -1.0));
        }
        let cube = cubes(&[[0, 0, 0]]);
        let far = cube.clone().moved(&Affine::translation(Vec3::new(1e9, 0.0, 0.0)));
        for mesh in [every, cube.clone().with(&far), ball(3), cube] {
            let (welded, report) = mesh.welded(Weld::Auto).unwrap();
            assert_eq!((welded, report.distance, report.merged), (mesh, None, 0));
        }
    }

    #[test]
    fn auto_merges_no_feature_that_is_wider_than_rounding() {
        let cube = cubes(&[[0, 0, 0]]);
        let plate = |scale: Vec3, at: Vec3| {
            cube.clone().moved(&Affine::scaling(scale)).moved(&Affine::translation(at))
        };
        let thin = |height| plate(Vec3::new(1.0, 1.0, height), Vec3::ZERO);
        let far = |height| plate(Vec3::new(1.0, 1.0, height), Vec3::splat(5e6));
        let gap = |gap, x| plate(Vec3::ONE, Vec3::X * x).with(&plate(Vec3::ONE, Vec3::X * (x + 1.0 + gap)));
        // Far away, a distance of nearly this size is rounding.
        let mixed = thin(1e-6).with(&gap(2.4e-7, 1e9));
        let features = [
            thin(1e-9),
            thin(1e-12),
            far(5e-4),
            far(1e-6),
            gap(1e-12, 0.0),
            gap(1e-9, 0.0),
            gap(5e-4, 5e6),
            mixed,
        ];
        for mesh in features {
            let (welded, report) = mesh.welded(Weld::Auto).unwrap();
            assert_eq!((welded, report.distance, report.merged), (mesh, None, 0));
        }
    }

    #[test]
    fn each_vertex_goes_to_the_nearest_that_stays_also_to_a_later_one() {
        let vertices = vec![Vec3::ZERO, Vec3::X * 0.15, Vec3::X * 0.25, Vec3::Y, Vec3::ONE];
        let mesh = TriangleMesh::new(vertices, vec![[0, 3, 4], [1, 3, 4], [2, 3, 4]]);
        let (welded, report) = mesh.welded(Weld::Within(0.2)).unwrap();
        assert_eq!(welded.faces, [[0, 2, 3], [1, 2, 3], [1, 2, 3]]);
        assert!(report.merged == 1 && report.farthest < 0.11, "{report:?}");
    }

    #[test]
    fn vertices_that_coincide_exactly_are_not_an_unclear_gap() {
        let (_, report) = cubes(&[[0, 0, 0]]).unwelded().welded(Weld::Auto).unwrap();
        assert_eq!(report, Welded::default());
        // Distances of 1, 1e2, 1e4, ... units in the last place have no clear gap.
        let chain = (0..6).map(|i| Vec3::X * (1.0 + f64::EPSILON * 100f64.powi(i)));
        let vertices: Vec<Vec3> = [Vec3::X, Vec3::Y].into_iter().chain(chain).collect();
        let faces = (2..7).map(|i| [i, i + 1, 1]).chain([[0, 2, 1]]).collect();
        let (_, report) = TriangleMesh::new(vertices, faces).welded(Weld::Auto).unwrap();
        assert_eq!((report.distance, report.unclear), (None, 2));
    }

    #[test]
    fn nothing_moves_farther_than_the_distance_and_a_second_time_changes_nothing() {
        let mut random = Random::new(2);
        for distance in [0.0, 1e-3, 0.05, 0.3] {
            for _ in 0..20 {
                // Chains, clusters and exact copies.
                let vertices: Vec<Vec3> = (0..60)
                    .map(|i| match i % 3 {
                        0 => Vec3::X * f64::from(i) * 0.02,
                        1 => random.point(-1.0, 1.0),
                        _ => random.point(-2.0, 2.0).round() * 0.5,
                    })
                    .collect();
                let mut face = || [0; 3].map(|_: u32| random.below(60) as u32);
                let mesh = TriangleMesh::new(vertices, (0..80).map(|_| face()).collect());
                let (welded, report) = mesh.welded(Weld::Within(distance)).unwrap();
                assert!(report.farthest <= distance);
                let (again, none) = welded.welded(Weld::Within(distance)).unwrap();
                assert_eq!((none.merged, none.repeated, none.collapsed), (0, 0, 0));
                assert_eq!(again, welded);
                assert_eq!(welded.faces.len() + report.collapsed, mesh.faces.len());
                let (u, m) = (welded.vertices.len(), mesh.vertices.len());
                assert_eq!(u + report.merged + report.repeated, m);
            }
        }
    }

    #[test]
    fn a_chain_does_not_draw_a_feature_together() {
        let line = (0..100).map(|i| Vec3::X * f64::from(i)).chain([Vec3::new(0.0, 50.0, 0.0)]).collect();
        let fan = TriangleMesh::new(line, (0..99).map(|i| [i, i + 1, 100]).collect());
        let (welded, report) = fan.welded(Weld::Within(1.0)).unwrap();
        assert_eq!((welded.faces.len(), report.collapsed, report.farthest), (49, 50, 1.0));
    }

    #[test]
    fn vertices_in_one_place_and_polygons_are_kept() {
        let mesh = ring(9, 5).unwelded();
        let (welded, report) = mesh.welded(Weld::Within(0.0)).unwrap();
        assert_eq!((report.repeated, report.merged, welded.vertices.len()), (270 - 45, 0, 45));
        let hits = |mesh: TriangleMesh| {
            let mut random = Random::new(1);
            let solid = MeshSolid::new(Arc::new(mesh), "bvh").unwrap();
            let mut hits = Vec::new();
            for _ in 0..200 {
                let line = Line::exact(random.point(-4.0, 4.0), random.direction());
                solid.hits(&line, Span::FORWARD, &mut hits, &mut Scratch::default());
            }
            hits
        };
        assert_eq!(hits(mesh), hits(welded));
        // A sliver collapses; the other faces keep the numbers of their polygons.
        let mut mesh = cubes(&[[0, 0, 0]]);
        mesh.vertices.push(mesh.vertices[mesh.faces[3][0] as usize] + Vec3::X * 1e-12);
        let v = mesh.vertices.len() as u32 - 1;
        let [a, b, c] = mesh.faces[3];
        mesh.faces[3] = [v, b, c];
        mesh.faces.insert(4, [a, b, v]);
        let (welded, report) = mesh.welded(Weld::Within(1e-9)).unwrap();
        assert_eq!((report.merged, report.collapsed), (1, 1));
        assert_eq!(welded.polygons, [0, 1, 2, 3, 5, 6, 7, 8, 9, 10, 11, 12]);
    }

    #[test]
    fn unused_vertices_and_bad_distances() {
        let mut mesh = cubes(&[[0, 0, 0]]);
        mesh.vertices.extend([Vec3::NAN, mesh.vertices[0]]);
        let (welded, report) = mesh.welded(Weld::Within(1e-3)).unwrap();
        assert_eq!((report.merged + report.repeated, welded.vertices.len()), (0, 10));
        for bad in ["-1", "inf", "nan", "far", ""] {
            let error = bad.parse::<Weld>().unwrap_err().to_string();
            assert!(error.contains("at least 0, or auto"), "{error}");
        }
        assert_eq!(("auto".parse(), "1e-6".parse()), (Ok(Weld::Auto), Ok(Weld::Within(1e-6))));
    }
}
