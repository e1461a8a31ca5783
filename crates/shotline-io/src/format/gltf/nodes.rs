//! Nodes: a tree that places meshes, cameras and lights.

use shotline::math::ComposedTransform;
use shotline::scene::{LocalTransform, Node, NodeId};

use super::Reader;
use super::appearance::camera;
use super::extensions::LIGHTS;
use super::fields::{Field, List, Read};
use super::meshes::{Part, Target};
use super::transforms::{is_flat, of_node};
use crate::location::RawLocation;
use crate::note::{Effect, Note, NoteKind};
use crate::suggest;

const FLAT: NoteKind = NoteKind {
    name: "flat_nodes",
    effect: Effect::Changed,
    one: "1 node that is scaled by 0 was left out, with what is below it",
    many: "# nodes that are scaled by 0 were left out, with what is below them",
};

const SKINS: NoteKind = NoteKind {
    name: "skins",
    effect: Effect::Changed,
    one: "1 mesh with a skin was read as it is stored, without its joints",
    many: "# meshes with skins were read as they are stored, without their joints",
};

const CAMERAS: NoteKind = NoteKind {
    name: "cameras",
    effect: Effect::Kept,
    one: "1 camera besides the first was not read",
    many: "# cameras besides the first were not read",
};

/// How many transforms a scene may have for each of its nodes, and in any case: each object has those above it.
const PER_NODE: usize = 16;
const FREE: usize = 1 << 20;

/// A node that waits to be visited.
struct Waiting {
    node: usize,
    depth: usize,
}

impl<'j> Reader<'_, 'j, '_> {
    /// Reads the scene that is chosen.
    pub(super) fn scene(&mut self) -> Read<()> {
        let nodes = self.root.list("nodes")?;
        let parents = parents(nodes)?;
        let roots = self.roots(nodes, &parents)?;
        let mut left = FREE.saturating_add(PER_NODE.saturating_mul(nodes.len()));
        // The transforms of the nodes from the root to the present one, and their products.
        let mut path: Vec<Option<LocalTransform>> = Vec::new();
        let mut world: Vec<ComposedTransform> = vec![ComposedTransform::IDENTITY];
        let mut waiting: Vec<Waiting> =
            roots.into_iter().rev().map(|node| Waiting { node, depth: 0 }).collect();
        while let Some(Waiting { node, depth }) = waiting.pop() {
            let Some(field) = nodes.get(node) else { continue };
            let transform = of_node(field, &format!("node {node}"))?;
            if transform.as_ref().is_some_and(is_flat) {
                self.notes.add(&FLAT, RawLocation::Text(field.range()));
                continue;
            }
            path.truncate(depth);
            world.truncate(depth + 1);
            path.push(transform);
            world.push(transform.map_or(world[depth], |local| local.inside(&world[depth])));
            self.attached(field, &world[depth + 1])?;
            if let Some(mesh) = field.get("mesh") {
                let chain: Vec<LocalTransform> = path.iter().rev().copied().flatten().collect();
                self.place(node, field, mesh, &chain, &mut left)?;
            }
            for child in field.list("children")?.iter().rev() {
                waiting.push(Waiting { node: child.index("node", &nodes)?, depth: depth + 1 });
            }
        }
        Ok(())
    }

    /// The root nodes of the scene that is chosen: by its name, or the default one, or else the first. A file without scenes
    /// has the nodes that are no children.
    fn roots(&mut self, nodes: List<'j>, parents: &[Option<usize>]) -> Read<Vec<usize>> {
        let scenes = self.root.list("scenes")?;
        let chosen = match (&self.options.setup, self.root.get("scene")) {
            (Some(setup), _) => Some(scene_of_name(scenes, setup)?),
            (None, Some(default)) => Some(default.index("scene", &scenes)?),
            (None, None) => (scenes.len() > 0).then_some(0),
        };
        let Some(scene) = chosen.and_then(|index| scenes.get(index)) else {
            return Ok((0..nodes.len()).filter(|node| parents[*node].is_none()).collect());
        };
        if self.options.setup.is_none() && scenes.len() > 1 {
            let name = scene.name().map_or(String::new(), |name| format!(" '{name}'"));
            let text = format!(
                "of {} scenes, scene {}{name} was read; --setup (in Python setup=) reads another by its name",
                scenes.len(),
                chosen.unwrap_or(0)
            );
            self.notes.push(Note::new("setups", Effect::Changed, scenes.len(), text));
        }
        let mut roots = Vec::new();
        let mut is_root = vec![false; nodes.len()];
        for field in scene.list("nodes")?.iter() {
            let node = field.index("node", &nodes)?;
            if let Some(parent) = parents[node] {
                let message = format!("node {node} is no root of the scene: it is a child of node {parent}");
                return Err(field.error(message));
            }
            if std::mem::replace(&mut is_root[node], true) {
                return Err(field.error(format!("node {node} stands twice in the scene")));
            }
            roots.push(node);
        }
        Ok(roots)
    }

