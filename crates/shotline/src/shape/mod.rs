//! Scenes built with operators: shapes are combined and transformed, objects give them names, and
//! [`Scene::of`](crate::scene::Scene::of) makes a scene of objects.
//!
//! A [`Shape`] is a handle to an immutable node, so a clone is the same node: a shape that is used many times is one
//! node of the scene, compiled once. Nodes are only made from existing nodes, so there are no cycles. No function
//! recurses over them, so their depth is limited by memory only.

mod node;
mod object;
mod operators;
mod scene;
#[cfg(test)]
mod tests;
mod transforms;

use std::fmt::{self, Debug, Formatter};
use std::sync::Arc;

use node::{NodeKind, ShapeNode};

use crate::math::{Lattice, Vec3};
use crate::scene::Op;
use crate::solid::mesh::{MeshError, TriangleMesh};
use crate::solid::{InvalidSolid, Kind, ParamError, Params, every_constructor};

pub use object::Object;

/// A shape: a solid, a mesh, a combination or a group of shapes, or a transformed shape.
///
/// There is a constructor for every kind of solid, with its parameters in the order in which the kind declares them.
/// `a | b`, `a & b` and `a - b` combine shapes, by value or by reference. [`translate`](Shape::translate),
/// [`rotate`](Shape::rotate), [`scale`](Shape::scale) and [`transform`](Shape::transform) apply to the result so far,
/// so they act in the order in which they are written. None of them changes the shape itself; each returns a new one.
///
/// ```
/// use shotline::prelude::*;
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let drill = Shape::cylinder(0.4, 0.0, 1.0)?;
/// let block = Shape::cuboid([-3.0, -2.0, 0.0], [3.0, 2.0, 1.0])?;
/// let plate = block - drill.translate([-1.0, 0.0, 0.0]) - drill.translate([1.0, 0.0, 0.0]);
/// let scene = Scene::of([Object::new("plate", plate)]);
/// let world = scene.compile()?;
/// let ray = Ray::new(Vec3::new(-5.0, 0.0, 0.5), Vec3::X)?;
/// assert_eq!(Caster::new(&world).count(&ray, Span::FORWARD)?, 6);
///
/// let error = Shape::sphere(-1.0).unwrap_err();
/// assert_eq!(error.to_string(), "sphere: radius is -1, but must be positive");
/// # Ok(())
/// # }
/// ```
#[derive(Clone)]
#[must_use = "a shape is never changed: use the result"]
pub struct Shape(Arc<ShapeNode>);

/// The solids.
impl Shape {
    every_constructor!();

    /// A solid of a kind that is known only at run time: see [`kind`](crate::solid::kind) and [`Params::of`].
    ///
    /// # Errors
    /// [`InvalidSolid`] names the wrong parameter, its value and the requirement that it violates.
    pub fn solid(kind: &'static Kind, params: Params) -> Result<Shape, InvalidSolid> {
        let is_superfluous = |i: usize, name: &str| {
            !kind.params.iter().any(|param| param.name == name)
                || params.entries[..i].iter().any(|(earlier, _)| *earlier == name)
        };
        if let Some((_, (param, _))) =
            params.entries.iter().enumerate().find(|(i, (name, _))| is_superfluous(*i, name))
        {
            let why = "is given twice, or is not a parameter of this kind".into();
            return Err(InvalidSolid { kind: kind.name, error: ParamError { param, why } });
        }
        match kind.build(&params) {
            Ok(_) => Ok(Shape::new(NodeKind::Solid { kind, params }, [])),
            Err(error) => Err(InvalidSolid { kind: kind.name, error }),
        }
    }
}

/// Meshes, combinations and groups.
impl Shape {
    /// A triangle mesh: its vertices and, for each face, three vertex indices, counted from 0, counter-clockwise seen
    /// from outside. A mesh that is not closed is a surface: it can be hit, but not combined.
    ///
    /// # Errors
    /// [`MeshError`] names the wrong face or vertex and says how to correct it.
    pub fn mesh(
        vertices: impl IntoIterator<Item = impl Into<Vec3>>,
        faces: impl Into<Vec<[u32; 3]>>,
    ) -> Result<Shape, MeshError> {
        let vertices = vertices.into_iter().map(Into::into).collect();
        Shape::triangles(Arc::new(TriangleMesh::new(vertices, faces.into())))
    }

