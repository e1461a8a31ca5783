//! The caster: walks the world for one ray and folds what the bodies' streams give.

use std::ops::ControlFlow;

use super::seed::Seed;
use super::segments::{Interval, resolve};
use super::stream::{Stream, StreamScratch};
use super::walk::{Meeting, Walk};
use super::{Hit, MAX_OF_A_RAY, Overlaps, QueryError, Segment};
use crate::accel::{Scratch, Work};
use crate::compile::{Body, SolidBody, World};
use crate::crossing::{Crossing, NO_PRIMITIVE};
use crate::csg::{Boundary, HitKind, ProgramState};
use crate::math::{Vec3, unit};
use crate::ray::{Line, Ray, Span};
use crate::solid::{Solid, Wanted};
use crate::trace::{Act, Trace};

/// A world with one thread's scratch memory.
///
/// ```
/// use shotline::compile::{Options, compile};
/// use shotline::math::Vec3;
/// use shotline::query::Caster;
/// use shotline::ray::{Ray, Span};
/// use shotline::scene::Scene;
/// use shotline::solid::Value;
///
/// let mut scene = Scene::default();
/// let ball = scene.add_solid("sphere", &[Value::Number(2.0)]).unwrap();
/// scene.add_object("ball", None, ball);
/// let world = compile(&scene, Options::default()).unwrap();
/// let ray = Ray::new(Vec3::new(-5.0, 0.0, 0.0), Vec3::X).unwrap();
/// let mut hits = Vec::new();
/// Caster::new(&world).crossings(&ray, Span::FORWARD, &mut hits);
/// assert_eq!(hits.iter().map(|h| (h.t, h.entering)).collect::<Vec<_>>(), [(3.0, true), (7.0, false)]);
/// ```
#[derive(Debug)]
pub struct Caster<'w> {
    world: &'w World,
    walk: Walk<'w>,
    stream: StreamScratch,
    hits: Vec<Crossing>,
    /// Boundaries of the last ray: memory only.
    found: Vec<(Meeting, Boundary)>,
    state: ProgramState,
    scratch: Scratch,
}

/// The memory of so many boundaries is kept for the next ray.
const KEPT: usize = 4096;

/// Where the fold stands after a boundary.
enum Go {
    /// Nothing beyond this `t` is wanted any more.
    UpTo(f64),
    Stop,
}

/// What a query makes of the boundaries it is given.
type Fold<'f> = dyn FnMut(&Meeting, Boundary) -> Go + 'f;

impl<'w> Caster<'w> {
    /// A caster for one thread.
    pub fn new(world: &'w World) -> Caster<'w> {
        Caster {
            world,
            walk: Walk::default(),
            stream: StreamScratch::default(),
            hits: Vec::new(),
            found: Vec::new(),
            state: ProgramState::default(),
            scratch: Scratch::default(),
        }
    }

    /// The world.
    pub fn world(&self) -> &'w World {
        self.world
    }

    /// Work counted since the caster was made, or since this was asked last.
    pub fn take_work(&mut self) -> Work {
        std::mem::take(&mut self.scratch.work)
    }

    /// Keeps the steps of the queries that follow, so many at most, until [`Caster::take_trace`]. No answer
    /// depends on it.
    pub fn record(&mut self, most: usize) {
        self.scratch.log.start(most);
    }

    /// The steps kept since [`Caster::record`]; none are kept from here on.
    pub fn take_trace(&mut self) -> Trace {
        self.scratch.log.take()
    }

    /// The first crossing in the span. Of several at the same `t`, that of the lowest path.
    pub fn closest(&mut self, ray: &Ray, span: Span) -> Option<Hit> {
        let (meeting, boundary) = self.nearest(ray, span, &[])?;
        Some(self.hit(ray, &meeting, &boundary))
    }

    /// As [`Caster::closest`], asking first the body that the seed's last ray met: what lies behind that is
    /// passed over. It answers the same.
    pub fn closest_from(&mut self, seed: &mut Seed, ray: &Ray, span: Span) -> Option<Hit> {
        let (meeting, boundary) = self.nearest(ray, span, seed.way())?;
        seed.keep(&meeting, &self.walk, &mut self.scratch.work);
        Some(self.hit(ray, &meeting, &boundary))
    }

