//! The flags that several commands share: each is declared here once.

use std::path::PathBuf;
use std::str::FromStr;

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use shotline::accel::DEFAULT;
use shotline::compile::Options;
use shotline::query::Kinds;
use shotline::ray::Span;
use shotline::scene::Scene;
use shotline::solid::mesh::Weld;
use shotline_io::{PathPolicy, ReadOptions, mesh_format_names};

use crate::failure::Failure;
use crate::stream;

/// The model that a command reads.
#[derive(Args, Clone, Debug)]
pub struct Model {
    #[arg(value_name = "SCENE_OR_MESH", help = format!(
        "A scene file (JSON), a detector (GDML) or a mesh ({}), which is a scene of one object; - for standard input",
        mesh_format_names()
    ))]
    pub path: PathBuf,
    /// Let the scene name mesh files outside of its own folder
    #[arg(long)]
    pub allow_outside: bool,
    /// Weld vertices of meshes that are at most this distance apart, in the units of the file; with `auto`, vertices
    /// within rounding of each other and far from all others. Merged vertices are reported
    #[arg(long, value_name = "DIST|auto", allow_negative_numbers = true)]
    pub weld: Option<Weld>,
    /// Read a GDML file without the parts that are not supported. They are reported
    #[arg(long)]
    pub partial: bool,
    /// Read this setup of a GDML file, which names the world volume, or this scene of a glTF file. Default: the setup named
    /// Default, the default scene, or else the first
    #[arg(long, value_name = "NAME")]
    pub setup: Option<String>,
}

impl Model {
    /// Its name in messages.
    pub fn name(&self) -> String {
        stream::name_of(&self.path)
    }

    /// How to read it.
    pub fn options(&self) -> ReadOptions {
        ReadOptions {
            paths: if self.allow_outside { PathPolicy::Anywhere } else { PathPolicy::SceneFolder },
            weld: self.weld,
            partial: self.partial,
            setup: self.setup.clone(),
        }
    }
}

/// How to build the world.
#[derive(Args, Debug)]
pub struct Build {
    /// The accelerator used everywhere; no result depends on it. Default: that of the scene, or else bvh
    #[arg(long, value_name = "NAME", value_parser = accel_names())]
    pub accel: Option<&'static str>,
}

impl Build {
    /// The accelerator of the scene as a whole: of everything that does not name its own.
    pub fn scene_accel(&self, scene: &Scene) -> &'static str {
        self.accel.or(scene.accel).unwrap_or(DEFAULT)
    }

    /// The options of the compiler.
    pub fn options(&self) -> Options {
        Options { accel: self.accel }
    }
}

fn accel_names() -> impl TypedValueParser<Value = &'static str> {
    let names = shotline::accel::NAMES;
    PossibleValuesParser::new(names.iter().copied()).try_map(|given| {
        names.iter().find(|name| **name == given).copied().ok_or("there is no such accelerator")
    })
}

/// The number of threads.
#[derive(Args, Debug, Clone, Copy)]
pub struct Threads {
    /// Number of threads; 0 for one per core. No result depends on it
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = parse_whole_number::<usize>, allow_negative_numbers = true)]
    pub threads: usize,
}

impl Threads {
    /// The number of threads on this machine.
    pub fn count(self) -> usize {
        match self.threads {
            0 => std::thread::available_parallelism().map_or(1, usize::from),
            n => n,
        }
    }
}

/// The interval of each ray in which crossings are found.
#[derive(Args, Debug)]
pub struct SpanOfT {
    /// Where rays begin, in lengths of their direction
    #[arg(long, value_name = "X", default_value_t = 0.0, allow_hyphen_values = true)]
    pub t_min: f64,
    /// Where rays end, in lengths of their direction
    #[arg(long, value_name = "X", default_value_t = f64::INFINITY, allow_hyphen_values = true)]
    pub t_max: f64,
}

/// Which kinds of crossings are found.
#[derive(Args, Debug, Clone, Copy)]
pub struct SurfacesOnly {
    /// Find surfaces only: leave out the crossings of kind `start` and `end`, with which a list begins and ends where
    /// the ray begins or ends inside. `closest` and `any` then find real surfaces only. Not for `segments` and `thickness`
    #[arg(long)]
    pub surfaces_only: bool,
}

impl SurfacesOnly {
    /// The kinds of crossings.
    pub fn kinds(self) -> Kinds {
        if self.surfaces_only { Kinds::Surfaces } else { Kinds::All }
    }
}

impl SpanOfT {
    /// The span, if it is valid.
    pub fn span(&self) -> Result<Span, Failure> {
        Span::new(self.t_min, self.t_max)
            .map_err(|e| Failure::new(format!("{e}\nhelp: --t-min must be finite and --t-max not below it")))
    }
}

/// Parses a whole number, 0 or more.
pub fn parse_whole_number<T: FromStr>(text: &str) -> Result<T, String> {
    text.parse().map_err(|_| {
        let is_whole = !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
        let why = if is_whole { "the number is too large" } else { "expected a whole number, 0 or more" };
        why.to_string()
    })
}

/// Parses a size in pixels, as in 800x600.
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
    fn whole_numbers_are_parsed() {
        assert_eq!(parse_whole_number("7"), Ok(7_u64));
        for (text, why) in
            [("-1", "0 or more"), ("1.5", "whole number"), ("99999999999999999999", "too large")]
        {
            assert!(parse_whole_number::<u64>(text).unwrap_err().contains(why), "{text}");
        }
    }

    #[test]
    fn sizes_are_parsed() {
        assert_eq!(parse_size("64x48"), Ok((64, 48)));
        assert!(parse_size("64").is_err() && parse_size("-1x4").is_err());
    }
}
