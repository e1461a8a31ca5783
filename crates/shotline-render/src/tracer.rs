//! What rays see: the first surfaces, and whether anything occludes a light.

use shotline::compile::World;
use shotline::counters::Counters;
use shotline::crossing::GROUPING;
use shotline::math::{HALF_ULP, Vec3};
use shotline::query::batch::{BatchCaster, BatchError, ClosestRows, Fields, Run};
use shotline::query::{CoherenceHint, Hit, HitKind, Overlaps, Scope, Segment};
use shotline::ray::{Ray, Span};

use crate::color::Rgb;
use crate::temporal_cache::SweptBounds;
use crate::vertex_colors::VertexColors;
use crate::visible_part::VisiblePart;

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

/// Rays to be traced together, each for a sample of a pixel.
#[derive(Debug, Default)]
pub struct SampleRays {
    rays: Vec<Ray>,
    samples: Vec<u32>,
}

impl SampleRays {
    pub fn push(&mut self, ray: Ray, sample: u32) {
        self.rays.push(ray);
        self.samples.push(sample);
    }

    pub fn len(&self) -> usize {
        self.rays.len()
    }

    pub fn is_empty(&self) -> bool {
        self.rays.is_empty()
    }

    pub fn clear(&mut self) {
        self.rays.clear();
        self.samples.clear();
    }

    pub fn ray(&self, number: usize) -> &Ray {
        &self.rays[number]
    }

    /// The sample that a ray is for.
    pub fn sample(&self, number: usize) -> u32 {
        self.samples[number]
    }
}

/// What a tracer has to tell of the surfaces that it finds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Identify {
    /// Their objects.
    Objects,
    /// Their objects, leaf surfaces and instance paths.
    Surfaces,
}

/// Traces the rays of some samples at a time: one thread's caster, with memory for its results.
pub struct Tracer<'w> {
    caster: BatchCaster<'w>,
    coherence: Coherence,
    swept: Option<&'w SweptBounds>,
    visible: &'w VisiblePart,
    /// By sample, whether a ray has met the swept bounds.
    meets_motion: Vec<bool>,
    /// By lamp, what occluded the last ray to it that was occluded: the shadow cache.
    occluders: Vec<CoherenceHint>,
    /// What the last ray of any other kind met.
    last: CoherenceHint,
    closest: ClosestRows,
    occluded: Vec<bool>,
    /// `None` if no mesh has colours.
    colors: Option<VertexColors<'w>>,
}

/// A point on a surface.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint {
    /// The number of the ray that meets it.
    pub ray: usize,
    /// The ray parameter.
    pub t: f64,
    /// The object.
    pub object: u32,
    /// The leaf surface, and -1 at a cut; 0 if surfaces are not identified.
    pub surface: i64,
    /// The instance path; 0 if surfaces are not identified.
    pub path: i64,
    /// The unit normal on the side that the ray comes from. Surfaces without an inside have two sides, and a
    /// solid may be seen from within: both are shaded like any other.
    pub normal: Vec3,
    /// A point beside the surface from which other rays can start, see [`offset_from_surface`].
    pub start: Vec3,
    /// Whether it is where a plane cuts through the object.
    pub is_cut: bool,
    /// The colour that a mesh has there.
    pub color: Option<Rgb>,
    /// The share of what the ray sees that this surface covers: 1 if nothing that is seen through is in front of it or at it.
    pub weight: f64,
}

impl SurfacePoint {
    fn new(number: usize, ray: &Ray, hit: &RayHit) -> SurfacePoint {
        let &RayHit { t, t_err, object, surface, path, normal, is_cut, color } = hit;
        let normal = if normal.dot(ray.direction()) > 0.0 { -normal } else { normal };
        let start = offset_from_surface(ray, t, t_err, normal);
        SurfacePoint { ray: number, t, object, surface, path, normal, start, is_cut, color, weight: 1.0 }
    }
}

/// What is known of the surface that a ray meets.
struct RayHit {
    t: f64,
    t_err: f64,
    object: u32,
    surface: i64,
    path: i64,
    normal: Vec3,
    is_cut: bool,
    color: Option<Rgb>,
}

