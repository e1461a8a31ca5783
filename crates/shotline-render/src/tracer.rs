//! What a ray sees: the first surface, and whether anything occludes a light.

use shotline::compile::World;
use shotline::counters::Counters;
use shotline::crossing::GROUPING;
use shotline::math::{HALF_ULP, Vec3};
use shotline::query::{Caster, CoherenceHint, Hit, Overlaps, QueryError, Scope, Segment, Watch};
use shotline::ray::{Ray, Span};

use crate::temporal_cache::SweptBounds;

/// What rays reuse from earlier rays. It does not change the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Coherence {
    /// The shadow cache, one for each lamp and thread: a ray to a lamp first tests what occluded the last one.
    pub shadows: bool,
    /// A ray from the camera first tests what the one before it met. Off by default: it gains nothing, since
    /// boxes are opened nearest first anyway.
    pub neighbours: bool,
    /// An animation renders a pixel once if nothing that moves can change it.
    pub frames: bool,
}

impl Default for Coherence {
    fn default() -> Coherence {
        Coherence { shadows: true, neighbours: false, frames: true }
    }
}

/// Traces the rays of pixels: one thread's caster, with memory for its lists.
pub struct PixelTracer<'w> {
    caster: Caster<'w>,
    coherence: Coherence,
    swept: Option<&'w SweptBounds>,
    /// Whether a ray of this pixel has met the swept bounds.
    meets_motion: bool,
    /// By lamp, what occluded the last ray to it that was occluded: the shadow cache.
    occluders: Vec<CoherenceHint>,
    /// What the last ray of any other kind met.
    last: CoherenceHint,
    segments: Vec<Segment>,
}

/// A point on a surface.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint {
    /// The crossing.
    pub hit: Hit,
    /// The unit normal on the side that the ray comes from. Surfaces without an inside have two sides, and a
    /// solid may be seen from within: both are shaded like any other.
    pub normal: Vec3,
    /// A point beside the surface from which other rays can start, see [`offset_from_surface`].
    pub start: Vec3,
}

impl<'w> PixelTracer<'w> {
    pub fn new(
        world: &'w World,
        coherence: Coherence,
        swept: Option<&'w SweptBounds>,
        watch: Watch<'w>,
    ) -> PixelTracer<'w> {
        let mut caster = Caster::new(world);
        caster.watch(watch);
        PixelTracer {
            caster,
            coherence,
            swept,
            meets_motion: false,
            occluders: Vec::new(),
            last: CoherenceHint::default(),
            segments: Vec::new(),
        }
    }

    /// Begins a pixel.
    pub fn begin_pixel(&mut self) {
        self.meets_motion = false;
    }

    /// Whether nothing that moves can change what the rays of this pixel have met.
    pub fn is_static(&self) -> bool {
        self.swept.is_some() && !self.meets_motion
    }

    /// Records whether a ray meets the swept bounds in a span.
    fn record_motion(&mut self, ray: &Ray, span: Span) {
        self.meets_motion = self.meets_motion || self.swept.is_some_and(|swept| swept.meets(ray, span));
    }

    /// Returns the work done since the last call.
    pub fn take_counters(&mut self) -> Counters {
        self.caster.take_counters()
    }

    /// The first surface a ray meets. A solid in which the ray starts is seen from within.
    ///
    /// # Errors
    /// As [`Caster::closest`].
    pub fn surface(&mut self, ray: &Ray) -> Result<Option<SurfacePoint>, QueryError> {
        let surfaces = Scope::surfaces(Span::FORWARD);
        let hit = match self.coherence.neighbours {
            true => self.caster.closest_with_hint(&mut self.last, ray, surfaces)?,
            false => self.caster.closest(ray, surfaces)?,
        };
        self.record_motion(ray, hit.and_then(|hit| Span::new(0.0, hit.t).ok()).unwrap_or(Span::FORWARD));
        Ok(hit.map(|hit| {
            let normal = if hit.normal.dot(ray.direction()) > 0.0 { -hit.normal } else { hit.normal };
            SurfacePoint { hit, normal, start: offset_from_surface(ray, &hit, normal) }
        }))
    }

    /// Whether a surface lies between a point and the point `reach` lengths of `toward` away from it. `lamp` is
    /// the number of the lamp there, if it is a lamp: each lamp has its own shadow cache.
    ///
    /// # Errors
    /// As [`Caster::any`].
    pub fn is_occluded(
        &mut self,
        point: &SurfacePoint,
        toward: Vec3,
        reach: f64,
        lamp: Option<usize>,
    ) -> Result<bool, QueryError> {
        let (Ok(ray), Ok(span)) = (Ray::new(point.start, toward), Span::new(0.0, reach)) else {
            return Ok(false);
        };
        self.record_motion(&ray, span);
        match lamp.filter(|_| self.coherence.shadows) {
            None => self.caster.any(&ray, Scope::surfaces(span)),
            Some(lamp) => {
                if self.occluders.len() <= lamp {
                    self.occluders.resize_with(lamp + 1, CoherenceHint::default);
                }
                self.caster.any_with_hint(&mut self.occluders[lamp], &ray, Scope::surfaces(span))
            }
        }
    }

    /// The work that the closest crossing of a ray costs.
    ///
    /// # Errors
    /// As [`Caster::closest`].
    pub fn closest_work(&mut self, ray: &Ray) -> Result<Counters, QueryError> {
        self.caster.take_counters();
        self.caster.closest(ray, Span::FORWARD)?;
        Ok(self.caster.take_counters())
    }

    /// The segments of a ray inside objects. Where objects overlap, the one of higher priority owns the segment.
    ///
    /// # Errors
    /// As [`Caster::segments`].
    pub fn segments(&mut self, ray: &Ray) -> Result<&[Segment], QueryError> {
        self.segments.clear();
        self.record_motion(ray, Span::FORWARD);
        self.caster.segments(ray, Span::FORWARD, Overlaps::Priority, &mut self.segments)?;
        Ok(&self.segments)
    }
}

/// The point from which rays leave a surface: beside it, on the side of the normal.
///
/// The point `o + t d` misses the surface by the error of `t` (at most `t_err` lengths of `d`) and by the rounding
/// of the product and of the sum. Both have known bounds. The offset is a few times the sum of these bounds: far
/// below anything visible, and right for a screw and for a planet alike. A fixed distance would be wrong for one
/// of them: too small, it puts shadows on lit faces; too large, it lets light through thin sheets. The offset is
/// along the normal, not along the new ray: a ray that runs nearly along the surface would not leave it.
fn offset_from_surface(ray: &Ray, hit: &Hit, normal: Vec3) -> Vec3 {
    let step = ray.direction().length();
    let rounding = 4.0 * HALF_ULP * (ray.origin().length() + hit.t.abs() * step);
    ray.at(hit.t) + normal * (GROUPING * (hit.t_err * step + rounding))
}
