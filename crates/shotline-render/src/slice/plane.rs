//! The plane of a slice, and the directions in it.

use std::str::FromStr;

use shotline::math::Vec3;

use crate::clip_plane::{ClipPlane, InvalidClipPlane};

/// The plane of a slice, with two perpendicular axes in it. Coordinates along them are in world units, and those of the
/// point `p` are `u . p` and `v . p`: for planes across an axis of the world they are two of its coordinates.
///
/// `v` is the direction in the plane nearest to +z, or nearest to +y where the largest component of the normal is that along
/// z. `u` is perpendicular to it, and its largest component is positive. So `z=c` has the axes x and y, `x=c` y and z, and
/// `y=c` x and z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlicePlane {
    normal: Vec3,
    distance: f64,
    u: Vec3,
    v: Vec3,
}

/// The text or the numbers are not those of a plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum InvalidSlicePlane {
    /// The text is not a plane.
    #[error("expected a plane: x=1, y=-2, z=0, or four numbers NX,NY,NZ,D, for the points p with N.p = D")]
    Text,
    /// The numbers are not those of a plane.
    #[error(transparent)]
    Numbers(InvalidClipPlane),
}

impl SlicePlane {
    /// The plane of the points `p` with `normal . p = offset`.
    ///
    /// # Errors
    /// [`InvalidSlicePlane::Numbers`] for a normal of zero, NaN and infinite numbers.
    pub fn new(normal: Vec3, offset: f64) -> Result<SlicePlane, InvalidSlicePlane> {
        ClipPlane::new(normal, offset).map(SlicePlane::of).map_err(InvalidSlicePlane::Numbers)
    }

    fn of(plane: ClipPlane) -> SlicePlane {
        let normal = plane.outward();
        let largest = largest_component(normal);
        let up = if largest == 2 { Vec3::Y } else { Vec3::Z };
        let v = (up - normal * normal.dot(up)).normalize();
        let u = v.cross(normal).normalize();
        let u = if u[largest_component(u)] < 0.0 { -u } else { u };
        // A sum with 0 turns -0 into 0.
        SlicePlane { normal, distance: plane.distance(), u: u + Vec3::ZERO, v: v + Vec3::ZERO }
    }

    /// The unit normal.
    pub fn normal(&self) -> Vec3 {
        self.normal
    }

    /// The distance of the plane from the origin along its normal.
    pub fn distance(&self) -> f64 {
        self.distance
    }

    /// The axis to the right, of unit length.
    pub fn u(&self) -> Vec3 {
        self.u
    }

    /// The axis upwards, of unit length.
    pub fn v(&self) -> Vec3 {
        self.v
    }

    /// The point with some coordinates in the plane.
    pub fn at(&self, u: f64, v: f64) -> Vec3 {
        self.normal * self.distance + self.u * u + self.v * v
    }

    /// What the axes are called: after an axis of the world if they are one, else u and v.
    pub fn axis_names(&self) -> [&'static str; 2] {
        let name = |axis: Vec3, other| {
            let named = [("x", Vec3::X), ("y", Vec3::Y), ("z", Vec3::Z)];
            named.iter().find(|(_, world)| *world == axis).map_or(other, |(name, _)| *name)
        };
        [name(self.u, "u"), name(self.v, "v")]
    }
}

impl FromStr for SlicePlane {
    type Err = InvalidSlicePlane;

    /// `x=1`, `y=-2`, `z=0` or `NX,NY,NZ,D`, as the planes that cut a picture.
    fn from_str(text: &str) -> Result<SlicePlane, InvalidSlicePlane> {
        match text.parse::<ClipPlane>() {
            Ok(plane) => Ok(SlicePlane::of(plane)),
            Err(InvalidClipPlane::Text) => Err(InvalidSlicePlane::Text),
            Err(error) => Err(InvalidSlicePlane::Numbers(error)),
        }
    }
}

