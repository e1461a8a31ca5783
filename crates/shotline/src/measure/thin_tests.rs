//! Thin parts that rays along some axis miss or hardly meet: errors must be right, and small enough to be useful.

use std::f64::consts::PI;
use std::sync::Arc;

use super::tests::{all, at, one, rays, solid, world};
use super::*;
use crate::math::{Affine, Vec3};
use crate::scene::{Node, NodeId, Op};
use crate::solid::mesh::TriangleMesh;
use crate::solid::mesh::shapes::ball;

/// A thin object, its volume, and the largest allowed error.
struct Case {
    name: &'static str,
    scene: Scene,
    truth: f64,
    /// The largest mean standard error, as a fraction of the true volume.
    most: f64,
}

fn brick(s: &mut Scene, min: [f64; 3], max: [f64; 3]) -> NodeId {
    solid(s, "box", &[&min, &max])
}

fn mesh(s: &mut Scene, mesh: TriangleMesh) -> NodeId {
    s.add(Node::Mesh { mesh: Arc::new(mesh), file: None })
}

fn minus(s: &mut Scene, a: NodeId, b: NodeId) -> NodeId {
    s.add_csg(Op::Difference, vec![a, b])
}

fn sheet_and_post(s: &mut Scene) -> NodeId {
    let sheet = brick(s, [0.0; 3], [1000.0, 1000.0, 0.001]);
    let post = brick(s, [0.0; 3], [0.001, 0.001, 1000.0]);
    s.add_csg(Op::Union, vec![sheet, post])
}

fn foil(s: &mut Scene) -> NodeId {
    let outside = brick(s, [0.0; 3], [1.0; 3]);
    let inside = brick(s, [1e-5; 3], [1.0 - 1e-5; 3]);
    minus(s, outside, inside)
}

fn drilled(s: &mut Scene) -> NodeId {
    let block = brick(s, [-1.0; 3], [1.0; 3]);
    let hole = solid(s, "cylinder", &[&[0.001], &[-2.0], &[2.0]]);
    minus(s, block, hole)
}

fn bubble(s: &mut Scene) -> NodeId {
    let (outside, inside) = (solid(s, "sphere", &[&[1.0]]), solid(s, "sphere", &[&[1.0 - 1e-5]]));
    minus(s, outside, inside)
}

fn tube(s: &mut Scene) -> NodeId {
    let outside = solid(s, "cylinder", &[&[1.0], &[-1.0], &[1.0]]);
    let inside = solid(s, "cylinder", &[&[1.0 - 1e-5], &[-1.0], &[1.0]]);
    minus(s, outside, inside)
}

fn plate(s: &mut Scene) -> NodeId {
    let side = solid(s, "cylinder", &[&[1.0], &[-1.0], &[1.0]]);
    let top = solid(s, "halfspace", &[&[0.0, 0.0, 1.0], &[5e-6]]);
    let bottom = solid(s, "halfspace", &[&[0.0, 0.0, -1.0], &[5e-6]]);
    s.add_csg(Op::Intersection, vec![side, top, bottom])
}

fn inner_tube(s: &mut Scene) -> NodeId {
    let (outside, inside) =
        (solid(s, "torus", &[&[1.0], &[0.3]]), solid(s, "torus", &[&[1.0], &[0.3 - 1e-6]]));
    minus(s, outside, inside)
}

fn mesh_foil(s: &mut Scene) -> NodeId {
    let (outside, inside) = (ball(3), ball(3).moved(&Affine::scaling(Vec3::splat(0.99999))));
    let (outside, inside) = (mesh(s, outside), mesh(s, inside));
    minus(s, outside, inside)
}

/// A mesh of two specks far from each other, combined with a ball.
fn specks(s: &mut Scene) -> NodeId {
    let speck = |x: f64| {
        let small = ball(2).moved(&Affine::scaling(Vec3::splat(1e-4)));
        small.moved(&Affine::translation(Vec3::new(x, x, -x)))
    };
    let specks = mesh(s, speck(-1.0).with(&speck(1.0)));
    let middle = solid(s, "sphere", &[&[1e-4]]);
    let ball = at(s, middle, [0.5, -0.5, 0.0]);
    s.add_csg(Op::Union, vec![specks, ball])
}

