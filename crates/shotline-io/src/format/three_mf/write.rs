//! A scene to 3MF: an object for each object of the scene with its mesh, and an item of the build for each of its placements.

use std::collections::HashMap;
use std::fmt::Write;
use std::path::Path;
use std::sync::Arc;

use shotline::math::{Affine, ComposedTransform, Vec3};
use shotline::scene::{NodeId, Scene, Units};
use shotline::solid::mesh::{Topology, TriangleMesh};

use super::model::UNITS;
use super::package::pack;
use crate::error::WriteError;
use crate::format::WrittenScene;
use crate::format::instances::{Instance, instances, used_vertices};

const CORE: &str = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02";

/// The id of the group of materials. Objects follow.
const MATERIALS: usize = 1;

/// The colour of a material without one: each needs a colour.
const WHITE: [f64; 3] = [1.0; 3];

/// The writer, with the sections of the file so far.
#[derive(Default)]
struct Writer<'s> {
    materials: String,
    material_numbers: HashMap<&'s str, usize>,
    objects: String,
    items: String,
    /// The ids of objects, by their node and their mesh.
    ids: HashMap<(NodeId, *const TriangleMesh), usize>,
    /// How many materials have no colour, and how many have one that is between two of 256 steps.
    colorless: usize,
    stepped: usize,
    /// How many triangles were left out.
    flat: usize,
}

/// Writes a package.
pub(super) fn write(_: &Path, scene: &Scene) -> Result<WrittenScene, WriteError> {
    let (objects, mut notes) = instances(scene, "3MF")?;
    let (unit, scale, unit_note) = unit(scene.units);
    let mut writer = Writer::default();
    scene.materials.iter().for_each(|(name, material)| writer.add_material(name, material.color));
    for object in &objects {
        writer.add(object, scale)?;
    }
    notes.extend(unit_note);
    notes.extend(writer.notes());
    Ok(WrittenScene { bytes: pack(&writer.model(unit))?, notes })
}

/// The unit of the file, how many of it are one unit of the scene, and a note if these differ.
fn unit(units: Option<Units>) -> (&'static str, f64, Option<String>) {
    let scaled = |unit, scale, what: &str| {
        (
            unit,
            scale,
            Some(format!("3MF has no unit of {what}: the items of the build are scaled to {unit}s")),
        )
    };
    match units {
        None => {
            let note = "the scene has no units: its lengths are written as millimetres";
            ("millimeter", 1.0, Some(note.into()))
        }
        Some(Units::Nanometres) => scaled("micron", 1e-3, "nanometres"),
        Some(Units::Kilometres) => scaled("meter", 1e3, "kilometres"),
        Some(units) => {
            let name =
                UNITS.iter().find(|(_, known)| *known == units).map_or("millimeter", |(name, _)| *name);
            (name, 1.0, None)
        }
    }
}

impl<'s> Writer<'s> {
    fn add_material(&mut self, name: &'s str, color: Option<[f64; 3]>) {
        let steps = color.unwrap_or(WHITE).map(|x| x.clamp(0.0, 1.0) * 255.0);
        self.colorless += usize::from(color.is_none());
        self.stepped += usize::from(steps.iter().any(|x| (x.round() - x).abs() > 1e-9));
        let digits = steps.map(|x| format!("{:02X}", x.round() as u8)).concat();
        self.material_numbers.insert(name, self.material_numbers.len());
        let name = attribute(name);
        // Writing to a string cannot fail.
        let _ = writeln!(self.materials, "<base name=\"{name}\" displaycolor=\"#{digits}\"/>");
    }

    fn add(&mut self, object: &Instance<'s>, scale: f64) -> Result<(), WriteError> {
        let material = object.material.map(|name| {
            if !self.material_numbers.contains_key(name) {
                self.add_material(name, None);
            }
            self.material_numbers[name]
        });
        let key = (object.id, Arc::as_ptr(&object.mesh));
        let id = match self.ids.get(&key) {
            Some(known) => *known,
            None => {
                let id = MATERIALS + 1 + self.ids.len();
                self.ids.insert(key, id);
                self.add_object(id, object, material)?;
                id
            }
        };
        let placed = match scale {
            1.0 => object.world_from_local,
            scale => {
                let scaled = ComposedTransform::IDENTITY.then(&Affine::scaling(Vec3::splat(scale)));
                let placement = scaled.then(&object.world_from_local).placement();
                placement.map_err(|error| WriteError::Unwritable(error.to_string()))?.parent_from_local
            }
        };
        let _ = write!(self.items, "<item objectid=\"{id}\"");
        if !placed.is_identity() {
            let _ = write!(self.items, " transform=\"{}\"", transform(&placed));
        }
        self.items.push_str("/>\n");
        Ok(())
    }

