//! What goes into a sweep and what comes out: events of leaves, boundaries of the result.

use crate::crossing::Crossing;

/// What a boundary is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i8)]
pub enum HitKind {
    /// The ray passes a surface.
    Surface = 0,
    /// The span begins inside: there is no surface.
    Start = 1,
    /// The span ends inside: there is no surface.
    End = 2,
}

/// What changes for a leaf at an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EventKind {
    /// The ray passes into the leaf's interior or out of it.
    Membership,
    /// The ray begins or ceases to run within the leaf's surface, with the interior in the sector of this number.
    Contact(u32),
    /// Two surfaces within which the ray runs exchange their order around it.
    OrderExchange,
}

/// A crossing of a leaf on its way into the sweep.
#[derive(Clone, Copy, Debug)]
pub struct Event {
    /// The lower end of the interval in which this crossing is one with others.
    pub low: f64,
    /// The leaf.
    pub leaf: u32,
    /// What changes there.
    pub kind: EventKind,
    /// What the leaf's solid answered.
    pub crossing: Crossing,
}

impl Event {
    /// The event of a leaf's crossing, given where the ray enters the leaf's effective bounds. Before those
    /// the leaf cannot matter; `None` says that it happened before and only changes the state.
    pub fn new(leaf: u32, kind: EventKind, crossing: Crossing, enter: f64) -> Option<Event> {
        if crossing.high() < enter {
            return None;
        }
        // Never before the box: so the order of events does not depend on when the box was opened.
        Some(Event { low: crossing.low().max(enter), leaf, kind, crossing })
    }

    /// The upper end of that interval.
    pub fn high(&self) -> f64 {
        self.low.max(self.crossing.high())
    }
}

/// Where the membership in the result changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Boundary {
    /// What it is.
    pub kind: HitKind,
    /// Whether the ray passes into the result.
    pub entering: bool,
    /// The leaf whose surface it is; meaningless without a surface.
    pub leaf: u32,
    /// The leaf's crossing, with `t` and its bound.
    pub crossing: Crossing,
}

impl Boundary {
    /// A boundary where the span begins or ends inside.
    pub(super) fn of_span_end(kind: HitKind, t: f64) -> Boundary {
        let entering = kind == HitKind::Start;
        Boundary { kind, entering, leaf: 0, crossing: Crossing::new(t, 0.0, entering, 0) }
    }
}
