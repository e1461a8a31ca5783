//! Errors as people read them: where, what, the line with a mark under it, and how to mend it.

use std::fmt::{self, Display, Formatter};
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};

use crate::bytes::{line_starts, mark_length};
use crate::fault::{At, Fault, Faults};

/// A file that cannot be read: everything that is wrong with it. Its text is ready for a terminal.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{}", Report(self))]
pub struct ReadError {
    /// The file, if there is one.
    pub path: Option<PathBuf>,
    /// What is wrong, at least one thing, in the order of the file.
    pub problems: Vec<Problem>,
    /// How many more problems were found than are listed.
    pub unlisted: usize,
}

/// One thing that is wrong with a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Problem {
    /// What.
    pub message: String,
    /// Where.
    pub place: Place,
    /// How to mend it.
    pub help: Option<String>,
}

/// A place in a file.
#[derive(Clone, Debug, PartialEq)]
pub enum Place {
    /// A stretch of text.
    Text {
        /// The bytes, counted from 0.
        bytes: Range<usize>,
        /// The line, counted from 1.
        line: usize,
        /// The character in the line, counted from 1.
        column: usize,
        /// The line, or a part of it if it is long.
        snippet: Snippet,
    },
    /// A byte of a binary file, counted from 0.
    Byte(usize),
    /// The file as a whole.
    File,
}

/// A line of source with a stretch of it marked.
#[derive(Clone, Debug, PartialEq)]
pub struct Snippet {
    /// The text, without control characters.
    pub text: String,
    /// How many characters stand before the mark.
    pub before: usize,
    /// How many characters are marked, at least one.
    pub marked: usize,
}

impl ReadError {
    /// The readable form of faults found in a file.
    pub(crate) fn new(path: Option<&Path>, bytes: &[u8], faults: Faults) -> ReadError {
        let lines = Lines::of(bytes);
        let mut listed = faults.listed;
        listed.sort_by_key(|fault| match &fault.at {
            At::Text(range) => range.start,
            At::Byte(offset) => *offset,
            At::File => 0,
        });
        let problems = listed.into_iter().map(|f| lines.problem(f)).collect();
        ReadError { path: path.map(Into::into), problems, unlisted: faults.unlisted }
    }

    /// A file that the system does not hand over.
    pub(crate) fn io(path: &Path, error: &io::Error) -> ReadError {
        ReadError::new(
            Some(path),
            &[],
            Fault::file(format!("cannot be read: {}", system_words(error))).into(),
        )
    }

    /// The first problem on one line, for a file that another file names.
    pub(crate) fn brief(&self, file: &str) -> String {
        let Some(first) = self.problems.first() else { return file.to_string() };
        match &first.place {
            Place::Text { line, column, .. } => format!("{file}:{line}:{column}: {}", first.message),
            Place::Byte(offset) => format!("{file}: byte {offset}: {}", first.message),
            Place::File => format!("{file} {}", first.message),
        }
    }
}

/// The starts of the lines of a text.
struct Lines<'b> {
    bytes: &'b [u8],
    starts: Vec<usize>,
}

impl Lines<'_> {
    fn of(bytes: &[u8]) -> Lines<'_> {
        // The column after a byte order mark is the first.
        let first = mark_length(bytes);
        Lines { bytes, starts: std::iter::once(first).chain(line_starts(bytes)).collect() }
    }

    fn problem(&self, fault: Fault) -> Problem {
        let place = match fault.at {
            At::Text(range) => self.place(range),
            At::Byte(offset) => Place::Byte(offset),
            At::File => Place::File,
        };
        Problem { message: fault.message, place, help: fault.help }
    }

    fn place(&self, range: Range<usize>) -> Place {
        let start = range.start.max(self.starts[0]).min(self.bytes.len());
        let line = self.starts.partition_point(|s| *s <= start);
        let line_start = self.starts[line - 1];
        let line_end = self.starts.get(line).map_or(self.bytes.len(), |next| next - 1);
        let line_end = line_end - usize::from(self.bytes[line_start..line_end].ends_with(b"\r"));
        let marked = start.min(line_end)..range.end.clamp(start.min(line_end), line_end);
        let column = 1 + characters(&self.bytes[line_start..start]);
        Place::Text { bytes: range, line, column, snippet: snippet(self.bytes, line_start..line_end, marked) }
    }
}

/// How many UTF-8 characters begin in some bytes.
fn characters(bytes: &[u8]) -> usize {
    bytes.iter().filter(|b| **b & 0xC0 != 0x80).count()
}

