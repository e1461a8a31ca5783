//! A wave: rays that run anywhere, each of which walks through levels alone. Rays that have met bodies wait for each other.

use arrayvec::ArrayVec;

use super::block_visitor::Slot;
use super::level_boxes::box_ray;
use super::level_paths::{self, LevelPaths};
use super::traversal::{BodyEntry, PlacedBody};
use crate::aabb::BoxRay;
use crate::accel::{Walk, WalkKind};
use crate::compile::{Level, Placement, Target, World};
use crate::math::Affine;
use crate::ray::{Line, Span};

/// The most rays of a wave. More of them fill more lanes, and need more memory near the CPU.
pub(super) const WAVE: usize = 64;

/// With more paths to levels than this a ray takes the plain path, which forgets paths that it has left.
const MAX_PATHS: usize = if cfg!(test) { 50 } else { 1 << 14 };

/// A level that a ray is in.
#[derive(Clone, Copy, Debug)]
struct LevelVisit<'w> {
    level: &'w Level,
    /// The placement of the level in the one above; `None` for the root.
    placement: Option<&'w Placement>,
    line: Line,
    boxes: BoxRay,
    path: u32,
    object: u32,
    first_path: u64,
    /// Where its pending entries begin.
    base: usize,
}

/// A body that a ray has met.
#[derive(Clone, Copy, Debug)]
pub(super) struct MetBody<'w> {
    pub placed: PlacedBody,
    pub placement: &'w Placement,
    /// Where the ray enters its box.
    pub enter: f64,
}

/// How a walk goes on.
pub(super) enum Advance<'w> {
    Met(MetBody<'w>),
    /// There is nothing else.
    Done,
    /// It takes too many steps or too much memory.
    Refused,
}

/// A ray of a wave.
#[derive(Debug, Default)]
pub(super) struct WaveRay<'w> {
    pub slot: Slot,
    pub paths: LevelPaths<'w>,
    visits: Vec<LevelVisit<'w>>,
    pub walk: Walk,
}

impl<'w> WaveRay<'w> {
    /// Begins at the root of a world.
    pub fn begin(&mut self, slot: Slot, world: &'w World, line: Line, span: Span) {
        self.slot = slot;
        self.visits.clear();
        self.walk.pending.clear();
        self.walk.steps = 0;
        let level = world.root();
        self.paths.begin(level);
        self.enter(LevelVisit {
            level,
            placement: None,
            line,
            boxes: BoxRay::new(&line, span),
            path: level_paths::ROOT,
            object: 0,
            first_path: 0,
            base: 0,
        });
    }

    /// Walks on to the next body whose box the ray enters up to its limit.
    pub fn advance(&mut self, world: &'w World, most_steps: u64) -> Advance<'w> {
        while let Some(visit) = self.visits.last() {
            let Some(accel) = &visit.level.accel else {
                self.visits.pop();
                continue;
            };
            let Some(entry) = accel.walk(&visit.boxes, self.slot.limit, visit.base, &mut self.walk) else {
                self.visits.pop();
                continue;
            };
            if self.walk.steps > most_steps || self.paths.len() > MAX_PATHS {
                return Advance::Refused;
            }
            let placement = &visit.level.placements[entry.number as usize];
            let enter = match entry.kind {
                WalkKind::Item => visit.boxes.enter_exit(&placement.bounds).map(|(enter, _)| enter),
                _ => Some(entry.t),
            };
            let Some(enter) = enter.filter(|enter| *enter <= self.slot.limit) else { continue };
            match placement.target {
                Target::Body(body) => {
                    let placed = PlacedBody {
                        body,
                        object: placement.object.unwrap_or(visit.object),
                        path: visit.first_path + placement.first_path,
                        visit: visit.path,
                        placement: entry.number,
                    };
                    return Advance::Met(MetBody { placed, placement, enter });
                }
                Target::Level(level) => self.descend(world.level(level), placement, entry.number),
            }
        }
        Advance::Done
    }

    /// Enters a level that is placed in the one that the ray is in.
    fn descend(&mut self, level: &'w Level, placement: &'w Placement, number: u32) {
        let Some(&above) = self.visits.last() else { return };
        let line = above.line.in_frame(&placement.local_from_parent);
        let path = self.paths.add(level, above.path, number);
        self.enter(LevelVisit {
            level,
            placement: Some(placement),
            line,
            boxes: box_ray(level, &line, above.boxes.span()),
            path,
            object: placement.object.unwrap_or(above.object),
            first_path: above.first_path + placement.first_path,
            base: self.walk.pending.len(),
        });
    }

    fn enter(&mut self, visit: LevelVisit<'w>) {
        if let Some(accel) = &visit.level.accel {
            accel.begin_walk(&visit.boxes, &mut self.walk);
        }
        self.visits.push(visit);
    }

    /// The line of the ray in the level that it is in: that of the body that it met last.
    pub fn line(&self) -> &Line {
        &self.visits.last().expect("a ray that has met a body is in a level").line
    }

    /// As [`WaveRay::line`], for box tests; `None` where those of the level are in another frame.
    pub fn boxes(&self) -> Option<&BoxRay> {
        let visit = self.visits.last().expect("a ray that has met a body is in a level");
        visit.level.box_frame.is_none().then_some(&visit.boxes)
    }

    /// How many levels below the root it is in.
    pub fn depth(&self) -> usize {
        self.visits.len() - 1
    }

    /// The transform into the level that lies as many levels above the one that the ray is in; `None` for the root.
    pub fn frame_above(&self, levels: usize) -> Option<&'w Affine> {
        let visit = self.visits.iter().rev().nth(levels)?;
        visit.placement.map(|placement| &placement.local_from_parent)
    }

    /// The ray in a body that it has met.
    pub fn body_entry(&self, met: &MetBody<'w>) -> BodyEntry {
        let line = self.line().in_frame(&met.placement.local_from_parent);
        BodyEntry { placed: met.placed, line, enter: met.enter }
    }
}

/// A ray that waits at a body.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair<'w> {
    /// Its number in the wave.
    pub ray: usize,
    /// Pairs with the same number can be cast together.
    pub group: u32,
    pub met: MetBody<'w>,
}

/// Below more levels than this normals are computed one by one.
pub(super) const MOST_DEEP: usize = 7;

/// Level by level, innermost first: the transform of each lane, and the lanes that have one.
pub(super) type LevelFrames<'w> = ArrayVec<([&'w Affine; 8], u8), { MOST_DEEP + 1 }>;

/// The transforms from the world to the bodies of pairs, one in each lane.
pub(super) fn level_frames<'w>(rays: &[WaveRay<'w>], pairs: &[&Pair<'w>]) -> LevelFrames<'w> {
    let (mut all, mut levels) = (LevelFrames::new_const(), 0);
    let mut of_level = ([&pairs[0].met.placement.local_from_parent; 8], 0);
    for (lane, pair) in pairs.iter().enumerate() {
        of_level.0[lane] = &pair.met.placement.local_from_parent;
        of_level.1 |= 1 << lane;
    }
    while of_level.1 != 0 && !all.is_full() {
        all.push(of_level);
        of_level.1 = 0;
        for (lane, pair) in pairs.iter().enumerate() {
            if let Some(frame) = rays[pair.ray].frame_above(levels) {
                of_level.0[lane] = frame;
                of_level.1 |= 1 << lane;
            }
        }
        levels += 1;
    }
    all
}
