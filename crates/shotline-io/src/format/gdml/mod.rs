//! GDML, the geometry files of Geant4 and ROOT, read and written with the meaning that Geant4 gives them. See `docs/gdml.md`.
//!
//! A volume becomes an object that contains the objects placed in it, with `clip`; a placement becomes a transform, whose label
//! is the name and copy number of the physical volume. Lengths are in millimetres.

mod attributes;
mod booleans;
mod chemical_elements;
mod copies;
mod definitions;
mod expression;
mod geant4_materials;
mod materials;
mod placements;
mod primitives;
mod profiles;
mod solids;
mod structure;
mod tessellated;
mod texts;
mod trapezoids;
mod units;
mod write;

use std::collections::{BTreeMap, HashMap};
use std::ops::Range;
use std::path::{Path, PathBuf};

use shotline::scene::{Node, NodeId, Scene, Units};

use self::attributes::Reported;
use self::definitions::Definitions;
use self::materials::Substances;
use self::texts::{Text, place_of, place_of_attribute, read_texts, with_tree};
use crate::diagnostic::{Diagnostics, RawDiagnostic};
use crate::document::{Document, Included, Source};
use crate::error::ReadError;
use crate::format::{Content, Format, MeshSource};
use crate::note::{Effect, Note};
use crate::options::ReadOptions;
use crate::paths::folder_of;
use crate::suggest;

pub(crate) const FORMAT: Format = Format {
    name: "GDML",
    extensions: &["gdml"],
    detect: |bytes| {
        let start = &bytes[..bytes.len().min(4096)];
        start.trim_ascii_start().starts_with(b"<") && start.windows(5).any(|word| word == b"<gdml")
    },
    content: Content::Scene {
        read,
        write: |_, scene| write::write(scene),
        holds_meshes: true,
        keeps_nesting: true,
        max_bytes: MAX_BYTES,
        has_setups: true,
    },
};

/// The largest file that is read, in bytes.
const MAX_BYTES: u64 = 256 << 20;

/// The largest number of times that the loops of a file run, and of copies that it makes of volumes.
const MAX_COPIES: usize = 4_000_000;

/// An element of the tree.
type Element<'a> = roxmltree::Node<'a, 'a>;

/// The name of an element.
fn tag<'a>(element: Element<'a>) -> &'a str {
    element.tag_name().name()
}

/// The elements directly below.
fn elements(element: Element) -> impl Iterator<Item = Element> {
    element.children().filter(|child| child.is_element())
}

/// What all files of a model share.
struct Reader {
    scene: Scene,
    spans: Vec<Range<usize>>,
    text_of: Vec<u32>,
    /// The texts of all files, with those being read still empty.
    texts: Vec<(PathBuf, String)>,
    found: Vec<(usize, RawDiagnostic)>,
    unlisted: usize,
    /// What is not supported: how many times, and the first.
    unsupported: BTreeMap<String, (usize, usize, Range<usize>)>,
    notes: Vec<Note>,
    options: ReadOptions,
    folder: PathBuf,
    /// The modules that are being read, the outermost first.
    open: Vec<PathBuf>,
    /// The modules that have been read; `None` for one that cannot be.
    modules: HashMap<PathBuf, Option<Volumes>>,
    /// How many more copies of volumes may be made.
    copies: usize,
}

/// The volumes of a file by name: objects, or groups for assemblies. `None` for what has been reported.
#[derive(Clone, Default)]
struct Volumes {
    by_name: HashMap<String, Option<NodeId>>,
    /// The worlds of its setups, by the names of the setups.
    worlds: Vec<(String, Option<NodeId>)>,
}

impl Volumes {
    /// The name and the world of the default setup, or else of the first one.
    fn world(&self) -> Option<&(String, Option<NodeId>)> {
        self.world_of("Default").or(self.worlds.first())
    }

    fn world_of(&self, setup: &str) -> Option<&(String, Option<NodeId>)> {
        self.worlds.iter().find(|(name, _)| name == setup)
    }

    /// As [`Volumes::world`], of the setup that is chosen if one is.
    fn chosen(&self, options: &ReadOptions) -> Option<&(String, Option<NodeId>)> {
        match &options.setup {
            Some(setup) => self.world_of(setup),
            None => self.world(),
        }
    }
}

