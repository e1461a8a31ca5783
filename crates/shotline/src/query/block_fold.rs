//! The fold of a block of rays, which casts the rays that need the same mesh at it together.
//!
//! Rays that run close together are bundled, and traverse levels together ([`Bundle`]). At a body with meshes a ray waits
//! until all rays in flight do. Then the rays that wait for a mesh are cast at it as one block. At a body
//! without meshes the rays of a bundle that meet it are cast together at once (`meetings`); a ray alone is folded by the plain
//! path.

use std::ops::Range;

use super::Limits;
use super::block_visitor::{BlockVisitor, Found, InFlight, Normal, Passing, Slot, State};
use super::bundle::{Advance, Bundle, BundleMemory, Pause};
use super::bundle_lists::BundleLists;
use super::bundle_stream::BundleStream;
use super::bundles::{Bundling, Rows};
use super::caster::Caster;
use super::fold_query::{FoldControl, FoldQuery};
use super::lane_cast::LaneFinds;
use super::level_paths::LevelPaths;
use super::level_visit::ManyRays;
use super::mesh_requests::{MeshRequest, MeshRequests};
use super::offers::Offers;
use super::row_block::RowBlock;
use super::traversal::{BodyEntry, Traversal};
use super::wave_memory::WaveMemory;
use crate::aabb::BoxRay;
use crate::accel::{BEAM_RAYS, ByRay};
use crate::compile::{Body, SurfaceBody};
use crate::csg::Boundary;
use crate::math::Affine;
use crate::solid::Wanted;

/// The most bundles in flight.
const BUNDLES: usize = 64;

/// The rays in flight.
#[derive(Debug, Default)]
pub(super) struct Flight<'w> {
    pub slots: Vec<Slot>,
    /// The body of each slot that waits.
    pub waiting: Vec<BodyEntry>,
    /// The offers of each slot.
    offers: Vec<Offers>,
    /// The bundles, each with [`BEAM_RAYS`] slots, and how many of these it uses.
    pub bundles: Vec<Bundle<'w>>,
    counts: Vec<usize>,
    /// The bundles with rays that have not ended, and the others.
    pub active: Vec<usize>,
    free: Vec<usize>,
    memory: BundleMemory,
    pub finds: LaneFinds,
    pub stream: BundleStream,
    pub lists: BundleLists,
    /// The rays of a bundle in a body.
    pub body_rays: Box<ManyRays>,
    /// The transforms into the body that is cast at.
    pub frames: Vec<&'w Affine>,
}

impl<'w> Flight<'w> {
    /// Begins without rays.
    fn clear(&mut self) {
        self.active.clear();
        self.free.clear();
        self.free.extend((0..BUNDLES).rev());
    }

    /// Makes room for a bundle. A small batch must not pay for memory that it does not use.
    fn make_room(&mut self, bundle: usize) {
        let (bundles, in_flight) = (bundle + 1, (bundle + 1) * BEAM_RAYS);
        if self.counts.len() < bundles {
            self.slots.resize(in_flight, Slot::default());
            self.waiting.resize(in_flight, BodyEntry::NONE);
            self.offers.resize(in_flight, Offers::default());
            self.bundles.resize_with(bundles, Bundle::default);
            self.counts.resize(bundles, 0);
        }
    }

    /// The slots that a bundle uses.
    pub fn range(&self, bundle: usize) -> Range<usize> {
        bundle * BEAM_RAYS..bundle * BEAM_RAYS + self.counts[bundle]
    }

    /// A slot, its bundle and the body that it waits for.
    pub fn parts(&mut self, slot: usize) -> (&mut Slot, &Bundle<'w>, &BodyEntry) {
        let body_entry = &self.waiting[slot];
        let slot = &mut self.slots[slot];
        let bundle = &self.bundles[slot.bundle];
        (slot, bundle, body_entry)
    }
}