    fn nearest(&mut self, ray: &Ray, span: Span, seed: &[u32]) -> Option<(Meeting, Boundary)> {
        let mut best: Option<(Meeting, Boundary)> = None;
        self.fold(ray, span, Wanted::First, seed, &mut |meeting, boundary| {
            let t = boundary.crossing.t;
            let nearer =
                best.is_none_or(|(m, b)| t < b.crossing.t || (t == b.crossing.t && meeting.path < m.path));
            if nearer {
                best = Some((*meeting, boundary));
            }
            Go::UpTo(t)
        });
        best
    }

    /// Whether there is any crossing in the span.
    pub fn any(&mut self, ray: &Ray, span: Span) -> bool {
        self.interloper(ray, span, &[]).is_some()
    }

    /// As [`Caster::any`], asking first the body that the seed's last ray met (the shadow cache: Haines and
    /// Greenberg 1986). It answers the same.
    pub fn any_from(&mut self, seed: &mut Seed, ray: &Ray, span: Span) -> bool {
        let found = self.interloper(ray, span, seed.way());
        if let Some(meeting) = &found {
            seed.keep(meeting, &self.walk, &mut self.scratch.work);
        }
        found.is_some()
    }

    fn interloper(&mut self, ray: &Ray, span: Span, seed: &[u32]) -> Option<Meeting> {
        let mut found = None;
        self.fold(ray, span, Wanted::First, seed, &mut |meeting, _| {
            found = Some(*meeting);
            Go::Stop
        });
        found
    }

    /// The number of crossings in the span.
    pub fn count(&mut self, ray: &Ray, span: Span) -> u64 {
        let mut count = 0;
        self.fold(ray, span, Wanted::All, &[], &mut |_, _| {
            count += 1;
            Go::UpTo(f64::INFINITY)
        });
        count
    }

    /// Appends every crossing in the span, ascending in `t`; those of one path alternate from an entry.
    /// Crossings of different paths at the same `t` come in the order of the paths.
    /// However many there are: shared parts can put 10^12 before one ray.
    pub fn crossings(&mut self, ray: &Ray, span: Span, out: &mut Vec<Hit>) {
        // No memory holds so many that this is an error.
        let _ = self.crossings_up_to(ray, span, usize::MAX, out);
    }

    /// As [`Caster::crossings`], unless there are more than `most`.
    ///
    /// # Errors
    /// [`QueryError::TooMany`]; nothing is appended then.
    pub fn crossings_up_to(
        &mut self,
        ray: &Ray,
        span: Span,
        most: usize,
        out: &mut Vec<Hit>,
    ) -> Result<(), QueryError> {
        let mut all = std::mem::take(&mut self.found);
        all.clear();
        self.fold(ray, span, Wanted::All, &[], &mut |meeting, boundary| {
            all.push((*meeting, boundary));
            if all.len() > most { Go::Stop } else { Go::UpTo(f64::INFINITY) }
        });
        if all.len() > most {
            return Err(QueryError::TooMany { most });
        }
        // Stable: boundaries of one body keep their order.
        all.sort_by(|(m, a), (n, b)| a.crossing.t.total_cmp(&b.crossing.t).then(m.path.cmp(&n.path)));
        out.extend(all.iter().map(|(meeting, boundary)| self.hit(ray, meeting, boundary)));
        if all.len() <= KEPT {
            self.found = all;
        }
        Ok(())
    }

    /// Appends the stretches inside objects and answers how many overlaps of equal priority were met.
    /// Stretches of one object that overlap or touch are joined.
    ///
    /// # Errors
    /// [`QueryError`] for meshes that are not closed, for more than [`MAX_OF_A_RAY`] stretches and, with
    /// [`Overlaps::Error`], for overlaps.
    pub fn segments(
        &mut self,
        ray: &Ray,
        span: Span,
        overlaps: Overlaps,
        out: &mut Vec<Segment>,
    ) -> Result<u64, QueryError> {
        all_solid(self.world)?;
        let mut open: Option<Interval> = None;
        let mut intervals = Vec::new();
        self.fold(ray, span, Wanted::All, &[], &mut |meeting, boundary| {
            let end = (boundary.crossing.t, boundary.crossing.t_err);
            // The boundaries of a body come one after the other, in pairs.
            match open.take() {
                None => open = Some(Interval { start: end, end, object: meeting.object, path: meeting.path }),
                Some(started) => intervals.push(Interval { end, ..started }),
            }
            if intervals.len() > MAX_OF_A_RAY { Go::Stop } else { Go::UpTo(f64::INFINITY) }
        });
        if intervals.len() > MAX_OF_A_RAY {
            return Err(QueryError::TooMany { most: MAX_OF_A_RAY });
        }
        resolve(self.world, ray, intervals, overlaps, out)
    }

