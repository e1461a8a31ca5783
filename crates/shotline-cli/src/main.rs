//! The program `shotline`.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(shotline_cli::main(std::env::args_os()))
}
