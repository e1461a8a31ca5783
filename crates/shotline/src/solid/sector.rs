//! The sector around the z axis between two angles, of solids that are cut by it.

use super::capped::Capped;
use super::form::Form;
use super::parts::Parts;
use super::{ParamError, Params};
use crate::aabb::Aabb;
use crate::math::{Dd, Vec3, sin_cos_degrees_wide};

/// A sector of less than a full turn: the intersection of the half-spaces behind two planes through the axis, or their
/// union if it is more than half a turn.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sector {
    /// The sine and cosine of the angle at which it begins, and of that at which it ends.
    start: [Dd; 2],
    end: [Dd; 2],
    pub is_reflex: bool,
}

impl Sector {
    /// The sector of the parameters `phi0` and `dphi`, in degrees; `None` for a full turn.
    pub fn of(p: &Params) -> Result<Option<Sector>, ParamError> {
        // The remainder is exact. It keeps the middle angle accurate if there are many turns.
        let (phi0, dphi) = (p.number("phi0")? % 360.0, p.number("dphi")?);
        if !(dphi > 0.0 && dphi <= 360.0) {
            let why = format!("is {dphi}, but must be above 0 and at most 360");
            return Err(ParamError { param: "dphi", why });
        }
        let (s0, c0) = sin_cos_degrees_wide(phi0);
        let (s, c) = sin_cos_degrees_wide(dphi);
        let end = [s0 * c + c0 * s, c0 * c - s0 * s];
        Ok((dphi < 360.0).then_some(Sector { start: [s0, c0], end, is_reflex: dphi > 180.0 }))
    }

    /// The planes of its ends, negative inside.
    pub fn planes(&self) -> [Form; 2] {
        let plane = |x: Dd, y: Dd| Form { linear: [x * 0.5, y * 0.5, Dd::ZERO], ..Form::ZERO };
        let ([s0, c0], [s1, c1]) = (self.start, self.end);
        [plane(s0, -c0), plane(-s1, c1)]
    }

    /// The directions of its two ends.
    pub fn ends(&self) -> [Vec3; 2] {
        [self.start, self.end].map(|[s, c]| Vec3::new(c.hi, s.hi, 0.0))
    }

    /// The half-spaces that it is made of.
    pub fn parts(&self) -> Parts {
        self.combined(self.planes())
    }

    /// The sector twisted about the axis: at the height z it is turned by the angle whose tangent is `z * twist`. The units
    /// of length across the axis and along it are powers of two.
    pub fn twisted(&self, twist: Dd, [unit, unit_z]: [f64; 2]) -> Parts {
        if twist.hi == 0.0 {
            return self.parts();
        }
        let k = twist * unit_z;
        self.combined(self.planes().map(|plane| {
            // A plane through the axis is a x + b y < 0; turned it is a (x + k z y) + b (y - k z x) < 0.
            let [a, b, _] = plane.linear;
            let cross = Some([k * a, -(k * b), Dd::ZERO]);
            Form { shrink: Vec3::new(1.0 / unit, 1.0 / unit, 1.0 / unit_z), cross, ..plane }
        }))
    }

    /// The sector between two surfaces that are like its planes.
    fn combined(&self, [start, end]: [Form; 2]) -> Parts {
        let half = |plane, surfaces| Parts::of(Capped::whole(plane, Aabb::EVERYTHING, surfaces));
        let halves = vec![half(start, &["start"]), half(end, &["end"])];
        if self.is_reflex { Parts::Union(halves) } else { Parts::Intersection(halves) }
    }
}
