//! Results as lines of text, with names in place of numbers.

use std::io::{self, Write};

use shotline_io::arrays::fill_csv;

use super::Values;

/// A column of text.
struct Cells<'a> {
    name: String,
    rows: usize,
    cell: Box<dyn Fn(usize) -> String + 'a>,
}

/// Writes a heading and a line for each row.
///
/// # Errors
/// If writing fails.
pub fn write(arrays: &[(&'static str, Values)], is_by_object: bool, out: &mut impl Write) -> io::Result<()> {
    let all = Arrays { arrays, is_by_object };
    let columns: Vec<Cells> = arrays.iter().flat_map(|(name, values)| all.cells(name, values)).collect();
    let heading: Vec<String> = columns.iter().map(|column| column.name.clone()).collect();
    let rows = columns.iter().map(|column| column.rows).max().unwrap_or(0);
    fill_csv(out, &heading, (0..rows).map(|row| columns.iter().map(|column| (column.cell)(row)).collect()))
}

/// All arrays of a result.
struct Arrays<'a> {
    arrays: &'a [(&'static str, Values)],
    is_by_object: bool,
}

impl<'a> Arrays<'a> {
    /// The columns of an array: none for a table of names, three for vectors.
    fn cells(&self, name: &'static str, values: &'a Values) -> Vec<Cells<'a>> {
        let column =
            |name: String, rows: usize, cell: Box<dyn Fn(usize) -> String + 'a>| Cells { name, rows, cell };
        let one =
            |rows: usize, cell: Box<dyn Fn(usize) -> String + 'a>| vec![column(name.to_owned(), rows, cell)];
        match values {
            Values::Text(_) => Vec::new(),
            Values::I64(splits) if name == "ray_splits" => {
                let rows = splits.last().map_or(0, |end| *end as usize);
                let ray = |row: usize| splits.partition_point(|begin| *begin <= row as i64) - 1;
                vec![column("ray".into(), rows, Box::new(move |row| ray(row).to_string()))]
            }
            Values::I8(kinds) if name == "kind" => {
                let words = ["surface", "start", "end"];
                one(
                    kinds.len(),
                    Box::new(move |row| words.get(kinds[row] as usize).unwrap_or(&"").to_string()),
                )
            }
            Values::I32(numbers) => match self.names(name) {
                Some(names) => one(numbers.len(), Box::new(move |row| named(names, i64::from(numbers[row])))),
                None => one(numbers.len(), Box::new(move |row| numbers[row].to_string())),
            },
            Values::I64(numbers) => match self.names(name) {
                Some(names) => one(numbers.len(), Box::new(move |row| named(names, numbers[row]))),
                None => one(numbers.len(), Box::new(move |row| numbers[row].to_string())),
            },
            Values::F64(numbers) => one(numbers.len(), Box::new(move |row| number(numbers[row]))),
            Values::I8(numbers) => one(numbers.len(), Box::new(move |row| numbers[row].to_string())),
            Values::Bool(values) => one(values.len(), Box::new(move |row| values[row].to_string())),
            Values::Vec3(vectors) => {
                let axis = |(i, axis)| {
                    column(
                        format!("{name}_{axis}"),
                        vectors.len(),
                        Box::new(move |row| number(vectors[row][i])),
                    )
                };
                ["x", "y", "z"].into_iter().enumerate().map(axis).collect()
            }
            Values::Rows(width, numbers) => self
                .columns_of_rows()
                .into_iter()
                .enumerate()
                .map(|(i, name)| {
                    let cell = move |row: usize| number(numbers[row * width + i]);
                    column(name, numbers.len() / width, Box::new(cell))
                })
                .collect(),
            Values::I64Rows(..) | Values::I32Rows(..) => Vec::new(),
        }
    }

    /// The names of the columns of `thickness`: those of the objects, or those of the materials and `no material`.
    fn columns_of_rows(&self) -> Vec<String> {
        if self.is_by_object {
            return self.names("object").unwrap_or_default().to_vec();
        }
        let materials = self.names("material").unwrap_or_default();
        materials.iter().cloned().chain(["no material".to_owned()]).collect()
    }

    /// The table of names for an array of numbers, if it has one.
    fn names(&self, of: &str) -> Option<&'a [String]> {
        self.arrays.iter().find_map(|(name, values)| match values {
            Values::Text(names) if name.strip_suffix("_names") == Some(of) => Some(names.as_slice()),
            _ => None,
        })
    }
}

fn named(names: &[String], number: i64) -> String {
    usize::try_from(number).ok().and_then(|number| names.get(number)).cloned().unwrap_or_default()
}

/// All digits that a number needs. NaN is an empty cell.
fn number(x: f64) -> String {
    if x.is_nan() { String::new() } else { format!("{x:?}") }
}
