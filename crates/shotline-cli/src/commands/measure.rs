//! `shotline measure`: volume, mass, centroid and inertia of objects.

use std::sync::atomic::AtomicBool;

use clap::{Args, ValueEnum};
use serde_json::{Value, json};
use shotline::compile::World;
use shotline::measure::{self, Estimate, Measure, MeasureError, Method, Settings};
use shotline::query::QueryError;
use shotline::query::batch::Run;
use shotline::scene::{Scene, Units};
use shotline_io::nearest_name;

use crate::failure::Failure;
use crate::flags::{Build, Model, Threads, parse_whole_number};
use crate::number::{counted, grouped, json as number, json_vector, short_bounds, uncertain};
use crate::progress::{self, Quiet};
use crate::query::{OverlapPolicy, help};
use crate::table::{Align, Table};
use crate::{input, interrupt, output};

/// Measure volume, mass, centroid and inertia of objects
///
/// Exact, but for rounding, where there is a closed form: single solids, closed meshes, polytopes (intersections of
/// half-spaces and boxes), and groups of them whose boxes do not overlap, with any transforms. All others are measured
/// by rays, and reported with their standard errors: about two thirds of all values have a smaller error than that, and
/// one in a hundred has an error of more than three times that. Details that no ray meets are not measured; use more
/// rays for small details.
///
/// An unbounded object is reported as unbounded, and the others are measured. If every object is unbounded, that
/// is an error.
///
/// The inertia tensor (--json) is about the centroid, along the axes of the world, and for density 1. Mass is in
/// grams, from the density of the material in g/cm^3, if it has one. In a scene without units it is volume times
/// density, in the product of their units. The results are bit-identical for every accelerator and number of threads.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Command {
    #[command(flatten)]
    model: Model,
    /// Rays for each object that has no closed form, rounded up to a multiple of 48
    #[arg(long, value_name = "N", default_value_t = Settings::default().rays, value_parser = parse_whole_number::<usize>, allow_negative_numbers = true)]
    rays: usize,
    /// The seed, which determines the rays
    #[arg(long, value_name = "N", default_value_t = Settings::default().seed, value_parser = parse_whole_number::<u64>, allow_negative_numbers = true)]
    seed: u64,
    /// Measure only objects of this name; may be given several times
    #[arg(long = "object", value_name = "NAME")]
    objects: Vec<String>,
    /// Whether closed forms are used
    #[arg(long, value_enum, default_value_t = MethodChoice::Best)]
    method: MethodChoice,
    /// What to measure where objects overlap. With `all` each object is measured as if it were alone. With
    /// `error` and `priority` rays measure only the segments that `cast --query segments` gives to the object
    #[arg(long, value_name = "POLICY", value_enum, default_value_t = OverlapPolicy::All)]
    overlaps: OverlapPolicy,
    /// Print one JSON document instead, with all digits and the inertia tensor
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
  shotline measure engine.json
  shotline measure engine.json --object crankshaft --rays 10000000
  shotline measure part.stl --json";

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum MethodChoice {
    /// Closed forms where there are any, else rays
    Best,
    /// Rays only
    Rays,
}

impl Command {
    /// Runs the command.
    pub fn run(&self) -> Result<u8, Failure> {
        interrupt::catch();
        if self.rays == 0 {
            return Err(Failure::new("--rays is 0, but must be at least 1"));
        }
        let document = input::load_with_notes(&self.model, self.quiet)?;
        let world = input::compile(&document, &self.build)?;
        let settings = Settings {
            rays: self.rays,
            seed: self.seed,
            method: match self.method {
                MethodChoice::Best => Method::Best,
                MethodChoice::Rays => Method::Rays,
            },
            overlaps: self.overlaps.into(),
            objects: self.chosen(&world)?,
        };
        if world.object_names().is_empty() {
            return Err(Failure::of_file(
                &self.model.path,
                "the scene has no objects, so there is nothing to measure",
            ));
        }
        let measures =
            interrupt::cancellable(|cancel| self.measure(&world, &document.scene, &settings, cancel))?;
        self.expect_bounded(&world, &measures)?;
        let report = Report { world: &world, scene: &document.scene, settings: &settings, measures };
        output::print(&if self.json { format!("{:#}\n", report.to_json()) } else { report.to_text() })?;
        Ok(0)
    }

    /// Returns an error if all objects are unbounded, so that nothing can be measured.
    fn expect_bounded(&self, world: &World, measures: &[Measure]) -> Result<(), Failure> {
        let Some(first) = measures.first().filter(|_| measures.iter().all(Measure::is_unbounded)) else {
            return Ok(());
        };
        let why = format!(
            "object '{}' has no finite bounds: its box is from {}\n\
             help: intersect it with a box around the part to measure, or choose others with --object",
            world.object_names()[first.object as usize],
            short_bounds(&first.bounds)
        );
        Err(Failure::of_input(&self.model.path, why))
    }

    /// The numbers of the objects named by --object; `None` for all.
    fn chosen(&self, world: &World) -> Result<Option<Vec<u32>>, Failure> {
        let mut chosen = Vec::new();
        for name in &self.objects {
            let before = chosen.len();
            let named = (0..).zip(world.object_names()).filter(|(_, known)| *known == name);
            chosen.extend(named.map(|(object, _)| object));
            if chosen.len() == before {
                let hint = nearest_name(name, world.object_names().iter().map(String::as_str));
                let hint = hint.map_or("`shotline info` lists the objects".into(), |known| {
                    format!("did you mean '{known}'?")
                });
                let why = format!("there is no object '{name}'\nhelp: {hint}");
                return Err(Failure::of_input(&self.model.path, why));
            }
        }
        Ok((!chosen.is_empty()).then_some(chosen))
    }

