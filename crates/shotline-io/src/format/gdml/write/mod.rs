//! A scene to the text of a GDML file. See `docs/gdml.md`.
//!
//! An object becomes a volume with its solid, and what it contains is placed in it. Geant4 centres solids on their axes; where the
//! scene does not, the frame of the volume is that of the solid, and its placements make up for it.

mod curved;
mod kinds;
mod materials;
mod meshes;
mod names;
mod placements;
mod profiles;
mod report;
mod shapes;
mod structure;
mod trapezoids;
mod traversal;
mod volumes;
mod world;
mod xml;

use std::collections::HashMap;

use shotline::scene::{NodeId, Scene};

use self::names::Names;
use self::report::Report;
use self::shapes::Shape;
use self::structure::Structure;
use self::volumes::{Volume, VolumeKey};
use self::xml::Xml;
use crate::error::WriteError;
use crate::format::WrittenScene;

/// The writer, with the sections of the file so far.
struct Writer<'s> {
    scene: &'s Scene,
    structure: Structure,
    report: Report,
    /// The names of all that is not a volume, and those that objects and materials want.
    names: Names,
    volume_names: Names,
    material_names: Names,
    /// Names of materials in the file, by their names in the scene; `None` for that of objects without one.
    materials: HashMap<Option<&'s str>, String>,
    shapes: HashMap<NodeId, Shape>,
    volumes: HashMap<VolumeKey, Volume>,
    /// The name of the object that is being written.
    object: String,
    define: String,
    materials_text: String,
    solids: String,
    volumes_text: String,
}

/// The largest number of cells of lattices, each of which is written as a placement.
const MAX_CELLS: u64 = 1 << 20;

/// Writes a scene, with notes on what is lost.
pub(super) fn write(scene: &Scene) -> Result<WrittenScene, WriteError> {
    let Some(scene) = &scene.with_lattices_listed(MAX_CELLS) else {
        return Err(WriteError::Unwritable(format!(
            "each cell of a lattice is written as a placement, and the scene has more than {MAX_CELLS}"
        )));
    };
    let Some(structure) = Structure::of(scene) else {
        return Err(WriteError::Unwritable(
            "the scene has a node that contains itself, or one that does not exist".into(),
        ));
    };
    let mut writer = Writer {
        scene,
        structure,
        report: Report::default(),
        names: Names::default(),
        volume_names: Names::default(),
        material_names: Names::default(),
        materials: HashMap::new(),
        shapes: HashMap::new(),
        volumes: HashMap::new(),
        object: String::new(),
        define: String::new(),
        materials_text: String::new(),
        solids: String::new(),
        volumes_text: String::new(),
    };
    writer.reserve_names();
    writer.write_materials();
    let world = writer.world();
    writer.note_losses();
    let world = world.ok().unwrap_or_default();
    let bytes = writer.document(&world).into_bytes();
    Ok(WrittenScene { bytes, notes: writer.report.finish()? })
}

impl Writer<'_> {
    /// Keeps the names of volumes and materials from solids and positions: names must differ in all of a file.
    fn reserve_names(&mut self) {
        for (name, _) in &self.scene.materials {
            self.names.reserve(names::as_xml_name(name));
        }
        for name in self.structure.object_names(self.scene) {
            self.names.reserve(names::as_xml_name(name));
        }
    }

    /// A name of XML for something of the scene; a change is noted.
    fn xml_name(&mut self, name: &str) -> String {
        let found = names::as_xml_name(name);
        if found != name {
            self.report.lose("names that are no names of XML were changed", name);
        }
        found
    }

    /// Refuses the object that is being written if a number of an element cannot be written.
    fn check(&mut self, element: &Xml) {
        if element.is_broken() {
            self.refuse(
                "a length is no float64 in millimetres: it is too large, or so small that it would be 0",
            );
        }
    }

    /// An element of a section.
    fn element(&self, tag: &'static str) -> Xml {
        Xml::new(tag, self.structure.millimetres)
    }

    fn note_losses(&mut self) {
        let scene = self.scene;
        match scene.units {
            None => self.report.note("the scene has no units: its lengths are written as millimetres".into()),
            Some(units) if self.structure.millimetres != 1.0 => {
                self.report.note(format!("lengths in {units} are written in mm"));
            }
            Some(_) => {}
        }
        if scene.camera.is_some() || !scene.lights.is_empty() || !scene.motions.is_empty() {
            self.report.note("the camera, the lights and the motions are lost".into());
        }
        let has_looks = |material: &shotline::scene::Material| {
            let shotline::scene::Material { mu, color, specular, shininess, mirror, .. } = material;
            [mu, specular, shininess, mirror].iter().any(|x| x.is_some()) || color.is_some()
        };
        if scene.materials.iter().any(|(_, material)| has_looks(material)) {
            self.report.note("the colours and the attenuation coefficients of materials are lost".into());
        }
    }

    fn document(&self, world: &str) -> String {
        let section = |tag: &str, text: &str| match text.is_empty() {
            true => format!("  <{tag}/>\n"),
            false => format!("  <{tag}>\n{text}  </{tag}>\n"),
        };
        let mut setup = String::new();
        self.element("world").text("ref", world).write(&mut setup);
        [
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
             <gdml xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" \
             xsi:noNamespaceSchemaLocation=\"http://cern.ch/service-spi/app/releases/GDML/schema/gdml.xsd\">\n",
            &section("define", &self.define),
            &section("materials", &self.materials_text),
            &section("solids", &self.solids),
            &section("structure", &self.volumes_text),
            "  <setup name=\"Default\" version=\"1.0\">\n",
            &setup,
            "  </setup>\n</gdml>\n",
        ]
        .concat()
    }
}
