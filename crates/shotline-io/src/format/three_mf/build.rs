//! The scene graph: each item of the build is an object that is placed, and objects are shared.

use std::collections::{HashMap, HashSet};

use shotline::math::Affine;
use shotline::scene::{LocalTransform, Material, Node, NodeId, Scene};

use super::model::{Model, Object, ObjectKey, Placed, Shape};
use crate::diagnostic::RawDiagnostic;
use crate::location::RawLocation;
use crate::mesh_file::MeshFile;
use crate::note::{Effect, NoteKind, Notes};
use crate::options::ReadOptions;
use crate::unique_names::UniqueNames;

const SUPPORTS: NoteKind = NoteKind {
    name: "supports",
    effect: Effect::Changed,
    one: "1 object that supports the print, or is of the type 'other', was left out",
    many: "# objects that support the print, or are of the type 'other', were left out",
};

/// An error, and the number of the model part that it is in.
pub(super) type Fault = (usize, RawDiagnostic);

/// The scene while it is built.
pub(super) struct Builder<'m> {
    models: &'m [Model],
    options: &'m ReadOptions,
    pub(super) scene: Scene,
    /// The part of the text that each node comes from, and the number of its model part.
    pub(super) spans: Vec<std::ops::Range<usize>>,
    pub(super) parts: Vec<u32>,
    names: UniqueNames,
    /// What objects without a name are called: as an object that consists of them.
    called: HashMap<ObjectKey, String>,
    /// The node of each object that is complete; `None` for what has no triangles.
    nodes: HashMap<ObjectKey, Option<NodeId>>,
    /// The objects at the root that hold groups.
    roots: HashMap<ObjectKey, NodeId>,
    /// Materials by what they look like, with their names in the scene.
    materials: HashMap<(String, Option<[u64; 3]>), String>,
    material_names: UniqueNames,
}

