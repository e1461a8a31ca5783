//! Welding: vertices that are nearly in one place become one.
//!
//! Each vertex goes to the nearest of the vertices that stay, if one is within the distance; else it stays. Vertices are
//! taken in their order, so the result is determined, no vertex is moved farther than the distance, and those that stay are
//! farther apart than that: welding again changes nothing. A chain of vertices, each near the next, is cut into pieces of
//! that size, not drawn together.

use std::collections::HashMap;

use super::nearest::Nearest;
use super::welded::{has_three_places, places};
use super::{MeshError, TriangleMesh};
use crate::math::{Vec3, length};

/// `auto` takes a distance for noise only if the next larger one is so many times larger.
const CLEAR: f64 = 1000.0;

/// `auto` takes no more than this part of the largest coordinate for noise: a few units of the last place of a float32,
/// or of a text of six digits.
const NOISE: f64 = 1.0 / (1 << 20) as f64;

/// Which vertices to weld.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Weld {
    /// Those up to this distance apart, in the lengths of the mesh; with 0 those in exactly one place.
    Within(f64),
    /// Those that are nearer to each other than any others by a wide and clear gap; none where there is no such gap.
    Auto,
}

/// A text or number that is not a distance to weld within.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("'{given}' is not a distance to weld within; give a finite number of at least 0, or auto")]
pub struct WeldError {
    /// What was given.
    pub given: String,
}

impl Weld {
    /// Vertices up to a distance apart.
    ///
    /// # Errors
    /// [`WeldError`] for what is negative or not finite.
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
            Err(_) => Err(WeldError { given: text.into() }),
        }
    }
}

/// What welding did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Welded {
    /// The distance within which vertices were welded; `None` where [`Weld::Auto`] found no clear gap.
    pub distance: Option<f64>,
    /// Vertices that went to another in exactly the same place.
    pub repeated: usize,
    /// Vertices that went to another that was not in exactly the same place.
    pub merged: usize,
    /// The farthest that one of these was moved.
    pub farthest: f64,
    /// The smallest distance between vertices after that; only for [`Weld::Auto`], else `None`.
    pub apart: Option<f64>,
    /// Faces with three corners before and fewer after; they are dropped.
    pub collapsed: usize,
}

