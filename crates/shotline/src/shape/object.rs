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
    shape: Arc<ShapeNode>,
    contents: Vec<Arc<ShapeNode>>,
    clip: bool,
}

impl Object {
    /// An object with a name and a shape, without a material, of priority 0.
    pub fn new(name: impl Into<String>, shape: impl Into<Shape>) -> Object {
        let (name, shape) = (name.into(), shape.into().0);
        Object { name, material: None, priority: 0, shape, contents: Vec::new(), clip: false }
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

    /// The same object with other objects in it, given in its coordinates. They are transformed with it, each remains an
    /// object of its own, and each displaces this one where it is.
    pub fn containing(mut self, objects: impl IntoIterator<Item = Object>) -> Object {
        self.contents.extend(objects.into_iter().map(Object::into_node));
        self
    }

    /// The same object, of whose contents only what is inside its shape counts.
    pub fn clip(self) -> Object {
        Object { clip: true, ..self }
    }

    pub(super) fn placed(&self, transform: LocalTransform) -> Object {
        let placed = |node: &Arc<ShapeNode>| ShapeNode::placed(node, transform);
        Object {
            shape: placed(&self.shape),
            contents: self.contents.iter().map(placed).collect(),
            ..self.clone()
        }
    }

    pub(super) fn into_node(self) -> Arc<ShapeNode> {
        let Object { name, material, priority, shape, contents, clip } = self;
        let children = std::iter::once(shape).chain(contents).collect();
        Arc::new(ShapeNode::new(NodeKind::Object { name, material, priority, clip }, children))
    }
}

/// One line, without the nodes below the shape.
impl Debug for Object {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        let Object { name, material, priority, shape, contents, clip } = self;
        write!(f, "Object({name:?}, material {material:?}, priority {priority}, {shape}")?;
        if !contents.is_empty() {
            write!(f, ", containing {}{}", contents.len(), if *clip { ", clipped" } else { "" })?;
        }
        f.write_str(")")
    }
}
