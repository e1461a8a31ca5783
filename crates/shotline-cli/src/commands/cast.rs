//! `shotline cast`: many rays, arrays in and arrays out.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64};
use std::time::Instant;

use clap::{ArgGroup, Args};
use serde_json::json;
use shotline::compile::World;
use shotline::query::Scope;
use shotline::query::batch::{self, BatchError, Run};
use shotline::scene::Scene;

use crate::columns::Columns;
use crate::failure::Failure;
use crate::fields::FieldsFlag;
use crate::flags::{Build, Model, SpanOfT, SurfacesOnly, Threads, parse_size, parse_whole_number};
use crate::number::counted;
use crate::progress::{self, Quiet};
use crate::query::{OverlapPolicy, Query, ThicknessBy, help};
use crate::rays::{OnInvalid, Rays};
use crate::{input, interrupt, output, stream};

/// Cast many rays
///
/// Reads rays from a .npy file of shape (N, 6), float64, or from a .csv file with six
/// numbers a line: the origin, then the
/// direction, of any length but zero. t is in lengths of the direction.
/// With --camera the rays are those of a picture.
/// Writes the results as named arrays to an .npz file:
///
///   closest    t, t_err, normal, object, surface, primitive, path, entering:
///              one row per ray; a miss is inf, NaN, -1 and False; with --fields
///              t and those named
///   any        any: bool, one row per ray
///   count      count: int64, one row per ray
///   crossings  ray_splits, t, t_err, normal, entering, object, surface,
///              primitive, path, kind: one row per crossing; those of ray i are
///              ray_splits[i] to ray_splits[i+1]; kind is 0 surface,
///              1 start (the ray begins inside), 2 end (it ends inside)
///   segments   ray_splits, t_in, t_out, length, material, object, path:
///              one row per segment of the ray inside an object
///   thickness  thickness: float64 (N, columns), one row per ray: its length in
///              each of material_names and, last, in objects without a material;
///              with --by object its length in each of object_names
///
/// object, material and path are indices into the text arrays object_names,
/// material_names and path_names. The results are bit-identical for every
/// accelerator and number of threads.
///
/// In a .csv file a line is a row, with names in place of indices; where there is a row
/// per crossing or segment, its first column is the number of the ray, from 0.
// The text is help of the command line: its brackets are not links.
#[allow(rustdoc::broken_intra_doc_links)]
#[derive(Args, Debug)]
#[command(
    after_help = EXAMPLES,
    verbatim_doc_comment,
    group = ArgGroup::new("source").args(["rays", "camera"]).required(true)
)]
pub struct Command {
    #[command(flatten)]
    model: Model,
    /// The rays, as .npy or .csv; - for .npy on standard input
    #[arg(long, value_name = "FILE.npy|.csv")]
    rays: Option<PathBuf>,
    /// Cast the rays of the scene's camera instead, through the middles of the pixels, row by row from the top
    #[arg(long, value_name = "WxH", value_parser = parse_size, allow_hyphen_values = true)]
    camera: Option<(u32, u32)>,
    /// The query for each ray
    #[arg(long, value_enum)]
    query: Query,
    /// The results, as .npz or .csv; - for .npz on standard output
    #[arg(short, long, value_name = "FILE.npz|.csv")]
    output: PathBuf,
    /// What `thickness` has columns for; default: material
    #[arg(long, value_enum)]
    by: Option<ThicknessBy>,
    /// What `segments` and `thickness` do where objects of equal priority overlap; default: error
    #[arg(long, value_name = "POLICY", value_enum)]
    overlaps: Option<OverlapPolicy>,
    /// What to do with a row that is not a valid ray: NaN, infinite, or with a zero direction
    #[arg(long, value_name = "POLICY", value_enum, default_value_t = OnInvalid::Error)]
    on_invalid: OnInvalid,
    #[command(flatten)]
    span: SpanOfT,
    #[command(flatten)]
    surfaces_only: SurfacesOnly,
    #[command(flatten)]
    fields: FieldsFlag,
    /// End with an error if the result has more rows than this; a million rows take about 65 MB
    #[arg(
        long,
        value_name = "N",
        default_value_t = Run::default().most_rows,
        value_parser = parse_whole_number::<u64>,
        allow_negative_numbers = true
    )]
    max_crossings: u64,
    /// Print one line of JSON on stdout: sizes, times, memory
    #[arg(long)]
    stats: bool,
    #[command(flatten)]
    build: Build,
    #[command(flatten)]
    threads: Threads,
    #[command(flatten)]
    quiet: Quiet,
}

