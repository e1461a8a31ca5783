//! The shells of a mesh: components that have no vertex in common.

use super::Tally;
use super::welded::Face;

/// A disjoint-set forest of connected vertices or faces, with path halving.
pub(super) struct Shells {
    parents: Vec<u32>,
}

impl Shells {
    /// Creates sets of one member each.
    pub(super) fn singletons(members: usize) -> Shells {
        Shells { parents: (0..).take(members).collect() }
    }

    /// Returns the shells of faces; `vertices` is the number of vertices.
    pub(super) fn of(vertices: usize, faces: &[Face]) -> Shells {
        let mut shells = Shells::singletons(vertices);
        for Face { corners: [a, b, c], .. } in faces {
            shells.join(*a, *b);
            shells.join(*b, *c);
        }
        shells
    }

    /// Returns the representative vertex of a vertex's shell.
    pub(super) fn root(&mut self, mut v: u32) -> u32 {
        while self.parents[v as usize] != v {
            let grandparent = self.parents[self.parents[v as usize] as usize];
            self.parents[v as usize] = grandparent;
            v = grandparent;
        }
        v
    }

    pub(super) fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.parents[a.max(b) as usize] = a.min(b);
    }

    /// Counts the shells that faces make. The first item is the first face of the second shell.
    pub(super) fn count(&mut self, faces: &[Face]) -> Tally<u32> {
        let (mut seen, mut found) = (vec![false; self.parents.len()], Tally::default());
        for face in faces {
            if !std::mem::replace(&mut seen[self.root(face.corners[0]) as usize], true) {
                found.count += 1;
                found.first = found.first.or((found.count == 2).then_some(face.number));
            }
        }
        found
    }
}
