//! Text in aligned columns.

use terminal_size::{Width, terminal_size_of};

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

    /// The lines of the table, each with a line end. On a terminal that is narrower, cells of words are wrapped, and where that
    /// is not enough, columns follow below the others, with the first column again.
    pub fn text(&self) -> String {
        self.within(terminal_columns())
    }

    /// The lines of the table in lines of `most` characters at most, if there is a limit.
    fn within(&self, most: Option<usize>) -> String {
        let all: Vec<usize> = (0..self.columns.len()).collect();
        let natural: Vec<usize> = all.iter().map(|c| self.natural_width(*c)).collect();
        let Some(most) = most.filter(|most| total(&natural) > *most) else {
            return self.lines(&all, &natural);
        };
        let bands = self.bands(&natural, most);
        let band = |band: &Vec<usize>| self.lines(band, &self.shrunk(band, &natural, most));
        bands.iter().map(band).collect::<Vec<_>>().join("\n")
    }

    fn heading(&self, column: usize) -> &str {
        &self.columns[column].0
    }

    fn natural_width(&self, column: usize) -> usize {
        let cells = self.rows.iter().filter_map(|row| row.get(column)).map(String::as_str);
        cells.chain([self.heading(column)]).map(width).max().unwrap_or(0)
    }

    /// The width below which a column is not wrapped. Numbers are never wrapped.
    fn least_width(&self, column: usize, natural: usize) -> usize {
        match self.columns[column].1 {
            Align::Left => natural.min(LEAST.max(width(self.heading(column)))),
            Align::Right => natural,
        }
    }

    /// The columns in groups that fit, each but the first with the first column before it.
    fn bands(&self, natural: &[usize], most: usize) -> Vec<Vec<usize>> {
        let least: Vec<usize> = natural.iter().enumerate().map(|(c, n)| self.least_width(c, *n)).collect();
        let mut bands: Vec<Vec<usize>> = vec![vec![0]];
        for column in 1..self.columns.len() {
            let Some(band) = bands.last_mut() else { break };
            let widths: Vec<usize> = band.iter().chain([&column]).map(|c| least[*c]).collect();
            if band.len() == 1 || total(&widths) <= most {
                band.push(column);
            } else {
                bands.push(vec![0, column]);
            }
        }
        bands
    }

    /// The widths of columns in a line of `most` characters: the widest column of words gives way first.
    fn shrunk(&self, band: &[usize], natural: &[usize], most: usize) -> Vec<usize> {
        let mut widths: Vec<usize> = band.iter().map(|c| natural[*c]).collect();
        let least: Vec<usize> = band.iter().map(|c| self.least_width(*c, natural[*c])).collect();
        while total(&widths) > most {
            let can_shrink = (0..band.len()).filter(|i| widths[*i] > least[*i]);
            let Some(widest) = can_shrink.max_by_key(|i| widths[*i]) else { break };
            widths[widest] -= 1;
        }
        widths
    }

    fn lines(&self, columns: &[usize], widths: &[usize]) -> String {
        let heading: Vec<String> = self.columns.iter().map(|(name, _)| name.clone()).collect();
        let mut out = String::new();
        for row in [&heading].into_iter().chain(&self.rows) {
            let cell = |(column, width): (&usize, &usize)| {
                wrapped(row.get(*column).map_or("", String::as_str), *width)
            };
            let cells: Vec<Vec<&str>> = columns.iter().zip(widths).map(cell).collect();
            for number in 0..cells.iter().map(Vec::len).max().unwrap_or(0) {
                let mut line = String::new();
                for ((column, lines), &width) in columns.iter().zip(&cells).zip(widths) {
                    let part = lines.get(number).copied().unwrap_or("");
                    match self.columns[*column].1 {
                        Align::Left => line += &format!("  {part:<width$}"),
                        Align::Right => line += &format!("  {part:>width$}"),
                    }
                }
                out += line.trim_end();
                out.push('\n');
            }
        }
        out
    }
}

/// The width to which a column of words may be wrapped.
const LEAST: usize = 16;

/// How many characters fit on a line of standard output; `None` if it is no terminal.
fn terminal_columns() -> Option<usize> {
    terminal_size_of(std::io::stdout()).map(|(Width(columns), _)| columns.into())
}

fn width(text: &str) -> usize {
    text.chars().count()
}

/// The length of a line with columns of these widths.
fn total(widths: &[usize]) -> usize {
    widths.iter().map(|width| width + 2).sum()
}

/// A text in lines of at most this many characters, broken at blanks where there are some, else after a slash or anywhere.
fn wrapped(text: &str, most: usize) -> Vec<&str> {
    let mut lines = Vec::new();
    let mut rest = text;
    while width(rest) > most.max(1) {
        let end = rest.char_indices().nth(most.max(1)).map_or(rest.len(), |(at, _)| at);
        let is_between = rest[end..].starts_with(' ');
        let blank = if is_between { Some(end) } else { rest[..end].rfind(' ').filter(|at| *at > 0) };
        let slash = || rest[..end].rfind('/').map(|at| at + 1);
        let (line, next) = match (blank, slash()) {
            (Some(at), _) => (at, at + 1),
            (None, Some(at)) => (at, at),
            (None, None) => (end, end),
        };
        lines.push(&rest[..line]);
        rest = rest[next..].trim_start_matches(' ');
    }
    lines.push(rest);
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_aligned() {
        let mut table = Table::new(vec![("t".into(), Align::Right), ("object".into(), Align::Left)]);
        table.row(vec!["1.25".into(), "a".into()]);
        table.row(vec!["10".into(), "bo\x1bt".into()]);
        assert_eq!(table.within(None), "     t  object\n  1.25  a\n    10  bo\u{FFFD}t\n");
        assert_eq!(table.within(Some(14)), table.within(None));
    }

    #[test]
    fn words_are_wrapped_and_numbers_are_not() {
        let mut table = Table::new(vec![("object".into(), Align::Left), ("t".into(), Align::Right)]);
        table.row(vec!["a part of an engine/cylinder head/valve".into(), "1.25".into()]);
        let expected =
            "  object                   t\n  a part of an          1.25\n  engine/cylinder\n  head/valve\n";
        assert_eq!(table.within(Some(28)), expected);
    }

    #[test]
    fn columns_that_do_not_fit_follow_below() {
        let names = ["#", "first", "second", "third"];
        let mut table = Table::new(names.iter().map(|name| ((*name).into(), Align::Right)).collect());
        table.row(["7", "1111111111", "2222222222", "3333333333"].map(String::from).to_vec());
        let expected =
            "  #       first      second\n  7  1111111111  2222222222\n\n  #       third\n  7  3333333333\n";
        assert_eq!(table.within(Some(30)), expected);
        // Nothing is lost on a terminal that is too narrow for anything.
        let narrow = table.within(Some(3));
        assert_eq!(narrow.matches("  7  ").count(), 3, "{narrow}");
    }

    #[test]
    fn texts_are_wrapped_at_blanks_and_slashes() {
        assert_eq!(wrapped("ab cd", 5), ["ab cd"]);
        assert_eq!(wrapped("ab cd", 2), ["ab", "cd"]);
        assert_eq!(wrapped("world/hall/wall", 12), ["world/hall/", "wall"]);
        assert_eq!(wrapped("größenordnung", 5), ["größe", "nordn", "ung"]);
        assert_eq!(wrapped("", 0), [""]);
        assert_eq!(wrapped("üü üü", 1), ["ü", "ü", "ü", "ü"]);
    }
}
