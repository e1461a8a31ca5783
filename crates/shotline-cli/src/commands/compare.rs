//! `shotline compare`: every accelerator on the same rays.

use std::path::PathBuf;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use clap::Args;
use shotline::accel::{DEFAULT, NAMES};
use shotline::compile::{self, Options, World};
use shotline::counters::{COUNTERS, Counters};
use shotline::query::batch::{self, ClosestRows, Run};
use shotline::ray::{Ray, Span};
use shotline_io::Document;
use shotline_render::{Image, Settings, look, render};

use crate::failure::Failure;
use crate::flags::Model;
use crate::input::PICTURE;
use crate::number::{bytes, short};
use crate::progress::Quiet;
use crate::table::{Align, Table};
use crate::{input, interrupt, output, picture_file};

/// Compare the accelerators
///
/// Builds the model once for every accelerator, casts the same rays on one thread and prints a table: build time,
/// memory, time per ray for the closest crossing (the best of five passes), the ratio to the fastest, and the
/// counters per ray.
/// The rays are those of a picture, or yours. A slow accelerator is stopped after a few seconds; the column `rays`
/// says how many rays it has cast. The results of all accelerators are compared bit by bit.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Command {
    #[command(flatten)]
    model: Model,
    /// The rays, as .npy; default: those of a picture
    #[arg(long, value_name = "FILE.npy")]
    rays: Option<PathBuf>,
    /// A contact sheet of heat maps of the work per ray, as PNG or JPEG, by the extension of the name; - for standard output
    #[arg(short, long, value_name = "FILE.png")]
    output: Option<PathBuf>,
}

const EXAMPLES: &str = "\
Examples:
  shotline compare bunny.ply
  shotline compare engine.json --rays rays.npy -o work.png";

/// The number of pictures in a row of the sheet.
const COLUMNS: u32 = 5;
/// How long one accelerator may cast.
const MAX_TIME: Duration = Duration::from_secs(3);
/// The number of passes, of which the fastest counts, if all of them fit into `MAX_TIME`.
const PASSES: u32 = 5;
/// Rays between two readings of the clock.
const CHUNK: usize = 256;

/// The measurements of one accelerator.
struct Entry {
    name: &'static str,
    world: World,
    build_s: f64,
    ns_a_ray: f64,
    work: Counters,
    results: ClosestRows,
}

impl Command {
    /// Runs the command.
    pub fn run(&self) -> Result<u8, Failure> {
        interrupt::catch();
        let inputs: Vec<PathBuf> = self.rays.iter().chain([&self.model.path]).cloned().collect();
        self.rays.iter().try_for_each(|rays| input::expect_one_stream(&self.model, rays))?;
        self.output.iter().try_for_each(|path| output::expect_writable(path, output::PICTURE, &inputs))?;
        let document = input::load_with_notes(&self.model, Quiet { quiet: false })?;
        let rays = self.rays(&document)?;
        let entries: Vec<Entry> =
            NAMES.iter().map(|name| measure(name, &document, &rays)).collect::<Result<_, _>>()?;
        for other in &entries[1..] {
            expect_same(&entries[0], other)?;
        }
        let text = table(&entries).text();
        match &self.output {
            None => output::print(&text)?,
            Some(path) => {
                output::print_with(path, &text)?;
                picture_file::write(path, &self.sheet(&document, &entries)?)?;
            }
        }
        Ok(0)
    }

    fn rays(&self, document: &Document) -> Result<Vec<Ray>, Failure> {
        match &self.rays {
            Some(path) => input::valid_rays(path),
            None => {
                let world = compile_with(document, DEFAULT)?;
                input::rays_of_picture(&self.model, document, &world)
            }
        }
    }

