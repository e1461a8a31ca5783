//! The shells of a mesh: components that have no vertex in common.

use std::sync::atomic::{AtomicU32, Ordering};

use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};

use super::Tally;
use super::distribute::CHUNK;
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

    /// Returns the shells of faces; `vertices` is the number of vertices. Each vertex is in the set of the lowest vertex
    /// of its shell, and that is its parent.
    pub(super) fn of(vertices: usize, faces: &[Face]) -> Shells {
        let parents: Vec<AtomicU32> = (0..).take(vertices).map(AtomicU32::new).collect();
        faces.par_iter().with_min_len(CHUNK).for_each(|Face { corners: [a, b, c], .. }| {
            join(&parents, *a, *b);
            join(&parents, *b, *c);
        });
        let mut parents: Vec<u32> = parents.into_iter().map(AtomicU32::into_inner).collect();
        // Parents are lower than their children.
        (0..vertices).for_each(|v| parents[v] = parents[parents[v] as usize]);
        Shells { parents }
    }

    /// Returns for each vertex the lowest vertex of its shell, as [`Shells::of`] leaves it.
    pub(super) fn into_roots(self) -> Vec<u32> {
        self.parents
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
}

/// Counts the shells that faces make, given the root of each vertex and the corners of the faces, each once. The first
/// item is the first face of the second shell.
pub(super) fn count(roots: &[u32], faces: &[Face], corners: impl ParallelIterator<Item = u32>) -> Tally<u32> {
    let root = |face: &Face| roots[face.corners[0] as usize];
    let count = corners.filter(|v| roots[*v as usize] == *v).count();
    let second = || faces.par_iter().with_min_len(CHUNK).find_first(|face| root(face) != root(&faces[0]));
    Tally { count, first: if count > 1 { second().map(|face| face.number) } else { None } }
}

/// Joins the sets of two vertices. Other threads may do so at the same time: a vertex never becomes a root again, and
/// its parent is always in its set, so what another thread has just changed is at worst a longer way to the root.
fn join(parents: &[AtomicU32], a: u32, b: u32) {
    let (mut a, mut b) = (a, b);
    loop {
        (a, b) = (root(parents, a), root(parents, b));
        if a == b {
            return;
        }
        let (low, high) = (a.min(b), a.max(b));
        let is_root =
            parents[high as usize].compare_exchange(high, low, Ordering::Relaxed, Ordering::Relaxed);
        if is_root.is_ok() {
            return;
        }
    }
}

fn root(parents: &[AtomicU32], mut v: u32) -> u32 {
    loop {
        let parent = parents[v as usize].load(Ordering::Relaxed);
        let grandparent = parents[parent as usize].load(Ordering::Relaxed);
        if parent == grandparent {
            return parent;
        }
        parents[v as usize].store(grandparent, Ordering::Relaxed);
        v = grandparent;
    }
}
