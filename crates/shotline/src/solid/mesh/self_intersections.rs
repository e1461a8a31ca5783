//! Where the faces of a mesh meet other than at the corners and edges that they share.
//!
//! Faces that share no corner are found with a tree of oriented boxes (`pairs`). Two faces that share one corner meet
//! elsewhere if the sectors of directions that they cover from it meet. These are arcs on a sphere; they have a tree of
//! their own if too many faces share the corner to compare all pairs. Two faces that share an edge never pass through
//! each other; they meet only if one is folded onto the other. So the time grows with the number of faces, its
//! logarithm and the number of contacts, however many faces share a corner and however long and thin they are.

use std::sync::atomic::{AtomicU8, Ordering};

use super::distribute::divided;
use super::intersections::common_segment;
use super::pairs::{Item, NONE, Pairs};
use super::separation::{are_apart, sectors_are_apart};
use super::stop::{Cancelled, Stop};
use super::tally::{CROSSES, FaceContacts, TOUCHES};
use super::welded::first_at;
use super::{Intersection, MeshSolid, Tally};
use crate::math::Vec3;

/// Pairs beyond this number are counted but not listed.
const MAX_PAIRS: usize = 1 << 20;

impl MeshSolid {
    /// Returns the pairs of faces that pass through each other. By the rule of the winding number such a mesh still has
    /// an inside.
    pub fn self_intersections(&self) -> Tally<Intersection> {
        self.face_contacts().crossings
    }

    /// How faces meet; computed on the first call.
    pub(super) fn face_contacts(&self) -> &FaceContacts {
        match self.face_contacts.get() {
            Some(known) => known,
            None => {
                let face_contacts = FaceContacts::of(self, Stop::NEVER);
                self.face_contacts.get_or_init(|| face_contacts)
            }
        }
    }

    /// Computes how faces meet, unless that is known.
    ///
    /// # Errors
    /// [`Cancelled`]; the contacts are then still unknown.
    pub(super) fn find_face_contacts(&self, stop: Stop) -> Result<(), Cancelled> {
        if self.face_contacts.get().is_none() {
            let face_contacts = FaceContacts::of(self, stop);
            stop.check()?;
            // Another thread may have set the same result.
            let _ = self.face_contacts.set(face_contacts);
        }
        Ok(())
    }
}

/// The result of one thread.
#[derive(Default)]
struct PartialResult {
    crossings: Tally<Intersection>,
    pairs: Vec<[u32; 2]>,
    too_many: bool,
}

impl PartialResult {
    fn and(mut self, mut other: PartialResult) -> PartialResult {
        self.crossings = both(self.crossings, other.crossings);
        self.too_many |= other.too_many || self.pairs.len() + other.pairs.len() > MAX_PAIRS;
        if self.too_many {
            self.pairs = Vec::new();
        } else if self.pairs.len() < other.pairs.len() {
            other.pairs.append(&mut self.pairs);
            self.pairs = other.pairs;
        } else {
            self.pairs.append(&mut other.pairs);
        }
        self
    }

    fn add_pair(&mut self, pair: [u32; 2]) {
        self.too_many |= self.pairs.len() >= MAX_PAIRS;
        if !self.too_many {
            self.pairs.push(pair);
        }
    }
}

/// Adds the counts, and keeps the item with the lower faces.
fn both(a: Tally<Intersection>, b: Tally<Intersection>) -> Tally<Intersection> {
    let firsts = a.first.into_iter().chain(b.first);
    Tally { count: a.count + b.count, first: firsts.min_by_key(|intersection| intersection.faces) }
}

impl FaceContacts {
    fn of(solid: &MeshSolid, stop: Stop) -> FaceContacts {
        divided(solid.mesh.elements(), || FaceContacts::of_all(solid, stop))
    }

    fn of_all(solid: &MeshSolid, stop: Stop) -> FaceContacts {
        let first_at = first_at(&solid.mesh.vertices);
        let corners = |face: u32| solid.mesh.faces[face as usize].map(|v| first_at[v as usize]);
        let search = Search {
            solid,
            first_at: solid.triangles.iter().map(|t| corners(t.face)).collect(),
            marks: solid.triangles.iter().map(|_| AtomicU8::new(0)).collect(),
            stop,
        };
        let mut found = search.all();
        found.pairs.sort_unstable();
        FaceContacts {
            crossings: found.crossings,
            pairs: (!found.too_many).then_some(found.pairs),
            marks: search.marks.into_iter().map(AtomicU8::into_inner).collect(),
        }
    }
}

