//! Attributes whose values are named by the corners of faces.

use shotline::solid::mesh::{Attribute, NO_ROW};

/// An attribute while its file is read: values, and for each corner of a face which of them it has.
#[derive(Debug)]
pub(crate) struct CornerValues {
    name: String,
    width: usize,
    numbers: Vec<f64>,
    /// For each corner up to the last that has a value its index, or [`NO_ROW`].
    rows: Vec<u32>,
}

impl CornerValues {
    pub(crate) fn new(name: impl Into<String>, width: usize) -> CornerValues {
        CornerValues { name: name.into(), width, numbers: Vec::new(), rows: Vec::new() }
    }

    /// Adds a value. Numbers that are missing are 0, those beyond the width are left out.
    pub(crate) fn push(&mut self, numbers: impl IntoIterator<Item = f64>) {
        let end = self.numbers.len() + self.width;
        self.numbers.extend(numbers.into_iter().take(self.width));
        self.numbers.resize(end, 0.0);
    }

    /// How many numbers a value has.
    pub(crate) fn width(&self) -> usize {
        self.width
    }

    /// How many values there are.
    pub(crate) fn len(&self) -> usize {
        self.numbers.len() / self.width
    }

    /// Gives a value to a corner; corners are given in ascending order.
    pub(crate) fn set(&mut self, corner: usize, row: u32) {
        self.rows.resize(corner, NO_ROW);
        self.rows.push(row);
    }

    /// Takes its value from a corner, if it has none of those there are.
    pub(crate) fn unset_beyond(&mut self, corner: usize) -> bool {
        let is_beyond = self.rows[corner] as usize >= self.len();
        if is_beyond {
            self.rows[corner] = NO_ROW;
        }
        is_beyond
    }

    /// Whether no corner has a value.
    pub(crate) fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// The attribute of triangles, given the numbers of their corners.
    pub(crate) fn finish(self, corners: &[[u32; 3]]) -> Option<Attribute> {
        let row = |corner: u32| self.rows.get(corner as usize).copied().unwrap_or(NO_ROW);
        let rows: Vec<[u32; 3]> = corners.iter().map(|triangle| triangle.map(row)).collect();
        let is_used = rows.iter().flatten().any(|row| *row != NO_ROW);
        let CornerValues { name, width, numbers: values, .. } = self;
        is_used.then_some(Attribute { name, width, values, corners: Some(rows) })
    }
}
