//! The boxes and moments of the leaves of each object in world coordinates: they show where its thin parts are.

use std::collections::BTreeMap;

use crate::aabb::Aabb;
use crate::compile::{Body, Leaf, Placement, SolidBody, Target, World};
use crate::math::Affine;
use crate::solid::Moments;

/// The number of boxes of one object is at most this.
const MAX_LEAVES: usize = 1024;

/// The number of boxes kept over all levels; beyond it, a level keeps one box per object.
const BUDGET: usize = 1 << 20;

/// The box of a leaf, or of several together.
#[derive(Clone, Copy, Debug)]
pub(super) struct LeafBox {
    pub bounds: Aabb,
    /// The moments of the whole leaf, before any clipping or subtraction; `None` without a closed form, and for several
    /// leaves.
    pub moments: Option<Moments>,
}

impl LeafBox {
    fn placed(&self, map: &Affine) -> LeafBox {
        let moments = self.moments.map(|moments| moments.placed(map));
        LeafBox { bounds: self.bounds.transformed(map), moments }
    }

    fn within(self, bounds: &Aabb) -> Option<LeafBox> {
        let bounds = self.bounds.intersection(bounds);
        (!bounds.is_empty()).then_some(LeafBox { bounds, ..self })
    }
}

/// The boxes of a level by object; `None` stands for the object that a placement of the level names.
type Boxes = BTreeMap<Option<u32>, Vec<LeafBox>>;

/// Returns the boxes of the leaves of wanted objects, by index; none for other objects. If there are too many, the
/// boxes are those of groups, or only some of them.
pub(super) fn leaf_boxes(world: &World, wanted: &[bool]) -> Vec<Vec<LeafBox>> {
    // A level comes after the levels that it places, and the root is last.
    let (mut levels, mut kept): (Vec<Boxes>, usize) = (Vec::new(), 0);
    for level in world.levels() {
        // Of the cells of a large lattice, some.
        let step = level.lattice.as_ref().map_or(1, |cells| cells.count().div_ceil(MAX_LEAVES as u32));
        let numbers: Vec<u32> = level.numbers_by(step).collect();
        let each = (MAX_LEAVES / numbers.len().max(1)).max(1);
        let mut boxes = Boxes::new();
        for number in numbers {
            let placed = level.placement(number);
            let bounds = world.placed_bounds(level, number);
            for (object, own) in of(world, &levels, &placed) {
                if object.is_none_or(|object| wanted[object as usize]) {
                    boxes.entry(object).or_default().extend(moved(own, &placed, bounds, each));
                }
            }
        }
        let most = if kept < BUDGET { MAX_LEAVES } else { 1 };
        boxes.values_mut().for_each(|boxes| *boxes = thinned(std::mem::take(boxes), most));
        kept += boxes.values().map(Vec::len).sum::<usize>();
        levels.push(boxes);
    }
    let mut root = levels.pop().unwrap_or_default();
    (0..).take(wanted.len()).map(|object| root.remove(&Some(object)).unwrap_or_default()).collect()
}

/// Returns the boxes of a placement's target, in the frame of the target.
fn of(world: &World, levels: &[Boxes], placed: &Placement) -> Vec<(Option<u32>, Vec<LeafBox>)> {
    match placed.target {
        Target::Level(level) => {
            let named = levels[level as usize].iter();
            named.map(|(object, boxes)| (object.or(placed.object), boxes.clone())).collect()
        }
        Target::Body(body) => match world.body(body) {
            Body::Surface(surface) => {
                vec![(placed.object, vec![LeafBox { bounds: surface.bounds, moments: None }])]
            }
            Body::Solid(body) => vec![(placed.object, of_body(body))],
        },
    }
}

/// Transforms boxes to the frame of the level that places them within a box; more than `most` are replaced by one around all.
fn moved(boxes: Vec<LeafBox>, placed: &Placement, bounds: Aabb, most: usize) -> Vec<LeafBox> {
    // The map was inverted once, so it can be inverted again, but for rounding.
    let Ok(map) = inverse(&placed.local_from_parent) else {
        return vec![LeafBox { bounds, moments: None }];
    };
    let boxes = if boxes.len() > most { vec![around(&boxes)] } else { boxes };
    boxes.iter().filter_map(|own| own.placed(&map).within(&bounds)).collect()
}

fn inverse(map: &Affine) -> Result<Affine, crate::math::SingularTransform> {
    if map.is_identity() { Ok(Affine::IDENTITY) } else { map.inverse() }
}

/// The boxes of the leaves of a body.
fn of_body(body: &SolidBody) -> Vec<LeafBox> {
    let boxes = body.leaves.iter().flat_map(of_leaf);
    thinned(boxes.filter_map(|own| own.within(&body.bounds)).collect(), MAX_LEAVES)
}

/// The box of a leaf, or the boxes of the shells of a mesh.
fn of_leaf(leaf: &Leaf) -> Vec<LeafBox> {
    let map = inverse(&leaf.local_from_body);
    let (bounds, mesh) = (leaf.bounds, leaf.solid.as_mesh());
    match (mesh.filter(|mesh| mesh.topology().shells.count > 1), map) {
        (Some(mesh), Ok(map)) => {
            let shells =
                mesh.shell_boxes().into_iter().map(|bounds| LeafBox { bounds, moments: None }.placed(&map));
            thinned(shells.filter_map(|own| own.within(&bounds)).collect(), MAX_LEAVES)
        }
        (None, Ok(map)) if mesh.is_none() => {
            vec![LeafBox { bounds, moments: leaf.solid.moments().map(|moments| moments.placed(&map)) }]
        }
        _ => vec![LeafBox { bounds, moments: None }],
    }
}

/// Returns at most `most` of the boxes, evenly spaced in the list; if `most` is 1, one box around all.
fn thinned(boxes: Vec<LeafBox>, most: usize) -> Vec<LeafBox> {
    match boxes.len() {
        count if count <= most => boxes,
        _ if most == 1 => vec![around(&boxes)],
        count => boxes.into_iter().step_by(count.div_ceil(most)).collect(),
    }
}

fn around(boxes: &[LeafBox]) -> LeafBox {
    let bounds = boxes.iter().fold(Aabb::EMPTY, |all, own| all.union(&own.bounds));
    LeafBox { bounds, moments: None }
}
