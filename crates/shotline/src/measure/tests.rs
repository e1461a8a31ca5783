//! Known results, and whether the reported errors are right.

use std::f64::consts::PI;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use super::*;
use crate::accel::NAMES;
use crate::compile::{Options, compile};
use crate::math::{Affine, Vec3};
use crate::scene::{Material, Node, NodeId, Op};
use crate::solid::mesh::shapes::{ball, sheet};

pub(super) fn world(scene: &Scene) -> World {
    compile(scene, Options::default()).unwrap_or_else(|e| panic!("{e:?}"))
}

pub(super) fn all(scene: &Scene, settings: &Settings) -> Result<Vec<Measure>, MeasureError> {
    measure(&world(scene), scene, settings, Run::default())
}

pub(super) fn rays(rays: usize, seed: u64) -> Settings {
    Settings { rays, seed, method: Method::Rays, ..Settings::default() }
}

pub(super) fn solid(scene: &mut Scene, kind: &str, values: &[&[f64]]) -> NodeId {
    scene.add_solid(kind, values).unwrap()
}

pub(super) fn at(scene: &mut Scene, node: NodeId, place: [f64; 3]) -> NodeId {
    scene.add_transform(Affine::translation(Vec3::from(place)), node)
}

/// A scene of one object.
pub(super) fn one(build: impl FnOnce(&mut Scene) -> NodeId) -> Scene {
    let mut scene = Scene::default();
    let node = build(&mut scene);
    scene.add_object("it", None, node);
    scene
}

/// Objects with closed forms, to be measured by rays.
fn known() -> Vec<(&'static str, Scene)> {
    let turn = Affine::rotation_xyz(Vec3::new(20.0, 50.0, -10.0));
    let turned = move |kind: &'static str, values: &'static [&'static [f64]]| {
        one(move |scene| {
            let solid = solid(scene, kind, values);
            scene.add_transform(turn, solid)
        })
    };
    vec![
        ("ball", one(|s| solid(s, "sphere", &[&[1.0]]))),
        ("brick", turned("box", &[&[-1.0, 0.0, 2.0], &[1.0, 0.5, 5.0]])),
        ("sheet", turned("box", &[&[0.0, 0.0, 0.0], &[1.0, 1.0, 0.003]])),
        ("cone", turned("cone", &[&[1.0], &[0.2], &[-3.0], &[2.0]])),
        ("ring", turned("torus", &[&[1.0], &[0.3]])),
        ("wire", turned("torus", &[&[1.0], &[0.02]])),
        ("mesh", one(|s| s.add(Node::Mesh { mesh: Arc::new(ball(2)), file: None }))),
        ("far", {
            one(|scene| {
                let (a, b) = (solid(scene, "sphere", &[&[0.1]]), solid(scene, "sphere", &[&[0.2]]));
                let b = at(scene, b, [3.0, 2.0, 1.0]);
                scene.add(Node::Group { members: vec![a, b] })
            })
        }),
    ]
}

fn values(m: &Measure) -> Vec<Estimate> {
    let i = &m.inertia;
    [m.volume]
        .into_iter()
        .chain(m.centroid)
        .chain([i[0][0], i[1][1], i[2][2], i[1][2], i[0][2], i[0][1]])
        .collect()
}

/// The error is not a bound: of fifteen degrees of freedom, Student's distribution has 0.9 % beyond three and less than
/// one in 10^4 beyond six. There are ten values for each of sixty seeds of each shape; the values of one seed are
/// correlated.
#[test]
fn errors_are_what_they_are_said_to_be() {
    let (mut beyond, mut worst, mut count) = (0, 0.0f64, 0);
    for (name, scene) in known() {
        let world = world(&scene);
        let measure = |settings: &Settings| measure(&world, &scene, settings, Run::default()).unwrap()[0];
        let exact = measure(&Settings::default());
        assert!(exact.exact && exact.rays == 0, "{name}");
        let mut errors = 0.0;
        for seed in 0..60 {
            let found = measure(&rays(9600, seed));
            assert!(!found.exact && found.rays == 9600);
            for (estimate, truth) in values(&found).iter().zip(values(&exact)) {
                let off = (estimate.value - truth.value).abs() / estimate.std_error;
                (worst, count) = (worst.max(off), count + 1);
                beyond += usize::from(off > 3.0);
            }
            errors += found.volume.std_error / exact.volume.value;
        }
        // Errors that are right only because they are large would be useless.
        assert!(errors / 60.0 < 0.05, "{name}: {}", errors / 60.0);
    }
    assert!(count == 4800 && beyond * 100 <= 2 * count && worst < 6.5, "{beyond} of {count}, {worst}");
}

