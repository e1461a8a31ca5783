//! `shotline check`: is a model sound?

use clap::Args;
use shotline::compile;
use shotline::scene::Node;

use crate::args::{Build, Model};
use crate::failure::Failure;
use crate::findings::Findings;
use crate::{input, output};

/// Tell what is wrong with a model
///
/// Examines every mesh and the scene as a whole and lists all that is found: how often, and where first. Faults
/// make a model not sound: open edges and flipped faces, which leave a mesh without an inside, errors of the
/// scene, and objects of equal priority that overlap. Remarks do not: edges of more than two faces, faces
/// without area, doubled or inward faces, faces that pass through each other, faces of different objects in
/// one place, and objects of which there is nothing. A scene without objects is a fault. Faces that only touch, or overlap in one plane, do not pass through each other. Notes name what
/// the readers of the files passed over, dropped or repaired, how often, and the first line or byte.
///
/// Overlaps and coincidences of objects are looked for with rays along the axes, spread over the box of all objects that
/// have an end. Overlaps are also looked for in the common box of each two parts whose boxes meet; small ones may slip
/// through. Where the pairs of parts are too many, some are not examined: then the model is not called sound. Objects without an end, such as a ground, are cut by that box. Two of them that
/// might overlap far away are not examined there: then the model is not called sound.
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
  shotline check scenes/section.json && shotline cast scenes/section.json --rays rays.npy --query segments -o out.npz";

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
                findings.examine_mesh(file, mesh, self.build.general(&document.scene));
            }
        }
        match compile::compile(&document.scene, self.build.options()) {
            Ok(world) => findings.examine_world(&world, &document.scene),
            Err(errors) => findings.add_errors(&document, &errors),
        }
        let model = self.model.path.display().to_string();
        let json = || format!("{:#}\n", findings.to_json(&model));
        output::print(&if self.json { json() } else { findings.to_text(&model) })?;
        Ok(findings.verdict().exit_code())
    }
}
