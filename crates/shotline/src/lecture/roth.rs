//! Roth's classification (S. D. Roth, "Ray casting for modeling solids", 1982): the boolean operations on two lists
//! of crossings. Production code combines any number of operands with [`crate::csg::Program`] and
//! [`crate::csg::Sweep`]; tests compare them with this table.

use crate::crossing::{Crossing, are_coincident};
use crate::csg::Op;

/// Whether an interval of a ray is inside a solid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Inside.
    In,
    /// Outside.
    Out,
}

use Op::{Difference, Intersection, Union};
use Side::{In, Out};

/// Roth's table: operation, left, right, result.
pub const ROTH_TABLE: [(Op, Side, Side, Side); 12] = [
    (Union, In, In, In),
    (Union, In, Out, In),
    (Union, Out, In, In),
    (Union, Out, Out, Out),
    (Intersection, In, In, In),
    (Intersection, In, Out, Out),
    (Intersection, Out, In, Out),
    (Intersection, Out, Out, Out),
    (Difference, In, In, Out),
    (Difference, In, Out, In),
    (Difference, Out, In, Out),
    (Difference, Out, Out, Out),
];

/// Looks up Roth's table.
///
/// ```
/// use shotline::csg::Op;
/// use shotline::lecture::roth::{Side, classify};
/// assert_eq!(classify(Op::Difference, Side::In, Side::Out), Side::In);
/// ```
pub fn classify(op: Op, left: Side, right: Side) -> Side {
    let row = match op {
        Union => 0,
        Intersection => 4,
        Difference => 8,
    } + usize::from(left == Out) * 2
        + usize::from(right == Out);
    ROTH_TABLE[row].3
}

/// Merges the crossings of two solids into those of their combination. Coincident crossings are toggled together and
/// then classified once, so that solids that only touch leave no crossings.
///
/// ```
/// use shotline::crossing::Crossing;
/// use shotline::csg::Op;
/// use shotline::lecture::roth::combine;
/// let list = |a, b| [Crossing::new(a, 0.0, true, 0), Crossing::new(b, 0.0, false, 0)];
/// let t = |op| combine(op, &list(0.9, 3.1), &list(2.5, 4.5)).iter().map(|c| c.t).collect::<Vec<_>>();
/// assert_eq!(t(Op::Union), [0.9, 4.5]);
/// assert_eq!(t(Op::Intersection), [2.5, 3.1]);
/// assert_eq!(t(Op::Difference), [0.9, 2.5]);
/// ```
pub fn combine(op: Op, left: &[Crossing], right: &[Crossing]) -> Vec<Crossing> {
    let mut merged: Vec<(usize, Crossing)> =
        left.iter().map(|c| (0, *c)).chain(right.iter().map(|c| (1, *c))).collect();
    merged.sort_by(|a, b| a.1.t.total_cmp(&b.1.t));
    let mut sides = [Out, Out];
    let mut result = Out;
    let mut out = Vec::new();
    for group in merged.chunk_by(|a, b| are_coincident(&a.1, &b.1)) {
        for (operand, _) in group {
            sides[*operand] = if sides[*operand] == In { Out } else { In };
        }
        let now = classify(op, sides[0], sides[1]);
        if now != result {
            out.push(Crossing { entering: now == In, ..group[0].1 });
            result = now;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_the_algebra_of_sets() {
        for (op, left, right, result) in ROTH_TABLE {
            let (a, b) = (left == In, right == In);
            let expected = match op {
                Union => a || b,
                Intersection => a && b,
                Difference => a && !b,
            };
            assert_eq!(result == In, expected);
            assert_eq!(classify(op, left, right), result);
        }
    }

    fn list(ts: &[f64]) -> Vec<Crossing> {
        ts.iter().enumerate().map(|(i, &t)| Crossing::new(t, 1e-16, i % 2 == 0, 0)).collect()
    }

    #[test]
    fn touching_leaves_nothing() {
        assert!(combine(Difference, &list(&[1.0, 2.0]), &list(&[1.0, 2.0])).is_empty());
        assert!(combine(Intersection, &list(&[1.0, 2.0]), &list(&[2.0, 3.0])).is_empty());
        let joined = combine(Union, &list(&[1.0, 2.0]), &list(&[2.0, 3.0]));
        assert_eq!(joined.iter().map(|c| c.t).collect::<Vec<_>>(), [1.0, 3.0]);
    }
}
