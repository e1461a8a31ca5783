//! Volume, mass, centroid and inertia of objects: exact where there is a closed form, else by rays with an
//! estimate of the error.
//!
//! **Exact** are objects made of boxes, spheres, ellipsoids, cylinders, cones, paraboloids, hyperboloids, tori
//! that are no spindles, polytopes (intersections of half-spaces and boxes), and closed meshes of which the winding number is nowhere other than 0 and 1 (or -1): one of
//! them, or any number whose boxes do not overlap, under whatever transforms and however often shared parts are placed.
//! Exact means but for rounding; the error is reported as 0.
//!
//! **In part** closed meshes that pass through themselves, or have shells in one another, are exact. The sum over their
//! faces counts a place as often as they wind around it, and inside is where that is not 0. Only the cells in which the
//! two may differ are sampled, and the difference is added: the error is of the size of what is in doubt. `check` names
//! that sum the signed volume.
//!
//! **By rays** all others are measured: parallel to the three axes in turn through the object's box. Along a ray the
//! stretches inside are integrated in closed form, so only the two directions across are sampled, by stratified sampling
//! with importance: edges of the boxes of the object's leaves (solids, and shells of meshes) split the square across the
//! axis into the cells of a kd-tree, so that narrow gaps and thin parts get rays of their own. In each cell the points are
//! those of the additive sequence of the plastic number (M. Roberts 2018), a low-discrepancy sequence, which is shifted at
//! random (R. Cranley and T. N. L. Patterson 1976), sixteen times over. The seed and the number of rays decide every bit;
//! the accelerator and the number of threads none.
//!
//! **The error** is the spread of the sixteen shifts, by the jackknife (B. Efron 1982) for centroid and inertia. Where the
//! estimates by the rays of each axis alone spread more than twice as much, that is the error: rays along one of them may
//! not see a thin part. A leaf of known volume that fewer than 16 rays are expected to meet adds that volume over the root of
//! their number. The error also has room for one of the rays that count most, for rounding, and, where fewer than
//! 256 stretches are met, for what one ray stands for, anywhere in the box; so it is not 0 for an object that no ray meets,
//! which has no centroid. It is a standard error of fifteen degrees of freedom, not a bound: about one in a hundred is off
//! by more than three of them.
//!
//! **Not promised:** that a part too small for the rays is seen, where it has no box of its own. What no ray meets is
//! neither in the shifts nor in the axes. Of more than a thousand leaves some or groups only count, and boxes of what is
//! turned are larger than it is: for a thin shell that no axis follows about three in a hundred volumes are off by more than
//! three errors, as few rays graze it and these count most.

mod cells;
mod disjoint;
mod estimate;
mod extent;
mod known;
mod leaves;
mod objects;
mod partly;
#[cfg(test)]
mod partly_tests;
mod polytope;
mod rays;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod thin_tests;

pub use estimate::Estimate;

use crate::aabb::Aabb;
use crate::compile::World;
use crate::query::batch::Run;
use crate::query::{Overlaps, QueryError};
use crate::scene::Scene;
use leaves::leaf_boxes;
use rays::Rays;

/// How to measure.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Rays for each object that has no closed form, rounded up to a multiple of 48: three axes, sixteen shifts.
    pub rays: usize,
    /// Chooses the shifts.
    pub seed: u64,
    /// Whether closed forms are used.
    pub method: Method,
    /// What counts where objects overlap. [`Overlaps::All`]: each object's own volume, whatever else is there; this
    /// alone has closed forms. The others give what [segments](crate::query::Caster::segments) give the object.
    pub overlaps: Overlaps,
    /// The objects to be measured, by number; all if `None`.
    pub objects: Option<Vec<u32>>,
}

impl Default for Settings {
    fn default() -> Settings {
        Settings { rays: 1 << 16, seed: 0, method: Method::Best, overlaps: Overlaps::All, objects: None }
    }
}

/// Whether closed forms are used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// Closed forms where there are any, else rays.
    #[default]
    Best,
    /// Rays only.
    Rays,
}

/// What is known of an object. Lengths are those of the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measure {
    /// The object: an index into [`object_names`](World::object_names).
    pub object: u32,
    /// The volume, all placements together; bodies of one object that overlap count once. NaN, as all the rest, for an
    /// object that [has no end](Measure::is_unbounded).
    pub volume: Estimate,
    /// The mass, if the material has a density: in grams, by densities in g/cm^3; in a scene without units, the volume
    /// times the density, whatever these stand for.
    pub mass: Option<Estimate>,
    /// The centroid, in world coordinates; NaN where no volume was found.
    pub centroid: [Estimate; 3],
    /// The inertia tensor about the centroid along the axes of the world, of density 1: times the density it is
    /// that of the mass. NaN where no volume was found.
    pub inertia: [[Estimate; 3]; 3],
    /// Whether it is exact but for rounding.
    pub exact: bool,
    /// A box around the object.
    pub bounds: Aabb,
    /// The rays cast for it.
    pub rays: usize,
}

impl Measure {
    /// Whether the object has no end, or none that its box tells: then nothing but the box is known of it.
    pub fn is_unbounded(&self) -> bool {
        !self.bounds.is_empty() && !self.bounds.is_finite()
    }
}