    /// Appends the stretches inside one object, from and to which `t`, whatever else is there: ascending and apart.
    /// Answers how many boxes and bodies were opened for it; memory does not grow with them.
    ///
    /// # Errors
    /// [`QueryError::TooMany`] if these or the stretches are more than `most`.
    pub(crate) fn stretches(
        &mut self,
        object: u32,
        ray: &Ray,
        span: Span,
        most: usize,
        out: &mut Vec<[f64; 2]>,
    ) -> Result<usize, QueryError> {
        let mut ends: Vec<f64> = Vec::new();
        let (mut limit, mut steps) = (span.t_max(), most);
        self.walk.begin(self.world, Line::of(ray), span);
        self.walk.start(self.world, &mut self.scratch);
        while let Some(meeting) = self.walk.next_deep(self.world, &mut steps, &mut self.scratch) {
            if meeting.object == object {
                // Of one body they alternate.
                let _ = self.fold_body(&meeting, span, Wanted::All, &mut limit, &mut |_, boundary| {
                    ends.push(boundary.crossing.t);
                    Go::UpTo(f64::INFINITY)
                });
            }
            if ends.len() > 2 * most {
                break;
            }
        }
        if steps == 0 || ends.len() > 2 * most {
            return Err(QueryError::TooMany { most });
        }
        let mut stretches: Vec<[f64; 2]> = ends.chunks_exact(2).map(|pair| [pair[0], pair[1]]).collect();
        stretches.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let start = out.len();
        for [from, to] in stretches {
            match out[start..].last_mut() {
                Some(last) if from <= last[1] => last[1] = last[1].max(to),
                _ => out.push([from, to]),
            }
        }
        Ok(most - steps)
    }

    /// Appends the objects whose interior holds a point, ascending. No promise within rounding of a surface.
    ///
    /// # Errors
    /// [`QueryError`] for meshes that are not closed.
    pub fn contains(&mut self, p: Vec3, out: &mut Vec<u32>) -> Result<(), QueryError> {
        all_solid(self.world)?;
        let start = out.len();
        let here = Span::new(0.0, 0.0).unwrap_or(Span::FORWARD);
        self.walk.begin(self.world, Line::exact(p, Vec3::X), here);
        self.walk.start(self.world, &mut self.scratch);
        while let Some(meeting) = self.walk.next(self.world, 0.0, &mut self.scratch) {
            if let Body::Solid(body) = self.world.body(meeting.body)
                && holds(body, meeting.line.o, &mut self.state)
            {
                out.push(meeting.object);
            }
        }
        out[start..].sort_unstable();
        let mut kept = out.split_off(start);
        kept.dedup();
        out.append(&mut kept);
        Ok(())
    }

    /// Gives every boundary in the span to `fold`, body by body; nearest bodies first, but before all the one
    /// of the seed.
    fn fold(&mut self, ray: &Ray, span: Span, wanted: Wanted, seed: &[u32], fold: &mut Fold) {
        let mut limit = span.t_max();
        self.walk.begin(self.world, Line::of(ray), span);
        let asked = self.walk.follow(self.world, seed, &mut self.scratch.work);
        if let Some(meeting) = &asked
            && self.fold_body(meeting, span, wanted, &mut limit, fold).is_break()
        {
            return;
        }
        self.walk.start(self.world, &mut self.scratch);
        while let Some(meeting) = self.walk.next(self.world, limit, &mut self.scratch) {
            let again = asked.is_some_and(|a| a.path == meeting.path);
            if !again && self.fold_body(&meeting, span, wanted, &mut limit, fold).is_break() {
                return;
            }
        }
    }

