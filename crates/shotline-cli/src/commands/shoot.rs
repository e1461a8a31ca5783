//! `shotline shoot`: one ray, reported in full.

use std::path::{Path, PathBuf};

use clap::Args;
use shotline::compile::World;
use shotline::math::Vec3;
use shotline::query::Scope;
use shotline::query::batch::Run;
use shotline::ray::{Ray, Span};
use shotline::scene::Scene;
use shotline_render::{RayDrawing, RenderError, Settings, render_ray};

use crate::failure::Failure;
use crate::flags::{Build, Model, SpanOfT, SurfacesOnly, parse_size, parse_whole_number};
use crate::number::parse_vector;
use crate::picture_file;
use crate::progress::Quiet;
use crate::shoot_report::ShootReport;
use crate::stream::is_stream;
use crate::trace_report::{TraceQuery, TraceReport};
use crate::{input, output};

/// Shoot one ray and report every crossing
///
/// One line per crossing: t, distance from the origin, point, whether the ray goes in or out, object, surface,
/// material, path through the scene graph, normal, obliquity (the angle between ray and normal) and the
/// thickness so far: the length of the ray inside objects. Below are the lengths by material and the
/// overlaps of objects of equal priority.
///
/// t is in lengths of the direction. With --to it is 1 at that point; the ray continues behind it unless
/// --t-max 1 is given.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Command {
    #[command(flatten)]
    model: Model,
    /// Where the ray begins
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_vector, allow_hyphen_values = true)]
    from: Vec3,
    #[command(flatten)]
    aim: Aim,
    #[command(flatten)]
    span: SpanOfT,
    /// Find surfaces only: leave out the crossings of kind `start` and `end`, with which the list begins and ends
    /// where the ray begins or ends inside
    #[arg(long)]
    surfaces_only: bool,
    #[command(flatten)]
    build: Build,
    /// First print the steps of a query: crossings, unless another query is named
    ///
    /// One line per step, indented by depth. `open`: the nearest pending part of the accelerator is opened. Its
    /// children, `+`, are put on a heap, ordered by the t at which they begin. `test`: a solid is intersected, and its
    /// crossings are put on the heap too. A crossing is taken off the heap when no pending entry begins before it.
    /// `=>` is a crossing that the query receives; a crossing without it has no effect. In a mesh each line is a run of
    /// triangles.
    #[arg(
        long,
        value_name = "QUERY",
        value_enum,
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "crossings"
    )]
    trace: Option<TraceQuery>,
    /// The largest number of steps to print
    #[arg(long, value_name = "N", default_value_t = 1000, requires = "trace", value_parser = parse_whole_number::<usize>, allow_negative_numbers = true)]
    steps: usize,
    /// Print one JSON document instead; infinite and missing values are null there
    #[arg(long)]
    json: bool,
    /// Also draw the ray in the scene, as PNG or JPEG, by the extension of the name: seen from beside it, through the objects, with
    /// its parts in objects thick, its crossings as dots with their numbers, and a legend with the t of each
    #[arg(long, value_name = "FILE.png|.jpg")]
    picture: Option<PathBuf>,
    /// Pixels of the picture across and down, without the legend
    #[arg(long, value_name = "WxH", default_value = "800x600", requires = "picture", value_parser = parse_size, allow_hyphen_values = true)]
    size: (u32, u32),
}

#[derive(Args, Debug)]
#[group(required = true, multiple = false)]
struct Aim {
    /// A point on the ray, at t = 1
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_vector, allow_hyphen_values = true)]
    to: Option<Vec3>,
    /// The direction of the ray, of any length
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_vector, allow_hyphen_values = true)]
    dir: Option<Vec3>,
}

const EXAMPLES: &str = "\
Examples:
  shotline shoot part.json --from -10,0,0 --to 0,0,0
  shotline shoot part.json --from -10,0,0 --to 0,0,0 --picture ray.png
  shotline shoot bunny.ply --from 0,0.1,-1 --dir 0,0,1 --json
  shotline shoot part.json --from -10,0,0 --to 0,0,0 --trace=closest --accel grid";

impl Command {
    /// Runs the command.
    pub fn run(&self) -> Result<u8, Failure> {
        let ray = self.ray()?;
        let span = self.span.span()?;
        if let Some(path) = &self.picture {
            self.expect_picture(path)?;
        }
        let document = input::load_with_notes(&self.model, Quiet { quiet: false })?;
        let world = input::compile(&document, &self.build)?;
        let failure = |e| {
            let help = "shorten the ray with --t-min and --t-max, or use `shotline cast`";
            Failure::of_input(&self.model.path, format!("{e}\nhelp: {help}"))
        };
        let kinds = SurfacesOnly { surfaces_only: self.surfaces_only }.kinds();
        let report = ShootReport::new(&world, ray, span, kinds, document.scene.units).map_err(failure)?;
        let steps =
            self.trace.map(|query| TraceReport::new(&world, &ray, Scope { span, kinds }, query, self.steps));
        let steps = steps.transpose().map_err(failure)?;
        if let Some(path) = &self.picture {
            self.draw(path, &world, &document.scene, &report, (ray, span))?;
        }
        output::print(&if self.json {
            let mut document = report.to_json();
            if let Some(steps) = steps {
                document["trace"] = steps.to_json();
            }
            format!("{document:#}\n")
        } else {
            let steps = steps.map_or_else(String::new, |steps| steps.to_text() + "\n");
            steps + &report.to_text()
        })?;
        Ok(0)
    }

    fn expect_picture(&self, path: &Path) -> Result<(), Failure> {
        if is_stream(path) {
            let why = "--picture -: standard output is for the report\nhelp: name a file";
            return Err(Failure::new(why));
        }
        output::expect_writable(path, output::PICTURE, std::slice::from_ref(&self.model.path))
    }

    fn draw(
        &self,
        path: &Path,
        world: &World,
        scene: &Scene,
        report: &ShootReport,
        (ray, span): (Ray, Span),
    ) -> Result<(), Failure> {
        let (segments, marks) = (report.segments(), report.marks());
        let drawing = RayDrawing { ray, span, segments, marks: &marks };
        let ((width, height), hidden) = (self.size, scene.hiding_enclosures());
        let settings = Settings { width, height, hidden, ..Settings::default() };
        let image = render_ray(world, scene, &drawing, &settings, Run::default());
        picture_file::write(path, &image.map_err(|error| self.no_picture(error))?)
    }

    fn no_picture(&self, error: RenderError) -> Failure {
        match error {
            RenderError::Size { .. } => Failure::new(format!("--size: {error}")),
            error => Failure::of_input(&self.model.path, error),
        }
    }

    fn ray(&self) -> Result<Ray, Failure> {
        let direction = match (self.aim.dir, self.aim.to) {
            (Some(dir), _) => dir,
            (None, Some(to)) => to - self.from,
            (None, None) => Vec3::ZERO, // clap requires one of them
        };
        let help = "--dir must not be zero, and --to must differ from --from";
        Ray::new(self.from, direction)
            .map_err(|e| Failure::new(format!("the ray is not valid: {e}\nhelp: {help}")))
    }
}