/// The box of every object, in the order of their numbers: infinite where it has no end, empty where it is nowhere.
///
/// # Errors
/// [`MeasureError::TooNested`].
pub fn object_bounds(world: &World) -> Result<Vec<Aabb>, MeasureError> {
    let wanted = vec![true; world.object_names().len()];
    let extents = objects::extents(world, &wanted, None)?;
    Ok(extents.into_iter().map(|(_, extent)| extent.bounds).collect())
}

/// What keeps a volume from being a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Range {
    /// Above about 1.8e308.
    TooLarge,
    /// Below about 2.2e-308.
    TooSmall,
}

impl Range {
    /// Why the volume of something in a box is not a number that f64 holds; `None` if it is, or if the box is empty or has
    /// no end.
    pub fn of_volume(volume: f64, bounds: &Aabb) -> Option<Range> {
        if bounds.is_empty() || !bounds.is_finite() {
            return None;
        }
        if !volume.is_finite() {
            return Some(Range::TooLarge);
        }
        // Not by a side that is nothing but the padding of a box.
        let vanishes = bounds.volume_vanishes() && volume < f64::MIN_POSITIVE;
        vanishes.then_some(Range::TooSmall)
    }
}

impl std::fmt::Display for Range {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str(match self {
            Range::TooLarge => "large",
            Range::TooSmall => "small",
        })
    }
}

/// Why objects could not be measured.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeasureError {
    /// It was cancelled.
    #[error("cancelled")]
    Cancelled,
    /// There is no such object.
    #[error("there is no object {object}; there are {count}, numbered from 0")]
    NoObject {
        /// Its number.
        object: u32,
        /// How many there are.
        count: usize,
    },
    /// A mesh that is not closed, or objects that overlap where that is an error.
    #[error(transparent)]
    Query(QueryError),
    /// The rays of an object have met too much, or the first few show that they would.
    #[error("object '{object}': its rays meet too many parts{}", affordable(*rays))]
    TooMany {
        /// The object.
        object: String,
        /// About how many rays would be few enough; 0 if that is not known, or less than the fewest.
        rays: usize,
    },
    /// The volume of an object overflows or underflows.
    #[error(
        "object '{object}': its volume is too {range} for a 64-bit number; give the model in other units of length"
    )]
    OutOfRange {
        /// The object.
        object: String,
        /// Whether it is too large or too small.
        range: Range,
    },
    /// Objects in shared groups in shared groups, so that telling them apart takes too much memory.
    #[error("the shared groups hold more than {most} objects, every group counted")]
    TooNested {
        /// How many there may be.
        most: usize,
    },
}

/// How many rays would be few enough, in words.
fn affordable(rays: usize) -> String {
    if rays == 0 { String::new() } else { format!("; about {rays} rays would be few enough") }
}

/// Measures objects, in the order of their numbers. `scene` is what the world was compiled from; its materials tell
/// the densities.
///
/// Of `run`, `most_rows`, or a thousand a ray if that is more, limits the boxes and bodies that the rays of an object
/// open, and the [`Limits`](crate::query::Limits) of a query each ray: so parts placed 10^12 times over each other end with an error,
/// at once if the first few rays show it. `progress` counts
/// [`Settings::rays`] also for an object that needs no rays.
///
/// # Errors
/// [`MeasureError`], for the first object that has one.
pub fn measure(
    world: &World,
    scene: &Scene,
    settings: &Settings,
    run: Run,
) -> Result<Vec<Measure>, MeasureError> {
    let work = || measure_here(world, scene, settings, run);
    if let Some(pool) = run.pool {
        return pool.install(work);
    }
    // A pool of its own for one thread too: the global one is neither of one thread nor there after a fork.
    match rayon::ThreadPoolBuilder::new().num_threads(run.pool_threads()).build() {
        Ok(pool) => pool.install(work),
        Err(_) => work(),
    }
}

fn measure_here(
    world: &World,
    scene: &Scene,
    settings: &Settings,
    run: Run,
) -> Result<Vec<Measure>, MeasureError> {
    let count = world.object_names().len();
    let mut wanted = vec![settings.objects.is_none(); count];
    for &object in settings.objects.iter().flatten() {
        *wanted.get_mut(object as usize).ok_or(MeasureError::NoObject { object, count })? = true;
    }
    let closed_forms = settings.method == Method::Best && settings.overlaps == Overlaps::All;
    let sampling = closed_forms.then_some(partly::Sampling { settings, run });
    let extents = objects::extents(world, &wanted, sampling)?;
    // Boxes of leaves only for what needs them: objects without closed forms, and what else may own a part of them.
    let mut by_rays = vec![false; count];
    for (object, extent) in &extents {
        by_rays[*object as usize] = extent.moments.is_none();
    }
    if settings.overlaps != Overlaps::All && by_rays.contains(&true) {
        by_rays.fill(true);
    }
    let leaves = if by_rays.contains(&true) { leaf_boxes(world, &by_rays) } else { Vec::new() };
    let rays = Rays { world, settings, run, leaves };
    // Before any work.
    extents.iter().try_for_each(|(object, extent)| rays.check(*object, extent))?;
    extents.iter().map(|(object, extent)| rays.measure(scene, *object, extent)).collect()
}
