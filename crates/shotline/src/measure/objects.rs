//! What the compiled world tells of each object: its box, and its moments where they have a closed form.
//!
//! Levels come after what they place. So one pass over them finds what each holds of each object, however often it is
//! placed: 10^12 spheres take no longer than the groups that hold them.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use super::apart::are_apart;
use super::{MeasureError, polytope};
use crate::aabb::Aabb;
use crate::compile::{Body, Placed, Target, World};
use crate::math::Affine;
use crate::solid::Moments;

/// More entries than this, an object in a placement each, take too much memory.
const MOST: usize = 10_000_000;

/// All there is of an object in some frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    pub bounds: Aabb,
    /// Its moments, where bodies and boxes allow.
    pub moments: Option<Moments>,
    /// A body of it that has no inside.
    pub open: Option<u32>,
}

impl Extent {
    /// Whether it has no end, or none that its box tells.
    pub fn is_unbounded(&self) -> bool {
        !self.bounds.is_empty() && !self.bounds.is_finite()
    }
}

/// What a level holds of each object; `None` stands for the object that is named above it.
type Holdings<T> = BTreeMap<Option<u32>, T>;

/// The extent of each wanted object in the world, in the order of their numbers; moments if closed forms are wanted.
///
/// # Errors
/// [`MeasureError::TooNested`].
pub(super) fn extents(
    world: &World,
    wanted: &[bool],
    closed_forms: bool,
) -> Result<Vec<(u32, Extent)>, MeasureError> {
    let mut survey = Survey { world, wanted, closed_forms, solids: HashMap::new(), levels: Vec::new() };
    let mut entries = 0;
    for level in world.levels() {
        let mut parts: Holdings<Vec<Extent>> = BTreeMap::new();
        for placed in &level.placements {
            for (object, extent) in survey.of(placed) {
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
    let of = |object: u32| found.and_then(|found| found.get(&Some(object))).copied();
    let objects = (0..).zip(wanted).filter(|(_, wanted)| **wanted).map(|(object, _)| object);
    Ok(objects.map(|object| (object, of(object).unwrap_or_else(|| together(&[])))).collect())
}

/// What is gathered on the way up.
struct Survey<'w> {
    world: &'w World,
    wanted: &'w [bool],
    closed_forms: bool,
    /// The moments of solids, each worked out once, by their addresses.
    solids: HashMap<*const (), Option<Moments>>,
    levels: Vec<Holdings<Extent>>,
}

impl Survey<'_> {
    /// What is placed, in the frame of the level.
    fn of(&mut self, placed: &Placed) -> Vec<(Option<u32>, Extent)> {
        let wanted = self.wanted;
        let is_wanted = |object: Option<u32>| object.is_none_or(|object| wanted[object as usize]);
        let parts: Vec<(Option<u32>, Extent)> = match placed.target {
            Target::Body(_) if !is_wanted(placed.object) => return Vec::new(),
            Target::Body(body) => vec![(placed.object, self.body(body))],
            Target::Level(level) => {
                let parts = self.levels[level as usize].iter();
                let named = parts.map(|(object, extent)| (object.or(placed.object), *extent));
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
            ..extent
        };
        parts.into_iter().map(|(object, extent)| (object, moved(extent))).collect()
    }

    fn body(&mut self, body: u32) -> Extent {
        match self.world.body(body) {
            Body::Surface(b) => Extent { bounds: b.bounds, moments: None, open: Some(body) },
            Body::Solid(b) => {
                let moments = match &b.leaves[..] {
                    _ if !self.closed_forms => None,
                    [leaf] => {
                        let key = Arc::as_ptr(&leaf.solid).cast();
                        let own = *self.solids.entry(key).or_insert_with(|| leaf.solid.moments());
                        own.and_then(|m| Some(m.placed(&leaf.local_from_body.inverse().ok()?)))
                    }
                    _ => polytope::moments(b),
                };
                Extent { bounds: b.bounds, moments, open: None }
            }
        }
    }
}

/// Parts of one object as one: with moments if all have them and their boxes are apart.
fn together(parts: &[Extent]) -> Extent {
    let moments: Option<Vec<Moments>> = parts.iter().map(|part| part.moments).collect();
    let apart = |_: &Vec<Moments>| are_apart(parts.iter().map(|part| part.bounds).collect());
    Extent {
        bounds: parts.iter().fold(Aabb::EMPTY, |all, part| all.union(&part.bounds)),
        moments: moments.filter(apart).map(|moments| Moments::total(&moments)),
        open: parts.iter().find_map(|part| part.open),
    }
}
