//! The caster: a world and the memory with which one thread queries it. Each kind of query is in its own file.

use super::interval_ends::Interval;
use super::membership::Membership;
use super::met_bodies::MetBodies;
use super::ownership::OwnershipScratch;
use super::stream::StreamScratch;
use super::traversal::Traversal;
use super::{Limits, QueryError};
use crate::budget::Watch;
use crate::compile::World;
use crate::counters::Counters;
use crate::crossing::Crossing;
use crate::scratch::Scratch;
use crate::trace::Trace;

/// A world with one thread's scratch memory.
///
/// The cost of every query is bounded: see [`Limits`] and [`Caster::watch`]. A query that exceeds a limit returns an
/// error and appends nothing.
///
/// ```
/// use shotline::compile::{Options, compile};
/// use shotline::math::Vec3;
/// use shotline::query::Caster;
/// use shotline::ray::{Ray, Span};
/// use shotline::scene::Scene;
///
/// let mut scene = Scene::default();
/// let ball = scene.add_solid("sphere", &[&[2.0]]).unwrap();
/// scene.add_object("ball", None, ball);
/// let world = compile(&scene, Options::default()).unwrap();
/// let ray = Ray::new(Vec3::new(-5.0, 0.0, 0.0), Vec3::X).unwrap();
/// let mut hits = Vec::new();
/// Caster::new(&world).crossings(&ray, Span::FORWARD, &mut hits).unwrap();
/// assert_eq!(hits.iter().map(|h| (h.t, h.entering)).collect::<Vec<_>>(), [(3.0, true), (7.0, false)]);
/// ```
#[derive(Debug)]
pub struct Caster<'w> {
    pub(super) world: &'w World,
    pub(super) traversal: Traversal<'w>,
    pub(super) stream: StreamScratch,
    pub(super) hits: Vec<Crossing>,
    pub(super) scratch: Scratch<'w>,
    pub(super) limits: Limits,
    pub(super) membership: Membership,
    pub(super) intervals: Vec<Interval>,
    pub(super) met: MetBodies,
    pub(super) ownership: OwnershipScratch<'w>,
}

impl<'w> Caster<'w> {
    /// Creates a caster for one thread.
    pub fn new(world: &'w World) -> Caster<'w> {
        Caster {
            world,
            traversal: Traversal::default(),
            stream: StreamScratch::default(),
            hits: Vec::new(),
            scratch: Scratch::default(),
            limits: Limits::default(),
            membership: Membership::default(),
            intervals: Vec::new(),
            met: MetBodies::default(),
            ownership: OwnershipScratch::default(),
        }
    }

    /// Sets callbacks that observe and cancel queries while they run, even within one ray.
    pub fn watch(&mut self, watch: Watch<'w>) {
        self.scratch.budget.watch(watch);
    }

    /// Sets what one ray may cost.
    pub fn limit(&mut self, limits: Limits) {
        self.limits = limits;
    }

    /// The world.
    pub fn world(&self) -> &'w World {
        self.world
    }

    /// Returns the work counted since the caster was created or since the last call, and resets the counters.
    pub fn take_counters(&mut self) -> Counters {
        std::mem::take(&mut self.scratch.counters)
    }

    /// Records the steps of the queries that follow, at most `most`, until [`Caster::take_trace`]. No result depends
    /// on recording.
    pub fn record(&mut self, most: usize) {
        self.scratch.log.start(most);
    }

    /// Returns the steps recorded since [`Caster::record`], and stops recording.
    pub fn take_trace(&mut self) -> Trace {
        self.scratch.log.take()
    }
}

/// Returns an error if an object of the world has no inside.
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
