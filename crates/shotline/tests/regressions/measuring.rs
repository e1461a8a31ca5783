//! Volumes, masses and boxes.

use std::f64::consts::PI;

use shotline::measure::{Measure, MeasureError, Settings, measure};
use shotline::query::batch::Run;
use shotline::solid::mesh::Topology;

use super::*;

fn measured(scene: &Scene) -> Result<Vec<Measure>, MeasureError> {
    measure(&scene.compile().unwrap(), scene, &Settings::default(), Run::default())
}

fn volume_of(shape: Shape) -> Measure {
    measured(&scene_of(shape)).unwrap()[0]
}

#[track_caller]
fn assert_exactly(found: &Measure, volume: f64) {
    assert!(found.exact && (found.volume.value / volume - 1.0).abs() < 1e-14, "{volume}: {found:?}");
}

/// Half-spaces that bound a polytope had infinite boxes, and `measure` refused it.
#[test]
fn an_octahedron_of_half_spaces_is_measured_exactly() {
    let side = |i: u32| [1, 2, 4].map(|bit| if i & bit == 0 { 1.0 } else { -1.0 });
    let octahedron = Shape::intersection((0..8).map(|i| Shape::halfspace(side(i), 1.0).unwrap()));
    let bounds = world_of(&octahedron).bounds();
    assert!((bounds.max - Vec3::ONE).abs().max_element() < 1e-12, "{bounds:?}");
    assert_exactly(&volume_of(octahedron), 4.0 / 3.0);
}

/// A cell as OpenMC and MCNP write it, a cylinder surface between two planes, had an infinite box: every ray asked
/// every cell, and `measure` refused it.
#[test]
fn a_cylinder_surface_between_planes_has_a_box_and_a_volume() {
    let side = Shape::quadric([1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0]).unwrap();
    let plane = |z: f64| Shape::halfspace([0.0, 0.0, z], 1.0).unwrap();
    let pin = side & plane(1.0) & plane(-1.0);
    let bounds = world_of(&pin).bounds();
    assert!((bounds.max - Vec3::ONE).abs().max_element() < 1e-12, "{bounds:?}");
    let found = volume_of(pin).volume;
    assert!(found.std_error < 0.01 && (found.value - 2.0 * PI).abs() <= 6.0 * found.std_error, "{found:?}");
}

/// The sides of a turned wedge are parallel to the rays that measure it, and its volume was a third too small, with a
/// small standard error.
#[test]
fn a_turned_wedge_has_its_volume() {
    let disc = Shape::cylinder(1.0, 0.0, 1.0).unwrap();
    let below = Shape::halfspace([0.0, -1.0, 0.0], 0.0).unwrap();
    let above = Shape::halfspace([0.0, 1.0, 0.0], 0.0).unwrap().rotate([0.0, 0.0, 30.0]);
    let found = volume_of((disc & below & above).rotate([0.0, 0.0, 330.0])).volume;
    assert!(found.std_error < 1e-3 && (found.value - PI / 12.0).abs() <= 6.0 * found.std_error, "{found:?}");
}

/// An object without an end kept all others from being measured.
#[test]
fn an_object_without_an_end_does_not_stop_the_others() {
    let ground = Shape::halfspace(Vec3::Z, 0.0).unwrap();
    let block = Shape::cuboid([0.0; 3], [1.0, 2.0, 3.0]).unwrap();
    let found = measured(&Scene::of([Object::new("ground", ground), Object::new("block", block)])).unwrap();
    assert!(found[0].is_unbounded() && found[0].volume.value.is_nan());
    assert_exactly(&found[1], 6.0);
}

/// The error of a mesh that passes through itself was that of sampling its whole box: 0 +- 3 for thin parts.
#[test]
fn crossed_rods_in_one_mesh_are_known_but_for_where_they_cross() {
    let w = 0.0009765625;
    let rods = shells([brick([-50.0, -w, -w], [50.0, w, w]), brick([-w, -50.0, -w], [w, 50.0, w])]);
    let found = volume_of(shape_of(rods)).volume;
    let (rod, both) = (100.0 * 4.0 * w * w, 8.0 * w * w * w);
    assert!(found.std_error <= both, "{found:?}");
    assert!((found.value - (2.0 * rod - both)).abs() <= 6.0 * found.std_error + 1e-14, "{found:?}");
}