    /// Gives the boundaries of one body, up to the limit, which it may lower.
    fn fold_body(
        &mut self,
        meeting: &Meeting,
        span: Span,
        wanted: Wanted,
        limit: &mut f64,
        fold: &mut Fold,
    ) -> ControlFlow<()> {
        // With the first wanted, what lies beyond the best so far does not matter.
        let span = Span::new(span.t_min(), *limit).unwrap_or(span);
        let mut give = |boundary: Boundary| match fold(meeting, boundary) {
            Go::UpTo(t) => {
                *limit = limit.min(t);
                ControlFlow::Continue(())
            }
            Go::Stop => ControlFlow::Break(()),
        };
        match self.world.body(meeting.body) {
            Body::Solid(body) => {
                let mut stream =
                    Stream::new(body, &meeting.line, span, wanted, &mut self.stream, &mut self.scratch);
                while let Some(boundary) = stream.next() {
                    stream.log().add(1, Some(boundary.crossing.t), || told(&boundary));
                    give(boundary)?;
                    if wanted == Wanted::First {
                        break;
                    }
                }
            }
            Body::Surface(body) => {
                self.hits.clear();
                let line = meeting.line.in_frame(&body.local_from_body);
                self.scratch.log.add(1, None, || Act::Test { item: "mesh".into() });
                match wanted {
                    Wanted::All => body.mesh.hits(&line, span, &mut self.hits, &mut self.scratch),
                    Wanted::First => self.hits.extend(body.mesh.nearest(&line, span, &mut self.scratch)),
                }
                self.scratch.log.add(1, None, || Act::Found { crossings: self.hits.clone() });
                for &crossing in &self.hits {
                    let entering = crossing.entering;
                    let boundary = Boundary { kind: HitKind::Surface, entering, leaf: 0, crossing };
                    self.scratch.log.add(1, Some(crossing.t), || told(&boundary));
                    give(boundary)?;
                }
            }
        }
        ControlFlow::Continue(())
    }

    /// A boundary in world terms.
    fn hit(&self, ray: &Ray, meeting: &Meeting, boundary: &Boundary) -> Hit {
        let Boundary { kind, entering, leaf, crossing } = *boundary;
        let mut hit = Hit {
            t: crossing.t,
            t_err: crossing.t_err,
            entering,
            kind,
            normal: Vec3::NAN,
            object: meeting.object,
            surface: None,
            primitive: None,
            polygon: None,
            barycentric: None,
            path: meeting.path,
        };
        if kind != HitKind::Surface {
            return hit;
        }
        let (solid, local_from_body, first_surface, subtracted) = match self.world.body(meeting.body) {
            Body::Surface(b) => (&*b.mesh as &dyn Solid, &b.local_from_body, b.first_surface, false),
            Body::Solid(b) => {
                let l = &b.leaves[leaf as usize];
                (&*l.solid, &l.local_from_body, l.first_surface, b.program.is_subtracted(leaf))
            }
        };
        let p = meeting.line.in_frame(local_from_body).at(crossing.t);
        let outward = solid.normal(p, crossing.surface, crossing.primitive);
        let normal = unit(self.walk.world_normal(meeting, local_from_body.covector(outward)));
        hit.normal = if crossing.primitive == NO_PRIMITIVE {
            if subtracted { -normal } else { normal }
        } else if (normal.dot(ray.direction()) < 0.0) == entering {
            // A triangle is flat: which of its sides is outside shows in the way the ray goes.
            normal
        } else {
            -normal
        };
        hit.surface = Some(first_surface + crossing.surface);
        if crossing.primitive != NO_PRIMITIVE {
            hit.primitive = Some(crossing.primitive);
            hit.polygon = solid.polygon(crossing.primitive);
            hit.barycentric = solid.barycentric(p, crossing.primitive);
        }
        hit
    }
}

fn told(boundary: &Boundary) -> Act {
    match boundary.kind {
        HitKind::Surface => Act::Boundary { entering: boundary.entering },
        HitKind::Start => Act::Start,
        HitKind::End => Act::End,
    }
}

fn holds(body: &SolidBody, p: Vec3, state: &mut ProgramState) -> bool {
    state.reset(&body.program);
    for (i, leaf) in (0..).zip(&body.leaves) {
        if leaf.solid.contains(leaf.local_from_body.point(p)) {
            state.toggle(&body.program, i);
        }
    }
    let inside = state.value(&body.program);
    state.clear(&body.program);
    inside
}

/// Refuses worlds in which an object has no inside.
///
/// # Errors
/// [`QueryError::NotASolid`].
pub(super) fn all_solid(world: &World) -> Result<(), QueryError> {
    match world.surface() {
        None => Ok(()),
        Some((object, body)) => Err(QueryError::NotASolid {
            object: world.object_names()[object as usize].clone(),
            why: body.mesh.topology().why_open(),
        }),
    }
}
