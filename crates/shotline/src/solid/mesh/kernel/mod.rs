//! Casts blocks of rays at a mesh. Whatever it returns has the bits of the plain path, [`MeshSolid::hits`](super::MeshSolid::hits)
//! and [`MeshSolid::nearest`](super::MeshSolid::nearest), which stays the definition.
//!
//! The boxes of the tree are float32 and conservative. Triangles are tested in float64, four at a time, with bounds on
//! all rounding (`leaf`); the plain path decides what these leave open. The `t` of the hits that are returned are
//! computed by the same double-double operations as in the plain path, many at a time (`finish`). Incoherent rays are
//! traversed 32 at a time, without branches that depend on the data (`wave`); coherent ones share one traversal
//! (`stream`). Which of the two is used changes no result.

mod block;
mod cast;
mod coherence;
mod context;
mod finish;
mod found;
mod frame;
mod index;
mod leaf;
mod lines;
mod node;
mod prepare;
mod ray;
mod stream;
mod walk;
mod wave;
mod widths;

pub(crate) use cast::KernelMemory;

pub(super) use frame::MeshFrame;
pub(super) use index::WideIndex;
pub(crate) use lines::{BlockQuery, Lines, RayBlock};
pub(super) use ray::{CLEARANCE, INSET};
