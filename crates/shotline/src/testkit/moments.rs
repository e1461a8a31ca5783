//! Checks closed-form moments against estimates from rays.

use crate::compile::{Options, compile};
use crate::math::{Affine, HALF_ULP, Vec3};
use crate::measure::{Estimate, Measure, Method, Settings, measure};
use crate::query::batch::Run;
use crate::scene::{Node, Scene};
use crate::solid::{Kind, Params};

/// The allowed error of an estimate in standard errors. With 15 degrees of freedom, fewer than one in a million
/// exceed it.
const MAX_STANDARD_ERRORS: f64 = 8.0;

/// Checks that the closed form of a solid, if it has one, agrees with rays: as it is, and rotated and stretched.
///
/// # Panics
/// If they disagree.
pub fn closed_form_agrees_with_rays(kind: &'static Kind, params: &Params) {
    let stretched = Affine::rotation_xyz(Vec3::new(30.0, -50.0, 70.0))
        .then_after(&Affine::scaling(Vec3::new(0.5, -2.0, 1.25)));
    for map in [Affine::IDENTITY, stretched] {
        let mut scene = Scene::default();
        let solid = scene.add(Node::Solid { kind, params: params.clone() });
        let placed = scene.add_transform(map, solid);
        scene.add_object("solid", None, placed);
        let Ok(world) = compile(&scene, Options::default()) else { panic!("{params:?} under {map:?}") };
        if !world.bounds().is_finite() {
            continue;
        }
        let [exact, rays] = [Method::Best, Method::Rays].map(|method| {
            match measure(&world, &scene, &Settings { method, ..Settings::default() }, Run::default()) {
                Ok(measures) => measures[0],
                Err(error) => panic!("{}: {params:?}: {error}", kind.name),
            }
        });
        assert!(!rays.exact && rays.volume.value > 0.0, "{}: {params:?}: {rays:?}", kind.name);
        if let Some(off) = exact.exact.then(|| farthest_off(&exact, &rays)) {
            assert!(off < MAX_STANDARD_ERRORS, "{}: {params:?}: off by {off}: {exact:?} {rays:?}", kind.name);
        }
    }
}

/// Returns the largest difference between the estimate and the exact values, in standard errors of the estimate.
pub fn farthest_off(exact: &Measure, estimate: &Measure) -> f64 {
    let size = estimate.bounds.size().length();
    let reach = estimate.bounds.min.abs().max(estimate.bounds.max.abs()).length();
    let volume = exact.volume.value;
    // Rounding that the standard errors do not include: that of the numbers themselves, and that of a coordinate
    // relative to the thinnest side.
    let rounding = 64.0 * HALF_ULP * (1.0 + reach / estimate.bounds.size().min_element());
    let scales = |m: &Measure| -> Vec<(Estimate, f64)> {
        let centroid = m.centroid.map(|x| (x, reach));
        let inertia = m.inertia.as_flattened().iter().map(|x| (*x, volume * size * size));
        [(m.volume, volume)].into_iter().chain(centroid).chain(inertia).collect()
    };
    let off = |((exact, scale), (estimate, _)): (&(Estimate, f64), &(Estimate, f64))| {
        (exact.value - estimate.value).abs() / (estimate.std_error + rounding * scale)
    };
    scales(exact).iter().zip(&scales(estimate)).map(off).fold(0.0, f64::max)
}
