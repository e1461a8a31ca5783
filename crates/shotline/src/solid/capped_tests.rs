//! Cases that the random lines of the conformance suite do not reach: apexes, generators, tangents, sheets,
//! scales.

use std::sync::Arc;

use super::{Build, KINDS, Kind, ParamError, Params, Quantity, Solid, kind};
use crate::crossing::{Crossing, is_alternating};
use crate::math::Vec3;
use crate::ray::Line;

pub(super) fn build(name: &str, numbers: &[f64]) -> Result<Arc<dyn Solid>, ParamError> {
    let kind = kind(name).unwrap();
    let values: Vec<&[f64]> = match kind.params {
        [_] => vec![numbers],
        _ => numbers.chunks(1).collect(),
    };
    kind.build(&Params::of(kind, &values)).map(|parts| parts.single().unwrap().clone())
}

pub(super) fn cast(solid: &dyn Solid, o: [f64; 3], d: [f64; 3]) -> Vec<Crossing> {
    let mut list = Vec::new();
    solid.crossings(&Line::exact(Vec3::from(o), Vec3::from(d)), &mut list);
    assert!(is_alternating(&list), "{list:?}");
    list
}

fn ts(name: &str, numbers: &[f64], o: [f64; 3], d: [f64; 3]) -> Vec<f64> {
    cast(&*build(name, numbers).unwrap(), o, d).iter().map(|c| c.t).collect()
}

#[test]
fn lines_through_an_apex_enter_and_leave() {
    let cone = [3.0, 0.0, 0.0, 4.0];
    assert_eq!(ts("cone", &cone, [0.0, 0.0, -1.0], [0.0, 0.0, 1.0]), [1.0, 5.0]);
    assert_eq!(ts("cone", &cone, [0.25, 0.0, 3.0], [-0.25, 0.0, 1.0]), [-3.0, 1.0]);
    // Across the apex: outside on both sides.
    assert_eq!(ts("cone", &cone, [-1.0, 0.0, 4.0], [1.0, 0.0, 0.0]), []);
    assert_eq!(ts("cone", &cone, [-4.0, 0.0, 3.0], [4.0, 0.0, 1.0]), []);
}

#[test]
fn lines_along_a_generator_cross_nothing_but_a_rim() {
    assert_eq!(ts("cone", &[3.0, 0.0, 0.0, 4.0], [3.0, 0.0, 0.0], [-3.0, 0.0, 4.0]), []);
    assert_eq!(ts("cylinder", &[1.0, 0.0, 4.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]), []);
    // A hyperboloid of one sheet contains lines.
    assert_eq!(ts("hyperboloid", &[1.0, 1.0, -2.0, 2.0], [1.0, 0.0, 0.0], [0.0, 1.0, 1.0]), []);
    // Parallel to a generator, inside: one root is at infinity, and the cap bounds the other side.
    assert_eq!(ts("cone", &[3.0, 0.0, 0.0, 4.0], [0.0, 0.0, 0.0], [-3.0, 0.0, 4.0]), [0.0, 0.5]);
}

#[test]
fn tangents_and_near_tangents_are_told_apart() {
    assert_eq!(ts("sphere", &[1.0], [1.0, -2.0, 0.0], [0.0, 1.0, 0.0]), []);
    let inside = 1.0 - f64::EPSILON / 2.0;
    assert_eq!(ts("sphere", &[1.0], [inside, -2.0, 0.0], [0.0, 1.0, 0.0]).len(), 2);
    let outside = 1.0 + f64::EPSILON;
    assert_eq!(ts("sphere", &[1.0], [outside, -2.0, 0.0], [0.0, 1.0, 0.0]), []);
    // The result is independent of how far away the line starts.
    assert_eq!(ts("sphere", &[1.0], [inside, -2.0, 3e3], [0.0, 1e-3, -1.5]).len(), 2);
    assert_eq!(ts("sphere", &[1.0], [1.0, -2.0, 3e3], [0.0, 1e-3, -1.5]).len(), 0);
}

#[test]
fn rims_and_edges_grazed_leave_nothing() {
    assert_eq!(ts("cylinder", &[1.0, 0.0, 4.0], [-3.0, 0.0, 2.0], [1.0, 0.0, 1.0]), []);
    assert_eq!(ts("cylinder", &[1.0, 0.0, 4.0], [-3.0, 0.0, 4.0], [1.0, 0.0, 0.0]), []);
    assert_eq!(ts("paraboloid", &[1.0, 0.0, 4.0], [-3.0, 0.0, 0.0], [1.0, 0.0, 0.0]), []);
}