    /// Reads the camera and the light of a node.
    fn attached(&mut self, field: Field<'j>, world: &ComposedTransform) -> Read<()> {
        let (of_camera, light) = (field.get("camera"), field.extension(LIGHTS));
        if of_camera.is_none() && light.is_none() {
            return Ok(());
        }
        let placed = world.placement().map_err(|error| field.error(error.to_string()))?.parent_from_local;
        if let Some(number) = of_camera {
            let cameras = self.root.list("cameras")?;
            let index = number.index("camera", &cameras)?;
            match cameras.get(index) {
                Some(_) if self.scene.camera.is_some() => {
                    self.notes.add(&CAMERAS, RawLocation::Text(field.range()));
                }
                Some(found) => self.scene.camera = Some(camera(found, &placed)?),
                None => {}
            }
        }
        if let Some(light) = light {
            let lights = match self.root.extension(LIGHTS) {
                Some(extension) => extension.list("lights")?,
                None => return Err(light.error("the file has no list of lights")),
            };
            let index = light.required("light", LIGHTS)?.index("light", &lights)?;
            if let Some(found) = lights.get(index) {
                self.lights.add(found, &placed, &mut self.notes)?;
            }
        }
        Ok(())
    }

    /// Adds the objects of a node that has a mesh. `chain` are the transforms from the node outwards.
    fn place(
        &mut self,
        node: usize,
        field: Field<'j>,
        mesh: Field<'j>,
        chain: &[LocalTransform],
        left: &mut usize,
    ) -> Read<()> {
        let meshes = self.root.list("meshes")?;
        let index = mesh.index("mesh", &meshes)?;
        let Some(of_mesh) = meshes.get(index) else { return Ok(()) };
        if field.get("skin").is_some() {
            self.notes.add(&SKINS, RawLocation::Text(field.range()));
        }
        let mut target = Target {
            scene: &mut self.scene,
            spans: &mut self.spans,
            notes: &mut self.notes,
            options: self.options,
            materials: self.materials.len(),
        };
        let parts = self.meshes.parts(index, of_mesh, &mut self.accessors, &mut target)?;
        let default = format!("node{node}");
        let base = field.name().or(of_mesh.name()).unwrap_or(&default).to_owned();
        for part in parts {
            match left.checked_sub(chain.len()) {
                Some(rest) => *left = rest,
                None => return Err(field.error("the nodes above the meshes are nested too deeply")),
            }
            let mut top = self.object(&base, field, part);
            for transform in chain {
                top = self.add(field, Node::Transform { transform: *transform, child: top });
            }
            self.scene.objects.push(top);
        }
        Ok(())
    }

    fn object(&mut self, base: &str, field: Field<'j>, part: Part) -> NodeId {
        let object = Node::Object {
            name: self.names.free(base),
            material: part.material.map(|index| self.materials[index].0.clone()),
            priority: 0,
            node: part.mesh,
            contents: Vec::new(),
            clip: false,
        };
        self.add(field, object)
    }

    fn add(&mut self, field: Field<'j>, node: Node) -> NodeId {
        self.spans.push(field.range());
        self.scene.add(node)
    }
}

/// The parent of each node. A node has at most one, so what can be reached from a node without a parent has no cycle.
fn parents(nodes: List) -> Read<Vec<Option<usize>>> {
    let mut parents: Vec<Option<usize>> = vec![None; nodes.len()];
    for (number, node) in nodes.iter().enumerate() {
        for child in node.list("children")?.iter() {
            let index = child.index("node", &nodes)?;
            if let Some(other) = parents[index].replace(number) {
                let message =
                    format!("node {index} is a child of node {number}, and of node {other} as well");
                return Err(child.error(message).help("nodes form a tree; share meshes instead of nodes"));
            }
        }
    }
    check_cycles(nodes, &parents)?;
    Ok(parents)
}

/// Refuses nodes that are their own ancestors: no root leads to them, so they would be left out silently.
fn check_cycles(nodes: List, parents: &[Option<usize>]) -> Read<()> {
    // The number of the first node from which each was reached on the way up.
    let mut reached: Vec<Option<usize>> = vec![None; parents.len()];
    for start in 0..parents.len() {
        let mut at = Some(start);
        while let Some(node) = at.filter(|node| reached[*node].is_none()) {
            reached[node] = Some(start);
            at = parents[node];
        }
        if let Some(node) = at.filter(|node| reached[*node] == Some(start))
            && let Some(field) = nodes.get(node)
        {
            return Err(field.error(format!("node {node} is below itself")));
        }
    }
    Ok(())
}

fn scene_of_name(scenes: List, setup: &str) -> Read<usize> {
    let names: Vec<&str> = scenes.iter().filter_map(Field::name).collect();
    scenes.iter().position(|scene| scene.name() == Some(setup)).ok_or_else(|| {
        let diagnostic = crate::diagnostic::RawDiagnostic::file(format!("there is no scene '{setup}'"));
        diagnostic.help(suggest::hint(setup, &names))
    })
}
