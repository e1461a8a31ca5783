//! The progress bar on stderr.

use std::fmt::Write;
use std::io::IsTerminal;
use std::path::Path;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};

use crate::number::{bytes, grouped};
use crate::stream::is_stream;

/// Whether progress and notes are shown.
#[derive(clap::Args, Debug, Clone, Copy)]
pub struct Quiet {
    /// Show no progress bar and no notes; errors are still shown
    #[arg(long, short)]
    pub quiet: bool,
}

/// A bar of so many rays, drawn on stderr if that is a terminal.
pub fn bar(rays: u64, what: &'static str, quiet: Quiet) -> ProgressBar {
    let target = if quiet.quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
    let rate = |state: &ProgressState, out: &mut dyn Write| {
        // What is drawn cannot fail.
        let _ = write!(out, "{} rays/s", grouped(state.per_sec() as u64));
    };
    let style = ProgressStyle::with_template("{msg} {wide_bar} {human_pos}/{human_len} rays {rate} {eta}")
        .unwrap_or_else(|_| ProgressStyle::default_bar())
        .with_key("rate", rate);
    let bar = ProgressBar::with_draw_target(Some(rays), target).with_style(style).with_message(what);
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}

/// A line on stderr, if that is a terminal, for work whose end is not known; its message is replaced as the work goes on.
pub fn spinner(what: &'static str, quiet: Quiet) -> ProgressBar {
    let target = if quiet.quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
    let spinner = ProgressBar::with_draw_target(None, target).with_message(what);
    spinner.enable_steady_tick(Duration::from_millis(200));
    spinner
}

/// Tells that a file has been written, with its size and the seconds since a command began, if stderr is a terminal.
pub fn written(path: &Path, begin: Instant, quiet: Quiet) {
    if quiet.quiet || !std::io::stderr().is_terminal() || is_stream(path) {
        return;
    }
    let size = path.metadata().map_or(0, |data| data.len() as usize);
    eprintln!("wrote {} ({}) in {:.2} s", path.display(), bytes(size), begin.elapsed().as_secs_f64());
}

/// Prints a note, which is not an error, on stderr.
pub fn note(text: &str, quiet: Quiet) {
    if !quiet.quiet {
        // Names can come from any file, and a terminal would execute control characters.
        let is_control = |c: char| c.is_control() && c != '\n';
        eprintln!("note: {}", text.replace(is_control, "\u{FFFD}"));
    }
}
