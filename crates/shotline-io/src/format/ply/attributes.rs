//! The attributes in a PLY file: which properties of vertices and faces hold them.

use shotline::solid::mesh::Attribute;

use super::header::{Element, Property, Scalar, Shape};
use crate::corner_values::CornerValues;

/// The properties that together are one attribute of vertices or faces, in the names that programs write.
pub(super) const SETS: &[(&str, &[&str])] = &[
    ("color", &["red", "green", "blue", "alpha"]),
    ("color", &["red", "green", "blue"]),
    ("color", &["diffuse_red", "diffuse_green", "diffuse_blue"]),
    ("color", &["r", "g", "b"]),
    ("normal", &["nx", "ny", "nz"]),
    ("uv", &["u", "v"]),
    ("uv", &["s", "t"]),
    ("uv", &["texture_u", "texture_v"]),
    ("uv", &["texture_s", "texture_t"]),
];

/// Whether these properties together are the attribute of this name.
pub(super) fn is_set(name: &str, properties: &[String]) -> bool {
    SETS.iter().any(|(set, known)| *set == name && known.iter().eq(properties))
}

/// The list of a face with the texture coordinates of its corners, as MeshLab writes it.
pub(super) const TEXTURE: &str = "texcoord";

/// The beginning of the name of any other list of a face with values of its corners.
pub(super) const CORNER: &str = "corner_";

/// Columns of an element that are one attribute.
pub(super) struct Columns {
    pub(super) name: String,
    pub(super) columns: Vec<usize>,
    /// What a number is divided by.
    scale: f64,
}

/// Whole numbers are the range from 0 to 1 in colours.
fn color_scale(property: &Property) -> f64 {
    match property.shape {
        Shape::One(Scalar::U8) => 255.0,
        Shape::One(Scalar::U16) => 65535.0,
        _ => 1.0,
    }
}

/// The sets that an element has. Of those of one name the first counts.
fn sets(element: &Element) -> Vec<Columns> {
    let column = |name: &&str| {
        element.properties.iter().position(|p| p.name == *name && matches!(p.shape, Shape::One(_)))
    };
    let mut found: Vec<Columns> = Vec::new();
    for (name, properties) in SETS {
        let columns: Vec<usize> = properties.iter().filter_map(column).collect();
        if columns.len() == properties.len() && found.iter().all(|known| known.name != *name) {
            let scale = if *name == "color" { color_scale(&element.properties[columns[0]]) } else { 1.0 };
            found.push(Columns { name: (*name).into(), columns, scale });
        }
    }
    found
}

/// Adds every other number of an element: `a_0`, `a_1`, ... as the attribute `a`, any other by its name.
fn add_others(found: &mut Vec<Columns>, element: &Element, read: &[usize]) {
    let is_taken =
        |found: &[Columns], p: usize| read.contains(&p) || found.iter().any(|f| f.columns.contains(&p));
    for (p, property) in element.properties.iter().enumerate() {
        if is_taken(found, p) || !matches!(property.shape, Shape::One(_)) {
            continue;
        }
        let stem = property.name.strip_suffix("_0").unwrap_or_default();
        let is_next =
            |(i, p): &(usize, &Property)| p.name == format!("{stem}_{i}") && matches!(p.shape, Shape::One(_));
        let count = element.properties[p..].iter().enumerate().take_while(is_next).count();
        let (name, count) =
            if count > 1 && !stem.is_empty() { (stem, count) } else { (property.name.as_str(), 1) };
        if found.iter().all(|known| known.name != name) {
            found.push(Columns { name: name.into(), columns: (p..p + count).collect(), scale: 1.0 });
        }
    }
}

/// The attributes of vertices in an element, without the columns `read`.
pub(super) fn of_vertices(element: &Element, read: &[usize]) -> Vec<Columns> {
    let mut sets = sets(element);
    sets.retain(|set| set.columns.iter().all(|column| !read.contains(column)));
    add_others(&mut sets, element, read);
    sets
}

/// The attributes of vertices while they are read.
pub(super) struct VertexAttributes {
    sets: Vec<Columns>,
    values: Vec<Vec<f64>>,
}

impl VertexAttributes {
    /// The numbers of an element that are not among the columns `read`.
    pub(super) fn of(element: &Element, read: &[usize]) -> VertexAttributes {
        let sets = of_vertices(element, read);
        let values = sets.iter().map(|set| Vec::with_capacity(set.columns.len() * element.count)).collect();
        VertexAttributes { sets, values }
    }

