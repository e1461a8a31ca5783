//! Where the faces of a mesh meet other than at the corners and edges that they share.
//!
//! Faces that share no corner are found with a tree of oriented boxes (`pairs`). Two faces that share one corner meet
//! elsewhere if the sectors of directions that they cover from it meet. These are arcs on a sphere; they have a tree of
//! their own if too many faces share the corner to compare all pairs. Two faces that share an edge never pass through
//! each other; they meet only if one is folded onto the other. So the time grows with the number of faces, its
//! logarithm and the number of contacts, however many faces share a corner and however long and thin they are. Where too
//! many faces come near to each other, the search ends without a result.

use std::sync::atomic::{AtomicU8, Ordering};

use super::distribute::divided;
use super::effort::Effort;
use super::intersections::{common_segment, has_no_area};
use super::pairs::{Item, NONE, Pairs};
use super::separation::{are_apart, sectors_are_apart};
use super::stop::{Cancelled, Stop};
use super::tally::{CROSSES, FaceContacts, TOUCHES};
use super::welded::first_at;
use super::{Intersection, MeshSolid, Tally};
use crate::math::Vec3;

/// Pairs beyond this number are counted but not listed.
const MAX_PAIRS: usize = 1 << 20;

/// A search may take so many steps, some seconds of one thread, and more for each face.
const STEPS: u64 = if cfg!(test) { 1 << 20 } else { 1 << 23 };
const STEPS_PER_FACE: u64 = 256;

impl MeshSolid {
    /// Returns the pairs of faces that pass through each other; `None` if so many faces come near to each other that it
    /// would take too long to find them. By the rule of the winding number such a mesh still has an inside.
    pub fn self_intersections(&self) -> Option<Tally<Intersection>> {
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
        let steps = STEPS + STEPS_PER_FACE * solid.triangles.len() as u64;
        divided(solid.mesh.elements(), || FaceContacts::within(steps, solid, stop))
    }

