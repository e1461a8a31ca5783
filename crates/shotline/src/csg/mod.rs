//! Boolean combination: Roth's table, programs over many operands, and the sweep that turns crossings of
//! leaves into boundaries of the result.

mod bounds;
mod chain;
mod contact;
mod event;
pub mod op;
mod program;
mod sweep;

pub use bounds::LeafBounds;
pub use event::{Boundary, Change, Event, HitKind};
pub use op::Op;
pub use program::{Program, ProgramState, Tree, TreeNode};
pub use sweep::Sweep;
