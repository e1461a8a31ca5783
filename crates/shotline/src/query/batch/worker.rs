//! The memory of one worker of a batch.

use crate::budget::Watch;
use crate::compile::World;
use crate::query::block_caster::{BlockCaster, BlockMemory, BlockPlan};
use crate::query::row_hit::RowHit;
use crate::query::{Caster, Hit, Segment};

/// The memory of one worker.
pub(super) struct Worker<'w> {
    pub caster: Caster<'w>,
    pub hits: Vec<Hit>,
    pub row_hits: Vec<RowHit>,
    pub segments: Vec<Segment>,
    pub objects: Vec<u32>,
    /// The rays of a block, and the memory of casting it.
    pub rays: Vec<[f64; 6]>,
    blocks: BlockMemory<'w>,
}

impl<'w> Worker<'w> {
    pub fn new(world: &'w World, watch: Watch<'w>) -> Worker<'w> {
        let mut caster = Caster::new(world);
        caster.watch(watch);
        Worker {
            caster,
            hits: vec![],
            row_hits: vec![],
            segments: vec![],
            objects: vec![],
            rays: vec![],
            blocks: BlockMemory::default(),
        }
    }

    /// What casts blocks, and its memory.
    pub fn blocks<'c>(
        &'c mut self,
        plan: &'c BlockPlan<'w>,
    ) -> (BlockCaster<'c, 'w>, &'c mut BlockMemory<'w>) {
        (BlockCaster { plan, caster: &mut self.caster }, &mut self.blocks)
    }
}

/// Clears a buffer that a worker reuses from row to row, and frees memory that only a rare row needs.
pub(super) fn empty<T>(kept: &mut Vec<T>) {
    kept.clear();
    kept.shrink_to(4096);
}
