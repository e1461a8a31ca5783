//! Properties that must hold for any world and any ray: lists alternate and are in order, all queries are
//! consistent, and all accelerators return the same bits.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet};

use crate::accel;
use crate::compile::{Options, World, compile};
use crate::math::Vec3;
use crate::query::{Caster, CoherenceHint, Hit, HitKind, Overlaps, QueryError};
use crate::ray::{Ray, Span};
use crate::scene::Scene;

/// Compiles a scene with every accelerator and runs every query on each ray, with and without the fast paths for
/// few leaves. Returns whether the scene compiles.
///
/// # Panics
/// If a rule is broken. The message contains the ray and the results.
pub fn check_scene(scene: &Scene, rays: &[(Ray, Span)]) -> bool {
    let compiled = |accel: &'static str| compile(scene, Options { accel: Some(accel) });
    let plain = accel::NAMES.iter().map(|accel| Ok(compiled(accel)?.reference_world(accel)));
    let worlds: Vec<World> = match std::iter::once(compiled(accel::DEFAULT)).chain(plain).collect() {
        Ok(worlds) => worlds,
        Err(errors) => {
            assert!(!errors.is_empty() && errors.iter().all(|e| !e.message.is_empty()), "{errors:?}");
            return false;
        }
    };
    let mut hints = Hints::default();
    for (ray, span) in rays {
        let expected = check_ray(&worlds[0], ray, *span, &mut hints);
        for (name, world) in accel::NAMES.iter().zip(&worlds[1..]) {
            let list = check_ray(world, ray, *span, &mut hints);
            let same = bits(&list) == bits(&expected);
            assert!(same, "{name} and the short ways on {ray:?} {span:?}\n{list:#?}\n{expected:#?}");
        }
    }
    true
}

/// Runs every query on each ray in one world.
///
/// # Panics
/// If a rule is broken. The message contains the ray and the results.
pub fn check_world(world: &World, rays: &[(Ray, Span)]) {
    let mut hints = Hints::default();
    rays.iter().for_each(|(ray, span)| {
        check_ray(world, ray, *span, &mut hints);
    });
}