    fn add_object(
        &mut self,
        id: usize,
        object: &Instance,
        material: Option<usize>,
    ) -> Result<(), WriteError> {
        let (vertices, faces) = used_vertices(&object.mesh);
        if let Some(vertex) = vertices.iter().find(|vertex| !vertex.is_finite()) {
            let message = format!("object '{}' has a vertex that is not finite: {vertex}", object.name);
            return Err(WriteError::Unwritable(message));
        }
        let is_closed = Topology::of(&object.mesh).is_ok_and(|topology| topology.is_closed());
        let kind = if is_closed { "model" } else { "surface" };
        let out = &mut self.objects;
        let _ = write!(out, "<object id=\"{id}\" type=\"{kind}\" name=\"{}\"", attribute(object.name));
        if let Some(material) = material {
            let _ = write!(out, " pid=\"{MATERIALS}\" pindex=\"{material}\"");
        }
        out.push_str("><mesh><vertices>\n");
        for Vec3 { x, y, z } in vertices {
            let _ = writeln!(out, "<vertex x=\"{x:?}\" y=\"{y:?}\" z=\"{z:?}\"/>");
        }
        out.push_str("</vertices><triangles>\n");
        for [a, b, c] in faces {
            // The format forbids them. Their edges cancel out, so closed meshes stay closed.
            if a == b || b == c || c == a {
                self.flat += 1;
                continue;
            }
            let _ = writeln!(out, "<triangle v1=\"{a}\" v2=\"{b}\" v3=\"{c}\"/>");
        }
        out.push_str("</triangles></mesh></object>\n");
        Ok(())
    }

    fn notes(&self) -> Vec<String> {
        let counted = [
            (self.colorless, "materials without a colour became white"),
            (self.stepped, "colours of materials were rounded to 256 steps"),
            (self.flat, "triangles with two corners at one vertex were left out"),
        ];
        let told = counted.into_iter().filter(|(count, _)| *count > 0);
        told.map(|(count, what)| format!("{what}: {count}")).collect()
    }

    /// The text of the model.
    fn model(&self, unit: &str) -> String {
        let mut out = format!(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<model unit=\"{unit}\" xml:lang=\"en-US\" xmlns=\"{CORE}\">\n\
             <metadata name=\"Application\">shotline</metadata>\n<resources>\n"
        );
        if !self.materials.is_empty() {
            let materials = &self.materials;
            let _ = writeln!(out, "<basematerials id=\"{MATERIALS}\">\n{materials}</basematerials>");
        }
        out + &self.objects + "</resources>\n<build>\n" + &self.items + "</build>\n</model>\n"
    }
}

/// The 12 numbers of a transform of rows: the images of the axes, and the shift.
fn transform(affine: &Affine) -> String {
    let number = |i: usize| format!("{:?}", affine.rows[i % 3][i / 3]);
    (0..12).map(number).collect::<Vec<_>>().join(" ")
}

/// A value of an attribute. Characters that XML cannot hold become underscores.
fn attribute(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\t' | '\n' | '\r' => {
                let _ = write!(out, "&#{};", u32::from(c));
            }
            '\0'..' ' | '\u{fffe}' | '\u{ffff}' => out.push('_'),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn attributes_hold_any_text() {
        assert_eq!(attribute("a \"<&>\"\n\u{1}ß"), "a &quot;&lt;&amp;&gt;&quot;&#10;_ß");
    }

    #[test]
    fn rows_are_written_as_columns() {
        let affine = Affine { rows: [[1.0, 2.0, 3.0, 4.0], [5.0, 6.0, 7.0, 8.0], [9.0, 10.0, 11.0, 0.1]] };
        assert_eq!(transform(&affine), "1.0 5.0 9.0 2.0 6.0 10.0 3.0 7.0 11.0 4.0 8.0 0.1");
    }
}
