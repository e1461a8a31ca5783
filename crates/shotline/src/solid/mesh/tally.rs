//! How often something is found, and where first.

use crate::math::Vec3;

/// A count with the first place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tally<P> {
    /// How many there are.
    pub count: usize,
    /// Where the first is; `None` if there is none.
    pub first: Option<P>,
}

impl<P> Default for Tally<P> {
    fn default() -> Tally<P> {
        Tally { count: 0, first: None }
    }
}

impl<P> Tally<P> {
    /// Counts one more; the first to come is the first.
    pub(super) fn add(&mut self, place: P) {
        self.count += 1;
        self.first.get_or_insert(place);
    }
}

impl<P> FromIterator<P> for Tally<P> {
    fn from_iter<I: IntoIterator<Item = P>>(places: I) -> Tally<P> {
        let mut found = Tally::default();
        places.into_iter().for_each(|place| found.add(place));
        found
    }
}

/// An edge, with faces that have it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// Its vertices; of vertices in one place, the first.
    pub vertices: [u32; 2],
    /// Where it begins.
    pub from: Vec3,
    /// Where it ends.
    pub to: Vec3,
    /// The first and the last face that have it; the same if there is only one.
    pub faces: [u32; 2],
}

/// Two faces that pass through each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Intersection {
    /// The two, the lower number first.
    pub faces: [u32; 2],
    /// A point where they do, as near as rounding allows.
    pub point: Vec3,
}

/// A face passes through another.
pub(super) const CROSSES: u8 = 1;
/// A face touches another, or is as near to it as rounding.
pub(super) const TOUCHES: u8 = 2;

/// How faces meet. Items are triangles of the solid.
#[derive(Debug, Default)]
pub(super) struct FaceContacts {
    /// Pairs of faces that pass through each other.
    pub(super) crossings: Tally<Intersection>,
    /// Pairs of items that meet, in ascending order; `None` if there are too many to list.
    pub(super) pairs: Option<Vec<[u32; 2]>>,
    /// For each item [`CROSSES`] and [`TOUCHES`].
    pub(super) marks: Vec<u8>,
}
