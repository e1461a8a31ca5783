//! The part of a scene that a picture shows: planes cut it open, and objects are hidden.

use shotline::query::{Caster, Hit, HitKind, Kinds, Overlaps, QueryError, Scope, Segment};
use shotline::ray::{Ray, Span};
use shotline::scene::{HiddenObjects, Scene};

use crate::clip_plane::{ClipPlane, KeptSpan};

/// What rays see of a world.
#[derive(Clone, Debug, Default)]
pub(crate) struct VisiblePart {
    planes: Vec<ClipPlane>,
    /// By number of an object.
    hidden: Vec<bool>,
    /// Whether objects contain others, differ in priority or are hidden, so that rays see the owners of points and not the outermost surfaces.
    shows_owners: bool,
}

impl VisiblePart {
    pub fn new(scene: &Scene, hidden: &HiddenObjects, planes: &[ClipPlane]) -> VisiblePart {
        let shows_owners = scene.has_owners() || !hidden.is_empty();
        let hidden = if shows_owners { hidden.by_number(scene) } else { Vec::new() };
        VisiblePart { planes: planes.to_vec(), hidden, shows_owners }
    }

    /// Whether rays see the surfaces of all bodies, whole.
    pub fn is_everything(&self) -> bool {
        !self.shows_owners && self.planes.is_empty()
    }

    /// What a ray sees first in a span. A hit of kind [`HitKind::Start`] is at a plane that cuts through an object, and has the
    /// normal of that plane.
    pub fn closest(&self, caster: &mut Caster, ray: &Ray, span: Span) -> Result<Option<Hit>, QueryError> {
        let Some(KeptSpan { span, cut }) = KeptSpan::new(&self.planes, ray, span) else { return Ok(None) };
        // A ray that begins inside without a cut sees the object from within.
        let kinds = if cut.is_some() { Kinds::All } else { Kinds::Surfaces };
        let hit = self.first(caster, ray, Scope { span, kinds })?;
        Ok(hit.map(|hit| match cut {
            Some(normal) if hit.kind == HitKind::Start => Hit { normal, ..hit },
            _ => hit,
        }))
    }

    /// Whether a surface is in a span of a ray.
    pub fn occludes(&self, caster: &mut Caster, ray: &Ray, span: Span) -> Result<bool, QueryError> {
        let Some(KeptSpan { span, .. }) = KeptSpan::new(&self.planes, ray, span) else { return Ok(false) };
        if self.shows_owners {
            Ok(self.first(caster, ray, Scope::surfaces(span))?.is_some())
        } else {
            caster.any(ray, Scope::surfaces(span))
        }
    }

    /// Appends the visible segments of a ray.
    pub fn segments(
        &self,
        caster: &mut Caster,
        ray: &Ray,
        span: Span,
        out: &mut Vec<Segment>,
    ) -> Result<(), QueryError> {
        let Some(KeptSpan { span, .. }) = KeptSpan::new(&self.planes, ray, span) else { return Ok(()) };
        caster.segments(ray, span, Overlaps::Priority, out)?;
        out.retain(|segment| !self.hidden.get(segment.object as usize).copied().unwrap_or(false));
        Ok(())
    }

    fn first(&self, caster: &mut Caster, ray: &Ray, scope: Scope) -> Result<Option<Hit>, QueryError> {
        if self.shows_owners {
            caster.first_visible(ray, scope, &self.hidden)
        } else {
            caster.closest(ray, scope)
        }
    }
}
