//! Kinds that are parts of other solids, against their interiors as formulas.

use super::{Kind, Params, kind};
use crate::compile::{Options, compile};
use crate::math::Vec3;
use crate::query::Caster;
use crate::ray::{Ray, Span};
use crate::scene::Scene;
use crate::testkit::random::Random;

/// The interior of a kind at a point: the numbers of its parameters in their order, in radians where they are angles.
type Interior = fn(&[f64], Vec3) -> bool;

fn sector(p: Vec3, phi0: f64, dphi: f64) -> bool {
    let turn = p.y.atan2(p.x) - phi0.to_radians();
    turn.rem_euclid(std::f64::consts::TAU) < dphi.to_radians() || dphi == 360.0
}

fn between(x: f64, low: f64, high: f64) -> bool {
    low < x && x < high
}

fn linear(z: f64, [z0, z1]: [f64; 2], [a, b]: [f64; 2]) -> f64 {
    a + (b - a) * (z - z0) / (z1 - z0)
}

const INTERIORS: &[(&str, Interior)] = &[
    ("cone_section", |n, p| {
        let z = [n[4], n[5]];
        let (low, high) = (linear(p.z, z, [n[0], n[2]]), linear(p.z, z, [n[1], n[3]]));
        between(p.z, z[0], z[1]) && between(p.x.hypot(p.y), low, high) && sector(p, n[6], n[7])
    }),
    ("cut_tube", |n, p| {
        let [low, high] = [4, 7].map(|i| Vec3::new(n[i], n[i + 1], n[i + 2]));
        let behind = |normal: Vec3, z: f64| normal.dot(p - Vec3::Z * z) < 0.0;
        between(p.x.hypot(p.y), n[0], n[1])
            && behind(low, n[2])
            && behind(high, n[3])
            && sector(p, n[10], n[11])
    }),
    ("ellipsoid_section", |n, p| {
        let scaled = p / Vec3::new(n[0], n[1], n[2]);
        scaled.length() < 1.0 && between(p.z, n[3], n[4])
    }),
    ("elliptical_cone", |n, p| {
        (p.x / n[0]).hypot(p.y / n[1]) < (n[3] - p.z) / n[2] && between(p.z, n[4], n[5])
    }),
    ("elliptical_cylinder", |n, p| (p.x / n[0]).hypot(p.y / n[1]) < 1.0 && between(p.z, n[2], n[3])),
    ("hyperboloid_shell", |n, p| {
        let wall = |r: f64, stereo: f64| r.hypot(p.z * stereo.to_radians().tan());
        between(p.x.hypot(p.y), wall(n[0], n[2]), wall(n[1], n[3])) && between(p.z, n[4], n[5])
    }),
    ("paraboloid_section", |n, p| {
        let square = linear(p.z, [n[2], n[3]], [n[0] * n[0], n[1] * n[1]]);
        p.x * p.x + p.y * p.y < square && between(p.z, n[2], n[3])
    }),
    ("sphere_section", |n, p| {
        let theta = p.x.hypot(p.y).atan2(p.z).to_degrees();
        between(p.length(), n[0], n[1]) && sector(p, n[2], n[3]) && between(theta, n[4], n[4] + n[5])
    }),
    ("torus_section", |n, p| {
        let tube = (p.x.hypot(p.y) - n[0]).hypot(p.z);
        between(tube, n[1], n[2]) && sector(p, n[3], n[4])
    }),
];

fn numbers(kind: &Kind, params: &Params) -> Vec<f64> {
    let number =
        |name: &str| params.entries.iter().find(|(n, _)| *n == name).map(|(_, numbers)| numbers.to_vec());
    kind.params.iter().filter_map(|param| number(param.name)).flatten().collect()
}

#[test]
fn interiors_are_those_of_the_formulas() {
    let mut random = Random::new(301);
    for (name, interior) in INTERIORS {
        let kind = kind(name).expect("a kind");
        for example in kind.examples {
            let params = Params::of(kind, example);
            let (parts, numbers) = (kind.build(&params).expect("an example"), numbers(kind, &params));
            let mut inside = 0;
            for _ in 0..20_000 {
                let p = random.point(-2.5, 2.5);
                let expected = interior(&numbers, p);
                inside += usize::from(expected);
                assert_eq!(parts.contains(p), expected, "{name} {example:?} at {p}");
                assert!(
                    !expected || parts.bounds().contains(p),
                    "{name} {example:?}: {p} {:?}",
                    parts.bounds()
                );
            }
            assert!(inside > 20, "{name} {example:?}: {inside}");
        }
    }
}