impl<'w> Tracer<'w> {
    /// Rays are cast one by one if the run requests counters.
    pub fn new(
        world: &'w World,
        coherence: Coherence,
        swept: Option<&'w SweptBounds>,
        visible: &'w VisiblePart,
        identify: Identify,
        run: Run<'w>,
    ) -> Tracer<'w> {
        let colors = VertexColors::new(world);
        let of_colors = if colors.is_some() { VertexColors::fields() } else { Fields::NONE };
        let identity = match identify {
            Identify::Objects => Fields::NONE,
            Identify::Surfaces => Fields::SURFACE | Fields::PATH,
        };
        let fields = Fields::OBJECT | Fields::NORMAL | Fields::T_ERR | of_colors | identity;
        Tracer {
            caster: BatchCaster::new(world, Run { fields, ..run }),
            coherence,
            swept,
            visible,
            meets_motion: Vec::new(),
            occluders: Vec::new(),
            last: CoherenceHint::default(),
            closest: ClosestRows::default(),
            occluded: Vec::new(),
            colors,
        }
    }

    /// Begins some samples.
    pub fn begin(&mut self, samples: usize) {
        self.meets_motion.clear();
        self.meets_motion.resize(samples, false);
    }

    /// Whether nothing that moves can change what the rays of a sample have met.
    pub fn is_static(&self, sample: u32) -> bool {
        self.swept.is_some() && !self.meets_motion[sample as usize]
    }

    /// Records whether a ray of a sample meets the swept bounds in a span.
    fn record_motion(&mut self, sample: u32, ray: &Ray, span: Span) {
        if let Some(swept) = self.swept {
            let meets_motion = &mut self.meets_motion[sample as usize];
            *meets_motion = *meets_motion || swept.meets(ray, span);
        }
    }

    /// Returns the work done since the last call.
    pub fn take_counters(&mut self) -> Counters {
        self.caster.take_counters()
    }

    /// The first surface that each ray meets, in order of the rays that meet one. A solid in which a ray starts is seen
    /// from within.
    ///
    /// # Errors
    /// As [`BatchCaster::closest`].
    pub fn surfaces(&mut self, rays: &SampleRays) -> Result<Vec<SurfacePoint>, BatchError> {
        if !self.visible.is_everything() {
            return self.visible_surfaces(rays);
        }
        let hint = self.coherence.neighbours.then_some(&mut self.last);
        self.caster.closest(&rays.rays, Scope::surfaces(Span::FORWARD), hint, &mut self.closest)?;
        let mut points = Vec::with_capacity(rays.len());
        for (number, (ray, &sample)) in rays.rays.iter().zip(&rays.samples).enumerate() {
            let t = self.closest.t[number];
            // Infinite for a miss.
            self.record_motion(sample, ray, Span::new(0.0, t).unwrap_or(Span::FORWARD));
            if t < f64::INFINITY {
                let normal = Vec3::from_array(self.closest.normal[number]);
                let (t_err, object) = (self.closest.t_err[number], self.closest.object[number] as u32);
                let color =
                    self.colors.as_mut().and_then(|colors| colors.of_row(&self.closest, number, ray.at(t)));
                // Columns that were not requested are empty.
                let surface = self.closest.surface.get(number).map_or(0, |surface| i64::from(*surface));
                let path = self.closest.path.get(number).copied().unwrap_or(0);
                let hit = RayHit { t, t_err, object, surface, path, normal, is_cut: false, color };
                points.push(SurfacePoint::new(number, ray, &hit));
            }
        }
        Ok(points)
    }

    /// As [`Tracer::surfaces`], where not all is visible.
    fn visible_surfaces(&mut self, rays: &SampleRays) -> Result<Vec<SurfacePoint>, BatchError> {
        let mut points = Vec::with_capacity(rays.len());
        let (visible, colors) = (self.visible, &mut self.colors);
        self.caster.cast_rays(&rays.rays, |caster, number, ray| {
            let hit = visible.closest(caster, ray, Span::FORWARD)?;
            points.extend(hit.map(|hit| point_of_hit(number, ray, &hit, colors)));
            Ok(())
        })?;
        let mut met = points.iter().peekable();
        for (number, (ray, &sample)) in rays.rays.iter().zip(&rays.samples).enumerate() {
            let t = met.next_if(|point| point.ray == number).map_or(f64::INFINITY, |point| point.t);
            self.record_motion(sample, ray, Span::new(0.0, t).unwrap_or(Span::FORWARD));
        }
        Ok(points)
    }

    /// As [`Tracer::surfaces`], and behind surfaces of objects that are seen through, also the next ones: one after the other for
    /// each ray, nearest first.
    ///
    /// # Errors
    /// As [`BatchCaster::closest`].
    pub fn layers(&mut self, rays: &SampleRays) -> Result<Vec<SurfacePoint>, BatchError> {
        if self.visible.is_opaque() {
            return self.surfaces(rays);
        }
        for (ray, &sample) in rays.rays.iter().zip(&rays.samples) {
            self.record_motion(sample, ray, Span::FORWARD);
        }
        let mut points = Vec::with_capacity(rays.len());
        let (visible, colors) = (self.visible, &mut self.colors);
        self.caster.cast_rays(&rays.rays, |caster, number, ray| {
            visible.layers(caster, ray, |hit, weight| {
                points.push(SurfacePoint { weight, ..point_of_hit(number, ray, hit, colors) });
            })
        })?;
        Ok(points)
    }

    /// Whether rays see one surface, or several of objects that are seen through.
    pub fn is_opaque(&self) -> bool {
        self.visible.is_opaque()
    }

    /// The first surface that each ray meets of those that are not seen through, as [`Tracer::surfaces`].
    ///
    /// # Errors
    /// As [`BatchCaster::closest`].
    pub fn opaque_surfaces(&mut self, rays: &SampleRays) -> Result<Vec<SurfacePoint>, BatchError> {
        let mut points = Vec::with_capacity(rays.len());
        let (visible, colors) = (self.visible, &mut self.colors);
        self.caster.cast_rays(&rays.rays, |caster, number, ray| {
            let hit = visible.closest_opaque(caster, ray)?;
            points.extend(hit.map(|hit| point_of_hit(number, ray, &hit, colors)));
            Ok(())
        })?;
        Ok(points)
    }

    /// Whether a surface is in the span of each ray. `lamp` is the number of the lamp to which the rays go, if they go
    /// to one: each lamp has its own shadow cache.
    ///
    /// # Errors
    /// As [`BatchCaster::any`].
    pub fn occluded(
        &mut self,
        rays: &SampleRays,
        span: Span,
        lamp: Option<usize>,
    ) -> Result<&[bool], BatchError> {
        for (ray, &sample) in rays.rays.iter().zip(&rays.samples) {
            self.record_motion(sample, ray, span);
        }
        if !self.visible.is_everything() {
            self.occluded.clear();
            let (visible, occluded) = (self.visible, &mut self.occluded);
            self.caster.cast_rays(&rays.rays, |caster, _, ray| {
                occluded.push(visible.occludes(caster, ray, span)?);
                Ok(())
            })?;
            return Ok(&self.occluded);
        }
        let lamp = lamp.filter(|_| self.coherence.shadows);
        if let Some(lamp) = lamp
            && self.occluders.len() <= lamp
        {
            self.occluders.resize_with(lamp + 1, CoherenceHint::default);
        }
        let hint = lamp.map(|lamp| &mut self.occluders[lamp]);
        self.caster.any(&rays.rays, Scope::surfaces(span), hint, &mut self.occluded)?;
        Ok(&self.occluded)
    }

    /// Passes the number of each ray to `take`, with the work that its closest crossing costs.
    ///
    /// # Errors
    /// As [`BatchCaster::cost`].
    pub fn cost(
        &mut self,
        rays: &SampleRays,
        mut take: impl FnMut(usize, Counters),
    ) -> Result<(), BatchError> {
        if !self.visible.is_everything() {
            let visible = self.visible;
            return self.caster.cast_rays(&rays.rays, |caster, number, ray| {
                caster.take_counters();
                visible.closest(caster, ray, Span::FORWARD)?;
                take(number, caster.take_counters());
                Ok(())
            });
        }
        self.caster.cost(&rays.rays, Span::FORWARD, take)
    }

    /// Passes the number of each ray to `take`, with its segments inside objects. Where objects overlap, the one of higher
    /// priority owns the segment.
    ///
    /// # Errors
    /// As [`BatchCaster::segments`].
    pub fn segments(
        &mut self,
        rays: &SampleRays,
        mut take: impl FnMut(usize, &[Segment]),
    ) -> Result<(), BatchError> {
        for (ray, &sample) in rays.rays.iter().zip(&rays.samples) {
            self.record_motion(sample, ray, Span::FORWARD);
        }
        if !self.visible.is_everything() {
            let (visible, mut segments) = (self.visible, Vec::new());
            return self.caster.cast_rays(&rays.rays, |caster, number, ray| {
                segments.clear();
                visible.segments(caster, ray, Span::FORWARD, &mut segments)?;
                take(number, &segments);
                Ok(())
            });
        }
        self.caster.segments(&rays.rays, Span::FORWARD, Overlaps::Priority, take)
    }
}

