//! How a command fails: with one readable message, or because the user ended it.

use std::fmt::Display;
use std::path::Path;

use crate::input;

/// Why a command has no result.
#[derive(Debug)]
pub enum Failure {
    /// Something is wrong; the text says what, where and, where that is known, how to mend it.
    Message(String),
    /// Ctrl-C.
    Interrupted,
}

impl Failure {
    /// A failure with a text.
    pub fn new(text: impl Into<String>) -> Failure {
        Failure::Message(text.into())
    }

    /// A failure that concerns an input as a whole.
    pub fn of_input(path: &Path, why: impl Display) -> Failure {
        Failure::Message(format!("{}: {why}", input::name_of(path)))
    }

    /// A failure that concerns a file as a whole.
    pub fn of_file(path: &Path, why: impl Display) -> Failure {
        Failure::Message(format!("{}: {why}", path.display()))
    }

    /// Writes the message to stderr.
    pub fn report(&self) {
        match self {
            Failure::Message(text) => {
                // Names may come from anywhere: what a terminal would obey is replaced.
                let obeyed = |c: char| c.is_control() && c != '\n';
                eprintln!("error: {}", text.trim_end().replace(obeyed, "\u{FFFD}"));
            }
            Failure::Interrupted => eprintln!("interrupted"),
        }
    }

    /// The exit code of a program that fails like this.
    pub fn exit_code(&self) -> u8 {
        match self {
            Failure::Message(_) => 2,
            Failure::Interrupted => 130, // as a shell reports SIGINT
        }
    }
}