const EXAMPLES: &str = "\
Examples:
  shotline cast engine.json --rays rays.npy --query crossings -o crossings.npz
  shotline cast engine.json --camera 640x480 --query any -o - | python look.py
  shotline cast engine.json --rays rays.csv --query segments -o segments.csv
  shotline cast bunny.ply --rays rays.npy --query closest -o closest.npz --stats";

/// Counts for the notes and statistics.
struct Counts {
    overlaps: u64,
    repaired: u64,
}

/// Times in seconds.
struct Times {
    load: f64,
    build: f64,
    cast: f64,
}

impl Command {
    /// Runs the command.
    pub fn run(&self) -> Result<u8, Failure> {
        let started = Instant::now();
        interrupt::catch();
        let scope = self.query.scope(self.span.span()?, self.surfaces_only)?;
        if self.by.is_some() && self.query != Query::Thickness {
            let why = format!("--by is for --query thickness, not for {}", self.query.name());
            return Err(Failure::new(why));
        }
        if self.overlaps.is_some() && !matches!(self.query, Query::Segments | Query::Thickness) {
            let name = self.query.name();
            return Err(Failure::new(format!(
                "--overlaps is for --query segments and thickness, not for {name}"
            )));
        }
        let inputs: Vec<PathBuf> = self.rays.iter().chain([&self.model.path]).cloned().collect();
        self.rays.iter().try_for_each(|rays| input::expect_one_stream(&self.model, rays))?;
        output::expect_writable(&self.output, output::ARRAYS, &inputs)?;
        let rays = self.rays.as_ref().map(|path| input::rays(path, self.on_invalid)).transpose()?;
        let begin = Instant::now();
        let document = input::load_with_notes(&self.model, self.quiet)?;
        output::expect_not_an_input(&self.output, &input::named_files(&self.model, &document))?;
        let load = begin.elapsed().as_secs_f64();
        let begin = Instant::now();
        let world = input::compile(&document, &self.build)?;
        let build = begin.elapsed().as_secs_f64();
        let rays = match (rays, self.camera) {
            (Some(rays), _) => rays,
            (None, size) => {
                let size = size.unwrap_or(input::PICTURE);
                Rays::all(input::rays_of_pixels(&self.model, &document, &world, size)?)
            }
        };
        let repaired = AtomicU64::new(0);
        let (overlaps, cast) = interrupt::cancellable(|cancel| {
            let begin = Instant::now();
            let (columns, overlaps) = self.cast(&world, &rays, scope, cancel, &repaired)?;
            let cast = begin.elapsed().as_secs_f64();
            columns.with_names(&world).write(&self.output)?;
            Ok((overlaps, cast))
        })?;
        let repaired = repaired.into_inner();
        self.print_notes(&rays, overlaps, repaired);
        if self.stats {
            let counts = Counts { overlaps, repaired };
            let stats = self.stats(&document.scene, &world, &rays, counts, &Times { load, build, cast });
            output::print_with(&self.output, &stats)?;
        }
        progress::written(&self.output, started, self.quiet);
        Ok(0)
    }

