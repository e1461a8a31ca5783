//! Records what a ray does, step by step.
//!
//! Queries report their steps to the [`Log`] in the scratch memory. While the log is off, that costs a test of one
//! pointer: a step is described only if it is kept. See [`Caster::record`](crate::query::Caster::record).
//!
//! ```
//! use shotline::{compile, math::Vec3, query::Caster, ray::{Ray, Span}, scene::Scene, trace::Act};
//!
//! let mut scene = Scene::default();
//! let ball = scene.add_solid("sphere", &[&[2.0]]).unwrap();
//! scene.add_object("ball", None, ball);
//! let world = compile::compile(&scene, compile::Options::default()).unwrap();
//! let mut caster = Caster::new(&world);
//! caster.record(1000);
//! caster.closest(&Ray::new(Vec3::new(-5.0, 0.0, 0.0), Vec3::X).unwrap(), Span::FORWARD).unwrap();
//! let trace = caster.take_trace();
//! let tested = trace.steps.iter().filter(|step| matches!(step.act, Act::Test { .. }));
//! assert_eq!((tested.count(), trace.left_out), (1, 0));
//! ```

use crate::crossing::Crossing;
use crate::math::Affine;
use crate::outline::Outline;

/// One step.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// The nesting depth: levels in levels, a body in its level, a test in its body.
    pub depth: usize,
    /// The `t` at which the subject of the step begins; `None` if the ray does not meet it.
    pub t: Option<f64>,
    /// The action.
    pub act: Act,
    /// The shape of its subject, if it has one, in the frame below.
    pub outline: Option<Outline>,
    /// The frame of the level or of the body: world from frame. `None` if numbers of 64 bits cannot hold it.
    pub frame: Option<Affine>,
}

/// The action of a step. A node is described in the terms of its structure. An item that is a body or a level has the
/// name of its placement; a leaf has its kind and number.
#[derive(Clone, Debug, PartialEq)]
pub enum Act {
    /// A level is entered.
    EnterLevel {
        /// The instance path so far; empty for the root.
        path: String,
        /// Its placements.
        placements: usize,
    },
    /// A body is entered.
    EnterBody {
        /// The instance path.
        path: String,
        /// Its leaves.
        leaves: usize,
    },
    /// The nearest queued node is expanded.
    Expand {
        /// Its description.
        node: String,
    },
    /// A node is pushed on the heap.
    PushNode {
        /// Its description.
        node: String,
    },
    /// An item is pushed on the heap.
    PushItem {
        /// Its description.
        item: String,
    },
    /// An item is proposed, but the ray misses its box.
    Miss {
        /// Its description.
        item: String,
    },
    /// An item is proposed again, and its tag saves the work.
    Saved {
        /// Its description.
        item: String,
    },
    /// A leaf is intersected. [`Act::Found`] follows, after the [`Act::Run`]s of a mesh.
    Test {
        /// Its description.
        item: String,
    },
    /// A run of triangles that the traversal of a mesh visits.
    Run {
        /// Boxes, cells and planes met since the previous run.
        met: u64,
        /// Triangles intersected.
        tested: u64,
        /// Triangles whose tag saved the intersection.
        saved: u64,
        /// Hits.
        hits: Vec<Crossing>,
        /// The `t` beyond which no more items are needed.
        limit: f64,
    },
    /// The leaf returns its crossings, which are pushed on the heap.
    Found {
        /// The crossings, in ascending order.
        crossings: Vec<Crossing>,
    },
    /// A crossing before the box in which its leaf can affect the result. It is applied at once and not pushed on the
    /// heap.
    Before {
        /// The leaf.
        item: String,
        /// Its crossing.
        crossing: Crossing,
    },
    /// No queued entry begins before a crossing: the leaf is toggled.
    Toggle {
        /// The leaf.
        item: String,
        /// Its crossing.
        crossing: Crossing,
    },
    /// A crossing of the body itself, which the query receives.
    Boundary {
        /// Whether the ray enters the body.
        entering: bool,
    },
    /// The span begins inside the body.
    Start,
    /// The span ends inside the body.
    End,
    /// The traversal ends.
    Done {
        /// The number of queued entries that were never examined.
        pending: usize,
    },
}

/// Steps in the order in which they were taken.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trace {
    /// The steps kept, up to the limit.
    pub steps: Vec<Step>,
    /// The number of further steps, which were not kept.
    pub left_out: u64,
}

/// Keeps steps while it is on.
#[derive(Clone, Debug, Default)]
pub struct Log {
    recording: Option<Box<Recording>>,
}

/// What is kept, and what the next steps are about.
#[derive(Clone, Debug)]
struct Recording {
    trace: Trace,
    most: usize,
    /// The depth of the level or body that is being traversed.
    depth: usize,
    /// Its frame: world from frame.
    frame: Option<Affine>,
}

impl Log {
    /// Starts to keep steps, at most `most` of them.
    pub fn start(&mut self, most: usize) {
        let trace = Trace::default();
        self.recording = Some(Box::new(Recording { trace, most, depth: 0, frame: Some(Affine::IDENTITY) }));
    }

    /// Stops, and returns what was kept.
    pub fn take(&mut self) -> Trace {
        self.recording.take().map_or_else(Trace::default, |recording| recording.trace)
    }

    /// Whether steps are kept.
    #[inline]
    pub fn is_on(&self) -> bool {
        self.recording.is_some()
    }

    /// The next steps are in a level or body at a depth, with a frame.
    pub(crate) fn enter(&mut self, depth: usize, frame: Option<Affine>) {
        if let Some(recording) = &mut self.recording {
            (recording.depth, recording.frame) = (depth, frame);
        }
    }

    /// Adds a step that is `deeper` levels below the current depth.
    #[inline]
    pub fn add(&mut self, deeper: usize, t: Option<f64>, act: impl FnOnce() -> Act) {
        self.add_with_outline(deeper, t, || (act(), None));
    }

    /// As [`Log::add`], with the shape of what the step is about.
    #[inline]
    pub fn add_with_outline(
        &mut self,
        deeper: usize,
        t: Option<f64>,
        act: impl FnOnce() -> (Act, Option<Outline>),
    ) {
        if let Some(recording) = &mut self.recording {
            recording.add(deeper, t, act);
        }
    }
}

impl Recording {
    #[cold]
    fn add(&mut self, deeper: usize, t: Option<f64>, act: impl FnOnce() -> (Act, Option<Outline>)) {
        if self.trace.steps.len() < self.most {
            let (act, outline) = act();
            let depth = self.depth + deeper;
            self.trace.steps.push(Step { depth, t, act, outline, frame: self.frame });
        } else {
            self.trace.left_out += 1;
        }
    }
}
