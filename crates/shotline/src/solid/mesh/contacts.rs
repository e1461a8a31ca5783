//! Lines that run in planes of faces: where the mesh has its interior beside the line.
//!
//! The planes divide the surroundings of the line into sectors. In each sector the line is moved aside a little, and
//! its crossings there are those of the mesh in that sector. An exact line is moved by an infinitesimal step, by the
//! rule for ties (`sheared_ray`), any other line by more than its error.

use std::f64::consts::{PI, TAU};

use super::MeshSolid;
use super::mesh_line::MeshLine;
use super::plane;
use super::winding::to_crossings;
use crate::contact::{Border, Contact, Sector};
use crate::math::{Vec3, unit};
use crate::ray::Line;
use crate::scratch::Scratch;

/// Planes at a smaller angle than this, in radians, count as one.
const ONE_PLANE: f64 = 1e-7;

/// The border between a plane and a sector: its angle in the plane perpendicular to the line, and its direction there.
#[derive(Clone, Copy, Debug)]
struct Edge {
    angle: f64,
    direction: Vec3,
}

impl MeshSolid {
    /// Appends the contacts of the mesh beside a line that runs in the planes of some faces.
    pub(super) fn contacts_with(
        &self,
        faces: &[u32],
        line: &Line,
        mesh_line: &MeshLine,
        out: &mut Vec<Contact>,
        scratch: &mut Scratch,
    ) {
        let (x, y) = unit(line.d).any_orthonormal_pair();
        let borders = self.borders(faces, line, (x, y));
        let Some(first) = borders.first() else { return };
        let last = Edge { angle: first.angle + TAU, ..*first };
        let mut hits = Vec::new();
        for (from, to) in borders.iter().zip(borders.iter().skip(1).chain([&last])) {
            let (middle, half) = (0.5 * (from.angle + to.angle), 0.5 * (to.angle - from.angle));
            let direction = x * libm::cos(middle) + y * libm::sin(middle);
            let Some(moved_aside) = mesh_line.moved_aside(direction, libm::sin(half), &self.scaled_bounds)
            else {
                continue;
            };
            hits.clear();
            self.hits_between(&moved_aside, f64::NEG_INFINITY, f64::INFINITY, &mut hits, scratch);
            to_crossings(&mut hits, 0, 0);
            let border = |edge: &Edge| Border::straight(edge.direction, line.d);
            let sector = Sector { from: border(from), to: border(to) };
            out.extend(hits.chunks_exact(2).map(|pair| Contact { enter: pair[0], exit: pair[1], sector }));
        }
        scratch.in_plane.clear();
    }

    /// Returns the borders of the sectors, sorted by angle. The plane of each face has one on both sides of the line.
    fn borders(&self, faces: &[u32], line: &Line, (x, y): (Vec3, Vec3)) -> Vec<Edge> {
        let side = |face: &u32| {
            let direction = plane::normal(self.corners(*face)).cross(line.d);
            let flat = unit(direction);
            let angle = libm::atan2(flat.dot(y), flat.dot(x));
            if (0.0..PI).contains(&angle) {
                Edge { angle, direction }
            } else {
                Edge { angle: angle.rem_euclid(PI), direction: -direction }
            }
        };
        let mut borders: Vec<Edge> = faces.iter().map(side).filter(|side| !side.angle.is_nan()).collect();
        borders.sort_by(|a, b| a.angle.total_cmp(&b.angle));
        borders.dedup_by(|b, a| b.angle - a.angle < ONE_PLANE);
        if borders.len() > 1 && borders[0].angle + PI - borders[borders.len() - 1].angle < ONE_PLANE {
            borders.pop();
        }
        let opposite = |b: &Edge| Edge { angle: b.angle + PI, direction: -b.direction };
        let opposites: Vec<Edge> = borders.iter().map(opposite).collect();
        borders.extend(opposites);
        borders
    }
}
