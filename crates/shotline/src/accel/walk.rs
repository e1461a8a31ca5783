//! The walk of one ray through structures: depth first, nearer boxes first.

/// A pending entry of a walk.
#[derive(Clone, Copy, Debug)]
pub struct WalkEntry {
    /// A lower bound on every `t` at which the ray meets it.
    pub t: f64,
    /// Which node, or which item.
    pub number: u32,
    /// What it is.
    pub kind: WalkKind,
}

/// What a [`WalkEntry`] stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WalkKind {
    /// A node, whose number only the structure can interpret.
    Node,
    /// An item, whose box the caller tests.
    Item,
    /// An item whose box the ray enters exactly at `t`.
    Entered,
}

/// The pending entries of a walk, the next one last. Structures that are nested share it: entries of an outer one lie below
/// those of the inner one.
#[derive(Debug, Default)]
pub struct Walk {
    /// The entries.
    pub pending: Vec<WalkEntry>,
    /// The entries taken so far.
    pub steps: u64,
}

impl Walk {
    /// Removes the next entry above `base` that begins at or before `limit`.
    #[inline(always)]
    pub(super) fn take(&mut self, base: usize, limit: f64) -> Option<WalkEntry> {
        while self.pending.len() > base {
            let entry = self.pending.pop()?;
            if entry.t <= limit {
                self.steps += 1;
                return Some(entry);
            }
        }
        None
    }

    /// Adds an entry to those from `start` on, which descend by `t`.
    #[inline(always)]
    pub(super) fn add(&mut self, start: usize, entry: WalkEntry) {
        let mut at = self.pending.len();
        self.pending.push(entry);
        while at > start && self.pending[at - 1].t < entry.t {
            self.pending[at] = self.pending[at - 1];
            at -= 1;
        }
        self.pending[at] = entry;
    }
}
