//! Pixels of an animation that no motion changes, so that the next frame can reuse them.

use shotline::aabb::{Aabb, BoxRay};
use shotline::ray::{Line, Ray, Span};

use crate::exposure::Sample;

/// The boxes in which moving objects are, in all frames.
#[derive(Clone, Debug)]
pub struct SweptBounds {
    union: Aabb,
    boxes: Vec<Aabb>,
}

impl SweptBounds {
    pub fn new(boxes: Vec<Aabb>) -> SweptBounds {
        SweptBounds { union: boxes.iter().fold(Aabb::EMPTY, |all, b| all.union(b)), boxes }
    }

    /// Whether a ray in a span can ever meet a moving object. A world tests the same boxes with the same test
    /// before it tests the objects in them. So a ray that meets no box here meets no moving object there.
    pub fn meets(&self, ray: &Ray, span: Span) -> bool {
        let ray = BoxRay::new(&Line::of(ray), span);
        let meets = |b: &Aabb| ray.enter_exit(b).is_some();
        meets(&self.union) && self.boxes.iter().any(meets)
    }
}

/// What the next frame can reuse.
#[derive(Clone, Debug, Default)]
pub struct TemporalCache {
    /// Where motion can change pixels; `None` to reuse nothing.
    pub swept: Option<SweptBounds>,
    /// By pixel, its sample if that cannot change. Empty before the first frame.
    pub pixels: Vec<Option<Sample>>,
}