/// Shells in one another were sampled, though what they hold is known.
#[test]
fn shells_in_one_another_are_exact() {
    let inner = brick([-0.5; 3], [0.5; 3]);
    let mut cavity = inner.clone();
    cavity.faces.iter_mut().for_each(|face| face.swap(1, 2));
    let mut turned = shells([brick([-1.0; 3], [1.0; 3])]);
    turned.faces.iter_mut().for_each(|face| face.swap(1, 2));
    assert_exactly(&volume_of(shape_of(shells([brick([-1.0; 3], [1.0; 3]), inner]))), 8.0);
    assert_exactly(&volume_of(shape_of(shells([brick([-1.0; 3], [1.0; 3]), cavity]))), 7.0);
    assert_exactly(&volume_of(shape_of(turned)), 8.0);
}

/// Volumes of meshes were sums of terms about the origin that cancel: wrong by any factor for long tetrahedra and for
/// small shells far apart.
#[test]
fn volumes_of_meshes_are_right_where_their_terms_cancel() {
    let moved = |x: f64| {
        let mut mesh = tetrahedron();
        mesh.vertices.iter_mut().for_each(|v| *v += Vec3::new(x, 2.0 * x, 3.0 * x));
        mesh
    };
    let far = 2f64.powi(40);
    assert_exactly(&volume_of(shape_of(moved(far))), 1.0 / 6.0);
    assert_exactly(&volume_of(shape_of(shells([moved(0.0), moved(far)]))), 1.0 / 3.0);
    let (size, away) = (0.5f64.powi(10), 2f64.powi(30));
    let speck = |x: f64, y: f64| brick([x, y, y], [x + size, y + size, y + size]);
    let specks = shells([speck(0.0, 0.0), speck(away, away), speck(away, 0.0)]);
    assert_exactly(&volume_of(shape_of(specks)), 3.0 * size.powi(3));
    // A needle of length 2^30 with a volume of 1/6: (n + 1) (n - 1) - n^2 = -1.
    let n = 2f64.powi(30);
    let mut needle = tetrahedron();
    needle.vertices[1] = Vec3::new(n, n - 1.0, 0.0);
    needle.vertices[2] = Vec3::new(n + 1.0, n, 0.0);
    assert_eq!(Topology::of(&needle).unwrap().signed_volume, 1.0 / 6.0);
}

/// Rods and plates that rays along one axis do not meet were missing, and the standard error did not show it.
#[test]
fn a_plate_and_a_post_have_their_volume() {
    let sheet = Shape::cuboid([0.0; 3], [1000.0, 1000.0, 0.001]).unwrap();
    let post = Shape::cuboid([0.0; 3], [0.001, 0.001, 1000.0]).unwrap();
    let found = volume_of(sheet | post).volume;
    let truth = 1000.0 + 0.001 - 1e-9;
    assert!((found.value - truth).abs() <= 6.0 * found.std_error + 1e-9, "{found:?}");
    assert!(found.std_error < 1e-3 * truth, "{found:?}");
}

/// Volumes of huge and tiny objects were returned as infinite and 0, without an error.
#[test]
fn a_volume_that_overflows_or_underflows_is_an_error() {
    for size in [1e120, 1e-110] {
        let error = measured(&scene_of(Shape::sphere(size).unwrap())).unwrap_err();
        assert!(matches!(error, MeasureError::OutOfRange { .. }), "{error}");
    }
    assert_exactly(&volume_of(Shape::sphere(1e100).unwrap()), 4.0 / 3.0 * PI * 1e300);
}

/// The mass of a cube of 10 mm was its volume in cubic millimetres times a density in g/cm^3: 7800.
#[test]
fn masses_are_in_grams() {
    let steel = Material { density: Some(7.8), ..Material::default() };
    let cube = Object::new("cube", Shape::cuboid([0.0; 3], [10.0; 3]).unwrap()).material("steel");
    let scene = Scene::of([cube]).with_material("steel", steel).with_units(Units::Millimetres);
    let mass = measured(&scene).unwrap()[0].mass.unwrap().value;
    assert!((mass - 7.8).abs() < 1e-14, "{mass}");
}