    fn sheet(&self, document: &Document, entries: &[Entry]) -> Result<Image, Failure> {
        let look = look("cost").unwrap_or(Settings::default().look);
        let counter = &COUNTERS[COUNTERS.len() - 1];
        let (width, height) = PICTURE;
        let settings = Settings { width, height, samples: 1, look, counter, ..Settings::default() };
        let picture = |entry: &Entry| {
            let picture = render(&entry.world, &document.scene, &settings, Run::default());
            picture.map(|picture| (entry.name, picture)).map_err(|e| self.failure(e))
        };
        let pictures: Vec<_> = entries.iter().map(picture).collect::<Result<_, _>>()?;
        Image::contact_sheet(&pictures, COLUMNS).ok_or_else(|| Failure::new("there is nothing to draw"))
    }

    fn failure(&self, error: impl std::fmt::Display) -> Failure {
        Failure::of_input(&self.model.path, error)
    }
}

fn compile_with(document: &Document, accel: &'static str) -> Result<World, Failure> {
    compile::compile(&document.scene, Options { accel: Some(accel) })
        .map_err(|errors| Failure::new(document.diagnostics(&errors).to_string()))
}

fn measure(name: &'static str, document: &Document, rays: &[Ray]) -> Result<Entry, Failure> {
    let begin = Instant::now();
    let world = compile_with(document, name)?;
    let build_s = begin.elapsed().as_secs_f64();
    let work = Mutex::new(Counters::default());
    let run = Run { threads: 1, counters: Some(&work), ..Run::default() };
    let mut results = ClosestRows::default();
    let begin = Instant::now();
    for chunk in rays.chunks(CHUNK) {
        let rows = batch::closest(&world, chunk, Span::FORWARD, run);
        results.append(rows.map_err(|e| Failure::new(e.to_string()))?);
        if begin.elapsed() > MAX_TIME {
            break;
        }
    }
    let mut seconds = begin.elapsed().as_secs_f64();
    // The first pass includes cache misses, and any pass may include other work of the machine.
    for _ in 1..PASSES {
        if results.t.len() < rays.len() || begin.elapsed() > MAX_TIME {
            break;
        }
        let pass = Instant::now();
        for chunk in rays.chunks(CHUNK) {
            batch::closest(&world, chunk, Span::FORWARD, Run { counters: None, ..run })
                .map_err(|e| Failure::new(e.to_string()))?;
        }
        seconds = seconds.min(pass.elapsed().as_secs_f64());
    }
    let work = work.into_inner().unwrap_or_default();
    let ns_a_ray = seconds * 1e9 / results.t.len().max(1) as f64;
    Ok(Entry { name, world, build_s, ns_a_ray, work, results })
}

/// Checks that the results of two accelerators are the same for the rays that both have cast.
fn expect_same(a: &Entry, b: &Entry) -> Result<(), Failure> {
    let bits = |rows: &ClosestRows, i: usize| (rows.t[i].to_bits(), rows.path[i], rows.primitive[i]);
    let both = a.results.t.len().min(b.results.t.len());
    match (0..both).find(|&i| bits(&a.results, i) != bits(&b.results, i)) {
        None => Ok(()),
        Some(ray) => Err(Failure::new(format!(
            "'{}' and '{}' differ on ray {ray}; please report this with the model",
            a.name, b.name
        ))),
    }
}

fn table(entries: &[Entry]) -> Table {
    let number = |name: &str| (name.to_owned(), Align::Right);
    let mut columns = vec![("accelerator".to_owned(), Align::Left)];
    columns.extend(["build, s", "memory", "rays", "ns a ray", "times"].map(number));
    columns.extend(COUNTERS.iter().map(|counter| number(counter.name)));
    let mut table = Table::new(columns);
    let best = entries.iter().fold(f64::INFINITY, |m, e| m.min(e.ns_a_ray));
    for entry in entries {
        let rays = entry.results.t.len();
        let mut row = vec![
            entry.name.to_owned(),
            format!("{:.3}", entry.build_s),
            bytes(entry.world.stats().memory_bytes),
            rays.to_string(),
            format!("{:.0}", entry.ns_a_ray),
            format!("{:.1}", entry.ns_a_ray / best),
        ];
        row.extend(
            COUNTERS
                .iter()
                .map(|c| short(((c.of)(&entry.work) as f64 / rays.max(1) as f64 * 10.0).round() / 10.0)),
        );
        table.row(row);
    }
    table
}
