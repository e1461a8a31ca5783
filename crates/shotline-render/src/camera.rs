//! A valid camera and the rays it casts.

use shotline::math::{Affine, Vec3};
use shotline::ray::{InvalidRay, Ray};
use shotline::scene::{Camera, Lens, LightSource};

/// Why a camera is not valid.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum CameraError {
    /// A coordinate is NaN or infinite.
    #[error("`{0}` has a component that is NaN or infinite")]
    NotFinite(&'static str),
    /// The camera has no direction.
    #[error("`eye` and `target` are the same point: move one of them, so that the camera has a direction")]
    NoDirection,
    /// The camera has no upward direction.
    #[error(
        "`up` is zero or along the line from `eye` to `target`: for a view straight down, choose [0, 1, 0]"
    )]
    NoUp,
    /// The angle of view is out of range.
    #[error("`fov` is {0} degrees, but must be above 0 and below 180")]
    Fov(f64),
    /// The height of the picture is out of range.
    #[error("`height` is {0}, but must be positive and finite")]
    Height(f64),
    /// The numbers are too large for rays.
    #[error("the camera is too far out to cast rays: {0}")]
    Ray(#[from] InvalidRay),
}

/// A camera with a picture size: it turns positions in the picture into rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    eye: Vec3,
    forward: Vec3,
    right: Vec3,
    up: Vec3,
    zenith: Vec3,
    projection: Projection,
    /// Width and height of the picture in pixels.
    size: [f64; 2],
}

/// Half the height of the picture: at distance 1, or everywhere.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Projection {
    Perspective(f64),
    Parallel(f64),
}

impl View {
    /// Checks a camera for a picture of `width` times `height` pixels; pixels are square.
    ///
    /// # Errors
    /// [`CameraError`].
    pub fn new(camera: &Camera, width: u32, height: u32) -> Result<View, CameraError> {
        for (name, v) in [("eye", camera.eye), ("target", camera.target), ("up", camera.up)] {
            if !v.is_finite() {
                return Err(CameraError::NotFinite(name));
            }
        }
        let projection = match camera.lens {
            Lens::Pinhole { fov } if fov > 0.0 && fov < 180.0 => {
                Projection::Perspective((fov / 2.0).to_radians().tan())
            }
            Lens::Pinhole { fov } => return Err(CameraError::Fov(fov)),
            Lens::Orthographic { height } if height > 0.0 && height.is_finite() => {
                Projection::Parallel(height / 2.0)
            }
            Lens::Orthographic { height } => return Err(CameraError::Height(height)),
        };
        let (forward, right, up) = basis(camera)?;
        let zenith = unit(camera.up).ok_or(CameraError::NoUp)?;
        let size = [f64::from(width), f64::from(height)];
        Ok(View { eye: camera.eye, forward, right, up, zenith, projection, size })
    }

    /// The ray through a position in the picture, in pixels from its upper left corner: the middle of the first
    /// pixel is at 0.5, 0.5.
    ///
    /// The direction's component along [`View::forward`] is 1, so `t` is the distance from the plane of
    /// the eye. A parallel ray begins on that plane and meets nothing behind it.
    ///
    /// # Errors
    /// [`CameraError::Ray`] where numbers near the largest finite one overflow.
    pub fn ray(&self, x: f64, y: f64) -> Result<Ray, CameraError> {
        let [width, height] = self.size;
        // From -1 to 1 over the height; square pixels make the width follow.
        let across = self.right * ((2.0 * x - width) / height) + self.up * (1.0 - 2.0 * y / height);
        Ok(match self.projection {
            Projection::Perspective(half) => Ray::new(self.eye, self.forward + across * half)?,
            Projection::Parallel(half) => Ray::new(self.eye + across * half, self.forward)?,
        })
    }

    /// The position in the picture, as [`View::ray`] takes it, of a point in front of the eye.
    pub fn position(&self, point: Vec3) -> [f64; 2] {
        let from_eye = point - self.eye;
        let half = match self.projection {
            Projection::Perspective(half) => half * from_eye.dot(self.forward),
            Projection::Parallel(half) => half,
        };
        let [width, height] = self.size;
        let (right, up) = (from_eye.dot(self.right) / half, from_eye.dot(self.up) / half);
        [(width + right * height) / 2.0, (1.0 - up) * height / 2.0]
    }

    /// A light whose rays run along those of the camera.
    pub fn headlight(&self) -> LightSource {
        match self.projection {
            Projection::Perspective(_) => LightSource::Point(self.eye),
            Projection::Parallel(_) => LightSource::Directional(self.forward),
        }
    }

    /// The unit vector into the picture.
    pub fn forward(&self) -> Vec3 {
        self.forward
    }

