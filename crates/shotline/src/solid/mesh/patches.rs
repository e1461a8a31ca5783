//! The winding numbers on both sides of every face, from few lines.
//!
//! A *patch* is a set of faces that are connected across edges and meet no other faces. The front of one face of a
//! patch is connected to the front of its neighbour around their edge, without a face between them. So a line through
//! one face gives the winding numbers of all. A face that passes through others or touches others is a patch of its
//! own. Where patches meet at an edge of more than two faces, the sides that face each other around the edge have the
//! same winding number.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use rayon::prelude::*;

use super::edges::Link;
use super::shells::Shells;
use super::stop::{Cancelled, Stop};
use super::winding::sides_of;
use super::{MeshSolid, Tally, mesh_line::Triangle};
use crate::math::Vec3;
use crate::pool;
use crate::ray::{Line, Span};
use crate::scratch::Scratch;

/// Faces that all have the same winding number on the front, and all the same on the back.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Patch {
    /// The triangles of the solid in it, in ascending order.
    pub(super) items: Vec<u32>,
    /// The winding numbers on the front and on the back; `None` if they are unknown because no line hits the face.
    pub(super) sides: Option<[i32; 2]>,
    /// The winding number inside a sound mesh: 1, or -1 if it is wound inward.
    pub(super) inside: i32,
}

impl Patch {
    /// Whether the winding numbers are known, and 0 or that of the inside.
    pub(super) fn is_sound(&self) -> bool {
        self.sides.is_some_and(|sides| sides.iter().all(|w| *w == 0 || *w == self.inside))
    }
}

/// What follows from the winding numbers on both sides of all faces of a closed mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Winding {
    /// Whether the winding number is either 0 or one other number everywhere, 1 or -1. Then the signed volume is that
    /// of the inside.
    pub once: bool,
    /// Faces with the same winding number on both sides because coincident faces have the opposite orientation. They
    /// cancel, and no ray has a crossing there.
    pub cancelling: Tally<u32>,
    /// Whether the inside ends, or may end, at any face. If not, no ray ever has a crossing.
    pub can_be_hit: bool,
    /// Faces with a negative winding number on a side. That side is inside all the same.
    pub negative: Tally<u32>,
    /// Whether no faces pass through each other, and no two known winding numbers have opposite signs.
    pub consistent: bool,
}

impl MeshSolid {
    /// Computes the winding numbers on both sides of all faces, and what follows from them; `None` for a mesh that is
    /// not closed. Takes as long as [`MeshSolid::self_intersections`], and if that has no result, nothing is known.
    ///
    /// Exact where faces meet only at their edges and corners. The sides of a face that others touch or pass through
    /// are those at its centroid.
    pub fn winding(&self) -> Option<Winding> {
        if !self.is_closed() {
            return None;
        }
        let Ok(patches) = self.patches(Stop::NEVER) else { return None };
        let faces = |is_meant: fn([i32; 2]) -> bool| {
            let meant = patches.iter().filter(|patch| patch.sides.is_some_and(is_meant));
            let items = meant.flat_map(|patch| &patch.items);
            let mut faces: Vec<u32> = items.map(|item| self.triangles.face(*item)).collect();
            faces.sort_unstable();
            faces.into_iter().collect::<Tally<u32>>()
        };
        let negative = faces(|sides| sides.iter().any(|w| *w < 0));
        let is_positive = |patch: &Patch| patch.sides.is_some_and(|sides| sides.iter().any(|w| *w > 0));
        let crosses = self.face_contacts().may_cross();
        let ends = |patch: &Patch| patch.sides.is_none_or(|[front, back]| (front == 0) != (back == 0));
        Some(Winding {
            once: !crosses && patches.iter().all(Patch::is_sound),
            cancelling: faces(|[front, back]| front == back),
            can_be_hit: crosses || patches.iter().any(ends),
            negative,
            consistent: !crosses && (negative.count == 0 || !patches.iter().any(is_positive)),
        })
    }

    /// The winding number inside, where the mesh is sound.
    pub(super) fn inside(&self) -> i32 {
        if self.topology.signed_volume < 0.0 { -1 } else { 1 }
    }