    /// A mesh that exists already, such as one read from a file. It is not copied.
    ///
    /// # Errors
    /// As [`Shape::mesh`].
    pub fn triangles(mesh: Arc<TriangleMesh>) -> Result<Shape, MeshError> {
        mesh.check()?;
        Ok(Shape::new(NodeKind::Mesh(mesh), []))
    }

    /// All points in any of the shapes, as `a | b`. Compiling refuses a union of no shapes.
    pub fn union(shapes: impl IntoIterator<Item = Shape>) -> Shape {
        Shape::new(NodeKind::Combination(Op::Union), shapes)
    }

    /// All points in each of the shapes, as `a & b`. Compiling refuses an intersection of no shapes.
    pub fn intersection(shapes: impl IntoIterator<Item = Shape>) -> Shape {
        Shape::new(NodeKind::Combination(Op::Intersection), shapes)
    }

    /// All points of this shape that are in none of the others, as `a - b`.
    pub fn difference(&self, others: impl IntoIterator<Item = Shape>) -> Shape {
        Shape::new(NodeKind::Combination(Op::Difference), std::iter::once(self.clone()).chain(others))
    }

    /// A collection of shapes without boolean meaning: each is a body of its own, with its own path and its own list of
    /// crossings. As an operand of a combination, a group counts as the union of its members.
    pub fn group(members: impl IntoIterator<Item = Shape>) -> Shape {
        Shape::new(NodeKind::Group, members)
    }

    /// Copies of this shape in the cells of a lattice: each is a body of its own, with its own path. Compiling refuses what is
    /// [not a lattice](Lattice::fault).
    ///
    /// ```
    /// use shotline::math::Lattice;
    /// use shotline::prelude::*;
    ///
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// let pins = Shape::cylinder(0.4, 0.0, 10.0)?.lattice(Lattice::rectangular([17, 17, 1], [1.26, 1.26, 0.0]));
    /// let world = Scene::of([Object::new("pins", pins)]).compile()?;
    /// let ray = Ray::new(Vec3::new(-5.0, 1.26, 5.0), Vec3::X)?;
    /// assert_eq!(Caster::new(&world).count(&ray, Span::FORWARD)?, 34);
    /// # Ok(())
    /// # }
    /// ```
    pub fn lattice(&self, lattice: Lattice) -> Shape {
        Shape::new(NodeKind::Lattice { lattice, table: None }, [self.clone()])
    }

    /// Copies of several shapes in the cells of a lattice. The table has the index of the shape of each cell, or
    /// [`EMPTY_CELL`](crate::scene::EMPTY_CELL): x runs fastest, then y, then z.
    pub fn lattice_of(
        elements: impl IntoIterator<Item = Shape>,
        lattice: Lattice,
        table: impl Into<Arc<[u32]>>,
    ) -> Shape {
        Shape::new(NodeKind::Lattice { lattice, table: Some(table.into()) }, elements)
    }

    /// The same shape with an accelerator of its own, by name (see [`accel::NAMES`](crate::accel::NAMES)); compiling
    /// refuses an unknown name. It applies to meshes, to combinations (that of the outermost is used), and to groups
    /// with several instances; for a single solid only the name is checked. No result depends on it.
    pub fn with_accel(&self, name: &'static str) -> Shape {
        // The accelerator belongs to the shape below the transforms, which are placed again around it.
        let (mut inner, mut transforms) = (&self.0, Vec::new());
        while let NodeKind::Placed(transform) = inner.kind {
            transforms.push(transform);
            inner = &inner.children[0];
        }
        let mut node = ShapeNode::clone(inner);
        node.accel = Some(name);
        let place = |node, transform| ShapeNode::placed(&node, transform);
        Shape(transforms.into_iter().rev().fold(Arc::new(node), place))
    }

    fn new(kind: NodeKind, children: impl IntoIterator<Item = Shape>) -> Shape {
        Shape(Arc::new(ShapeNode::new(kind, children.into_iter().map(|shape| shape.0).collect())))
    }
}

/// One line, without the children.
impl Debug for Shape {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        write!(f, "Shape({})", self.0)
    }
}
