//! Casts the rays of a bundle together at a body that they have met.

use super::block_fold::{BlockFold, Flight, Reach};
use super::block_visitor::{BlockVisitor, Found, Normal};
use super::bundle::Meeting;
use super::bundle_lists::ListRequest;
use super::bundle_stream::StreamRequest;
use super::fold_query::FoldQuery;
use super::lane_cast::{LaneCast, LaneFind, LaneQuery};
use super::level_visit::ones;
use super::offers::Offer;
use super::traversal::BodyEntry;
use crate::accel::MetRays;
use crate::compile::{Body, SolidBody};
use crate::simd::dispatch;
use crate::solid::Wanted;

/// A meeting, and the body.
struct Met<'m, 'w> {
    meeting: &'m Meeting,
    body: &'w SolidBody,
    /// The bundle, and its first slot.
    bundle: usize,
    first_slot: usize,
}

impl Met<'_, '_> {
    /// Where the ray at a place enters the box of the body.
    fn enter(&self, place: usize) -> f64 {
        self.meeting.rays.enter[place / 8][place % 8]
    }

    /// The ray at a place in the body.
    fn entry(&self, flight: &Flight, place: usize) -> BodyEntry {
        let Meeting { visit, placement, .. } = *self.meeting;
        let enter = self.enter(place);
        flight.bundles[self.bundle].body_entry(&Offer { enter, visit, placement }, place)
    }
}

impl<'w> BlockFold<'_, 'w> {
    /// Casts the rays of a bundle that have met a body at it, and passes their boundaries.
    pub(super) fn cast_together<V: BlockVisitor<'w>>(
        &mut self,
        bundle: usize,
        reach: &mut Reach,
        flight: &mut Flight<'w>,
        visitor: &mut V,
    ) {
        let Some(meeting) = flight.bundles[bundle].meeting.take() else { return };
        let placed = flight.bundles[bundle].placed_body(meeting.visit, meeting.placement);
        let Body::Solid(body) = self.caster.world.body(placed.body) else {
            unreachable!("only solids are cast at together")
        };
        let met = Met { meeting: &meeting, body, bundle, first_slot: flight.range(bundle).start };
        let open = if body.takes_lanes {
            self.cast_in_lanes(&met, reach, flight, visitor)
        } else if self.query.wanted == Wanted::All {
            self.list(&met, reach, flight, visitor)
        } else {
            self.stream(&met, reach, flight, visitor)
        };
        for place in ones(open) {
            let entry = met.entry(flight, place);
            let slot = &mut flight.slots[met.first_slot + place];
            let bundle = &flight.bundles[bundle];
            self.fold_body(slot, (&bundle.paths, bundle.steps), &entry, visitor);
            reach.set(place, slot);
        }
        flight.bundles[bundle].release(meeting.visit);
    }

    /// Casts at a body of few leaves. Returns the rays that are left open.
    fn cast_in_lanes<V: BlockVisitor<'w>>(
        &mut self,
        met: &Met<'_, 'w>,
        reach: &mut Reach,
        flight: &mut Flight<'w>,
        visitor: &mut V,
    ) -> u32 {
        let Flight { bundles, slots, finds, frames, .. } = flight;
        let bundle = &bundles[met.bundle];
        let Some(rays) = bundle.rays(met.meeting.visit) else { return met.meeting.rays.rays };
        let placed = bundle.placed_body(met.meeting.visit, met.meeting.placement);
        frames.clear();
        frames.extend(bundle.paths.frames(&placed));
        let FoldQuery { scope, wanted, .. } = self.query;
        dispatch(LaneCast {
            query: LaneQuery { scope, wanted, finds, scratch: &mut self.caster.scratch },
            body: met.body,
            rays,
            places: met.meeting.rays.rays,
            frames,
            wants_normals: self.block.wants_normals,
            limits: &reach.limits,
        });
        let passing = self.passing::<V>();
        for &LaneFind { place, boundary, normal } in &finds.all {
            let slot = &mut slots[met.first_slot + place as usize];
            let found = Found { paths: &bundle.paths, placed, boundary, normal: Normal::Known(normal) };
            slot.pass(found, met.enter(place as usize), passing, visitor);
            reach.set(place as usize, slot);
        }
        finds.open
    }

    /// Casts at a body of many leaves for all boundaries. Returns the rays that are left open.
    fn list<V: BlockVisitor<'w>>(
        &mut self,
        met: &Met<'_, 'w>,
        reach: &mut Reach,
        flight: &mut Flight<'w>,
        visitor: &mut V,
    ) -> u32 {
        let Meeting { visit, placement, rays: MetRays { rays: places, .. } } = *met.meeting;
        let Flight { bundles, slots, lists, frames, body_rays, .. } = flight;
        let bundle = &bundles[met.bundle];
        let Some(rays) = bundle.rays(visit) else { return places };
        let (placed, scope) = (bundle.placed_body(visit, placement), self.query.scope);
        frames.clear();
        frames.extend(bundle.paths.frames(&placed));
        let rays = if frames[0].is_identity() && bundle.has_own_boxes(visit) {
            rays
        } else {
            body_rays.set_below(rays, places, frames[0], None, scope.span);
            &*body_rays
        };
        let request = ListRequest {
            body: met.body,
            rays,
            places,
            scope,
            frames: self.block.wants_normals.then_some(&frames[..]),
            cancel: self.block.cancel,
        };
        let passing = self.passing::<V>();
        let open = lists.run(&request, &mut self.caster.scratch);
        for place in ones(places & !open) {
            let slot = &mut slots[met.first_slot + place];
            for (boundary, normal) in lists.boundaries(place, scope.span) {
                let found = Found { paths: &bundle.paths, placed, boundary, normal: Normal::Known(normal) };
                slot.pass(found, met.enter(place), passing, visitor);
            }
            reach.set(place, slot);
        }
        open
    }

    /// Casts at a body of many leaves for the first boundary. Returns the rays that are left open.
    fn stream<V: BlockVisitor<'w>>(
        &mut self,
        met: &Met<'_, 'w>,
        reach: &mut Reach,
        flight: &mut Flight<'w>,
        visitor: &mut V,
    ) -> u32 {
        let places = met.meeting.rays.rays;
        let bundle = &flight.bundles[met.bundle];
        let Some(rays) = bundle.rays(met.meeting.visit) else { return places };
        let placed = bundle.placed_body(met.meeting.visit, met.meeting.placement);
        let frame = bundle.frame(met.meeting.visit, met.meeting.placement);
        let span = self.query.scope.span;
        let rays = if frame.is_identity() && bundle.has_own_boxes(met.meeting.visit) {
            rays
        } else {
            flight.body_rays.set_below(rays, places, frame, None, span);
            &*flight.body_rays
        };
        let request = StreamRequest {
            body: met.body,
            rays,
            places,
            scope: self.query.scope,
            limits: &reach.limits,
            cancel: self.block.cancel,
        };
        let passing = self.passing::<V>();
        let open = flight.stream.run(&request, &mut self.caster.scratch);
        for place in ones(places & !open) {
            let Some(boundary) = flight.stream.first(place) else { continue };
            let entry = met.entry(flight, place);
            let (bundle, slot) = (&flight.bundles[met.bundle], &mut flight.slots[met.first_slot + place]);
            let found = Found { paths: &bundle.paths, placed, boundary, normal: Normal::Open(&entry) };
            slot.pass(found, entry.enter, passing, visitor);
            reach.set(place, slot);
        }
        open
    }
}
