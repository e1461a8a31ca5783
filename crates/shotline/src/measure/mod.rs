//! Volume, mass, centroid and inertia of objects: exact if there is a closed form, else estimated by rays, with an
//! error.
//!
//! **Exact** are objects made of boxes, spheres, ellipsoids, cylinders, cones, paraboloids, hyperboloids, tori other
//! than spindle tori, polytopes (intersections of half-spaces and boxes), and closed meshes whose winding number is
//! nowhere other than 0 and 1 (or -1). An object may consist of one of them or of any number whose boxes do not
//! overlap, under any transforms and with any number of placements of shared parts. Exact means up to rounding; the
//! error is reported as 0.
//!
//! **Partly exact** are closed meshes that pass through themselves or have nested shells. The sum over their faces
//! counts a region as often as they wind around it, while inside is where the winding number is not 0. Only the cells
//! in which the two may differ are sampled, and the difference is added: the error is proportional to the uncertain
//! volume, not to the object. `check` calls that sum the signed volume.
//!
//! **By rays** all others are measured. The rays are parallel to the three axes in turn and pass through the object's
//! box. Along a ray the intervals inside are integrated in closed form, so only the two directions across are sampled,
//! by stratified sampling with importance. Edges of the boxes of the object's leaves (solids, and shells of meshes)
//! split the square across the axis into the cells of a k-d tree, so narrow gaps and thin parts get rays of their own.
//! In each cell the points are those of the additive sequence of the plastic number (M. Roberts 2018), a
//! low-discrepancy sequence, with sixteen random shifts (R. Cranley and T. N. L. Patterson 1976). The seed and the
//! number of rays determine every bit of the result; it does not depend on the accelerator or the number of threads.
//!
//! **The error** is the spread of the sixteen shifts, by the jackknife (B. Efron 1982) for centroid and inertia. If the
//! estimates by the rays of each axis alone spread more than twice as much, their spread is the error: rays along one
//! axis may miss a thin part. A leaf of known volume that fewer than 16 rays are expected to meet adds that volume over
//! the root of their number. The error also includes the effect of one of the rays that contribute most, of rounding,
//! and, if fewer than 256 intervals are met, of the volume that one ray represents, anywhere in the box. So it is not 0
//! for an object that no ray meets; such an object has no centroid. It is a standard error of fifteen degrees of
//! freedom, not a bound: about one value in a hundred is off by more than three of them.
//!
//! **Not promised:** that a part too small for the rays is found if it has no box of its own. What no ray meets shows
//! neither in the shifts nor in the axes. Of more than a thousand leaves only some, or groups, are used, and the boxes
//! of rotated leaves are larger than the leaves. For a thin shell that no axis follows, about three in a hundred
//! volumes are off by more than three errors, because few rays graze it and these contribute most.

mod cells;
mod disjoint;
mod estimate;
mod extent;
mod known;
#[cfg(test)]
mod lattice_tests;
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
use crate::pool;
use crate::query::batch::Run;
use crate::query::{Overlaps, QueryError};
use crate::scene::Scene;
use leaves::leaf_boxes;
use rays::Rays;

/// The settings of a measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Rays for each object without a closed form, rounded up to a multiple of 48: three axes times sixteen shifts.
    pub rays: usize,
    /// The seed of the random shifts.
    pub seed: u64,
    /// Whether closed forms are used.
    pub method: Method,
    /// How overlapping objects count. [`Overlaps::All`]: each object's own volume, independent of other objects; only
    /// this has closed forms. The others count what [segments](crate::query::Caster::segments) assign to the object.
    pub overlaps: Overlaps,
    /// The objects to be measured, by index; all if `None`.
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
    /// Closed forms if there are any, else rays.
    #[default]
    Best,
    /// Rays only.
    Rays,
}

