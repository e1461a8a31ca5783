//! Scenes of which only some objects are shown.

use super::{Node, NodeId, Scene};

impl Scene {
    /// The same scene without the shapes of some objects, chosen by name. What they contain stays, also where it would count only
    /// inside them.
    #[must_use]
    pub fn hiding(&self, is_hidden: impl Fn(&str) -> bool) -> Scene {
        self.without_shapes(|_, name| is_hidden(name))
    }

    /// The same scene with the shapes of some objects, chosen by name, and of all that they contain, and no others.
    #[must_use]
    pub fn showing_only(&self, is_shown: impl Fn(&str) -> bool) -> Scene {
        let is_chosen = |node: &Node| matches!(node, Node::Object { name, .. } if is_shown(name));
        let mut is_seen = vec![false; self.nodes.len()];
        let ids = (0..).map(NodeId).zip(&self.nodes);
        let mut next: Vec<NodeId> = ids.filter(|(_, node)| is_chosen(node)).map(|(id, _)| id).collect();
        while let Some(id) = next.pop() {
            if !std::mem::replace(&mut is_seen[id.0 as usize], true) {
                next.extend(self.node(id).children());
            }
        }
        self.without_shapes(|id, _| !is_seen[id.0 as usize])
    }

    fn without_shapes(&self, is_hidden: impl Fn(NodeId, &str) -> bool) -> Scene {
        let mut scene = self.clone();
        let nothing = scene.add(Node::Group { members: Vec::new() });
        for (id, node) in (0..).map(NodeId).zip(&mut scene.nodes) {
            if let Node::Object { name, node, clip, .. } = node
                && is_hidden(id, name)
            {
                (*node, *clip) = (nothing, false);
            }
        }
        scene
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
}

#[cfg(test)]
mod tests {
    use crate::math::Vec3;
    use crate::prelude::*;
    use crate::scene::Scene;

    fn ball(name: &str, radius: f64) -> Object {
        Object::new(name, Shape::sphere(radius).expect("a ball"))
    }

    #[test]
    fn hidden_objects_are_not_met_and_their_contents_are() {
        let inner = ball("shell", 2.0).containing([ball("core", 1.0)]).clip();
        let scene = Scene::of([ball("world", 3.0).containing([inner]).clip()]);
        assert_eq!(scene.enclosures(), ["world"]);
        let ray = Ray::new(Vec3::X * -9.0, Vec3::X).expect("a ray");
        let first = |scene: &Scene| {
            let world = scene.compile().expect("a world");
            let hit = Caster::new(&world).closest(&ray, Span::FORWARD).expect("no budget").expect("a hit");
            (world.object_names()[hit.object as usize].clone(), hit.t)
        };
        assert_eq!(first(&scene), ("world".into(), 6.0));
        assert_eq!(first(&scene.hiding(|name| name == "world")), ("shell".into(), 7.0));
        assert_eq!(first(&scene.hiding(|name| name != "core")), ("core".into(), 8.0));
        assert_eq!(first(&scene.showing_only(|name| name == "shell")), ("shell".into(), 7.0));
        assert_eq!(first(&scene.showing_only(|name| name == "core")), ("core".into(), 8.0));
    }
}