struct Search<'a> {
    solid: &'a MeshSolid,
    /// The corners of each item; coincident vertices have one index.
    first_at: Vec<[u32; 3]>,
    marks: Vec<AtomicU8>,
    stop: Stop<'a>,
}

impl Search<'_> {
    fn all(&self) -> PartialResult {
        let items: Vec<Item> = (self.solid.triangles.iter().zip(&self.first_at))
            .map(|(t, &corners)| Item {
                points: [t.corners[0], t.corners[1], t.corners[2], t.corners[2]],
                corners,
            })
            .collect();
        let pairs = Pairs::of(&items, self.stop);
        let visit = |i: u32, j: u32, found: &mut PartialResult| self.examine([i, j], found);
        let mut found = pairs.visit(&visit, &PartialResult::and);
        for (hub, members) in &pairs.hubs {
            let arcs: Vec<Item> = members.iter().map(|&item| self.arc(item, *hub)).collect();
            let visit = |i: u32, j: u32, found: &mut PartialResult| {
                let [i, j] = [members[i as usize], members[j as usize]];
                self.examine([i.min(j), i.max(j)], found);
            };
            found = found.and(Pairs::of(&arcs, self.stop).visit(&visit, &PartialResult::and));
        }
        found
    }

    /// Returns the arc of directions that an item covers from one of its corners, as a convex set around it. If two
    /// faces meet elsewhere, their arcs have at least one direction in common.
    fn arc(&self, item: u32, hub: u32) -> Item {
        let (corners, first_at) = (self.solid.triangles.get(item).corners, self.first_at[item as usize]);
        let k = first_at.iter().position(|intersection| *intersection == hub).unwrap_or(0);
        let [tip, a, b] = [0, 1, 2].map(|i| corners[(k + i) % 3]);
        let (a, b) = ((a - tip).normalize(), (b - tip).normalize());
        let middle = (a + b).normalize();
        let rise = middle * (1.0 - middle.dot(a));
        let points = if rise.is_finite() { [a, b, a + rise, b + rise] } else { AROUND_THE_SPHERE };
        Item { points, corners: [first_at[(k + 1) % 3], first_at[(k + 2) % 3], NONE] }
    }

    /// Examines how two items meet; they may share corners.
    fn examine(&self, [i, j]: [u32; 2], found: &mut PartialResult) {
        let (of_i, of_j) = (self.first_at[i as usize], self.first_at[j as usize]);
        let (a, b) = (self.solid.triangles.get(i), self.solid.triangles.get(j));
        let mut shared = of_i.iter().enumerate().filter_map(|(k, intersection)| {
            of_j.iter().position(|other| other == intersection).map(|l| (k, l))
        });
        let apart = match (shared.next(), shared.next()) {
            // An edge: they do not pass through each other.
            (Some(_), Some(_)) => true,
            (Some((k, l)), None) => {
                let others = |corners: &[Vec3; 3], k: usize| [corners[(k + 1) % 3], corners[(k + 2) % 3]];
                sectors_are_apart(a.corners[k], others(&a.corners, k), others(&b.corners, l))
            }
            _ => are_apart(&a, &b),
        };
        if apart {
            return;
        }
        let mark = match common_segment(a.corners, b.corners) {
            Some([p, q]) => {
                let (faces, point) = ([a.face.min(b.face), a.face.max(b.face)], 0.5 * p + 0.5 * q);
                let crossing = Intersection { faces, point: self.solid.size.unscale(point) };
                found.crossings = both(found.crossings, Tally { count: 1, first: Some(crossing) });
                CROSSES
            }
            None => TOUCHES,
        };
        self.marks[i as usize].fetch_or(mark, Ordering::Relaxed);
        self.marks[j as usize].fetch_or(mark, Ordering::Relaxed);
        found.add_pair([i, j]);
    }
}

