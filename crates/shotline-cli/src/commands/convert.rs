//! `shotline convert`: from one file format to another.

use std::borrow::Cow;
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use clap::Args;
use shotline::query::batch::{BatchError, Run};
use shotline::scene::{Node, Scene};
use shotline_io::{Document, Format, WriteError, save, write_scene};
use shotline_tessellate::{Part, Progress, Settings, TessellateError, tessellate};

use crate::failure::Failure;
use crate::flags::{Model, Threads};
use crate::number::{counted, grouped, significant};
use crate::progress::{self, Quiet};
use crate::shown::{enclosures_in_words, hidden_by_name};
use crate::{input, interrupt, output, stream};

/// Convert between file formats
///
/// The extension of OUT gives the format: .json a scene, .gdml a detector, .glb or .gltf a scene in glTF, .3mf a print, those of
/// mesh formats a mesh. Reports on stderr what is lost, and which other files were written: the meshes that a scene names are
/// written to its folder as PLY, unless they are there. A GDML file holds them itself; what GDML lacks is an error that names the
/// object.
///
/// PLY and OBJ keep every bit of a mesh, and its colours, normals and texture coordinates; PLY keeps all other attributes too. STL
/// has no vertex indices, and float32 coordinates in its binary form, so it is written as text if float32 would move a vertex. A
/// mesh file contains all meshes of a scene, transformed; OBJ and text STL keep the objects apart, OBJ with their materials in an
/// MTL file, and the others join them to one. glTF and 3MF keep objects, names, colours and shared meshes; glTF rounds to float32. Solids
/// and combinations are made into meshes with --tolerance: closed, with sharp edges, within that distance. The outermost object of nested
/// volumes is left out of mesh files then, unless --hide or --only say what is.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Command {
    #[command(flatten)]
    model: Model,
    /// The file to write
    #[arg(value_name = "OUT")]
    output: PathBuf,
    /// Make solids and combinations into meshes within this distance of their surfaces, in units of the scene
    #[arg(long, value_name = "DISTANCE", allow_negative_numbers = true)]
    tolerance: Option<f64>,
    /// Leave out the objects of this name, but not what they contain; * stands for any letters. May be given several times
    #[arg(long, value_name = "NAME")]
    hide: Vec<String>,
    /// Convert the objects of this name and what they contain, and no others; * stands for any letters. May be given several times
    #[arg(long, value_name = "NAME", conflicts_with = "hide")]
    only: Vec<String>,
    #[command(flatten)]
    threads: Threads,
    #[command(flatten)]
    quiet: Quiet,
}

const EXAMPLES: &str = "\
Examples:
  shotline convert part.stl part.ply
  shotline convert part.ply part.json      # a scene of one object, to edit
  shotline convert detector.gdml detector.json
  shotline convert scene.json detector.gdml
  shotline convert valve.json valve.stl --tolerance 0.01 --hide ground
  shotline convert valve.json valve.glb --tolerance 0.01    # objects with names and colours";

impl Command {
    /// Runs the command.
    pub fn run(&self) -> Result<u8, Failure> {
        let started = Instant::now();
        interrupt::catch();
        output::expect_writable(&self.output, &[], std::slice::from_ref(&self.model.path))?;
        let mut document = input::load(&self.model)?;
        let enclosures = self.leave_out_hidden(&mut document.scene)?;
        output::expect_not_an_input(&self.output, &input::named_files(&self.model, &document))?;
        let notes = interrupt::cancellable(|cancel| {
            let (scene, made) = self.tessellated(&document, cancel)?;
            let notes = self.save(&scene)?;
            Ok([enclosures, made, notes].concat())
        })?;
        let text = document.source.text();
        let has_comments =
            if text.trim_start().starts_with('<') { text.contains("<!--") } else { has_comments(text) };
        let comments = has_comments.then(|| "comments are lost".into());
        let read = document.notes.iter().map(ToString::to_string);
        for note in read.chain(notes).chain(comments) {
            progress::note(&note, self.quiet);
        }
        progress::written(&self.output, started, self.quiet);
        Ok(0)
    }

    /// Leaves out what is not to be converted. Returns a note if that was not asked for: as a mesh, an object that encloses all others
    /// would hide them.
    fn leave_out_hidden(&self, scene: &mut Scene) -> Result<Vec<String>, Failure> {
        let is_chosen = !self.hide.is_empty() || !self.only.is_empty();
        let keeps_nesting = Format::of_file(&self.output).is_none_or(Format::keeps_nesting);
        let mut notes = Vec::new();
        let hidden = if is_chosen || self.tolerance.is_none() || keeps_nesting {
            hidden_by_name(scene, &self.hide, &self.only)?
        } else {
            if !scene.enclosures().is_empty() {
                let names = enclosures_in_words(scene);
                notes.push(format!(
                    "{names} is left out, for it encloses the other objects; --only NAME converts it"
                ));
            }
            scene.hiding_enclosures()
        };
        if !hidden.is_empty() {
            *scene = scene.without(&hidden);
            let all = std::mem::take(&mut scene.objects);
            scene.objects = all.into_iter().filter(|root| !hidden.is_all_of(scene, *root)).collect();
        }
        Ok(notes)
    }

