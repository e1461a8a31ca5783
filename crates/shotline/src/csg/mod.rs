//! Boolean combination: Roth's table, programs over many operands, and the sweep that turns crossings of
//! leaves into boundaries of the result.

mod border;
mod bounds;
mod chain;
mod contact;
mod event;
pub mod op;
mod program;
mod single;
mod sweep;
mod table;

pub use bounds::LeafBounds;
pub use contact::Turn;
pub use event::{Boundary, Change, Event, HitKind};
pub use op::Op;
pub use program::{Program, ProgramState, Tree, TreeNode};
pub use single::Single;
pub use sweep::Sweep;
