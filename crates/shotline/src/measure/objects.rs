//! Computes the extent of each object in the compiled world: its box, and its moments if they have a closed form.
//!
//! A level comes after the levels that it places. So one pass over the levels finds what each holds of each object,
//! however many placements that has: 10^12 spheres take no longer than the groups that hold them.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use super::disjoint::are_disjoint;
use super::extent::Extent;
use super::known::KnownMoments;
use super::partly::Sampling;
use super::{MeasureError, polytope};
use crate::aabb::Aabb;
use crate::compile::{Body, LatticeCells, Level, Placement, Target, World};
use crate::math::{Affine, Lattice, Vec3};
use crate::solid::Solid;
use crate::solid::mesh::{Cancelled, Enclosed};

/// More entries than this, one per object in a placement, take too much memory.
const MAX_NODES: usize = 10_000_000;

/// What a level holds of each object; `None` stands for the object that a placement of the level names.
type Holdings<T> = BTreeMap<Option<u32>, T>;

/// Returns the extent of each wanted object in the world, by index. It has moments if closed forms are requested; they
/// are partly sampled where a mesh passes through itself.
///
/// # Errors
/// [`MeasureError::TooNested`], [`MeasureError::Cancelled`].
pub(super) fn extents(
    world: &World,
    wanted: &[bool],
    closed_forms: Option<Sampling>,
) -> Result<Vec<(u32, Extent)>, MeasureError> {
    let mut survey = ObjectSurvey { world, wanted, closed_forms, solids: HashMap::new(), levels: Vec::new() };
    let mut entries = 0;
    for level in world.levels() {
        let mut parts: Holdings<Vec<Extent>> = BTreeMap::new();
        let (numbers, repetition) = placements(level);
        for number in numbers {
            let bounds = world.placed_bounds(level, number);
            for (object, extent) in survey.of(&level.placement(number), bounds)? {
                parts.entry(object).or_default().push(repeated(extent, repetition));
                entries += 1;
                if entries > MAX_NODES {
                    return Err(MeasureError::TooNested { most: MAX_NODES });
                }
            }
        }
        survey.levels.push(parts.into_iter().map(|(object, parts)| (object, combined(&parts))).collect());
    }
    let found = survey.levels.last();
    let of = |object: u32| found.and_then(|found| found.get(&Some(object))).cloned();
    let objects = (0..).zip(wanted).filter(|(_, wanted)| **wanted).map(|(object, _)| object);
    Ok(objects.map(|object| (object, of(object).unwrap_or_else(|| combined(&[])))).collect())
}

/// How often a part is repeated along each axis, and at which distances.
type Repetition = [(u32, f64); 3];

/// The placements of a level. Where the cells of a lattice are all alike, they are its first cell, repeated.
fn placements(level: &Level) -> (Box<dyn Iterator<Item = u32> + '_>, Repetition) {
    match level.lattice.as_deref() {
        Some(LatticeCells { lattice: Lattice::Rectangular { counts, pitch, stagger: false }, .. })
            if level.has_equal_cells() =>
        {
            (Box::new(0..1), [0, 1, 2].map(|axis| (counts[axis], pitch[axis])))
        }
        _ => (Box::new(level.numbers()), [(1, 0.0); 3]),
    }
}

/// A part with all its repetitions. It has moments if it has them alone and neighbours are disjoint.
fn repeated(mut extent: Extent, repetition: Repetition) -> Extent {
    for (axis, (count, pitch)) in repetition.into_iter().enumerate().filter(|(_, (count, _))| *count > 1) {
        let shift = |steps: u32| {
            let mut shift = Vec3::ZERO;
            shift[axis] = f64::from(steps) * pitch;
            shift
        };
        let bounds = |steps| Aabb::new(extent.bounds.min + shift(steps), extent.bounds.max + shift(steps));
        // The last two are the farthest away, so rounding is largest.
        let apart = are_disjoint(vec![bounds(count - 2), bounds(count - 1)]);
        let moved = |m: &KnownMoments, steps| m.placed(&Affine::translation(shift(steps)));
        let moments = extent.moments.take().filter(|_| apart).map(|one| {
            // By the binary digits of the number, the highest first.
            let (mut sum, mut done) = (one.clone(), 1);
            for digit in (0..count.ilog2()).rev() {
                sum = KnownMoments::total(&[moved(&sum, done), sum]);
                done *= 2;
                if count >> digit & 1 == 1 {
                    sum = KnownMoments::total(&[moved(&one, done), sum]);
                    done += 1;
                }
            }
            sum
        });
        let bounds = extent.bounds.union(&bounds(count - 1));
        extent = Extent { bounds, moments, open: extent.open };
    }
    extent
}

