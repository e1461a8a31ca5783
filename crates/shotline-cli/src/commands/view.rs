//! `shotline view`: the viewer.

use std::sync::Arc;
use std::time::Duration;

use clap::Args;

use crate::failure::Failure;
use crate::flags::Model;
use crate::progress::Quiet;
use crate::stream::is_stream;
use crate::view::{Source, Stage, Viewer};
use crate::{input, interrupt, progress};

/// Look at a scene in the browser
///
/// Serves one page on 127.0.0.1, on a free port, and opens it. The page shows the scene from all sides, its parts, planes that cut
/// it open, slices, the crossings of the ray that is clicked, and the steps of an accelerator. It is drawn by this program, so it
/// works without a network, and ends with it: Ctrl-C ends both. When the file of the scene changes, the page shows the change.
///
/// Only this machine reaches the page, by the address with its token, which is printed.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Command {
    #[command(flatten)]
    model: Model,
    /// Print the address only; do not open it in the browser
    #[arg(long)]
    no_open: bool,
    /// The port; 0 for a free one
    #[arg(long, value_name = "N", default_value_t = 0)]
    port: u16,
    #[command(flatten)]
    quiet: Quiet,
}

const EXAMPLES: &str = "\
Examples:
  shotline view engine.json
  shotline view detector.gdml --no-open --port 8080";

impl Command {
    /// Runs the command until it is interrupted.
    pub fn run(&self) -> Result<u8, Failure> {
        interrupt::catch();
        let document = input::load_with_notes(&self.model, self.quiet)?;
        let source = if is_stream(&self.model.path) {
            Source::Memory(self.model.name())
        } else {
            Source::File(Box::new(self.model.clone()))
        };
        let stage = Arc::new(Stage::new(source, document)?);
        let viewer = Viewer::start(stage, self.port).map_err(|error| {
            Failure::new(format!(
                "no viewer at 127.0.0.1:{}: {error}\nhelp: choose another --port, or none",
                self.port
            ))
        })?;
        println!("{}", viewer.url());
        progress::note("Ctrl-C ends the viewer", self.quiet);
        if !self.no_open
            && let Err(error) = open::that_detached(viewer.url())
        {
            progress::note(
                &format!("there is no browser to open ({error}); open the address above"),
                self.quiet,
            );
        }
        loop {
            std::thread::sleep(Duration::from_secs(3600));
        }
    }
}
