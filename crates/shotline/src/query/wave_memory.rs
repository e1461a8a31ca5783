//! The memory of waves.

use super::lane_cast::LaneFinds;
use super::wave::{Pair, WaveRay};
use super::wave_bodies::BodyWave;

/// The memory of waves; reused from block to block.
#[derive(Debug, Default)]
pub(super) struct WaveMemory<'w> {
    /// The rows of the rays that are cast in waves.
    pub rows: Vec<u32>,
    pub rays: Vec<WaveRay<'w>>,
    pub pairs: Vec<Pair<'w>>,
    pub finds: LaneFinds,
    pub bodies: BodyWave,
}