/// The state of the pass over the levels.
struct ObjectSurvey<'w> {
    world: &'w World,
    wanted: &'w [bool],
    closed_forms: Option<Sampling<'w>>,
    /// The moments of solids, each computed once, by address.
    solids: HashMap<*const (), Option<KnownMoments>>,
    levels: Vec<Holdings<Extent>>,
}

impl ObjectSurvey<'_> {
    /// Returns the extents of the objects in a placement, in the frame of its level, where its box is given.
    fn of(&mut self, placed: &Placement, bounds: Aabb) -> Result<Vec<(Option<u32>, Extent)>, MeasureError> {
        let wanted = self.wanted;
        let is_wanted = |object: Option<u32>| object.is_none_or(|object| wanted[object as usize]);
        let parts: Vec<(Option<u32>, Extent)> = match placed.target {
            Target::Body(_) if !is_wanted(placed.object) => return Ok(Vec::new()),
            Target::Body(body) => vec![(placed.object, self.body(body)?)],
            Target::Level(level) => {
                let parts = self.levels[level as usize].iter();
                let named = parts.map(|(object, extent)| (object.or(placed.object), extent.clone()));
                named.filter(|(object, _)| is_wanted(*object)).collect()
            }
        };
        // The map was inverted once, so it can be inverted again, but for rounding.
        let baked = placed.local_from_parent.is_identity();
        let map = if baked { Some(Affine::IDENTITY) } else { placed.local_from_parent.inverse().ok() };
        let moved = |extent: Extent| Extent {
            bounds: map.map_or(bounds, |map| extent.bounds.transformed(&map).intersection(&bounds)),
            moments: extent.moments.and_then(|moments| Some(moments.placed(&map?))),
            open: extent.open,
        };
        Ok(parts.into_iter().map(|(object, extent)| (object, moved(extent))).collect())
    }

    fn body(&mut self, body: u32) -> Result<Extent, MeasureError> {
        Ok(match self.world.body(body) {
            Body::Surface(b) => Extent { bounds: b.bounds, moments: None, open: Some(body) },
            Body::Solid(b) => {
                let moments = match &b.leaves[..] {
                    _ if self.closed_forms.is_none() => None,
                    [leaf] => {
                        let own = self.solid(&leaf.solid)?;
                        own.and_then(|m| Some(m.placed(&leaf.local_from_body.inverse().ok()?)))
                    }
                    _ => polytope::moments(b).map(KnownMoments::Exactly),
                };
                Extent { bounds: b.bounds, moments, open: None }
            }
        })
    }

    /// The moments of a solid in its own frame.
    fn solid(&mut self, solid: &Arc<dyn Solid>) -> Result<Option<KnownMoments>, MeasureError> {
        let Some(sampling) = self.closed_forms else { return Ok(None) };
        let key = Arc::as_ptr(solid).cast();
        if let Some(known) = self.solids.get(&key) {
            return Ok(known.clone());
        }
        let enclosed = solid.as_mesh().map(|mesh| mesh.enclosed(sampling.run.cancel)).transpose();
        let known = match enclosed.map_err(|Cancelled| MeasureError::Cancelled)? {
            None => solid.moments().map(KnownMoments::Exactly),
            Some(None) => None,
            Some(Some(Enclosed::Exactly(moments))) => Some(KnownMoments::Exactly(moments)),
            Some(Some(Enclosed::Partly(doubt))) => {
                Some(sampling.of(&doubt, u32::try_from(self.solids.len()).unwrap_or(u32::MAX))?)
            }
        };
        self.solids.insert(key, known.clone());
        Ok(known)
    }
}

/// Combines parts of one object. The result has moments if all parts have them and their boxes are disjoint.
fn combined(parts: &[Extent]) -> Extent {
    let moments: Option<Vec<KnownMoments>> = parts.iter().map(|part| part.moments.clone()).collect();
    let apart = |_: &Vec<KnownMoments>| are_disjoint(parts.iter().map(|part| part.bounds).collect());
    Extent {
        bounds: parts.iter().fold(Aabb::EMPTY, |all, part| all.union(&part.bounds)),
        moments: moments.filter(apart).map(|moments| KnownMoments::total(&moments)),
        open: parts.iter().find_map(|part| part.open),
    }
}
