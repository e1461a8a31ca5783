//! Where the parts of objects are.

use super::World;
use super::world::Target;
use crate::aabb::Aabb;
use crate::math::Affine;

/// A named group of more bodies than this is one part.
const FEW: u64 = 256;

impl World {
    /// The number of an object and a box around a part of it, in world coordinates, for all parts of all objects: the
    /// bodies, and in place of a large group its own box. `None` if there are more than `most`.
    pub fn parts_of_objects(&self, most: usize) -> Option<Vec<(u32, Aabb)>> {
        let mut parts = Vec::new();
        let mut waiting = vec![(self.root, Affine::IDENTITY, None)];
        while let Some((level, world_from_level, named)) = waiting.pop() {
            for placed in &self.level(level).placements {
                let object: Option<u32> = placed.object.or(named);
                let inverse = placed.local_from_parent.inverse();
                match (placed.target, object, inverse) {
                    (Target::Level(inner), _, Ok(map))
                        if object.is_none() || self.level(inner).path_count <= FEW =>
                    {
                        waiting.push((inner, world_from_level.then_after(&map), object));
                    }
                    (_, Some(object), _) => {
                        parts.push((object, placed.bounds.transformed(&world_from_level)))
                    }
                    _ => {}
                }
                if parts.len() + waiting.len() > most {
                    return None;
                }
            }
        }
        Some(parts)
    }
}
