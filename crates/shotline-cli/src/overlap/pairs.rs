//! Pairs of objects, by name.

use std::collections::BTreeMap;

use shotline::math::Vec3;

/// Two objects that have points in common.
#[derive(Debug)]
pub struct ObjectPair {
    pub first: String,
    pub second: String,
    /// The first common point that was found.
    pub point: Vec3,
    /// On how many rays common points were found.
    pub rays: usize,
}

/// Each pair of objects once. The order in which rays meet the two objects varies, so the names of a key are sorted.
#[derive(Default)]
pub struct PairSet(BTreeMap<(String, String), ObjectPair>);

impl PairSet {
    pub fn add(&mut self, a: &str, b: &str, point: Vec3) {
        let (first, second) = (a.min(b).to_string(), a.max(b).to_string());
        let key = (first.clone(), second.clone());
        self.0.entry(key).or_insert(ObjectPair { first, second, point, rays: 0 }).rays += 1;
    }

    pub fn contains(&self, a: &str, b: &str) -> bool {
        self.0.contains_key(&(a.min(b).to_string(), a.max(b).to_string()))
    }

    /// The pairs in the order of their names.
    pub fn into_list(self) -> Vec<ObjectPair> {
        self.0.into_values().collect()
    }
}