/// The measurement of an object. Lengths are in the unit of the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measure {
    /// The object: an index into [`object_names`](World::object_names).
    pub object: u32,
    /// The volume of all placements together; bodies of one object that overlap count once. NaN, like all other values,
    /// for an object that [is unbounded](Measure::is_unbounded).
    pub volume: Estimate,
    /// The mass, if the material has a density: in grams, for densities in g/cm^3. In a scene without units it is the
    /// volume times the density, in whatever units these have.
    pub mass: Option<Estimate>,
    /// The centroid, in world coordinates; NaN if no volume was found.
    pub centroid: [Estimate; 3],
    /// The inertia tensor about the centroid along the axes of the world, for density 1; multiply it by the density for
    /// that of the mass. NaN if no volume was found.
    pub inertia: [[Estimate; 3]; 3],
    /// Whether the values are exact up to rounding.
    pub exact: bool,
    /// A box around the object.
    pub bounds: Aabb,
    /// The number of rays cast for it.
    pub rays: usize,
}

impl Measure {
    /// Whether the object is unbounded, or its box does not show that it is bounded. Then only the box is valid.
    pub fn is_unbounded(&self) -> bool {
        !self.bounds.is_empty() && !self.bounds.is_finite()
    }
}

/// Returns the box of every object, by index: infinite if the object is unbounded, empty if it has no points.
///
/// # Errors
/// [`MeasureError::TooNested`].
pub fn object_bounds(world: &World) -> Result<Vec<Aabb>, MeasureError> {
    let wanted = vec![true; world.object_names().len()];
    let extents = objects::extents(world, &wanted, None)?;
    Ok(extents.into_iter().map(|(_, extent)| extent.bounds).collect())
}

/// Why a volume is not representable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Range {
    /// Above about 1.8e308.
    TooLarge,
    /// Below about 2.2e-308.
    TooSmall,
}

impl Range {
    /// Returns why the volume of something in a box is not representable in f64; `None` if it is, or if the box is
    /// empty or unbounded.
    pub fn of_volume(volume: f64, bounds: &Aabb) -> Option<Range> {
        if bounds.is_empty() || !bounds.is_finite() {
            return None;
        }
        if !volume.is_finite() {
            return Some(Range::TooLarge);
        }
        // A side that is only the padding of a box does not count.
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
    /// The measurement was cancelled.
    #[error("cancelled")]
    Cancelled,
    /// There is no such object.
    #[error("there is no object {object}; there are {count}, numbered from 0")]
    NoObject {
        /// The requested index.
        object: u32,
        /// How many there are.
        count: usize,
    },
    /// A mesh is not closed, or objects overlap where that is an error.
    #[error(transparent)]
    Query(QueryError),
    /// The rays of an object meet too much, or the first few show that they would.
    #[error("object '{object}': its rays meet too many parts{}", affordable(*rays))]
    TooMany {
        /// The object.
        object: String,
        /// About how many rays would be few enough; 0 if that is unknown or less than the minimum.
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
    /// Shared groups are nested so deeply that listing the objects of each takes too much memory.
    #[error("the shared groups hold more than {most} objects, every group counted")]
    TooNested {
        /// The largest possible number.
        most: usize,
    },
}

/// Describes how many rays would be few enough.
fn affordable(rays: usize) -> String {
    if rays == 0 { String::new() } else { format!("; about {rays} rays would be few enough") }
}

/// Measures objects, ordered by index. `world` must be compiled from `scene`, whose materials provide the densities.
///
/// In `run`, `most_rows` limits the boxes and bodies that the rays of an object visit, but not below a thousand per
/// ray. The [`Limits`](crate::query::Limits) of a query limit each ray. So parts placed 10^12 times over each other end
/// with an error, at once if the first few rays show it. `progress` is also called with [`Settings::rays`] for an
/// object that needs no rays.
///
/// # Errors
/// [`MeasureError`] of the first object that has one.
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
    pool::on_threads(run.threads, |_| work())
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
    // Boxes of leaves are needed only for objects without closed forms, and for others that may own a part of them.
    let mut by_rays = vec![false; count];
    for (object, extent) in &extents {
        by_rays[*object as usize] = extent.moments.is_none();
    }
    if settings.overlaps != Overlaps::All && by_rays.contains(&true) {
        by_rays.fill(true);
    }
    let leaves = if by_rays.contains(&true) { leaf_boxes(world, &by_rays) } else { Vec::new() };
    let rays = Rays { world, settings, run, leaves };
    // Check all objects before any work.
    extents.iter().try_for_each(|(object, extent)| rays.check(*object, extent))?;
    extents.iter().map(|(object, extent)| rays.measure(scene, *object, extent)).collect()
}
