//! What a kind of solid is built of: one solid, or a combination of several in one frame.
//!
//! A kind whose surface is not one of the others' is a combination: the crossings, normals and contacts of its parts are those
//! of their own kinds, and the sweep combines them.

use std::sync::Arc;

use super::Solid;
use crate::aabb::Aabb;
use crate::math::Vec3;

/// One solid, or a combination.
#[derive(Clone, Debug)]
pub enum Parts {
    /// A solid, with the names of its surfaces as the kind calls them.
    Solid(Arc<dyn Solid>, &'static [&'static str]),
    /// The points in any of them.
    Union(Vec<Parts>),
    /// The points in all of them.
    Intersection(Vec<Parts>),
    /// The points in the first and in no other.
    Difference(Vec<Parts>),
}

impl Parts {
    /// A solid whose surfaces keep their names.
    pub fn of(solid: impl Solid + 'static) -> Parts {
        let surfaces = solid.surfaces();
        Parts::named(solid, surfaces)
    }

    /// A solid with names for its surfaces.
    pub fn named(solid: impl Solid + 'static, surfaces: &'static [&'static str]) -> Parts {
        Parts::Solid(Arc::new(solid), surfaces)
    }

    /// The points of these parts that are in all the others.
    #[must_use]
    pub fn within(self, others: impl IntoIterator<Item = Parts>) -> Parts {
        let mut all = vec![self];
        all.extend(others);
        if all.len() == 1 { all.remove(0) } else { Parts::Intersection(all) }
    }

    /// The points of these parts that are in none of the others.
    #[must_use]
    pub fn without(self, others: impl IntoIterator<Item = Parts>) -> Parts {
        let mut all = vec![self];
        all.extend(others);
        if all.len() == 1 { all.remove(0) } else { Parts::Difference(all) }
    }

    /// The only solid; `None` for a combination.
    pub fn single(&self) -> Option<&Arc<dyn Solid>> {
        match self {
            Parts::Solid(solid, _) => Some(solid),
            Parts::Union(_) | Parts::Intersection(_) | Parts::Difference(_) => None,
        }
    }

    /// The number of solids.
    pub fn count(&self) -> usize {
        match self {
            Parts::Solid(..) => 1,
            Parts::Union(parts) | Parts::Intersection(parts) | Parts::Difference(parts) => {
                parts.iter().map(Parts::count).sum()
            }
        }
    }

    /// A box that contains the interior.
    pub fn bounds(&self) -> Aabb {
        match self {
            Parts::Solid(solid, _) => solid.bounds(),
            Parts::Union(parts) => parts.iter().fold(Aabb::EMPTY, |all, part| all.union(&part.bounds())),
            Parts::Intersection(parts) => {
                parts.iter().fold(Aabb::EVERYTHING, |all, part| all.intersection(&part.bounds()))
            }
            Parts::Difference(parts) => parts[0].bounds(),
        }
    }

    /// Whether a point lies in the interior. The result is not reliable within rounding of the surface.
    pub fn contains(&self, p: Vec3) -> bool {
        match self {
            Parts::Solid(solid, _) => solid.contains(p),
            Parts::Union(parts) => parts.iter().any(|part| part.contains(p)),
            Parts::Intersection(parts) => parts.iter().all(|part| part.contains(p)),
            Parts::Difference(parts) => {
                parts[0].contains(p) && !parts[1..].iter().any(|part| part.contains(p))
            }
        }
    }
}
