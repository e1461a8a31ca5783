//! `shotline slice`: what owns each pixel of a plane.

use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::time::Instant;

use clap::{Args, ValueEnum};
use shotline::compile::World;
use shotline::query::batch::Run;
use shotline::scene::Scene;
use shotline_io::Document;
use shotline_render::slice::{
    Area, ColorBy, Conflicts, Slice, SliceError, SlicePlane, SliceSettings, area_within_enclosures, slice,
    slice_jpeg, slice_png, slice_svg,
};

use crate::columns::Columns;
use crate::failure::Failure;
use crate::flags::{Build, Model, Threads, parse_size};
use crate::number::{counted, short_vector};
use crate::picture_file;
use crate::progress::{self, Quiet};
use crate::shown::enclosures_in_words;
use crate::stream::is_stream;
use crate::{input, interrupt, output};

/// Show which object, material or instance owns each pixel of a plane
///
/// Rays along the rows of pixels find the boundaries, so that these are exact along the rows; a pixel belongs to what owns
/// its middle. Nothing is hidden, and what encloses everything is shown too, but the area is by default that of the other
/// objects. The file is a picture with axes and a legend, .png, .jpg or .svg, or arrays, .npz:
///
///   object, material, path  (rows, columns), from the upper left corner: indices
///                           into object_names, material_names, path_names; -1
///                           where there is none
///   overlap                 (rows, columns): the pair of objects that overlap
///                           there, an index into overlap_first,
///                           overlap_second and overlap_kind; -1 where none do
///   overlap_first, overlap_second, overlap_kind
///                           two objects of equal priority that overlap (kind
///                           0), or the first sticks out of the second, which
///                           contains and clips it (kind 1)
///   area, origin, u, v      the area U0,V0,U1,V1; the point of the plane at
///                           (0, 0), and the axes to the right and upwards
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES, verbatim_doc_comment)]
pub struct Command {
    #[command(flatten)]
    model: Model,
    /// The picture, as PNG, JPEG or SVG, or the arrays, by the extension of the name; - for a PNG on standard output
    #[arg(short, long, value_name = "FILE.png|.jpg|.svg|.npz")]
    output: PathBuf,
    /// The plane: x=1, y=-2, z=0, or NX,NY,NZ,D for the points with N.p = D. Its axes are x and y for z=0, y and z for
    /// x=1, x and z for y=-2; in other planes the axis upwards is nearest to z, or to y where N is mostly along z
    #[arg(long, value_name = "PLANE", default_value = "z=0", value_parser = SlicePlane::from_str, allow_hyphen_values = true)]
    plane: SlicePlane,
    /// What has a colour of its own
    #[arg(long, value_enum, default_value_t = ByChoice::Object)]
    by: ByChoice,
    /// Pixels across and down; default: 800 on the longer side, and square pixels
    #[arg(long, value_name = "WxH", value_parser = parse_size, allow_hyphen_values = true)]
    size: Option<(u32, u32)>,
    /// The part of the plane: its lower left and its upper right corner, along the axes. Default: what is around the
    /// bounded objects in the plane
    #[arg(long, value_name = "U0,V0,U1,V1", value_parser = parse_area, allow_hyphen_values = true)]
    area: Option<Area>,
    /// Mark in the picture where objects of equal priority overlap, and where one sticks out of what contains and clips
    /// it, and name each pair
    #[arg(long)]
    overlaps: bool,
    #[command(flatten)]
    build: Build,
    #[command(flatten)]
    threads: Threads,
    #[command(flatten)]
    quiet: Quiet,
}

const EXAMPLES: &str = "\
Examples:
  shotline slice engine.json -o engine.png --plane y=0
  shotline slice detector.gdml -o cut.svg --plane x=0 --by material
  shotline slice detector.gdml -o near.png --area -50,-50,50,50 --size 1000x1000 --overlaps
  shotline slice part.stl -o slice.npz --plane 1,1,0,10";

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum ByChoice {
    /// Each object
    Object,
    /// Each material, in its own colour if it has one
    Material,
    /// Each placement of an object
    Instance,
}

impl From<ByChoice> for ColorBy {
    fn from(choice: ByChoice) -> ColorBy {
        match choice {
            ByChoice::Object => ColorBy::Object,
            ByChoice::Material => ColorBy::Material,
            ByChoice::Instance => ColorBy::Instance,
        }
    }
}

/// What is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Png,
    Jpeg,
    Svg,
    Arrays,
}

