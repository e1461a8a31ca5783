//! `a | b`, `a & b` and `a - b`, by value and by reference.

use std::ops::{BitAnd, BitOr, Sub};
use std::sync::Arc;

use super::Shape;
use super::part::What;
use crate::scene::Op;

/// A combination of two shapes. A chain, as in `a - b - c`, is one combination of many operands where nothing else holds
/// the one so far. Otherwise that one stays a node of its own, which compiles to the same world.
fn combine(op: Op, mut left: Shape, right: Shape) -> Shape {
    if let Some(part) = Arc::get_mut(&mut left.0)
        && matches!(part.what, What::Combination(same) if same == op)
        && part.accel.is_none()
    {
        part.children.push(right.0);
        return left;
    }
    Shape::new(What::Combination(op), [left, right])
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
