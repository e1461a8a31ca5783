//! Which objects of a scene are shown.

use super::{Node, NodeId, Scene};

/// The objects of a scene that are not shown. What they contain may be shown.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct HiddenObjects {
    /// By node; nodes beyond the end are shown.
    nodes: Vec<bool>,
}

/// No object has a name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no object is named '{0}'")]
pub struct UnknownObject(
    /// The name.
    pub String,
);

impl HiddenObjects {
    /// Whether every object is shown.
    pub fn is_empty(&self) -> bool {
        !self.nodes.contains(&true)
    }

    fn contains(&self, id: NodeId) -> bool {
        self.nodes.get(id.0 as usize).copied().unwrap_or(false)
    }

    /// Whether an object of a scene is hidden and contains nothing that could be shown.
    pub fn is_all_of(&self, scene: &Scene, id: NodeId) -> bool {
        self.contains(id) && matches!(scene.node(id), Node::Object { contents, .. } if contents.is_empty())
    }

    /// Tells by the number of an object in the world of the scene whether it is hidden.
    pub fn by_number(&self, scene: &Scene) -> Vec<bool> {
        scene.numbered_objects().into_iter().map(|id| self.contains(id)).collect()
    }
}

impl Scene {
    /// Hides the objects of some names, but not what they contain. In a name `*` stands for any letters.
    ///
    /// # Errors
    /// If no object has one of the names.
    pub fn hiding(&self, names: &[impl AsRef<str>]) -> Result<HiddenObjects, UnknownObject> {
        self.know(names)?;
        Ok(self.hidden(|_, name| names.iter().any(|pattern| matches_name(pattern.as_ref(), name))))
    }

    /// Hides all objects but those of some names and what they contain. In a name `*` stands for any letters.
    ///
    /// # Errors
    /// If no object has one of the names.
    pub fn showing_only(&self, names: &[impl AsRef<str>]) -> Result<HiddenObjects, UnknownObject> {
        self.know(names)?;
        let is_named = |name: &str| names.iter().any(|pattern| matches_name(pattern.as_ref(), name));
        let is_chosen = |node: &Node| matches!(node, Node::Object { name, .. } if is_named(name));
        let chosen = self.ids().filter(|&id| is_chosen(self.node(id))).collect();
        let mut is_shown = vec![false; self.nodes.len()];
        self.visit_below(chosen, &mut is_shown, |_| {});
        Ok(self.hidden(|id, _| !is_shown[id.0 as usize]))
    }

    /// Hides [`Scene::enclosures`].
    pub fn hiding_enclosures(&self) -> HiddenObjects {
        let enclosures = self.enclosures();
        self.hidden(|_, name| enclosures.contains(&name))
    }

    fn know(&self, names: &[impl AsRef<str>]) -> Result<(), UnknownObject> {
        let is_known = |pattern: &str| {
            self.nodes
                .iter()
                .any(|node| matches!(node, Node::Object { name, .. } if matches_name(pattern, name)))
        };
        let unknown = names.iter().map(AsRef::as_ref).find(|name| !is_known(name));
        unknown.map_or(Ok(()), |name| Err(UnknownObject(name.to_owned())))
    }

    /// The same scene without the shapes of the objects that are hidden. What they contain stays, also where it would count only
    /// inside them.
    #[must_use]
    pub fn without(&self, hidden: &HiddenObjects) -> Scene {
        let mut scene = self.clone();
        let nothing = scene.add(Node::Group { members: Vec::new() });
        for (id, node) in (0..).map(NodeId).zip(&mut scene.nodes) {
            if let Node::Object { node, clip, .. } = node
                && hidden.contains(id)
            {
                (*node, *clip) = (nothing, false);
            }
        }
        scene
    }

    /// Whether an object contains others, or objects differ in priority: then one owns a point where several are.
    pub fn has_owners(&self) -> bool {
        let mut priorities = self.nodes.iter().filter_map(|node| match node {
            Node::Object { priority, .. } => Some(priority),
            _ => None,
        });
        let first = priorities.next();
        self.is_nested() || priorities.any(|priority| Some(priority) != first)
    }

    /// Whether an object contains others.
    fn is_nested(&self) -> bool {
        let is_object = |id: NodeId| matches!(self.node(id), Node::Object { .. });
        let parts = self.ids().filter(|&id| is_object(id)).flat_map(|id| self.node(id).children());
        let (mut seen, mut is_nested) = (vec![false; self.nodes.len()], false);
        self.visit_below(parts.collect(), &mut seen, |id| is_nested |= is_object(id));
        is_nested
    }

    /// The names of the roots that contain other objects and clip them, as the world volume of a detector does: from outside
    /// nothing else is seen.
    pub fn enclosures(&self) -> Vec<&str> {
        let object = |mut id: NodeId| {
            // Not longer than the scene: the nodes may have a cycle.
            for _ in &self.nodes {
                match self.node(id) {
                    Node::Transform { child, .. } => id = *child,
                    Node::Object { name, clip: true, contents, .. } if !contents.is_empty() => {
                        return Some(name.as_str());
                    }
                    _ => return None,
                }
            }
            None
        };
        self.objects.iter().filter_map(|&id| object(id)).collect()
    }

