//! The command line as a whole, and the flags that several commands share: each is declared here once.

use std::path::PathBuf;
use std::str::FromStr;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, Parser, Subcommand};
use shotline::accel::DEFAULT;
use shotline::compile::Options;
use shotline::query::Kinds;
use shotline::ray::Span;
use shotline::scene::Scene;
use shotline::solid::mesh::Weld;
use shotline_io::{PathPolicy, ReadOptions};

use crate::commands::{bench, cast, check, compare, convert, info, measure, render, shoot};
use crate::failure::Failure;
use crate::input;

/// Every crossing of rays with exact solids
///
/// shotline finds where rays cross solids: quadrics, tori, closed meshes, their unions, intersections and
/// differences, placed by a scene graph. It answers for every crossing of a ray, not only the first.
#[derive(Parser, Debug)]
#[command(name = "shotline", version, max_term_width = 100, after_long_help = EXIT_CODES)]
pub struct CommandLine {
    #[command(subcommand)]
    pub command: Command,
}

const EXIT_CODES: &str = "\
Exit codes: 0 done; 1 `check` found the model not sound; 2 an error, reported on stderr; \
3 `check` found no fault but could not examine everything; 130 interrupted.
An output file appears whole or not at all.";

#[derive(Subcommand, Debug)]
pub enum Command {
    Render(render::Command),
    Cast(cast::Command),
    Shoot(shoot::Command),
    Check(check::Command),
    Info(info::Command),
    Measure(measure::Command),
    Compare(compare::Command),
    Bench(bench::Command),
    Convert(convert::Command),
}

impl Command {
    /// Runs the command and answers the exit code.
    pub fn run(&self) -> Result<u8, Failure> {
        match self {
            Command::Render(c) => c.run(),
            Command::Cast(c) => c.run(),
            Command::Shoot(c) => c.run(),
            Command::Check(c) => c.run(),
            Command::Info(c) => c.run(),
            Command::Measure(c) => c.run(),
            Command::Compare(c) => c.run(),
            Command::Bench(c) => c.run(),
            Command::Convert(c) => c.run(),
        }
    }
}

/// What is looked at.
#[derive(Args, Debug)]
pub struct Model {
    /// A scene file (JSON) or a mesh (PLY, STL, OBJ), which stands for a scene of one object; - for standard input
    #[arg(value_name = "SCENE_OR_MESH")]
    pub path: PathBuf,
    /// Let the scene name mesh files outside of its own folder
    #[arg(long)]
    pub allow_outside: bool,
    /// Weld vertices of meshes: those up to this distance apart, in the lengths of the file, or with `auto` those
    /// within rounding of each other and far from all others. What is merged is reported
    #[arg(long, value_name = "DIST|auto", allow_negative_numbers = true)]
    pub weld: Option<Weld>,
}

impl Model {
    /// What it is called in messages.
    pub fn name(&self) -> String {
        input::name_of(&self.path)
    }

    /// How it is read.
    pub fn options(&self) -> ReadOptions {
        ReadOptions {
            paths: if self.allow_outside { PathPolicy::Anywhere } else { PathPolicy::SceneFolder },
            weld: self.weld,
        }
    }
}

/// How the world is built.
#[derive(Args, Debug)]
pub struct Build {
    /// The accelerator used everywhere; no answer depends on it. Without this what the scene chooses, else bvh
    #[arg(long, value_name = "NAME", value_parser = accel_names())]
    pub accel: Option<&'static str>,
}

impl Build {
    /// The accelerator of the scene as a whole.
    pub fn general(&self, scene: &Scene) -> &'static str {
        self.accel.or(scene.accel).unwrap_or(DEFAULT)
    }

    /// The choices as the compiler takes them.
    pub fn options(&self) -> Options {
        Options { accel: self.accel }
    }
}

fn accel_names() -> impl TypedValueParser<Value = &'static str> {
    let names = shotline::accel::NAMES;
    PossibleValuesParser::new(names.iter().copied())
        .try_map(|given| names.iter().find(|name| **name == given).copied().ok_or("no such accelerator"))
}

/// How work is shared out.
#[derive(Args, Debug, Clone, Copy)]
pub struct Threads {
    /// Threads; 0 for one a core. No answer depends on it
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = parse_whole::<usize>, allow_negative_numbers = true)]
    pub threads: usize,
}

impl Threads {
    /// How many that is on this machine.
    pub fn count(self) -> usize {
        match self.threads {
            0 => std::thread::available_parallelism().map_or(1, usize::from),
            n => n,
        }
    }
}

/// The part of each ray that is asked about.
#[derive(Args, Debug)]
pub struct SpanOfT {
    /// Where rays begin, in lengths of their direction
    #[arg(long, value_name = "X", default_value_t = 0.0, allow_hyphen_values = true)]
    pub t_min: f64,
    /// Where rays end, in lengths of their direction
    #[arg(long, value_name = "X", default_value_t = f64::INFINITY, allow_hyphen_values = true)]
    pub t_max: f64,
}

/// Which kinds of crossings are looked for.
#[derive(Args, Debug, Clone, Copy)]
pub struct SurfacesOnly {
    /// Look for surfaces only: leave out the crossings of kind `start` and `end`, with which a list begins and ends where
    /// the ray begins or ends inside. `closest` and `any` look for the first real surface. Not for `segments` and `thickness`
    #[arg(long)]
    pub surfaces_only: bool,
}

impl SurfacesOnly {
    /// The kinds.
    pub fn kinds(self) -> Kinds {
        if self.surfaces_only { Kinds::Surfaces } else { Kinds::All }
    }
}

impl SpanOfT {
    /// The span, if it is one.
    pub fn span(&self) -> Result<Span, Failure> {
        Span::new(self.t_min, self.t_max)
            .map_err(|e| Failure::new(format!("{e}\nhelp: --t-min must be finite and --t-max not below it")))
    }
}

/// A whole number, 0 or more.
pub fn parse_whole<T: FromStr>(text: &str) -> Result<T, String> {
    text.parse().map_err(|_| {
        let is_whole = !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
        let why = if is_whole { "the number is too large" } else { "expected a whole number, 0 or more" };
        why.to_string()
    })
}

/// Pixels across and down, as in 800x600.
pub fn parse_size(text: &str) -> Result<(u32, u32), String> {
    let parse = || {
        let (width, height) = text.split_once(['x', 'X'])?;
        Some((width.parse().ok()?, height.parse().ok()?))
    };
    parse().ok_or_else(|| "expected the width and the height in pixels, as in 800x600".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_numbers_are_read() {
        assert_eq!(parse_whole("7"), Ok(7_u64));
        for (text, why) in
            [("-1", "0 or more"), ("1.5", "whole number"), ("99999999999999999999", "too large")]
        {
            assert!(parse_whole::<u64>(text).unwrap_err().contains(why), "{text}");
        }
    }

    #[test]
    fn sizes_are_read() {
        assert_eq!(parse_size("64x48"), Ok((64, 48)));
        assert!(parse_size("64").is_err() && parse_size("-1x4").is_err());
    }
}
