//! The bounds of `t` hold for lines with the errors of their transforms.

use std::sync::Arc;

use super::shapes::{ball, cubes, ring, sheet};
use super::{MeshSolid, TriangleMesh};
use crate::crossing::Crossing;
use crate::math::{Affine, HALF_ULP, Vec3};
use crate::ray::{Line, Span};
use crate::scratch::Scratch;
use crate::testkit::random::Random;

fn hits(solid: &MeshSolid, line: &Line) -> Vec<Crossing> {
    let mut out = Vec::new();
    solid.hits(line, Span::new(-f64::MAX, f64::INFINITY).unwrap(), &mut out, &mut Scratch::default());
    out
}

/// A point of a face and a direction that leaves the face by an angle of about `slope`.
fn grazing(random: &mut Random, mesh: &TriangleMesh, slope: f64) -> (Vec3, Vec3) {
    let [a, b, c] = mesh.corners(random.below(mesh.faces.len()) as u32);
    let (v, w) = (random.number(0.05, 0.45), random.number(0.05, 0.45));
    let along = (b - a) * random.number(-1.0, 1.0) + (c - a) * random.number(-1.0, 1.0);
    let normal = (b - a).cross(c - a).normalize();
    (a + (b - a) * v + (c - a) * w, along.normalize() + normal * slope)
}

/// From lines head on to lines so grazing that the bound is still small against the faces.
#[test]
fn bounds_hold_for_lines_that_are_off() {
    let mut random = Random::new(5);
    let meshes = [ball(2), ring(9, 5), cubes(&[[0, 0, 0], [1, 0, 0]]), sheet(2)];
    let solids = meshes.map(|mesh| (mesh.clone(), MeshSolid::new(Arc::new(mesh), "bvh").unwrap()));
    let (mut compared, mut steep, mut other) = (0, 0, 0);
    for case in 0..20_000 {
        let (mesh, solid) = &solids[case % solids.len()];
        let slope = 10f64.powf(random.number(-7.0, 0.0));
        let (p, d) = grazing(&mut random, mesh, slope);
        let far = random.number(-20.0, 20.0);
        let size = 10f64.powf(random.number(-16.0, -13.5));
        let line = Line::exact(p - d * far, d);
        let off = Line::exact(line.o + random.point(-size, size), line.d + random.point(-size, size) * 0.1);
        // The other line lies exactly at the error bounds of this one.
        let (o_err, d_err) = ((off.o - line.o).abs(), (off.d - line.d).abs());
        let nominal = Line { o_err, d_err, ..line };
        let exact = hits(solid, &off);
        for n in hits(solid, &nominal) {
            let Some(e) = exact.iter().find(|e| e.primitive == n.primitive) else {
                other += 1;
                continue;
            };
            let [a, b, c] = mesh.corners(n.primitive);
            let sine = (b - a).cross(c - a).normalize().dot(d.normalize()).abs();
            assert!((n.t - e.t).abs() <= n.t_err + e.t_err, "{slope} {sine} {size} {n:?} {e:?}");
            // The bounds are also no larger than the error of the line, seen along the face.
            let doubt =
                (o_err + d_err * n.t.abs()).length() + 16.0 * HALF_ULP * (2.0 + n.t.abs()) * d.length();
            assert!(n.t_err <= 2.0 * doubt / (sine * d.length()), "{sine} {size} {n:?}");
            compared += 1;
            steep += usize::from(sine < 1e-4);
        }
    }
    assert!(compared > 20_000 && steep > 4_000 && other < 50, "{compared} {steep} {other}");
}

/// A line in the plane of a ledge, up to rounding, still finds the wall behind it.
#[test]
fn a_wall_behind_a_ledge_is_not_lost() {
    let mut random = Random::new(6);
    let places = [[0, 0, 0], [1, 0, 0], [2, 0, 0], [2, 0, 1]];
    for _ in 0..2_000 {
        let facing = Affine::rotation_xyz(random.point(-180.0, 180.0));
        let mesh = cubes(&places).moved(&facing);
        let solid = MeshSolid::new(Arc::new(mesh), "bvh").unwrap();
        let (o, d) = (facing.point(Vec3::new(-3.0, 0.4, 1.0)), facing.vector(Vec3::X));
        let doubt = Vec3::splat(4.0 * f64::EPSILON);
        let line = Line { o_err: doubt, d_err: doubt, ..Line::exact(o, d) };
        let list = hits(&solid, &line);
        let (first, last) = (list.first().unwrap(), list.last().unwrap());
        assert!((3.0 - 1e-9..5.0 + 1e-9).contains(&first.t) && (last.t - 6.0).abs() < 1e-9, "{list:?}");
        assert!(list.iter().all(|hit| 8.0 * hit.t_err < 1e-3), "{list:?}");
    }
}