    fn measure(
        &self,
        world: &World,
        scene: &Scene,
        settings: &Settings,
        cancel: &AtomicBool,
    ) -> Result<Vec<Measure>, Failure> {
        let objects = settings.objects.as_ref().map_or(world.object_names().len(), Vec::len);
        let bar = progress::bar((objects as u64).saturating_mul(self.rays as u64), "measuring", self.quiet);
        let progress = |rays| bar.inc(rays);
        let run = Run {
            threads: self.threads.threads,
            progress: Some(&progress),
            cancel: Some(cancel),
            ..Run::default()
        };
        let result = measure::measure(world, scene, settings, run);
        bar.finish_and_clear();
        result.map_err(|error| self.failure(&error))
    }

    fn failure(&self, error: &MeasureError) -> Failure {
        let help = match error {
            MeasureError::Cancelled => return Failure::Interrupted,
            MeasureError::Query(QueryError::NotASolid { .. }) => {
                "close the mesh (`shotline check` lists its defects), or choose others with --object"
            }
            MeasureError::Query(QueryError::TooMany { .. } | QueryError::TooLong { .. }) => {
                "nest fewer parts in each other, or choose others with --object"
            }
            MeasureError::Query(error) => help(error),
            MeasureError::TooMany { .. } => {
                "choose fewer --rays, or measure fewer objects at a time with --object"
            }
            MeasureError::OutOfRange { .. } => "choose other objects with --object",
            MeasureError::TooNested { .. } | MeasureError::NoObject { .. } => "choose fewer with --object",
        };
        Failure::of_input(&self.model.path, format!("{error}\nhelp: {help}"))
    }
}

/// The unit of mass in scenes with a unit of length.
const GRAMS: &str = "g";

/// What the command reports.
struct Report<'a> {
    world: &'a World,
    scene: &'a Scene,
    settings: &'a Settings,
    measures: Vec<Measure>,
}

impl Report<'_> {
    fn to_json(&self) -> Value {
        json!({
            "units": self.scene.units.map(Units::name),
            "mass_units": self.scene.units.map(|_| GRAMS),
            "seed": self.settings.seed,
            "rays": self.rays(),
            "objects": self.measures.iter().map(|m| json!({
                "name": self.name(m),
                "exact": m.exact,
                "unbounded": m.is_unbounded(),
                "rays": m.rays,
                "volume": estimate(&m.volume),
                "mass": m.mass.as_ref().map(estimate),
                "centroid": m.centroid.iter().map(estimate).collect::<Vec<_>>(),
                "inertia": m.inertia.iter()
                    .map(|row| row.iter().map(estimate).collect())
                    .collect::<Vec<Vec<_>>>(),
                "bounds": if m.bounds.is_empty() { Value::Null } else {
                    json!({ "min": json_vector(m.bounds.min), "max": json_vector(m.bounds.max) })
                },
            })).collect::<Vec<_>>(),
        })
    }

    fn to_text(&self) -> String {
        let column = |name: &str, unit: &str| {
            let units = self.scene.units.map_or_else(String::new, |units| format!(" {units}{unit}"));
            (format!("{name}{units}"), Align::Left)
        };
        let has_mass = self.measures.iter().any(|m| m.mass.is_some());
        let mut columns = vec![("object".into(), Align::Left), column("volume", "^3")];
        if has_mass {
            let units = if self.scene.units.is_some() { GRAMS } else { "density x length^3" };
            columns.push((format!("mass {units}"), Align::Left));
        }
        columns.extend([column("centroid", ""), column("bounds", ""), ("rays".into(), Align::Right)]);
        let mut table = Table::new(columns);
        for m in &self.measures {
            let text = |e: &Estimate| if m.is_unbounded() { "-".into() } else { to_text(e) };
            let volume = if m.is_unbounded() { "unbounded".into() } else { to_text(&m.volume) };
            let mut row = vec![self.name(m).to_string(), volume];
            if has_mass {
                row.push(m.mass.as_ref().map_or_else(|| "-".into(), text));
            }
            row.push(match &m.centroid {
                [x, ..] if x.value.is_nan() => "-".into(),
                centroid => format!("({})", centroid.each_ref().map(text).join(", ")),
            });
            row.push(if m.bounds.is_empty() { "nothing".into() } else { short_bounds(&m.bounds) });
            row.push(if m.is_unbounded() {
                "-".into()
            } else if m.exact {
                "exact".into()
            } else {
                grouped(m.rays as u64)
            });
            table.row(row);
        }
        let rays = counted(self.rays(), "ray", "rays");
        format!("{}\n  {rays} in all; exact: but for rounding\n", table.text())
    }

    fn rays(&self) -> u64 {
        self.measures.iter().map(|m| m.rays as u64).sum()
    }

    fn name(&self, m: &Measure) -> &str {
        &self.world.object_names()[m.object as usize]
    }
}

fn estimate(e: &Estimate) -> Value {
    json!({ "value": number(e.value), "std_error": number(e.std_error) })
}

fn to_text(e: &Estimate) -> String {
    uncertain(e.value, e.std_error)
}
