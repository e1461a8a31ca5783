//! All meshes of a scene as one, with the faces of each object.

use std::collections::{HashMap, HashSet};

use shotline::scene::{Material, Node, Scene};
use shotline::solid::mesh::TriangleMesh;

use crate::append::{NORMAL, append, expect_joinable};
use crate::error::WriteError;
use crate::format::Keeps;
use crate::losses;
use crate::mesh_file::ObjectFaces;
use crate::placed::Placed;
use crate::unique_names::UniqueNames;

/// A scene as one mesh.
#[derive(Debug)]
pub(crate) struct Joined<'s> {
    pub(crate) mesh: TriangleMesh,
    /// The objects of the faces, with names that differ and stand on a line of a text.
    pub(crate) objects: Vec<ObjectFaces>,
    /// The materials of the objects, with their names in the file.
    pub(crate) materials: Vec<(String, &'s Material)>,
    /// What is lost.
    pub(crate) notes: Vec<String>,
}

/// Joins all meshes of a scene for a format.
///
/// # Errors
/// [`WriteError::Unwritable`] if the scene has other solids than meshes, or too many.
pub(crate) fn join<'s>(scene: &'s Scene, format: &str, keeps: Keeps) -> Result<Joined<'s>, WriteError> {
    let placed = Placed::of(scene, format)?;
    expect_joinable(placed.meshes.iter().map(|found| &**found.mesh), "the scene")?;
    let mut names = Names::of(scene);
    let mut mesh = TriangleMesh::default();
    let mut objects: Vec<ObjectFaces> = Vec::new();
    let (mut last, mut moved) = (None, 0);
    for found in &placed.meshes {
        if last != Some(found.object) {
            let (name, material) = names.of_object(found.object, &placed);
            objects.push(ObjectFaces { first: mesh.faces.len(), name, material });
            last = Some(found.object);
        }
        moved += if found.world_from_local.is_identity() { 0 } else { found.mesh.vertices.len() };
        append(&mut mesh, found.mesh, &found.world_from_local)?;
    }
    let mut notes = losses_of(scene, keeps);
    if keeps != Keeps::Nothing && names.changed > 0 {
        notes.push(format!(
            "names of objects changed, because each must differ and be one line: {}",
            names.changed
        ));
    }
    let meshes = scene.nodes.iter().filter(|node| matches!(node, Node::Mesh { .. })).count();
    if placed.meshes.len() > meshes {
        let copies = placed.meshes.len();
        notes.push(format!("shared meshes are written out for each of their placements, {copies} in all"));
    }
    if moved > 0 {
        notes.push(format!("vertices moved into place, and rounded to float64: {moved}"));
        let has_normals =
            |node: &Node| matches!(node, Node::Mesh { mesh, .. } if mesh.attribute(NORMAL).is_some());
        if scene.nodes.iter().any(has_normals) {
            notes.push("normals of meshes that were moved are lost".into());
        }
    }
    let used: HashSet<&str> = objects.iter().filter_map(|object| object.material.as_deref()).collect();
    let named = |(name, material): &'s (String, Material)| {
        Some((names.materials.get(name.as_str())?.clone(), material))
    };
    let materials = scene.materials.iter().filter_map(named).filter(|(name, _)| used.contains(name.as_str()));
    Ok(Joined { materials: materials.collect(), mesh, objects, notes })
}

/// The names in a text of objects and materials.
struct Names<'s> {
    /// Those of placed objects that have one.
    objects: HashMap<usize, String>,
    taken: UniqueNames,
    materials: HashMap<&'s str, String>,
    taken_by_materials: UniqueNames,
    /// How many objects have another name than in the scene.
    changed: usize,
}

impl<'s> Names<'s> {
    fn of(scene: &'s Scene) -> Names<'s> {
        let mut names = Names {
            objects: HashMap::new(),
            taken: UniqueNames::default(),
            materials: HashMap::new(),
            taken_by_materials: UniqueNames::default(),
            changed: 0,
        };
        scene.materials.iter().for_each(|(name, _)| drop(names.material(name)));
        names
    }

    fn of_object(&mut self, object: usize, placed: &Placed<'s>) -> (String, Option<String>) {
        let found = placed.objects[object];
        let material = found.material.map(|name| self.material(name));
        if let Some(known) = self.objects.get(&object) {
            return (known.clone(), material);
        }
        let name = self.taken.free(&on_a_line(found.name, "object"));
        self.changed += usize::from(name != found.name);
        self.objects.insert(object, name.clone());
        (name, material)
    }

    fn material(&mut self, name: &'s str) -> String {
        let taken = &mut self.taken_by_materials;
        self.materials.entry(name).or_insert_with(|| taken.free(&on_a_line(name, "material"))).clone()
    }
}

/// A name as the formats of text read it: words with one blank between them, no comment, and no line that goes on.
fn on_a_line(name: &str, default: &str) -> String {
    let plain = |c: char| if c == '#' || c == '\\' { '_' } else { c };
    let is_gap = |c: char| c.is_ascii_whitespace() || c.is_control();
    let words: Vec<String> = name
        .split(is_gap)
        .filter(|word| !word.is_empty())
        .map(|word| word.chars().map(plain).collect())
        .collect();
    if words.is_empty() { default.into() } else { words.join(" ") }
}

/// What a mesh file cannot hold of a scene.
fn losses_of(scene: &Scene, keeps: Keeps) -> Vec<String> {
    let objects = scene.numbered_objects().len();
    let mut lost = Vec::new();
    if keeps == Keeps::Nothing && objects > 1 {
        lost.push(format!("{objects} objects were joined into one mesh; their names are lost"));
    }
    if let Some(units) = scene.units {
        lost.push(format!("the units, {units}, are lost"));
    }
    match keeps {
        Keeps::NamesAndMaterials => lost.extend(losses::of_materials(scene, losses::Look::Highlight)),
        Keeps::Nothing | Keeps::Names if !scene.materials.is_empty() => {
            lost.push("materials are lost".into())
        }
        Keeps::Nothing | Keeps::Names => {}
    }
    if keeps != Keeps::Nothing {
        lost.extend(losses::of_nesting(scene));
    }
    lost.extend(losses::of_view(scene));
    lost
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_one_line_without_a_comment() {
        assert_eq!(on_a_line(" a  b\n#1 \\", "object"), "a b _1 _");
        assert_eq!(
            (on_a_line("\t", "object"), on_a_line("größe", "object")),
            ("object".into(), "größe".into())
        );
    }
}
