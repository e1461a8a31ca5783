//! Objects to volumes, and shared groups of objects to assemblies.
//!
//! GDML scales solids but not volumes. So a volume is written once for each scale that it is placed with, with the scale in its
//! solid and in the positions of what it contains.

use shotline::math::{Affine, ComposedTransform, Vec3};
use shotline::scene::{Node, NodeId};

use super::Writer;
use super::names::{as_xml_name, name_and_copy};
use super::placements::Placement;
use super::report::Reported;
use super::xml::Xml;

/// An object or a group under a scale.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct VolumeKey {
    node: NodeId,
    scale: [u64; 3],
}

impl VolumeKey {
    pub(super) fn of(node: NodeId, scale: Vec3) -> VolumeKey {
        VolumeKey { node, scale: scale.to_array().map(f64::to_bits) }
    }

    fn scale(&self) -> Vec3 {
        Vec3::from(self.scale.map(f64::from_bits))
    }
}

/// A volume or an assembly of the file.
#[derive(Clone, Debug)]
pub(super) struct Volume {
    pub(super) name: String,
    /// The frame of the object or group from that of the volume: a rotation and a translation.
    frame: Affine,
    /// Whether it is an assembly.
    pub(super) is_assembly: bool,
    /// Whether it is an assembly of nothing.
    is_empty: bool,
}

/// Something that is placed in an object or a group.
pub(super) struct Child<'s> {
    pub(super) key: VolumeKey,
    /// The frame of the object or group around it from its own, without the scale.
    place: Affine,
    label: Option<&'s str>,
    /// The lowest priority of what is placed.
    pub(super) priority: i32,
    /// The highest priority of what is placed and of what that contains.
    highest: i32,
}

/// The most volumes that a scene may need.
const MAX_VOLUMES: usize = 1_000_000;

enum Step<'s> {
    Enter(VolumeKey),
    Leave(VolumeKey, Vec<Child<'s>>),
}

impl<'s> Writer<'s> {
    /// Writes an object, or a group of objects, after what it contains. What cannot be written is reported, and the rest is gone
    /// through all the same.
    pub(super) fn volume(&mut self, key: VolumeKey, is_world: bool) -> Result<Volume, Reported> {
        let mut todo = vec![Step::Enter(key)];
        while let Some(step) = todo.pop() {
            match step {
                Step::Enter(key) if self.volumes.contains_key(&key) => {}
                Step::Enter(key) => {
                    let children = self.children(key);
                    let below: Vec<_> = children.iter().rev().map(|child| Step::Enter(child.key)).collect();
                    todo.push(Step::Leave(key, children));
                    todo.extend(below);
                    if self.volumes.len() > MAX_VOLUMES {
                        return Err(self.refuse("its contents are placed with too many different scales"));
                    }
                }
                Step::Leave(key, children) => {
                    let is_outermost = is_world && todo.is_empty();
                    if let Ok(volume) = self.finished(key, &children, is_outermost) {
                        self.volumes.insert(key, volume);
                    }
                }
            }
        }
        self.known_volume(&key)
    }

    fn known_volume(&self, key: &VolumeKey) -> Result<Volume, Reported> {
        self.volumes.get(key).cloned().ok_or(Reported)
    }