/// Cuts a window out of a line: enough before the mark to recognise the place, and no more than a screen's width.
fn snippet(bytes: &[u8], line: Range<usize>, marked: Range<usize>) -> Snippet {
    const BEFORE: usize = 60;
    const AFTER: usize = 60;
    let short = line.len() <= BEFORE + AFTER;
    let mut from = if short { line.start } else { line.start.max(marked.start.saturating_sub(BEFORE)) };
    let mut to = if short { line.end } else { line.end.min(marked.start + AFTER) };
    while from < marked.start && bytes[from] & 0xC0 == 0x80 {
        from += 1;
    }
    while to > marked.start && to < line.end && bytes[to] & 0xC0 == 0x80 {
        to -= 1;
    }
    let marked = marked.start..marked.end.min(to);
    let shown = |r: Range<usize>| plain(&String::from_utf8_lossy(&bytes[r]));
    let (lead, body, rest) = (shown(from..marked.start), shown(marked.clone()), shown(marked.end..to));
    let lead = if from > line.start { format!("...{lead}") } else { lead };
    let rest = if to < line.end { format!("{rest}...") } else { rest };
    Snippet {
        before: lead.chars().count(),
        marked: body.chars().count().max(1),
        text: format!("{lead}{body}{rest}").trim_end().to_string(),
    }
}

/// Text from a file without what a terminal would obey.
fn plain(text: &str) -> String {
    text.chars()
        .map(|c| {
            if c == '\t' {
                ' '
            } else if c.is_control() {
                '\u{FFFD}'
            } else {
                c
            }
        })
        .collect()
}

struct Report<'e>(&'e ReadError);

impl Display for Report<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        for (i, problem) in self.0.problems.iter().enumerate() {
            if i > 0 {
                f.write_str("\n\n")?;
            }
            write_problem(f, self.0.path.as_deref(), problem)?;
        }
        match self.0.unlisted {
            0 => Ok(()),
            n => write!(f, "\n\nand {n} more"),
        }
    }
}

fn write_problem(f: &mut Formatter<'_>, path: Option<&Path>, problem: &Problem) -> fmt::Result {
    let path = path.map(|p| p.display().to_string());
    let (colon, gap) = if path.is_some() { (":", " ") } else { ("", "") };
    let path = path.as_deref().unwrap_or("");
    let message = plain(&problem.message);
    match &problem.place {
        Place::Text { line, column, snippet, .. } => {
            writeln!(f, "{path}{colon}{line}:{column}: {message}")?;
            writeln!(f, "    {}", snippet.text)?;
            write!(
                f,
                "    {:before$}{:^<marked$}",
                "",
                "",
                before = snippet.before,
                marked = snippet.marked
            )?;
        }
        Place::Byte(offset) => write!(f, "{path}{colon}{gap}byte {offset}: {message}")?,
        Place::File => write!(f, "{path}{colon}{gap}{message}")?,
    }
    match &problem.help {
        Some(help) => write!(f, "\nhelp: {}", plain(help)),
        None => Ok(()),
    }
}

/// What the system says is wrong, without the number of the error and without the name of a temporary file, which
/// the user has never seen.
pub fn system_words(error: &io::Error) -> String {
    let text = error.to_string();
    text.split(" (os error ").next().unwrap_or_default().to_string()
}

/// Something that cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The system refuses.
    #[error("{}: cannot be written: {}", path.display(), system_words(source))]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// No format has this file name ending.
    #[error("{}: no format ends like this; known are {known}", path.display())]
    UnknownFormat {
        /// The file.
        path: PathBuf,
        /// The known endings.
        known: String,
    },
    /// The format cannot hold this.
    #[error("cannot be written: {0}")]
    Unwritable(String),
}

#[cfg(test)]
mod tests {
    use super::*;

    fn show(text: &str, fault: Fault) -> String {
        ReadError::new(Some(Path::new("a.json")), text.as_bytes(), fault.into()).to_string()
    }

    #[test]
    fn the_mark_stands_under_the_word() {
        let shown = show("{\n  \"größe\": bad\n}", Fault::text(15..18, "no such word").help("use a number"));
        assert_eq!(
            shown,
            "a.json:2:12: no such word\n      \"größe\": bad\n               ^^^\nhelp: use a number"
        );
    }

    #[test]
    fn places_beyond_the_end_and_long_lines_are_shown() {
        assert!(show("", Fault::text(0..0, "empty")).starts_with("a.json:1:1: empty\n"));
        assert!(show("ab\n", Fault::text(90..99, "over")).starts_with("a.json:2:1: over"));
        let long = format!("{}X{}", "ä".repeat(500), "ö".repeat(500));
        let shown = show(&long, Fault::text(1000..1001, "here"));
        let rows: Vec<&str> = shown.lines().collect();
        assert!(rows[1].chars().count() < 140);
        let mark = rows[2].chars().position(|c| c == '^').unwrap();
        assert_eq!(rows[1].chars().nth(mark), Some('X'));
    }

    #[test]
    fn what_has_no_file_begins_with_its_place() {
        let fault = Fault::byte(0, "no array").into();
        assert_eq!(ReadError::new(None, &[], fault).to_string(), "byte 0: no array");
    }

    #[test]
    fn the_number_of_an_error_of_the_system_is_left_out() {
        assert_eq!(system_words(&io::Error::from_raw_os_error(2)), "No such file or directory");
        assert_eq!(system_words(&io::Error::other("no more")), "no more");
    }

    #[test]
    fn terminals_get_no_control_characters() {
        assert!(!show("\u{1b}[2J x", Fault::text(0..4, "an \u{1b} escape")).contains('\u{1b}'));
    }
}
