//! Rays and results as text, as spreadsheets read and write them: values separated by commas, a row a line.

use std::io::{self, Write};

use csv::{ReaderBuilder, Trim, Writer};

use crate::diagnostic::RawDiagnostic;

const HELP: &str = "a line is the origin x, y, z and the direction x, y, z: six numbers with commas between them; the first \
                    line may have their names";

/// The rows of a text. Empty lines and lines that begin with `#` are skipped, and the first line may be a heading.
pub(super) fn rows(bytes: &[u8]) -> Result<Vec<[f64; 6]>, RawDiagnostic> {
    let mut reader = ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .comment(Some(b'#'))
        .trim(Trim::All)
        .from_reader(bytes);
    let mut rows = Vec::new();
    let mut is_first = true;
    for record in reader.byte_records() {
        let record =
            record.map_err(|error| RawDiagnostic::file(format!("this is not CSV: {error}")).help(HELP))?;
        let numbers: Vec<Option<f64>> = record.iter().map(number).collect();
        let is_heading = std::mem::take(&mut is_first) && numbers.iter().all(Option::is_none);
        if is_heading {
            continue;
        }
        let line = record.position().map_or(0, csv::Position::line);
        let refuse = |why: String| RawDiagnostic::file(format!("line {line}: {why}")).help(HELP);
        if numbers.len() != 6 {
            return Err(refuse(format!("a ray has six numbers, not {}", numbers.len())));
        }
        let mut row = [0.0; 6];
        for (column, (number, text)) in numbers.iter().zip(record.iter()).enumerate() {
            let text = String::from_utf8_lossy(text);
            row[column] = number.ok_or_else(|| refuse(format!("'{}' is not a number", shown(&text))))?;
        }
        rows.push(row);
    }
    Ok(rows)
}

fn number(text: &[u8]) -> Option<f64> {
    std::str::from_utf8(text).ok()?.parse().ok()
}

/// The first letters of a text that may be any file.
fn shown(text: &str) -> String {
    text.chars().take(40).map(|c| if c.is_control() { '\u{FFFD}' } else { c }).collect()
}

/// Writes a heading and rows.
///
/// # Errors
/// If writing fails.
pub fn fill_csv(
    out: &mut impl Write,
    heading: &[String],
    rows: impl Iterator<Item = Vec<String>>,
) -> io::Result<()> {
    let mut writer = Writer::from_writer(out);
    writer.write_record(heading)?;
    for row in rows {
        writer.write_record(&row)?;
    }
    writer.flush()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_read_with_and_without_a_heading() {
        let expected = vec![[0.0, 0.5, -1.0, 1e-3, 0.0, 1.0], [1.0, 2.0, 3.0, 4.0, 5.0, f64::INFINITY]];
        let plain = "0, .5,-1,1e-3,0,1\n\n# a note\n1,2,3,4,5,inf\n";
        for text in [plain.to_owned(), format!("ox,oy,oz,dx,dy,dz\n{plain}"), plain.replace('\n', "\r\n")] {
            assert_eq!(rows(text.as_bytes()).unwrap(), expected, "{text}");
        }
        assert!(rows(b"").unwrap().is_empty());
    }

    #[test]
    fn errors_name_the_line() {
        let message = |text: &str| rows(text.as_bytes()).unwrap_err().message;
        assert_eq!(message("1,2,3,4,5,6\n1,2,3\n"), "line 2: a ray has six numbers, not 3");
        assert_eq!(message("x,y,z,a,b,c\n1,2,3,4,5,six\n"), "line 2: 'six' is not a number");
        assert_eq!(message("1,2,3,4,5,6\na,b,c,d,e,f\n"), "line 2: 'a' is not a number");
        // A first line without any number is taken for a heading.
        assert_eq!(message("1;2;3;4;5;6\n1;2;3;4;5;6\n"), "line 2: a ray has six numbers, not 1");
    }
}
