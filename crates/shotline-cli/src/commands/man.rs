//! `shotline man`: the manual pages.

use std::path::PathBuf;

use clap::{Args, CommandFactory};
use clap_mangen::Man;

use super::CommandLine;
use crate::failure::Failure;
use crate::output;

/// Print the manual page of a command, or write the pages of all commands
///
/// The pages have the text of --help, in the format of man.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Command {
    /// The command; default: shotline itself
    #[arg(value_name = "COMMAND", conflicts_with = "output")]
    command: Option<String>,
    /// Write the pages of all commands into this folder: shotline.1, shotline-render.1 and so on
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
}

const EXAMPLES: &str = "\
Examples:
  shotline man render | man -l -
  shotline man -o ~/.local/share/man/man1";

impl Command {
    /// Runs the command and returns the exit code.
    ///
    /// # Errors
    /// If there is no such command, or a page cannot be written.
    pub fn run(&self) -> Result<u8, Failure> {
        let mut root = CommandLine::command();
        root.build();
        let pages =
            || std::iter::once(&root).chain(root.get_subcommands().filter(|c| c.get_name() != "help"));
        if let Some(folder) = &self.output {
            for command in pages() {
                let path = folder.join(Man::new(command.clone()).get_filename());
                output::write(&path, page(command)?.as_bytes())?;
            }
            return Ok(0);
        }
        let name = self.command.as_deref().unwrap_or("shotline");
        let Some(command) = pages().find(|command| command.get_name() == name) else {
            let names: Vec<_> = root.get_subcommands().map(clap::Command::get_name).collect();
            let help = format!("the commands are {}", names.join(", "));
            return Err(Failure::new(format!("there is no command '{name}'\nhelp: {help}")));
        };
        output::print(&page(command)?)?;
        Ok(0)
    }
}

/// The text of a page.
fn page(command: &clap::Command) -> Result<String, Failure> {
    let mut text = Vec::new();
    let made = Man::new(command.clone()).render(&mut text);
    made.map_err(|error| Failure::new(format!("the page cannot be made: {error}")))?;
    Ok(String::from_utf8_lossy(&text).into_owned())
}