/// The memory of folds; reused from block to block.
#[derive(Debug, Default)]
pub(super) struct FoldMemory<'w> {
    flight: Flight<'w>,
    requests: MeshRequests,
    wave: WaveMemory<'w>,
    bundling: Option<Bundling>,
}

/// The fold of one block.
pub(super) struct BlockFold<'f, 'w> {
    pub caster: &'f mut Caster<'w>,
    pub block: &'f RowBlock<'f>,
    pub query: FoldQuery<'f>,
}

impl<'f, 'w> BlockFold<'f, 'w> {
    /// Passes the boundaries of all rays to a visitor. After a cancellation they mean nothing.
    pub fn run<V: BlockVisitor<'w>>(&mut self, memory: &mut FoldMemory<'w>, visitor: &mut V) {
        let FoldMemory { flight, requests, wave, bundling } = memory;
        let bundling = *bundling.get_or_insert_with(|| Bundling::of(self.caster.world));
        flight.clear();
        let mut next = 0;
        while !self.block.is_cancelled() {
            requests.clear();
            let mut active = std::mem::take(&mut flight.active);
            active.retain(|&bundle| {
                let goes_on = self.advance(bundle, flight, requests, visitor);
                if !goes_on {
                    flight.free.push(bundle);
                }
                goes_on
            });
            while next < self.block.rays.len()
                && let Some(bundle) = flight.free.pop()
            {
                flight.make_room(bundle);
                visitor.make_room((bundle + 1) * BEAM_RAYS);
                let (rows, is_loose) = match bundling.next(self.block.rays, next) {
                    Rows::Close(rows) => (rows, false),
                    Rows::Loose(rows) => (rows, true),
                    Rows::Single(row) => (row..row + 1, false),
                    Rows::Wave(rows) => {
                        flight.free.push(bundle);
                        next = rows.end;
                        wave.rows.extend(rows.map(|row| row as u32));
                        continue;
                    }
                    Rows::Plain(rows) => {
                        flight.free.push(bundle);
                        next = rows.end;
                        let slot = bundle * BEAM_RAYS;
                        rows.for_each(|row| visitor.refuse(InFlight { row, slot }));
                        continue;
                    }
                };
                next = rows.end;
                self.begin(bundle, (rows, is_loose), flight, visitor);
                if self.advance(bundle, flight, requests, visitor) {
                    active.push(bundle);
                } else {
                    flight.free.push(bundle);
                }
            }
            flight.active = active;
            if requests.all.is_empty() {
                break;
            }
            self.cast(flight, requests, visitor);
        }
        self.cast_waves(wave, visitor);
    }

    /// Begins a bundle with the rays of some rows.
    fn begin<V: BlockVisitor<'w>>(
        &mut self,
        bundle: usize,
        (rows, is_loose): (Range<usize>, bool),
        flight: &mut Flight<'w>,
        visitor: &mut V,
    ) {
        let (world, span) = (self.caster.world, self.query.scope.span);
        flight.counts[bundle] = rows.len();
        let slots = flight.range(bundle);
        for (place, (slot, row)) in slots.clone().zip(rows.clone()).enumerate() {
            flight.offers[slot].clear();
            flight.slots[slot] = Slot::new(InFlight { row, slot }, (bundle, place), span.t_max());
        }
        let Flight { slots: all, bundles, memory, .. } = flight;
        let rays = &self.block.rays[rows];
        if rays.iter().all(is_ray) {
            bundles[bundle].begin(world, (rays, is_loose), span, memory, &mut self.caster.scratch);
            return;
        }
        // A row is not valid: an array that is read in place may change.
        for slot in &mut all[slots] {
            slot.refuse(visitor);
        }
    }

    /// Advances the rays of a bundle until each waits for meshes, has ended, or needs those that wait to go on. Returns
    /// whether there are rays that have not ended.
    fn advance<V: BlockVisitor<'w>>(
        &mut self,
        number: usize,
        flight: &mut Flight<'w>,
        requests: &mut MeshRequests,
        visitor: &mut V,
    ) -> bool {
        let range = flight.range(number);
        loop {
            let Flight { slots, offers, bundles, memory, waiting, .. } = &mut *flight;
            let bundle = &mut bundles[number];
            let (slots, offers) = (&mut slots[range.clone()], &mut offers[range.clone()]);
            let waiting = &mut waiting[range.clone()];
            let (mut wait, mut have_ended) = (false, true);
            for (place, (slot, offers)) in slots.iter_mut().zip(&mut *offers).enumerate() {
                if !offers.is_empty() {
                    let body_entry = &mut waiting[place];
                    self.take_offers(slot, bundle, offers, body_entry, requests, visitor);
                }
                wait |= slot.state == State::Waiting;
                have_ended &= slot.state == State::Ended;
            }
            if wait || have_ended {
                return wait;
            }
            let mut reach = Reach::of(slots);
            let mut pause = self.offer(&reach, offers, bundle, memory);
            while pause == Pause::Met {
                self.cast_together(number, &mut reach, flight, visitor);
                let Flight { offers, bundles, memory, .. } = &mut *flight;
                pause = self.offer(&reach, &mut offers[range.clone()], &mut bundles[number], memory);
            }
            let Flight { slots, offers, bundles, .. } = &mut *flight;
            let (slots, offers) = (&mut slots[range.clone()], &offers[range.clone()]);
            let bundle = &bundles[number];
            let is_done = pause == Pause::Done && offers.iter().all(Offers::is_empty);
            if !is_done && pause != Pause::Refused {
                continue;
            }
            for slot in slots {
                if slot.state == State::Ready {
                    slot.state = State::Ended;
                    match pause {
                        Pause::Refused => visitor.refuse(slot.in_flight),
                        _ => visitor.end(slot.in_flight, &bundle.paths),
                    }
                }
            }
            return false;
        }
    }

    /// Offers bodies to the rays of a bundle.
    fn offer(
        &mut self,
        reach: &Reach,
        offers: &mut [Offers],
        bundle: &mut Bundle<'w>,
        memory: &mut BundleMemory,
    ) -> Pause {
        if bundle.is_done() {
            return Pause::Done;
        }
        let Caster { world, scratch, limits: Limits { steps, .. }, .. } = &mut *self.caster;
        let span = self.query.scope.span;
        let (limits, limit) = (&reach.limits, reach.largest());
        let mut advance = Advance { world, span, limits, limit, offers, scratch };
        bundle.advance(*steps, memory, &mut advance)
    }

    /// Takes the offers of a ray until it waits for the meshes of `body_entry`, has ended, or has no more.
    fn take_offers<V: BlockVisitor<'w>>(
        &mut self,
        slot: &mut Slot,
        bundle: &mut Bundle<'w>,
        offers: &mut Offers,
        body_entry: &mut BodyEntry,
        requests: &mut MeshRequests,
        visitor: &mut V,
    ) {
        while slot.state != State::Waiting
            && let Some(offer) = offers.take()
        {
            if slot.state == State::Ended || offer.enter > slot.limit {
                bundle.release(offer.visit);
                continue;
            }
            *body_entry = bundle.body(&offer, slot.place);
            if self.request(slot, body_entry, requests) {
                slot.state = State::Waiting;
            } else {
                self.fold_body(slot, (&bundle.paths, bundle.steps), body_entry, visitor);
            }
        }
    }

    /// The query for which boundaries are passed.
    pub(super) fn passing<V: BlockVisitor<'w>>(&self) -> Passing<'f> {
        let is_closest = self.query.wanted == Wanted::First && !V::IS_ANY;
        Passing { rays: self.block.rays, kinds: self.query.scope.kinds, is_closest }
    }

    /// Folds a body by the plain path. `steps` have been taken by the traversal of levels.
    pub(super) fn fold_body<V: BlockVisitor<'w>>(
        &mut self,
        slot: &mut Slot,
        (paths, steps): (&LevelPaths<'w>, u64),
        body_entry: &BodyEntry,
        visitor: &mut V,
    ) {
        let (most, passing) = (self.caster.limits.steps, self.passing::<V>());
        self.caster.scratch.budget.begin(most.saturating_sub(steps + slot.steps));
        let mut limit = slot.limit;
        let mut fold = |_: &mut Traversal<'w>, body_entry: &BodyEntry, boundary: Boundary| {
            let (placed, normal) = (body_entry.placed, Normal::Open(body_entry));
            slot.pass(Found { paths, placed, boundary, normal }, body_entry.enter, passing, visitor);
            if slot.state == State::Ended { FoldControl::Stop } else { FoldControl::Limit(slot.limit) }
        };
        let _ = self.caster.fold_body(body_entry, &self.query, &mut limit, &mut fold);
        slot.steps += self.caster.scratch.budget.used();
        if self.caster.outcome().is_err() {
            slot.refuse(visitor);
        } else if slot.state != State::Ended {
            slot.state = State::Ready;
        }
    }

    /// Requests what a ray needs of the meshes of a body. Returns `false` if that is nothing.
    fn request(&mut self, slot: &Slot, body_entry: &BodyEntry, requests: &mut MeshRequests) -> bool {
        let (body, span) = (self.caster.world.body(body_entry.placed.body), self.query.scope.span);
        // As for a single ray: the limit itself counts.
        let end = if slot.limit < span.t_max() { slot.limit.next_up() } else { span.t_max() };
        let mut request = |leaf: u32, local_from_body: &Affine| {
            let slot = slot.in_flight.slot as u32;
            let line = body_entry.line.in_frame(local_from_body);
            requests.push(MeshRequest { body: body_entry.placed.body, leaf, slot }, &line, end);
        };
        if let Body::Surface(SurfaceBody { mesh, local_from_body, .. }) = body {
            let casts_blocks = mesh.casts_blocks();
            if casts_blocks {
                request(0, local_from_body);
            }
            return casts_blocks;
        }
        let (mut boxes, mut is_requested) = (None, false);
        for body_mesh in body.block_meshes() {
            let is_met = body.leaf_count() == 1 || {
                let boxes = boxes.get_or_insert_with(|| BoxRay::new(&body_entry.line, span));
                boxes.enter_exit(body_mesh.bounds).is_some()
            };
            if is_met {
                request(body_mesh.leaf, body_mesh.local_from_body);
                is_requested = true;
            }
        }
        is_requested
    }
}