#[test]
fn parameters_out_of_range_are_named() {
    let error = |name: &str, values: &[&[f64]]| {
        let kind = kind(name).expect("a kind");
        kind.build(&Params::of(kind, values)).expect_err("an error").to_string()
    };
    let z = [0.0, 0.0, 1.0];
    for (name, values, expected) in [
        ("cone_section", &[&[1.0][..], &[1.0], &[2.0], &[2.0], &[0.0], &[1.0]][..], "rmax1: is 2 like rmin1"),
        (
            "cone_section",
            &[&[1.0], &[0.5], &[2.0], &[2.0], &[0.0], &[1.0]],
            "rmax0: is 0.5, but must be at least rmin0 = 1",
        ),
        (
            "cut_tube",
            &[&[0.0], &[1.0], &[0.0], &[1.0], &z, &z],
            "normal0: is [0, 0, 1], but its z must be negative",
        ),
        ("ellipsoid_section", &[&[1.0, 1.0, 1.0], &[1.0], &[2.0]], "z0: is 1, which is beyond the end"),
        (
            "elliptical_cone",
            &[&[1.0], &[1.0], &[1.0], &[0.5], &[0.0], &[1.0]],
            "apex: is 0.5, but must be at least z1 = 1",
        ),
        ("hyperboloid_shell", &[&[0.5], &[1.0], &[0.0], &[90.0], &[0.0], &[1.0]], "stereo_max: is 90, but"),
        (
            "sphere_section",
            &[&[0.0], &[1.0], &[0.0], &[360.0], &[90.0], &[91.0]],
            "dtheta: is 91, but with theta0 = 90 it must be at most 90",
        ),
        ("torus_section", &[&[1.0], &[0.5], &[1.5]], "R: is 1, but must be at least rmax = 1.5"),
    ] {
        let found = error(name, values);
        assert!(found.starts_with(expected), "{found}");
    }
}

/// The crossings of a solid of a kind along a ray, each with its bound.
fn crossings(name: &str, values: &[&[f64]], o: [f64; 3], d: [f64; 3]) -> Vec<(f64, f64)> {
    let mut scene = Scene::default();
    let node = scene.add_solid(name, values).expect("a kind");
    scene.add_object("it", None, node);
    let world = compile(&scene, Options::default()).expect("a world");
    let (ray, mut hits) = (Ray::new(o.into(), d.into()).expect("a ray"), Vec::new());
    Caster::new(&world).crossings(&ray, Span::FORWARD, &mut hits).expect("within limits");
    hits.iter().map(|hit| (hit.t, hit.t_err)).collect()
}

/// The offset of the tilted plane from the origin was rounded, and a ray that grazes it was wrong by 2e8 bounds.
#[test]
fn tilted_planes_are_about_their_points() {
    let tube: [&[f64]; 6] = [&[0.0], &[1.0], &[-1.1], &[1.0], &[0.7, -0.7, -2.7], &[0.0, 0.0, 1.0]];
    let grazing =
        crossings("cut_tube", &tube, [-4.0, -4.0, -1.1000000037252904], [1.0, 1.0, 9.313225746154785e-10]);
    let (t, t_err) = grazing[0];
    assert!((t - 4.0).abs() <= t_err, "{grazing:?}");
    assert_eq!(crossings("cut_tube", &tube, [-4.0, -4.0, -1.1], [1.0, 1.0, 0.0]), []);
}

/// The tangent of the stereo angle was rounded twice, and a ray that grazes the shell was wrong by 1.7e7 bounds.
#[test]
fn tangents_of_angles_are_wide() {
    let shell: [&[f64]; 6] = [
        &[0.5],
        &[1.0653527578795332],
        &[0.0],
        &[61.01122460424313],
        &[-1.041720302164839],
        &[1.6597814297979911],
    ];
    let o = [-1.078609540327861, 4.078905995710889, 1.5652432058397419];
    let d = [0.7823252631690877, -0.6162321647057788, -0.09069234691773963];
    let found = crossings("hyperboloid_shell", &shell, o, d);
    let near = |t: f64| found.iter().any(|(found, t_err)| (found - t).abs() <= 1e-12 + 8.0 * t_err);
    assert!(near(2.999999905111) && near(2.999999992661), "{found:?}");
}