    /// The patches of a closed mesh, in the order of their first faces.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub(super) fn patches(&self, stop: Stop) -> Result<Vec<Patch>, Cancelled> {
        pool::divided(|| self.find_patches(stop))
    }

    fn find_patches(&self, stop: Stop) -> Result<Vec<Patch>, Cancelled> {
        self.find_face_contacts(stop)?;
        let inside = self.inside();
        if self.face_contacts().crossings.is_none() {
            // Every face would be a patch of its own, and every line may meet all of them.
            let items = (0..self.triangles.len() as u32).collect();
            return Ok(vec![Patch { items, sides: None, inside }]);
        }
        let edges = self.edges();
        let meets_others = self.meets_others(&edges);
        let (patches, patch_of) = grouped(self.joined_by_edges(&edges, &meets_others), self.triangles.len());
        let links: Vec<Link> = self.links(&edges, &meets_others);
        let links =
            links.into_iter().map(|link| Link { items: link.items.map(|i| patch_of[i as usize]), ..link });
        let sides = self.sides_of_patches(&patches, &links.collect::<Vec<_>>(), stop);
        stop.check()?;
        Ok(patches.into_iter().zip(sides).map(|(items, sides)| Patch { items, sides, inside }).collect())
    }

    /// Returns the winding numbers on both sides of patches, given their links. A line is cast for one of several
    /// linked patches, and for another if that line gives no result; the others follow from the links.
    fn sides_of_patches(&self, patches: &[Vec<u32>], links: &[Link], stop: Stop) -> Vec<Option<[i32; 2]>> {
        let mut forest = Shells::singletons(patches.len());
        let mut links_of: Vec<Vec<(u32, [usize; 2])>> = vec![Vec::new(); patches.len()];
        for &Link { items: [a, b], sides: [of_a, of_b] } in links {
            forest.join(a, b);
            links_of[a as usize].push((b, [of_a, of_b]));
            links_of[b as usize].push((a, [of_b, of_a]));
        }
        let (groups, _) = grouped(forest, patches.len());
        let of_group = |group: &Vec<u32>| {
            let mut found: HashMap<u32, [i32; 2]> = HashMap::new();
            for &first in group {
                if stop.is_set() {
                    break;
                }
                if found.contains_key(&first) {
                    continue;
                }
                let Some(sides) = self.sides_by_line(&patches[first as usize]) else { continue };
                found.insert(first, sides);
                let mut open = vec![first];
                while let Some(patch) = open.pop() {
                    let known = found[&patch];
                    for &(other, [side, of_other]) in &links_of[patch as usize] {
                        // Passing into a face adds one to the winding number.
                        let front = known[side] - i32::from(of_other == 1);
                        if let Entry::Vacant(place) = found.entry(other) {
                            place.insert([front, front + 1]);
                            open.push(other);
                        }
                    }
                }
            }
            group.iter().map(|patch| (*patch, found.get(patch).copied())).collect::<Vec<_>>()
        };
        let mut out = vec![None; patches.len()];
        for (patch, sides) in groups.par_iter().map(of_group).collect::<Vec<_>>().into_iter().flatten() {
            out[patch as usize] = sides;
        }
        out
    }

    /// Returns the winding numbers on the front and the back of a patch, by a line through its widest item.
    fn sides_by_line(&self, items: &[u32]) -> Option<[i32; 2]> {
        let widest = |i: &&u32, j: &&u32| self.width(**i).total_cmp(&self.width(**j)).then(j.cmp(i));
        let item = items.iter().max_by(widest)?;
        let triangle = self.triangles.get(*item);
        self.sides(&triangle, centroid(&triangle))
    }

    /// Returns the winding numbers on the front and the back of a triangle at one of its points.
    pub(super) fn sides(&self, triangle: &Triangle, at: Vec3) -> Option<[i32; 2]> {
        // The axis closest to the normal.
        let normal = normal(triangle).abs();
        let axis = (0..3).fold(0, |best, i| if normal[i] > normal[best] { i } else { best });
        let mut hits = Vec::new();
        let before = self.bounds.size().max_element();
        let mut from = self.size.unscale(at);
        from[axis] = self.bounds.min[axis] - before;
        let line = Line::exact(from, Vec3::AXES[axis] * before);
        self.hits(&line, Span::FORWARD, &mut hits, &mut Scratch::default());
        sides_of(&hits, triangle.face)
    }

    /// The height of an item over its longest edge. The larger it is, the more reliable is a line through the item.
    fn width(&self, item: u32) -> f64 {
        let triangle = self.triangles.get(item);
        let [a, b, c] = triangle.corners;
        let longest = (b - a).length().max((c - b).length()).max((a - c).length());
        let width = normal(&triangle).length() / longest;
        if width.is_nan() { 0.0 } else { width }
    }
}