    /// The results, and how many overlaps were met.
    fn cast(
        &self,
        world: &World,
        rays: &Rays,
        scope: Scope,
        cancel: &AtomicBool,
        repaired: &AtomicU64,
    ) -> Result<(Columns, u64), Failure> {
        let bar = progress::bar(rays.valid.len() as u64, "casting", self.quiet);
        let progress = |rays| bar.inc(rays);
        let run = Run {
            threads: self.threads.threads,
            progress: Some(&progress),
            cancel: Some(cancel),
            repaired: Some(repaired),
            fields: self.fields.of(self.query)?,
            most_rows: self.max_crossings,
            ..Run::default()
        };
        let valid = &rays.valid;
        let policy = self.overlaps.unwrap_or(OverlapPolicy::Error).into();
        let result = match self.query {
            Query::Closest => batch::closest(world, valid, scope, run)
                .map(|rows| (Columns::closest(rows, rays, run.fields), 0)),
            Query::Any => batch::any(world, valid, scope, run).map(|rows| (Columns::any(rows, rays), 0)),
            Query::Count => {
                batch::count(world, valid, scope, run).map(|rows| (Columns::count(rows, rays), 0))
            }
            Query::Crossings => batch::crossings(world, valid, scope, run)
                .map(|rows| (Columns::crossings(rows, rays, run.fields), 0)),
            Query::Segments => batch::segments(world, valid, scope.span, policy, run).map(|rows| {
                let overlaps = rows.overlaps;
                (Columns::segments(rows, rays), overlaps)
            }),
            Query::Thickness => {
                let by = self.by.unwrap_or(ThicknessBy::Material).into();
                batch::thickness(world, valid, scope.span, by, policy, run).map(|thickness| {
                    let overlaps = thickness.overlaps;
                    (Columns::thickness(thickness, rays, self.by == Some(ThicknessBy::Object)), overlaps)
                })
            }
        };
        bar.finish_and_clear();
        result.map_err(|error| self.failure(error, rays))
    }

    /// The file that the rays are from.
    fn source(&self) -> &Path {
        self.rays.as_deref().unwrap_or(&self.model.path)
    }

    fn failure(&self, error: BatchError, rays: &Rays) -> Failure {
        let (location, error) = match error {
            BatchError::Cancelled => return Failure::Interrupted,
            error @ BatchError::OutOfMemory => {
                let help = "cast fewer rays at a time, or use --query closest or count";
                return Failure::of_input(self.source(), format!("{error}\nhelp: {help}"));
            }
            BatchError::TooMany { most } => {
                let most = match self.query {
                    Query::Crossings => counted(most, "crossing", "crossings"),
                    Query::Segments => counted(most, "segment", "segments"),
                    _ => counted(most, "row", "rows"),
                };
                let help =
                    "cast fewer rays at a time, use --query closest or count, or raise --max-crossings";
                let why = format!("the result has more than {most}\nhelp: {help}");
                return Failure::of_input(self.source(), why);
            }
            // All rays are valid here: invalid rows were reported or counted as misses.
            error @ (BatchError::Ray { .. } | BatchError::Point { .. }) => {
                return Failure::of_input(self.source(), error);
            }
            BatchError::World(error) => (String::new(), error),
            BatchError::Query { row, error } => {
                (format!("row {} of {}: ", rays.row(row), stream::name_of(self.source())), error)
            }
        };
        let help = help(&error);
        Failure::new(format!("{}: {location}{error}\nhelp: {help}", self.model.name()))
    }

    fn print_notes(&self, rays: &Rays, overlaps: u64, repaired: u64) {
        if rays.invalid() > 0 {
            let rows = counted(rays.invalid() as u64, "row is not a valid ray", "rows are not valid rays");
            progress::note(&format!("{rows}, counted as a miss"), self.quiet);
        }
        if overlaps > 0 {
            let met = counted(overlaps, "overlap", "overlaps");
            progress::note(&format!("{met} of objects of equal priority"), self.quiet);
        }
        if repaired > 0 {
            let lists = counted(repaired, "list of crossings was", "lists of crossings were");
            progress::note(
                &format!("{lists} broken by rounding and repaired; please report this"),
                self.quiet,
            );
        }
    }

    fn stats(&self, scene: &Scene, world: &World, rays: &Rays, counts: Counts, times: &Times) -> String {
        let line = json!({
            "rays": rays.rows,
            "threads": self.threads.count(),
            "accel": self.build.scene_accel(scene),
            "query": self.query.name(),
            "load_s": times.load,
            "build_s": times.build,
            "cast_s": times.cast,
            "rays_per_s": rays.rows as f64 / times.cast.max(1e-9),
            "memory_bytes": world.stats().memory_bytes,
            "repaired": counts.repaired,
            "invalid": rays.invalid(),
            "overlaps": counts.overlaps,
        });
        format!("{line}\n")
    }
}
