//! How a command fails: with one readable message, or because the user interrupted it.

use std::fmt::Display;
use std::path::Path;

use clap::builder::styling::{AnsiColor, Style};

use crate::stream;

/// The colours of the words before a message, as clap has them.
const ERROR: Style = AnsiColor::Red.on_default().bold();
const HELP: Style = AnsiColor::Green.on_default();

/// A message with its first word, and with those of its lines of help, in colours, which only a terminal shows.
fn colored(text: &str) -> String {
    let line = |line: &str| match line.trim_start().strip_prefix("help:") {
        Some(help) => {
            let indent = &line[..line.len() - line.trim_start().len()];
            format!("{indent}{HELP}help:{HELP:#}{help}")
        }
        None => line.to_owned(),
    };
    let lines: Vec<String> = text.lines().map(line).collect();
    format!("{ERROR}error:{ERROR:#} {}", lines.join("\n"))
}

/// Why a command has no result.
#[derive(Debug)]
pub enum Failure {
    /// An error; the text says what, where and, if that is known, how to correct it.
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
        Failure::Message(format!("{}: {why}", stream::name_of(path)))
    }

    /// A failure that concerns a file as a whole.
    pub fn of_file(path: &Path, why: impl Display) -> Failure {
        Failure::Message(format!("{}: {why}", path.display()))
    }

    /// The message.
    pub fn text(&self) -> String {
        match self {
            Failure::Message(text) => text.trim_end().to_owned(),
            Failure::Interrupted => "interrupted".into(),
        }
    }

    /// Writes the message to stderr.
    pub fn report(&self) {
        match self {
            Failure::Message(text) => {
                // Names can come from any file: control characters, which a terminal would execute, are replaced.
                let is_control = |c: char| c.is_control() && c != '\n';
                anstream::eprintln!("{}", colored(&text.trim_end().replace(is_control, "\u{FFFD}")));
            }
            Failure::Interrupted => eprintln!("interrupted"),
        }
    }

    /// The exit code of the program.
    pub fn exit_code(&self) -> u8 {
        match self {
            Failure::Message(_) => 2,
            Failure::Interrupted => 130, // as a shell reports SIGINT
        }
    }
}