    /// The scene, with its solids as meshes if a tolerance is given, and what was made.
    fn tessellated<'d>(
        &self,
        document: &'d Document,
        cancel: &'static AtomicBool,
    ) -> Result<(Cow<'d, Scene>, Vec<String>), Failure> {
        let Some(tolerance) = self.tolerance else { return Ok((Cow::Borrowed(&document.scene), Vec::new())) };
        let run = Run { threads: self.threads.threads, cancel: Some(cancel), ..Run::default() };
        let bar = progress::spinner("meshes", self.quiet);
        let found = tessellate(&document.scene, &Settings::new(tolerance), run, &mut |progress| {
            let Progress { object, cells, triangles, deviation } = progress;
            let [cells, triangles] = [*cells, *triangles].map(|count| grouped(count as u64));
            bar.set_message(format!(
                "'{object}': {cells} cells, {triangles} triangles, within {}",
                significant(*deviation, 2)
            ));
        });
        bar.finish_and_clear();
        let found = found.map_err(|error| match error {
            TessellateError::Batch(BatchError::Cancelled) => Failure::Interrupted,
            TessellateError::Tolerance(_) => Failure::new(format!("--tolerance: {error}")),
            TessellateError::Unbounded { ref object } => {
                let help = format!("help: --hide '{object}' leaves it out");
                Failure::of_input(&self.model.path, format!("{error}\n{help}"))
            }
            error => Failure::of_input(&self.model.path, error),
        })?;
        let told = |part: &Part| {
            let (triangles, deviation) =
                (counted(part.triangles as u64, "triangle", "triangles"), significant(part.deviation, 2));
            format!("'{}' became a mesh of {triangles}, within {deviation}", part.object)
        };
        let empty = found.empty.iter().map(|name| format!("'{name}' is empty and has no mesh"));
        let mut notes: Vec<String> = found.parts.iter().map(told).chain(empty).collect();
        if found.scene.objects.is_empty() {
            let why = if notes.is_empty() { "the scene has no objects".into() } else { notes.join("\n") };
            return Err(Failure::of_input(&self.model.path, format!("there is nothing to convert: {why}")));
        }
        let contains = |node: &Node| matches!(node, Node::Object { contents, .. } if !contents.is_empty());
        if document.scene.nodes.iter().any(contains) {
            notes.push("what objects contain is not cut out of their meshes".into());
        }
        Ok((Cow::Owned(found.scene), notes))
    }

    /// Writes the scene and returns notes for the user. On standard output a scene is written as text.
    fn save(&self, scene: &Scene) -> Result<Vec<String>, Failure> {
        if !stream::is_stream(&self.output) {
            return save(&self.output, scene).map_err(|e| self.failure(&e));
        }
        if scene.nodes.iter().any(|node| matches!(node, Node::Mesh { .. })) {
            let why = "stdout can receive one file, and the meshes of this scene are files of their own";
            return Err(Failure::new(format!("{why}\nhelp: name a file to write to")));
        }
        output::write(&self.output, write_scene(scene).map_err(|e| self.failure(&e))?.as_bytes())?;
        Ok(Vec::new())
    }

    fn failure(&self, error: &WriteError) -> Failure {
        match error {
            WriteError::Unwritable(_) => {
                let help = match self.tolerance {
                    None => {
                        "write a scene, which keeps everything: a file with the extension .json; or make solids into meshes with --tolerance"
                    }
                    Some(_) => {
                        "write a scene, which keeps everything: a file with the extension .json; or leave out objects with --hide or --only"
                    }
                };
                Failure::of_file(&self.output, format!("{error}\nhelp: {help}"))
            }
            error => Failure::new(error.to_string()),
        }
    }
}

/// Whether the text of a scene has comments. It is valid JSON but for these, so a slash outside of strings is one.
fn has_comments(text: &str) -> bool {
    let (mut in_string, mut escaped) = (false, false);
    text.chars().any(|c| {
        match c {
            _ if escaped => escaped = false,
            '\\' if in_string => escaped = true,
            '"' => in_string = !in_string,
            _ => return c == '/' && !in_string,
        }
        false
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_are_found_outside_of_strings() {
        assert!(has_comments("{} // here") && has_comments(r#"{"a\\": /* b */ 1}"#));
        assert!(!has_comments(r#"{"//": "a\"//b", "c": "/"}"#) && !has_comments(""));
    }
}