/// One file while it is read.
struct Module<'r> {
    reader: &'r mut Reader,
    texts: &'r [Text],
    /// The number of its first text among those of the reader.
    first_text: usize,
    definitions: Definitions,
    substances: Substances,
    solids: HashMap<String, Option<NodeId>>,
    volumes: Volumes,
    /// How many loops are around the element that is being read.
    loops: usize,
    /// The attributes that have other names in the element that is being read, with these names.
    renamed: &'static [(&'static str, &'static str)],
}

fn read(path: &Path, bytes: Vec<u8>, meshes: MeshSource) -> Result<Document, ReadError> {
    let options = match meshes {
        MeshSource::Files { options, .. } => options.clone(),
        MeshSource::Given(_) => ReadOptions::default(),
    };
    let folder = folder_of(path).to_path_buf();
    let texts = read_texts(Text::of(path, bytes)?, &folder, options.paths)?;
    let mut reader = Reader {
        scene: Scene { units: Some(Units::Millimetres), ..Scene::default() },
        spans: Vec::new(),
        text_of: Vec::new(),
        texts: Vec::new(),
        found: Vec::new(),
        unlisted: 0,
        unsupported: BTreeMap::new(),
        notes: Vec::new(),
        options,
        folder,
        open: Vec::new(),
        modules: HashMap::new(),
        copies: MAX_COPIES,
    };
    let volumes = reader.module(texts, true)?;
    if let Some(world) = reader.world(&volumes) {
        reader.scene.objects.push(world);
    }
    reader.finish()
}

impl Reader {
    /// Reads a file of the model.
    fn module(&mut self, texts: Vec<Text>, is_main: bool) -> Result<Volumes, ReadError> {
        let first_text = self.texts.len();
        self.texts.extend(texts.iter().map(|text| (text.path.clone(), String::new())));
        let volumes = with_tree(&texts, |tree| {
            let mut module = Module {
                reader: self,
                texts: &texts,
                first_text,
                definitions: Definitions::default(),
                substances: Substances::default(),
                solids: HashMap::new(),
                volumes: Volumes::default(),
                loops: 0,
                renamed: &[],
            };
            module.read(tree.root_element(), is_main);
            module.volumes
        });
        for (number, text) in (first_text..).zip(texts) {
            self.texts[number].1 = text.text;
        }
        volumes
    }

    /// The world of the model.
    fn world(&mut self, volumes: &Volumes) -> Option<NodeId> {
        let chosen = volumes.chosen(&self.options);
        if let (None, Some(setup)) = (chosen, &self.options.setup)
            && !volumes.worlds.is_empty()
        {
            let names: Vec<_> = volumes.worlds.iter().map(|(name, _)| name.as_str()).collect();
            let diagnostic = RawDiagnostic::file(format!("there is no setup '{setup}'"));
            self.found.push((0, diagnostic.help(suggest::hint(setup, &names))));
        } else if chosen.is_none() && self.found.is_empty() {
            let message = "the file has no setup, which names the world volume";
            let help =
                "add <setup name=\"Default\" version=\"1.0\"><world ref=\"...\"/></setup> before </gdml>";
            self.found.push((0, RawDiagnostic::file(message).help(help)));
        }
        let is_guessed = self.options.setup.is_none() && volumes.worlds.len() > 1;
        if let (Some((name, _)), true) = (chosen, is_guessed) {
            let text = format!(
                "of {} setups, '{name}' was read; --setup (in Python setup=) reads another",
                volumes.worlds.len()
            );
            self.notes.push(Note::new("setups", Effect::Changed, volumes.worlds.len(), text));
        }
        chosen.and_then(|(_, world)| *world)
    }

