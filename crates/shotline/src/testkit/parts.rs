//! The conformance suite of kinds that are combinations of other solids: in a world, their crossings are where membership
//! changes, with every accelerator.

use super::agreement::{check_scene, spans_of};
use super::membership::Membership;
use super::random::Random;
use crate::compile::{Options, compile};
use crate::math::Vec3;
use crate::query::Caster;
use crate::ray::{Ray, Span};
use crate::scene::{Node, Scene};
use crate::solid::{Kind, Params};

/// The number of rays for each example.
const RAYS: usize = 60;

/// Runs the suite on all examples of a kind that are combinations.
///
/// # Panics
/// If the kind breaks a rule. The message contains the kind, its parameters and the ray.
pub fn conformance(kind: &'static Kind) {
    for example in kind.examples {
        let params = Params::of(kind, example);
        let parts = kind.build(&params).unwrap_or_else(|error| panic!("{} {example:?}: {error}", kind.name));
        if parts.single().is_some() {
            continue;
        }
        let mut scene = Scene::default();
        let node = scene.add(Node::Solid { kind, params });
        scene.add_object("it", None, node);
        let world = compile(&scene, Options::default()).unwrap_or_else(|errors| panic!("{errors:?}"));
        let bounds = world.bounds();
        assert!(bounds.is_finite() && !bounds.is_empty(), "{} {example:?}: {bounds:?}", kind.name);
        let mut random = Random::new(7);
        let mut rays: Vec<(Ray, Span)> =
            (0..RAYS).map(|i| (ray(&mut random, i, &bounds.min, &bounds.size()), Span::FORWARD)).collect();
        let more =
            rays[..4].iter().flat_map(|(ray, _)| spans_of(&world, ray).into_iter().map(|span| (*ray, span)));
        let more: Vec<_> = more.collect();
        rays.extend(more);
        assert!(check_scene(&scene, &rays));
        let membership = Membership::of(&scene);
        let (mut caster, mut crossed) = (Caster::new(&world), 0);
        for (ray, _) in &rays[..RAYS] {
            let mut hits = Vec::new();
            caster.crossings(ray, Span::FORWARD, &mut hits).unwrap_or_else(|error| panic!("{error}"));
            crossed += usize::from(!hits.is_empty());
            let mut ts: Vec<f64> = hits.iter().map(|hit| hit.t).collect();
            ts.insert(0, 0.0);
            ts.push(ts[ts.len() - 1] + bounds.size().max_element() / ray.direction().length());
            for (i, pair) in ts.windows(2).enumerate().filter(|(_, pair)| pair[0] < pair[1]) {
                let t = 0.5 * (pair[0] + pair[1]);
                let is_wrong = membership.certainly_differs(
                    node,
                    ray.at(t),
                    1e-9 * bounds.size().max_element(),
                    i % 2 == 1,
                );
                assert!(!is_wrong, "{} {example:?}: {ray:?} at {t}: {hits:?}", kind.name);
            }
        }
        assert!(crossed > RAYS / 4, "{} {example:?}: {crossed}", kind.name);
    }
}

/// A ray at a box: from outside, from inside, along an axis, and in planes through the z axis.
fn ray(random: &mut Random, number: usize, min: &Vec3, size: &Vec3) -> Ray {
    let mut inside = || *min + *size * random.point(0.0, 1.0);
    let (mut o, target) = (inside(), inside());
    let far = random.direction() * size.length() * 2.0;
    let d = match number % 5 {
        0 => target - o,
        1 => Vec3::AXES[number / 5 % 3],
        2 => {
            // In a plane through the axis.
            o.x = 0.0;
            Vec3::new(0.0, target.y - o.y, target.z - o.z)
        }
        _ => {
            o = target + far;
            -far
        }
    };
    if number % 5 == 1 {
        o -= d * size.length() * 2.0;
    }
    Ray::new(o, d).unwrap_or_else(|error| panic!("{error}"))
}
