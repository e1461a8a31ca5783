//! What a reader finds wrong while it reads: plain data, without a path and without line numbers. Lines and
//! snippets are worked out once, when the faults leave the crate as a [`crate::ReadError`].

use std::ops::Range;

/// Where a fault lies.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum At {
    /// Bytes of a text.
    Text(Range<usize>),
    /// A byte of a binary file.
    Byte(usize),
    /// The file as a whole.
    File,
}

/// One thing that is wrong.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Fault {
    pub(crate) at: At,
    pub(crate) message: String,
    pub(crate) help: Option<String>,
}

impl Fault {
    pub(crate) fn text(range: Range<usize>, message: impl Into<String>) -> Fault {
        Fault { at: At::Text(range), message: message.into(), help: None }
    }

    pub(crate) fn byte(offset: usize, message: impl Into<String>) -> Fault {
        Fault { at: At::Byte(offset), message: message.into(), help: None }
    }

    pub(crate) fn file(message: impl Into<String>) -> Fault {
        Fault { at: At::File, message: message.into(), help: None }
    }

    pub(crate) fn help(mut self, help: impl Into<String>) -> Fault {
        self.help = Some(help.into());
        self
    }

    /// The same, with some help in any case.
    pub(crate) fn or_help(self, help: &str) -> Fault {
        if self.help.is_some() { self } else { self.help(help) }
    }
}

/// All faults of a file. A broken file of many megabytes can have millions; the first few tell enough.
#[derive(Debug, Default)]
pub(crate) struct Faults {
    pub(crate) listed: Vec<Fault>,
    pub(crate) unlisted: usize,
}

impl Faults {
    const MOST: usize = 100;

    pub(crate) fn push(&mut self, fault: Fault) {
        if self.is_full() {
            self.unlisted += 1;
        } else {
            self.listed.push(fault);
        }
    }

    /// Whether further faults are only counted.
    pub(crate) fn is_full(&self) -> bool {
        self.listed.len() >= Faults::MOST
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.listed.is_empty()
    }
}

impl From<Fault> for Faults {
    fn from(fault: Fault) -> Faults {
        Faults { listed: vec![fault], unlisted: 0 }
    }
}
