//! The names of attributes in a PLY file. Each is read back as an attribute of its own, and most under the same name.

use shotline::solid::mesh::Attribute;

use super::attributes::{self, CORNER, SETS, TEXTURE};
use super::header::{Element, Property, Scalar, Shape};
use crate::unique_names::UniqueNames;

/// The properties of vertices that are their coordinates.
const COORDINATES: [&str; 3] = ["x", "y", "z"];

/// An attribute with the properties that hold it.
pub(super) struct Named<'m> {
    pub(super) attribute: &'m Attribute,
    /// Of vertices one for each number, of corners the one list.
    pub(super) properties: Vec<String>,
    /// The name under which it is read back.
    name: String,
}

/// The attributes of a mesh with their properties.
#[derive(Default)]
pub(super) struct PropertyNames<'m> {
    pub(super) of_vertices: Vec<Named<'m>>,
    pub(super) of_corners: Vec<Named<'m>>,
    /// Which attributes have another name in the file.
    pub(super) note: Option<String>,
}

impl<'m> PropertyNames<'m> {
    pub(super) fn of(attributes: &'m [Attribute]) -> PropertyNames<'m> {
        let mut names = PropertyNames::default();
        let mut taken = UniqueNames::default();
        // The attributes that PLY has properties for come first, then those whose names it holds as they are.
        let mut ordered: Vec<&Attribute> = attributes.iter().collect();
        ordered.sort_by_key(|a| (!is_standard(a), word(&a.name) != a.name));
        for attribute in ordered {
            match attribute.corners {
                Some(_) => names.of_corners.push(of_corners(attribute, &mut taken)),
                None => {
                    let named = of_vertices(attribute, &names.of_vertices, &mut taken);
                    names.of_vertices.push(named);
                }
            }
        }
        names.note = names.changes();
        names
    }

    fn changes(&self) -> Option<String> {
        let all = self.of_vertices.iter().chain(&self.of_corners);
        let changed: Vec<String> = all
            .filter(|named| named.name != named.attribute.name)
            .map(|named| format!("'{}' is '{}'", named.attribute.name, named.name))
            .collect();
        let why = "attributes have other names in the file, because PLY cannot hold these";
        (!changed.is_empty()).then(|| format!("{why}: {}", changed.join(", ")))
    }
}

/// The properties that PLY has for an attribute of vertices.
fn standard(attribute: &Attribute) -> Option<Vec<String>> {
    let known = SETS.iter().find(|(set, set_of)| *set == attribute.name && set_of.len() == attribute.width);
    known.map(|(_, properties)| properties.iter().map(|property| (*property).into()).collect())
}

fn is_standard(attribute: &Attribute) -> bool {
    attribute.corners.is_none() && standard(attribute).is_some()
}

/// A list of faces for an attribute of corners.
fn of_corners<'m>(attribute: &'m Attribute, taken: &mut UniqueNames) -> Named<'m> {
    let name = taken.free(&word(&attribute.name));
    let list = if name == "uv" { TEXTURE.into() } else { format!("{CORNER}{name}") };
    Named { attribute, properties: vec![list], name }
}

/// The properties of an attribute of vertices, beside those of others.
fn of_vertices<'m>(attribute: &'m Attribute, others: &[Named<'m>], taken: &mut UniqueNames) -> Named<'m> {
    loop {
        let name = taken.free(&word(&attribute.name));
        let properties = match standard(attribute) {
            Some(properties) if name == attribute.name => properties,
            _ if attribute.width == 1 => vec![name.clone()],
            _ => (0..attribute.width).map(|i| format!("{name}_{i}")).collect(),
        };
        let named = Named { attribute, properties, name };
        if are_read_back(others, &named) {
            return named;
        }
    }
}

/// Whether the reader finds these attributes in their properties. Single numbers `red`, `green` and `blue` would be a colour, and
/// a single number `flow_2` after `flow_0` and `flow_1` a third number of `flow`.
fn are_read_back(others: &[Named], named: &Named) -> bool {
    let all = || others.iter().chain([named]);
    let properties = all().flat_map(|named| &named.properties).map(String::as_str);
    let names: Vec<&str> = COORDINATES.into_iter().chain(properties).collect();
    let are_new = named.properties.iter().all(|new| names.iter().filter(|name| *name == new).count() == 1);
    let property = |name: &&str| Property { name: (*name).into(), shape: Shape::One(Scalar::F64) };
    let properties = names.iter().map(property).collect();
    let element = Element { name: "vertex".into(), count: 0, count_at: 0..0, properties };
    let found = attributes::of_vertices(&element, &[0, 1, 2]);
    let is_found = |named: &Named| {
        found.iter().any(|columns| {
            let properties = columns.columns.iter().map(|column| names[*column]);
            columns.name == named.name && properties.eq(named.properties.iter().map(String::as_str))
        })
    };
    are_new && all().all(is_found)
}

/// A name as one word of a header.
fn word(name: &str) -> String {
    let is_gap = |c: char| c.is_whitespace() || c.is_control();
    let words: Vec<&str> = name.split(is_gap).filter(|word| !word.is_empty()).collect();
    if words.is_empty() { "attribute".into() } else { words.join("_") }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The properties of attributes of vertices with these names and widths, and the note.
    fn named(attributes: &[(&str, usize)]) -> (Vec<String>, Option<String>) {
        let attribute =
            |(name, width): &(&str, usize)| Attribute::of_vertices(*name, *width, vec![0.0; *width]);
        let attributes: Vec<Attribute> = attributes.iter().map(attribute).collect();
        let PropertyNames { of_vertices, note, .. } = PropertyNames::of(&attributes);
        (of_vertices.into_iter().flat_map(|named| named.properties).collect(), note)
    }

    #[test]
    fn no_two_attributes_become_one() {
        type Given = [(&'static str, usize)];
        let cases: &[(&Given, &[&str])] = &[
            (&[("a b", 1), ("a_b", 1)], &["a_b", "a_b_2"]),
            (&[("red", 1), ("green", 1), ("blue", 1)], &["red", "green", "blue_2"]),
            (&[("red", 1), ("color", 3)], &["red", "green", "blue", "red_2"]),
            (&[("color", 3), ("alpha", 1)], &["red", "green", "blue", "alpha_2"]),
            (&[("s", 1), ("t", 1)], &["s", "t_2"]),
            (&[("s", 1), ("t", 1), ("uv", 2)], &["u", "v", "s", "t"]),
            (&[("x", 1), ("nx", 1), ("normal", 3)], &["nx", "ny", "nz", "x_2", "nx_2"]),
            (&[("flow", 2), ("flow_2", 1)], &["flow_0", "flow_1", "flow_2_2"]),
            (&[("flow_0", 1), ("flow_1", 1)], &["flow_0", "flow_1_2"]),
            (&[("", 1), ("\n", 2)], &["attribute", "attribute_2_0", "attribute_2_1"]),
        ];
        for (attributes, expected) in cases {
            assert_eq!(named(attributes).0, *expected, "{attributes:?}");
        }
        let (_, note) = named(&[("a b", 1), ("a_b", 1), ("c", 1)]);
        let text = "attributes have other names in the file, because PLY cannot hold these: 'a b' is 'a_b_2'";
        assert_eq!(note.as_deref(), Some(text));
        assert_eq!(named(&[("red", 1), ("heat", 1)]).1, None);
    }
}
