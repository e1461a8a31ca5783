//! The shells of a mesh: parts that have no vertex in common.

use std::collections::HashSet;

use super::Tally;
use super::welded::Face;

/// A disjoint-set forest: which vertices, or faces, hang together. Paths are halved on the way.
pub(super) struct Shells {
    parents: Vec<u32>,
}

impl Shells {
    /// So many sets of one member each.
    pub(super) fn apart(members: usize) -> Shells {
        Shells { parents: (0..).take(members).collect() }
    }

    /// The shells of faces among so many vertices.
    pub(super) fn of(vertices: usize, faces: &[Face]) -> Shells {
        let mut shells = Shells::apart(vertices);
        for Face { corners: [a, b, c], .. } in faces {
            shells.join(*a, *b);
            shells.join(*b, *c);
        }
        shells
    }

    /// The vertex that stands for the shell of a vertex.
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

    /// The parts that faces make.
    pub(super) fn count(&mut self, faces: &[Face]) -> Tally<u32> {
        let (mut seen, mut found) = (HashSet::new(), Tally::default());
        for face in faces {
            if seen.insert(self.root(face.corners[0])) {
                found.count += 1;
                found.first = found.first.or((found.count == 2).then_some(face.number));
            }
        }
        found
    }
}
