//! What must hold of any world and any ray, however odd: lists alternate and are in order, every query tells the
//! same story, and every accelerator gives the same bits.

use std::collections::BTreeMap;

use crate::accel;
use crate::compile::{Options, World, compile};
use crate::query::{Caster, Hit, HitKind, Overlaps, QueryError, Seed};
use crate::ray::{Ray, Span};
use crate::scene::Scene;

/// Compiles a scene with every accelerator and asks everything of each ray. Answers whether the scene compiles.
///
/// # Panics
/// Where a rule is broken, with the ray and the answers.
pub fn hold(scene: &Scene, rays: &[(Ray, Span)]) -> bool {
    let worlds = accel::NAMES.iter().map(|accel| compile(scene, Options { accel: Some(accel) }));
    let worlds: Vec<World> = match worlds.collect() {
        Ok(worlds) => worlds,
        Err(errors) => {
            assert!(!errors.is_empty() && errors.iter().all(|e| !e.message.is_empty()), "{errors:?}");
            return false;
        }
    };
    let mut seeds = Seeds::default();
    for (ray, span) in rays {
        let expected = answers(&worlds[0], ray, *span, &mut seeds);
        for (name, world) in accel::NAMES.iter().zip(&worlds).skip(1) {
            let list = answers(world, ray, *span, &mut seeds);
            let same = bits(&list) == bits(&expected);
            assert!(same, "{name} and {} on {ray:?} {span:?}\n{list:#?}\n{expected:#?}", accel::NAMES[0]);
        }
    }
    true
}

/// Hits in a form that compares every bit.
fn bits(hits: &[Hit]) -> Vec<impl PartialEq> {
    let bits = |hit: &Hit| {
        let numbers = [hit.t, hit.t_err, hit.normal.x, hit.normal.y, hit.normal.z].map(f64::to_bits);
        let triangle = (hit.primitive, hit.barycentric.map(|b| b.map(f64::to_bits)));
        (numbers, hit.entering, hit.kind, hit.object, hit.surface, triangle, hit.path)
    };
    hits.iter().map(bits).collect()
}

/// What earlier rays met, of whatever kind they were.
#[derive(Default)]
struct Seeds {
    closest: Seed,
    any: Seed,
}

/// What is told of a ray where a rule is broken.
type Context<'a> = &'a dyn Fn() -> String;

/// The crossings, after every other query has been held to them.
fn answers(world: &World, ray: &Ray, span: Span, seeds: &mut Seeds) -> Vec<Hit> {
    let mut caster = Caster::new(world);
    let mut hits = Vec::new();
    caster.crossings(ray, span, &mut hits).expect("within limits");
    let context = || format!("{ray:?} {span:?}\n{hits:#?}");
    in_order(&hits, span, &context);
    let first = caster.closest(ray, span).expect("within limits");
    assert!(bits(first.as_slice()) == bits(&hits[..hits.len().min(1)]), "closest {first:?} of {}", context());
    let seeded = caster.closest_from(&mut seeds.closest, ray, span).expect("within limits");
    assert!(bits(seeded.as_slice()) == bits(first.as_slice()), "seeded {seeded:?} of {}", context());
    assert_eq!(caster.any(ray, span).expect("within limits"), !hits.is_empty(), "any of {}", context());
    assert_eq!(
        caster.any_from(&mut seeds.any, ray, span).expect("within limits"),
        !hits.is_empty(),
        "seeded any of {}",
        context()
    );
    assert_eq!(caster.count(ray, span).expect("within limits"), hits.len() as u64, "count of {}", context());
    let mut segments = Vec::new();
    match caster.segments(ray, span, Overlaps::All, &mut segments) {
        Ok(_) => {
            alternate(&hits, &context);
            let sound = segments.iter().all(|s| s.t_in <= s.t_out && s.length >= 0.0);
            assert!(sound, "{segments:?} of {}", context());
        }
        Err(error) => assert!(matches!(error, QueryError::NotASolid { .. }), "{error} of {}", context()),
    }
    hits
}

fn in_order(hits: &[Hit], span: Span, context: Context) {
    assert!(hits.windows(2).all(|w| w[0].t <= w[1].t), "not ascending: {}", context());
    for hit in hits {
        assert!(
            span.t_min() <= hit.t && hit.t <= span.t_max(),
            "{} outside of the span: {}",
            hit.t,
            context()
        );
        assert!(hit.t_err >= 0.0 && hit.t_err.is_finite(), "bound {}: {}", hit.t_err, context());
        let unit = (hit.normal.length() - 1.0).abs() < 1e-12;
        assert!(unit == (hit.kind == HitKind::Surface), "normal {}: {}", hit.normal, context());
        assert!(hit.surface.is_some() == unit, "surface: {}", context());
    }
}

/// The crossings of each path go in, out, in, out.
fn alternate(hits: &[Hit], context: Context) {
    let mut inside: BTreeMap<u64, bool> = BTreeMap::new();
    for hit in hits {
        let before = inside.insert(hit.path, hit.entering).unwrap_or(false);
        assert!(before != hit.entering, "path {} does not alternate: {}", hit.path, context());
    }
    assert!(inside.values().all(|inside| !inside), "odd: {}", context());
}
