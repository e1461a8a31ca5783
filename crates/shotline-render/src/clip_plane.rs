//! Planes that cut a scene open.

use std::str::FromStr;

use shotline::crossing::GROUPING;
use shotline::math::{HALF_ULP, Vec3};
use shotline::ray::{Ray, Span};

use crate::camera::unit;

/// The margin beside a plane, in units of its rounding: some events of coincident crossings.
pub(crate) const MARGIN: f64 = 8.0 * GROUPING;

/// A plane that cuts a scene open: the points `p` with `normal . p > offset` are removed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClipPlane {
    normal: Vec3,
    /// The normal at unit length.
    outward: Vec3,
    offset: f64,
}

/// The text or the numbers are not those of a plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum InvalidClipPlane {
    /// The text is not a plane.
    #[error(
        "expected a plane: x=1, y=-2, z=0, or four numbers NX,NY,NZ,D, which remove the points p with N.p > D"
    )]
    Text,
    /// The normal is zero.
    #[error("the normal of the plane, its first three numbers, is zero, or too small to have a direction")]
    NoNormal,
    /// A number is NaN or infinite.
    #[error("the plane has a number that is NaN or infinite")]
    NotFinite,
}

impl ClipPlane {
    /// The plane that removes the points `p` with `normal . p > offset`.
    ///
    /// # Errors
    /// [`InvalidClipPlane`] for a normal of zero, NaN and infinite numbers.
    pub fn new(normal: Vec3, offset: f64) -> Result<ClipPlane, InvalidClipPlane> {
        if !normal.is_finite() || !offset.is_finite() {
            return Err(InvalidClipPlane::NotFinite);
        }
        // Below normal numbers digits are lost.
        let largest = normal.abs().max_element();
        let outward =
            unit(normal).filter(|_| largest >= f64::MIN_POSITIVE).ok_or(InvalidClipPlane::NoNormal)?;
        Ok(ClipPlane { normal, outward, offset })
    }

    /// The normal at unit length.
    pub(crate) fn outward(&self) -> Vec3 {
        self.outward
    }

    /// The distance of the plane from the origin along its normal.
    pub(crate) fn distance(&self) -> f64 {
        // As `unit` does: the square of a number must not overflow.
        let size = self.normal.abs().max_element();
        self.offset / size / (self.normal / size).length()
    }

    /// The first or last `t` on the side that is kept; `None` if the ray runs along the plane.
    ///
    /// It is beside the plane by more than rounding can move it and a face that lies in the plane. So what ends in the plane of a
    /// cut is gone, and what begins there is cut, for all rays alike.
    fn crossing(&self, ray: &Ray) -> Option<f64> {
        let speed = self.normal.dot(ray.direction());
        let t = (self.offset - self.normal.dot(ray.origin())) / speed;
        let weight = self.normal.abs().dot(ray.origin().abs()) + self.offset.abs();
        let beside = MARGIN * HALF_ULP * (weight / speed.abs() + t.abs());
        let t = if speed > 0.0 { t - beside } else { t + beside };
        (speed != 0.0 && t.is_finite()).then_some(t)
    }

    fn removes(&self, point: Vec3) -> bool {
        self.normal.dot(point) > self.offset
    }
}

impl FromStr for ClipPlane {
    type Err = InvalidClipPlane;

    /// `x=1`, `y=-2`, `z=0` or `NX,NY,NZ,D`.
    fn from_str(text: &str) -> Result<ClipPlane, InvalidClipPlane> {
        let number = |text: &str| text.trim().parse::<f64>().map_err(|_| InvalidClipPlane::Text);
        if let Some((axis, offset)) = text.split_once('=') {
            let axes = [("x", Vec3::X), ("y", Vec3::Y), ("z", Vec3::Z)];
            let normal = axes.iter().find(|(name, _)| *name == axis.trim()).ok_or(InvalidClipPlane::Text)?.1;
            return ClipPlane::new(normal, number(offset)?);
        }
        let numbers = text.split(',').map(number).collect::<Result<Vec<f64>, _>>()?;
        let [x, y, z, offset] = numbers[..] else { return Err(InvalidClipPlane::Text) };
        ClipPlane::new(Vec3::new(x, y, z), offset)
    }
}

