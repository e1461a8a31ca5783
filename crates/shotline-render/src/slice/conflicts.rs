//! Objects of equal priority that overlap on a slice, and objects that stick out of what contains and clips them.

use std::collections::BTreeMap;

use shotline::compile::World;
use shotline::crossing::GROUPING;
use shotline::query::{Caster, Conflict, ConflictKind, QueryError};
use shotline::ray::{Ray, Span};

/// An interval of a row in which two objects are in conflict.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConflictPart {
    /// Where it begins and ends, in columns from the left side.
    pub columns: [f64; 2],
    /// The pair: an index into [`Slice::pairs`](super::Slice::pairs).
    pub pair: u32,
}

/// Two objects that are in conflict on a slice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairInConflict {
    /// What is wrong.
    pub kind: ConflictKind,
    /// The object of the lower number; the one that sticks out.
    pub first: u32,
    /// The other; the one that it sticks out of. Both may be one object that is placed twice.
    pub second: u32,
    /// The pixels whose middles are in the conflict. There may be none in a thin one.
    pub pixels: u64,
    /// The column and the row of a point in it, in pixels from the upper left corner.
    pub at: [f64; 2],
}

impl PairInConflict {
    /// What is wrong, with both names.
    pub fn text(&self, world: &World) -> String {
        let name = |object: u32| world.object_names().get(object as usize).map_or("", String::as_str);
        let (first, second) = (name(self.first), name(self.second));
        match self.kind {
            ConflictKind::Overlap if self.first == self.second => {
                format!("two placements of '{first}' overlap")
            }
            ConflictKind::Overlap => format!("'{first}' and '{second}' overlap"),
            ConflictKind::Protrusion => format!("'{first}' sticks out of '{second}'"),
        }
    }
}

/// The kind and the objects of a conflict, alike for whichever a ray enters first.
type Key = (ConflictKind, u32, u32);

/// A conflict on a row: where, and what.
pub(super) type RowConflict = ([f64; 2], Key);

/// The conflicts on the ray of a row that are longer than rounding, with their intervals of `t`.
pub(super) fn on_row(
    caster: &mut Caster,
    ray: &Ray,
    span: Span,
    found: &mut Vec<Conflict>,
) -> Result<Vec<RowConflict>, QueryError> {
    found.clear();
    caster.conflicts(ray, span, found)?;
    let wide = found.iter().filter(|c| c.t_out - c.t_in > GROUPING * c.t_err);
    Ok(wide.map(|c| ([c.t_in, c.t_out], key(c))).collect())
}

fn key(&Conflict { kind, first, second, .. }: &Conflict) -> Key {
    let is_in_order = kind == ConflictKind::Protrusion || first <= second;
    if is_in_order { (kind, first, second) } else { (kind, second, first) }
}

/// The pairs of all rows in the order of their kinds and numbers, each at its longest interval, and the intervals with the
/// numbers of their pairs. The first pixel has its middle at `t` = 1.
pub(super) fn by_pair(rows: Vec<Vec<RowConflict>>) -> (Vec<PairInConflict>, Vec<Vec<ConflictPart>>) {
    let mut known: BTreeMap<Key, ([f64; 2], f64)> = BTreeMap::new();
    for (row, conflicts) in rows.iter().enumerate() {
        for &([from, to], key) in conflicts {
            let longest = known.entry(key).or_insert(([0.0; 2], 0.0));
            if to - from > longest.1 {
                *longest = ([from.midpoint(to) - 0.5, row as f64 + 0.5], to - from);
            }
        }
    }
    let pair = |(&(kind, first, second), &(at, _)): (&Key, &([f64; 2], f64))| PairInConflict {
        kind,
        first,
        second,
        pixels: 0,
        at,
    };
    let pairs: Vec<PairInConflict> = known.iter().map(pair).collect();
    let numbers: BTreeMap<Key, u32> = known.into_keys().zip(0..).collect();
    let part = |([from, to], key): RowConflict| ConflictPart {
        columns: [from - 0.5, to - 0.5],
        pair: numbers[&key],
    };
    let parts = rows.into_iter().map(|row| row.into_iter().map(part).collect()).collect();
    (pairs, parts)
}
