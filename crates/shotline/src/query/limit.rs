//! How far the search for the closest crossing goes on behind the best one so far.

use crate::crossing::{Crossing, GROUPING};
use crate::math::{Vec3, power_of_two_below};

/// The share of the way to a crossing, from the origin of the coordinates, by which a boundary may lie before the box of
/// its body. See [`limit_behind`].
const SLACK: f64 = 1.0 / (1 << 26) as f64;

/// The extent of an event of a few leaves, in bounds of its crossings.
const EVENT: f64 = 8.0 * GROUPING;

/// On a ray from `o` along `d`, the end of the boxes that matter: one that begins behind it has no boundary at or before `t`.
///
/// A box begins at or before every point of its body. But the `t` of a boundary is rounded, so it may lie before the box by
/// its bound; and boundaries that are one event have the `t` of one of them, which may lie before the box by the extent of
/// the event, a few bounds for each leaf. A bound is what rounding moves the line or the surface, divided by the sine of the
/// angle between them. In all frames on the path to a surface, rounding moves by some 2^-50 of the largest coordinate, which
/// is at most about `|o| + |t d|`: a frame moves the surface to where the ray is. The slack is 2^24 times that. So it is enough
/// down to angles of some 2^-20, for events of a few leaves. Below that the bounds are larger than the slack.
pub(super) fn limit_behind(o: Vec3, d: Vec3, t: f64) -> f64 {
    // A power of two at or below the length of the direction, so that the slack is not too small.
    let way = o.abs().max_element() / power_of_two_below(d.abs().max_element());
    t + SLACK * (way + t.abs())
}

/// The end of the search behind a crossing. As [`limit_behind`], and behind the events that its own bound lets expect: where the
/// line meets its surface at a smaller angle, others may be near.
pub(super) fn search_limit(o: Vec3, d: Vec3, crossing: &Crossing) -> f64 {
    let Crossing { t, t_err, .. } = *crossing;
    limit_behind(o, d, t).max(t + EVENT * t_err)
}

/// [`search_limit`] for a row of origin and direction.
pub(super) fn search_limit_of_row(&[ox, oy, oz, dx, dy, dz]: &[f64; 6], crossing: &Crossing) -> f64 {
    search_limit(Vec3::new(ox, oy, oz), Vec3::new(dx, dy, dz), crossing)
}

/// [`limit_behind`] for a row of origin and direction.
pub(super) fn limit_behind_row(&[ox, oy, oz, dx, dy, dz]: &[f64; 6], t: f64) -> f64 {
    limit_behind(Vec3::new(ox, oy, oz), Vec3::new(dx, dy, dz), t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_limit_is_behind_by_a_share_of_the_way() {
        let (o, d) = (Vec3::new(-3.0, 0.0, 8.0), Vec3::new(0.0, 2.0, 0.5));
        assert_eq!(limit_behind(o, d, 4.0), 4.0 + 8.0 * SLACK);
        assert_eq!(limit_behind(Vec3::ZERO, d, 0.0), 0.0);
        assert_eq!(limit_behind(o, d * 1e-320, 1.0), f64::INFINITY);
        assert_eq!(limit_behind(o, d, f64::INFINITY), f64::INFINITY);
        let limit = |t_err| search_limit(o, d, &Crossing::new(4.0, t_err, true, 0));
        assert_eq!([limit(1e-15), limit(1e-3)], [4.0 + 8.0 * SLACK, 4.0 + EVENT * 1e-3]);
    }
}