/// Many balls that touch, and a long thin post between them.
fn crowd(s: &mut Scene) -> NodeId {
    let one = solid(s, "sphere", &[&[0.5]]);
    let mut members: Vec<NodeId> =
        (0..512).map(|i| at(s, one, [f64::from(i % 8), f64::from(i / 8 % 8), f64::from(i / 64)])).collect();
    members.push(brick(s, [0.4999, 0.4999, -1.0], [0.5001, 0.5001, 100.0]));
    s.add_csg(Op::Union, members)
}

fn cases() -> Vec<Case> {
    let sphere = 4.0 / 3.0 * PI;
    let gone = 1.0 - (1.0 - 1e-5f64).powi(3);
    let polyhedron = |n: u32| all(&one(|s| mesh(s, ball(n))), &Settings::default()).unwrap()[0].volume.value;
    let wall = 1.0 - (1.0 - 2e-5f64).powi(3);
    type Build = fn(&mut Scene) -> NodeId;
    let list: [(&'static str, Build, f64, f64, f64); 10] = [
        ("sheet and post", sheet_and_post, 1000.0 + 1e-6 * (1000.0 - 0.001), 1e-6, 0.1),
        ("foil", foil, wall, 1e-6, 0.1),
        ("drilled", drilled, 8.0 - 2.0 * PI * 1e-6, 1e-6, 0.1),
        ("bubble", bubble, sphere * gone, 0.1, 0.1),
        ("tube", tube, 2.0 * PI * (1.0 - (1.0 - 1e-5f64).powi(2)), 0.5, 0.1),
        ("plate", plate, PI * 1e-5, 0.1, 0.1),
        ("inner tube", inner_tube, 2.0 * PI * PI * (0.09 - (0.3 - 1e-6f64).powi(2)), 0.1, 0.1),
        ("mesh foil", mesh_foil, polyhedron(3) * gone, 0.1, 0.1),
        ("specks", specks, 1e-12 * (2.0 * polyhedron(2) + sphere), 0.1, 0.1),
        ("crowd", crowd, 512.0 * sphere / 8.0 + 101.0 * 4e-8, 0.1, 0.1),
    ];
    let turn = Affine::rotation_xyz(Vec3::new(20.0, 50.0, -10.0));
    let straight = list.iter().map(|(name, build, truth, most, _)| Case {
        name,
        scene: one(build),
        truth: *truth,
        most: *most,
    });
    let turned = list.iter().map(|(name, build, truth, _, most)| Case {
        name,
        scene: one(|s| {
            let node = build(s);
            s.add_transform(turn, node)
        }),
        truth: *truth,
        most: *most,
    });
    straight.chain(turned).collect()
}

/// Forty seeds each: the errors are right, and small enough to be useful. Rays along the axis of the tube miss it, so a
/// third of it is missing, which the error shows.
#[test]
fn thin_parts_are_found_within_their_errors() {
    let (mut beyond, mut count) = (0, 0);
    for Case { name, scene, truth, most } in cases() {
        let world = world(&scene);
        let (mut squares, mut size) = (0.0, 0.0);
        for seed in 0..40 {
            let found = measure(&world, &scene, &rays(4800, seed), Run::default()).unwrap()[0].volume;
            let off = (found.value - truth).abs() / found.std_error;
            assert!(off < 5.0, "{name}, {seed}: {found:?}, not {truth}");
            (beyond, count) = (beyond + usize::from(off > 3.0), count + 1);
            squares += off * off / 40.0;
            size += found.std_error / truth / 40.0;
        }
        assert!(squares.sqrt() < 1.5, "{name}: {}", squares.sqrt());
        assert!(size < most, "{name}: {size}");
    }
    assert!(count == 800 && beyond * 100 <= count, "{beyond} of {count}");
}

/// A later pin takes its volume from a block.
#[test]
fn a_thin_part_that_another_object_owns_is_found_too() {
    let mut scene = Scene::default();
    let block = brick(&mut scene, [-1.0; 3], [1.0; 3]);
    let pin = solid(&mut scene, "cylinder", &[&[0.001], &[-2.0], &[2.0]]);
    scene.add_object("block", None, block);
    scene.add_object("pin", None, pin);
    let truth = 8.0 - 2.0 * PI * 1e-6;
    for seed in 0..20 {
        let settings = Settings { overlaps: Overlaps::Priority, objects: Some(vec![0]), ..rays(4800, seed) };
        let found = all(&scene, &settings).unwrap()[0].volume;
        assert!((found.value - truth).abs() <= 3.0 * found.std_error && found.std_error < 1e-6, "{found:?}");
    }
}

/// Boxes and cylinders that rays along some axis miss.
#[test]
fn a_part_that_one_axis_does_not_see_is_in_the_standard_error() {
    for case in cases().iter().take(3) {
        for seed in 0..20 {
            let found = all(&case.scene, &rays(4800, seed)).unwrap()[0].volume;
            let off = (found.value - case.truth).abs();
            assert!(off <= 3.0 * found.std_error, "{}, {seed}: {found:?}, not {}", case.name, case.truth);
        }
    }
}

/// Slanted parts, whose boxes are wide, beside parts that rays meet.
#[test]
fn slanted_parts_that_no_ray_meets_are_in_the_error() {
    let turned = |s: &mut Scene, node: NodeId| {
        let turn = Affine::rotation_xyz(Vec3::new(33.0, 41.0, 0.0));
        s.add_transform(turn, node)
    };
    let rod = |s: &mut Scene, r: f64| {
        let rod = solid(s, "cylinder", &[&[r], &[-1.0], &[1.0]]);
        turned(s, rod)
    };
    let measured =
        |scene: &Scene| measure(&world(scene), scene, &rays(1 << 15, 0), Run::default()).unwrap()[0].volume;
    let beside_a_speck = one(|s| {
        let (rod, speck) = (rod(s, 1e-6), solid(s, "sphere", &[&[1e-6]]));
        let speck = at(s, speck, [9.0, 0.0, 0.0]);
        s.add_csg(Op::Union, vec![rod, speck])
    });
    let (found, truth) = (measured(&beside_a_speck), 2.0 * PI * 1e-12 + 4.0 / 3.0 * PI * 1e-18);
    assert!(
        (found.value - truth).abs() <= 3.0 * found.std_error && found.std_error < 2.0 * truth,
        "{found:?}"
    );
    for r in [1e-2, 1e-3, 1e-4, 1e-5] {
        let drilled = one(|s| {
            let (block, rod) = (brick(s, [-1.5; 3], [1.5; 3]), rod(s, r));
            minus(s, block, rod)
        });
        let (found, hole) = (measured(&drilled), 2.0 * PI * r * r);
        let off = (found.value - (27.0 - hole)).abs();
        assert!(off <= 4.0 * found.std_error && found.std_error < 9.0 * hole, "{r}: {found:?} {off}");
    }
}

#[test]
fn errors_are_of_the_size_of_what_is_there() {
    let hollow = |s: &mut Scene, x: f64| {
        let [outer, inner] = [1.0, 0.5].map(|r| solid(s, "sphere", &[&[r]]));
        let ball = minus(s, outer, inner);
        at(s, ball, [x; 3])
    };
    let measured =
        |scene: &Scene| measure(&world(scene), scene, &rays(1 << 15, 0), Run::default()).unwrap()[0];
    let far_apart = one(|s| {
        let balls = vec![hollow(s, 0.0), hollow(s, 1e6)];
        s.add_csg(Op::Union, balls)
    });
    let found = measured(&far_apart).volume;
    assert!(found.std_error < 1e-2 * found.value, "{found:?}");
    // The squares of inertias of 10^-300 and 10^300 are not representable.
    let relative = |power: i32| {
        let scene = one(|s| {
            let ball = hollow(s, 0.0);
            s.add_transform(Affine::scaling(Vec3::splat(libm::ldexp(1.0, power))), ball)
        });
        let found = measured(&scene);
        [found.volume, found.inertia[0][0]].map(|estimate| estimate.std_error / estimate.value)
    };
    let usual = relative(1);
    for power in [-195, -60, 60, 195] {
        for (found, usual) in relative(power).into_iter().zip(usual) {
            assert!((found / usual - 1.0).abs() < 1e-3, "2^{power}: {found} {usual}");
        }
    }
}
