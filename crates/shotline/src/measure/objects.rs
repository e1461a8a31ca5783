//! What the compiled world tells of each object: its box, and its moments where they have a closed form.
//!
//! Levels come after what they place. So one pass over them finds what each holds of each object, however often it is
//! placed: 10^12 spheres take no longer than the groups that hold them.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use super::disjoint::are_disjoint;
use super::extent::Extent;
use super::known::KnownMoments;
use super::partly::Sampling;
use super::{MeasureError, polytope};
use crate::aabb::Aabb;
use crate::compile::{Body, Placement, Target, World};
use crate::math::Affine;
use crate::solid::Solid;
use crate::solid::mesh::{Cancelled, Enclosed};

/// More entries than this, an object in a placement each, take too much memory.
const MOST: usize = 10_000_000;

/// What a level holds of each object; `None` stands for the object that is named above it.
type Holdings<T> = BTreeMap<Option<u32>, T>;

/// The extent of each wanted object in the world, in the order of their numbers; moments if closed forms are wanted, in
/// part sampled where a mesh passes through itself.
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
        for placed in &level.placements {
            for (object, extent) in survey.of(placed)? {
                parts.entry(object).or_default().push(extent);
                entries += 1;
                if entries > MOST {
                    return Err(MeasureError::TooNested { most: MOST });
                }
            }
        }
        survey.levels.push(parts.into_iter().map(|(object, parts)| (object, together(&parts))).collect());
    }
    let found = survey.levels.last();
    let of = |object: u32| found.and_then(|found| found.get(&Some(object))).cloned();
    let objects = (0..).zip(wanted).filter(|(_, wanted)| **wanted).map(|(object, _)| object);
    Ok(objects.map(|object| (object, of(object).unwrap_or_else(|| together(&[])))).collect())
}

/// What is gathered on the way up.
struct ObjectSurvey<'w> {
    world: &'w World,
    wanted: &'w [bool],
    closed_forms: Option<Sampling<'w>>,
    /// The moments of solids, each worked out once, by their addresses.
    solids: HashMap<*const (), Option<KnownMoments>>,
    levels: Vec<Holdings<Extent>>,
}

impl ObjectSurvey<'_> {
    /// What is placed, in the frame of the level.
    fn of(&mut self, placed: &Placement) -> Result<Vec<(Option<u32>, Extent)>, MeasureError> {
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
        // It was inverted once, so it can be again, but for rounding.
        let baked = placed.local_from_parent.is_identity();
        let map = if baked { Some(Affine::IDENTITY) } else { placed.local_from_parent.inverse().ok() };
        let moved = |extent: Extent| Extent {
            bounds: map
                .map_or(placed.bounds, |map| extent.bounds.transformed(&map).intersection(&placed.bounds)),
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

/// Parts of one object as one: with moments if all have them and their boxes are apart.
fn together(parts: &[Extent]) -> Extent {
    let moments: Option<Vec<KnownMoments>> = parts.iter().map(|part| part.moments.clone()).collect();
    let apart = |_: &Vec<KnownMoments>| are_disjoint(parts.iter().map(|part| part.bounds).collect());
    Extent {
        bounds: parts.iter().fold(Aabb::EMPTY, |all, part| all.union(&part.bounds)),
        moments: moments.filter(apart).map(|moments| KnownMoments::total(&moments)),
        open: parts.iter().find_map(|part| part.open),
    }
}
