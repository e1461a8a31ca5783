//! Why there is no picture.

use shotline::query::QueryError;
use shotline::query::batch::BatchError;

use crate::camera::CameraError;
use crate::light::LightError;

/// Why there is no picture, and how to correct that.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RenderError {
    /// The size is out of range.
    #[error(
        "a picture of {width}x{height} pixels: each side must be from 1 to {MAX_SIDE}, all pixels at most {MAX_PIXELS}"
    )]
    Size {
        /// The requested width.
        width: u32,
        /// The requested height.
        height: u32,
    },
    /// The number of samples is out of range.
    #[error("{0} samples per pixel: it must be from 1 to {MAX_SAMPLES}")]
    Samples(u32),
    /// The camera is not valid.
    #[error("the camera: {0}")]
    Camera(#[from] CameraError),
    /// A light is not valid.
    #[error("light {index}: {error}")]
    Light {
        /// Its index in the scene's list, from 0.
        index: usize,
        /// Why.
        error: LightError,
    },
    /// The scene has no camera, and nothing of finite size that a camera could frame.
    #[error("the scene has no camera and nothing of finite size to frame: give it a camera")]
    NothingToFrame,
    /// The magnification is out of range.
    #[error("the zoom is {0}, but must be positive and finite")]
    Zoom(f64),
    /// The magnification leaves the camera no picture.
    #[error(
        "a zoom of {0:e} leaves the camera an angle of view of 0 or of 180 degrees: choose one nearer to 1"
    )]
    ZoomBeyondLens(f64),
    /// The look does not show surfaces.
    #[error(
        "the look '{0}' has no edges, since it shows what lies along each ray and no surfaces; choose 'lit', 'normal' or 'depth'"
    )]
    Edges(&'static str),
    /// The look cannot show objects that are seen through.
    #[error(
        "the look '{0}' shows no objects that are seen through; choose 'lit' or 'normal', or make all opaque"
    )]
    Opacity(&'static str),
    /// The look does not hatch cuts.
    #[error("the look '{0}' hatches no cuts; choose 'lit'")]
    Hatch(&'static str),
    /// Cuts are to be hatched, and there are none.
    #[error("there is nothing to hatch: give a plane that cuts the scene open")]
    NothingToHatch,
    /// The look needs solids, and an object of the world is not a solid.
    #[error("the look '{look}' needs solids, which have an inside: {error}; close the mesh or choose 'lit'")]
    NotSolid {
        /// The look.
        look: &'static str,
        /// Why.
        error: QueryError,
    },
    /// A ray of the picture exceeds a limit.
    #[error("a ray of the picture has no result: {0}; nest fewer parts in each other")]
    Ray(QueryError),
    /// The caller cancelled.
    #[error("cancelled")]
    Cancelled,
}

impl RenderError {
    /// The error of a picture in a look, from the error of some of its rays.
    pub(crate) fn of(look: &'static str, error: BatchError) -> RenderError {
        match error {
            BatchError::Cancelled => RenderError::Cancelled,
            BatchError::World(error)
            | BatchError::Query { error: error @ QueryError::NotASolid { .. }, .. } => {
                RenderError::NotSolid { look, error }
            }
            BatchError::Query { error, .. } => RenderError::Ray(error),
            BatchError::Ray { error, .. } => RenderError::Camera(CameraError::Ray(error)),
            // What is left is too little memory: a picture has no limit of rows.
            _ => RenderError::Ray(QueryError::OutOfMemory),
        }
    }
}

/// The longest side of a picture, in pixels.
pub const MAX_SIDE: u32 = 1 << 16;
/// The maximum number of pixels of a picture.
pub const MAX_PIXELS: u64 = 1 << 28;
/// The maximum number of samples per pixel.
pub const MAX_SAMPLES: u32 = 1 << 16;
