//! What a ray does, step by step, for those who want to see it.
//!
//! Whoever works on a ray tells the [`Log`] in the scratch memory. While nobody listens that is a look at one
//! pointer: what a step says is put into words only if it is kept. See
//! [`Caster::record`](crate::query::Caster::record).
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

/// One step.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// How far inside: levels in levels, a body in its level, a test in its body.
    pub depth: usize,
    /// Where on the ray what it speaks of begins; `None` for what the ray does not meet.
    pub t: Option<f64>,
    /// What is done.
    pub act: Act,
}

/// What a step does. Parts are in the words of their structure; items are bodies and levels by the name of their
/// placement, leaves by kind and number.
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
    /// The nearest pending part is opened.
    Expand {
        /// Which.
        node: String,
    },
    /// A part waits in the heap from now on.
    PushNode {
        /// Which.
        node: String,
    },
    /// An item waits in the heap from now on.
    PushItem {
        /// Which.
        item: String,
    },
    /// An item is offered, but its own box is not met.
    Miss {
        /// Which.
        item: String,
    },
    /// An item is offered again: its tag saves the work.
    Saved {
        /// Which.
        item: String,
    },
    /// A leaf is intersected. [`Act::Found`] follows, after the [`Act::Run`]s of a mesh.
    Test {
        /// Which.
        item: String,
    },
    /// Triangles that the walk through a mesh came to.
    Run {
        /// Boxes, cells and planes met since the run before.
        met: u64,
        /// Triangles intersected.
        tested: u64,
        /// Triangles whose tag saved that.
        saved: u64,
        /// Hits.
        hits: Vec<Crossing>,
        /// The `t` behind which nothing is wanted any more.
        limit: f64,
    },
    /// What a leaf answered. The crossings wait in the heap.
    Found {
        /// Ascending.
        crossings: Vec<Crossing>,
    },
    /// A crossing before the box in which its leaf can matter: it is counted and does not wait.
    Before {
        /// The leaf.
        item: String,
        /// Its crossing.
        crossing: Crossing,
    },
    /// Nothing pending begins before a crossing: the leaf is toggled.
    Toggle {
        /// The leaf.
        item: String,
        /// Its crossing.
        crossing: Crossing,
    },
    /// The body's own crossing: what the query is given.
    Boundary {
        /// Whether the ray passes into the body.
        entering: bool,
    },
    /// The span begins inside the body.
    Start,
    /// The span ends inside the body.
    End,
    /// The walk ends.
    Done {
        /// What was never looked at.
        pending: usize,
    },
}

/// Steps in the order in which they were taken.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trace {
    /// As many as there was room for.
    pub steps: Vec<Step>,
    /// How many more there were.
    pub left_out: u64,
}

/// Keeps steps while somebody listens.
#[derive(Clone, Debug, Default)]
pub struct Log {
    trace: Option<Box<Trace>>,
    most: usize,
    /// The depth of what is walked now.
    pub(crate) depth: usize,
}

impl Log {
    /// Begins to keep steps, so many at most.
    pub fn start(&mut self, most: usize) {
        *self = Log { trace: Some(Box::default()), most, depth: 0 };
    }

    /// Answers what was kept, and ends.
    pub fn take(&mut self) -> Trace {
        self.trace.take().map_or_else(Trace::default, |trace| *trace)
    }

    /// Whether steps are kept.
    #[inline]
    pub fn is_on(&self) -> bool {
        self.trace.is_some()
    }

    /// Tells a step, so much deeper than what is walked now.
    #[inline]
    pub fn add(&mut self, deeper: usize, t: Option<f64>, act: impl FnOnce() -> Act) {
        if self.trace.is_some() {
            self.keep(deeper, t, act);
        }
    }

    #[cold]
    fn keep(&mut self, deeper: usize, t: Option<f64>, act: impl FnOnce() -> Act) {
        let Some(trace) = &mut self.trace else { return };
        if trace.steps.len() < self.most {
            trace.steps.push(Step { depth: self.depth + deeper, t, act: act() });
        } else {
            trace.left_out += 1;
        }
    }
}
