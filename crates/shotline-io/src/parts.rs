//! The objects of a mesh file: its faces by name and material.
//!
//! Faces that bound a solid together stay one object: parts that share edges along which each of them is open are joined,
//! such as the sides of a box that stand in groups of their own, or have materials of their own.

use std::collections::{BTreeMap, HashMap, HashSet};

use shotline::math::Vec3;
use shotline::solid::mesh::{Attribute, NO_ROW, TriangleMesh};

use crate::mesh_file::{MeshFile, Section};
use crate::note::{Effect, Note};
use crate::unique_names::UniqueNames;

/// An object of a mesh file.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Part {
    /// Its name; the names of all parts differ.
    pub(crate) name: String,
    pub(crate) material: Option<String>,
    pub(crate) mesh: TriangleMesh,
}

/// The objects of a mesh file, in the order of their first faces, and notes on how they were made. Faces without a name belong
/// to the object `unnamed`, and so does a mesh that is one object.
pub(crate) fn parts(found: MeshFile, unnamed: &str) -> (Vec<Part>, Vec<Note>) {
    let MeshFile { mesh, sections, .. } = found;
    let labels = Labels::new(&sections, &mesh);
    let groups = labels.groups(&mesh);
    let notes = labels.notes(&groups);
    // A mesh without faces has no label: it is an object all the same.
    if groups.len() <= 1 {
        let material = groups.first().and_then(|group| labels.material(group));
        return (vec![Part { name: unnamed.into(), material, mesh }], notes);
    }
    let mut group_of = vec![0; labels.labels.len()];
    for (number, group) in groups.iter().enumerate() {
        group.iter().for_each(|label| group_of[*label] = number);
    }
    let mut faces = vec![Vec::new(); groups.len()];
    for (face, label) in (0..).zip(&labels.of_face) {
        faces[group_of[*label]].push(face);
    }
    let mut names = UniqueNames::default();
    let mut part = |(group, faces): (&Vec<usize>, Vec<u32>)| Part {
        name: names.free(&labels.name(group, &groups, unnamed)),
        material: labels.material(group),
        mesh: faces_of(&mesh, &faces),
    };
    (groups.iter().zip(faces).map(&mut part).collect(), notes)
}

/// The name and the material of each face.
struct Labels<'s> {
    /// The different pairs, in the order of their first faces.
    labels: Vec<(&'s str, &'s str)>,
    /// How many faces each pair has.
    counts: Vec<usize>,
    /// For each face the index of its pair.
    of_face: Vec<usize>,
}

impl<'s> Labels<'s> {
    fn new(sections: &'s [Section], mesh: &TriangleMesh) -> Labels<'s> {
        let mut labels = Labels { labels: Vec::new(), counts: Vec::new(), of_face: Vec::new() };
        let mut numbers = HashMap::new();
        let (mut next, mut now) = (0, ("", ""));
        for face in (0..).take(mesh.faces.len()) {
            let polygon = mesh.polygon(face);
            while let Some(section) = sections.get(next).filter(|section| section.first <= polygon) {
                now = (&section.name, &section.material);
                next += 1;
            }
            let number = *numbers.entry(now).or_insert_with(|| {
                labels.labels.push(now);
                labels.counts.push(0);
                labels.labels.len() - 1
            });
            labels.counts[number] += 1;
            labels.of_face.push(number);
        }
        labels
    }

    /// The labels of each object, in the order of their first faces.
    fn groups(&self, mesh: &TriangleMesh) -> Vec<Vec<usize>> {
        let mut parents: Vec<usize> = (0..self.labels.len()).collect();
        if parents.len() > 1 {
            for (a, b) in open_together(mesh, &self.of_face) {
                let (a, b) = (root(&mut parents, a), root(&mut parents, b));
                parents[a.max(b)] = a.min(b);
            }
        }
        let mut groups: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for label in 0..parents.len() {
            groups.entry(root(&mut parents, label)).or_default().push(label);
        }
        groups.into_values().collect()
    }

    /// The name of an object: that of its faces; where names differ, that of most.
    fn name(&self, group: &[usize], groups: &[Vec<usize>], unnamed: &str) -> String {
        let (name, _) = self.labels[self.most(group, |(name, _)| name)];
        let material = self.material(group).unwrap_or_default();
        if name.is_empty() {
            return if material.is_empty() { unnamed.into() } else { material };
        }
        let is_of_name = |group: &&Vec<usize>| group.iter().any(|label| self.labels[*label].0 == name);
        let is_only = groups.iter().filter(is_of_name).count() == 1;
        if is_only || material.is_empty() { name.into() } else { format!("{name}:{material}") }
    }

    /// The material of an object: where those of its faces differ, that of most.
    fn material(&self, group: &[usize]) -> Option<String> {
        let (_, material) = self.labels[self.most(group, |(_, material)| material)];
        (!material.is_empty()).then(|| material.into())
    }

    /// The label with the name, or the material, that most faces of an object have.
    fn most(&self, group: &[usize], key: fn((&'s str, &'s str)) -> &'s str) -> usize {
        let mut counts: HashMap<&str, usize> = HashMap::new();
        for label in group {
            *counts.entry(key(self.labels[*label])).or_default() += self.counts[*label];
        }
        let count = |label: &usize| (counts[key(self.labels[*label])], std::cmp::Reverse(*label));
        group.iter().copied().max_by_key(count).unwrap_or_default()
    }

    fn notes(&self, groups: &[Vec<usize>]) -> Vec<Note> {
        let different = |group: &Vec<usize>, key: fn((&'s str, &'s str)) -> &'s str| {
            group.iter().map(|label| key(self.labels[*label])).collect::<HashSet<_>>().len() > 1
        };
        let mut notes = Vec::new();
        let mut note = |kind, count: usize, one: &str, many: &str| {
            let text = if count == 1 { one.into() } else { many.replace('#', &count.to_string()) };
            if count > 0 {
                notes.push(Note::new(kind, Effect::Kept, count, text));
            }
        };
        note(
            "groups_joined",
            groups.iter().filter(|group| different(group, |(name, _)| name)).count(),
            "1 object is made of groups that bound it together",
            "# objects are made of groups that bound them together",
        );
        note(
            "materials_of_faces",
            groups.iter().filter(|group| different(group, |(_, material)| material)).count(),
            "1 object has faces of several materials; it has the material of most of them",
            "# objects have faces of several materials; each has the material of most of them",
        );
        notes
    }
}