impl Format {
    /// The format for the name of a file.
    fn of(path: &Path) -> Result<Format, Failure> {
        let extension = path.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase());
        match extension.as_deref() {
            _ if is_stream(path) => Ok(Format::Png),
            Some("png") => Ok(Format::Png),
            Some("jpg" | "jpeg") => Ok(Format::Jpeg),
            Some("svg") => Ok(Format::Svg),
            Some("npz") => Ok(Format::Arrays),
            _ => {
                let why =
                    "the extension tells what is written\nhelp: use the extension .png, .jpg, .svg or .npz";
                Err(Failure::of_file(path, format!("cannot be written: {why}")))
            }
        }
    }
}

/// The pairs of objects that are named on stderr.
const MOST_PAIRS: usize = 10;

impl Command {
    /// Runs the command.
    pub fn run(&self) -> Result<u8, Failure> {
        let started = Instant::now();
        interrupt::catch();
        output::expect_writable(&self.output, output::SLICE, std::slice::from_ref(&self.model.path))?;
        let format = Format::of(&self.output)?;
        let document = input::load_with_notes(&self.model, self.quiet)?;
        output::expect_not_an_input(&self.output, &input::named_files(&self.model, &document))?;
        let world = input::compile(&document, &self.build)?;
        interrupt::cancellable(|cancel| {
            let settings =
                SliceSettings { plane: self.plane, area: self.area(&document.scene), size: self.size };
            let run = Run { threads: self.threads.threads, cancel: Some(cancel), ..Run::default() };
            let slice = slice(&world, &settings, run).map_err(|error| self.failure(error))?;
            self.print_notes(&slice, &world);
            self.write(slice, &world, &document, format)
        })?;
        progress::written(&self.output, started, self.quiet);
        Ok(0)
    }

    /// The area, if it is not the default of a slice: without one that is given, objects that enclose all others do not count.
    fn area(&self, scene: &Scene) -> Option<Area> {
        let inner = || area_within_enclosures(scene, &self.plane, self.size);
        self.area.or_else(|| {
            let area = inner()?;
            let names = enclosures_in_words(scene);
            progress::note(
                &format!("the area is that of what {names} encloses; --area shows another"),
                self.quiet,
            );
            Some(area)
        })
    }

    fn write(&self, slice: Slice, world: &World, document: &Document, format: Format) -> Result<(), Failure> {
        let conflicts = if self.overlaps { Conflicts::Marked } else { Conflicts::Hidden };
        let by = self.by.into();
        match format {
            Format::Arrays => Columns::slice(slice).with_names(world).write(&self.output),
            Format::Png => {
                output::write(&self.output, &slice_png(&slice, world, &document.scene, by, conflicts))
            }
            Format::Jpeg => {
                let jpeg = slice_jpeg(&slice, world, &document.scene, by, conflicts);
                output::write(
                    &self.output,
                    &jpeg.map_err(|error| picture_file::failure(&self.output, error))?,
                )
            }
            Format::Svg => {
                let svg = slice_svg(&slice, world, &document.scene, by, conflicts);
                output::write(&self.output, svg.as_bytes())
            }
        }
    }

    fn print_notes(&self, slice: &Slice, world: &World) {
        let note = |text: &str| progress::note(text, self.quiet);
        if slice.rows.iter().all(Vec::is_empty) {
            note(&format!("there is nothing in this area of the plane {}", slice.plane));
        }
        let count = slice.pairs.len();
        let shown = if self.overlaps { MOST_PAIRS } else { 1 };
        for pair in slice.pairs.iter().take(shown) {
            let pixels = counted(pair.pixels, "pixel", "pixels");
            let at = short_vector(slice.point(pair.at));
            note(&format!("{} on {pixels}, as at {at}", pair.text(world)));
        }
        if count > shown {
            let more = counted((count - shown) as u64, "more pair", "more pairs");
            let help = if self.overlaps { "" } else { "; --overlaps names and marks them" };
            note(&format!("{more} of objects in conflict{help}"));
        }
    }

    fn failure(&self, error: SliceError) -> Failure {
        match error {
            SliceError::Cancelled => Failure::Interrupted,
            SliceError::Size { .. } => Failure::new(format!("--size: {error}")),
            error => Failure::of_input(&self.model.path, error),
        }
    }
}

/// Parses a rectangle, as in -5,-5,5,5.
fn parse_area(text: &str) -> Result<Area, String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|number| number.trim().parse()).collect();
    match numbers.as_deref() {
        Ok(&[u0, v0, u1, v1]) => Area::new([u0, v0], [u1, v1]).map_err(|error| error.to_string()),
        _ => Err("expected four numbers U0,V0,U1,V1: the lower left and the upper right corner".into()),
    }
}
