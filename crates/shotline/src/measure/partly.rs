//! Meshes that pass through themselves: uncertain regions are sampled, the rest is exact.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use rayon::prelude::*;

use super::known::{KnownMoments, Sampled};
use super::rays::{MIN_INTERVALS, STRATA, sample_point};
use super::{MeasureError, Settings};
use crate::math::{Dd, split_mix64};
use crate::query::batch::Run;
use crate::scratch::Scratch;
use crate::solid::mesh::Doubt;

/// Rays between checks of the cancel flag.
const CHUNK: usize = 1024;

/// How uncertain regions are sampled.
#[derive(Clone, Copy)]
pub(super) struct Sampling<'a> {
    pub(super) settings: &'a Settings,
    pub(super) run: Run<'a>,
}

impl Sampling<'_> {
    /// Returns the moments of the inside of a mesh. `number` identifies the mesh and selects its random shifts.
    ///
    /// # Errors
    /// [`MeasureError::Cancelled`].
    pub(super) fn of(&self, doubt: &Doubt, number: u32) -> Result<KnownMoments, MeasureError> {
        let rays = self.settings.rays.div_ceil(STRATA).max(1);
        let one = |stratum: usize| self.stratum(doubt, number, stratum, rays);
        let strata: Vec<([Dd; 10], u64)> = (0..STRATA).into_par_iter().map(one).collect::<Result<_, _>>()?;
        let met: u64 = strata.iter().map(|(_, met)| met).sum();
        let mean = |of: &dyn Fn(usize) -> bool| {
            let own = (0..STRATA).filter(|stratum| of(*stratum));
            let (sums, count) = own.fold(([Dd::ZERO; 10], 0), |(sums, count), stratum| {
                (std::array::from_fn(|i| sums[i] + strata[stratum].0[i]), count + 1)
            });
            doubt.moments(&sums.map(|sum| sum.hi / (count * rays) as f64))
        };
        let moments = std::array::from_fn(|shift| mean(&|stratum| stratum / 3 == shift));
        let axes = std::array::from_fn(|axis| mean(&|stratum| stratum % 3 == axis));
        let unseen = if met < MIN_INTERVALS { doubt.volume() / (STRATA * rays) as f64 } else { 0.0 };
        Ok(KnownMoments::Sampled(Arc::new(Sampled { moments, axes, unseen, solids: vec![number] })))
    }

    /// Returns the sums over the rays of an axis and a shift, and how many of the rays contribute.
    fn stratum(
        &self,
        doubt: &Doubt,
        number: u32,
        stratum: usize,
        rays: usize,
    ) -> Result<([Dd; 10], u64), MeasureError> {
        let key = split_mix64(split_mix64(self.settings.seed) ^ split_mix64(u64::from(number) | 1 << 40))
            ^ stratum as u64;
        let shift = [split_mix64(key), split_mix64(key ^ (1 << 63))];
        let (mut sums, mut met, mut scratch) = ([Dd::ZERO; 10], 0, Scratch::default());
        for i in 0..rays {
            if i % CHUNK == 0 && self.run.cancel.is_some_and(|c| c.load(Ordering::Relaxed)) {
                return Err(MeasureError::Cancelled);
            }
            // Map the square from -1 to 1 to the unit square.
            let sample_point = sample_point(i, shift).map(|x| 0.5 * x + 0.5);
            let terms = doubt.sample(stratum % 3, sample_point, &mut scratch);
            met += u64::from(terms[0] != 0.0);
            sums = std::array::from_fn(|k| sums[k] + Dd::from(terms[k]));
        }
        if let Some(progress) = self.run.progress {
            progress(rays as u64);
        }
        Ok((sums, met))
    }
}
