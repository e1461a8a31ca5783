//! Tests whether a line is clear of a plane: certainly on its inner side for an interval of `t`, and far from
//! crossing it.

use super::form::{Form, rounded};
use crate::math::{HALF_ULP, Vec3};
use crate::ray::Line;

/// The bound of a crossing with a plane is at most 24 half-ulps of the sum of its terms' magnitudes (see
/// `Form::root`), and crossings within 8 bounds are coincident. Half of this margin is for errors that grow with
/// the distance to the crossing, half for those that do not. The rest is spare.
const CLEAR: f64 = 1024.0 * HALF_ULP;
/// The same for errors of the line's frame, which enter the bound directly.
const CLEAR_OF_FRAME: f64 = 16.0;

impl Form {
    /// Whether a line lies on the inner side of a plane at these two `t`, and so between them, and its crossing
    /// with the plane is not coincident with anything in that interval. `false` for other surfaces, for lines
    /// almost parallel to the plane, and where it is not certain.
    pub fn is_clear_of_surface(&self, line: &Line, ends: [f64; 2]) -> bool {
        if self.is_curved() {
            return false;
        }
        let normal = 2.0 * rounded(&self.linear);
        let (o, d) = ((line.o - self.centre) * self.shrink, line.d * self.shrink);
        let (o_err, d_err) = (line.o_err * self.shrink, line.d_err * self.shrink);
        let sum = |v: Vec3| v.abs().element_sum();
        let (length, slope, offset) = (sum(normal), normal.dot(d), normal.dot(o) + self.constant.hi);
        let turn = CLEAR * length * sum(d) + CLEAR_OF_FRAME * normal.abs().dot(d_err);
        let doubt = |t: f64| {
            let size = length * (sum(o) + sum(self.centre * self.shrink)) + self.constant.hi.abs();
            CLEAR * size + CLEAR_OF_FRAME * normal.abs().dot(o_err) + t.abs() * turn + f64::MIN_POSITIVE
        };
        slope.abs() > turn && ends.into_iter().all(|t| -(offset + t * slope) > doubt(t))
    }
}

#[cfg(test)]
mod tests {
    use super::super::Params;
    use super::super::kind;
    use crate::crossing::Crossing;
    use crate::math::Affine;
    use crate::ray::Line;
    use crate::testkit::random::Random;

    #[test]
    fn what_is_clear_of_a_plane_is_no_event_with_its_crossing() {
        let mut random = Random::new(29);
        let (mut clear, mut near) = (0, 0);
        for _ in 0..200_000 {
            let tiny = 2f64.powi(-(random.below(60) as i32));
            let normal = random.direction() + random.direction() * tiny;
            let offset = random.number(-2.0, 2.0);
            let kind = kind("halfspace").unwrap();
            let parts = kind.build(&Params::of(kind, &[&normal.to_array(), &[offset]])).unwrap();
            let plane = parts.single().unwrap();
            // The line starts near the plane or far away, and runs towards it, along it or nearly along it.
            let along = normal.any_orthonormal_vector() * 10f64.powi(random.below(7) as i32);
            let o = normal * (offset / normal.length_squared()) + along
                - normal * random.number(-1.0, 2.0) * tiny;
            let d =
                along * random.number(-1.0, 1.0) + random.direction() * 2f64.powi(-(random.below(50) as i32));
            let mut line = Line::exact(o, d);
            if random.below(2) == 0 {
                line = line.in_frame(&Affine::rotation_xyz(random.point(0.0, 90.0)));
            }
            let from = random.number(-1.0, 1.0);
            let to = from + random.number(0.0, 2.0) * tiny;
            if plane.is_clear_of_surface(&line, from, to) {
                clear += 1;
                let mut list: Vec<Crossing> = Vec::new();
                plane.crossings(&line, &mut list);
                let [enter, exit] = &list[..] else { panic!("{list:?}") };
                assert!(enter.high() < from && exit.low() > to, "{line:?} {from} {to} {list:?}");
                near += usize::from(exit.low() - to < 1e-3 || from - enter.high() < 1e-3);
            }
        }
        assert!(clear > 20_000 && near > 10, "{clear} {near}");
    }
}
