//! From where a picture is seen, where that is not what the scene says.

use std::str::FromStr;

use shotline::aabb::Aabb;
use shotline::math::Vec3;
use shotline::scene::{Camera, Lens};

use crate::error::RenderError;
use crate::framing;

/// The vertical angle of view of a camera that is given without one, in degrees, as in scene files.
const FOV: f64 = 40.0;

/// Changes to the camera of a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Viewpoint {
    /// A standard view of everything, in parallel projection unless an angle of view is given.
    pub view: Option<StandardView>,
    /// Where the eye is.
    pub eye: Option<Vec3>,
    /// What it looks at; the middle of everything if only the eye is given.
    pub target: Option<Vec3>,
    /// The direction that points up in the picture.
    pub up: Option<Vec3>,
    /// The vertical angle of view, in degrees.
    pub fov: Option<f64>,
    /// By how much the picture is magnified about its middle.
    pub zoom: Option<f64>,
}

/// The standard views of technical drawings; z is up, and the front faces -y.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StandardView {
    /// From -y.
    Front,
    /// From +y.
    Back,
    /// From -x.
    Left,
    /// From +x.
    Right,
    /// From +z, with y up.
    Top,
    /// From -z, with y up.
    Bottom,
    /// Isometric: from the front, the right and above.
    Iso,
}

impl StandardView {
    /// All views with their names.
    pub const NAMED: &[(&str, StandardView)] = &[
        ("front", StandardView::Front),
        ("back", StandardView::Back),
        ("left", StandardView::Left),
        ("right", StandardView::Right),
        ("top", StandardView::Top),
        ("bottom", StandardView::Bottom),
        ("iso", StandardView::Iso),
    ];

    /// The direction from the scene to the eye, and the direction that points up in the picture.
    fn directions(self) -> (Vec3, Vec3) {
        match self {
            StandardView::Front => (-Vec3::Y, Vec3::Z),
            StandardView::Back => (Vec3::Y, Vec3::Z),
            StandardView::Left => (-Vec3::X, Vec3::Z),
            StandardView::Right => (Vec3::X, Vec3::Z),
            StandardView::Top => (Vec3::Z, Vec3::Y),
            StandardView::Bottom => (-Vec3::Z, Vec3::Y),
            StandardView::Iso => (Vec3::new(1.0, -1.0, 1.0), Vec3::Z),
        }
    }
}

impl FromStr for StandardView {
    type Err = String;

    fn from_str(name: &str) -> Result<StandardView, String> {
        let found = StandardView::NAMED.iter().find(|(known, _)| *known == name);
        let names = || StandardView::NAMED.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ");
        found.map(|(_, view)| *view).ok_or_else(|| format!("the views are {}", names()))
    }
}

impl Viewpoint {
    /// The camera of a picture whose width is `ratio` times its height: that of the scene, or one that frames a box, with these
    /// changes.
    ///
    /// # Errors
    /// [`RenderError::NothingToFrame`] if there is neither a camera nor a box to frame, [`RenderError::Zoom`],
    /// [`RenderError::ZoomBeyondLens`].
    pub(crate) fn camera(
        &self,
        of_scene: Option<Camera>,
        subject: Option<Aabb>,
        ratio: f64,
    ) -> Result<Camera, RenderError> {
        let camera = match (self.view, self.eye) {
            (Some(view), _) => {
                let (from, up) = view.directions();
                subject.and_then(|bounds| framing::frame_from(&bounds, ratio, from, up, self.fov))
            }
            (None, Some(eye)) => self.at_eye(eye, of_scene, subject),
            (None, None) => {
                let framed = || subject.and_then(|bounds| framing::frame(&bounds, ratio));
                of_scene.or_else(framed).map(|camera| self.turned(camera))
            }
        };
        self.zoomed(camera.ok_or(RenderError::NothingToFrame)?)
    }

    /// A camera at a given point, with what the scene's camera says of the rest.
    fn at_eye(&self, eye: Vec3, of_scene: Option<Camera>, subject: Option<Aabb>) -> Option<Camera> {
        let middle = || subject.map(|bounds| bounds.centre());
        let target = self.target.or_else(|| of_scene.map(|camera| camera.target)).or_else(middle)?;
        let forward = target - eye;
        let is_vertical = forward.x == 0.0 && forward.y == 0.0;
        let default_up = if is_vertical { Vec3::Y } else { of_scene.map_or(Vec3::Z, |camera| camera.up) };
        let lens = of_scene.map_or(Lens::Pinhole { fov: FOV }, |camera| camera.lens);
        Some(self.turned(Camera { eye, target, up: default_up, lens }))
    }

    /// A camera with this target, upward direction and angle of view, where they are given.
    fn turned(&self, camera: Camera) -> Camera {
        Camera {
            target: self.target.unwrap_or(camera.target),
            up: self.up.unwrap_or(camera.up),
            lens: self.fov.map_or(camera.lens, |fov| Lens::Pinhole { fov }),
            ..camera
        }
    }