/// A tetrahedron around the unit sphere, for arcs whose middle is lost to rounding.
const AROUND_THE_SPHERE: [Vec3; 4] = [
    Vec3::new(4.0, 4.0, 4.0),
    Vec3::new(4.0, -4.0, -4.0),
    Vec3::new(-4.0, 4.0, -4.0),
    Vec3::new(-4.0, -4.0, 4.0),
];

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::solid::mesh::TriangleMesh;
    use crate::solid::mesh::shapes::{fan, needle};
    use crate::testkit::random::Random;

    /// The reference by all pairs.
    fn plainly(solid: &MeshSolid) -> Tally<Intersection> {
        let mut found = Tally::default();
        for (i, a) in solid.triangles.iter().enumerate() {
            for b in solid.triangles.iter().skip(i + 1) {
                if let Some([p, q]) = common_segment(a.corners, b.corners) {
                    let point = solid.size.unscale(0.5 * p + 0.5 * q);
                    found.add(Intersection { faces: [a.face, b.face], point });
                }
            }
        }
        found
    }

    fn agrees(mesh: TriangleMesh) -> usize {
        let solid = MeshSolid::new(Arc::new(mesh), "bvh").unwrap();
        let (fast, plain) = (solid.self_intersections(), plainly(&solid));
        assert_eq!(fast.count, plain.count);
        assert_eq!(fast.first.map(|f| f.faces), plain.first.map(|f| f.faces));
        let listed = solid.face_contacts().pairs.as_ref().map_or(0, |pairs| {
            let crosses = |[i, j]: &&[u32; 2]| {
                let corners = |k: u32| solid.triangles.get(k).corners;
                common_segment(corners(*i), corners(*j)).is_some()
            };
            pairs.iter().filter(crosses).count()
        });
        assert_eq!(listed, plain.count);
        plain.count
    }

    #[test]
    fn random_faces_among_few_vertices_agree_with_all_pairs() {
        let mut random = Random::new(11);
        let mut crossings = 0;
        // Few vertices make hubs; small integers make faces that touch or are coplanar.
        for (vertices, faces) in [(7, 60), (9, 200), (30, 120), (300, 100), (12, 400)] {
            for round in 0..12 {
                let intersection = |random: &mut Random| match round % 3 {
                    0 => random.point(-1.0, 1.0),
                    1 => random.point(-3.0, 3.0).round(),
                    _ => random.point(-3.0, 3.0).round() * Vec3::new(1.0, 1.0, 1e-3) + Vec3::splat(1e6),
                };
                let first_at = (0..vertices).map(|_| intersection(&mut random)).collect();
                let face = |random: &mut Random| [0; 3].map(|_: u32| random.below(vertices) as u32);
                let mesh = TriangleMesh::new(first_at, (0..faces).map(|_| face(&mut random)).collect());
                crossings += agrees(mesh);
            }
        }
        assert!(crossings > 10_000, "{crossings}");
    }

    #[test]
    fn a_cancelled_search_finds_nothing_and_can_be_made_again() {
        let solid = MeshSolid::new(Arc::new(needle(400).with(&fan(400))), "bvh").unwrap();
        let cancel = std::sync::atomic::AtomicBool::new(true);
        assert_eq!(solid.enclosed(Some(&cancel)).err(), Some(Cancelled));
        assert!(solid.face_contacts.get().is_none());
        cancel.store(false, Ordering::Relaxed);
        assert!(solid.enclosed(Some(&cancel)).unwrap().is_some());
        assert_eq!(solid.face_contacts().marks.len(), solid.triangles.len());
    }

    #[test]
    fn faces_around_one_corner_agree_with_all_pairs() {
        let mut random = Random::new(5);
        for n in [30, 200] {
            let mut mesh = TriangleMesh::new(vec![Vec3::ZERO], Vec::new());
            for i in 0..n {
                let at = random.direction() * random.number(0.1, 10.0);
                mesh.vertices.extend([at, at + random.direction() * 0.7 * at.length()]);
                mesh.faces.push([0, 2 * i + 1, 2 * i + 2]);
            }
            assert!(agrees(mesh) > 5);
        }
        assert_eq!((agrees(fan(100)), agrees(needle(100))), (0, 0));
    }

    /// Counts visited pairs instead of measuring time: they must be few compared to all pairs.
    #[test]
    fn few_pairs_are_visited_however_many_faces_share_a_corner() {
        for mesh in [fan(2000), needle(4000)] {
            let solid = MeshSolid::new(Arc::new(mesh), "bvh").unwrap();
            let items: Vec<Item> = (solid.triangles.iter())
                .map(|t| Item {
                    points: [t.corners[0], t.corners[1], t.corners[2], t.corners[2]],
                    corners: solid.mesh.faces[t.face as usize],
                })
                .collect();
            let count = |items: &[Item]| {
                let pairs = Pairs::of(items, Stop::NEVER);
                pairs.visit(&|_, _, n: &mut usize| *n += 1, &|a, b| a + b)
            };
            let n = items.len();
            assert!(count(&items) < 40 * n, "{} of {n}", count(&items));
            let first_at = items.iter().map(|i| i.corners).collect();
            let search = Search { solid: &solid, first_at, marks: vec![], stop: Stop::NEVER };
            for (hub, members) in Pairs::of(&items, Stop::NEVER).hubs {
                let arcs: Vec<Item> = members.iter().map(|&item| search.arc(item, hub)).collect();
                assert!(count(&arcs) < 40 * arcs.len(), "{} of {}", count(&arcs), arcs.len());
            }
        }
    }
}
