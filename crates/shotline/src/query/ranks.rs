//! The order in which intervals own a ray: by priority, then the later instance, which comes after those that it is in, then the
//! lower path. Intervals of one path follow each other along the ray.

use super::instances::{Instances, is_in};
use super::interval_ends::Interval;
use crate::compile::World;

/// The ranks of the intervals of a ray, and their places: a place is a rank for equal priorities, so the intervals of an instance
/// and of what it contains have adjacent places.
#[derive(Debug, Default)]
pub(super) struct Ranks<'w> {
    pub instances: Instances<'w>,
    /// The intervals by path.
    pub by_path: Vec<(u64, u32)>,
    /// The place of each interval, and at each place the interval and its instance.
    places: Vec<u32>,
    interval_at: Vec<u32>,
    instance_at: Vec<u32>,
    /// The first place of each instance, and the number of all places.
    first_place: Vec<u32>,
    /// The rank of each place, and the place of each rank; empty where they are the same.
    ranks: Vec<u32>,
    ranked: Vec<u32>,
}

impl<'w> Ranks<'w> {
    /// Determines the ranks of some intervals.
    pub fn begin(&mut self, world: &'w World, intervals: &[Interval]) {
        self.by_path.clear();
        self.by_path.extend((0..).zip(intervals).map(|(number, interval)| (interval.path, number)));
        self.by_path.sort_unstable();
        self.instances.begin(world);
        // For now the instance of each interval.
        self.places.clear();
        self.places.resize(intervals.len(), 0);
        for &(path, interval) in &self.by_path {
            self.places[interval as usize] = self.instances.of_path(world, path);
        }
        self.place();
        self.rank(world, intervals);
    }

    /// Sorts the intervals by instance: counts those of each, and then goes through them by descending path.
    fn place(&mut self) {
        let count = self.instances.finish().len();
        self.first_place.clear();
        self.first_place.resize(count + 1, 0);
        for &instance in &self.places {
            self.first_place[instance as usize + 1] += 1;
        }
        for instance in 0..count {
            self.first_place[instance + 1] += self.first_place[instance];
        }
        self.interval_at.clear();
        self.interval_at.resize(self.places.len(), 0);
        self.instance_at.clear();
        self.instance_at.resize(self.places.len(), 0);
        for &(_, interval) in self.by_path.iter().rev() {
            let instance = self.places[interval as usize];
            let next = &mut self.first_place[instance as usize];
            self.places[interval as usize] = *next;
            self.interval_at[*next as usize] = interval;
            self.instance_at[*next as usize] = instance;
            *next += 1;
        }
        // Each first place has become that of the next instance.
        self.first_place.rotate_right(1);
        self.first_place[0] = 0;
    }

    fn rank(&mut self, world: &World, intervals: &[Interval]) {
        self.ranks.clear();
        self.ranked.clear();
        let priority = |interval: &Interval| world.object_priority(interval.object);
        if intervals.windows(2).all(|pair| priority(&pair[0]) == priority(&pair[1])) {
            return;
        }
        self.ranked.extend(0..intervals.len() as u32);
        let at = &self.interval_at;
        self.ranked.sort_by_key(|&place| priority(&intervals[at[place as usize] as usize]));
        self.ranks.resize(intervals.len(), 0);
        for (rank, &place) in (0..).zip(&self.ranked) {
            self.ranks[place as usize] = rank;
        }
    }

    pub fn place_of(&self, interval: usize) -> u32 {
        self.places[interval]
    }

    pub fn interval_at(&self, place: u32) -> usize {
        self.interval_at[place as usize] as usize
    }

    pub fn instance_at(&self, place: u32) -> u32 {
        self.instance_at[place as usize]
    }

    /// The places of the intervals of the instances from one to another.
    pub fn places_of(&self, first: u32, last: u32) -> std::ops::Range<u32> {
        self.first_place[first as usize]..self.first_place[last as usize + 1]
    }

    pub fn rank_of(&self, place: u32) -> u32 {
        self.ranks.get(place as usize).copied().unwrap_or(place)
    }

    pub fn place_ranked(&self, rank: u32) -> u32 {
        self.ranked.get(rank as usize).copied().unwrap_or(rank)
    }

    /// Whether the interval at a place is neither of the instance of another nor in it.
    pub fn is_apart(&self, place: u32, around: u32) -> bool {
        let [inner, outer] = [place, around].map(|place| self.instance_at(place));
        inner != outer && !is_in(self.instances.all(), inner, outer)
    }
}
