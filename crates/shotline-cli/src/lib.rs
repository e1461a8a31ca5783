//! The command line of shotline, as a function: [`main`] serves the program and any other door that is
//! handed an argument list.

mod args;
mod close;
mod columns;
mod commands;
mod empty;
mod failure;
mod findings;
mod input;
mod interrupt;
mod number;
mod output;
mod overlap;
mod progress;
mod query;
mod rays;
mod shot;
mod steps;
mod survey;
mod table;
mod usage;

use std::ffi::OsString;

use clap::Parser;

/// Runs a command line, the name of the program first, and answers the exit code: 0 done, 1 not sound
/// (`check`), 2 an error, 3 not examined in full (`check`), 130 interrupted.
pub fn main(argv: impl IntoIterator<Item = OsString>) -> u8 {
    let line = match args::CommandLine::try_parse_from(argv) {
        Ok(line) => line,
        Err(answer) => {
            let answer = usage::with_useful_tips(answer);
            // Help goes to stdout and ends well, a usage error to stderr; a closed pipe is not an error.
            let _ = answer.print();
            return u8::try_from(answer.exit_code()).unwrap_or(2);
        }
    };
    line.command.run().unwrap_or_else(|failure| {
        failure.report();
        failure.exit_code()
    })
}
