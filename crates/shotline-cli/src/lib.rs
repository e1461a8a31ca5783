//! The command line of shotline as a function: the program and the Python package call [`main`] with an argument list. The viewer
//! of `shotline view` shows scenes in memory too: [`show`].

mod columns;
mod commands;
mod empty_objects;
mod failure;
mod fields;
mod findings;
mod flags;
mod input;
mod interrupt;
mod nesting;
mod number;
mod opacity;
mod output;
mod overlap;
mod picture_file;
mod progress;
mod query;
mod rays;
mod shoot_report;
mod shown;
mod stream;
mod table;
mod trace_report;
mod usage;
mod view;
mod viewpoint;

use std::ffi::OsString;
use std::io;
use std::sync::Arc;

use clap::Parser;
use shotline::scene::Scene;
use shotline_io::Document;

pub use view::Viewer;
use view::{Source, Stage};

/// Runs a command line, the name of the program first, and returns the exit code: 0 done, 1 not sound
/// (`check`), 2 an error, 3 not examined in full (`check`), 130 interrupted.
pub fn main(argv: impl IntoIterator<Item = OsString>) -> u8 {
    let line = match commands::CommandLine::try_parse_from(argv) {
        Ok(line) => line,
        Err(error) => {
            let error = usage::with_useful_tips(error);
            // `--help` and `--version` are printed to stdout with exit code 0, usage errors to stderr. A closed pipe is not
            // an error.
            let _ = error.print();
            return u8::try_from(error.exit_code()).unwrap_or(2);
        }
    };
    line.command.run().unwrap_or_else(|failure| {
        failure.report();
        failure.exit_code()
    })
}

/// Why a scene is not shown.
#[derive(Debug)]
pub enum ShowError {
    /// The scene is not valid; the text says why.
    Scene(String),
    /// There is no server at the port.
    Listen(io::Error),
}

/// Shows a scene on a page of 127.0.0.1, at a port or, with 0, a free one, until the viewer is dropped.
///
/// # Errors
/// [`ShowError`].
pub fn show(scene: Scene, port: u16) -> Result<Viewer, ShowError> {
    let document = Document { scene, notes: Vec::new(), source: shotline_io::Source::default() };
    let stage = Stage::new(Source::Memory("scene".into()), document);
    let stage = stage.map_err(|failure| ShowError::Scene(failure.text()))?;
    Viewer::start(Arc::new(stage), port).map_err(ShowError::Listen)
}
