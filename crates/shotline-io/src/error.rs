//! Errors as users read them: where, what, the line with a mark under it, and how to correct it.

use std::fmt::{self, Display, Formatter};
use std::io;
use std::path::{Path, PathBuf};

use crate::diagnostic::{Diagnostic, Diagnostics, RawDiagnostic};
use crate::location::{Lines, Location, plain};

/// A file that cannot be read: everything that is wrong with it. Its text is ready for a terminal.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{}", Report(self))]
pub struct ReadError {
    /// The file, if there is one.
    pub path: Option<PathBuf>,
    /// What is wrong, at least one thing, in the order of the file.
    pub diagnostics: Vec<Diagnostic>,
    /// The number of further diagnostics that are not listed.
    pub unlisted: usize,
}

impl ReadError {
    /// Sorts and locates the diagnostics of a file.
    pub(crate) fn new(path: Option<&Path>, bytes: &[u8], diagnostics: Diagnostics) -> ReadError {
        let lines = Lines::of(bytes);
        let Diagnostics { mut listed, unlisted } = diagnostics;
        listed.sort_by_key(|diagnostic| diagnostic.location.start());
        let diagnostics = listed.into_iter().map(|diagnostic| diagnostic.locate(&lines)).collect();
        ReadError { path: path.map(Into::into), diagnostics, unlisted }
    }

    /// Locates the diagnostics of a file and of files that it includes: each is of the text of that number, the first of which
    /// is the file itself.
    pub(crate) fn of_texts(
        texts: &[(&Path, &str)],
        mut found: Vec<(usize, RawDiagnostic)>,
        unlisted: usize,
    ) -> ReadError {
        found.sort_by_key(|(number, diagnostic)| (*number, diagnostic.location.start()));
        let mut diagnostics = Vec::with_capacity(found.len());
        let mut found = found.into_iter().peekable();
        for (number, (path, text)) in texts.iter().enumerate() {
            let lines = Lines::of(text.as_bytes());
            while let Some((_, diagnostic)) = found.next_if(|(of, _)| *of == number) {
                let file = (number > 0).then(|| path.to_path_buf());
                diagnostics.push(Diagnostic { file, ..diagnostic.locate(&lines) });
            }
        }
        ReadError { path: texts.first().map(|(path, _)| path.to_path_buf()), diagnostics, unlisted }
    }

    /// A file that the operating system refuses to read.
    pub(crate) fn io(path: &Path, error: &io::Error) -> ReadError {
        let message = format!("cannot be read: {}", os_error_message(error));
        ReadError::new(Some(path), &[], RawDiagnostic::file(message).into())
    }

    /// The first diagnostic on one line, for a file that another file names.
    pub(crate) fn brief(&self, file: &str) -> String {
        let Some(first) = self.diagnostics.first() else { return file.to_string() };
        match &first.location {
            Location::Text { line, column, .. } => format!("{file}:{line}:{column}: {}", first.message),
            Location::Byte(offset) => format!("{file}: byte {offset}: {}", first.message),
            Location::File => format!("{file} {}", first.message),
        }
    }
}

struct Report<'e>(&'e ReadError);

impl Display for Report<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        for (i, diagnostic) in self.0.diagnostics.iter().enumerate() {
            if i > 0 {
                f.write_str("\n\n")?;
            }
            write_diagnostic(f, diagnostic.file.as_deref().or(self.0.path.as_deref()), diagnostic)?;
        }
        match self.0.unlisted {
            0 => Ok(()),
            n => write!(f, "\n\nand {n} more"),
        }
    }
}

fn write_diagnostic(f: &mut Formatter<'_>, path: Option<&Path>, diagnostic: &Diagnostic) -> fmt::Result {
    let path = path.map(|p| p.display().to_string());
    let (colon, gap) = if path.is_some() { (":", " ") } else { ("", "") };
    let path = path.as_deref().unwrap_or("");
    let message = plain(&diagnostic.message);
    match &diagnostic.location {
        Location::Text { line, column, snippet, .. } => {
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
        Location::Byte(offset) => write!(f, "{path}{colon}{gap}byte {offset}: {message}")?,
        Location::File => write!(f, "{path}{colon}{gap}{message}")?,
    }
    match &diagnostic.help {
        Some(help) => write!(f, "\nhelp: {}", plain(help)),
        None => Ok(()),
    }
}

/// The message of an operating system error, without its number and without the name of a temporary file, which the
/// user has never seen.
pub fn os_error_message(error: &io::Error) -> String {
    let text = error.to_string();
    text.split(" (os error ").next().unwrap_or_default().to_string()
}

/// Why a file cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The operating system refuses.
    #[error("{}: cannot be written: {}", path.display(), os_error_message(source))]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// No format has this file name extension.
    #[error("{}: no format ends like this; known are {known}", path.display())]
    UnknownFormat {
        /// The file.
        path: PathBuf,
        /// The known extensions.
        known: String,
    },
    /// The format cannot hold this.
    #[error("cannot be written: {0}")]
    Unwritable(String),
}

#[cfg(test)]
mod tests {
    use super::*;

    fn show(text: &str, diagnostic: RawDiagnostic) -> String {
        ReadError::new(Some(Path::new("a.json")), text.as_bytes(), diagnostic.into()).to_string()
    }

    #[test]
    fn the_mark_stands_under_the_word() {
        let shown =
            show("{\n  \"größe\": bad\n}", RawDiagnostic::text(15..18, "no such word").help("use a number"));
        assert_eq!(
            shown,
            "a.json:2:12: no such word\n      \"größe\": bad\n               ^^^\nhelp: use a number"
        );
    }

    #[test]
    fn locations_beyond_the_end_and_long_lines_are_shown() {
        assert!(show("", RawDiagnostic::text(0..0, "empty")).starts_with("a.json:1:1: empty\n"));
        assert!(show("ab\n", RawDiagnostic::text(90..99, "over")).starts_with("a.json:2:1: over"));
        let long = format!("{}X{}", "ä".repeat(500), "ö".repeat(500));
        let shown = show(&long, RawDiagnostic::text(1000..1001, "here"));
        let rows: Vec<&str> = shown.lines().collect();
        assert!(rows[1].chars().count() < 140);
        let mark = rows[2].chars().position(|c| c == '^').unwrap();
        assert_eq!(rows[1].chars().nth(mark), Some('X'));
    }

    #[test]
    fn a_message_without_a_file_begins_with_its_location() {
        let diagnostic = RawDiagnostic::byte(0, "no array").into();
        assert_eq!(ReadError::new(None, &[], diagnostic).to_string(), "byte 0: no array");
    }

    #[test]
    fn operating_system_errors_are_shown_without_their_number() {
        assert_eq!(os_error_message(&io::Error::from_raw_os_error(2)), "No such file or directory");
        assert_eq!(os_error_message(&io::Error::other("no more")), "no more");
    }

    #[test]
    fn terminals_get_no_control_characters() {
        assert!(!show("\u{1b}[2J x", RawDiagnostic::text(0..4, "an \u{1b} escape")).contains('\u{1b}'));
    }
}