fn root(parents: &mut [usize], mut label: usize) -> usize {
    while parents[label] != label {
        parents[label] = parents[parents[label]];
        label = parents[label];
    }
    label
}

/// Pairs of labels whose faces share an edge along which both are open: their faces run along it more often one way than the
/// other.
fn open_together(mesh: &TriangleMesh, of_face: &[usize]) -> Vec<(usize, usize)> {
    let places = places(&mesh.vertices);
    let mut edges = Vec::with_capacity(mesh.faces.len() * 3);
    for (corners, label) in mesh.faces.iter().zip(of_face) {
        let [a, b, c] = corners.map(|vertex| places[vertex as usize]);
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let direction = if from < to { 1 } else { -1_i32 };
            edges.push((from.min(to), from.max(to), *label, direction));
        }
    }
    edges.sort_unstable();
    let mut pairs = Vec::new();
    for edge in edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)).filter(|edge| edge[0].0 != edge[0].1) {
        let of_label = edge.chunk_by(|a, b| a.2 == b.2);
        let open = of_label.filter(|edges| edges.iter().map(|edge| edge.3).sum::<i32>() != 0);
        let open: Vec<usize> = open.map(|edges| edges[0].2).collect();
        pairs.extend(open.windows(2).map(|pair| (pair[0], pair[1])));
    }
    pairs.dedup();
    pairs
}

/// For each vertex the number of the first at its position.
fn places(vertices: &[Vec3]) -> Vec<u32> {
    let mut first: HashMap<[u64; 3], u32> = HashMap::with_capacity(vertices.len());
    // Adding zero turns -0.0 into 0.0, which is the same place.
    let key = |v: &Vec3| (*v + Vec3::ZERO).to_array().map(f64::to_bits);
    (0..).zip(vertices).map(|(number, vertex)| *first.entry(key(vertex)).or_insert(number)).collect()
}

/// Some faces of a mesh, with the vertices that they use. Polygons keep their numbers.
fn faces_of(mesh: &TriangleMesh, faces: &[u32]) -> TriangleMesh {
    let corners: Vec<[u32; 3]> = faces.iter().map(|face| mesh.faces[*face as usize]).collect();
    let (used, new_corners) = renumbered(&corners, mesh.vertices.len());
    let attribute = |attribute: &Attribute| {
        let corners = attribute.corners.as_ref();
        let rows = corners.map(|all| faces.iter().map(|face| all[*face as usize]).collect::<Vec<_>>());
        let rows = rows.as_ref().map(|rows| renumbered(rows, attribute.rows()));
        let kept = rows.as_ref().map_or(&used, |(kept, _)| kept);
        Attribute {
            values: kept.iter().filter_map(|row| attribute.value(*row)).flatten().copied().collect(),
            corners: rows.as_ref().map(|(_, corners)| corners.clone()),
            ..attribute.without_values()
        }
    };
    let polygons: Vec<u32> = faces.iter().map(|face| mesh.polygon(*face)).collect();
    let is_plain = (0..).zip(&polygons).all(|(face, polygon)| face == *polygon);
    TriangleMesh {
        vertices: used.iter().map(|vertex| mesh.vertices[*vertex as usize]).collect(),
        faces: new_corners,
        polygons: if is_plain { Vec::new() } else { polygons },
        attributes: mesh.attributes.iter().map(attribute).collect(),
    }
}