#[test]
fn more_rays_see_more_than_by_the_root_of_their_number() {
    let scene = one(|s| solid(s, "sphere", &[&[1.0]]));
    let error = |n: usize| all(&scene, &rays(n, 1)).unwrap()[0].volume.std_error;
    assert!(error(96_000) < error(960) / 30.0);
}

#[test]
fn what_rays_hardly_meet_is_not_told_as_certain() {
    // A wire that fills its box from corner to corner: no edge shows where it is.
    let wire = one(|scene| {
        let ring = solid(scene, "torus", &[&[1.0], &[1e-9]]);
        scene.add_transform(Affine::rotation_xyz(Vec3::new(20.0, 50.0, -10.0)), ring)
    });
    let found = all(&wire, &rays(4800, 0)).unwrap()[0];
    assert!(found.volume.value == 0.0 && found.volume.std_error > 1e-4, "{found:?}");
    assert!(found.centroid[0].value.is_nan() && found.inertia[0][1].value.is_nan());
    // A small part that few rays meet.
    let (_, far) = known().pop().unwrap();
    let truth = values(&all(&far, &Settings::default()).unwrap()[0]);
    for seed in 0..100 {
        let found = values(&all(&far, &rays(960, seed)).unwrap()[0]);
        let sure = |(e, t): (&Estimate, &Estimate)| (e.value - t.value).abs() < 6.0 * e.std_error;
        assert!(found.iter().zip(&truth).all(sure), "{seed}: {found:?} {truth:?}");
    }
}

#[test]
fn combinations_have_the_volumes_of_textbooks() {
    // The rest of a ball around a hole of length 6, whatever its radius, has the volume of a ball of diameter 6.
    let napkin_ring = one(|scene| {
        let (ball, hole) =
            (solid(scene, "sphere", &[&[5.0]]), solid(scene, "cylinder", &[&[4.0], &[-9.0], &[9.0]]));
        scene.add_csg(Op::Difference, vec![ball, hole])
    });
    // The solid of Archimedes and Steinmetz: two perpendicular cylinders of radius 1.
    let steinmetz = one(|scene| {
        let upright = solid(scene, "cylinder", &[&[1.0], &[-2.0], &[2.0]]);
        let lying = scene.add_transform(Affine::rotation_xyz(Vec3::new(90.0, 0.0, 0.0)), upright);
        scene.add_csg(Op::Intersection, vec![upright, lying])
    });
    for (scene, volume) in [(napkin_ring, 36.0 * PI), (steinmetz, 16.0 / 3.0)] {
        let found = all(&scene, &Settings::default()).unwrap()[0];
        assert!(!found.exact && found.volume.std_error < 1e-3 * volume, "{found:?}");
        assert!((found.volume.value - volume).abs() < 5.0 * found.volume.std_error, "{found:?}");
        assert!(found.centroid.iter().all(|c| c.value.abs() < 5.0 * c.std_error), "{found:?}");
    }
}

#[test]
fn bodies_of_one_object_that_overlap_count_once() {
    let scene = one(|scene| {
        let cube = solid(scene, "box", &[&[0.0; 3], &[1.0; 3]]);
        let other = at(scene, cube, [0.5, 0.0, 0.0]);
        scene.add(Node::Group { members: vec![cube, other] })
    });
    let found = all(&scene, &Settings::default()).unwrap()[0];
    assert!(!found.exact && (found.volume.value - 1.5).abs() < 1e-12, "{found:?}");
}

