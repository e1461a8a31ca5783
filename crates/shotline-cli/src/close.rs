//! Overlaps of objects looked for where their boxes meet, however small that place is in the whole scene.

use shotline::aabb::Aabb;
use shotline::compile::World;
use shotline::query::{Caster, QueryError};
use shotline::ray::Span;

use crate::number::counted;
use crate::overlap::{self, Overlap};
use crate::survey::{Pairs, spread};

/// More parts than this are not compared with each other.
const MOST_PARTS: usize = 1_000_000;

/// Comparisons of boxes, at most.
const MOST_COMPARISONS: usize = 1 << 25;

/// Pairs that are kept to be looked at.
const MOST_PAIRS: usize = 1 << 20;

/// Rays for all pairs together, and for each along each axis.
const ALL_RAYS: usize = 1 << 18;
const MOST_RAYS: usize = 256;
const LEAST_RAYS: usize = 8;

/// Half-ulps of its coordinates by which a box may be larger than what it holds.
const PADDING: f64 = 32.0;

/// Parts of two objects of equal priority, and the box that is common to theirs.
struct Meeting {
    objects: [u32; 2],
    common: Aabb,
}

/// Casts rays through the common boxes of pairs of parts, the largest box first, and adds the overlaps; pairs of objects
/// that are known to overlap are passed over. Answers what could not be looked at.
pub fn look(world: &World, overlaps: &mut Pairs) -> Vec<String> {
    let Some(parts) = world.parts_of_objects(MOST_PARTS) else {
        return vec![format!("overlaps of more than {MOST_PARTS} parts with each other")];
    };
    let (meetings, all_compared) = meetings(world, parts);
    let mut unexamined = Vec::new();
    if !all_compared {
        unexamined.push("overlaps of some parts: too many have boxes that meet".to_string());
    }
    let name = |object: u32| world.object_names()[object as usize].as_str();
    let mut caster = Caster::new(world);
    let rays_of_pair = (ALL_RAYS / (3 * meetings.len().max(1))).clamp(LEAST_RAYS, MOST_RAYS);
    let (mut rays, mut missed) = (0, 0);
    for Meeting { objects, common } in &meetings {
        let names = objects.map(name);
        if overlaps.has(names[0], names[1]) {
            continue;
        }
        if rays >= ALL_RAYS {
            missed += 1;
            continue;
        }
        rays += 3 * rays_of_pair;
        if let Err(error) = through(&mut caster, common, rays_of_pair, names, overlaps) {
            // The other pairs would cost as much.
            unexamined.push(format!("overlaps of parts whose boxes meet: a ray was given up: {error}"));
            break;
        }
    }
    if missed > 0 {
        let pairs = counted(missed, "pair of parts", "pairs of parts");
        unexamined.push(format!("{pairs} whose boxes meet: too many to look at each"));
    }
    unexamined
}

/// Casts rays along each axis through a box, until two objects are seen to overlap.
fn through(
    caster: &mut Caster,
    bounds: &Aabb,
    rays: usize,
    [a, b]: [&str; 2],
    overlaps: &mut Pairs,
) -> Result<(), QueryError> {
    for (i, axis) in (0..rays as u32).flat_map(|i| (0..3).map(move |axis| (i, axis))) {
        let (Some(ray), Ok(span)) = (spread(bounds, axis, i), Span::new(0.0, 2.0 * bounds.size()[axis]))
        else {
            continue;
        };
        for Overlap { first, second, t_in, t_out } in overlap::on_ray(caster, &ray, span)? {
            overlaps.add(&first, &second, ray.at(t_in.midpoint(t_out)));
        }
        if overlaps.has(a, b) {
            break;
        }
    }
    Ok(())
}

/// Pairs of parts whose boxes have a volume in common, the largest first, and whether these are all.
fn meetings(world: &World, mut parts: Vec<(u32, Aabb)>) -> (Vec<Meeting>, bool) {
    parts.iter_mut().for_each(|(_, b)| *b = b.widened(-PADDING));
    parts.retain(|(_, b)| !b.is_empty());
    parts.sort_by(|(_, a), (_, b)| a.min.x.total_cmp(&b.min.x));
    let (mut meetings, mut comparisons, mut all) = (Vec::new(), 0, true);
    'parts: for (i, (a, box_of_a)) in parts.iter().enumerate() {
        for (b, box_of_b) in parts[i + 1..].iter().take_while(|(_, b)| b.min.x < box_of_a.max.x) {
            comparisons += 1;
            if comparisons > MOST_COMPARISONS || meetings.len() > MOST_PAIRS {
                all = false;
                break 'parts;
            }
            let common = box_of_a.intersection(box_of_b);
            let meet = common.min.cmplt(common.max).all() && common.is_finite();
            if a != b && meet && world.object_priority(*a) == world.object_priority(*b) {
                meetings.push(Meeting { objects: [*a.min(b), *a.max(b)], common });
            }
        }
    }
    let volume = |m: &Meeting| m.common.size().element_product();
    meetings.sort_by(|a, b| volume(b).total_cmp(&volume(a)));
    (meetings, all)
}