    /// What an object or a group places.
    fn children(&mut self, key: VolumeKey) -> Vec<Child<'s>> {
        let scene = self.scene;
        let start: Vec<NodeId> = match scene.node(key.node) {
            Node::Object { name, node, contents, .. } => {
                self.object.clone_from(name);
                std::iter::once(*node).chain(contents.iter().copied()).collect()
            }
            node => node.children().collect(),
        };
        let mut children = self.objects_among(start, key.scale());
        self.order_by_priority(key.node, &mut children);
        children
    }

    /// The objects and the shared groups of objects at or below some nodes, in a frame with a scale.
    pub(super) fn objects_among(&mut self, start: Vec<NodeId>, scale: Vec3) -> Vec<Child<'s>> {
        let scene = self.scene;
        let scale = ComposedTransform::IDENTITY.then(&Affine::scaling(scale));
        let mut children = Vec::new();
        let mut todo: Vec<_> = start.into_iter().rev().map(|id| (id, scale, None, false)).collect();
        while let Some((id, transform, label, is_transformed)) = todo.pop() {
            if !self.structure.has_objects(id) {
                continue;
            }
            match scene.node(id) {
                Node::Transform { transform: local, child } => {
                    let label = label.or_else(|| scene.labels.get(&id).map(String::as_str));
                    todo.push((*child, local.inside(&transform), label, true));
                }
                Node::Group { members } if !is_transformed && !self.structure.is_shared(id) => {
                    todo.extend(members.iter().rev().map(|member| (*member, transform, None, false)));
                }
                Node::Object { .. } | Node::Group { .. } => {
                    children.extend(self.child(id, &transform, label));
                }
                // Lattices have been written out.
                Node::Solid { .. } | Node::Mesh { .. } | Node::Csg { .. } | Node::Lattice { .. } => {}
            }
        }
        children
    }

    fn child(
        &mut self,
        id: NodeId,
        transform: &ComposedTransform,
        label: Option<&'s str>,
    ) -> Result<Child<'s>, Reported> {
        let matrix = self.rounded(transform)?;
        let placement = self.placement(&matrix)?;
        let priority = self.structure.lowest_priority(id).unwrap_or_default();
        let key = VolumeKey::of(id, placement.scale);
        let highest = self.structure.highest_priority(id).unwrap_or_default();
        Ok(Child { key, place: placement.isometry(), label, priority, highest })
    }

    /// What is placed later wins where two overlap, in Geant4's location of points and in `--overlaps priority`.
    pub(super) fn order_by_priority(&mut self, mother: NodeId, children: &mut [Child]) {
        if !self.structure.has_priorities {
            return;
        }
        children.sort_by_key(|child| child.priority);
        self.check_priorities(children);
        if let Node::Object { priority, .. } = self.scene.node(mother)
            && children.first().is_some_and(|least| least.priority < *priority)
        {
            self.refuse(
                "it contains an object of lower priority, and in GDML what is contained always counts",
            );
        }
    }

    /// What is placed earlier loses as a whole where it overlaps what is placed later.
    pub(super) fn check_priorities(&mut self, children: &[Child]) {
        let mut highest = i32::MIN;
        for of_one in children.chunk_by(|a, b| a.priority == b.priority) {
            if of_one[0].priority < highest {
                if let Node::Object { name, .. } = self.scene.node(of_one[0].key.node) {
                    self.object.clone_from(name);
                }
                self.refuse(
                    "it is placed beside an object of another priority, and one of them contains an object of a higher one: \
                     in GDML what is placed later wins with all that it contains",
                );
                return;
            }
            highest = of_one.iter().map(|child| child.highest).fold(highest, i32::max);
        }
    }

    /// Writes an object or a group whose contents are written.
    fn finished(&mut self, key: VolumeKey, children: &[Child], is_world: bool) -> Result<Volume, Reported> {
        let scene = self.scene;
        let Node::Object { name, material, node, clip, priority, .. } = scene.node(key.node) else {
            return self.group(key.node, children);
        };
        self.object.clone_from(name);
        let Some(mut placed) = self.shape(*node)? else {
            self.report.lose("objects without a solid became assemblies", name);
            let name = self.xml_name(name);
            let name = self.volume_name(&name);
            return self.assembly(name, children);
        };
        if key.scale() != Vec3::ONE {
            placed = self.under(placed, &Affine::scaling(key.scale()))?;
        }
        if is_world {
            placed = self.fixed(placed);
        }
        self.note_object(key.node, *clip || children.is_empty(), *priority);
        let written = self.xml_name(name);
        let name = self.volume_name(&written);
        let material = self.material(material.as_deref());
        let element = self.element("volume").named(&name);
        let element = element.reference("materialref", &material).reference("solidref", &placed.solid);
        let element = self.with_children(element, &placed.place, children)?;
        self.check(&element);
        element.write(&mut self.volumes_text);
        Ok(Volume { name, frame: placed.place, is_assembly: false, is_empty: false })
    }

    /// A group of objects, under a name that no object has.
    fn group(&mut self, id: NodeId, children: &[Child]) -> Result<Volume, Reported> {
        let def = self.scene.defs.iter().find(|(_, node)| *node == id);
        let name = as_xml_name(def.map_or("assembly", |(name, _)| name));
        let name = self.names.free(&name);
        self.volume_names.reserve(name.clone());
        self.object.clone_from(&name);
        self.assembly(name, children)
    }

    fn assembly(&mut self, name: String, children: &[Child]) -> Result<Volume, Reported> {
        let element = self.element("assembly").named(&name);
        let element = self.with_children(element, &Affine::IDENTITY, children)?;
        let is_empty = element.is_empty();
        if !is_empty {
            self.check(&element);
            element.write(&mut self.volumes_text);
        }
        Ok(Volume { name, frame: Affine::IDENTITY, is_assembly: true, is_empty })
    }

    /// Notes what a volume loses.
    fn note_object(&mut self, id: NodeId, clips: bool, priority: i32) {
        let object = self.object.clone();
        if !clips {
            self.report.lose("what they contain counts only inside them in GDML, of the objects", &object);
        }
        if priority != 0 && self.structure.has_priorities {
            let what = "GDML has no priorities: objects are placed in the order of theirs, and checks for overlaps report the objects";
            self.report.lose(what, &object);
        }
        if self.is_group_of_solids(id) {
            self.report.lose("the members of their groups became unions, of the objects", &object);
        }
    }

    /// Whether the shape of an object is a group of several solids.
    fn is_group_of_solids(&self, object: NodeId) -> bool {
        let Node::Object { node, .. } = self.scene.node(object) else { return false };
        let mut shape = *node;
        while let Node::Transform { child, .. } = self.scene.node(shape) {
            shape = *child;
        }
        let Node::Group { members } = self.scene.node(shape) else { return false };
        members.iter().filter(|member| !self.structure.has_objects(**member)).count() > 1
    }

    /// Adds what is placed in a volume of a frame.
    pub(super) fn with_children(
        &mut self,
        mut element: Xml,
        frame: &Affine,
        children: &[Child],
    ) -> Result<Xml, Reported> {
        let volume_from_object = match frame.inverse() {
            Ok(inverse) => inverse,
            Err(error) => return Err(self.refuse(&error.to_string())),
        };
        let mut copies = std::collections::HashMap::new();
        let parts = self.free_name("physvol");
        for (number, child) in children.iter().enumerate() {
            let volume = self.known_volume(&child.key)?;
            if volume.is_empty {
                continue;
            }
            let place =
                ComposedTransform::IDENTITY.then(&volume_from_object).then(&child.place).then(&volume.frame);
            let place = self.rounded(&place)?;
            let placement = self.placement(&place)?;
            let physvol = element.inner("physvol").with_parts_of(format!("{parts}-{number}"));
            let copy = copies.entry(child.key).or_insert(0);
            let physvol = self.physvol(physvol, child.label, &volume.name, *copy);
            *copy += 1;
            element.add(placed_by(physvol, &placement));
        }
        Ok(element)
    }

    /// A placement with its name and copy number; the name that it has without one is left out.
    fn physvol(&mut self, element: Xml, label: Option<&str>, volume: &str, copy: i32) -> Xml {
        let (name, copy) = match label {
            Some(label) => name_and_copy(label),
            None => ("", Some(copy).filter(|copy| *copy > 0)),
        };
        let mut element = element;
        if !name.is_empty() && name.strip_suffix("_PV") != Some(volume) {
            element = element.text("name", &self.xml_name(name));
        }
        if let Some(copy) = copy {
            element = element.number("copynumber", f64::from(copy));
        }
        element.reference("volumeref", volume)
    }

    /// A name for a volume that no other has.
    fn volume_name(&mut self, name: &str) -> String {
        let found = self.volume_names.free_for_geant4(name);
        if found != name {
            self.report
                .lose("names of several volumes were made different by endings, which Geant4 removes", name);
        }
        found
    }
}

/// Adds a position, the turn of the mother's frame and a mirror.
fn placed_by(physvol: Xml, placement: &Placement) -> Xml {
    let element = physvol.position("position", placement.position());
    let element = element.rotation("rotation", placement.degrees_of_volume());
    if !placement.is_mirrored() {
        return element;
    }
    element.scale(placement.mirror)
}
