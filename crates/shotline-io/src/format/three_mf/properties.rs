//! Properties: base materials and colours, which objects and triangles name by a group and an index.

use std::collections::HashMap;

use shotline::scene::Material;

use super::elements::{Element, Found, color, elements, error, required_whole, tag};
use crate::diagnostic::RawDiagnostic;

/// A property of a triangle's corner, or of an object: its group and its index.
pub(super) type Property = (u32, u32);

/// A value of a group.
#[derive(Clone, Debug)]
struct Entry {
    name: Option<String>,
    color: [f64; 4],
}

/// The groups of a model by their ids; `None` for those that are not read, such as textures.
#[derive(Debug, Default)]
pub(super) struct Groups(HashMap<u32, Option<Vec<Entry>>>);

impl Groups {
    /// Takes over a resource if it is a group; tells whether it is one that is read, or none.
    pub(super) fn add(&mut self, element: Element) -> Found<Option<bool>> {
        let (entry, value, named) = match tag(element) {
            "basematerials" => ("base", "displaycolor", true),
            "colorgroup" => ("color", "color", false),
            "texture2dgroup" | "compositematerials" | "multiproperties" => {
                self.insert(element, None)?;
                return Ok(Some(false));
            }
            _ => return Ok(None),
        };
        let mut entries = Vec::new();
        for child in elements(element).filter(|child| tag(*child) == entry) {
            let name = child.attribute("name").filter(|name| named && !name.is_empty());
            entries.push(Entry { name: name.map(str::to_owned), color: color(child, value)? });
        }
        self.insert(element, Some(entries))?;
        Ok(Some(true))
    }

    fn insert(&mut self, element: Element, entries: Option<Vec<Entry>>) -> Found<()> {
        let id = required_whole(element, "id")?;
        match self.0.insert(id, entries) {
            None => Ok(()),
            Some(_) => Err(error(element, "id", format!("there are two groups of properties {id}"))),
        }
    }

    /// The colour of a property; `None` if its group is not read.
    pub(super) fn color(&self, property: Property, at: Place) -> Found<Option<[f64; 4]>> {
        Ok(self.entry(property, at)?.map(|entry| entry.color))
    }

    /// The name of a property and a material of its colour; `None` if its group is not read.
    pub(super) fn material(&self, property: Property, at: Place) -> Found<Option<(String, Material)>> {
        let Some(entry) = self.entry(property, at)? else { return Ok(None) };
        let [red, green, blue, _] = entry.color;
        let digits = [red, green, blue].map(|x| format!("{:02X}", (x * 255.0).round() as u8)).concat();
        let name = entry.name.clone().unwrap_or_else(|| format!("#{digits}"));
        Ok(Some((name, Material { color: Some([red, green, blue]), ..Material::default() })))
    }

    fn entry(&self, (group, index): Property, at: Place) -> Found<Option<&Entry>> {
        let Some(entries) = self.0.get(&group) else {
            return Err(at.error("pid", format!("there is no group of properties {group} before this")));
        };
        let Some(entries) = entries else { return Ok(None) };
        let message =
            || format!("group {group} has {} properties; there is none of index {index}", entries.len());
        entries.get(index as usize).map(Some).ok_or_else(|| at.error(at.index, message()))
    }
}

/// The element that names a property, and the attribute with its index.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place<'a> {
    pub(super) element: Element<'a>,
    pub(super) index: &'static str,
}

impl Place<'_> {
    fn error(&self, attribute: &str, message: String) -> RawDiagnostic {
        error(self.element, attribute, message)
    }
}
