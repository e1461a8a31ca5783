//! Lines for the boxes of levels, which may be in a frame of their own.

use crate::aabb::BoxRay;
use crate::compile::Level;
use crate::ray::{Line, Span};

/// A line in a level, for the boxes of the level.
pub(super) fn box_ray(level: &Level, line: &Line, span: Span) -> BoxRay {
    match &level.box_frame {
        None => BoxRay::new(line, span),
        Some(frame) => BoxRay::new(&line.in_frame(frame), span),
    }
}