impl<'m> Builder<'m> {
    pub(super) fn new(models: &'m [Model], options: &'m ReadOptions) -> Builder<'m> {
        let units = models.first().and_then(|model| model.units);
        Builder {
            models,
            options,
            scene: Scene { units, ..Scene::default() },
            spans: Vec::new(),
            parts: Vec::new(),
            names: UniqueNames::default(),
            called: HashMap::new(),
            nodes: HashMap::new(),
            roots: HashMap::new(),
            materials: HashMap::new(),
            material_names: UniqueNames::default(),
        }
    }

    /// Builds the items of the first model part.
    pub(super) fn build(&mut self, notes: &mut [Notes]) -> Result<(), Fault> {
        let items: &'m [Placed] = self.models.first().map_or(&[], |model| &model.items);
        for item in items {
            let object = self.object(0, item)?;
            let Some(node) = self.node(item.object, (0, item), notes)? else { continue };
            let root = if self.holds_group(node) { self.root(item.object, object, node) } else { node };
            let placed = self.transformed((0, item), root);
            self.scene.objects.push(placed);
        }
        Ok(())
    }

    /// Whether a node is a group, perhaps transformed.
    fn holds_group(&self, mut node: NodeId) -> bool {
        while let Node::Transform { child, .. } = self.scene.node(node) {
            node = *child;
        }
        matches!(self.scene.node(node), Node::Group { .. })
    }

    /// The object that a component or an item in a model part names.
    fn object(&self, part: usize, placed: &Placed) -> Result<&'m Object, Fault> {
        let (of_part, id) = placed.object;
        let found = self.models.get(of_part).and_then(|model| model.objects.get(&id));
        found.ok_or_else(|| {
            let message = format!("there is no object {id}");
            (part, RawDiagnostic::text(placed.range.clone(), message).help("check the number of the object"))
        })
    }

    /// The node of an object, with those of its components before it: depth first, with a stack of our own.
    fn node(
        &mut self,
        key: ObjectKey,
        named_by: (usize, &'m Placed),
        notes: &mut [Notes],
    ) -> Result<Option<NodeId>, Fault> {
        // The objects that are open, each with the number of its components that are done.
        let mut open: Vec<(ObjectKey, usize)> = Vec::new();
        let mut is_open: HashSet<ObjectKey> = HashSet::new();
        let mut next = Some((key, named_by));
        loop {
            if let Some((key, (part, placed))) = next.take()
                && !self.nodes.contains_key(&key)
            {
                let object = self.object(part, placed)?;
                if !is_open.insert(key) {
                    let message = format!("object {} consists of itself", key.1);
                    return Err((part, RawDiagnostic::text(placed.range.clone(), message)));
                }
                if !object.is_model {
                    notes[part].add(&SUPPORTS, RawLocation::Text(placed.range.clone()));
                    self.nodes.insert(key, None);
                } else {
                    open.push((key, 0));
                }
            }
            let Some((key, done)) = open.last_mut() else { break };
            let (key, index) = (*key, *done);
            *done += 1;
            let object = &self.models[key.0].objects[&key.1];
            match &object.shape {
                Shape::Components(parts) if index < parts.len() => {
                    let name = object.name.clone().or_else(|| self.called.get(&key).cloned());
                    if let (Some(name), 1) = (name, parts.len()) {
                        self.called.entry(parts[index].object).or_insert(name);
                    }
                    next = Some((parts[index].object, (key.0, &parts[index])));
                }
                _ => {
                    let node = self.complete(key, object, notes);
                    self.nodes.insert(key, node);
                    is_open.remove(&key);
                    open.pop();
                }
            }
        }
        Ok(self.nodes.get(&key).copied().flatten())
    }

    /// Adds the node of an object whose components are complete: an object, or a group of objects.
    fn complete(&mut self, key: ObjectKey, object: &'m Object, notes: &mut [Notes]) -> Option<NodeId> {
        match &object.shape {
            Shape::Mesh { mesh, material } => {
                let mesh = match self.options.weld {
                    None => mesh.clone(),
                    weld => {
                        let found =
                            MeshFile { mesh: mesh.as_ref().clone(), ..MeshFile::default() }.welded(weld);
                        found.notes.into_iter().for_each(|note| notes[key.0].push(note));
                        found.mesh.into()
                    }
                };
                let shape = self.add(key.0, object, Node::Mesh { mesh, file: None });
                let material = material.as_ref().map(|(name, material)| self.material(name, material));
                Some(self.named(key, object, material, shape))
            }
            Shape::Components(parts) => {
                let mut members = Vec::with_capacity(parts.len());
                for part in parts {
                    if let Some(node) = self.nodes.get(&part.object).copied().flatten() {
                        members.push(self.transformed((key.0, part), node));
                    }
                }
                match members[..] {
                    [] => None,
                    [only] => Some(only),
                    _ => Some(self.add(key.0, object, Node::Group { members })),
                }
            }
        }
    }

    /// The object at the root that holds a group: a root must be an object.
    fn root(&mut self, key: ObjectKey, object: &'m Object, group: NodeId) -> NodeId {
        if let Some(known) = self.roots.get(&key) {
            return *known;
        }
        let root = self.named(key, object, None, group);
        self.roots.insert(key, root);
        root
    }

    fn named(
        &mut self,
        key: ObjectKey,
        object: &'m Object,
        material: Option<String>,
        node: NodeId,
    ) -> NodeId {
        let default = || format!("object{}", key.1);
        let name = object.name.clone().or_else(|| self.called.get(&key).cloned()).unwrap_or_else(default);
        let name = self.names.free(&name);
        let found = Node::Object { name, material, priority: 0, node, contents: Vec::new(), clip: false };
        self.add(key.0, object, found)
    }

    /// The name in the scene of a material.
    fn material(&mut self, name: &str, material: &Material) -> String {
        let key = (name.to_owned(), material.color.map(|color| color.map(f64::to_bits)));
        if let Some(known) = self.materials.get(&key) {
            return known.clone();
        }
        let free = self.material_names.free(name);
        self.materials.insert(key, free.clone());
        self.scene.materials.push((free.clone(), material.clone()));
        free
    }

    fn transformed(&mut self, (part, placed): (usize, &Placed), child: NodeId) -> NodeId {
        let Some(matrix): Option<Affine> = placed.transform else { return child };
        self.spans.push(placed.range.clone());
        self.parts.push(part as u32);
        self.scene.add(Node::Transform { transform: LocalTransform::Matrix(matrix), child })
    }

    fn add(&mut self, part: usize, object: &Object, node: Node) -> NodeId {
        self.spans.push(object.range.clone());
        self.parts.push(part as u32);
        self.scene.add(node)
    }
}
