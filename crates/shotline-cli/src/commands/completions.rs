//! `shotline completions`: a script by which a shell completes command lines.

use clap::{Args, CommandFactory};
use clap_complete::{Shell, generate};

use super::CommandLine;
use crate::failure::Failure;
use crate::output;

/// Print a script that completes command lines of shotline in a shell
///
/// It completes commands, flags, the names that a flag accepts, and files.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Command {
    /// The shell
    shell: Shell,
}

const EXAMPLES: &str = "\
Examples:
  shotline completions bash > ~/.local/share/bash-completion/completions/shotline
  shotline completions zsh > ~/.zfunc/_shotline    (~/.zfunc in fpath, before compinit)
  shotline completions fish > ~/.config/fish/completions/shotline.fish";

impl Command {
    /// Runs the command and returns the exit code.
    ///
    /// # Errors
    /// If the script cannot be written.
    pub fn run(&self) -> Result<u8, Failure> {
        let mut script = Vec::new();
        generate(self.shell, &mut CommandLine::command(), "shotline", &mut script);
        output::print(&String::from_utf8_lossy(&script))?;
        Ok(0)
    }
}
