//! One model part: its objects and what it builds, as plain data.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

use shotline::math::Affine;
use shotline::scene::{Material, Units};
use shotline::solid::mesh::TriangleMesh;

use super::elements::{
    Element, Found, PRODUCTION, child, elements, error, required, required_whole, tag, transform, whole,
};
use super::meshes;
use super::properties::{Groups, Place};
use crate::location::RawLocation;
use crate::note::{Effect, NoteKind, Notes};
use crate::suggest;
use crate::xml::start_tag;

/// The extensions that a model may require: properties, several models, and sets of triangles, which say nothing of shapes.
const KNOWN: [&str; 3] = [
    "http://schemas.microsoft.com/3dmanufacturing/material/2015/02",
    PRODUCTION,
    "http://schemas.microsoft.com/3dmanufacturing/trianglesets/2021/07",
];

/// The units of length of 3MF.
pub(super) const UNITS: [(&str, Units); 6] = [
    ("micron", Units::Micrometres),
    ("millimeter", Units::Millimetres),
    ("centimeter", Units::Centimetres),
    ("inch", Units::Inches),
    ("foot", Units::Feet),
    ("meter", Units::Metres),
];

const RESOURCES: NoteKind = NoteKind {
    name: "resources_not_read",
    effect: Effect::Kept,
    one: "1 resource besides objects, base materials and groups of colours was not read",
    many: "# resources besides objects, base materials and groups of colours were not read",
};

/// An object by the number of its model part and its id.
pub(super) type ObjectKey = (usize, u32);

/// An object or a part of one that is placed.
#[derive(Clone, Debug)]
pub(super) struct Placed {
    pub(super) object: ObjectKey,
    pub(super) transform: Option<Affine>,
    pub(super) range: Range<usize>,
}

/// What an object is.
#[derive(Clone, Debug)]
pub(super) enum Shape {
    Mesh { mesh: Arc<TriangleMesh>, material: Option<(String, Material)> },
    Components(Vec<Placed>),
}

/// An object.
#[derive(Clone, Debug)]
pub(super) struct Object {
    pub(super) name: Option<String>,
    pub(super) shape: Shape,
    pub(super) range: Range<usize>,
    /// Whether it is a part of the model, and not a support for printing it.
    pub(super) is_model: bool,
}

/// A model part.
#[derive(Debug, Default)]
pub(super) struct Model {
    pub(super) units: Option<Units>,
    pub(super) objects: HashMap<u32, Object>,
    pub(super) items: Vec<Placed>,
}

/// Reads a model part of this number. `part` gives the number of another part by its path.
pub(super) fn read(
    root: Element,
    number: usize,
    part: &mut dyn FnMut(&str) -> usize,
    notes: &mut Notes,
) -> Found<Model> {
    if tag(root) != "model" {
        return Err(error(root, "", format!("the root element is <{}>, not <model>", tag(root))));
    }
    check_extensions(root)?;
    let mut model = Model { units: Some(units(root)?), ..Model::default() };
    let resources = child(root, "resources")
        .ok_or_else(|| error(root, "", "the model has no <resources>").help("they hold its objects"))?;
    let mut groups = Groups::default();
    for resource in elements(resources) {
        if tag(resource) == "object" {
            let id = required_whole(resource, "id")?;
            let object = object(resource, id, number, &groups, part, notes)?;
            if model.objects.insert(id, object).is_some() {
                return Err(error(resource, "id", format!("there are two objects {id}")));
            }
        } else if groups.add(resource)? != Some(true) {
            notes.add(&RESOURCES, RawLocation::Text(start_tag(resource)));
        }
    }
    for item in child(root, "build").into_iter().flat_map(elements).filter(|item| tag(*item) == "item") {
        model.items.push(placed(item, number, part)?);
    }
    Ok(model)
}

fn units(root: Element) -> Found<Units> {
    let Some(name) = root.attribute("unit") else { return Ok(Units::Millimetres) };
    let known = UNITS.iter().find(|(known, _)| *known == name);
    known.map(|(_, units)| *units).ok_or_else(|| {
        let names = UNITS.map(|(known, _)| known);
        error(root, "unit", format!("'{name}' is no unit of 3MF")).help(suggest::hint(name, &names))
    })
}

/// Refuses a model that requires what is not known.
fn check_extensions(root: Element) -> Found<()> {
    const NAME: &str = "requiredextensions";
    for prefix in root.attribute(NAME).unwrap_or("").split_ascii_whitespace() {
        let Some(namespace) = root.lookup_namespace_uri(Some(prefix)) else {
            let message = format!("the required extension '{prefix}' is no prefix of a namespace");
            return Err(error(root, NAME, message));
        };
        if !KNOWN.contains(&namespace) {
            let message = format!("the model requires the extension {namespace}, which is not known");
            return Err(error(root, NAME, message).help("export the model without it"));
        }
    }
    Ok(())
}

fn object(
    element: Element,
    id: u32,
    number: usize,
    groups: &Groups,
    part: &mut dyn FnMut(&str) -> usize,
    notes: &mut Notes,
) -> Found<Object> {
    let is_model = match element.attribute("type").unwrap_or("model") {
        "model" | "surface" => true,
        "support" | "solidsupport" | "other" => false,
        kind => {
            let help = "there are model, surface, solidsupport, support and other";
            return Err(error(element, "type", format!("there is no type of object '{kind}'")).help(help));
        }
    };
    let name = element.attribute("name").or(element.attribute("partnumber"));
    let name = name.filter(|name| !name.trim().is_empty()).map(str::to_owned);
    let shape = match (child(element, "mesh"), child(element, "components")) {
        (Some(mesh), None) => {
            let default = match (whole(element, "pid")?, whole(element, "pindex")?) {
                (Some(group), index) => Some((group, index.unwrap_or(0))),
                (None, _) => None,
            };
            let place = Place { element, index: "pindex" };
            if let Some(default) = default {
                groups.color(default, place)?;
            }
            let what = format!("object {id}");
            let meshes::Mesh { mesh, property } = meshes::read(mesh, &what, default, groups, notes)?;
            let material = match property {
                Some(property) => groups.material(property, place)?,
                None => None,
            };
            Shape::Mesh { mesh: Arc::new(mesh), material }
        }
        (None, Some(components)) => {
            let mut parts = Vec::new();
            for component in elements(components).filter(|child| tag(*child) == "component") {
                parts.push(placed(component, number, part)?);
            }
            Shape::Components(parts)
        }
        _ => {
            let message = format!("object {id} must have a <mesh> or <components>, and not both");
            return Err(error(element, "", message));
        }
    };
    Ok(Object { name, shape, range: start_tag(element), is_model })
}

/// An object that a component or an item places: of this model part, or of one that the production extension names.
fn placed(element: Element, number: usize, part: &mut dyn FnMut(&str) -> usize) -> Found<Placed> {
    required(element, "objectid")?;
    let id = required_whole(element, "objectid")?;
    let of_part = element.attribute((PRODUCTION, "path")).map_or(number, part);
    Ok(Placed { object: (of_part, id), transform: transform(element)?, range: start_tag(element) })
}
