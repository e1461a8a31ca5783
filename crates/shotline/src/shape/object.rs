//! Objects: the named shapes of a scene.

use std::fmt::{self, Debug, Formatter};
use std::sync::Arc;

use super::Shape;
use super::node::{NodeKind, ShapeNode};
use crate::scene::LocalTransform;

/// A shape with a name, a material and a priority: what hits and segments refer to.
///
/// ```
/// use shotline::prelude::*;
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let water = Object::new("water", Shape::sphere(0.9)?).material("water").priority(1);
/// let tank = Object::new("tank", Shape::sphere(1.0)?).material("steel").containing([water]);
/// let scene = Scene::of([tank.translate([0.0, 0.0, 3.0])])
///     .with_material("steel", Material { mu: Some(0.6), ..Material::default() })
///     .with_material("water", Material { mu: Some(0.1), ..Material::default() });
/// assert_eq!(scene.compile()?.object_names(), ["tank", "water"]);
/// # Ok(())
/// # }
/// ```
#[derive(Clone)]
#[must_use = "an object is never changed: use the result"]
pub struct Object {
    name: String,
    material: Option<String>,
    priority: i32,
    /// The shape; or a group of the shape and the objects that it contains.
    body: Arc<ShapeNode>,
    /// Whether `body` is that group.
    has_contents: bool,
}

impl Object {
    /// An object with a name and a shape, without a material, of priority 0.
    pub fn new(name: impl Into<String>, shape: impl Into<Shape>) -> Object {
        Object { name: name.into(), material: None, priority: 0, body: shape.into().0, has_contents: false }
    }

    /// The same object with a material, by its name in the scene. Compiling refuses a material that the scene does not
    /// have.
    pub fn material(self, name: impl Into<String>) -> Object {
        Object { material: Some(name.into()), ..self }
    }

    /// The same object with a priority. Where objects overlap, the one of the higher priority owns the segment.
    pub fn priority(self, priority: i32) -> Object {
        Object { priority, ..self }
    }

    /// The same object with other objects in it, given in its coordinates. They are transformed with it, and each
    /// remains an object of its own.
    pub fn containing(mut self, objects: impl IntoIterator<Item = Object>) -> Object {
        if !self.has_contents {
            self.body = Arc::new(ShapeNode::new(NodeKind::Group, vec![self.body]));
            self.has_contents = true;
        }
        Arc::make_mut(&mut self.body).children.extend(objects.into_iter().map(Object::into_node));
        self
    }

    pub(super) fn placed(&self, transform: LocalTransform) -> Object {
        Object { body: ShapeNode::placed(&self.body, transform), has_contents: false, ..self.clone() }
    }

    pub(super) fn into_node(self) -> Arc<ShapeNode> {
        let Object { name, material, priority, body, .. } = self;
        Arc::new(ShapeNode::new(NodeKind::Object { name, material, priority }, vec![body]))
    }
}

/// One line, without the nodes below the shape.
impl Debug for Object {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        let Object { name, material, priority, body, .. } = self;
        write!(f, "Object({name:?}, material {material:?}, priority {priority}, {body})")
    }
}
