//! Converts boundaries of bodies to hits in world coordinates.

use super::Hit;
use super::row_hit::RowHit;
use super::traversal::{BodyEntry, PlacedBody, Traversal};
use crate::compile::{Body, World};
use crate::crossing::NO_PRIMITIVE;
use crate::csg::{Boundary, HitKind};
use crate::math::{Affine, Vec3, unit};
use crate::ray::Ray;
use crate::solid::Solid;

/// The leaf at whose surface a boundary is.
struct BoundaryLeaf<'w> {
    solid: &'w dyn Solid,
    local_from_body: &'w Affine,
    first_surface: u32,
    is_subtracted: bool,
}

impl<'w> BoundaryLeaf<'w> {
    fn of(world: &'w World, placed: &PlacedBody, boundary: &Boundary) -> BoundaryLeaf<'w> {
        let leaf = boundary.leaf;
        match world.body(placed.body) {
            Body::Surface(body) => BoundaryLeaf {
                solid: &*body.mesh,
                local_from_body: &body.local_from_body,
                first_surface: body.first_surface,
                is_subtracted: false,
            },
            Body::Solid(body) => {
                let of_body = &body.leaves[leaf as usize];
                BoundaryLeaf {
                    solid: &*of_body.solid,
                    local_from_body: &of_body.local_from_body,
                    first_surface: of_body.first_surface,
                    is_subtracted: body.program.is_subtracted(leaf),
                }
            }
        }
    }

    /// The point of a boundary in the frame of the leaf.
    fn point(&self, body_entry: &BodyEntry, boundary: &Boundary) -> Vec3 {
        body_entry.line.in_frame(self.local_from_body).at(boundary.crossing.t)
    }
}

/// Converts a boundary of a body that the traversal returned to a hit in world coordinates.
pub(super) fn hit(
    world: &World,
    traversal: &Traversal,
    ray: &Ray,
    body_entry: &BodyEntry,
    boundary: &Boundary,
) -> Hit {
    let RowHit { t, t_err, object, surface, primitive, path, entering, kind, .. } =
        row_hit(world, &body_entry.placed, boundary);
    let world_normal = |normal| traversal.world_normal(&body_entry.placed, normal);
    let normal = normal(world, world_normal, ray.direction(), body_entry, boundary);
    let (mut polygon, mut barycentric) = (None, None);
    if let Some(primitive) = primitive {
        let leaf = BoundaryLeaf::of(world, &body_entry.placed, boundary);
        polygon = leaf.solid.polygon(primitive);
        barycentric = leaf.solid.barycentric(leaf.point(body_entry, boundary), primitive);
    }
    Hit { t, t_err, entering, kind, normal, object, surface, primitive, polygon, barycentric, path }
}

/// The numbers of the [`hit`] of a boundary that a batch has columns for, without the normal.
pub(super) fn row_hit(world: &World, placed: &PlacedBody, boundary: &Boundary) -> RowHit {
    let Boundary { kind, entering, crossing, .. } = *boundary;
    let (mut surface, mut primitive) = (None, None);
    if kind == HitKind::Surface {
        surface = Some(BoundaryLeaf::of(world, placed, boundary).first_surface + crossing.surface);
        primitive = (crossing.primitive != NO_PRIMITIVE).then_some(crossing.primitive);
    }
    RowHit {
        t: crossing.t,
        t_err: crossing.t_err,
        normal: Vec3::NAN,
        object: placed.object,
        surface,
        primitive,
        path: placed.path,
        entering,
        kind,
    }
}

/// The outward unit normal of a boundary in world coordinates, for a ray of a direction; NaN where there is no surface.
/// `world_normal` transforms a normal from the frame of the body.
pub(super) fn normal(
    world: &World,
    world_normal: impl FnOnce(Vec3) -> Vec3,
    direction: Vec3,
    body_entry: &BodyEntry,
    boundary: &Boundary,
) -> Vec3 {
    let Boundary { kind, entering, crossing, .. } = *boundary;
    if kind != HitKind::Surface {
        return Vec3::NAN;
    }
    let leaf = BoundaryLeaf::of(world, &body_entry.placed, boundary);
    let p = leaf.point(body_entry, boundary);
    let outward = leaf.solid.normal(p, crossing.surface, crossing.primitive);
    let normal = unit(world_normal(leaf.local_from_body.covector(outward)));
    if crossing.primitive == NO_PRIMITIVE {
        if leaf.is_subtracted { -normal } else { normal }
    } else if (normal.dot(direction) < 0.0) == entering {
        // A triangle is flat, so its outward side follows from the direction of the ray and from whether the ray
        // enters.
        normal
    } else {
        -normal
    }
}