/// Returns spans that begin and end at critical points: at crossings of a ray, just before and after them,
/// between them, and around single crossings.
pub fn spans_of(world: &World, ray: &Ray) -> Vec<Span> {
    let mut hits = Vec::new();
    let from = Span::new(-1e12, f64::INFINITY).unwrap_or(Span::FORWARD);
    Caster::new(world).crossings(ray, from, &mut hits).expect("within limits");
    let surfaces: Vec<f64> = hits.iter().filter(|h| h.kind == HitKind::Surface).map(|h| h.t).collect();
    let mut ts: Vec<f64> = surfaces.iter().flat_map(|t| [t.next_down(), *t, t.next_up()]).collect();
    ts.extend(hits.iter().filter(|h| h.t_err > 0.0).flat_map(|h| {
        let reach = 8.0 * h.t_err;
        [h.t - 2.0 * reach, h.t - 0.9 * reach, h.t + 0.9 * reach, h.t + 2.0 * reach]
    }));
    ts.extend(surfaces.windows(2).map(|pair| 0.5 * pair[0] + 0.5 * pair[1]));
    ts.sort_by(f64::total_cmp);
    let begin = ts.iter().filter_map(|&t| Span::new(t, f64::INFINITY).ok());
    let short = ts.windows(2).filter_map(|pair| Span::new(pair[0], pair[1]).ok());
    let long = ts.windows(5).filter_map(|some| Span::new(some[0], some[4]).ok());
    begin.chain(short).chain(long).chain([Span::FORWARD]).collect()
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

/// Hints left by earlier rays of any kind.
#[derive(Default)]
struct Hints {
    closest: CoherenceHint,
    any: CoherenceHint,
}

/// The description of a ray for a failure message.
type Context<'a> = &'a dyn Fn() -> String;

/// Returns the crossings, after checking every other query against them.
fn check_ray(world: &World, ray: &Ray, span: Span, hints: &mut Hints) -> Vec<Hit> {
    let mut caster = Caster::new(world);
    let mut hits = Vec::new();
    caster.crossings(ray, span, &mut hits).expect("within limits");
    let context = || format!("{ray:?} {span:?}\n{hits:#?}");
    in_order(&hits, span, &context);
    let first = caster.closest(ray, span).expect("within limits");
    assert!(bits(first.as_slice()) == bits(&hits[..hits.len().min(1)]), "closest {first:?} of {}", context());
    let hinted = caster.closest_with_hint(&mut hints.closest, ray, span).expect("within limits");
    assert!(bits(hinted.as_slice()) == bits(first.as_slice()), "hinted {hinted:?} of {}", context());
    assert_eq!(caster.any(ray, span).expect("within limits"), !hits.is_empty(), "any of {}", context());
    assert_eq!(
        caster.any_with_hint(&mut hints.any, ray, span).expect("within limits"),
        !hits.is_empty(),
        "hinted any of {}",
        context()
    );
    assert_eq!(caster.count(ray, span).expect("within limits"), hits.len() as u64, "count of {}", context());
    let mut segments = Vec::new();
    match caster.segments(ray, span, Overlaps::All, &mut segments) {
        Ok(_) => {
            alternate(&hits, &context);
            let sound = segments.iter().all(|s| s.t_in <= s.t_out && s.length >= 0.0);
            assert!(sound, "{segments:?} of {}", context());
            let mut found: Vec<ObjectInterval> =
                segments.iter().map(|s| (s.path, s.object, s.t_in, s.t_out)).collect();
            found.sort_by(by_path);
            assert_eq!(found, between_crossings(&hits), "segments of {}", context());
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

/// An interval of a ray inside an object: path, object, entry `t` and exit `t`.
type ObjectInterval = (u64, u32, f64, f64);

fn by_path(a: &ObjectInterval, b: &ObjectInterval) -> Ordering {
    a.0.cmp(&b.0).then(a.2.total_cmp(&b.2)).then(a.3.total_cmp(&b.3))
}

/// Pairs consecutive crossings of each path into intervals.
fn between_crossings(hits: &[Hit]) -> Vec<ObjectInterval> {
    let mut open: BTreeMap<u64, f64> = BTreeMap::new();
    let mut intervals = Vec::new();
    for hit in hits {
        match open.remove(&hit.path) {
            None => drop(open.insert(hit.path, hit.t)),
            Some(from) => intervals.push((hit.path, hit.object, from, hit.t)),
        }
    }
    intervals.sort_by(by_path);
    intervals
}

/// Checks `contains` against the crossings. Halfway between two crossings, if that is far enough from both for
/// the rounding of the point, it must return the objects that the ray is in there. Returns the number of points
/// checked.
///
/// # Panics
/// If `contains` is wrong at the point and all around it.
pub fn contains_agrees(world: &World, ray: &Ray) -> usize {
    let (mut caster, mut hits, mut checked) = (Caster::new(world), Vec::new(), 0);
    caster.crossings(ray, Span::FORWARD, &mut hits).expect("within limits");
    for pair in hits.windows(2) {
        let t = 0.5 * pair[0].t + 0.5 * pair[1].t;
        let (p, d) = (ray.at(t), ray.direction());
        // The perpendicular distance to the nearer face, and the possible rounding of coordinates.
        let slopes = pair.iter().filter(|h| h.kind == HitKind::Surface).map(|h| h.normal.dot(d).abs());
        let clear = slopes.fold(f64::INFINITY, f64::min) * (pair[1].t - pair[0].t) * 0.5;
        let fine = 1e-12 * ray.origin().abs().max(p.abs()).max_element();
        if clear.is_nan() || clear <= 8.0 * fine || t.is_infinite() {
            continue;
        }
        let mut inside: BTreeMap<u64, u32> = BTreeMap::new();
        for hit in hits.iter().filter(|hit| hit.t < t) {
            if inside.remove(&hit.path).is_none() {
                inside.insert(hit.path, hit.object);
            }
        }
        let expected: BTreeSet<u32> = inside.into_values().collect();
        let mut differs = |p: Vec3| {
            let mut held = Vec::new();
            caster.contains(p, &mut held).is_ok() && held != Vec::from_iter(expected.iter().copied())
        };
        // Near a face that the ray runs along, a point may count as on its other side.
        let around = Vec3::AXES.into_iter().flat_map(|axis| [axis * fine, -axis * fine]);
        let refuted = differs(p) && around.into_iter().all(|step| differs(p + step));
        assert!(!refuted, "contains at {p:?}, t = {t}, is not {expected:?}: {ray:?}\n{hits:#?}");
        checked += 1;
    }
    checked
}

/// The crossings of each path alternate, beginning with an entry.
fn alternate(hits: &[Hit], context: Context) {
    let mut inside: BTreeMap<u64, bool> = BTreeMap::new();
    for hit in hits {
        let before = inside.insert(hit.path, hit.entering).unwrap_or(false);
        assert!(before != hit.entering, "path {} does not alternate: {}", hit.path, context());
    }
    assert!(inside.values().all(|inside| !inside), "odd: {}", context());
}
