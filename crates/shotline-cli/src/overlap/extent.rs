//! How large an overlap or a protrusion is, estimated by rays through a box around it.

use shotline::aabb::Aabb;
use shotline::query::{Caster, ConflictKind, QueryError};
use shotline::ray::Span;

use super::axis_ray::axis_ray;
use super::on_ray::{Conflict, conflicts_on_ray};

/// The size of an overlap or a protrusion in a box.
#[derive(Clone, Copy, Debug)]
pub struct Extent {
    /// Along the axis on which it is thinnest, the longest part of a ray in it.
    pub depth: f64,
    pub volume: f64,
}

/// Rays along each axis.
const RAYS: u32 = 256;

/// Estimates in a box how large a conflict of two objects is. `None` if no ray meets it.
pub fn extent(
    caster: &mut Caster,
    conflict: (ConflictKind, [&str; 2]),
    bounds: &Aabb,
) -> Result<Option<Extent>, QueryError> {
    let size = bounds.size();
    let (mut depth, mut volume) = (f64::INFINITY, 0.0);
    for axis in 0..3 {
        let (mut longest, mut sum): (f64, f64) = (0.0, 0.0);
        for ray in (0..RAYS).filter_map(|i| axis_ray(bounds, axis, i)) {
            let from = bounds.min[axis] - ray.origin()[axis];
            let Ok(span) = Span::new(from, from + size[axis]) else { continue };
            let (found, _) = conflicts_on_ray(caster, &ray, span)?;
            // A ray may meet many of them: copies that overlap their neighbours.
            for o in found.iter().filter(|o| o.is_wide() && is_of(o, conflict)) {
                longest = longest.max(o.t_out - o.t_in);
                sum += o.t_out - o.t_in;
            }
        }
        depth = depth.min(longest);
        let area = size[(axis + 1) % 3] * size[(axis + 2) % 3];
        volume += sum / f64::from(RAYS) * area / 3.0;
    }
    Ok((volume > 0.0).then_some(Extent { depth, volume }))
}

fn is_of(overlap: &Conflict, (kind, [a, b]): (ConflictKind, [&str; 2])) -> bool {
    let names = [overlap.first.as_str(), overlap.second.as_str()];
    overlap.kind == kind && (names == [a, b] || names == [b, a])
}
