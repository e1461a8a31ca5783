//! `shotline bench`: rays per second.

use std::path::PathBuf;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use clap::Args;
use serde_json::json;
use shotline::compile::World;
use shotline::pool;
use shotline::query::batch::{self, BatchError, By, ClosestRows, CrossingRows, Run, SegmentRows};
use shotline::query::{Overlaps, QueryError, Scope};
use shotline::ray::{Ray, Span};

use crate::failure::Failure;
use crate::fields::FieldsFlag;
use crate::flags::{Build, Model, SurfacesOnly, Threads};
use crate::number::{bytes, counted, grouped};
use crate::progress::{self, Quiet};
use crate::query::{Query, help};
use crate::{input, interrupt, output};

/// Measure the number of rays per second
///
/// Casts the same rays several times and reports the median, the best and the spread: the difference of the
/// slowest and the fastest, relative to the median. Smaller differences are not significant. A first cast, which is
/// not counted, warms the caches. Results are collected in memory and not written; each cast of `closest`, `crossings` and
/// `segments` uses the memory of the last. `segments` and `thickness` resolve overlaps by priority.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Command {
    #[command(flatten)]
    model: Model,
    /// The rays, as .npy; default: those of a picture of 320 by 240
    #[arg(long, value_name = "FILE.npy")]
    rays: Option<PathBuf>,
    /// The query for each ray
    #[arg(long, value_enum, default_value_t = Query::Closest)]
    query: Query,
    #[command(flatten)]
    surfaces_only: SurfacesOnly,
    #[command(flatten)]
    fields: FieldsFlag,
    /// How many times the rays are cast
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1_000_000), allow_negative_numbers = true)]
    repeats: u32,
    /// Print one JSON document instead
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    build: Build,
    #[command(flatten)]
    threads: Threads,
    #[command(flatten)]
    quiet: Quiet,
}

const EXAMPLES: &str = "\
Examples:
  shotline bench bunny.ply --accel grid --threads 1
  shotline bench engine.json --rays rays.npy --query crossings --repeats 20";

/// The results of a cast, whose memory the next one uses.
#[derive(Default)]
struct Rows {
    closest: ClosestRows,
    crossings: CrossingRows,
    segments: SegmentRows,
}

/// The measured times, in seconds.
struct Report {
    accel: &'static str,
    rays: usize,
    load: f64,
    build: f64,
    /// The time of each repeat, ascending.
    casts: Vec<f64>,
    memory: usize,
}

impl Command {
    /// Runs the command.
    pub fn run(&self) -> Result<u8, Failure> {
        interrupt::catch();
        let scope = self.query.scope(Span::FORWARD, self.surfaces_only)?;
        let begin = Instant::now();
        let document = input::load_with_notes(&self.model, self.quiet)?;
        let load = begin.elapsed().as_secs_f64();
        // The threads are started before the time is taken, as those of the casts are.
        let (world, build) = pool::on_threads(self.threads.threads, |_| {
            let begin = Instant::now();
            let world = input::compile(&document, &self.build)?;
            Ok::<_, Failure>((world, begin.elapsed().as_secs_f64()))
        })?;
        let rays = match &self.rays {
            Some(path) => input::valid_rays(path)?,
            None => input::rays_of_picture(&self.model, &document, &world)?,
        };
        if rays.is_empty() {
            return Err(Failure::new("there is no ray to cast\nhelp: name a file with at least one ray"));
        }
        let mut casts = interrupt::cancellable(|cancel| self.casts(&world, &rays, scope, cancel))?;
        casts.sort_by(f64::total_cmp);
        let memory = world.stats().memory_bytes;
        let accel = self.build.scene_accel(&document.scene);
        let report = Report { accel, rays: rays.len(), load, build, casts, memory };
        output::print(&if self.json { self.json(&report) } else { self.text(&report) })?;
        Ok(0)
    }

    /// The time of each repeat in seconds.
    fn casts(
        &self,
        world: &World,
        rays: &[Ray],
        scope: Scope,
        cancel: &AtomicBool,
    ) -> Result<Vec<f64>, Failure> {
        let bar = progress::bar(rays.len() as u64 * u64::from(1 + self.repeats), "casting", self.quiet);
        let progress = |rays| bar.inc(rays);
        let run = Run {
            threads: self.threads.threads,
            progress: Some(&progress),
            cancel: Some(cancel),
            fields: self.fields.of(self.query)?,
            ..Run::default()
        };
        let mut rows = Rows::default();
        let casts = (0..=self.repeats).map(|_| {
            let begin = Instant::now();
            self.cast(world, rays, scope, run, &mut rows).map(|()| begin.elapsed().as_secs_f64())
        });
        let casts: Result<Vec<f64>, BatchError> = casts.collect();
        bar.finish_and_clear();
        let mut casts = casts.map_err(|error| self.failure(error))?;
        casts.remove(0); // the warm-up
        Ok(casts)
    }

