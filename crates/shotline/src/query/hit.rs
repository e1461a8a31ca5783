//! Converts boundaries of bodies to hits in world coordinates.

use super::Hit;
use super::traversal::{BodyEntry, Traversal};
use crate::compile::{Body, World};
use crate::crossing::NO_PRIMITIVE;
use crate::csg::{Boundary, HitKind};
use crate::math::{Vec3, unit};
use crate::ray::Ray;
use crate::solid::Solid;

/// Converts a boundary of a body that the traversal returned to a hit in world coordinates.
pub(super) fn hit(
    world: &World,
    traversal: &Traversal,
    ray: &Ray,
    body_entry: &BodyEntry,
    boundary: &Boundary,
) -> Hit {
    let Boundary { kind, entering, leaf, crossing } = *boundary;
    let mut hit = Hit {
        t: crossing.t,
        t_err: crossing.t_err,
        entering,
        kind,
        normal: Vec3::NAN,
        object: body_entry.object,
        surface: None,
        primitive: None,
        polygon: None,
        barycentric: None,
        path: body_entry.path,
    };
    if kind != HitKind::Surface {
        return hit;
    }
    let (solid, local_from_body, first_surface, subtracted) = match world.body(body_entry.body) {
        Body::Surface(b) => (&*b.mesh as &dyn Solid, &b.local_from_body, b.first_surface, false),
        Body::Solid(b) => {
            let l = &b.leaves[leaf as usize];
            (&*l.solid, &l.local_from_body, l.first_surface, b.program.is_subtracted(leaf))
        }
    };
    let p = body_entry.line.in_frame(local_from_body).at(crossing.t);
    let outward = solid.normal(p, crossing.surface, crossing.primitive);
    let normal = unit(traversal.world_normal(body_entry, local_from_body.covector(outward)));
    hit.normal = if crossing.primitive == NO_PRIMITIVE {
        if subtracted { -normal } else { normal }
    } else if (normal.dot(ray.direction()) < 0.0) == entering {
        // A triangle is flat, so its outward side follows from the direction of the ray and from whether the ray
        // enters.
        normal
    } else {
        -normal
    };
    hit.surface = Some(first_surface + crossing.surface);
    if crossing.primitive != NO_PRIMITIVE {
        hit.primitive = Some(crossing.primitive);
        hit.polygon = solid.polygon(crossing.primitive);
        hit.barycentric = solid.barycentric(p, crossing.primitive);
    }
    hit
}
