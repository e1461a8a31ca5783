//! Lines in lanes: several lines at once, one in each lane of a register.
//!
//! Every operation is that of a single line, in the same order and without fused ones, so each lane has the same bits.

mod boxes;
mod ends;
mod lines;
pub(crate) mod vector;

pub(crate) use boxes::BoxLanes;
pub(crate) use ends::{EndLanes, InsideLanes, IntervalLanes};
pub(crate) use lines::LineLanes;
