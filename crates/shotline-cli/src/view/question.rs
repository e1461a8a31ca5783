//! What a page can ask.

use serde::Deserialize;
use shotline::accel;
use shotline::counters::{COUNTERS, Counter};
use shotline::math::Vec3;
use shotline::scene::{Camera, Lens};
use shotline_render::{ClipPlane, Look, look};

use crate::trace_report::TraceQuery;

/// A question, with the number by which the page knows the answer.
#[derive(Debug, Deserialize)]
pub struct Asked {
    pub id: u64,
    #[serde(flatten)]
    pub question: Question,
}

/// A question.
#[derive(Debug, Deserialize)]
#[serde(tag = "ask", rename_all = "snake_case")]
pub enum Question {
    /// What is viewed: names, bounds, the camera to begin with.
    Scene,
    /// The camera of a standard view, or without a name that of the scene, for a picture of a size.
    View { name: Option<String>, size: [u32; 2] },
    /// The next step of a picture.
    Draw { pane: usize, picture: PictureOf, coarse: u32 },
    /// The report of the ray through a pixel, or of a given one.
    Shoot { ray: RayOf },
    /// The steps of a ray, with the boxes, cells and planes that it meets.
    Trace { ray: RayOf, accel: Option<String>, query: TraceQuery },
    /// The owners in a plane, as a PNG.
    Slice { plane: [f64; 4], size: [u32; 2], area: Option<[f64; 4]>, by: ColorByOf },
    /// The nodes below a node of the scene graph, or its roots.
    Children { of: Option<u32>, from: usize },
    /// The objects whose names contain a text.
    Find { text: String },
}

/// What has a colour of its own in a slice.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ColorByOf {
    Object,
    Material,
    Instance,
}

/// A picture that a page shows.
#[derive(Clone, Debug, Deserialize, PartialEq)]
pub struct PictureOf {
    pub camera: CameraOf,
    /// Columns and rows.
    pub size: [u32; 2],
    pub look: String,
    pub accel: Option<String>,
    /// What the look `cost` counts.
    pub counter: Option<String>,
    pub shown: ShownOf,
    /// Planes that cut the scene open: a normal, and the greatest height along it that is kept.
    #[serde(default)]
    pub clip: Vec<[f64; 4]>,
}

/// Which objects are shown, by name: all but some, or only some.
#[derive(Clone, Debug, Default, Deserialize, PartialEq)]
pub struct ShownOf {
    #[serde(default)]
    pub hide: Vec<String>,
    #[serde(default)]
    pub only: Vec<String>,
}

/// A camera: in perspective with an angle of view, or parallel with a height.
#[derive(Clone, Debug, Deserialize, PartialEq)]
pub struct CameraOf {
    pub eye: [f64; 3],
    pub target: [f64; 3],
    pub up: [f64; 3],
    pub fov: Option<f64>,
    pub height: Option<f64>,
}

impl CameraOf {
    pub fn camera(&self) -> Camera {
        let lens = match (self.fov, self.height) {
            (_, Some(height)) => Lens::Orthographic { height },
            (fov, None) => Lens::Pinhole { fov: fov.unwrap_or(30.0) },
        };
        let [eye, target, up] = [self.eye, self.target, self.up].map(Vec3::from);
        Camera { eye, target, up, lens }
    }
}

/// A ray: through a position of a picture in pixels, or given.
#[derive(Clone, Debug, Deserialize)]
#[serde(untagged)]
pub enum RayOf {
    Pixel { camera: CameraOf, size: [u32; 2], at: [f64; 2] },
    Given { origin: [f64; 3], direction: [f64; 3] },
}

/// The accelerator with a name.
pub fn accel_named(name: Option<&str>) -> Result<Option<&'static str>, String> {
    let Some(name) = name else { return Ok(None) };
    let found = accel::NAMES.iter().find(|known| **known == name).copied();
    found.map(Some).ok_or_else(|| format!("there is no accelerator '{name}'"))
}

impl PictureOf {
    pub fn look(&self) -> Result<&'static Look, String> {
        look(&self.look).ok_or_else(|| format!("there is no look '{}'", self.look))
    }

    pub fn counter(&self) -> Result<&'static Counter, String> {
        let Some(name) = &self.counter else { return Ok(&COUNTERS[0]) };
        COUNTERS
            .iter()
            .find(|counter| counter.name == name)
            .ok_or_else(|| format!("there is no counter '{name}'"))
    }

    pub fn clip_planes(&self) -> Result<Vec<ClipPlane>, String> {
        let plane = |&[x, y, z, height]: &[f64; 4]| ClipPlane::new(Vec3::new(x, y, z), height);
        self.clip.iter().map(plane).collect::<Result<_, _>>().map_err(|error| error.to_string())
    }
}