/// `z = 0`, or the unit normal and the distance.
impl std::fmt::Display for SlicePlane {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        for (name, axis) in [("x", Vec3::X), ("y", Vec3::Y), ("z", Vec3::Z)] {
            if self.normal == axis || self.normal == -axis {
                let distance = self.distance * self.normal.dot(axis);
                return write!(f, "{name} = {}", in_short(distance));
            }
        }
        let [x, y, z] = self.normal.to_array().map(rounded);
        write!(f, "({x}, {y}, {z}) · p = {}", in_short(rounded(self.distance)))
    }
}

/// A number with six decimals at most.
fn rounded(x: f64) -> f64 {
    // Larger numbers have no decimals to lose, and might overflow.
    if x.abs() < 1e9 { (x * 1e6).round() / 1e6 + 0.0 } else { x }
}

/// A number without long runs of zeros.
fn in_short(x: f64) -> String {
    if x == 0.0 || (1e-4..1e15).contains(&x.abs()) { (x + 0.0).to_string() } else { format!("{x:e}") }
}

/// The axis of the largest component, the first of those that are equal.
fn largest_component(v: Vec3) -> usize {
    let size = v.abs();
    (0..3).rev().max_by(|&a, &b| size[a].total_cmp(&size[b])).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plane(text: &str) -> SlicePlane {
        text.parse().expect("a plane")
    }

    #[test]
    fn planes_across_an_axis_have_the_axes_of_the_world() {
        for (text, normal, u, v) in [
            ("z=3", Vec3::Z, Vec3::X, Vec3::Y),
            ("0,0,-2,-6", Vec3::NEG_Z, Vec3::X, Vec3::Y),
            ("x=3", Vec3::X, Vec3::Y, Vec3::Z),
            ("-1,0,0,-3", Vec3::NEG_X, Vec3::Y, Vec3::Z),
            ("y=3", Vec3::Y, Vec3::X, Vec3::Z),
            ("0,-4,0,-12", Vec3::NEG_Y, Vec3::X, Vec3::Z),
        ] {
            let plane = plane(text);
            assert_eq!((plane.normal(), plane.u(), plane.v()), (normal, u, v), "{text}");
            assert_eq!(plane.at(1.0, 2.0), normal.abs() * 3.0 + u + v * 2.0, "{text}");
        }
        assert_eq!(plane("z=3").axis_names(), ["x", "y"]);
        assert_eq!(
            (plane("0,0,-2,-6").to_string(), plane("x=0").to_string()),
            ("z = 3".into(), "x = 0".into())
        );
        for (text, shown) in [
            ("z=1e300", "z = 1e300"),
            ("y=-1e-300", "y = -1e-300"),
            ("x=123456.789", "x = 123456.789"),
            ("3,4,0,5e300", "(0.6, 0.8, 0) · p = 1e300"),
            ("3,4,0,1", "(0.6, 0.8, 0) · p = 0.2"),
        ] {
            assert_eq!(plane(text).to_string(), shown);
        }
    }

    #[test]
    fn axes_are_perpendicular_and_turn_evenly() {
        for text in ["1,1,0,2", "1,2,3,-4", "1e-9,0,1,0", "0,1,1e-3,5", "-3,1,-2,1e3"] {
            let plane = plane(text);
            let (n, u, v) = (plane.normal(), plane.u(), plane.v());
            for (a, b) in [(n, u), (u, v), (v, n)] {
                assert!(a.dot(b).abs() < 1e-15 && (a.length() - 1.0).abs() < 1e-15, "{text}");
            }
            assert!((n.dot(plane.at(5.0, -7.0)) - plane.distance()).abs() < 1e-12, "{text}");
        }
        assert!((plane("1e-9,0,1,0").v() - Vec3::Y).length() < 1e-8);
        assert_eq!(plane("1,1,0,2").axis_names(), ["u", "z"]);
    }

    #[test]
    fn what_is_no_plane_is_refused() {
        assert_eq!("w=1".parse::<SlicePlane>(), Err(InvalidSlicePlane::Text));
        let no_normal = InvalidSlicePlane::Numbers(InvalidClipPlane::NoNormal);
        assert_eq!("0,0,0,1".parse::<SlicePlane>(), Err(no_normal));
    }
}
