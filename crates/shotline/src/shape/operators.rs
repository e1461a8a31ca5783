//! `a | b`, `a & b` and `a - b`, by value and by reference.

use std::ops::{BitAnd, BitOr, Sub};
use std::sync::Arc;

use super::Shape;
use super::node::NodeKind;
use crate::scene::Op;

/// A combination of two shapes. A chain, as in `a - b - c`, becomes one combination of many operands, unless the
/// intermediate shape is used elsewhere too or has its own accelerator. Such a shape stays a node of its own, which
/// compiles to the same world.
fn combine(op: Op, mut left: Shape, right: Shape) -> Shape {
    if let Some(node) = Arc::get_mut(&mut left.0)
        && matches!(node.kind, NodeKind::Combination(same) if same == op)
        && node.accel.is_none()
        && !node.children.is_empty()
    {
        node.children.push(right.0);
        return left;
    }
    Shape::new(NodeKind::Combination(op), [left, right])
}

impl From<&Shape> for Shape {
    fn from(shape: &Shape) -> Shape {
        shape.clone()
    }
}

macro_rules! operators {
    ($($trait:ident::$method:ident is $op:ident;)*) => {
        $(
            operators!($trait, $method, $op, Shape, Shape);
            operators!($trait, $method, $op, Shape, &Shape);
            operators!($trait, $method, $op, &Shape, Shape);
            operators!($trait, $method, $op, &Shape, &Shape);
        )*
    };
    ($trait:ident, $method:ident, $op:ident, $left:ty, $right:ty) => {
        impl $trait<$right> for $left {
            type Output = Shape;

            fn $method(self, right: $right) -> Shape {
                combine(Op::$op, self.into(), right.into())
            }
        }
    };
}

operators! {
    BitOr::bitor is Union;
    BitAnd::bitand is Intersection;
    Sub::sub is Difference;
}