#[test]
fn shared_parts_count_wherever_they_are_placed() {
    // Balls in rows of ten, in rows of rows: 10^12 of them in each object.
    let mut scene = Scene::default();
    let mut node = solid(&mut scene, "sphere", &[&[0.4]]);
    for i in 0..12 {
        let mut step = [0.0; 3];
        step[i % 3] = 10f64.powi(i as i32 / 3);
        let members = (0..10).map(|k| at(&mut scene, node, step.map(|x| x * f64::from(k)))).collect();
        node = scene.add(Node::Group { members });
    }
    scene.materials.push(("iron".into(), Material { density: Some(8.0), ..Material::default() }));
    let far = at(&mut scene, node, [2e4, 0.0, 0.0]);
    scene.add_object("here", Some("iron"), node);
    scene.add_object("there", None, far);
    let [here, there] = all(&scene, &Settings::default()).unwrap()[..] else { panic!("two objects") };
    let volume = 1e12 * 4.0 / 3.0 * PI * 0.064;
    assert!(here.exact && (here.volume.value / volume - 1.0).abs() < 1e-12, "{here:?}");
    assert!((here.mass.unwrap().value / volume / 8.0 - 1.0).abs() < 1e-12 && there.mass.is_none());
    assert!((here.centroid[2].value - 4999.5).abs() < 1e-9, "{here:?}");
    // Spread evenly over a cube of 10^4: a twelfth of the square of the side along either axis across.
    let spread = (1e8 - 1.0) / 6.0 + 0.4 * 0.16;
    assert!((here.inertia[0][0].value / volume / spread - 1.0).abs() < 1e-12, "{here:?}");
    assert!((there.centroid[0].value - here.centroid[0].value - 2e4).abs() < 1e-9);
}

#[test]
fn rays_that_meet_too_much_are_an_error() {
    // Boxes of balls that overlap: rays are needed, and they meet too many balls.
    let mut scene = Scene::default();
    let mut node = solid(&mut scene, "sphere", &[&[1.0]]);
    for _ in 0..40 {
        let other = at(&mut scene, node, [0.125, 0.0, 0.0]);
        node = scene.add(Node::Group { members: vec![node, other] });
    }
    scene.add_object("swarm", None, node);
    let run = Run { most_rows: 100_000, ..Run::default() };
    let error = measure(&world(&scene), &scene, &rays(48, 0), run).unwrap_err();
    assert_eq!(error, MeasureError::TooMany { object: "swarm".into(), rays: 0 });
}

#[test]
fn the_first_rays_tell_how_many_can_be_afforded() {
    let mut scene = Scene::default();
    let mut node = solid(&mut scene, "sphere", &[&[1.0]]);
    for _ in 0..11 {
        let other = at(&mut scene, node, [0.0, 0.0, 0.01]);
        node = scene.add(Node::Group { members: vec![node, other] });
    }
    scene.add_object("swarm", None, node);
    let (world, run) = (world(&scene), Run { most_rows: 3_000_000, ..Run::default() });
    let error = measure(&world, &scene, &rays(1 << 16, 0), run).unwrap_err();
    let MeasureError::TooMany { rays: affordable, .. } = error else { panic!("{error}") };
    assert!((480..5000).contains(&affordable), "{affordable}");
    assert!(measure(&world, &scene, &rays(affordable, 0), run).is_ok());
}

#[test]
fn the_same_bits_for_any_threads_and_accelerator() {
    let mut scene = Scene::default();
    let ball = solid(&mut scene, "sphere", &[&[1.0]]);
    let members =
        (0..20).map(|i| at(&mut scene, ball, [0.7 * f64::from(i), 0.3, f64::from(i % 3)])).collect();
    let group = scene.add(Node::Group { members });
    scene.add_object("balls", None, group);
    let bits = |accel: &'static str, threads: usize, objects: Option<Vec<u32>>| {
        let world = compile(&scene, Options { accel: Some(accel) }).unwrap();
        let settings = Settings { objects, ..rays(10_000, 7) };
        let cast = AtomicU64::new(0);
        let progress = |rays| _ = cast.fetch_add(rays, Ordering::Relaxed);
        let run = Run { threads, progress: Some(&progress), ..Run::default() };
        let found = measure(&world, &scene, &settings, run).unwrap();
        assert_eq!(cast.into_inner(), found[0].rays as u64);
        format!("{found:?}")
    };
    let first = bits("brute", 1, None);
    for accel in NAMES {
        assert_eq!(bits(accel, 3, Some(vec![0])), first, "{accel}");
    }
}