/// The numbers that occur, in ascending order, and the corners with each replaced by its index among these.
fn renumbered(corners: &[[u32; 3]], count: usize) -> (Vec<u32>, Vec<[u32; 3]>) {
    let mut new = vec![NO_ROW; count];
    for number in corners.iter().flatten().filter(|number| **number != NO_ROW) {
        new[*number as usize] = 0;
    }
    let used: Vec<u32> = (0..count as u32).filter(|number| new[*number as usize] == 0).collect();
    (0..).zip(&used).for_each(|(index, number)| new[*number as usize] = index);
    let replaced = |number: u32| new.get(number as usize).copied().unwrap_or(NO_ROW);
    (used, corners.iter().map(|triangle| triangle.map(replaced)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two boxes, the second beside the first, and sections that begin at these faces.
    fn boxes(sections: &[(u32, &str, &str)]) -> Vec<(String, Option<String>, usize)> {
        let corner =
            |i: u32, x: f64| Vec3::new(x + f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2 & 1));
        let sides: [[u32; 4]; 6] =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let cut = |first: u32| {
            sides.into_iter().flat_map(move |[a, b, c, d]| {
                [[a, b, c], [a, c, d]].map(|triangle| triangle.map(|v| v + first))
            })
        };
        let vertices = (0..8).map(|i| corner(i, 0.0)).chain((0..8).map(|i| corner(i, 2.0))).collect();
        let mesh = TriangleMesh::new(vertices, cut(0).chain(cut(8)).collect());
        let section = |(first, name, material): &(u32, &str, &str)| Section {
            first: *first,
            name: (*name).into(),
            material: (*material).into(),
        };
        let found =
            MeshFile { mesh, sections: sections.iter().map(section).collect(), ..MeshFile::default() };
        let (parts, _) = parts(found, "file");
        parts.into_iter().map(|part| (part.name, part.material, part.mesh.faces.len())).collect()
    }

    #[test]
    fn faces_that_bound_a_solid_together_stay_one_object() {
        let two = boxes(&[(0, "a", "steel"), (12, "b", "")]);
        assert_eq!(two, [("a".into(), Some("steel".into()), 12), ("b".into(), None, 12)]);
        let sides = boxes(&[(0, "front", ""), (2, "back", ""), (12, "b", "red"), (14, "b", "blue")]);
        assert_eq!(sides, [("back".into(), None, 12), ("b".into(), Some("blue".into()), 12)]);
        // What is red needs what is blue to be closed.
        assert_eq!(boxes(&[(0, "", "red"), (13, "", "blue")]), [("file".into(), Some("red".into()), 24)]);
        assert_eq!(boxes(&[(0, "x", "red"), (12, "x", "blue")])[1].0, "x:blue");
        assert_eq!(boxes(&[(0, "", "")]), [("file".into(), None, 24)]);
        assert_eq!(boxes(&[]), [("file".into(), None, 24)]);
        assert_eq!(boxes(&[(12, "file", "")])[1].0, "file_2");
    }

    #[test]
    fn parts_keep_the_values_of_their_corners() {
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
        let mut mesh = TriangleMesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]);
        mesh.attributes.push(Attribute::of_vertices("color", 1, vec![0.0, 1.0, 2.0, 3.0]));
        let rows = Some(vec![[0, 1, 2], [3, NO_ROW, 5]]);
        mesh.attributes.push(Attribute {
            corners: rows,
            ..Attribute::of_vertices("uv", 1, (0..6).map(f64::from).collect())
        });
        let part = faces_of(&mesh, &[1]);
        part.check().unwrap();
        let value = |attribute: usize, corner| {
            part.corner_value(&part.attributes[attribute], 0, corner).map(|v| v[0])
        };
        assert_eq!([0, 1, 2].map(|corner| value(0, corner)), [Some(0.0), Some(2.0), Some(3.0)]);
        assert_eq!([0, 1, 2].map(|corner| value(1, corner)), [Some(3.0), None, Some(5.0)]);
        assert_eq!((part.polygon(0), part.vertices.len(), part.attributes[1].rows()), (1, 3, 2));
    }
}
