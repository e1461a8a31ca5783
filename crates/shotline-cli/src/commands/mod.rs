//! The command line. Each command is a file that declares its flags and returns the exit code.

mod bench;
mod cast;
mod check;
mod compare;
mod completions;
mod convert;
mod info;
mod man;
mod measure;
mod render;
mod shoot;
mod slice;
mod view;

use clap::{Parser, Subcommand};

use crate::failure::Failure;

/// Every crossing of rays with exact solids
///
/// shotline finds where rays cross solids: quadrics, tori, closed meshes, their unions, intersections and
/// differences, placed by a scene graph. It finds every crossing of a ray, not only the first.
#[derive(Parser, Debug)]
#[command(name = "shotline", version, max_term_width = 100, after_long_help = EXIT_CODES)]
pub struct CommandLine {
    #[command(subcommand)]
    pub command: Command,
}

const EXIT_CODES: &str = "\
Exit codes: 0 done; 1 `check` found the model not sound; 2 an error, reported on stderr; \
3 `check` found no fault but could not examine everything; 130 interrupted.
An output file is written completely or not at all.";

#[derive(Subcommand, Debug)]
pub enum Command {
    Render(Box<render::Command>),
    Slice(slice::Command),
    View(view::Command),
    Cast(cast::Command),
    Shoot(shoot::Command),
    Check(check::Command),
    Info(info::Command),
    Measure(measure::Command),
    Compare(compare::Command),
    Bench(bench::Command),
    Convert(convert::Command),
    Completions(completions::Command),
    Man(man::Command),
}

impl Command {
    /// Runs the command and returns the exit code.
    pub fn run(&self) -> Result<u8, Failure> {
        match self {
            Command::Render(c) => c.run(),
            Command::Slice(c) => c.run(),
            Command::View(c) => c.run(),
            Command::Cast(c) => c.run(),
            Command::Shoot(c) => c.run(),
            Command::Check(c) => c.run(),
            Command::Info(c) => c.run(),
            Command::Measure(c) => c.run(),
            Command::Compare(c) => c.run(),
            Command::Bench(c) => c.run(),
            Command::Convert(c) => c.run(),
            Command::Completions(c) => c.run(),
            Command::Man(c) => c.run(),
        }
    }
}
