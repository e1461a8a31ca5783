//! How the rays of a block are cast at the meshes that they wait for.

use std::ops::Range;

use super::block_fold::{BlockFold, Flight};
use super::block_visitor::{BlockVisitor, Found, Normal, Slot, State};
use super::first_boundaries::{ClosedMesh, First};
use super::mesh_requests::{MeshRequest, MeshRequests};
use crate::compile::{Body, SurfaceBody};
use crate::csg::{Boundary, SingleLeaf};
use crate::solid::Wanted;
use crate::solid::mesh::MeshSolid;
use crate::solid::mesh::kernel::BlockQuery;

impl<'w> BlockFold<'_, 'w> {
    /// Casts all requests, and passes the boundaries of the bodies that rays wait for.
    pub(super) fn cast<V: BlockVisitor<'w>>(
        &mut self,
        flight: &mut Flight<'w>,
        requests: &mut MeshRequests,
        visitor: &mut V,
    ) {
        requests.sort();
        self.caster.stream.operands.crossings.clear();
        let (world, mut start) = (self.caster.world, 0);
        let (mut operands, mut has_operands) = (Vec::new(), false);
        while let Some(group) = requests.group(start) {
            start = group.end;
            let MeshRequest { body, leaf, .. } = requests.all[group.start];
            match world.body(body) {
                Body::Surface(surface) => self.cast_at_surface(surface, group, flight, requests, visitor),
                Body::Solid(body) => {
                    let Some(mesh) = body.leaves[leaf as usize].solid.as_mesh() else { continue };
                    if body.leaves.len() == 1 {
                        self.cast_at_solid(mesh, group, flight, requests, visitor);
                    } else {
                        has_operands = true;
                        self.cast_at_operand(mesh, group, requests, &mut operands);
                    }
                }
            }
        }
        if !has_operands {
            return;
        }
        operands.sort_unstable_by_key(|(slot, leaf, _)| (*slot, *leaf));
        let active = std::mem::take(&mut flight.active);
        for &bundle in &active {
            for slot in flight.range(bundle) {
                if flight.slots[slot].state == State::Waiting {
                    self.go_on_with_operands(flight, slot, &operands, visitor);
                }
            }
        }
        flight.active = active;
    }

    /// Folds the body that a ray waits for, some of whose operands have been cast. `operands` has the slots, the leaves and
    /// the ranges of their crossings, sorted.
    fn go_on_with_operands<V: BlockVisitor<'w>>(
        &mut self,
        flight: &mut Flight<'w>,
        slot: usize,
        operands: &[(u32, u32, Range<usize>)],
        visitor: &mut V,
    ) {
        let start = operands.partition_point(|(of, ..)| (*of as usize) < slot);
        let of_slot = operands[start..].iter().take_while(|(of, ..)| *of as usize == slot);
        let of_slot = of_slot.map(|(_, leaf, range)| (*leaf, range.clone()));
        self.caster.stream.operands.leaves.extend(of_slot);
        self.go_on_plainly(flight, slot, visitor);
        self.caster.stream.operands.leaves.clear();
    }

    fn cast_at_surface<V: BlockVisitor<'w>>(
        &mut self,
        surface: &SurfaceBody,
        group: Range<usize>,
        flight: &mut Flight<'w>,
        requests: &mut MeshRequests,
        visitor: &mut V,
    ) {
        let (span, mesh, cancel) = (self.query.scope.span, &surface.mesh, self.block.cancel);
        let slot_of = |requests: &MeshRequests, row: usize| requests.all[group.start + row].slot as usize;
        if self.query.wanted == Wanted::All {
            requests.cast_all(mesh, group.clone(), span, BlockQuery::All, cancel);
            for row in 0..group.len() {
                let slot = slot_of(requests, row);
                match requests.lists.hits(row) {
                    Some(hits) => {
                        let boundaries = hits.iter().map(|hit| Boundary::of_leaf(hit.crossing));
                        self.pass(flight, slot, boundaries, visitor);
                    }
                    None => self.go_on_plainly(flight, slot, visitor),
                }
            }
            return;
        }
        let query = if V::IS_ANY { BlockQuery::Any } else { BlockQuery::Nearest };
        let block = requests.rows.block(group.clone(), span, cancel);
        mesh.cast_block(&block, query, &mut requests.kernel);
        for &row in requests.kernel.plain_rows() {
            self.go_on_plainly(flight, slot_of(requests, row as usize), visitor);
        }
        for row in requests.kernel.rows_hit() {
            pass_any(&mut flight.slots[slot_of(requests, row)], visitor);
        }
        if self.block.wants_normals {
            mesh.prefetch(requests.kernel.hits().iter().map(|hit| hit.crossing.primitive));
        }
        for hit in requests.kernel.hits() {
            let slot = slot_of(requests, hit.row as usize);
            self.pass(flight, slot, [Boundary::of_leaf(hit.crossing)].into_iter(), visitor);
        }
        go_on_without(&group, flight, requests);
    }

    fn cast_at_solid<V: BlockVisitor<'w>>(
        &mut self,
        mesh: &MeshSolid,
        group: Range<usize>,
        flight: &mut Flight<'w>,
        requests: &mut MeshRequests,
        visitor: &mut V,
    ) {
        if self.query.wanted == Wanted::All {
            self.cast_at_solid_for_all(mesh, group.clone(), flight, requests, visitor);
        } else {
            let MeshRequests { all, rows, boundaries, .. } = requests;
            let block = rows.block(group.clone(), self.query.scope.span, self.block.cancel);
            let wants_normals_later = self.block.wants_normals;
            let closed =
                ClosedMesh { mesh, block: &block, kinds: self.query.scope.kinds, wants_normals_later };
            let slot_of = |row: usize| all[group.start + row].slot as usize;
            if V::IS_ANY {
                boundaries.any(&closed, |row, is_boundary| match is_boundary {
                    true => pass_any(&mut flight.slots[slot_of(row)], visitor),
                    false => self.go_on_plainly(flight, slot_of(row), visitor),
                });
            } else {
                boundaries.closest(&closed, |row, first| match first {
                    First::Boundary(boundary, _) => {
                        self.pass(flight, slot_of(row), [boundary].into_iter(), visitor);
                    }
                    First::Plain => self.go_on_plainly(flight, slot_of(row), visitor),
                });
            }
        }
        go_on_without(&group, flight, requests);
    }

    fn cast_at_solid_for_all<V: BlockVisitor<'w>>(
        &mut self,
        mesh: &MeshSolid,
        group: Range<usize>,
        flight: &mut Flight<'w>,
        requests: &mut MeshRequests,
        visitor: &mut V,
    ) {
        let span = self.query.scope.span;
        requests.cast_all(mesh, group.clone(), span, BlockQuery::Within, self.block.cancel);
        for (row, request) in group.enumerate() {
            let slot = requests.all[request].slot as usize;
            let line = requests.rows.line(request);
            let boundaries = requests.lists.crossings(mesh, span, row, &line).and_then(|crossings| {
                let mut single = SingleLeaf::begin(crossings, span)?;
                Some(std::iter::from_fn(move || single.next(crossings)))
            });
            match boundaries {
                Some(boundaries) => self.pass(flight, slot, boundaries, visitor),
                None => self.go_on_plainly(flight, slot, visitor),
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
            let line = requests.rows.line(request);
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
        flight: &mut Flight<'w>,
        slot: usize,
        boundaries: impl Iterator<Item = Boundary>,
        visitor: &mut V,
    ) {
        let (slot, bundle, body_entry) = flight.parts(slot);
        if slot.state != State::Waiting {
            return;
        }
        slot.state = State::Ready;
        let passing = self.passing::<V>();
        for boundary in boundaries {
            let (placed, normal) = (body_entry.placed, Normal::Open(body_entry));
            let found = Found { paths: &bundle.paths, placed, boundary, normal };
            slot.pass(found, body_entry.enter, passing, visitor);
            let is_found = self.query.wanted == Wanted::First && passing.kinds.hold(boundary.kind);
            if is_found || slot.state == State::Ended {
                return;
            }
        }
    }

    /// Folds the body that a ray waits for by the plain path.
    fn go_on_plainly<V: BlockVisitor<'w>>(&mut self, flight: &mut Flight<'w>, slot: usize, visitor: &mut V) {
        let (slot, bundle, body_entry) = flight.parts(slot);
        if slot.state == State::Waiting {
            self.fold_body(slot, (&bundle.paths, bundle.steps), body_entry, visitor);
        }
    }
}

/// Lets the rays go on that miss the mesh they were cast at.
fn go_on_without(group: &Range<usize>, flight: &mut Flight, requests: &MeshRequests) {
    for request in &requests.all[group.clone()] {
        let slot = &mut flight.slots[request.slot as usize];
        if slot.state == State::Waiting {
            slot.state = State::Ready;
        }
    }
}

/// Passes a ray that has a boundary, which ends it. Does nothing if it has been passed.
fn pass_any<'w, V: BlockVisitor<'w>>(slot: &mut Slot, visitor: &mut V) {
    if slot.state == State::Waiting {
        visitor.any(slot.in_flight);
        slot.state = State::Ended;
    }
}
