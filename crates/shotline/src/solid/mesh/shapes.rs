//! Meshes for tests.

use std::collections::HashMap;

use super::TriangleMesh;
use crate::math::{Affine, Vec3};

impl TriangleMesh {
    /// The mesh moved.
    pub(crate) fn moved(mut self, by: &Affine) -> TriangleMesh {
        self.vertices.iter_mut().for_each(|v| *v = by.point(*v));
        self
    }

    /// Both meshes as one.
    pub(crate) fn with(mut self, other: &TriangleMesh) -> TriangleMesh {
        let offset = self.vertices.len() as u32;
        self.vertices.extend(&other.vertices);
        self.faces.extend(other.faces.iter().map(|face| face.map(|v| v + offset)));
        self
    }

    /// The mesh with its faces the other way round.
    pub(crate) fn inside_out(mut self) -> TriangleMesh {
        self.faces.iter_mut().for_each(|face| face.swap(1, 2));
        self
    }

    /// The mesh with three vertices of its own for each face.
    pub(super) fn unwelded(&self) -> TriangleMesh {
        let vertices = (0..).take(self.faces.len()).flat_map(|face| self.corners(face)).collect();
        let faces = (0..).take(self.faces.len()).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        TriangleMesh::new(vertices, faces)
    }
}

/// An octahedron whose faces are divided into four this many `times`, with all corners on the unit sphere.
pub(crate) fn ball(times: u32) -> TriangleMesh {
    let vertices = [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z].to_vec();
    let faces = vec![[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]];
    let mut mesh = TriangleMesh::new(vertices, faces);
    for _ in 0..times {
        let mut middles = HashMap::new();
        let mut faces = Vec::new();
        for [a, b, c] in std::mem::take(&mut mesh.faces) {
            let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(p, q)| {
                *middles.entry((p.min(q), p.max(q))).or_insert_with(|| {
                    let sum = mesh.vertices[p as usize] + mesh.vertices[q as usize];
                    mesh.vertices.push(sum.normalize());
                    mesh.vertices.len() as u32 - 1
                })
            });
            faces.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        mesh.faces = faces;
    }
    mesh
}

/// A torus of radii 2 and 1 made of `n` times `m` squares, each cut in two.
pub(super) fn ring(n: u32, m: u32) -> TriangleMesh {
    let angle = |i: u32, of: u32| f64::from(i) / f64::from(of) * std::f64::consts::TAU;
    let mut mesh = TriangleMesh::default();
    for i in 0..n {
        for j in 0..m {
            let ((s, c), (z, r)) = (angle(i, n).sin_cos(), angle(j, m).sin_cos());
            mesh.vertices.push(Vec3::new((2.0 + r) * c, (2.0 + r) * s, z));
            let at = |i: u32, j: u32| (i % n) * m + j % m;
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            mesh.faces.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

/// The surface of unit cubes at integer positions. Cubes that touch have no face between them, but may share an edge of
/// four faces.
pub(crate) fn cubes(places: &[[i32; 3]]) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    let mut numbers = HashMap::new();
    for place in places {
        for axis in 0..3 {
            for side in [0, 1] {
                let mut next = *place;
                next[axis] += 2 * side - 1;
                if places.contains(&next) {
                    continue;
                }
                // The corners of the face, counter-clockwise seen from outside.
                let square = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(u, v)| {
                    let (u, v) = if side == 1 { (u, v) } else { (v, u) };
                    let mut p = *place;
                    p[axis] += side;
                    p[(axis + 1) % 3] += u;
                    p[(axis + 2) % 3] += v;
                    *numbers.entry(p).or_insert_with(|| {
                        mesh.vertices.push(Vec3::from(p.map(f64::from)));
                        mesh.vertices.len() as u32 - 1
                    })
                });
                let [a, b, c, d] = square;
                mesh.faces.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
    mesh
}

/// An open sheet of `n` times `n` unit squares in the plane z = 0, each cut in two, facing up.
pub(crate) fn sheet(n: u32) -> TriangleMesh {
    let at = |i: u32, j: u32| i * (n + 1) + j;
    let vertices = (0..=n).flat_map(|i| (0..=n).map(move |j| Vec3::new(i.into(), j.into(), 0.0))).collect();
    let squares = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
    let faces = squares
        .flat_map(|(i, j)| {
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            [[a, b, c], [a, c, d]]
        })
        .collect();
    TriangleMesh::new(vertices, faces)
}

/// A point in the plane perpendicular to the oblique axis of a fan or a needle, moved along the axis by `height`.
fn oblique(angle: f64, radius: f64, height: f64) -> Vec3 {
    let facing = Affine::rotation_xyz(Vec3::new(23.0, 41.0, 0.0));
    facing.point(Vec3::new(radius * angle.cos(), radius * angle.sin(), height))
}

/// A cylinder of radius 1 and height 1 with `n` sides, oblique to all axes. Its caps are fans around one of their
/// corners.
pub(crate) fn fan(n: u32) -> TriangleMesh {
    let angle = |i: u32| f64::from(i) / f64::from(n) * std::f64::consts::TAU;
    let mut mesh = TriangleMesh::default();
    for i in 0..n {
        mesh.vertices.extend([oblique(angle(i), 1.0, 0.0), oblique(angle(i), 1.0, 1.0)]);
        let j = (i + 1) % n;
        mesh.faces.extend([[2 * i, 2 * j, 2 * j + 1], [2 * i, 2 * j + 1, 2 * i + 1]]);
        if i > 0 && j > 0 {
            mesh.faces.extend([[0, 2 * j, 2 * i], [1, 2 * i + 1, 2 * j + 1]]);
        }
    }
    mesh
}

/// A cone of radius 1 and height 100 with `n` sides that share its apex, oblique to all axes.
pub(crate) fn needle(n: u32) -> TriangleMesh {
    let angle = |i: u32| f64::from(i) / f64::from(n) * std::f64::consts::TAU;
    let vertices = [oblique(0.0, 0.0, 100.0), oblique(0.0, 0.0, 0.0)]
        .into_iter()
        .chain((0..n).map(|i| oblique(angle(i), 1.0, 0.0)))
        .collect();
    let faces = (0..n).flat_map(|i| {
        let (i, j) = (2 + i, 2 + (i + 1) % n);
        [[0, i, j], [1, j, i]]
    });
    TriangleMesh::new(vertices, faces.collect())
}
