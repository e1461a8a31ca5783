//! How objects move in an animation.

use std::collections::HashSet;

use shotline::math::Vec3;
use shotline::scene::{Motion, Node, Scene};

use super::keys::{MOTION, names};
use super::placement::read_rotation;
use super::values::Values;
use crate::json::ValueId;

/// The motions, each with its value in the tree.
pub(super) fn read(values: &mut Values, at: ValueId) -> Vec<(Motion, ValueId)> {
    let motions = values.array(at, "\"motions\"").unwrap_or(&[]);
    motions.iter().filter_map(|&at| Some((read_motion(values, at)?, at))).collect()
}

fn read_motion(values: &mut Values, at: ValueId) -> Option<Motion> {
    values.object(at, "a motion")?;
    values.only(at, "a motion", &names(MOTION).collect::<Vec<_>>());
    let object = values.required(at, "a motion", "object", "the name of an object");
    let object = object.and_then(|at| values.text(at, "\"object\""));
    let rotate = values.tree.get(at, "rotate").and_then(|at| read_rotation(values, at));
    let mut vector = |key: &str| {
        let at = values.tree.get(at, key)?;
        values.vector(at, &format!("\"{key}\"")).map(Vec3::from)
    };
    let (about, translate) = (vector("about"), vector("translate"));
    Some(Motion { object: object?.to_string(), rotate, about, translate })
}

/// Checks that each motion moves an object, and that no object has two.
pub(super) fn check(values: &mut Values, motions: &[(Motion, ValueId)], scene: &Scene) {
    let objects = || {
        scene
            .nodes
            .iter()
            .filter_map(|n| if let Node::Object { name, .. } = n { Some(&**name) } else { None })
    };
    let known: HashSet<&str> = if motions.is_empty() { HashSet::new() } else { objects().collect() };
    let mut seen = HashSet::new();
    for (motion, at) in motions {
        let name = &*motion.object;
        if !known.contains(name) {
            let hint = values.hint(name, objects());
            values.report(*at, format!("there is no object named '{name}' to move"), hint);
        } else if !seen.insert(name) {
            values.report(*at, format!("'{name}' has two motions"), "put both into one");
        }
    }
}
