//! The moments of lattices.

use std::f64::consts::PI;

use super::tests::{all, rays};
use super::*;
use crate::math::{Lattice, Vec3};
use crate::shape::{Object, Shape};

const BALL: f64 = 4.0 / 3.0 * PI * 0.25 * 0.25 * 0.25;

fn measured(lattice: Lattice) -> Measure {
    let balls = Shape::sphere(0.25).unwrap().lattice(lattice);
    let scene = Scene::of([Object::new("balls", balls)]);
    all(&scene, &Settings::default()).unwrap().remove(0)
}

fn assert_near(a: f64, b: f64) {
    assert!((a - b).abs() <= 1e-9 * b.abs(), "{a} is not {b}");
}

/// A billion cells are added up by the digits of their numbers.
#[test]
fn lattices_of_any_size_have_closed_forms() {
    for counts in [[1000u32; 3], [7, 1, 12], [1, 1, 1], [2_000_000, 3, 1]] {
        let found = measured(Lattice::rectangular(counts, [1.0, 2.0, 0.5]));
        let count: f64 = counts.into_iter().map(f64::from).product();
        assert_near(found.volume.value, count * BALL);
        let middle = counts.map(|count| f64::from(count - 1) * 0.5);
        let expected = Vec3::from(middle) * Vec3::new(1.0, 2.0, 0.5);
        let centroid = Vec3::from(found.centroid.map(|x| x.value));
        assert!((centroid - expected).length() < 1e-6 * (1.0 + expected.length()), "{found:?}");
        assert!(found.exact);
    }
    let rings = Lattice::Hexagonal { rings: 4, pitch: 1.0, layers: 3, height: 1.0 };
    assert_near(measured(rings).volume.value, 37.0 * 3.0 * BALL);
}

/// Copies that overlap are measured by rays.
#[test]
fn cells_that_overlap_count_once() {
    let cubes = Shape::cuboid([0.0; 3], [1.0; 3]).unwrap().lattice(Lattice::rectangular([4, 1, 1], [0.5; 3]));
    let scene = Scene::of([Object::new("cubes", cubes)]);
    let found = all(&scene, &rays(20_000, 1)).unwrap().remove(0);
    let Estimate { value, std_error: error } = found.volume;
    assert!((value - 2.5).abs() <= 4.0 * error + 1e-9, "{value} +- {error}");
    assert!(!all(&scene, &Settings::default()).unwrap()[0].exact);
}