#[test]
fn solids_without_end_are_open_there() {
    let inf = f64::INFINITY;
    let plane_z = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, -2.0];
    assert_eq!(ts("quadric", &plane_z, [0.0, 0.0, 0.0], [0.0, 0.0, 1.0]), [-inf, 2.0]);
    assert_eq!(ts("quadric", &plane_z, [0.0, 0.0, 0.0], [1.0, 0.0, 0.0]), [-inf, inf]);
    assert_eq!(ts("quadric", &plane_z, [0.0, 0.0, 2.0], [1.0, 0.0, 0.0]), []);
    let outside_sphere = [-1.0, -1.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    assert_eq!(ts("quadric", &outside_sphere, [0.0, 0.0, 0.0], [0.0, 2.0, 0.0]), [-inf, -0.5, 0.5, inf]);
    assert_eq!(ts("quadric", &outside_sphere, [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]), [-inf, inf]);
}

#[test]
fn either_sheet_or_both_are_met() {
    let (o, d) = ([0.0, 0.0, -5.0], [0.0, 0.0, 1.0]);
    assert_eq!(ts("hyperboloid2", &[1.0, 1.0, -3.0, 3.0], o, d), [2.0, 4.0, 6.0, 8.0]);
    assert_eq!(ts("hyperboloid2", &[1.0, 1.0, -0.5, 3.0], o, d), [6.0, 8.0]);
    assert_eq!(ts("hyperboloid2", &[1.0, 1.0, -3.0, -2.0], o, d), [2.0, 3.0]);
}

#[test]
fn parameters_that_make_no_solid_are_refused() {
    let refused = |name: &str, numbers: &[f64]| build(name, numbers).unwrap_err().param;
    assert_eq!(refused("sphere", &[0.0]), "radius");
    assert_eq!(refused("ellipsoid", &[1.0, 0.0, 2.0]), "semi_axes");
    assert_eq!(refused("cylinder", &[1.0, 2.0, 2.0]), "z1");
    assert_eq!(refused("cone", &[0.0, 0.0, 0.0, 1.0]), "r1");
    assert_eq!(refused("cone", &[1.0, -1.0, 0.0, 1.0]), "r1");
    assert_eq!(refused("hyperboloid2", &[1.0, 1.0, -1.0, 1.0]), "z1");
    assert_eq!(refused("quadric", &[0.0; 10]), "coeffs");
    assert_eq!(refused("quadric", &[f64::NAN; 10]), "coeffs");
}

/// Scaling solid and line by a power of two preserves every bit of `t`. Only for kinds whose parameters are all
/// lengths.
#[test]
fn powers_of_two_scale_the_scene_exactly() {
    let line = Line::exact(Vec3::new(3.1, -4.2, 5.3), Vec3::new(-0.61, 0.85, -1.04));
    let has_lengths_only = |kind: &&&Kind| kind.params.iter().all(|p| p.quantity == Quantity::Length);
    let is_single = |kind: &&&Kind| matches!(kind.build, Build::Solid(_));
    for kind in KINDS.iter().filter(has_lengths_only).filter(is_single) {
        for example in kind.examples {
            let scaled = |factor: f64| {
                let numbers: Vec<Vec<f64>> =
                    example.iter().map(|value| value.iter().map(|x| x * factor).collect()).collect();
                let values: Vec<&[f64]> = numbers.iter().map(Vec::as_slice).collect();
                let parts = kind.build(&Params::of(kind, &values)).unwrap();
                let solid = parts.single().unwrap();
                let mut list = Vec::new();
                solid.crossings(&Line::exact(line.o * factor, line.d * factor), &mut list);
                list
            };
            for k in [-300, -1, 33, 300] {
                assert_eq!(scaled(2f64.powi(k)), scaled(1.0), "{} {example:?} by 2^{k}", kind.name);
            }
        }
    }
}

#[test]
fn extreme_directions_give_sound_lists() {
    let sphere = build("sphere", &[1.0]).unwrap();
    for exponent in [-1074, -1022, -600, 600, 1023] {
        let d = libm::ldexp(1.0, exponent);
        let list = cast(&*sphere, [0.0, 0.25, 0.0], [d, 0.0, 0.0]);
        assert_eq!(list.len(), 2, "2^{exponent}: {list:?}");
        assert!(list.iter().all(|c| !c.t.is_nan() && !c.t_err.is_nan()), "2^{exponent}: {list:?}");
    }
    assert_eq!(cast(&*sphere, [1e300, 0.0, 0.0], [0.0, 0.0, 1.0]), []);
}
