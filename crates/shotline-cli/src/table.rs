//! Text in aligned columns.

/// The alignment of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Align {
    /// For words.
    Left,
    /// For numbers.
    Right,
}

/// A table with a heading.
#[derive(Debug)]
pub struct Table {
    columns: Vec<(String, Align)>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// A table without rows.
    pub fn new(columns: Vec<(String, Align)>) -> Table {
        Table { columns, rows: Vec::new() }
    }

    /// Appends a row with one cell per column. Names can come from any file: control characters, which a terminal would
    /// execute, are replaced.
    pub fn row(&mut self, cells: Vec<String>) {
        let plain = |cell: String| cell.replace(char::is_control, "\u{FFFD}");
        self.rows.push(cells.into_iter().map(plain).collect());
    }

    /// The lines of the table, each with a line end.
    pub fn text(&self) -> String {
        let heading: Vec<String> = self.columns.iter().map(|(name, _)| name.clone()).collect();
        let widths: Vec<usize> = (0..self.columns.len())
            .map(|c| {
                let cells = self.rows.iter().chain([&heading]).filter_map(|row| row.get(c));
                cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
            })
            .collect();
        let mut out = String::new();
        for row in [&heading].into_iter().chain(&self.rows) {
            let mut line = String::new();
            for ((cell, &width), (_, align)) in row.iter().zip(&widths).zip(&self.columns) {
                match align {
                    Align::Left => line += &format!("  {cell:<width$}"),
                    Align::Right => line += &format!("  {cell:>width$}"),
                }
            }
            out += line.trim_end();
            out.push('\n');
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_aligned() {
        let mut table = Table::new(vec![("t".into(), Align::Right), ("object".into(), Align::Left)]);
        table.row(vec!["1.25".into(), "a".into()]);
        table.row(vec!["10".into(), "bo\x1bt".into()]);
        assert_eq!(table.text(), "     t  object\n  1.25  a\n    10  bo\u{FFFD}t\n");
    }
}
