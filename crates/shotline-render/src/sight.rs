//! What a ray sees: the first surface, and whether anything is between it and a light.

use shotline::compile::World;
use shotline::counters::Counters;
use shotline::crossing::GROUPING;
use shotline::math::{HALF_ULP, Vec3};
use shotline::query::{Caster, CoherenceHint, Hit, Overlaps, QueryError, Scope, Segment, Watch};
use shotline::ray::{Ray, Span};

use crate::still::Swept;

/// What rays may take over from those before them. None of it changes a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Coherence {
    /// A ray to a lamp first asks what the last one to it met: the shadow cache, one for each lamp and thread.
    pub shadows: bool,
    /// A ray from the camera first asks what the one before it met. Off by default: it gains nothing, since
    /// boxes are opened nearest first anyway.
    pub neighbours: bool,
    /// In an animation, pixels that nothing moving can touch are rendered once.
    pub frames: bool,
}

impl Default for Coherence {
    fn default() -> Coherence {
        Coherence { shadows: true, neighbours: false, frames: true }
    }
}

/// One thread's caster, with memory for its lists.
pub struct Eye<'w> {
    caster: Caster<'w>,
    coherence: Coherence,
    swept: Option<&'w Swept>,
    /// Whether a ray of this pixel has come through anything that is swept.
    touched: bool,
    /// What the last ray to each lamp met that was blocked: the shadow cache.
    blockers: Vec<CoherenceHint>,
    /// What the last ray of any other kind met.
    last: CoherenceHint,
    segments: Vec<Segment>,
}

/// A place on a surface.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// The crossing.
    pub hit: Hit,
    /// The unit normal on the side from which it is seen. Surfaces without an inside have two sides, and a
    /// solid may be seen from within: both are shaded like any other.
    pub normal: Vec3,
    /// A point beside the surface from which other rays can start, see [`leave`].
    pub start: Vec3,
}

impl<'w> Eye<'w> {
    pub fn new(
        world: &'w World,
        coherence: Coherence,
        swept: Option<&'w Swept>,
        watch: Watch<'w>,
    ) -> Eye<'w> {
        let mut caster = Caster::new(world);
        caster.watch(watch);
        Eye {
            caster,
            coherence,
            swept,
            touched: false,
            blockers: Vec::new(),
            last: CoherenceHint::default(),
            segments: Vec::new(),
        }
    }

    /// Begins a pixel.
    pub fn begin_pixel(&mut self) {
        self.touched = false;
    }

    /// Whether nothing that moves can change what the rays of this pixel have met.
    pub fn is_still(&self) -> bool {
        self.swept.is_some() && !self.touched
    }

    fn pass(&mut self, ray: &Ray, span: Span) {
        self.touched = self.touched || self.swept.is_some_and(|swept| swept.meets(ray, span));
    }

    /// The work done since this was asked last.
    pub fn take_counters(&mut self) -> Counters {
        self.caster.take_counters()
    }

    /// The first surface a ray meets. What it starts inside of is seen from within.
    ///
    /// # Errors
    /// As [`Caster::closest`].
    pub fn surface(&mut self, ray: &Ray) -> Result<Option<Place>, QueryError> {
        let surfaces = Scope::surfaces(Span::FORWARD);
        let hit = match self.coherence.neighbours {
            true => self.caster.closest_with_hint(&mut self.last, ray, surfaces)?,
            false => self.caster.closest(ray, surfaces)?,
        };
        self.pass(ray, hit.and_then(|hit| Span::new(0.0, hit.t).ok()).unwrap_or(Span::FORWARD));
        Ok(hit.map(|hit| {
            let normal = if hit.normal.dot(ray.direction()) > 0.0 { -hit.normal } else { hit.normal };
            Place { hit, normal, start: leave(ray, &hit, normal) }
        }))
    }

    /// Whether a surface lies between a place and what is `reach` lengths of `toward` away from it: the lamp
    /// of a number, or none.
    ///
    /// # Errors
    /// As [`Caster::any`].
    pub fn blocked(
        &mut self,
        place: &Place,
        toward: Vec3,
        reach: f64,
        lamp: Option<usize>,
    ) -> Result<bool, QueryError> {
        let (Ok(ray), Ok(span)) = (Ray::new(place.start, toward), Span::new(0.0, reach)) else {
            return Ok(false);
        };
        self.pass(&ray, span);
        match lamp.filter(|_| self.coherence.shadows) {
            None => self.caster.any(&ray, Scope::surfaces(span)),
            Some(lamp) => {
                if self.blockers.len() <= lamp {
                    self.blockers.resize_with(lamp + 1, CoherenceHint::default);
                }
                self.caster.any_with_hint(&mut self.blockers[lamp], &ray, Scope::surfaces(span))
            }
        }
    }

    /// The work it takes to find the closest crossing of a ray.
    ///
    /// # Errors
    /// As [`Caster::closest`].
    pub fn work(&mut self, ray: &Ray) -> Result<Counters, QueryError> {
        self.caster.take_counters();
        self.caster.closest(ray, Span::FORWARD)?;
        Ok(self.caster.take_counters())
    }

    /// The stretches of a ray inside objects; where objects overlap, the one of higher priority owns it.
    pub fn segments(&mut self, ray: &Ray) -> Result<&[Segment], QueryError> {
        self.segments.clear();
        self.pass(ray, Span::FORWARD);
        self.caster.segments(ray, Span::FORWARD, Overlaps::Priority, &mut self.segments)?;
        Ok(&self.segments)
    }
}

/// Where rays start that leave a surface: beside it, on the side of the normal.
///
/// `o + t d` misses the surface by what `t` may be wrong (`t_err` lengths of `d`) and by the rounding of the
/// product and the sum. Both are known, so the way to go is known: a few times their sum, far below anything
/// visible, and right for a screw and for a planet alike. A fixed distance would be wrong for one of them:
/// shadows on lit faces where it is too small, light through thin sheets where it is too large. The step is
/// along the normal, not along the new ray, which may run so flat that no step along it would leave.
fn leave(ray: &Ray, hit: &Hit, normal: Vec3) -> Vec3 {
    let step = ray.direction().length();
    let rounding = 4.0 * HALF_ULP * (ray.origin().length() + hit.t.abs() * step);
    ray.at(hit.t) + normal * (GROUPING * (hit.t_err * step + rounding))
}