    fn within(steps: u64, solid: &MeshSolid, stop: Stop) -> FaceContacts {
        let first_at = first_at(&solid.mesh.vertices);
        let corners = |face: u32| solid.mesh.faces[face as usize].map(|v| first_at[v as usize]);
        let items = solid.triangles.len();
        let search = Search {
            solid,
            first_at: solid.triangles.iter().map(|t| corners(t.face)).collect(),
            marks: solid.triangles.iter().map(|_| AtomicU8::new(0)).collect(),
            effort: Effort::new(steps, stop),
        };
        let mut found = search.all();
        if search.effort.is_exhausted() {
            return FaceContacts { crossings: None, pairs: None, marks: vec![TOUCHES; items] };
        }
        found.pairs.sort_unstable();
        FaceContacts {
            crossings: Some(found.crossings),
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
    effort: Effort<'a>,
}

impl Search<'_> {
    fn all(&self) -> PartialResult {
        let items: Vec<Item> = (self.solid.triangles.iter().zip(&self.first_at))
            .map(|(t, &corners)| Item {
                points: [t.corners[0], t.corners[1], t.corners[2], t.corners[2]],
                corners,
                has_no_area: has_no_area(t.corners),
            })
            .collect();
        let pairs = Pairs::of(&items, &self.effort);
        let visit = |i: u32, j: u32, found: &mut PartialResult| self.examine([i, j], found);
        let mut found = pairs.visit(&visit, &PartialResult::and);
        for (hub, members) in &pairs.hubs {
            let arcs: Vec<Item> = members.iter().map(|&item| self.arc(item, *hub)).collect();
            let visit = |i: u32, j: u32, found: &mut PartialResult| {
                let [i, j] = [members[i as usize], members[j as usize]];
                self.examine([i.min(j), i.max(j)], found);
            };
            found = found.and(Pairs::of(&arcs, &self.effort).visit(&visit, &PartialResult::and));
        }
        found
    }

    /// Returns the arc of directions that an item covers from one of its corners, as a convex set around it. If two
    /// faces meet elsewhere, their arcs have at least one direction in common.
    fn arc(&self, item: u32, hub: u32) -> Item {
        let (corners, first_at) = (self.solid.triangles.get(item).corners, self.first_at[item as usize]);
        let has_no_area = has_no_area(corners);
        let k = first_at.iter().position(|intersection| *intersection == hub).unwrap_or(0);
        let [tip, a, b] = [0, 1, 2].map(|i| corners[(k + i) % 3]);
        let (a, b) = ((a - tip).normalize(), (b - tip).normalize());
        let middle = (a + b).normalize();
        let rise = middle * (1.0 - middle.dot(a));
        let points = if rise.is_finite() { [a, b, a + rise, b + rise] } else { AROUND_THE_SPHERE };
        let corners = [first_at[(k + 1) % 3], first_at[(k + 2) % 3], NONE];
        Item { points, corners, has_no_area }
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
    use crate::solid::mesh::shapes::{ball, fan, needle};
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
        let (fast, plain) = (solid.self_intersections().unwrap(), plainly(&solid));
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

    fn steps_of(mesh: &TriangleMesh) -> u64 {
        let solid = MeshSolid::new(Arc::new(mesh.clone()), "bvh").unwrap();
        let fits = |steps: &u64| FaceContacts::within(*steps, &solid, Stop::NEVER).crossings.is_some();
        (0..40).map(|bits| 1 << bits).find(fits).expect("a search that ends")
    }

    #[test]
    fn faces_along_a_line_are_not_compared_with_each_other() {
        let mut random = Random::new(9);
        let n = 3000;
        let mut along = || f64::from(random.below(1 << 20) as u32) / f64::from(1 << 18) - 2.0;
        let vertices = (0..3 * n).map(|_| Vec3::new(1.0, 2.0, 4.0) * along());
        let line =
            TriangleMesh::new(vertices.collect(), (0..n).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect());
        assert!(steps_of(&line) < 64, "{}", steps_of(&line));
        // Faces with an area are still compared with them.
        let (ball, faces) = (ball(3), ball(3).faces.len());
        let both = MeshSolid::new(Arc::new(ball.with(&line)), "bvh").unwrap();
        assert_eq!(both.self_intersections(), Some(Tally::default()));
        let marks = &both.face_contacts().marks;
        assert!(marks[..faces].contains(&TOUCHES) && marks[faces..].contains(&TOUCHES));
    }

    #[test]
    fn a_search_among_too_many_faces_ends_without_a_result_on_any_number_of_threads() {
        let mut random = Random::new(10);
        let mut mesh = TriangleMesh::default();
        for i in 0..2500 {
            // Long and thin, through the origin.
            let (along, across) = (random.direction() * 10.0, random.direction() * 1e-3);
            mesh.vertices.extend([along, across - along, -across - along]);
            mesh.faces.push([3 * i, 3 * i + 1, 3 * i + 2]);
        }
        let all_pairs = 2500 * 2499 / 2;
        assert!(STEPS + 2500 * STEPS_PER_FACE < all_pairs);
        for threads in [1, 3] {
            let solid = MeshSolid::new(Arc::new(mesh.clone()), "bvh").unwrap();
            assert_eq!(crate::pool::on_threads(threads, |_| solid.self_intersections()), None);
        }
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
                    has_no_area: false,
                })
                .collect();
            let count = |items: &[Item]| {
                let effort = Effort::new(u64::MAX, Stop::NEVER);
                let pairs = Pairs::of(items, &effort);
                pairs.visit(&|_, _, n: &mut usize| *n += 1, &|a, b| a + b)
            };
            let n = items.len();
            assert!(count(&items) < 40 * n, "{} of {n}", count(&items));
            let first_at = items.iter().map(|i| i.corners).collect();
            let effort = Effort::new(u64::MAX, Stop::NEVER);
            let search = Search { solid: &solid, first_at, marks: vec![], effort };
            for (hub, members) in Pairs::of(&items, &search.effort).hubs {
                let arcs: Vec<Item> = members.iter().map(|&item| search.arc(item, hub)).collect();
                assert!(count(&arcs) < 40 * arcs.len(), "{} of {}", count(&arcs), arcs.len());
            }
        }
    }
}
