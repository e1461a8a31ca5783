//! The boolean operations.

/// Union, intersection or difference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Op {
    /// In any operand.
    Union,
    /// In all operands.
    Intersection,
    /// In the first operand and in no other.
    Difference,
}

impl Op {
    /// The name in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Op::Union => "union",
            Op::Intersection => "intersection",
            Op::Difference => "difference",
        }
    }
}
