//! Checks the materials of a scene.

use std::collections::HashSet;

use super::SceneError;
use crate::scene::{Material, Scene};

/// One error for each material whose name is taken, and for each property outside of its range.
pub(super) fn check(scene: &Scene) -> Vec<SceneError> {
    let mut names = HashSet::new();
    let mut errors = Vec::new();
    for (name, material) in &scene.materials {
        if !names.insert(name) {
            let error = SceneError::general(format!("two materials are named '{name}'"));
            errors.push(error.with_hint("give them different names"));
        }
        for (property, value, most) in properties(material) {
            if !(0.0..=most).contains(&value) {
                let error =
                    SceneError::general(format!("the {property} of the material '{name}' is {value}"));
                errors.push(error.with_hint(if most == 1.0 {
                    "it must be from 0 to 1"
                } else {
                    "it must be at least 0 and finite"
                }));
            }
        }
    }
    errors
}

/// The properties that are given, each with its largest valid value; the smallest is 0.
fn properties(material: &Material) -> impl Iterator<Item = (&'static str, f64, f64)> {
    let Material { mu, density, composition, color, specular, shininess, mirror } = material;
    let numbers = [
        ("mu", mu, f64::MAX),
        ("density", density, f64::MAX),
        ("specular", specular, 1.0),
        ("shininess", shininess, f64::MAX),
        ("mirror", mirror, 1.0),
    ];
    let numbers =
        numbers.into_iter().filter_map(|(name, value, most)| value.map(|value| (name, value, most)));
    let shares = composition.iter().map(|&(_, share)| ("composition", share, 1.0));
    numbers.chain(shares).chain(color.iter().flatten().map(|&component| ("color", component, 1.0)))
}
