//! Counters of the work that rays cause.

/// Counts of the work done by traversals.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Boxes tested against a ray.
    pub boxes: u64,
    /// Cells visited by a grid or an octree.
    pub cells: u64,
    /// Splitting planes tested against a ray.
    pub planes: u64,
    /// Solids and triangles intersected.
    pub primitive_tests: u64,
    /// Intersections that tags saved.
    pub tags_saved: u64,
    /// Entries pushed on a heap.
    pub heap_pushes: u64,
    /// Lists that rounding had made invalid and that were repaired by membership tests. Should always be 0.
    pub repaired: u64,
    /// Rays cast with a [`CoherenceHint`](crate::query::CoherenceHint) that met a body.
    pub hinted: u64,
    /// Those of them that met the body of their hint.
    pub hint_hits: u64,
}

/// One of the counts of [`Counters`].
#[derive(Clone, Copy, Debug)]
pub struct Counter {
    /// Its name on the command line.
    pub name: &'static str,
    /// What it counts, in a few words.
    pub summary: &'static str,
    /// Reads the count.
    pub of: fn(&Counters) -> u64,
}

/// All counts.
pub static COUNTERS: &[Counter] = &[
    Counter { name: "boxes", summary: "boxes tested", of: |w| w.boxes },
    Counter { name: "cells", summary: "cells visited", of: |w| w.cells },
    Counter { name: "planes", summary: "splitting planes met", of: |w| w.planes },
    Counter { name: "solids", summary: "solids and triangles intersected", of: |w| w.primitive_tests },
    Counter { name: "tags", summary: "intersections saved by tags", of: |w| w.tags_saved },
    Counter { name: "heap", summary: "entries pushed on heaps", of: |w| w.heap_pushes },
    Counter {
        name: "all",
        summary: "boxes, cells, planes and solids",
        of: |w| w.boxes + w.cells + w.planes + w.primitive_tests,
    },
];

impl std::ops::AddAssign for Counters {
    fn add_assign(&mut self, other: Counters) {
        self.boxes += other.boxes;
        self.cells += other.cells;
        self.planes += other.planes;
        self.primitive_tests += other.primitive_tests;
        self.tags_saved += other.tags_saved;
        self.heap_pushes += other.heap_pushes;
        self.repaired += other.repaired;
        self.hinted += other.hinted;
        self.hint_hits += other.hint_hits;
    }
}