#[test]
fn what_cannot_be_measured_is_an_error_at_once() {
    let mut scene = Scene::default();
    let ball = solid(&mut scene, "sphere", &[&[1.0]]);
    let ground = solid(&mut scene, "halfspace", &[&[0.0, 0.0, 1.0], &[0.0]]);
    let open = scene.add(Node::Mesh { mesh: Arc::new(sheet(2)), file: None });
    for (name, node) in [("ball", ball), ("ground", ground), ("open", open)] {
        scene.add_object(name, None, node);
    }
    let only = |objects: &[u32]| Settings { objects: Some(objects.to_vec()), ..Settings::default() };
    let error = all(&scene, &only(&[2])).unwrap_err();
    assert!(matches!(&error, MeasureError::Query(QueryError::NotASolid { object, .. }) if object == "open"));
    assert_eq!(all(&scene, &only(&[3])), Err(MeasureError::NoObject { object: 3, count: 3 }));
    // Other objects are not affected.
    let by_rays = Settings { method: Method::Rays, ..only(&[0]) };
    assert!(all(&scene, &by_rays).unwrap()[0].volume.value > 4.0);
    assert_eq!(all(&scene, &only(&[])), Ok(vec![]));
    let cancel = AtomicBool::new(true);
    let run = Run { cancel: Some(&cancel), ..Run::default() };
    assert_eq!(measure(&world(&scene), &scene, &by_rays, run), Err(MeasureError::Cancelled));
}

#[test]
fn nothing_has_no_volume() {
    let scene = one(|scene| {
        let ball = solid(scene, "sphere", &[&[1.0]]);
        let away = at(scene, ball, [3.0, 0.0, 0.0]);
        scene.add_csg(Op::Intersection, vec![ball, away])
    });
    let found = all(&scene, &Settings::default()).unwrap()[0];
    assert!(found.exact && found.volume == Estimate::default() && found.centroid[1].value.is_nan());
}

#[test]
fn an_object_without_an_end_does_not_stop_the_others() {
    let mut scene = Scene::default();
    let ground = solid(&mut scene, "halfspace", &[&[0.0, 0.0, 1.0], &[0.0]]);
    let ball = solid(&mut scene, "sphere", &[&[1.0]]);
    scene.add_object("ground", None, ground);
    scene.add_object("ball", None, ball);
    let found = all(&scene, &Settings::default()).unwrap();
    assert!(found[0].is_unbounded() && found[0].volume.value.is_nan() && !found[0].exact, "{found:?}");
    assert!(!found[1].is_unbounded() && found[1].exact && found[1].volume.value > 4.0, "{found:?}");
}

/// Half-spaces by normal and offset, and boxes, in one intersection under a transform.
fn polytope(planes: &[([f64; 3], f64)], boxes: &[[[f64; 3]; 2]], map: Affine) -> Measure {
    let scene = one(|scene| {
        let mut args: Vec<NodeId> =
            planes.iter().map(|(n, offset)| solid(scene, "halfspace", &[n, &[*offset]])).collect();
        args.extend(boxes.iter().map(|[min, max]| solid(scene, "box", &[min, max])));
        let node = scene.add_csg(Op::Intersection, args);
        scene.add_transform(map, node)
    });
    all(&scene, &Settings::default()).unwrap()[0]
}