    fn zoomed(&self, camera: Camera) -> Result<Camera, RenderError> {
        let Some(zoom) = self.zoom else { return Ok(camera) };
        if !(zoom > 0.0 && zoom.is_finite()) {
            return Err(RenderError::Zoom(zoom));
        }
        let lens = match camera.lens {
            Lens::Pinhole { fov } => {
                let slope = (fov / 2.0).to_radians().tan() / zoom;
                Lens::Pinhole { fov: 2.0 * slope.atan().to_degrees() }
            }
            Lens::Orthographic { height } => Lens::Orthographic { height: height / zoom },
        };
        // A lens that was invalid before is refused with the camera.
        if is_open(camera.lens) && !is_open(lens) {
            return Err(RenderError::ZoomBeyondLens(zoom));
        }
        Ok(Camera { lens, ..camera })
    }
}

/// Whether a lens sees something: its angle or its height is within the range of cameras.
fn is_open(lens: Lens) -> bool {
    match lens {
        Lens::Pinhole { fov } => fov > 0.0 && fov < 180.0,
        Lens::Orthographic { height } => height > 0.0 && height.is_finite(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOX: Aabb = Aabb { min: Vec3::new(1.0, 2.0, 3.0), max: Vec3::new(5.0, 4.0, 4.0) };

    fn camera(viewpoint: Viewpoint, of_scene: Option<Camera>) -> Camera {
        viewpoint.camera(of_scene, Some(BOX), 2.0).unwrap()
    }

    #[test]
    fn standard_views_are_parallel_and_hold_everything() {
        for (name, view) in StandardView::NAMED {
            assert_eq!(name.parse(), Ok(*view));
            let found = camera(Viewpoint { view: Some(*view), ..Viewpoint::default() }, None);
            assert!((found.target - BOX.centre()).length() < 1e-12, "{name}");
            let Lens::Orthographic { height } = found.lens else { panic!("{name}") };
            // The front is 4 wide and 1 high, in a picture twice as wide as high.
            if *view == StandardView::Front {
                assert!((height - 2.0 / 0.92).abs() < 1e-12 && found.eye.y < BOX.min.y);
            }
        }
        let fov = Some(20.0);
        let wide = camera(Viewpoint { view: Some(StandardView::Iso), fov, ..Viewpoint::default() }, None);
        assert_eq!(wide.lens, Lens::Pinhole { fov: 20.0 });
        assert!("side".parse::<StandardView>().unwrap_err().contains("front, back, left"));
    }

    #[test]
    fn an_eye_looks_at_the_middle_unless_it_is_told_otherwise() {
        let eye = Some(Vec3::new(0.0, -9.0, 0.0));
        let found = camera(Viewpoint { eye, ..Viewpoint::default() }, None);
        assert_eq!((found.target, found.up, found.lens), (BOX.centre(), Vec3::Z, Lens::Pinhole { fov: FOV }));
        let above = Some(BOX.centre() + Vec3::Z * 5.0);
        assert_eq!(camera(Viewpoint { eye: above, ..Viewpoint::default() }, None).up, Vec3::Y);
        let own = Camera { lens: Lens::Orthographic { height: 3.0 }, ..found };
        let target = Some(Vec3::ONE);
        let turned = camera(Viewpoint { target, zoom: Some(2.0), ..Viewpoint::default() }, Some(own));
        assert_eq!((turned.eye, turned.target), (own.eye, Vec3::ONE));
        assert_eq!(turned.lens, Lens::Orthographic { height: 1.5 });
    }

    #[test]
    fn a_zoom_magnifies_the_middle() {
        let eye = Some(Vec3::new(0.0, -9.0, 0.0));
        let fov = Some(90.0);
        let found = camera(Viewpoint { eye, fov, zoom: Some(2.0), ..Viewpoint::default() }, None);
        let Lens::Pinhole { fov } = found.lens else { panic!() };
        assert!(((fov / 2.0).to_radians().tan() - 0.5).abs() < 1e-12);
        for zoom in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let wrong = Viewpoint { zoom: Some(zoom), ..Viewpoint::default() };
            assert!(matches!(wrong.camera(None, Some(BOX), 1.0), Err(RenderError::Zoom(_))));
        }
        for (view, zoom) in [(None, 1e-308), (None, 1e-20), (Some(StandardView::Top), 1e-308)] {
            let wrong = Viewpoint { view, zoom: Some(zoom), ..Viewpoint::default() };
            let found = wrong.camera(None, Some(BOX), 1.0);
            assert!(matches!(found, Err(RenderError::ZoomBeyondLens(_))), "{view:?}");
        }
        let nothing = Viewpoint::default().camera(None, None, 1.0);
        assert!(matches!(nothing, Err(RenderError::NothingToFrame)));
    }
}