    /// The objects in the order of their numbers in a world: depth first, each root followed by what is inside it.
    pub fn numbered_objects(&self) -> Vec<NodeId> {
        let (mut seen, mut objects) = (vec![false; self.nodes.len()], Vec::new());
        self.visit_below(self.objects.iter().rev().copied().collect(), &mut seen, |id| {
            if let Node::Object { .. } = self.node(id) {
                objects.push(id);
            }
        });
        objects
    }

    fn ids(&self) -> impl Iterator<Item = NodeId> + use<> {
        (0..self.nodes.len() as u32).map(NodeId)
    }

    fn hidden(&self, is_hidden: impl Fn(NodeId, &str) -> bool) -> HiddenObjects {
        let of_node = |id: NodeId| matches!(self.node(id), Node::Object { name, .. } if is_hidden(id, name));
        HiddenObjects { nodes: self.ids().map(of_node).collect() }
    }

    /// Visits some nodes, the last one first, and those below them, depth first and each once.
    fn visit_below(&self, mut next: Vec<NodeId>, seen: &mut [bool], mut visit: impl FnMut(NodeId)) {
        while let Some(id) = next.pop() {
            if !std::mem::replace(&mut seen[id.0 as usize], true) {
                visit(id);
                next.extend(self.node(id).children().rev());
            }
        }
    }
}

/// Whether a name is one that a pattern stands for: the parts between the stars follow each other in it.
fn matches_name(pattern: &str, name: &str) -> bool {
    let mut parts = pattern.split('*');
    let first = parts.next().unwrap_or_default();
    let Some(mut rest) = name.strip_prefix(first) else { return false };
    let Some(last) = parts.next_back() else { return rest.is_empty() };
    for part in parts {
        match rest.find(part) {
            Some(at) => rest = &rest[at + part.len()..],
            None => return false,
        }
    }
    rest.ends_with(last)
}

#[cfg(test)]
mod tests {
    use super::{UnknownObject, matches_name};
    use crate::math::Vec3;
    use crate::prelude::*;
    use crate::scene::{HiddenObjects, Scene};

    fn ball(name: &str, radius: f64) -> Object {
        Object::new(name, Shape::sphere(radius).expect("a ball"))
    }

    fn nest() -> Scene {
        let inner = ball("shell", 2.0).containing([ball("core", 1.0)]).clip();
        Scene::of([ball("moon", 0.1).translate(Vec3::Y * 9.0), ball("world", 3.0).containing([inner]).clip()])
    }

    #[test]
    fn hidden_objects_are_not_met_and_their_contents_are() {
        let scene = nest();
        assert_eq!(scene.enclosures(), ["world"]);
        let ray = Ray::new(Vec3::X * -9.0, Vec3::X).expect("a ray");
        let first = |hidden: HiddenObjects| {
            let world = scene.without(&hidden).compile().expect("a world");
            let hit = Caster::new(&world).closest(&ray, Span::FORWARD).expect("no budget").expect("a hit");
            (world.object_names()[hit.object as usize].clone(), hit.t)
        };
        assert_eq!(first(HiddenObjects::default()), ("world".into(), 6.0));
        let hiding = |names: &[&str]| first(scene.hiding(names).expect("known names"));
        let only = |name: &str| first(scene.showing_only(&[name]).expect("a known name"));
        assert_eq!(hiding(&["world"]), ("shell".into(), 7.0));
        assert_eq!(first(scene.hiding_enclosures()), ("shell".into(), 7.0));
        assert_eq!(hiding(&["w*", "s*l"]), ("core".into(), 8.0));
        assert_eq!((only("shell"), only("c*")), (("shell".into(), 7.0), ("core".into(), 8.0)));
        assert_eq!(scene.hiding(&["core", "cor"]), Err(UnknownObject("cor".into())));
        assert_eq!(scene.showing_only(&["*x"]), Err(UnknownObject("*x".into())));
    }

    #[test]
    fn hidden_objects_have_the_numbers_of_the_world() {
        let scene = nest();
        let world = scene.compile().expect("a world");
        for name in world.object_names() {
            let numbers = scene.hiding(&[name]).expect("its name").by_number(&scene);
            let names = world.object_names().iter();
            assert_eq!(numbers, names.map(|other| other == name).collect::<Vec<_>>());
        }
        let nothing = scene.hiding(&[] as &[&str]).expect("no names");
        assert!(nothing.is_empty() && HiddenObjects::default().is_empty());
    }

    #[test]
    fn objects_in_objects_are_nested() {
        assert!(nest().has_owners());
        assert!(!Scene::of([ball("a", 1.0), ball("b", 2.0)]).has_owners());
        assert!(Scene::of([ball("a", 1.0), ball("b", 2.0).priority(1)]).has_owners());
    }

    #[test]
    fn a_star_stands_for_any_letters() {
        for (pattern, name) in [
            ("a", "a"),
            ("*", ""),
            ("*", "x"),
            ("a*", "a0x1"),
            ("*b", "ab"),
            ("a*c*e", "abcde"),
            ("a**", "ab"),
            ("é*", "éa"),
        ] {
            assert!(matches_name(pattern, name), "{pattern} {name}");
        }
        for (pattern, name) in
            [("a", "ab"), ("b", "ab"), ("a*", "b"), ("a*a", "a"), ("*c*b", "abc"), ("", "a")]
        {
            assert!(!matches_name(pattern, name), "{pattern} {name}");
        }
    }
}
