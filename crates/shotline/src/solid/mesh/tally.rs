//! Counts of findings, with the first of each.

use rayon::iter::{IndexedParallelIterator, ParallelIterator};

use crate::math::Vec3;

/// A count and the first item counted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tally<P> {
    /// The number of items.
    pub count: usize,
    /// The first item; `None` if there are none.
    pub first: Option<P>,
}

impl<P> Default for Tally<P> {
    fn default() -> Tally<P> {
        Tally { count: 0, first: None }
    }
}

impl<P> Tally<P> {
    /// Counts an item; the first call sets the first item.
    pub(super) fn add(&mut self, place: P) {
        self.count += 1;
        self.first.get_or_insert(place);
    }

    /// Adds the items of a later tally.
    pub(super) fn merged(self, later: Tally<P>) -> Tally<P> {
        Tally { count: self.count + later.count, first: self.first.or(later.first) }
    }
}

impl<P: Send> Tally<P> {
    /// Counts the items that are present, by several threads.
    pub(super) fn of(items: impl IndexedParallelIterator<Item = Option<P>>) -> Tally<P> {
        let add = |mut tally: Tally<P>, item: Option<P>| {
            item.into_iter().for_each(|item| tally.add(item));
            tally
        };
        items.fold(Tally::default, add).reduce(Tally::default, Tally::merged)
    }
}

impl<P> FromIterator<P> for Tally<P> {
    fn from_iter<I: IntoIterator<Item = P>>(places: I) -> Tally<P> {
        let mut found = Tally::default();
        places.into_iter().for_each(|place| found.add(place));
        found
    }
}

/// An edge, with faces that use it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// Its vertices; of coincident vertices, the first.
    pub vertices: [u32; 2],
    /// Its start.
    pub from: Vec3,
    /// Its end.
    pub to: Vec3,
    /// The first and the last face that use it; the same if there is only one.
    pub faces: [u32; 2],
}

/// Two faces that pass through each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Intersection {
    /// The two faces, the lower index first.
    pub faces: [u32; 2],
    /// A point of their intersection, up to rounding.
    pub point: Vec3,
}

/// A face passes through another.
pub(super) const CROSSES: u8 = 1;
/// A face touches another, or is within rounding of it.
pub(super) const TOUCHES: u8 = 2;

/// How faces meet. Items are triangles of the solid, those without area only where they meet items with an area.
#[derive(Debug, Default)]
pub(super) struct FaceContacts {
    /// Pairs of faces that pass through each other; `None` if it would take too long to find them. Then any two may.
    pub(super) crossings: Option<Tally<Intersection>>,
    /// Pairs of items that meet, in ascending order; `None` if there are too many to list.
    pub(super) pairs: Option<Vec<[u32; 2]>>,
    /// For each item, the flags [`CROSSES`] and [`TOUCHES`].
    pub(super) marks: Vec<u8>,
}

impl FaceContacts {
    /// Bytes used.
    pub(super) fn memory(&self) -> usize {
        self.pairs.as_deref().map_or(0, size_of_val) + size_of_val(self.marks.as_slice())
    }

    /// Whether faces pass through each other, or may.
    pub(super) fn may_cross(&self) -> bool {
        self.crossings.is_none_or(|crossings| crossings.count > 0)
    }
}