/// Returns the sets of a forest, ordered by their first members and each ascending, and for each member the index of
/// its set.
fn grouped(mut forest: Shells, members: usize) -> (Vec<Vec<u32>>, Vec<u32>) {
    let mut number_of_root = vec![u32::MAX; members];
    let mut groups: Vec<Vec<u32>> = Vec::new();
    let number_of = (0..members as u32).map(|member| {
        let number = &mut number_of_root[forest.root(member) as usize];
        if *number == u32::MAX {
            *number = groups.len() as u32;
            groups.push(Vec::new());
        }
        groups[*number as usize].push(member);
        *number
    });
    let number_of = number_of.collect();
    (groups, number_of)
}

pub(super) fn centroid(triangle: &Triangle) -> Vec3 {
    let [a, b, c] = triangle.corners;
    (a + b + c) / 3.0
}

fn normal(triangle: &Triangle) -> Vec3 {
    let [a, b, c] = triangle.corners;
    (b - a).cross(c - a)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::math::Affine;
    use crate::solid::mesh::TriangleMesh;
    use crate::solid::mesh::shapes::{ball, cubes, fan, needle, ring};

    fn solid(mesh: TriangleMesh) -> MeshSolid {
        MeshSolid::new(Arc::new(mesh), "bvh").unwrap()
    }

    #[test]
    fn a_shell_is_one_patch_whatever_its_faces() {
        for mesh in [ball(2), ring(9, 5).unwelded(), fan(200), needle(200)] {
            let solid = solid(mesh);
            let patches = solid.patches(Stop::NEVER).unwrap();
            assert_eq!(patches.iter().map(|patch| patch.sides).collect::<Vec<_>>(), [Some([0, 1])]);
            assert!(solid.winding().unwrap().once);
        }
    }

    #[test]
    fn faces_around_one_edge_are_joined_to_their_neighbours_elsewhere() {
        // Thin wedges around one edge with gaps between them: each is a patch.
        let book = |pages: u32| {
            let mut mesh = TriangleMesh::new(vec![Vec3::ZERO, Vec3::Z], Vec::new());
            for page in 0..pages {
                let angle = |i: u32| std::f64::consts::TAU * f64::from(i) / f64::from(2 * pages);
                let at = |i: u32| Vec3::new(angle(i).cos(), angle(i).sin(), 0.5);
                mesh.vertices.extend([at(2 * page), at(2 * page + 1)]);
                let (a, b) = (2 + 2 * page, 3 + 2 * page);
                mesh.faces.extend([[0, a, 1], [0, 1, b], [0, b, a], [1, a, b]]);
            }
            mesh
        };
        for pages in [2, 3, 50] {
            let solid = solid(book(pages));
            assert!(solid.folds().is_empty());
            let patches = solid.patches(Stop::NEVER).unwrap();
            assert_eq!(patches.len(), pages as usize);
            assert!(patches.iter().all(|patch| patch.items.len() == 4), "{patches:?}");
            assert!(solid.winding().unwrap().once);
        }
        // Each page twice: every face lies on another.
        let solid = solid(book(20).with(&book(20)));
        let folded: std::collections::HashSet<u32> = solid.folds().into_iter().flatten().collect();
        assert!(solid.triangles.len() == 160 && folded.len() == 160, "{}", folded.len());
        assert!(!solid.winding().unwrap().once);
    }

    #[test]
    fn patches_in_one_another_have_their_winding_numbers() {
        let half = ball(2).moved(&Affine::scaling(Vec3::splat(0.5)));
        let sides = |mesh: TriangleMesh| {
            solid(mesh).patches(Stop::NEVER).unwrap().iter().map(|p| p.sides).collect::<Vec<_>>()
        };
        assert_eq!(sides(ball(2).with(&half)), [Some([0, 1]), Some([1, 2])]);
        assert_eq!(sides(ball(2).with(&half.inside_out())), [Some([0, 1]), Some([0, 1])]);
    }

    #[test]
    fn faces_that_cancel_are_never_hit() {
        let winding = |mesh: TriangleMesh| solid(mesh).winding().unwrap();
        let sheet = || crate::solid::mesh::shapes::sheet(3);
        // The other side cut along the other diagonals.
        let turned = sheet().moved(&Affine::rotation_xyz(Vec3::new(0.0, 0.0, 90.0)));
        let back = turned.moved(&Affine::translation(Vec3::new(3.0, 0.0, 0.0))).inside_out();
        for mesh in [sheet().with(&sheet().inside_out()), ball(1).with(&ball(1).inside_out())] {
            let found = winding(mesh.clone());
            assert!(!found.can_be_hit && found.cancelling.count == mesh.faces.len(), "{found:?}");
            let beside = ball(1).moved(&Affine::translation(Vec3::splat(9.0)));
            let found = winding(mesh.clone().with(&beside));
            assert!(found.can_be_hit && found.cancelling.count == mesh.faces.len(), "{found:?}");
        }
        assert!(!solid(sheet().with(&back)).is_closed() || !winding(sheet().with(&back)).can_be_hit);
        let (cancelling, negative) = (Tally::default(), Tally::default());
        let plain = Winding { once: true, cancelling, can_be_hit: true, negative, consistent: true };
        assert_eq!(winding(ball(2)), plain);
        let inward = winding(ball(2).inside_out());
        assert!(inward.once && inward.consistent && inward.negative.count == ball(2).faces.len());
        let singletons = ball(1).moved(&Affine::translation(Vec3::splat(9.0)));
        let both = winding(ball(2).inside_out().with(&singletons));
        assert!(!both.consistent && both.negative == inward.negative, "{both:?}");
        assert!(!winding(ball(2).with(&ball(2))).once);
    }

    #[test]
    fn patches_around_edges_follow_from_their_neighbours() {
        // Random blocks of cubes, every second one inside out with a ball: edges of four and more faces.
        let mut random = crate::testkit::random::Random::new(7);
        let mut linked = 0;
        for round in 0..40 {
            let mut first_at = || -> Vec<[i32; 3]> {
                (0..27).filter(|_| random.below(3) == 0).map(|i| [i % 3, i / 3 % 3, i / 9]).collect()
            };
            let mut mesh = cubes(&first_at());
            if round % 2 == 1 {
                mesh = mesh
                    .inside_out()
                    .with(&ball(1).moved(&Affine::scaling(Vec3::splat(0.1 * f64::from(round)))));
            }
            let facing = Affine::rotation_xyz(Vec3::new(f64::from(round), 20.0, 5.0));
            let solid = solid(mesh.moved(&facing));
            let edges = solid.edges();
            linked += solid.links(&edges, &solid.meets_others(&edges)).len();
            for patch in solid.patches(Stop::NEVER).unwrap() {
                assert_eq!(patch.sides, solid.sides_by_line(&patch.items), "{round}");
            }
        }
        assert!(linked > 400, "{linked}");
    }

    #[test]
    fn each_face_tells_what_a_line_through_it_tells() {
        // Shells that touch, overlap, coincide and share edges of four faces.
        let at = |x: f64, y: f64| cubes(&[[0, 0, 0]]).moved(&Affine::translation(Vec3::new(x, y, 0.25)));
        let other = ball(2).moved(&Affine::translation(Vec3::new(0.6, 0.1, 0.2)));
        for mesh in [
            cubes(&[[0, 0, 0]]).with(&at(1.0, 0.5)),
            cubes(&[[0, 0, 0]]).with(&at(0.5, 0.5)),
            cubes(&[[0, 0, 0], [1, 1, 0]]).with(&cubes(&[[0, 0, 0]])),
            ball(2).with(&other).with(&other.clone().inside_out()),
        ] {
            let solid = solid(mesh);
            for patch in solid.patches(Stop::NEVER).unwrap() {
                for &item in &patch.items {
                    let triangle = solid.triangles.get(item);
                    let own = solid.sides(&triangle, centroid(&triangle));
                    assert_eq!(own, patch.sides);
                }
            }
        }
    }
}
