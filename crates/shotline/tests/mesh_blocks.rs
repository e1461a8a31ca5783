//! Blocks of rays that are cast at meshes by the kernel have the bits of the plain path, in every column: over meshes,
//! rays, spans and transforms that are difficult for rounding, and batches of any size and order.
//!
//! The plain path casts ray by ray. It is used where counters are requested.

#[path = "mesh_blocks/mod.rs"]
mod blocks;

use std::sync::Arc;

use shotline::math::{Affine, Vec3};
use shotline::query::Scope;
use shotline::ray::{Ray, Span};
use shotline::solid::mesh::TriangleMesh;
use shotline::testkit::meshes::cuboid;
use shotline::testkit::random::Random;

use blocks::cases::{Transform, any, any_world, cast, cast_from_within, place, world_of};
use blocks::compare::compare;
use blocks::meshes::{self, Coordinates, FAMILIES, Family};

const NEAR: Coordinates = Coordinates { offset: Vec3::ZERO, scale: 1.0, single: true };

/// The number of families of at most some hundred triangles, which come first.
const SMALL: usize = 17;

/// Runs cases with ascending seeds; at most a few scenes may be refused.
fn run(seeds: std::ops::Range<u64>, families: &[Family], n: usize) {
    let all = seeds.end - seeds.start;
    let cast: u64 =
        seeds.map(|seed| u64::from(any(seed, families, n).unwrap_or_else(|what| panic!("{what}")))).sum();
    assert!(2 * cast > all, "{cast} of {all}");
}

#[test]
fn random_cases_of_small_meshes() {
    run(0..150, &FAMILIES[..SMALL], 120);
}

#[test]
fn random_cases_of_large_meshes() {
    run(10_000..10_008, &FAMILIES[SMALL..], 120);
}

#[test]
fn random_worlds() {
    let run = |seeds: std::ops::Range<u64>, families: &[Family]| {
        let all = seeds.end - seeds.start;
        let cast: u64 = seeds
            .map(|seed| u64::from(any_world(seed, families, 100).unwrap_or_else(|what| panic!("{what}"))))
            .sum();
        assert!(2 * cast > all, "{cast} of {all}");
    };
    run(0..50, &[Family::Cube, Family::Tetrahedron, Family::Ball, Family::Plate, Family::Nested]);
    run(100..140, &FAMILIES[..13]);
}

#[test]
fn batches_of_any_size_and_number_of_threads() {
    let mut random = Random::new(1);
    for (n, threads) in [(1, 1), (7, 1), (63, 1), (64, 1), (65, 1), (2048, 1), (5000, 1), (5000, 2)] {
        for (family, transform, count) in [
            (Family::Ball, Transform::Identity, 1),
            (Family::Large, Transform::Identity, 1),
            (Family::LargeSheet, Transform::Turned, 1),
            (Family::Star, Transform::Identity, 2),
            (Family::Cube, Transform::Mirrored, 4),
        ] {
            let placed = world_of(family, NEAR, transform, count, &mut random).expect("a world");
            cast(&placed, n, threads, &mut random).unwrap_or_else(|what| panic!("{what}"));
        }
    }
}

/// Some thousand rays from within each mesh, so that almost all are cast after the cells of its grid are known.
#[test]
fn rays_that_begin_within_meshes() {
    let mut random = Random::new(4);
    for family in &FAMILIES[..SMALL] {
        for transform in [Transform::Identity, Transform::Turned] {
            let placed = world_of(*family, NEAR, transform, 1, &mut random).expect("a world");
            for n in [200, 400, 700] {
                cast_from_within(&placed, n, 1, &mut random).unwrap_or_else(|what| panic!("{what}"));
            }
        }
    }
    let placed = world_of(Family::Large, NEAR, Transform::Identity, 1, &mut random).expect("a world");
    cast_from_within(&placed, 5000, 2, &mut random).unwrap_or_else(|what| panic!("{what}"));
}

