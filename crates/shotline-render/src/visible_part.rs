//! The part of a scene that a picture shows: planes cut it open, and objects are hidden or seen through.

use shotline::crossing::GROUPING;
use shotline::math::HALF_ULP;
use shotline::query::{Caster, Hit, HitKind, Kinds, Overlaps, QueryError, Scope, Segment};
use shotline::ray::{Ray, Span};
use shotline::scene::{HiddenObjects, Scene};

use crate::clip_plane::{ClipPlane, KeptSpan};
use crate::opacity::Opacities;

/// The most surfaces that a ray sees through others.
const MAX_LAYERS: u32 = 16;
/// What covers less than this of a pixel is not looked for.
const FAINT: f64 = 1.0 / 512.0;

/// What rays see of a world.
#[derive(Clone, Debug, Default)]
pub(crate) struct VisiblePart {
    planes: Vec<ClipPlane>,
    /// By number of an object.
    hidden: Vec<bool>,
    /// By number of an object, whether it is hidden or seen through, and so has no shadow.
    shadowless: Vec<bool>,
    opacities: Opacities,
    /// Whether objects contain others, differ in priority, are hidden or seen through, so that rays see the owners of points and not the outermost surfaces.
    shows_owners: bool,
}

impl VisiblePart {
    pub fn new(
        scene: &Scene,
        hidden: &HiddenObjects,
        planes: &[ClipPlane],
        opacities: &Opacities,
    ) -> VisiblePart {
        let shows_owners = scene.has_owners() || !hidden.is_empty() || !opacities.is_opaque();
        let hidden = if shows_owners { hidden.by_number(scene) } else { Vec::new() };
        let is_shadowless = |(object, is_hidden): (u32, &bool)| *is_hidden || opacities.of(object) < 1.0;
        let shadowless = (0..).zip(&hidden).map(is_shadowless).collect();
        let (planes, opacities) = (planes.to_vec(), opacities.clone());
        VisiblePart { planes, hidden, shadowless, opacities, shows_owners }
    }

    /// Whether rays see one surface, or several of objects that are seen through.
    pub fn is_opaque(&self) -> bool {
        self.opacities.is_opaque()
    }

    /// Whether rays see the surfaces of all bodies, whole.
    pub fn is_everything(&self) -> bool {
        !self.shows_owners && self.planes.is_empty()
    }

    /// What a ray sees first in a span. A hit of kind [`HitKind::Start`] is at a plane that cuts through an object, and has the
    /// normal of that plane.
    pub fn closest(&self, caster: &mut Caster, ray: &Ray, span: Span) -> Result<Option<Hit>, QueryError> {
        self.closest_without(caster, ray, span, &self.hidden)
    }

    /// What a ray sees first that is not seen through.
    pub fn closest_opaque(&self, caster: &mut Caster, ray: &Ray) -> Result<Option<Hit>, QueryError> {
        self.closest_without(caster, ray, Span::FORWARD, &self.shadowless)
    }

    fn closest_without(
        &self,
        caster: &mut Caster,
        ray: &Ray,
        span: Span,
        hidden: &[bool],
    ) -> Result<Option<Hit>, QueryError> {
        let Some(KeptSpan { span, cut }) = KeptSpan::new(&self.planes, ray, span) else { return Ok(None) };
        // A ray that begins inside without a cut sees the object from within.
        let kinds = if cut.is_some() { Kinds::All } else { Kinds::Surfaces };
        let hit = self.first(caster, ray, Scope { span, kinds }, hidden)?;
        Ok(hit.map(|hit| match cut {
            Some(normal) if hit.kind == HitKind::Start => Hit { normal, ..hit },
            _ => hit,
        }))
    }

    /// Passes the surfaces that a ray sees to `take`, nearest first, each with the share of the pixel that it covers: all up to the
    /// first opaque one.
    pub fn layers(
        &self,
        caster: &mut Caster,
        ray: &Ray,
        mut take: impl FnMut(&Hit, f64),
    ) -> Result<(), QueryError> {
        let (mut span, mut left) = (Span::FORWARD, 1.0);
        for _ in 0..MAX_LAYERS {
            let Some(hit) = self.closest(caster, ray, span)? else { break };
            let opacity = self.opacities.of(hit.object);
            take(&hit, left * opacity);
            left *= 1.0 - opacity;
            let Some(behind) = behind(&hit).filter(|_| left >= FAINT) else { break };
            span = behind;
        }
        Ok(())
    }

    /// Whether a surface is in a span of a ray that is not of an object that is seen through.
    pub fn occludes(&self, caster: &mut Caster, ray: &Ray, span: Span) -> Result<bool, QueryError> {
        let Some(KeptSpan { span, .. }) = KeptSpan::new(&self.planes, ray, span) else { return Ok(false) };
        if self.shows_owners {
            Ok(self.first(caster, ray, Scope::surfaces(span), &self.shadowless)?.is_some())
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

    fn first(
        &self,
        caster: &mut Caster,
        ray: &Ray,
        scope: Scope,
        hidden: &[bool],
    ) -> Result<Option<Hit>, QueryError> {
        if self.shows_owners { caster.first_visible(ray, scope, hidden) } else { caster.closest(ray, scope) }
    }
}

/// What is behind a hit, beyond all that is one event with it.
fn behind(hit: &Hit) -> Option<Span> {
    let margin = 4.0 * GROUPING * (hit.t_err + HALF_ULP * hit.t.abs());
    Span::new((hit.t + margin).next_up(), f64::INFINITY).ok()
}
