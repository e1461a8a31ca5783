//! Why there is no picture.

use shotline::query::QueryError;

use crate::camera::CameraError;
use crate::light::LightError;

/// Why there is no picture, and how to mend it.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RenderError {
    /// The size is zero or beyond what a picture may have.
    #[error(
        "a picture of {width}x{height} pixels: each side must be from 1 to {MAX_SIDE}, all pixels at most {MAX_PIXELS}"
    )]
    Size {
        /// The width asked for.
        width: u32,
        /// The height asked for.
        height: u32,
    },
    /// The number of samples is zero or beyond reason.
    #[error("{0} samples a pixel: it must be from 1 to {MAX_SAMPLES}")]
    Samples(u32),
    /// The camera cannot see.
    #[error("the camera: {0}")]
    Camera(#[from] CameraError),
    /// A light does not shine.
    #[error("light {index}: {error}")]
    Light {
        /// Its place in the scene's list, from 0.
        index: usize,
        /// Why.
        error: LightError,
    },
    /// The scene has no camera, and nothing of finite size to point one at.
    #[error("the scene has no camera and nothing of finite size to frame: give it a camera")]
    NothingToFrame,
    /// The look asks a question that the world does not answer.
    #[error("the look '{look}' needs solids, which have an inside: {error}; close the mesh or choose 'lit'")]
    NotSolid {
        /// The look.
        look: &'static str,
        /// Why.
        error: QueryError,
    },
    /// A ray of the picture costs too much.
    #[error("a ray of the picture ends without an answer: {0}; place fewer parts in one another")]
    Ray(QueryError),
    /// The threads could not be started.
    #[error("cannot start {threads} threads: {why}")]
    Threads {
        /// How many were asked for; 0 for one a core.
        threads: usize,
        /// Why.
        why: String,
    },
    /// It was cancelled.
    #[error("cancelled")]
    Cancelled,
}

impl RenderError {
    /// Why there is no picture in a look if a ray has no answer.
    pub(crate) fn of(look: &'static str, error: QueryError) -> RenderError {
        match error {
            QueryError::Cancelled => RenderError::Cancelled,
            error @ QueryError::NotASolid { .. } => RenderError::NotSolid { look, error },
            error => RenderError::Ray(error),
        }
    }
}

/// The longest side of a picture, in pixels.
pub const MAX_SIDE: u32 = 1 << 16;
/// The most pixels of a picture.
pub const MAX_PIXELS: u64 = 1 << 28;
/// The most samples a pixel.
pub const MAX_SAMPLES: u32 = 1 << 16;