/// All placements coincide: of equal hits the lowest path is returned.
#[test]
fn placements_that_coincide() {
    let mut random = Random::new(2);
    for family in [Family::Tetrahedron, Family::Flaps, Family::Sheet, Family::Soup] {
        for transform in [Affine::IDENTITY, Affine::rotation_xyz(Vec3::new(10.0, 20.0, 30.0))] {
            let mesh = Arc::new(family.mesh(&mut random));
            let placed = place(&[0; 4].map(|_| (mesh.clone(), transform)), format!("{family:?}"));
            let placed = placed.expect("a world");
            for _ in 0..4 {
                cast(&placed, 150, 1, &mut random).unwrap_or_else(|what| panic!("{what}"));
            }
        }
    }
}

/// Both hits of a plate are one event if the intervals around them meet, which includes the rounding of the ends of
/// these intervals. The kernel once took the first hit of plates slightly thicker than twice the bound for a hit of its
/// own.
#[test]
fn plates_as_thin_as_the_bounds_of_their_hits() {
    let mut random = Random::new(3);
    for _ in 0..40 {
        let near: f64 = random.number(0.5, 1.0) * [1.0, 1024.0, 3e7][random.below(3)];
        for ulps in 12..22 {
            let far = f64::from_bits(near.to_bits() + ulps);
            let plate = cuboid(Vec3::new(near, -1.0, -1.0), Vec3::new(far, 1.0, 1.0));
            let placed = place(&[(Arc::new(plate), Affine::IDENTITY)], "a plate".into()).expect("a world");
            let rays = [Vec3::ZERO, Vec3::new(0.0, 0.5, -0.25)].map(|o| Ray::new(o, Vec3::X).expect("a ray"));
            for scope in [Span::FORWARD.into(), Scope::surfaces(Span::FORWARD)] {
                compare(&placed, &rays, scope, 1)
                    .unwrap_or_else(|what| panic!("{ulps} ulps at {near}: {what}"));
            }
        }
    }
}

/// The plain path misses one of two triangles where products of the ray's numbers underflow, so that the hits do not
/// balance. The kernel once took such a ray to begin inside the solid, the plain path outside.
#[test]
fn a_ray_from_outside_whose_hits_do_not_balance() {
    let mut ball = meshes::ball(3, 9);
    NEAR.apply(&mut ball);
    let placed = place(&[(Arc::new(ball), Affine::IDENTITY)], "a ball".into()).expect("a world");
    let o = Vec3::new(0.43301269412040716, -5e-324, 0.25);
    let rays = [Vec3::Z, -Vec3::Z].map(|d| Ray::new(o, d).expect("a ray"));
    let long = Span::new(-1e3, f64::INFINITY).expect("a span");
    for scope in [Span::FORWARD.into(), long.into(), Scope::surfaces(long)] {
        compare(&placed, &rays, scope, 1).unwrap_or_else(|what| panic!("{what}"));
    }
}

/// The coordinate of a ray that begins beside a box by less than any product can show becomes zero when it is scaled to
/// the size of the mesh. The kernel once hit the mesh there, which the plain path misses.
#[test]
fn a_ray_beside_the_box_by_a_denormal_number() {
    let small = f64::from_bits(1);
    let cube = Arc::new(cuboid(Vec3::ZERO, Vec3::ONE));
    let mut sheet = cuboid(Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0));
    sheet.faces.truncate(2);
    let sheet = Arc::new(sheet);
    for factors in [Vec3::ONE, Vec3::splat(2.0), Vec3::new(0.5, 0.25, 1024.0)] {
        for mesh in [&cube, &sheet] {
            let placed = place(&[(mesh.clone(), Affine::scaling(factors))], format!("{factors}"));
            let placed = placed.expect("a world");
            let mut rays = Vec::new();
            for x in [small, -small, 1e-310, -1e-300, 0.0] {
                for o in [Vec3::new(x, 2.0, 0.25), Vec3::new(0.25, 0.125, x), Vec3::new(x, -x, 5.0)] {
                    for d in
                        [Vec3::Y, Vec3::Z, Vec3::new(0.0, 1e300, 1e-305), Vec3::new(-1e-305, 1e-20, 1e300)]
                    {
                        rays.extend([d, -d].map(|d| Ray::new(o, d).expect("a ray")));
                    }
                }
            }
            for scope in [Span::FORWARD.into(), Scope::surfaces(Span::new(-9.0, 9.0).expect("a span"))] {
                compare(&placed, &rays, scope, 1).unwrap_or_else(|what| panic!("{factors}: {what}"));
            }
        }
    }
}

