//! The input and the output of a sweep: events of leaves, and boundaries of the result.

use crate::crossing::Crossing;

/// The kind of a boundary.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i8)]
pub enum HitKind {
    /// The ray crosses a surface.
    Surface = 0,
    /// The span begins inside: there is no surface.
    Start = 1,
    /// The span ends inside: there is no surface.
    End = 2,
}

/// What changes for a leaf at an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EventKind {
    /// The ray enters or leaves the leaf's interior.
    Membership,
    /// The ray begins or ceases to run in the leaf's surface. The interior is in the sector of this number.
    Contact(u32),
    /// Two surfaces in which the ray runs exchange their order around it.
    OrderExchange,
}

/// A crossing of a leaf, as input of the sweep.
#[derive(Clone, Copy, Debug)]
pub struct Event {
    /// The lower end of the interval in which this crossing coincides with others.
    pub low: f64,
    /// The leaf.
    pub leaf: u32,
    /// What changes there.
    pub kind: EventKind,
    /// The crossing that the leaf's solid returned.
    pub crossing: Crossing,
}

impl Event {
    /// Creates the event of a leaf's crossing, given the `t` at which the ray enters the leaf's effective bounds.
    /// Returns `None` for a crossing before that: the leaf cannot matter there, so the crossing only changes the
    /// state.
    pub fn new(leaf: u32, kind: EventKind, crossing: Crossing, enter: f64) -> Option<Event> {
        if crossing.high() < enter {
            return None;
        }
        // Never before the box, so that the order of events does not depend on when the box was opened.
        Some(Event { low: crossing.low().max(enter), leaf, kind, crossing })
    }

    /// The upper end of that interval.
    pub fn high(&self) -> f64 {
        self.low.max(self.crossing.high())
    }
}

/// A point where membership in the result changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Boundary {
    /// The kind.
    pub kind: HitKind,
    /// Whether the ray enters the result.
    pub entering: bool,
    /// The leaf whose surface it is; meaningless without a surface.
    pub leaf: u32,
    /// The leaf's crossing, with `t` and its bound.
    pub crossing: Crossing,
}

impl Boundary {
    /// A boundary at a crossing of the only leaf of a body.
    pub fn of_leaf(crossing: Crossing) -> Boundary {
        Boundary { kind: HitKind::Surface, entering: crossing.entering, leaf: 0, crossing }
    }

    /// A boundary where the span begins or ends inside.
    pub(crate) fn of_span_end(kind: HitKind, t: f64) -> Boundary {
        let entering = kind == HitKind::Start;
        Boundary { kind, entering, leaf: 0, crossing: Crossing::new(t, 0.0, entering, 0) }
    }
}
