//! The fold of a block of rays, which casts the rays that need the same mesh at it together.
//!
//! Every ray in flight has a traversal of its own, and meets the bodies that it would meet in a fold by itself, in the
//! same order. At a body with meshes it waits until all rays in flight do. Then the rays that wait for a mesh are cast
//! at it as one block. Bodies without meshes are folded ray by ray.

use std::ops::Range;

use super::caster::Caster;
use super::first_boundaries::{ClosedMesh, First};
use super::fold_query::{FoldControl, FoldQuery};
use super::mesh_requests::{MeshRequest, MeshRequests};
use super::row_block::RowBlock;
use super::traversal::{BodyEntry, Traversal};
use crate::aabb::BoxRay;
use crate::budget::Budget;
use crate::compile::{Body, SurfaceBody};
use crate::csg::{Boundary, SingleLeaf};
use crate::math::Vec3;
use crate::ray::{Line, Ray};
use crate::solid::Wanted;
use crate::solid::mesh::MeshSolid;
use crate::solid::mesh::kernel::BlockQuery;

/// The number of rays in flight.
pub(super) const IN_FLIGHT: usize = 64;

/// A ray in flight: its row in the block, and its number among the rays in flight.
#[derive(Clone, Copy, Debug)]
pub(super) struct InFlight {
    pub row: usize,
    pub slot: usize,
}

/// What a query does with the boundaries of the rays of a block.
pub(super) trait BlockVisitor<'w> {
    /// Whether any boundary is enough, and nothing needs to be known of it.
    const IS_ANY: bool = false;

    /// Takes a boundary. Those of one ray and body come one after the other.
    fn boundary(
        &mut self,
        ray: InFlight,
        traversal: &mut Traversal<'w>,
        body_entry: &BodyEntry,
        boundary: Boundary,
    ) -> FoldControl;

    /// Takes a ray that has a boundary, which ends it.
    fn any(&mut self, _ray: InFlight) {}

    /// Takes the end of a ray, after all its boundaries.
    fn end(&mut self, _ray: InFlight, _traversal: &Traversal<'w>) {}

    /// Takes a ray that has to be cast by the plain path. What was passed of it means nothing.
    fn refuse(&mut self, ray: InFlight);
}

/// A ray in flight.
#[derive(Debug)]
struct Slot<'w> {
    in_flight: InFlight,
    traversal: Box<Traversal<'w>>,
    budget: Budget<'w>,
    limit: f64,
    state: State,
}

#[derive(Clone, Copy, Debug)]
enum State {
    /// There is no ray.
    Free,
    /// The ray goes on to its next body.
    Ready,
    /// The ray needs the meshes of a body.
    Waiting(BodyEntry),
}

impl<'w> Slot<'w> {
    fn new(slot: usize) -> Slot<'w> {
        Slot {
            in_flight: InFlight { row: 0, slot },
            traversal: Box::default(),
            budget: Budget::default(),
            limit: 0.0,
            state: State::Free,
        }
    }

    /// Exchanges the traversal and the budget of the ray with those of the caster.
    fn exchange(&mut self, caster: &mut Caster<'w>) {
        std::mem::swap(&mut self.traversal, &mut caster.traversal);
        std::mem::swap(&mut self.budget, &mut caster.scratch.budget);
    }
}

/// The memory of folds; reused from block to block.
#[derive(Debug, Default)]
pub(super) struct FoldMemory<'w> {
    slots: Vec<Slot<'w>>,
    requests: MeshRequests,
}

/// The fold of one block.
pub(super) struct BlockFold<'f, 'w> {
    pub caster: &'f mut Caster<'w>,
    pub block: &'f RowBlock<'f>,
    pub query: FoldQuery<'f>,
}