/// The ray begins at -0.0 in the upper plane of the box of some faces, which lies there once it is padded, and enters that
/// box at a depth of -0.0. The kernel once took that for a depth beyond the first hit, and lost the nearer one.
#[test]
fn a_ray_that_enters_a_box_at_minus_zero() {
    let faces = [
        [
            [-0.1875, -1.0 / (1 << 22) as f64, -0.203125],
            [0.203125, -0.390625, -0.203125],
            [0.0, -0.40625, 0.25],
        ],
        [[-0.203125, -0.015625, -0.203125], [0.203125, -0.40625, -0.203125], [-0.015625, -0.40625, 0.25]],
        [[-0.1875, -0.003, -0.203125], [0.203125, -0.390625, -0.203125], [0.0, -0.40625, 0.25]],
        [[-0.09375, -0.703125, 0.0], [0.15625, -0.703125, 0.0], [-0.09375, -0.703125, 0.25]],
        [[0.15625, -0.703125, 0.0], [0.15625, -0.703125, 0.25], [-0.09375, -0.703125, 0.25]],
        [[-0.75, -0.75, -0.75], [-0.75, -0.734375, -0.75], [-0.734375, -0.75, -0.75]],
        [[0.75, 0.75, 0.75], [0.75, 0.734375, 0.75], [0.734375, 0.75, 0.75]],
    ];
    // The axis is y, z or x in turn.
    for turn in 0..3 {
        let turned = |v: [f64; 3]| Vec3::new(v[turn], v[(turn + 1) % 3], v[(turn + 2) % 3]);
        let vertices = faces.iter().flatten().map(|v| turned(*v)).collect();
        let faces = (0..7).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let mesh = TriangleMesh::new(vertices, faces);
        let placed = place(&[(Arc::new(mesh), Affine::IDENTITY)], format!("turned by {turn}"));
        let placed = placed.expect("a world");
        for y in [-0.0, 0.0, -1e-60, -1e-20] {
            let (o, d) = (turned([-0.019515734332457402, y, 0.11930328243256463]), turned([0.0, -1.0, 0.0]));
            let rays = [Ray::new(o, d).expect("a ray")];
            compare(&placed, &rays, Span::FORWARD.into(), 1).unwrap_or_else(|what| panic!("{y}: {what}"));
        }
    }
}

/// A `t` that underflows from below was returned as -0.0, where the plain path returns 0.0.
#[test]
fn a_negative_t_that_underflows_is_zero() {
    let z = -1e-300;
    let corners = vec![Vec3::new(-1.0, -1.0, z), Vec3::new(3.0, -1.0, z), Vec3::new(-1.0, 3.0, z)];
    let triangle = Arc::new(TriangleMesh::new(corners, vec![[0, 1, 2]]));
    let rays = [1e157, -1e157].map(|d| Ray::new(Vec3::ZERO, Vec3::new(0.0, 0.0, d)).expect("a ray"));
    for transform in [Affine::IDENTITY, Affine::scaling(Vec3::new(-1.0, 1.0, 1.0))] {
        let placed = place(&[(triangle.clone(), transform)], "a triangle".into()).expect("a world");
        compare(&placed, &rays, Span::FORWARD.into(), 1).unwrap_or_else(|what| panic!("{what}"));
    }
}

/// Where `t` is scaled by an extreme power of two, the ends of a tiny span must not make the kernel miss the mesh.
#[test]
fn a_tiny_span_of_a_ray_with_an_extreme_scale() {
    let size = 1e-200;
    let mesh = Arc::new(cuboid(Vec3::ZERO, Vec3::splat(size)));
    let placed = place(&[(mesh, Affine::scaling(Vec3::ONE))], "tiny".to_string()).expect("a world");
    let o = Vec3::new(0.5, 0.25, 2.0) * size;
    let rays: Vec<Ray> = [1e180, 1e200, 1e210].map(|d| Ray::new(o, -Vec3::Z * d).expect("a ray")).to_vec();
    for (t_min, t_max) in [(-1e-320, 1e-323), (-5e-324, 5e-324), (-1e-300, 1e-300), (0.0, 1e-305)] {
        let scope = Scope::surfaces(Span::new(t_min, t_max).expect("a span"));
        compare(&placed, &rays, scope, 1).unwrap_or_else(|what| panic!("{t_max}: {what}"));
    }
}