    /// The unit vector to the right of the picture.
    pub fn right(&self) -> Vec3 {
        self.right
    }

    /// The unit vector along the camera's `up`. Unlike [`View::up`] it need not be perpendicular to the direction of view.
    pub fn zenith(&self) -> Vec3 {
        self.zenith
    }

    /// The unit vector to the top of the picture.
    pub fn up(&self) -> Vec3 {
        self.up
    }
}

/// Turns a camera around its target, by degrees counter-clockwise about its `up`.
pub(crate) fn orbited(camera: &Camera, degrees: f64) -> Camera {
    let turn = Affine::rotation_about(camera.up, degrees);
    let eye = camera.target + turn.vector(camera.eye - camera.target);
    Camera { eye: if degrees == 0.0 { camera.eye } else { eye }, ..*camera }
}

/// Forward, right and up: unit vectors, perpendicular to each other.
fn basis(camera: &Camera) -> Result<(Vec3, Vec3, Vec3), CameraError> {
    // Below this sine the direction of "right" would be mostly rounding.
    const SMALLEST_SINE: f64 = 1e-9;
    let forward = unit(camera.target - camera.eye).ok_or(CameraError::NoDirection)?;
    let up = unit(camera.up).ok_or(CameraError::NoUp)?;
    let right = forward.cross(up);
    if right.length() < SMALLEST_SINE {
        return Err(CameraError::NoUp);
    }
    let right = right.normalize();
    Ok((forward, right, right.cross(forward)))
}

/// The unit vector along a vector, also where the square of its length would overflow or underflow.
pub(crate) fn unit(v: Vec3) -> Option<Vec3> {
    let size = v.abs().max_element();
    (size > 0.0 && size.is_finite()).then(|| (v / size).normalize())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(lens: Lens) -> Camera {
        Camera { eye: Vec3::new(0.0, -10.0, 0.0), target: Vec3::ZERO, up: Vec3::Z, lens }
    }

    #[test]
    fn corners_of_a_pinhole_picture() {
        let view = View::new(&camera(Lens::Pinhole { fov: 90.0 }), 200, 100).unwrap();
        let corner = |x, y| view.ray(x, y).unwrap().direction();
        // tan 45 degrees is 1 up and down, 2 left and right.
        for (got, want) in [
            (corner(0.0, 0.0), Vec3::new(-2.0, 1.0, 1.0)),
            (corner(200.0, 0.0), Vec3::new(2.0, 1.0, 1.0)),
            (corner(0.0, 100.0), Vec3::new(-2.0, 1.0, -1.0)),
            (corner(100.0, 50.0), Vec3::Y),
        ] {
            assert!((got - want).length() < 1e-15, "{got} {want}");
        }
    }

    #[test]
    fn corners_of_a_parallel_picture() {
        let view = View::new(&camera(Lens::Orthographic { height: 4.0 }), 200, 100).unwrap();
        let ray = view.ray(200.0, 100.0).unwrap();
        assert_eq!(ray.direction(), Vec3::Y);
        assert!((ray.origin() - Vec3::new(4.0, -10.0, -2.0)).length() < 1e-14);
    }

    #[test]
    fn positions_are_those_of_rays() {
        for lens in [Lens::Pinhole { fov: 50.0 }, Lens::Orthographic { height: 4.0 }] {
            let view = View::new(&camera(lens), 200, 100).unwrap();
            for [x, y] in [[0.0, 0.0], [100.0, 50.0], [31.5, 87.25]] {
                let [column, row] = view.position(view.ray(x, y).unwrap().at(7.0));
                assert!((column - x).abs() < 1e-9 && (row - y).abs() < 1e-9, "{column} {row}");
            }
        }
    }

    #[test]
    fn invalid_cameras_are_errors() {
        let pinhole = camera(Lens::Pinhole { fov: 40.0 });
        let error = |c: Camera| View::new(&c, 8, 6).unwrap_err();
        assert_eq!(error(Camera { target: pinhole.eye, ..pinhole }), CameraError::NoDirection);
        assert_eq!(error(Camera { up: Vec3::Y * -3.0, ..pinhole }), CameraError::NoUp);
        assert_eq!(error(Camera { up: Vec3::ZERO, ..pinhole }), CameraError::NoUp);
        assert_eq!(error(Camera { eye: Vec3::NAN, ..pinhole }), CameraError::NotFinite("eye"));
        assert_eq!(error(camera(Lens::Pinhole { fov: 180.0 })), CameraError::Fov(180.0));
        assert_eq!(error(camera(Lens::Orthographic { height: -1.0 })), CameraError::Height(-1.0));
    }
}
