//! The results of a batch as named arrays: names and types are those of the Python results.

mod lines;

use std::collections::HashSet;
use std::path::Path;

use shotline::compile::World;
use shotline::math::Vec3;
use shotline::query::ConflictKind;
use shotline::query::batch::{self, ClosestRows, CrossingRows, SegmentRows, Thickness};
use shotline_io::arrays::{Column, fill_npz};
use shotline_render::slice::{Area, PairInConflict, Slice};

use crate::failure::Failure;
use crate::output;
use crate::rays::Rays;

/// Values of one type, one per row.
#[derive(Debug)]
enum Values {
    F64(Vec<f64>),
    Vec3(Vec<[f64; 3]>),
    /// This many numbers per row.
    Rows(usize, Vec<f64>),
    I64(Vec<i64>),
    I64Rows(usize, Vec<i64>),
    I32Rows(usize, Vec<i32>),
    I32(Vec<i32>),
    I8(Vec<i8>),
    Bool(Vec<bool>),
    Text(Vec<String>),
}

/// Named arrays, in the order in which they are written.
#[derive(Debug, Default)]
pub struct Columns {
    arrays: Vec<(&'static str, Values)>,
    /// Whether the columns of `thickness` are those of the objects, not of the materials.
    is_by_object: bool,
}

/// The arrays that were asked for, and those that are always there.
fn only(wanted: batch::Fields, mut arrays: Vec<(&'static str, Values)>) -> Vec<(&'static str, Values)> {
    arrays.retain(|(name, _)| batch::Fields::named(name).is_none_or(|column| wanted.contains(column)));
    arrays
}

impl Columns {
    /// One row per ray.
    pub fn closest(rows: ClosestRows, rays: &Rays, wanted: batch::Fields) -> Columns {
        let arrays = vec![
            ("t", Values::F64(rays.by_row(rows.t, f64::INFINITY))),
            ("t_err", Values::F64(rays.by_row(rows.t_err, f64::NAN))),
            ("normal", Values::Vec3(rays.by_row(rows.normal, [f64::NAN; 3]))),
            ("object", Values::I32(rays.by_row(rows.object, -1))),
            ("surface", Values::I32(rays.by_row(rows.surface, -1))),
            ("primitive", Values::I32(rays.by_row(rows.primitive, -1))),
            ("path", Values::I64(rays.by_row(rows.path, -1))),
            ("entering", Values::Bool(rays.by_row(rows.entering, false))),
        ];
        Columns { arrays: only(wanted, arrays), is_by_object: false }
    }

    /// One row per ray.
    pub fn any(rows: Vec<bool>, rays: &Rays) -> Columns {
        Columns { arrays: vec![("any", Values::Bool(rays.by_row(rows, false)))], is_by_object: false }
    }

    /// One row per ray.
    pub fn count(rows: Vec<i64>, rays: &Rays) -> Columns {
        Columns { arrays: vec![("count", Values::I64(rays.by_row(rows, 0)))], is_by_object: false }
    }

    /// One row per crossing.
    pub fn crossings(rows: CrossingRows, rays: &Rays, wanted: batch::Fields) -> Columns {
        let arrays = vec![
            ("ray_splits", Values::I64(rays.splits_by_row(rows.ray_splits))),
            ("t", Values::F64(rows.t)),
            ("t_err", Values::F64(rows.t_err)),
            ("normal", Values::Vec3(rows.normal)),
            ("entering", Values::Bool(rows.entering)),
            ("object", Values::I32(rows.object)),
            ("surface", Values::I32(rows.surface)),
            ("primitive", Values::I32(rows.primitive)),
            ("path", Values::I64(rows.path)),
            ("kind", Values::I8(rows.kind)),
        ];
        Columns { arrays: only(wanted, arrays), is_by_object: false }
    }

    /// One row per segment.
    pub fn segments(rows: SegmentRows, rays: &Rays) -> Columns {
        let arrays = vec![
            ("ray_splits", Values::I64(rays.splits_by_row(rows.ray_splits))),
            ("t_in", Values::F64(rows.t_in)),
            ("t_out", Values::F64(rows.t_out)),
            ("length", Values::F64(rows.length)),
            ("material", Values::I32(rows.material)),
            ("object", Values::I32(rows.object)),
            ("path", Values::I64(rows.path)),
        ];
        Columns { arrays, is_by_object: false }
    }

    /// One row per ray, with a number for each material or object.
    pub fn thickness(thickness: Thickness, rays: &Rays, is_by_object: bool) -> Columns {
        let Thickness { lengths, columns, .. } = thickness;
        let arrays = vec![("thickness", Values::Rows(columns, rays.rows_by_row(lengths, columns)))];
        Columns { arrays, is_by_object }
    }

    /// A row per row of pixels, from the top; and where the pixels are.
    pub fn slice(slice: Slice) -> Columns {
        let width = slice.width as usize;
        let Area { min, max } = slice.area;
        let vector = |v: Vec3| Values::F64(v.to_array().to_vec());
        let of_pairs = |number: fn(&PairInConflict) -> i32| slice.pairs.iter().map(number).collect();
        let (first, second) = (of_pairs(|pair| pair.first as i32), of_pairs(|pair| pair.second as i32));
        let kinds = slice.pairs.iter().map(|pair| i8::from(pair.kind == ConflictKind::Protrusion)).collect();
        let arrays = vec![
            ("area", Values::F64(vec![min[0], min[1], max[0], max[1]])),
            ("origin", vector(slice.plane.at(0.0, 0.0))),
            ("u", vector(slice.plane.u())),
            ("v", vector(slice.plane.v())),
            ("overlap_first", Values::I32(first)),
            ("overlap_second", Values::I32(second)),
            ("overlap_kind", Values::I8(kinds)),
            ("object", Values::I32Rows(width, slice.object)),
            ("material", Values::I32Rows(width, slice.material)),
            ("path", Values::I64Rows(width, slice.path)),
            ("overlap", Values::I32Rows(width, slice.overlap)),
        ];
        Columns { arrays, is_by_object: false }
    }

    /// Adds the tables of names. Paths become indices into the table of the paths that were met: a scene may have more
    /// paths than can be listed, but a result has at most one per row.
    pub fn with_names(mut self, world: &World) -> Columns {
        let mut path_names = None;
        for (name, values) in &mut self.arrays {
            if let ("path", Values::I64(paths) | Values::I64Rows(_, paths)) = (*name, values) {
                let distinct = intern(paths);
                path_names = Some(distinct.into_iter().map(|p| world.path_name(p as u64)).collect());
            }
        }
        self.arrays.push(("object_names", Values::Text(world.object_names().to_vec())));
        self.arrays.push(("material_names", Values::Text(world.material_names().to_vec())));
        self.arrays.extend(path_names.map(|names| ("path_names", Values::Text(names))));
        self
    }

    /// Writes the arrays to an .npz file, or as lines to a .csv file; `-` is an .npz file on standard output.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), Failure> {
        if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("csv")) {
            return output::fill(path, |out| lines::write(&self.arrays, self.is_by_object, out));
        }
        let columns: Vec<(&str, Column)> =
            self.arrays.iter().map(|(name, values)| (*name, values.column())).collect();
        output::fill(path, |out| fill_npz(out, &columns))
    }
}