#[test]
fn polytopes_of_half_spaces_are_measured_exactly() {
    let signs = [1.0, -1.0];
    let normals = signs.iter().flat_map(|x| signs.iter().flat_map(move |y| signs.map(|z| [*x, *y, z])));
    let octahedron: Vec<_> = normals.map(|n| (n, 1.0)).collect();
    let corner = [([-1.0, 0.0, 0.0], 0.0), ([0.0, -1.0, 0.0], 0.0), ([0.0, 0.0, -1.0], 0.0), ([1.0; 3], 1.0)];
    let half_box = [([1.0, 1.0, 0.0], 0.0)];
    let turn = Affine::rotation_xyz(Vec3::new(20.0, 50.0, -10.0));
    for size in [1.0, 1e-60, 1e60] {
        let map = Affine::translation(Vec3::splat(size))
            .then_after(&turn)
            .then_after(&Affine::scaling(Vec3::new(size, 2.0 * size, size)));
        for map in [Affine::IDENTITY, map] {
            let growth = map.determinant();
            let cases: [(Measure, f64, f64); 3] = [
                (polytope(&octahedron, &[], map), 4.0 / 3.0, 0.0),
                (polytope(&corner, &[], map), 1.0 / 6.0, 0.25),
                (polytope(&half_box, &[[[-1.0; 3], [1.0; 3]]], map), 4.0, -1.0 / 3.0),
            ];
            for (found, volume, x) in cases {
                assert!(found.exact && found.volume.std_error == 0.0, "{found:?}");
                assert!((found.volume.value / (volume * growth) - 1.0).abs() < 1e-13, "{found:?}");
                let z = if volume == 4.0 { 0.0 } else { x };
                let centroid = map.point(Vec3::new(x, x, z));
                let off = (found.centroid[0].value - centroid.x).abs();
                assert!(off <= 1e-13 * map.vector(Vec3::ONE).abs().max_element(), "{found:?}");
            }
        }
    }
    // The inertia of an octahedron: m / 5 about each axis, for corners at 1.
    let inertia = polytope(&octahedron, &[], Affine::IDENTITY).inertia;
    assert!((inertia[2][2].value - 4.0 / 15.0).abs() < 1e-15 && inertia[0][1].value.abs() < 1e-16);
}

#[test]
fn a_half_space_taken_away_leaves_a_polytope() {
    let scene = one(|scene| {
        let brick = solid(scene, "box", &[&[0.0; 3], &[1.0; 3]]);
        let above = solid(scene, "halfspace", &[&[-1.0, -1.0, -1.0], &[-1.0]]);
        scene.add_csg(Op::Difference, vec![brick, above])
    });
    let found = all(&scene, &Settings::default()).unwrap()[0];
    assert!(found.exact && (found.volume.value - 1.0 / 6.0).abs() < 1e-15, "{found:?}");
}

#[test]
fn ellipsoids_given_as_quadrics_are_exact_and_cylinders_between_planes_have_a_volume() {
    // x^2 + xy + y^2 + z^2 - 2z < 0: a ball of radius 1 about (0, 0, 1), stretched by 2 / sqrt(3).
    let coeffs = [1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, -2.0, 0.0];
    let scene = one(|s| solid(s, "quadric", &[&coeffs]));
    let found = all(&scene, &Settings::default()).unwrap()[0];
    let volume = 4.0 / 3.0 * PI * 2.0 / 3f64.sqrt();
    assert!(found.exact && (found.volume.value / volume - 1.0).abs() < 1e-14, "{found:?}");
    assert!((found.centroid[2].value - 1.0).abs() < 1e-15);
    let pin = one(|s| {
        let side = [1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0];
        let side = solid(s, "quadric", &[&side]);
        let top = solid(s, "halfspace", &[&[0.1, 0.2, 1.0], &[1.0]]);
        let bottom = solid(s, "halfspace", &[&[0.0, 0.3, -1.0], &[1.0]]);
        s.add_csg(Op::Intersection, vec![side, top, bottom])
    });
    let found = all(&pin, &rays(48_000, 1)).unwrap()[0];
    assert!((found.volume.value - 2.0 * PI).abs() < 5.0 * found.volume.std_error, "{found:?}");
    assert!(found.volume.std_error < 0.01);
}

#[test]
fn a_volume_that_overflows_or_underflows_is_an_error() {
    for (size, range) in [(1e120, Range::TooLarge), (1e-110, Range::TooSmall)] {
        let whole = one(|s| solid(s, "sphere", &[&[size]]));
        let bitten = one(|s| {
            let ball = solid(s, "sphere", &[&[size]]);
            let bite = solid(s, "box", &[&[0.0; 3], &[size; 3]]);
            s.add_csg(Op::Difference, vec![ball, bite])
        });
        let map = Affine::scaling(Vec3::splat(size));
        let mesh = Arc::new(ball(1).moved(&map));
        let mesh = one(|s| s.add(Node::Mesh { mesh, file: None }));
        for scene in [whole, bitten, mesh] {
            let error = all(&scene, &Settings::default()).unwrap_err();
            let is_so = matches!(error, MeasureError::OutOfRange { range: found, .. } if found == range);
            assert!(is_so && error.to_string().contains("other units of length"), "{error}");
        }
    }
}