/// The part of a ray that planes keep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct KeptSpan {
    pub span: Span,
    /// The unit normal, towards the origin of the ray, of the plane at which it begins; `None` if the span is not cut there.
    pub cut: Option<Vec3>,
}

impl KeptSpan {
    /// The part of a span that all planes keep; `None` if none is left. The planes keep a convex part of space, so it is one
    /// interval.
    pub fn new(planes: &[ClipPlane], ray: &Ray, span: Span) -> Option<KeptSpan> {
        let (mut from, mut to, mut cut) = (span.t_min(), span.t_max(), None);
        for plane in planes {
            match plane.crossing(ray) {
                None if plane.removes(ray.at(from)) => return None,
                None => {}
                Some(t) if plane.normal.dot(ray.direction()) > 0.0 => to = to.min(t),
                Some(t) if t > from => (from, cut) = (t, Some(plane.outward)),
                Some(_) => {}
            }
        }
        let span = Span::new(from, to).ok().filter(|_| from < to)?;
        Some(KeptSpan { span, cut })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plane(text: &str) -> ClipPlane {
        text.parse().expect("a plane")
    }

    #[test]
    fn planes_are_read() {
        assert_eq!(plane("x=1"), ClipPlane::new(Vec3::X, 1.0).expect("a plane"));
        assert_eq!(plane(" z = -2.5e3 "), ClipPlane::new(Vec3::Z, -2500.0).expect("a plane"));
        assert_eq!(plane("0,-2,0, 4"), ClipPlane::new(Vec3::Y * -2.0, 4.0).expect("a plane"));
        for text in ["", "x", "x=", "w=1", "x=1=2", "1,2,3", "1,2,3,4,5", "1,2,3,a"] {
            assert_eq!(text.parse::<ClipPlane>(), Err(InvalidClipPlane::Text), "{text}");
        }
        assert_eq!("0,0,0,1".parse::<ClipPlane>(), Err(InvalidClipPlane::NoNormal));
        for text in ["x=inf", "nan,0,0,1", "1,0,0,1e400"] {
            assert_eq!(text.parse::<ClipPlane>(), Err(InvalidClipPlane::NotFinite), "{text}");
        }
    }

    #[test]
    fn one_interval_is_kept() {
        let ray = Ray::new(Vec3::new(-4.0, 0.0, 0.0), Vec3::X * 2.0).expect("a ray");
        let kept = |planes: &[&str]| {
            let planes: Vec<ClipPlane> = planes.iter().map(|text| plane(text)).collect();
            let KeptSpan { span, cut } = KeptSpan::new(&planes, &ray, Span::FORWARD)?;
            // The margins are invisible, and inside.
            let round = |t: f64| if t.is_finite() { (t * 1e9).round() / 1e9 } else { t };
            let (from, to) = (round(span.t_min()), round(span.t_max()));
            assert!(from <= span.t_min() && span.t_max() <= to && (cut.is_none() || from < span.t_min()));
            Some((from, to, cut))
        };
        assert_eq!(kept(&[]), Some((0.0, f64::INFINITY, None)));
        assert_eq!(kept(&["x=1"]), Some((0.0, 2.5, None)));
        assert_eq!(kept(&["-3,0,0,-3"]), Some((2.5, f64::INFINITY, Some(Vec3::NEG_X))));
        assert_eq!(kept(&["x=6", "-1,0,0,2", "-1,0,0,1"]), Some((1.5, 5.0, Some(Vec3::NEG_X))));
        assert_eq!(kept(&["x=1", "-1,0,0,-1"]), None);
        assert_eq!(kept(&["x=-5"]), None);
        // Along a plane.
        assert_eq!(kept(&["y=0"]), Some((0.0, f64::INFINITY, None)));
        assert_eq!(kept(&["y=-1"]), None);
    }
}