/// Whether a row is a [`Ray`](crate::ray::Ray).
fn is_ray(row: &[f64; 6]) -> bool {
    let are_finite = row.iter().fold(true, |are, number| are & number.is_finite());
    are_finite & (row[3..] != [0.0; 3])
}

/// How far the rays of a bundle look.
pub(super) struct Reach {
    /// How far each of them looks; -infinity for those that do not go on now.
    pub limits: ByRay,
}

impl Reach {
    fn of(slots: &[Slot]) -> Reach {
        let mut reach = Reach { limits: [[f64::NEG_INFINITY; 8]; BEAM_RAYS / 8] };
        slots.iter().enumerate().for_each(|(place, slot)| reach.set(place, slot));
        reach
    }

    pub fn set(&mut self, place: usize, slot: &Slot) {
        let limit = if slot.state == State::Ready { slot.limit } else { f64::NEG_INFINITY };
        self.limits[place / 8][place % 8] = limit;
    }

    fn largest(&self) -> f64 {
        let mut largest = [f64::NEG_INFINITY; 8];
        for limits in &self.limits {
            largest
                .iter_mut()
                .zip(limits)
                .for_each(|(most, &limit)| *most = if limit > *most { limit } else { *most });
        }
        largest.into_iter().fold(f64::NEG_INFINITY, f64::max)
    }
}
