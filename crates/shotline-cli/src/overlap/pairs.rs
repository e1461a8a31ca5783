//! Pairs of objects, by name.

use std::collections::BTreeMap;

use shotline::math::Vec3;
use shotline::query::ConflictKind;

use super::extent::Extent;

/// Two objects that have points in common, or of which one sticks out of the other. Both may be the same, placed twice.
#[derive(Debug)]
pub struct ObjectPair {
    pub kind: ConflictKind,
    pub first: String,
    pub second: String,
    /// The first such point that was found.
    pub point: Vec3,
    /// On how many rays such points were found.
    pub rays: usize,
    /// How large the part around the point is, if it was estimated.
    pub extent: Option<Extent>,
}

/// Each pair of objects once for each kind.
#[derive(Default)]
pub struct PairSet(BTreeMap<Key, ObjectPair>);

type Key = (ConflictKind, String, String);

/// The order in which rays meet two objects that overlap varies, so their names are sorted.
fn key(kind: ConflictKind, a: &str, b: &str) -> Key {
    let is_in_order = kind == ConflictKind::Protrusion || a <= b;
    let (first, second) = if is_in_order { (a, b) } else { (b, a) };
    (kind, first.to_owned(), second.to_owned())
}

impl PairSet {
    pub fn add(&mut self, kind: ConflictKind, [a, b]: [&str; 2], point: Vec3) {
        let key = key(kind, a, b);
        let (_, first, second) = key.clone();
        let new = ObjectPair { kind, first, second, point, rays: 0, extent: None };
        self.0.entry(key).or_insert(new).rays += 1;
    }

    pub fn contains(&self, kind: ConflictKind, [a, b]: [&str; 2]) -> bool {
        self.0.contains_key(&key(kind, a, b))
    }

    /// The pairs, for estimates of their extent.
    pub fn pairs_mut(&mut self) -> impl Iterator<Item = &mut ObjectPair> {
        self.0.values_mut()
    }

    /// The pairs in the order of their kinds and names.
    pub fn into_list(self) -> Vec<ObjectPair> {
        self.0.into_values().collect()
    }
}
