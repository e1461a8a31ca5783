//! Usage errors, with useful tips.

use clap::builder::StyledStr;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{CommandFactory, Error};

use crate::commands::CommandLine;

/// Improves the tips of an error. Removes the tip to pass an unknown option as a value after `--`, and lists the commands
/// if a command is unknown.
pub fn with_useful_tips(mut error: Error) -> Error {
    match error.kind() {
        ErrorKind::UnknownArgument => {
            if let Some(ContextValue::StyledStrs(mut tips)) = error.remove(ContextKind::Suggested) {
                tips.retain(|tip| !tip.to_string().starts_with("to pass "));
                if !tips.is_empty() {
                    error.insert(ContextKind::Suggested, ContextValue::StyledStrs(tips));
                }
            }
            let is_number = |text: &String| text.parse::<f64>().is_ok();
            if let Some(ContextValue::String(text)) = error.get(ContextKind::InvalidArg)
                && is_number(text)
            {
                let tip = StyledStr::from("write three numbers with commas between them, as in --from 1,2,3");
                error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip]));
            }
        }
        ErrorKind::InvalidSubcommand => {
            let line = CommandLine::command();
            let names: Vec<&str> = line.get_subcommands().map(clap::Command::get_name).collect();
            let tip = StyledStr::from(format!("the commands are {}", names.join(", ")));
            error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip]));
        }
        _ => {}
    }
    error
}