impl<'w> BlockFold<'_, 'w> {
    /// Passes the boundaries of all rays to a visitor. After a cancellation they mean nothing.
    pub fn run<V: BlockVisitor<'w>>(&mut self, memory: &mut FoldMemory<'w>, visitor: &mut V) {
        let FoldMemory { slots, requests } = memory;
        slots.iter_mut().for_each(|slot| slot.state = State::Free);
        let mut next = 0;
        while !self.block.is_cancelled() {
            requests.all.clear();
            for number in 0..IN_FLIGHT.min(self.block.rays.len()) {
                if number == slots.len() {
                    slots.push(Slot::new(number));
                }
                let slot = &mut slots[number];
                loop {
                    match slot.state {
                        State::Free if next < self.block.rays.len() => {
                            self.begin(slot, next, visitor);
                            next += 1;
                        }
                        State::Ready => self.advance(slot, requests, visitor),
                        State::Free | State::Waiting(_) => break,
                    }
                }
            }
            if requests.all.is_empty() {
                return;
            }
            self.cast(slots, requests, visitor);
        }
    }

    /// Begins the ray of a row.
    fn begin<V: BlockVisitor<'w>>(&mut self, slot: &mut Slot<'w>, row: usize, visitor: &mut V) {
        let (caster, span) = (&mut *self.caster, self.query.scope.span);
        slot.in_flight.row = row;
        let [ox, oy, oz, dx, dy, dz] = self.block.rays[row];
        let Ok(ray) = Ray::new(Vec3::new(ox, oy, oz), Vec3::new(dx, dy, dz)) else {
            return visitor.refuse(slot.in_flight);
        };
        (slot.limit, slot.state) = (span.t_max(), State::Ready);
        slot.budget = caster.scratch.budget.clone();
        slot.budget.begin(caster.limits.steps);
        slot.traversal.begin(caster.world, Line::of(&ray), span);
        slot.traversal.enter_root(caster.world, &mut caster.scratch);
    }

    /// Advances a ray to its next body with meshes, or to its end.
    fn advance<V: BlockVisitor<'w>>(
        &mut self,
        slot: &mut Slot<'w>,
        requests: &mut MeshRequests,
        visitor: &mut V,
    ) {
        slot.exchange(self.caster);
        loop {
            let caster = &mut *self.caster;
            let Some(body_entry) = caster.traversal.next(caster.world, slot.limit, &mut caster.scratch)
            else {
                return self.end(slot, visitor);
            };
            if self.request(slot, &body_entry, requests) {
                slot.state = State::Waiting(body_entry);
                return slot.exchange(self.caster);
            }
            if self.fold_body(slot, &body_entry, visitor) {
                return self.end(slot, visitor);
            }
        }
    }

    /// Ends a ray whose traversal is in the caster.
    fn end<V: BlockVisitor<'w>>(&mut self, slot: &mut Slot<'w>, visitor: &mut V) {
        let failed = self.caster.outcome().is_err();
        slot.exchange(self.caster);
        slot.state = State::Free;
        if failed {
            visitor.refuse(slot.in_flight);
        } else {
            visitor.end(slot.in_flight, &slot.traversal);
        }
    }

    /// Folds a body by the plain path, for a ray whose traversal is in the caster. Returns whether the query stops it.
    fn fold_body<V: BlockVisitor<'w>>(
        &mut self,
        slot: &mut Slot<'w>,
        body_entry: &BodyEntry,
        visitor: &mut V,
    ) -> bool {
        let in_flight = slot.in_flight;
        let mut fold = |traversal: &mut Traversal<'w>, body_entry: &BodyEntry, boundary| {
            visitor.boundary(in_flight, traversal, body_entry, boundary)
        };
        self.caster.fold_body(body_entry, &self.query, &mut slot.limit, &mut fold).is_break()
    }

    /// Requests what a ray needs of the meshes of a body. Returns `false` if that is nothing.
    fn request(&mut self, slot: &Slot, body_entry: &BodyEntry, requests: &mut MeshRequests) -> bool {
        let (body, span) = (self.caster.world.body(body_entry.body), self.query.scope.span);
        let before = requests.all.len();
        let mut boxes = None;
        for body_mesh in body.block_meshes() {
            let is_met = body.leaf_count() == 1 || {
                let boxes = boxes.get_or_insert_with(|| BoxRay::new(&body_entry.line, span));
                boxes.enter_exit(body_mesh.bounds).is_some()
            };
            if is_met {
                requests.all.push(MeshRequest {
                    body: body_entry.body,
                    leaf: body_mesh.leaf,
                    slot: slot.in_flight.slot as u32,
                    line: body_entry.line.in_frame(body_mesh.local_from_body),
                    // As for a single ray: the limit itself counts.
                    end: if slot.limit < span.t_max() { slot.limit.next_up() } else { span.t_max() },
                });
            }
        }
        requests.all.len() > before
    }

    /// Casts all requests, and passes the boundaries of the bodies that rays wait for.
    fn cast<V: BlockVisitor<'w>>(
        &mut self,
        slots: &mut [Slot<'w>],
        requests: &mut MeshRequests,
        visitor: &mut V,
    ) {
        requests.sort();
        self.caster.stream.operands.crossings.clear();
        let (world, mut start) = (self.caster.world, 0);
        let mut operands = Vec::new();
        while let Some(group) = requests.group(start) {
            start = group.end;
            let MeshRequest { body, leaf, .. } = requests.all[group.start];
            match world.body(body) {
                Body::Surface(surface) => self.cast_at_surface(surface, group, slots, requests, visitor),
                Body::Solid(body) => {
                    let Some(mesh) = body.leaves[leaf as usize].solid.as_mesh() else { continue };
                    if body.leaves.len() == 1 {
                        self.cast_at_solid(mesh, group, slots, requests, visitor);
                    } else {
                        self.cast_at_operand(mesh, group, requests, &mut operands);
                    }
                }
            }
        }
        operands.sort_unstable_by_key(|(slot, leaf, _)| (*slot, *leaf));
        let mut rest = &operands[..];
        for slot in slots {
            let State::Waiting(body_entry) = slot.state else { continue };
            let number = slot.in_flight.slot as u32;
            let before = rest.partition_point(|(of, ..)| *of < number);
            let count = rest[before..].partition_point(|(of, ..)| *of == number);
            let lists = &rest[before..before + count];
            rest = &rest[before + count..];
            let leaves = &mut self.caster.stream.operands.leaves;
            leaves.extend(
                lists.iter().map(|(_, leaf, range): &(u32, u32, Range<usize>)| (*leaf, range.clone())),
            );
            self.fold_plainly(slot, &body_entry, visitor);
            self.caster.stream.operands.leaves.clear();
        }
    }

    fn cast_at_surface<V: BlockVisitor<'w>>(
        &mut self,
        surface: &SurfaceBody,
        group: Range<usize>,
        slots: &mut [Slot<'w>],
        requests: &mut MeshRequests,
        visitor: &mut V,
    ) {
        let (span, mesh, cancel) = (self.query.scope.span, &surface.mesh, self.block.cancel);
        let slot_of = |requests: &MeshRequests, row: usize| requests.all[group.start + row].slot as usize;
        if self.query.wanted == Wanted::All {
            requests.cast_all(mesh, group.clone(), span, BlockQuery::All, cancel);
            for row in 0..group.len() {
                let slot = &mut slots[slot_of(requests, row)];
                match requests.lists.hits(row) {
                    Some(hits) => {
                        let boundaries = hits.iter().map(|hit| Boundary::of_leaf(hit.crossing));
                        self.pass(slot, boundaries, visitor);
                    }
                    None => self.go_on_plainly(slot, visitor),
                }
            }
            return;
        }
        let query = if V::IS_ANY { BlockQuery::Any } else { BlockQuery::Nearest };
        let block = requests.rows.block(&requests.all[group.clone()], span, cancel);
        mesh.cast_block(&block, query, &mut requests.kernel);
        for &row in requests.kernel.plain_rows() {
            self.go_on_plainly(&mut slots[slot_of(requests, row as usize)], visitor);
        }
        for row in requests.kernel.rows_hit() {
            pass_any(&mut slots[slot_of(requests, row)], visitor);
        }
        if self.block.wants_normals {
            mesh.prefetch(requests.kernel.hits().iter().map(|hit| hit.crossing.primitive));
        }
        for hit in requests.kernel.hits() {
            let slot = &mut slots[slot_of(requests, hit.row as usize)];
            self.pass(slot, [Boundary::of_leaf(hit.crossing)].into_iter(), visitor);
        }
        self.go_on_without(&group, slots, requests);
    }

    fn cast_at_solid<V: BlockVisitor<'w>>(
        &mut self,
        mesh: &MeshSolid,
        group: Range<usize>,
        slots: &mut [Slot<'w>],
        requests: &mut MeshRequests,
        visitor: &mut V,
    ) {
        if self.query.wanted == Wanted::All {
            self.cast_at_solid_for_all(mesh, group.clone(), slots, requests, visitor);
        } else {
            let MeshRequests { all, rows, boundaries, .. } = requests;
            let block = rows.block(&all[group.clone()], self.query.scope.span, self.block.cancel);
            let wants_normals_later = self.block.wants_normals;
            let closed =
                ClosedMesh { mesh, block: &block, kinds: self.query.scope.kinds, wants_normals_later };
            let slot_of = |row: usize| all[group.start + row].slot as usize;
            if V::IS_ANY {
                boundaries.any(&closed, |row, is_boundary| match is_boundary {
                    true => pass_any(&mut slots[slot_of(row)], visitor),
                    false => self.go_on_plainly(&mut slots[slot_of(row)], visitor),
                });
            } else {
                boundaries.closest(&closed, |row, first| match first {
                    First::Boundary(boundary, _) => {
                        self.pass(&mut slots[slot_of(row)], [boundary].into_iter(), visitor);
                    }
                    First::Plain => self.go_on_plainly(&mut slots[slot_of(row)], visitor),
                });
            }
        }
        self.go_on_without(&group, slots, requests);
    }

    fn cast_at_solid_for_all<V: BlockVisitor<'w>>(
        &mut self,
        mesh: &MeshSolid,
        group: Range<usize>,
        slots: &mut [Slot<'w>],
        requests: &mut MeshRequests,
        visitor: &mut V,
    ) {
        let span = self.query.scope.span;
        requests.cast_all(mesh, group.clone(), span, BlockQuery::Within, self.block.cancel);
        for (row, request) in group.enumerate() {
            let slot = &mut slots[requests.all[request].slot as usize];
            let line = requests.rows.line(row);
            let boundaries = requests.lists.crossings(mesh, span, row, &line).and_then(|crossings| {
                let mut single = SingleLeaf::begin(crossings, span)?;
                Some(std::iter::from_fn(move || single.next(crossings)))
            });
            match boundaries {
                Some(boundaries) => self.pass(slot, boundaries, visitor),
                None => self.go_on_plainly(slot, visitor),
            }
        }
    }

    /// Computes the crossings of an operand, and notes the slots and ranges of those that the plain path need not
    /// compute.
    fn cast_at_operand(
        &mut self,
        mesh: &MeshSolid,
        group: Range<usize>,
        requests: &mut MeshRequests,
        operands: &mut Vec<(u32, u32, Range<usize>)>,
    ) {
        let span = self.query.scope.span;
        requests.cast_all(mesh, group.clone(), span, BlockQuery::Operand, self.block.cancel);
        let all = &mut self.caster.stream.operands.crossings;
        for (row, request) in group.enumerate() {
            let line = requests.rows.line(row);
            let MeshRequest { slot, leaf, .. } = requests.all[request];
            if let Some(crossings) = requests.lists.crossings(mesh, span, row, &line) {
                let start = all.len();
                all.extend_from_slice(crossings);
                operands.push((slot, leaf, start..all.len()));
            }
        }
    }

    /// Passes the boundaries of the body that a ray waits for. Does nothing if they have been passed.
    fn pass<V: BlockVisitor<'w>>(
        &mut self,
        slot: &mut Slot<'w>,
        boundaries: impl Iterator<Item = Boundary>,
        visitor: &mut V,
    ) {
        let State::Waiting(body_entry) = slot.state else { return };
        slot.state = State::Ready;
        for mut boundary in boundaries {
            if !self.query.scope.kinds.hold(boundary.kind) {
                continue;
            }
            // Turns -0.0 into 0.0, as in the fold of a single ray.
            boundary.crossing.t += 0.0;
            match visitor.boundary(slot.in_flight, &mut slot.traversal, &body_entry, boundary) {
                FoldControl::Limit(t) => slot.limit = slot.limit.min(t),
                FoldControl::Stop => {
                    slot.state = State::Free;
                    return visitor.end(slot.in_flight, &slot.traversal);
                }
            }
            if self.query.wanted == Wanted::First {
                return;
            }
        }
    }

    /// Folds the body that a ray waits for by the plain path.
    fn go_on_plainly<V: BlockVisitor<'w>>(&mut self, slot: &mut Slot<'w>, visitor: &mut V) {
        if let State::Waiting(body_entry) = slot.state {
            self.fold_plainly(slot, &body_entry, visitor);
        }
    }

    fn fold_plainly<V: BlockVisitor<'w>>(
        &mut self,
        slot: &mut Slot<'w>,
        body_entry: &BodyEntry,
        visitor: &mut V,
    ) {
        slot.exchange(self.caster);
        slot.state = State::Ready;
        if self.fold_body(slot, body_entry, visitor) {
            self.end(slot, visitor);
        } else {
            slot.exchange(self.caster);
        }
    }

    /// Lets the rays go on that miss the mesh they were cast at.
    fn go_on_without(&self, group: &Range<usize>, slots: &mut [Slot], requests: &MeshRequests) {
        for request in &requests.all[group.clone()] {
            let slot = &mut slots[request.slot as usize];
            if let State::Waiting(_) = slot.state {
                slot.state = State::Ready;
            }
        }
    }
}

/// Passes a ray that has a boundary, which ends it. Does nothing if it has been passed.
fn pass_any<'w, V: BlockVisitor<'w>>(slot: &mut Slot<'w>, visitor: &mut V) {
    if let State::Waiting(_) = slot.state {
        visitor.any(slot.in_flight);
        slot.state = State::Free;
    }
}
