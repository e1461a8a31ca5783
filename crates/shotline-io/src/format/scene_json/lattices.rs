//! Reads the operations of a scene file that place copies: lattices and rings.

use std::sync::Arc;

use shotline::math::{Lattice, MAX_CELLS, Vec3};
use shotline::scene::{EMPTY_CELL, LocalTransform, Rotation};

use super::keys::{HEXAGONAL_LATTICE, LATTICE};
use super::values::Values;
use crate::json::{Content, ValueId};

/// Where the cells of a lattice are, and the table of what they hold, if it has one.
pub(super) type Cells = (Lattice, Option<Arc<[u32]>>);

/// The cells of an operation that places copies of its args, by its name; `None` for other operations.
pub(super) fn is_lattice(op: &str) -> bool {
    op == LATTICE || op == HEXAGONAL_LATTICE
}

/// Reads the keys of a lattice, but for its args. The compiler checks what the numbers are.
pub(super) fn read(values: &mut Values, at: ValueId, op: &str) -> Option<Cells> {
    let lattice = if op == LATTICE { rectangular(values, at) } else { hexagonal(values, at) };
    let table = match values.tree.get(at, "cells") {
        Some(cells) => Some(table(values, cells)?),
        None => None,
    };
    Some((lattice?, table))
}

fn rectangular(values: &mut Values, at: ValueId) -> Option<Lattice> {
    let what = "this lattice";
    let counts = values.required(at, what, "counts", "the numbers of cells along x, y and z: [nx, ny, nz]");
    let pitch = values.required(at, what, "pitch", "the distances along x, y and z: [dx, dy, dz]");
    let counts = counts.and_then(|at| {
        let [x, y, z] = *values.array(at, "\"counts\"")? else {
            values.report(at, "\"counts\" must be three whole numbers", "as in [nx, ny, nz]");
            return None;
        };
        Some([size(values, x, "counts")?, size(values, y, "counts")?, size(values, z, "counts")?])
    });
    let pitch = pitch.and_then(|at| values.vector(at, "\"pitch\""));
    let stagger = match values.tree.get(at, "stagger") {
        Some(at) => values.boolean(at, "\"stagger\"")?,
        None => false,
    };
    Some(Lattice::Rectangular { counts: counts?, pitch: pitch?, stagger })
}

fn hexagonal(values: &mut Values, at: ValueId) -> Option<Lattice> {
    let what = "this hexagonal lattice";
    let rings =
        values.required(at, what, "rings", "the number of rings around the cell in the middle, with it");
    let pitch = values.required(at, what, "pitch", "the distance between neighbours: a number");
    let rings = rings.and_then(|at| size(values, at, "rings"));
    let pitch = pitch.and_then(|at| values.number(at, "\"pitch\""));
    let layers = match values.tree.get(at, "layers") {
        Some(at) => size(values, at, "layers")?,
        None => 1,
    };
    let height = match values.tree.get(at, "height") {
        Some(at) => values.number(at, "\"height\"")?,
        None => 0.0,
    };
    Some(Lattice::Hexagonal { rings: rings?, pitch: pitch?, layers, height })
}

/// A number of cells.
fn size(values: &mut Values, at: ValueId, key: &str) -> Option<u32> {
    let x = values.number(at, &format!("each of \"{key}\""))?;
    if x.fract() == 0.0 && (1.0..=MAX_CELLS as f64).contains(&x) {
        return Some(x as u32);
    }
    values.report(at, format!("\"{key}\" must be whole numbers"), format!("from 1 to {MAX_CELLS}"));
    None
}

/// The largest number of copies of a ring, each of which is a node of the scene.
const MAX_TURNS: u32 = 1 << 20;

/// The turns of the copies of a ring.
pub(super) fn turns(
    values: &mut Values,
    at: ValueId,
) -> Option<impl Iterator<Item = LocalTransform> + use<>> {
    let count_at = values.required(at, "this ring", "count", "the number of copies: a whole number")?;
    let count = size(values, count_at, "count")?;
    if count > MAX_TURNS {
        values.report(
            count_at,
            format!("a ring of {count} copies is too large"),
            format!("up to {MAX_TURNS}"),
        );
        return None;
    }
    let step = match values.tree.get(at, "step") {
        Some(at) => values.number(at, "\"step\"")?,
        None => 360.0 / f64::from(count),
    };
    let turn = move |i| Vec3::new(0.0, 0.0, f64::from(i) * step);
    Some((0..count).map(move |i| LocalTransform::rotation(Rotation::Xyz(turn(i)))))
}

/// The index of the element of each cell; null for an empty one.
fn table(values: &mut Values, at: ValueId) -> Option<Arc<[u32]>> {
    let cells = values.array(at, "\"cells\"")?;
    let mut table = Some(Vec::with_capacity(cells.len()));
    for &cell in cells {
        let element = match values.tree.content(cell) {
            Content::Null => Some(EMPTY_CELL),
            Content::Number(x) if x.fract() == 0.0 && (0.0..f64::from(EMPTY_CELL)).contains(x) => {
                Some(*x as u32)
            }
            _ => {
                values.report(cell, "a cell is the index of one of the args, or null", "as in [0, 1, null]");
                None
            }
        };
        table = table.zip(element).map(|(mut table, element)| {
            table.push(element);
            table
        });
    }
    table.map(Arc::from)
}