impl Values {
    fn column(&self) -> Column<'_> {
        match self {
            Values::F64(v) => Column::F64(v),
            Values::Vec3(v) => Column::Vec3(v),
            Values::Rows(width, values) => Column::Rows { width: *width, values },
            Values::I64(v) => Column::I64(v),
            Values::I64Rows(width, values) => Column::I64Rows { width: *width, values },
            Values::I32Rows(width, values) => Column::I32Rows { width: *width, values },
            Values::I32(v) => Column::I32(v),
            Values::I8(v) => Column::I8(v),
            Values::Bool(v) => Column::Bool(v),
            Values::Text(v) => Column::Text(v),
        }
    }
}

/// Replaces each number by its index among the distinct numbers, and returns these. They are ascending, so that the
/// result depends on the numbers only. -1 stays.
fn intern(numbers: &mut [i64]) -> Vec<i64> {
    let present: HashSet<i64> = numbers.iter().copied().filter(|n| *n >= 0).collect();
    let mut distinct: Vec<i64> = present.into_iter().collect();
    distinct.sort_unstable();
    for number in numbers {
        if let Ok(index) = distinct.binary_search(number) {
            *number = index as i64;
        }
    }
    distinct
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_interned_in_ascending_order() {
        let mut numbers = vec![1 << 60, -1, 7, 7, 1 << 60, 9];
        assert_eq!(intern(&mut numbers), [7, 9, 1 << 60]);
        assert_eq!(numbers, [2, -1, 0, 0, 2, 1]);
    }
}
