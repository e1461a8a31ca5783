//! Casts the rays of waves at the bodies that they have met: rays that have met the same body, or bodies of one kind, in
//! lanes together.

use arrayvec::ArrayVec;

use super::block_fold::BlockFold;
use super::block_visitor::{BlockVisitor, Found, InFlight, Normal, Slot, State};
use super::fold_query::FoldQuery;
use super::lane_bodies::Bodies;
use super::lane_cast::{Cast, LaneFind, LaneQuery};
use super::lane_normals::Frames;
use super::level_visit::ones;
use super::wave::{Advance, LevelFrames, MOST_DEEP, Pair, WAVE, WaveRay, level_frames};
use super::wave_bodies::BodyRequest;
use super::wave_memory::WaveMemory;
use crate::compile::{Body, SolidBody, World};
use crate::lanes::LineLanes;
use crate::lanes::vector::gather;
use crate::math::Vec3;
use crate::ray::{Line, Ray};
use crate::simd::{Doubles, Simd, Task, dispatch};

/// The most pairs that are cast together.
const MOST_TOGETHER: usize = 32;

/// Fewer rays than this are cast at a body of many leaves one by one.
const FEWEST_AT_MANY_LEAVES: usize = 2;

impl<'w> BlockFold<'_, 'w> {
    /// Casts the rows of a wave.
    pub(super) fn cast_waves<V: BlockVisitor<'w>>(&mut self, memory: &mut WaveMemory<'w>, visitor: &mut V) {
        let WaveMemory { rows, rays, .. } = memory;
        if rays.len() < rows.len().min(WAVE) {
            rays.resize_with(rows.len().min(WAVE), WaveRay::default);
        }
        rays.iter_mut().for_each(|ray| ray.slot.state = State::Ended);
        visitor.make_room(rays.len());
        let mut rows = std::mem::take(rows);
        let mut next = rows.iter();
        while !self.block.is_cancelled() {
            memory.pairs.clear();
            for number in 0..memory.rays.len() {
                self.meet(number, &mut next, memory, visitor);
            }
            if memory.pairs.is_empty() {
                break;
            }
            memory.pairs.sort_unstable_by_key(|pair| pair.group);
            let pairs = std::mem::take(&mut memory.pairs);
            for group in pairs.chunk_by(|a, b| a.group == b.group) {
                for some in group.chunks(MOST_TOGETHER) {
                    self.cast_pairs(some, memory, visitor);
                }
            }
            memory.pairs = pairs;
        }
        rows.clear();
        memory.rows = rows;
    }

    /// Lets a ray walk on to its next body, or the next one begin if it has ended.
    fn meet<V: BlockVisitor<'w>>(
        &mut self,
        number: usize,
        rows: &mut std::slice::Iter<u32>,
        memory: &mut WaveMemory<'w>,
        visitor: &mut V,
    ) {
        let world = self.caster.world;
        let ray = &mut memory.rays[number];
        loop {
            if ray.slot.state == State::Ended {
                let Some(&row) = rows.next() else { return };
                self.begin_ray(InFlight { row: row as usize, slot: number }, ray, visitor);
                continue;
            }
            match ray.advance(world, self.caster.limits.steps) {
                Advance::Met(met) => {
                    let group = world.lane_group(met.placed.body);
                    memory.pairs.push(Pair { ray: number, group, met });
                    return;
                }
                Advance::Done => {
                    ray.slot.state = State::Ended;
                    visitor.end(ray.slot.in_flight, &ray.paths);
                }
                Advance::Refused => ray.slot.refuse(visitor),
            }
        }
    }

    fn begin_ray<V: BlockVisitor<'w>>(&self, in_flight: InFlight, to: &mut WaveRay<'w>, visitor: &mut V) {
        let span = self.query.scope.span;
        let [ox, oy, oz, dx, dy, dz] = self.block.rays[in_flight.row];
        match Ray::new(Vec3::new(ox, oy, oz), Vec3::new(dx, dy, dz)) {
            Ok(ray) => {
                let slot = Slot::new(in_flight, (0, 0), span.t_max());
                to.begin(slot, self.caster.world, Line::of(&ray), span);
            }
            // An array that is read in place may change.
            Err(_) => visitor.refuse(in_flight),
        }
    }

    /// Casts the rays of pairs of one group at their bodies, and passes their boundaries.
    fn cast_pairs<V: BlockVisitor<'w>>(
        &mut self,
        pairs: &[Pair<'w>],
        memory: &mut WaveMemory<'w>,
        visitor: &mut V,
    ) {
        let WaveMemory { rays, finds, bodies, .. } = memory;
        let FoldQuery { scope, wanted, .. } = self.query;
        let world = self.caster.world;
        let mut wants_normals = self.block.wants_normals;
        let is_deep = wants_normals && pairs.iter().any(|pair| rays[pair.ray].depth() > MOST_DEEP);
        wants_normals &= !is_deep;
        let mut open = u32::MAX >> (MOST_TOGETHER - pairs.len());
        let is_cast = match world.body(pairs[0].met.placed.body) {
            Body::Solid(SolidBody { takes_lanes: true, .. }) if pairs.len() > 1 => {
                let query = LaneQuery { scope, wanted, finds, scratch: &mut self.caster.scratch };
                dispatch(PairCast { query, pairs, rays, world, wants_normals });
                true
            }
            Body::Solid(body) if body.takes_waves && pairs.len() >= FEWEST_AT_MANY_LEAVES => {
                let request = BodyRequest { body, pairs, rays, scope, wanted, wants_normals };
                bodies.run(&request, finds, || self.block.is_cancelled());
                true
            }
            _ => false,
        };
        if is_cast {
            open = finds.open;
            let passing = self.passing::<V>();
            for &LaneFind { place, boundary, normal } in &finds.all {
                let Pair { ray, met, .. } = &pairs[place as usize];
                let ray = &mut rays[*ray];
                let entry = is_deep.then(|| ray.body_entry(met));
                let normal = entry.as_ref().map_or(Normal::Known(normal), Normal::Open);
                let found = Found { paths: &ray.paths, placed: met.placed, boundary, normal };
                ray.slot.pass(found, met.enter, passing, visitor);
            }
        }
        for place in ones(open) {
            let Pair { ray, met, .. } = &pairs[place];
            let entry = rays[*ray].body_entry(met);
            let WaveRay { slot, paths, walk, .. } = &mut rays[*ray];
            self.fold_body(slot, (paths, walk.steps), &entry, visitor);
        }
    }
}