    /// The columns that are read.
    pub(super) fn columns(&self) -> impl Iterator<Item = usize> {
        self.sets.iter().flat_map(|set| set.columns.iter().copied())
    }

    /// Adds the values of a row, given its numbers by column.
    pub(super) fn push(&mut self, row: &[f64]) {
        for (set, values) in self.sets.iter().zip(&mut self.values) {
            values.extend(set.columns.iter().map(|column| row[*column] / set.scale));
        }
    }

    pub(super) fn finish(self) -> impl Iterator<Item = Attribute> {
        self.sets
            .into_iter()
            .zip(self.values)
            .map(|(set, values)| Attribute::of_vertices(set.name, set.columns.len(), values))
    }
}

/// The attributes of faces and of their corners while they are read.
pub(super) struct FaceAttributes {
    sets: Vec<(Columns, CornerValues)>,
    lists: Vec<(usize, String, Option<CornerValues>)>,
}

impl FaceAttributes {
    pub(super) fn of(element: &Element) -> FaceAttributes {
        let is_list = |p: &Property| matches!(p.shape, Shape::List { .. });
        let named = element.properties.iter().enumerate().filter(|(_, p)| is_list(p));
        let lists: Vec<(usize, String, Option<CornerValues>)> = named
            .filter_map(|(column, p)| {
                let name = if p.name == TEXTURE { "uv" } else { p.name.strip_prefix(CORNER)? };
                (!name.is_empty()).then(|| (column, name.to_owned(), None))
            })
            .collect();
        let mut sets = sets(element);
        sets.retain(|set| lists.iter().all(|(_, name, _)| *name != set.name));
        let values = |set: Columns| {
            let values = CornerValues::new(set.name.clone(), set.columns.len());
            (set, values)
        };
        FaceAttributes { sets: sets.into_iter().map(values).collect(), lists }
    }

    /// Whether there are none.
    pub(super) fn is_empty(&self) -> bool {
        self.sets.is_empty() && self.lists.is_empty()
    }

    /// The columns that are read.
    pub(super) fn columns(&self) -> impl Iterator<Item = usize> {
        let of_sets = self.sets.iter().flat_map(|(set, _)| set.columns.iter().copied());
        of_sets.chain(self.lists.iter().map(|(column, ..)| *column))
    }

    /// The names of the attributes.
    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        let of_sets = self.sets.iter().map(|(set, _)| set.name.as_str());
        of_sets.chain(self.lists.iter().map(|(_, name, _)| name.as_str()))
    }

    /// Adds the values of a face, given the numbers of each of its columns, for its corners from a number on. `wrong` gets the
    /// column of each list that does not have as many numbers for each corner as the first such list.
    pub(super) fn push(
        &mut self,
        row: &[Vec<f64>],
        first_corner: usize,
        corners: usize,
        mut wrong: impl FnMut(usize),
    ) {
        for (set, values) in &mut self.sets {
            let number = values.len() as u32;
            values.push(
                set.columns.iter().map(|column| row[*column].first().map_or(f64::NAN, |x| x / set.scale)),
            );
            (first_corner..first_corner + corners).for_each(|corner| values.set(corner, number));
        }
        for (column, name, values) in &mut self.lists {
            let numbers = &row[*column];
            let width = numbers.len() / corners.max(1);
            // A face without texture has an empty list.
            if numbers.is_empty() || corners == 0 {
                continue;
            }
            let differs = values.as_ref().is_some_and(|values| values.width() != width);
            if differs || width == 0 || !numbers.len().is_multiple_of(corners) {
                wrong(*column);
                continue;
            }
            let values = values.get_or_insert_with(|| CornerValues::new(name.clone(), width));
            for (corner, value) in (first_corner..).zip(numbers.chunks(width)) {
                let number = values.len() as u32;
                values.push(value.iter().copied());
                values.set(corner, number);
            }
        }
    }

    pub(super) fn finish(self, corners: &[[u32; 3]]) -> Vec<Attribute> {
        let of_sets = self.sets.into_iter().map(|(_, values)| values);
        let of_lists = self.lists.into_iter().filter_map(|(.., values)| values);
        of_sets.chain(of_lists).filter_map(|values| values.finish(corners)).collect()
    }
}