fn point_of_hit(number: usize, ray: &Ray, hit: &Hit, colors: &mut Option<VertexColors>) -> SurfacePoint {
    let &Hit { t, t_err, object, normal, kind, path, .. } = hit;
    let (surface, path) = (hit.surface.map_or(-1, i64::from), path as i64);
    let color = colors.as_mut().and_then(|colors| colors.of_hit(hit, ray.at(t)));
    let is_cut = kind == HitKind::Start;
    SurfacePoint::new(number, ray, &RayHit { t, t_err, object, surface, path, normal, is_cut, color })
}

/// The point from which rays leave a surface: beside it, on the side of the normal.
///
/// The point `o + t d` misses the surface by the error of `t` (at most `t_err` lengths of `d`) and by the rounding
/// of the product and of the sum. Both have known bounds. The offset is a few times the sum of these bounds: far
/// below anything visible, and right for a screw and for a planet alike. A fixed distance would be wrong for one
/// of them: too small, it puts shadows on lit faces; too large, it lets light through thin sheets. The offset is
/// along the normal, not along the new ray: a ray that runs nearly along the surface would not leave it.
fn offset_from_surface(ray: &Ray, t: f64, t_err: f64, normal: Vec3) -> Vec3 {
    let step = ray.direction().length();
    let rounding = 4.0 * HALF_ULP * (ray.origin().length() + t.abs() * step);
    ray.at(t) + normal * (GROUPING * (t_err * step + rounding))
}