impl TriangleMesh {
    /// The mesh with vertices welded, and what that did. Vertices that no face uses stay as they are.
    ///
    /// # Errors
    /// [`MeshError`] for indices out of range and corners that are not finite.
    pub fn welded(&self, weld: Weld) -> Result<(TriangleMesh, Welded), MeshError> {
        super::topology::check(self)?;
        let used = Used::of(self);
        let targets = match weld {
            Weld::Within(distance) => Some((used.targets(distance), distance, None)),
            Weld::Auto => used.clear_gap(self),
        };
        let Some((targets, distance, apart)) = targets else {
            return Ok((self.clone(), Welded::default()));
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

    /// The mesh with corners replaced, without the faces that collapse and the vertices that were replaced.
    fn with_vertices_replaced(&self, target: impl Fn(u32) -> u32, report: &mut Welded) -> TriangleMesh {
        let places = places(&self.vertices);
        let mut number = vec![u32::MAX; self.vertices.len()];
        let mut welded = TriangleMesh::default();
        for (v, vertex) in (0..).zip(&self.vertices) {
            if target(v) == v {
                number[v as usize] = welded.vertices.len() as u32;
                welded.vertices.push(*vertex);
            }
        }
        let replaced = self.vertices.len() - welded.vertices.len();
        report.repeated = replaced - report.merged;
        for (face, corners) in (0..).zip(&self.faces) {
            let new = corners.map(|v| number[target(v) as usize]);
            if has_three_places(&corners.map(|v| places[v as usize])) && !has_three_places(&new) {
                report.collapsed += 1;
                continue;
            }
            welded.faces.push(new);
            welded.polygons.push(self.polygon(face));
        }
        if report.collapsed == 0 && self.polygons.is_empty() {
            welded.polygons.clear();
        }
        welded
    }
}

/// The vertices in use, one for each place.
struct Used<'a> {
    mesh: &'a TriangleMesh,
    /// The first vertex in each place.
    vertices: Vec<u32>,
    /// For each vertex of the mesh the place, as a number of `vertices`; `u32::MAX` for those not in use.
    place: Vec<u32>,
}

impl<'a> Used<'a> {
    fn of(mesh: &'a TriangleMesh) -> Used<'a> {
        let places = places(&mesh.vertices);
        let mut in_use = vec![false; mesh.vertices.len()];
        mesh.faces.iter().flatten().for_each(|v| in_use[*v as usize] = true);
        let mut number = vec![u32::MAX; mesh.vertices.len()];
        let (mut vertices, mut place) = (Vec::new(), vec![u32::MAX; mesh.vertices.len()]);
        for v in (0..mesh.vertices.len()).filter(|v| in_use[*v]) {
            // Of those in use: the first in a place may not be.
            let known = &mut number[places[v] as usize];
            if *known == u32::MAX {
                *known = vertices.len() as u32;
                vertices.push(v as u32);
            }
            place[v] = *known;
        }
        Used { mesh, vertices, place }
    }

    fn at(&self, place: usize) -> Vec3 {
        self.mesh.vertices[self.vertices[place] as usize]
    }

    fn target(&self, targets: &[u32], vertex: u32) -> u32 {
        match self.place[vertex as usize] {
            u32::MAX => vertex,
            place => targets[place as usize],
        }
    }

    /// For each place the vertex that it goes to.
    fn targets(&self, distance: f64) -> Vec<u32> {
        if distance == 0.0 {
            return self.vertices.clone();
        }
        // Twice as wide as needed, so that rounding cannot bring near vertices two cells apart. Where the cells are finer
        // than coordinates, their numbers are coordinates themselves and neighbours are equal.
        let cell = |v: Vec3| (v / (2.0 * distance)).floor() + Vec3::ZERO;
        let key = |v: Vec3| v.to_array().map(f64::to_bits);
        let mut staying: HashMap<[u64; 3], Vec<u32>> = HashMap::new();
        let mut targets = Vec::with_capacity(self.vertices.len());
        for (place, &vertex) in self.vertices.iter().enumerate() {
            let (p, own) = (self.at(place), cell(self.at(place)));
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
            let nearest = distances
                .filter(|(d, _)| *d <= distance)
                .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            targets.push(nearest.map_or(vertex, |(_, v)| v));
            if nearest.is_none() {
                staying.entry(key(own)).or_default().push(vertex);
            }
        }
        targets
    }

    /// The clear gap: targets, a distance within it, and the smallest distance above it.
    fn clear_gap(&self, mesh: &TriangleMesh) -> Option<(Vec<u32>, f64, Option<f64>)> {
        let points: Vec<Vec3> = (0..self.vertices.len()).map(|place| self.at(place)).collect();
        let largest = points.iter().fold(0.0, |m: f64, p| m.max(p.abs().max_element()));
        let mut distances = Nearest::of(&points).distances();
        distances.retain(|d| d.is_finite());
        distances.sort_by(f64::total_cmp);
        // Where the next larger distance is that much larger, or not to be seen since each vertex has another near it.
        let ends = (1..=distances.len()).filter(|&i| {
            distances[i - 1] <= NOISE * largest
                && distances.get(i).is_none_or(|next| *next >= CLEAR * distances[i - 1])
        });
        // From the widest noise on.
        ends.rev().find_map(|i| {
            let noise = distances[i - 1];
            let distance = noise * CLEAR.sqrt();
            let targets = self.targets(distance);
            let farthest = (points.iter().zip(&targets))
                .map(|(p, target)| length(*p - mesh.vertices[*target as usize]))
                .fold(noise, f64::max);
            let mut staying = targets.clone();
            staying.sort_unstable();
            staying.dedup();
            let staying: Vec<Vec3> = staying.iter().map(|v| mesh.vertices[*v as usize]).collect();
            let apart = Nearest::of(&staying).distances().into_iter().fold(f64::INFINITY, f64::min);
            let clear = apart >= CLEAR * farthest && !self.loses_parts(&targets);
            clear.then_some((targets, distance, Some(apart)))
        })
    }

    /// Whether some vertex is left without a face though it had one: then a part of the mesh is as small as the noise.
    fn loses_parts(&self, targets: &[u32]) -> bool {
        let (mut before, mut after) =
            (vec![false; self.mesh.vertices.len()], vec![false; self.mesh.vertices.len()]);
        for corners in &self.mesh.faces {
            let new = corners.map(|v| self.target(targets, v));
            if has_three_places(&corners.map(|v| self.place[v as usize])) {
                new.iter().for_each(|v| before[*v as usize] = true);
            }
            if has_three_places(&new) {
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
    use crate::accel::Scratch;
    use crate::math::Affine;
    use crate::ray::{Line, Span};
    use crate::solid::mesh::shapes::{ball, cubes, ring};
    use crate::solid::mesh::{MeshSolid, Topology};
    use crate::testkit::random::Random;

    fn noisy(mesh: &TriangleMesh, noise: f64) -> TriangleMesh {
        let mut random = Random::new(4);
        let mut mesh = mesh.unwelded();
        for v in &mut mesh.vertices {
            // Some stay where they are.
            *v += random.point(-noise, noise) * f64::from(random.below(2) as u32);
        }
        mesh
    }

    #[test]
    fn noise_is_welded_away_where_the_gap_is_clear() {
        for (noise, size) in [(1e-15, 1.0), (1e-9, 1.0), (1e-4, 1e3), (1e-18, 1e-4)] {
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
        // Distances of every size down to noise, parts as small as noise, and no noise at all.
        let mut every = ring(12, 8).unwelded();
        for v in &mut every.vertices {
            *v += random.point(-1.0, 1.0) * 10f64.powf(random.number(-14.0, -1.0));
        }
        let cube = cubes(&[[0, 0, 0]]);
        let far = cube.clone().moved(&Affine::translation(Vec3::new(1e9, 0.0, 0.0)));
        for mesh in [every, cube.clone().with(&far), ball(3), cube] {
            let (welded, report) = mesh.welded(Weld::Auto).unwrap();
            assert_eq!((welded, report), (mesh, Welded::default()));
        }
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
        // A sliver collapses; the others keep the numbers of their polygons.
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
