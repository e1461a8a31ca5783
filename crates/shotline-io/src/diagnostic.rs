//! What is wrong with a file. Readers report raw diagnostics: plain data, without a path and without line numbers.
//! [`crate::ReadError`] computes lines and snippets once, when the diagnostics leave the crate.

use std::ops::Range;
use std::path::PathBuf;

use crate::location::{Lines, Location, RawLocation};

/// One thing that is wrong with a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnostic<L = Location> {
    /// What is wrong.
    pub message: String,
    /// Where.
    pub location: L,
    /// How to correct it.
    pub help: Option<String>,
    /// The file, if it is not the one that was read but one that it includes.
    pub file: Option<PathBuf>,
}

/// A diagnostic as a reader reports it.
pub(crate) type RawDiagnostic = Diagnostic<RawLocation>;

impl RawDiagnostic {
    /// About bytes of a text.
    pub(crate) fn text(range: Range<usize>, message: impl Into<String>) -> RawDiagnostic {
        Diagnostic { location: RawLocation::Text(range), message: message.into(), help: None, file: None }
    }

    /// About a byte of a binary file.
    pub(crate) fn byte(offset: usize, message: impl Into<String>) -> RawDiagnostic {
        Diagnostic { location: RawLocation::Byte(offset), message: message.into(), help: None, file: None }
    }

    /// About the file as a whole.
    pub(crate) fn file(message: impl Into<String>) -> RawDiagnostic {
        Diagnostic { location: RawLocation::File, message: message.into(), help: None, file: None }
    }

    pub(crate) fn help(mut self, help: impl Into<String>) -> RawDiagnostic {
        self.help = Some(help.into());
        self
    }

    /// The same diagnostic, with this help if it has none.
    pub(crate) fn or_help(self, help: &str) -> RawDiagnostic {
        if self.help.is_some() { self } else { self.help(help) }
    }

    /// The diagnostic with its location in the lines of the file.
    pub(crate) fn locate(self, lines: &Lines) -> Diagnostic {
        let Diagnostic { message, location, help, file } = self;
        Diagnostic { message, location: lines.locate(location), help, file }
    }
}

/// All diagnostics of a file. A broken file of many megabytes can have millions; the first few are enough.
#[derive(Debug, Default)]
pub(crate) struct Diagnostics {
    pub(crate) listed: Vec<RawDiagnostic>,
    pub(crate) unlisted: usize,
}

impl Diagnostics {
    pub(crate) const MAX_LISTED: usize = 100;

    pub(crate) fn push(&mut self, diagnostic: RawDiagnostic) {
        if self.is_full() {
            self.unlisted += 1;
        } else {
            self.listed.push(diagnostic);
        }
    }

    /// Whether further diagnostics are only counted.
    pub(crate) fn is_full(&self) -> bool {
        self.listed.len() >= Diagnostics::MAX_LISTED
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.listed.is_empty()
    }
}

impl From<RawDiagnostic> for Diagnostics {
    fn from(diagnostic: RawDiagnostic) -> Diagnostics {
        Diagnostics { listed: vec![diagnostic], unlisted: 0 }
    }
}