    fn finish(mut self) -> Result<Document, ReadError> {
        for (what, (count, text, range)) in std::mem::take(&mut self.unsupported) {
            let (is, the) = if count == 1 { ("is", "it") } else { ("are", "the first") };
            let message = format!("{count} of {what} {is} not supported; {the} stands here");
            if self.options.partial {
                let (path, source) = &self.texts[text];
                let line = crate::lines::line_at(source.as_bytes(), range.start);
                let note =
                    Note::new("unsupported", Effect::Changed, count, format!("{count} of {what} left out"));
                let first = Some(crate::note::Spot::Line(line));
                self.notes.push(Note { first, ..note.of_file(path.display().to_string()) });
            } else {
                let help = "--partial (in Python partial=True) reads the rest without it";
                self.push(text, RawDiagnostic::text(range, message).help(help));
            }
        }
        let texts: Vec<_> = self.texts.iter().map(|(path, text)| (path.as_path(), text.as_str())).collect();
        if !self.found.is_empty() {
            return Err(ReadError::of_texts(&texts, self.found, self.unlisted));
        }
        let (path, text) = self.texts.remove(0);
        let included = Included { texts: self.texts, text_of: self.text_of };
        let source = Source::including(&path, text, self.spans, included);
        Ok(Document { scene: self.scene, notes: self.notes, source })
    }

    /// How much has been reported so far.
    fn reported(&self) -> usize {
        self.found.len() + self.unlisted + self.unsupported.len()
    }

    fn push(&mut self, text: usize, diagnostic: RawDiagnostic) {
        if self.found.len() < Diagnostics::MAX_LISTED {
            self.found.push((text, diagnostic));
        } else {
            self.unlisted += 1;
        }
    }
}

impl Module<'_> {
    /// Reads the sections of a file, each of which may refer to those before.
    fn read(&mut self, root: Element, is_main: bool) {
        if tag(root) != "gdml" {
            let message = format!("the root element is <{}>, not <gdml>", tag(root));
            self.report(root, None, message, "this is no GDML file");
            return;
        }
        let mut setups = Vec::new();
        for section in elements(root) {
            match tag(section) {
                "define" => self.define(section),
                "materials" => self.materials(section),
                "solids" => self.solids(section),
                "structure" => self.structure(section),
                "setup" => setups.push(section),
                "userinfo" | "extension" => {}
                other => {
                    let message = format!("<{other}> is no section of a GDML file");
                    let help = "the sections are define, materials, solids, structure and setup";
                    self.report(section, None, message, help);
                }
            }
        }
        for setup in setups {
            let world = elements(setup).find(|child| tag(*child) == "world");
            let world = match world {
                Some(world) => self.volume_of(world),
                None => Err(self.report(setup, None, "the setup has no <world>", "add <world ref=\"...\"/>")),
            };
            let name = setup.attribute("name").unwrap_or("Default").to_owned();
            self.volumes.worlds.push((name, world.ok().flatten()));
        }
        if is_main && let Some((_, Some(world))) = self.volumes.chosen(&self.reader.options) {
            let is_object = matches!(self.reader.scene.node(*world), Node::Object { .. });
            if !is_object {
                self.report(root, None, "the world is an assembly", "name a volume that has a solid");
            }
        }
    }

    /// Reports what is wrong with an element, or with one of its attributes.
    fn report(
        &mut self,
        element: Element,
        attribute: Option<&str>,
        message: impl Into<String>,
        help: impl Into<String>,
    ) -> Reported {
        let (number, range) = place_of_attribute(self.texts, element, attribute.unwrap_or_default());
        let diagnostic = RawDiagnostic::text(range, message).help(help);
        self.reader.push(self.first_text + number, diagnostic);
        Reported
    }

    /// Counts something that is not supported.
    fn unsupported(&mut self, element: Element, what: impl Into<String>) -> Reported {
        let (number, range) = place_of_attribute(self.texts, element, "");
        let first = (0, self.first_text + number, range);
        self.reader.unsupported.entry(what.into()).or_insert(first).0 += 1;
        Reported
    }

    /// Adds a node that an element describes.
    fn add(&mut self, element: Element, node: Node) -> NodeId {
        let (number, range) = place_of(self.texts, element);
        self.reader.spans.push(range);
        self.reader.text_of.push((self.first_text + number) as u32);
        self.reader.scene.add(node)
    }

    /// Counts copies that an element makes, and refuses more than memory may hold.
    fn count_copies(&mut self, element: Element, count: usize) -> Result<(), Reported> {
        match self.reader.copies.checked_sub(count) {
            Some(left) => {
                self.reader.copies = left;
                Ok(())
            }
            None => {
                let message = format!("the loops and copies of this model are more than {MAX_COPIES}");
                Err(self.report(element, None, message, "check the bounds of the loop"))
            }
        }
    }
}
