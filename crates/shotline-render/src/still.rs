//! Which pixels stand still while things move, and so can be taken over from the frame before.

use shotline::aabb::{Aabb, BoxRay};
use shotline::ray::{Line, Ray, Span};

use crate::film::Sample;

/// Everywhere that moving things are, in all frames.
#[derive(Clone, Debug)]
pub struct Swept {
    around: Aabb,
    boxes: Vec<Aabb>,
}

impl Swept {
    pub fn new(boxes: Vec<Aabb>) -> Swept {
        Swept { around: boxes.iter().fold(Aabb::EMPTY, |all, b| all.union(b)), boxes }
    }

    /// Whether anything that moves can ever be met by a ray in a span. The boxes are those that worlds look
    /// through, and they are tested as there: what is not met here is not met there.
    pub fn meets(&self, ray: &Ray, span: Span) -> bool {
        let ray = BoxRay::new(&Line::of(ray), span);
        let meets = |b: &Aabb| ray.enter_exit(b).is_some();
        meets(&self.around) && self.boxes.iter().any(meets)
    }
}

/// What the next frame may take over.
#[derive(Clone, Debug, Default)]
pub struct Kept {
    /// `None` to take over nothing.
    pub swept: Option<Swept>,
    /// By pixel, what it shows if that cannot change. Empty before the first frame.
    pub pixels: Vec<Option<Sample>>,
}