/// Casts the rays of pairs of one group at their bodies.
struct PairCast<'a, 'c, 'w> {
    query: LaneQuery<'a, 'c>,
    pairs: &'a [Pair<'w>],
    rays: &'a [WaveRay<'w>],
    world: &'w World,
    wants_normals: bool,
}

impl Task for PairCast<'_, '_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self) {
        self.query.finds.clear();
        for first in (0..self.pairs.len()).step_by(S::Wide::LANES) {
            self.cast_some::<S::Wide>(first);
        }
    }
}

impl<'w> PairCast<'_, '_, 'w> {
    /// Casts the pairs from a place on, as many as there are lanes.
    #[inline(always)]
    fn cast_some<F: Doubles>(&mut self, first: usize) {
        let some = &self.pairs[first..self.pairs.len().min(first + F::LANES)];
        // Other lanes hold the first pair.
        let pair = |lane: usize| some.get(lane).unwrap_or(&some[0]);
        let (mut lines, mut frames) =
            ([self.rays[some[0].ray].line(); 8], [&some[0].met.placement.local_from_parent; 8]);
        let mut places = [first as u8; 8];
        for (lane, Pair { ray, met, .. }) in some.iter().enumerate() {
            lines[lane] = self.rays[*ray].line();
            frames[lane] = &met.placement.local_from_parent;
            places[lane] = (first + lane) as u8;
        }
        let line = LineLanes::<F>::each(&lines).in_frames(&frames);
        let limit = gather(|lane| self.rays[pair(lane).ray].slot.limit);
        let cast = Cast { used: u8::MAX >> (8 - some.len()), limit, places };
        let frames = if self.wants_normals {
            level_frames(self.rays, &some.iter().collect::<ArrayVec<&Pair, 8>>())
        } else {
            LevelFrames::new_const()
        };
        let above = if self.wants_normals { Some(Frames::Each(&frames)) } else { None };
        let Some(body) = solid_body(self.world, &some[0]) else { return };
        let is_same = some.iter().all(|pair| pair.met.placed.body == some[0].met.placed.body);
        if is_same {
            return self.query.at_bodies(Bodies::Same(body), &line, &cast, above);
        }
        let mut bodies = [body; 8];
        for (to, pair) in bodies.iter_mut().zip(some) {
            *to = solid_body(self.world, pair).unwrap_or(body);
        }
        self.query.at_bodies(Bodies::Each(&bodies), &line, &cast, above);
    }
}

fn solid_body<'w>(world: &'w World, pair: &Pair) -> Option<&'w SolidBody> {
    match world.body(pair.met.placed.body) {
        Body::Solid(body) => Some(body),
        Body::Surface(_) => None,
    }
}
