//! Boolean combination: programs over many operands, and the sweep that turns crossings of leaves into boundaries of
//! the result.

mod border;
mod bounds;
mod chain;
mod contact;
mod event;
pub(crate) mod lanes;
#[cfg(test)]
mod lanes_tests;
mod list_sweep;
pub mod op;
mod program;
mod single_leaf;
mod sweep;
mod tally;
mod truth_table;

pub use bounds::LeafBounds;
pub use contact::OrderExchange;
pub use event::{Boundary, Event, EventKind, HitKind};
pub use list_sweep::{ListSweep, ListedBoundary, ListedCrossings, ListedEvent};
pub use op::Op;
pub use program::{Program, ProgramState, Tree, TreeNode};
pub use single_leaf::SingleLeaf;
pub use sweep::Sweep;
pub use tally::Tally;