    fn cast(
        &self,
        world: &World,
        rays: &[Ray],
        scope: Scope,
        run: Run,
        rows: &mut Rows,
    ) -> Result<(), BatchError> {
        match self.query {
            Query::Closest => batch::closest_into(world, rays, scope, run, &mut rows.closest),
            Query::Any => batch::any(world, rays, scope, run).map(drop),
            Query::Count => batch::count(world, rays, scope, run).map(drop),
            Query::Crossings => batch::crossings_into(world, rays, scope, run, &mut rows.crossings),
            Query::Segments => {
                let overlaps = Overlaps::Priority;
                batch::segments_into(world, rays, scope.span, overlaps, run, &mut rows.segments)
            }
            Query::Thickness => {
                batch::thickness(world, rays, scope.span, By::Material, Overlaps::Priority, run).map(drop)
            }
        }
    }

    fn failure(&self, error: BatchError) -> Failure {
        let help = match &error {
            BatchError::Cancelled => return Failure::Interrupted,
            BatchError::TooMany { .. } | BatchError::OutOfMemory => {
                "bench fewer rays, or use --query closest or count"
            }
            BatchError::Query { error: QueryError::TooMany { .. } | QueryError::TooLong { .. }, .. } => {
                "nest fewer parts in each other, or use --query closest or count"
            }
            BatchError::World(error) | BatchError::Query { error, .. } => help(error),
            BatchError::Ray { .. } | BatchError::Point { .. } => "correct the rays",
        };
        Failure::of_input(&self.model.path, format!("{error}\nhelp: {help}"))
    }

    fn text(&self, report: &Report) -> String {
        let line = |seconds: f64| {
            let ns = 1e9 / report.rate(seconds);
            format!("{:>12} rays/s  {:>8} ns a ray", grouped(report.rate(seconds) as u64), grouped(ns as u64))
        };
        let threads = self.threads.count() as u64;
        format!(
            "{} of {} of {}, under {} on {}\n\
             load    {:.3} s\n\
             build   {:.3} s, {}\n\
             median  {}\n\
             best    {}\n\
             spread  {:.1} % of the median, over {}\n",
            self.query.name(),
            counted(report.rays as u64, "ray", "rays"),
            self.model.name(),
            report.accel,
            counted(threads, "thread", "threads"),
            report.load,
            report.build,
            bytes(report.memory),
            line(report.median()),
            line(report.casts[0]),
            100.0 * report.spread(),
            counted(report.casts.len() as u64, "repeat", "repeats"),
        )
    }

    fn json(&self, report: &Report) -> String {
        let document = json!({
            "rays": report.rays,
            "query": self.query.name(),
            "accel": report.accel,
            "threads": self.threads.count(),
            "repeats": report.casts.len(),
            "load_s": report.load,
            "build_s": report.build,
            "memory_bytes": report.memory,
            "cast_s": report.casts,
            "rays_per_s": report.rate(report.median()),
            "best_rays_per_s": report.rate(report.casts[0]),
            "spread": report.spread(),
        });
        format!("{document:#}\n")
    }
}

impl Report {
    fn rate(&self, seconds: f64) -> f64 {
        self.rays as f64 / seconds.max(1e-9)
    }

    fn median(&self) -> f64 {
        let n = self.casts.len();
        0.5 * (self.casts[(n - 1) / 2] + self.casts[n / 2])
    }

    /// The difference of the slowest and the fastest, relative to the median.
    fn spread(&self) -> f64 {
        (self.casts[self.casts.len() - 1] - self.casts[0]) / self.median().max(1e-9)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_and_spreads() {
        let report = |casts: &[f64]| Report {
            accel: "bvh",
            rays: 10,
            load: 0.0,
            build: 0.0,
            casts: casts.into(),
            memory: 0,
        };
        let odd = report(&[1.0, 2.0, 4.0]);
        assert_eq!((odd.median(), odd.spread(), odd.rate(odd.median())), (2.0, 1.5, 5.0));
        assert_eq!(report(&[1.0, 3.0]).median(), 2.0);
        assert_eq!((report(&[3.0]).median(), report(&[3.0]).spread()), (3.0, 0.0));
    }
}
