//! The edges of the triangles of a mesh, and the order of faces around non-manifold edges.

use rayon::prelude::*;

use super::MeshSolid;
use super::separation::wings_are_apart;
use super::shells::Shells;
use super::welded::first_at;

/// The use of an edge by an item: the ends, the lower first; the item; and the index of its corner opposite the edge.
pub(super) type EdgeUse = ([u32; 2], u32, u32);

/// Two sides of items with no other face between them: they have the same winding number.
#[derive(Clone, Copy, Debug)]
pub(super) struct Link {
    pub(super) items: [u32; 2],
    /// For each item, 0 for the front and 1 for the back.
    pub(super) sides: [usize; 2],
}

impl MeshSolid {
    /// Returns the edges of all items, sorted.
    pub(super) fn edges(&self) -> Vec<EdgeUse> {
        let first_at = first_at(&self.mesh.vertices);
        let mut edges: Vec<EdgeUse> = Vec::with_capacity(3 * self.triangles.len());
        for (item, triangle) in (0..).zip(self.triangles.iter()) {
            let corners = self.mesh.faces[triangle.face as usize].map(|v| first_at[v as usize]);
            for k in 0..3 {
                let (u, v) = (corners[(k + 1) % 3], corners[(k + 2) % 3]);
                edges.push(([u.min(v), u.max(v)], item, k as u32));
            }
        }
        edges.par_sort_unstable();
        edges
    }

    /// Returns pairs of items with a common edge that may be folded onto each other. If several items lie on each
    /// other, each is paired with the next.
    pub(super) fn folds(&self) -> Vec<[u32; 2]> {
        self.folds_at(&self.edges())
    }

    fn folds_at(&self, edges: &[EdgeUse]) -> Vec<[u32; 2]> {
        let mut folds = Vec::new();
        for uses in edges.chunk_by(|a, b| a.0 == b.0) {
            if let [one, other] = uses {
                folds.extend((!self.lies_open(one, other)).then_some([one.1, other.1]));
            } else if uses.len() > 2 {
                let around = self.around(uses);
                // Items that lie on each other are next to each other; so are the last and the first.
                let pairs = around.iter().zip(around.iter().cycle().skip(1));
                let closed = pairs.filter(|(one, other)| !self.lies_open(one, other));
                folds.extend(closed.map(|(one, other)| [one.1, other.1]));
            }
        }
        folds
    }

    /// Sorts the faces at an edge by their angle around it.
    ///
    /// Rounding may put a face in the wrong position, but by no more than the error of its own angle. So the face is
    /// still found to lie on one of its neighbours.
    fn around(&self, uses: &[EdgeUse]) -> Vec<EdgeUse> {
        let Some(&(_, item, k)) = uses.first() else { return Vec::new() };
        let corners = self.triangles.get(item).corners;
        let (u, v) = (corners[(k as usize + 1) % 3], corners[(k as usize + 2) % 3]);
        let (ahead, across) = (v - u).normalize().any_orthonormal_pair();
        let angle = |(_, item, k): &EdgeUse| {
            let out = self.triangles.get(*item).corners[*k as usize] - u;
            across.dot(out).atan2(ahead.dot(out))
        };
        let mut around: Vec<(f64, EdgeUse)> = uses.iter().map(|face| (angle(face), *face)).collect();
        around.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        around.into_iter().map(|(_, face)| face).collect()
    }

    /// Returns for each item whether it meets other faces elsewhere than at shared edges and corners, or is folded onto
    /// one.
    pub(super) fn meets_others(&self, edges: &[EdgeUse]) -> Vec<bool> {
        let mut meets_others: Vec<bool> =
            self.face_contacts().marks.iter().map(|marks| *marks != 0).collect();
        for item in self.folds_at(edges).into_iter().flatten() {
            meets_others[item as usize] = true;
        }
        meets_others
    }

    /// Joins items across edges of two faces, where neither meets other faces.
    pub(super) fn joined_by_edges(&self, edges: &[EdgeUse], meets_others: &[bool]) -> Shells {
        let mut forest = Shells::singletons(self.triangles.len());
        for uses in edges.chunk_by(|a, b| a.0 == b.0) {
            if let [(_, i, _), (_, j, _)] = *uses
                && !meets_others[i as usize]
                && !meets_others[j as usize]
            {
                forest.join(i, j);
            }
        }
        forest
    }

    /// Returns the sides that face each other around edges of more than two faces, where neither item meets other
    /// faces.
    pub(super) fn links(&self, edges: &[EdgeUse], meets_others: &[bool]) -> Vec<Link> {
        let mut links = Vec::new();
        for uses in edges.chunk_by(|a, b| a.0 == b.0).filter(|uses| uses.len() > 2) {
            let corner = |(_, item, k): &EdgeUse| self.triangles.get(*item).corners[(*k as usize + 1) % 3];
            let (around, begin) = (self.around(uses), corner(&uses[0]));
            // Angles are about the edge as the first face runs along it. A face that runs the same way has its front on
            // its counter-clockwise side.
            let ahead = |face: &EdgeUse| usize::from(corner(face) != begin);
            for (one, next) in around.iter().zip(around.iter().cycle().skip(1)) {
                let items = [one.1, next.1];
                if items.iter().all(|item| !meets_others[*item as usize]) && self.lies_open(one, next) {
                    links.push(Link { items, sides: [ahead(one), 1 - ahead(next)] });
                }
            }
        }
        links
    }

    /// Whether neither of two faces at an edge is folded onto the other.
    fn lies_open(&self, &(_, i, k): &EdgeUse, &(_, j, l): &EdgeUse) -> bool {
        let (of_i, k) = (self.triangles.get(i).corners, k as usize);
        let opposite = self.triangles.get(j).corners[l as usize];
        wings_are_apart(of_i[(k + 1) % 3], of_i[(k + 2) % 3], [of_i[k], opposite])
    }
}
