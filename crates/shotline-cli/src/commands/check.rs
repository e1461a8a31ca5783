//! `shotline check`: is a model sound?

use clap::Args;
use shotline::compile;
use shotline::scene::Node;

use crate::failure::Failure;
use crate::findings::Findings;
use crate::flags::{Build, Model};
use crate::{input, output};

/// Find defects of a model
///
/// Examines every mesh and the scene as a whole and lists all findings: how many, and where the first is. Faults
/// make a model not sound: open edges and flipped faces, which leave a mesh without an inside, errors of the
/// scene, and objects of equal priority that overlap. Remarks do not: edges of more than two faces, faces
/// without area, duplicate or inward faces, faces that pass through each other, coincident faces of different
/// objects, and empty objects. A scene without objects is a fault. Faces that only touch, or overlap in one
/// plane, do not pass through each other. Notes name what the readers of the files ignored, dropped or
/// repaired, how many times, and the first line or byte.
///
/// Rays along the axes find overlaps and coincidences of objects in the box of all bounded objects. Unbounded
/// objects, such as a ground, are clipped to that box. More rays find overlaps in the common box of each two
/// parts whose boxes meet. Small overlaps may be missed. The model is not called sound if there are too many pairs
/// of parts to examine, or if two unbounded objects might overlap outside the box.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Command {
    #[command(flatten)]
    model: Model,
    #[command(flatten)]
    build: Build,
    /// Print one JSON document instead: `sound` (null if something could not be examined), what was `unexamined`, and one
    /// of `findings` for each line
    #[arg(long)]
    json: bool,
}

const EXAMPLES: &str = "\
Exit codes: 0 sound, 1 not sound, 2 cannot be read, 3 no fault found but something could not be examined.

Examples:
  shotline check part.stl
  shotline check section.json && shotline render section.json -o section.png";

impl Command {
    /// Runs the command.
    pub fn run(&self) -> Result<u8, Failure> {
        let document = input::load(&self.model)?;
        let mut findings = Findings::default();
        for note in &document.notes {
            findings.add_note(note);
        }
        for node in &document.scene.nodes {
            if let Node::Mesh { mesh, file } = node {
                let file = file.as_ref().map_or("mesh", |file| &file.name);
                findings.examine_mesh(file, mesh, self.build.scene_accel(&document.scene));
            }
        }
        match compile::compile(&document.scene, self.build.options()) {
            Ok(world) => findings.examine_world(&world, &document.scene),
            Err(errors) => findings.add_errors(&document, &errors),
        }
        let model = self.model.name();
        let json = || format!("{:#}\n", findings.to_json(&model));
        output::print(&if self.json { json() } else { findings.to_text(&model) })?;
        Ok(findings.verdict().exit_code())
    }
}
