//! Validated rays, spans of their parameter, and the lines of rays in local frames.

use crate::math::{Affine, HALF_ULP, Vec3};

/// The ray `o + t d`. The direction has any finite non-zero length and is never normalised: `t` is in units of the
/// length of `d`, so that the same `t` is valid in every frame of a scene graph.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::NoUninit)]
#[repr(C)]
pub struct Ray {
    origin: Vec3,
    direction: Vec3,
}

/// Why six numbers are not a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum InvalidRay {
    /// A component of the origin is NaN or infinite.
    #[error("the origin has a component that is NaN or infinite")]
    Origin,
    /// A component of the direction is NaN or infinite.
    #[error("the direction has a component that is NaN or infinite")]
    Direction,
    /// All components of the direction are zero.
    #[error("the direction is zero")]
    ZeroDirection,
}

impl Ray {
    /// A ray from an origin in a direction of any finite non-zero length.
    ///
    /// # Errors
    /// [`InvalidRay`] for NaN, infinite components and the zero direction.
    pub fn new(origin: Vec3, direction: Vec3) -> Result<Ray, InvalidRay> {
        if !origin.is_finite() {
            Err(InvalidRay::Origin)
        } else if !direction.is_finite() {
            Err(InvalidRay::Direction)
        } else if direction == Vec3::ZERO {
            Err(InvalidRay::ZeroDirection)
        } else {
            Ok(Ray { origin, direction })
        }
    }

    /// The origin, where `t` is 0.
    pub fn origin(&self) -> Vec3 {
        self.origin
    }

    /// The direction: the displacement for one unit of `t`.
    pub fn direction(&self) -> Vec3 {
        self.direction
    }

    /// The point `o + t d`.
    pub fn at(&self, t: f64) -> Vec3 {
        self.origin + self.direction * t
    }
}

/// The interval `[t_min, t_max]` of a ray to which a query applies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    t_min: f64,
    t_max: f64,
}

/// A span with NaN, with an infinite `t_min`, or with its ends reversed.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("the span from t_min = {t_min} to t_max = {t_max} is not an interval")]
pub struct InvalidSpan {
    /// The lower end given.
    pub t_min: f64,
    /// The upper end given.
    pub t_max: f64,
}

impl Span {
    /// The half line `[0, inf)`.
    pub const FORWARD: Span = Span { t_min: 0.0, t_max: f64::INFINITY };

    /// The span from a finite `t_min` to a `t_max` not below it, which may be infinite.
    ///
    /// # Errors
    /// [`InvalidSpan`] for NaN, an infinite `t_min` and `t_max < t_min`.
    pub fn new(t_min: f64, t_max: f64) -> Result<Span, InvalidSpan> {
        if t_min.is_finite() && t_min <= t_max {
            Ok(Span { t_min, t_max })
        } else {
            Err(InvalidSpan { t_min, t_max })
        }
    }

    /// The lower end.
    pub fn t_min(&self) -> f64 {
        self.t_min
    }

    /// The upper end; may be infinite.
    pub fn t_max(&self) -> f64 {
        self.t_max
    }
}

/// The whole line of a ray in a frame of the scene graph: `T^-1 o` and `T^-1 d`, with bounds on the rounding errors
/// of both. The parameter `t` is that of the ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// The point at which `t` is 0.
    pub o: Vec3,
    /// The displacement for one unit of `t`.
    pub d: Vec3,
    /// Bounds on the error of each component of `o`; zero where exact.
    pub o_err: Vec3,
    /// Bounds on the error of each component of `d`; zero where exact.
    pub d_err: Vec3,
}

impl Line {
    /// The line of a ray in the frame in which the ray was given: exact.
    pub fn of(ray: &Ray) -> Line {
        Line { o: ray.origin, d: ray.direction, o_err: Vec3::ZERO, d_err: Vec3::ZERO }
    }

    /// The line through two vectors taken as exact.
    pub fn exact(o: Vec3, d: Vec3) -> Line {
        Line { o, d, o_err: Vec3::ZERO, d_err: Vec3::ZERO }
    }

    /// The point `o + t d`.
    pub fn at(&self, t: f64) -> Vec3 {
        self.o + self.d * t
    }

    /// Bounds on the error of each component of `at(t)` that stem from the frame, not from evaluating it.
    pub fn point_err(&self, t: f64) -> Vec3 {
        self.o_err + self.d_err * t.abs()
    }

    /// The line in a child's frame, given the child's `T^-1`. The bounds grow by the rounding of the
    /// matrix entries (half an ulp each) and of the products and sums.
    pub fn in_frame(&self, local_from_parent: &Affine) -> Line {
        if local_from_parent.is_identity() {
            return *self;
        }
        let mut out = *self;
        // Weighed, errors of zero are zero.
        let is_exact = self.o_err == Vec3::ZERO && self.d_err == Vec3::ZERO;
        for i in 0..3 {
            let m = &local_from_parent.rows[i];
            let a = [m[0].abs(), m[1].abs(), m[2].abs()];
            let weigh = |v: Vec3| a[0] * v.x.abs() + a[1] * v.y.abs() + a[2] * v.z.abs();
            out.o[i] = m[0] * self.o.x + m[1] * self.o.y + m[2] * self.o.z + m[3];
            out.d[i] = m[0] * self.d.x + m[1] * self.d.y + m[2] * self.d.z;
            // Half an ulp each for an entry, one product and up to three sums. The mean error is far less.
            out.o_err[i] = 5.0 * HALF_ULP * (weigh(self.o) + m[3].abs());
            out.d_err[i] = 4.0 * HALF_ULP * weigh(self.d);
            if !is_exact {
                out.o_err[i] += weigh(self.o_err);
                out.d_err[i] += weigh(self.d_err);
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bad_rays_and_spans_are_refused() {
        assert_eq!(Ray::new(Vec3::NAN, Vec3::X), Err(InvalidRay::Origin));
        assert_eq!(Ray::new(Vec3::ZERO, Vec3::X * f64::INFINITY), Err(InvalidRay::Direction));
        assert_eq!(Ray::new(Vec3::ZERO, Vec3::ZERO), Err(InvalidRay::ZeroDirection));
        assert!(Span::new(f64::NAN, 1.0).is_err());
        assert!(Span::new(1.0, f64::NAN).is_err());
        assert!(Span::new(2.0, 1.0).is_err());
        assert!(Span::new(f64::NEG_INFINITY, 1.0).is_err());
        assert_eq!(Span::new(0.0, f64::INFINITY), Ok(Span::FORWARD));
    }

    #[test]
    fn identity_frames_keep_the_bits() {
        let line = Line::exact(Vec3::new(0.1, 0.2, 0.3), Vec3::new(-0.0, 1e-300, 7.0));
        assert_eq!(line.in_frame(&Affine::IDENTITY), line);
    }
}
