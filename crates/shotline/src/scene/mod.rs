//! The scene as plain data: a directed acyclic graph of nodes in one arena, objects, materials, camera, lights.
//! Nothing is checked here beyond the types; [`crate::compile`] checks the scene.

mod lattices;
mod motion;
mod placement;
mod units;
mod visibility;

use std::collections::HashMap;
use std::sync::Arc;

pub use crate::csg::Op;
pub use motion::Motion;
pub use placement::{LocalTransform, Rotation};
pub use units::Units;
pub use visibility::{HiddenObjects, UnknownObject};

use crate::math::{Affine, Lattice, Vec3};
use crate::solid::mesh::{TriangleMesh, Weld};
use crate::solid::{Kind, Params};

/// Index of a node in [`Scene::nodes`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct NodeId(pub u32);

/// The element of an empty cell in the table of a [`Node::Lattice`].
pub const EMPTY_CELL: u32 = u32::MAX;

/// A node of the graph. A node with several parents is shared: it is compiled once.
#[derive(Clone, Debug)]
pub enum Node {
    /// A solid given by parameters.
    Solid {
        /// Its kind.
        kind: &'static Kind,
        /// Its parameters.
        params: Params,
    },
    /// A triangle mesh.
    Mesh {
        /// The triangles.
        mesh: Arc<TriangleMesh>,
        /// The file it was read from; needed to write the scene back.
        file: Option<MeshFile>,
    },
    /// A boolean combination; a group below it counts as the union of its members.
    Csg {
        /// The operation.
        op: Op,
        /// The operands, at least one; those of a difference after the first are subtracted.
        args: Vec<NodeId>,
    },
    /// A collection without boolean meaning: each member is a body of its own, with its own path.
    Group {
        /// The members.
        members: Vec<NodeId>,
    },
    /// Copies of nodes in the cells of a lattice, each with a path of its own. A lattice of a billion cells takes no more
    /// memory than one of a single cell.
    Lattice {
        /// Where the cells are.
        lattice: Lattice,
        /// What the cells hold, at least one node.
        elements: Vec<NodeId>,
        /// The index of the element of each cell, or [`EMPTY_CELL`]: x runs fastest, then y, then z. `None` where every cell
        /// holds the first element.
        table: Option<Arc<[u32]>>,
    },
    /// A transform of a child.
    Transform {
        /// The transform: parent from local.
        transform: LocalTransform,
        /// The child.
        child: NodeId,
    },
    /// An object: gives its shape a name, a material and a priority. Not allowed below a boolean combination.
    ///
    /// It may contain other objects, which displace it where they are: those in `contents`, and those in the groups of its
    /// shape.
    Object {
        /// The name.
        name: String,
        /// The name of its material.
        material: Option<String>,
        /// Where objects overlap, the object of higher priority owns the segment.
        priority: i32,
        /// Its shape.
        node: NodeId,
        /// What it contains, in its coordinates: objects, and groups of them.
        contents: Vec<NodeId>,
        /// Whether what it contains counts only inside its shape.
        clip: bool,
    },
}

impl Node {
    /// The nodes directly below, in order: of an object its shape comes first.
    pub fn children(&self) -> impl DoubleEndedIterator<Item = NodeId> + '_ {
        let [first, others] = self.child_lists();
        first.iter().chain(others).copied()
    }

    /// The node directly below at an index.
    pub fn child(&self, index: usize) -> Option<NodeId> {
        let [first, others] = self.child_lists();
        first.get(index).or_else(|| others.get(index - first.len())).copied()
    }

    /// The cells of a lattice that are not empty, in order: the number of each, how far it is shifted, and what it holds. None
    /// for other nodes.
    pub fn cells(&self) -> impl Iterator<Item = (u32, Vec3, NodeId)> + '_ {
        let parts = match self {
            Node::Lattice { lattice, elements, table } => Some((lattice, elements, table)),
            _ => None,
        };
        let count = parts.map_or(0, |(lattice, ..)| lattice.cell_count() as u32);
        (0..count).filter_map(move |cell| {
            let (lattice, elements, table) = parts?;
            let element = table.as_ref().map_or(0, |table| table[cell as usize]);
            Some((cell, lattice.offset(lattice.indices(cell)), *elements.get(element as usize)?))
        })
    }

    /// How many cells of a lattice hold each of its elements; `None` for other nodes.
    pub fn element_uses(&self) -> Option<Vec<u64>> {
        let Node::Lattice { lattice, elements, table } = self else { return None };
        let mut uses = vec![0; elements.len()];
        match table {
            None => uses[..1].fill(lattice.cell_count()),
            Some(table) => {
                for &element in table.iter() {
                    // The empty cells have no element.
                    if let Some(count) = uses.get_mut(element as usize) {
                        *count += 1;
                    }
                }
            }
        }
        Some(uses)
    }

    /// The nodes directly below in two parts.
    fn child_lists(&self) -> [&[NodeId]; 2] {
        match self {
            Node::Solid { .. } | Node::Mesh { .. } => [&[], &[]],
            Node::Csg { args, .. } => [args, &[]],
            Node::Group { members } => [members, &[]],
            Node::Lattice { elements, .. } => [elements, &[]],
            Node::Transform { child, .. } => [std::slice::from_ref(child), &[]],
            Node::Object { node, contents, .. } => [std::slice::from_ref(node), contents],
        }
    }
}

/// The file that a mesh was read from, and what was done to the mesh on reading.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshFile {
    /// The path, relative to the scene's folder.
    pub name: String,
    /// The vertices that were welded, if any; the file itself is not welded.
    pub weld: Option<Weld>,
}

/// A whole scene.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// The unit of length, if the scene has one. Lengths are never converted.
    pub units: Option<Units>,
    /// All nodes, as an arena.
    pub nodes: Vec<Node>,
    /// Named nodes, which may be shared, in order of definition.
    pub defs: Vec<(String, NodeId)>,
    /// The roots, in order: each an [`Node::Object`], which may be transformed.
    pub objects: Vec<NodeId>,
    /// Materials by name, in order.
    pub materials: Vec<(String, Material)>,
    /// The camera, if the scene has one.
    pub camera: Option<Camera>,
    /// The lights, if the scene has any.
    pub lights: Vec<Light>,
    /// The accelerator of all nodes that have none of their own, by name (see [`crate::accel::NAMES`]).
    pub accel: Option<&'static str>,
    /// Accelerators of individual nodes: of meshes, of combinations (the outermost counts), and of groups that are
    /// placed several times; other groups are part of the level around them. No result depends on them.
    pub accels: HashMap<NodeId, &'static str>,
    /// The labels of transforms: what is placed by one is called so in the names of paths, instead of by its own name and its
    /// index in the group. An empty label leaves it out of the names.
    pub labels: HashMap<NodeId, String>,
    /// How objects move in an animation; at most one for each name.
    pub motions: Vec<Motion>,
}

/// What an object is made of. Everything is optional, so that a scene writes back as it was read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Material {
    /// Linear attenuation coefficient, per unit of length.
    pub mu: Option<f64>,
    /// Density in g/cm^3, whatever the unit of length; in a scene without units, mass per cubed length.
    pub density: Option<f64>,
    /// The elements that it is made of, each with its share of the mass. No query depends on them.
    pub composition: Vec<(String, f64)>,
    /// Colour as sRGB from 0 to 1.
    pub color: Option<[f64; 3]>,
    /// Strength of the highlight, from 0 to 1.
    pub specular: Option<f64>,
    /// Exponent of the highlight (Phong).
    pub shininess: Option<f64>,
    /// Fraction of the light that is reflected as by a mirror, from 0 to 1.
    pub mirror: Option<f64>,
}

/// A camera, in world coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Where the eye is.
    pub eye: Vec3,
    /// What it looks at.
    pub target: Vec3,
    /// The direction that points up in the picture.
    pub up: Vec3,
    /// The projection.
    pub lens: Lens,
}

/// A projection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lens {
    /// Perspective, with the vertical angle of view in degrees.
    Pinhole {
        /// The vertical angle of view, above 0 and below 180 degrees.
        fov: f64,
    },
    /// Parallel, with the height of the picture in world units.
    Orthographic {
        /// The height, positive.
        height: f64,
    },
}

/// A light.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// Where the light comes from.
    pub source: LightSource,
    /// Colour as sRGB from 0 to 1; white if absent.
    pub color: Option<[f64; 3]>,
    /// Strength; 1 if absent. It does not decrease with distance.
    pub intensity: Option<f64>,
}

/// Where light comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightSource {
    /// From a point.
    Point(Vec3),
    /// From far away, travelling in this direction.
    Directional(Vec3),
    /// From everywhere, without shadows.
    Ambient,
}

impl Scene {
    /// The same scene with a material by this name, for [objects](Node::Object) that are made of it.
    #[must_use]
    pub fn with_material(mut self, name: impl Into<String>, material: Material) -> Scene {
        self.materials.push((name.into(), material));
        self
    }

    /// The same scene in a unit of length.
    #[must_use]
    pub fn with_units(self, units: Units) -> Scene {
        Scene { units: Some(units), ..self }
    }

    /// Adds a node and returns its number.
    pub fn add(&mut self, node: Node) -> NodeId {
        let id = NodeId(u32::try_from(self.nodes.len()).expect("fewer than 2^32 nodes"));
        self.nodes.push(node);
        id
    }

    /// Returns the node with this number.
    pub fn node(&self, id: NodeId) -> &Node {
        &self.nodes[id.0 as usize]
    }

    /// Adds a solid by the name of its kind and its parameters in the order of declaration.
    /// `None` if there is no such kind.
    pub fn add_solid(&mut self, kind: &str, values: &[&[f64]]) -> Option<NodeId> {
        let kind = crate::solid::kind(kind)?;
        Some(self.add(Node::Solid { kind, params: Params::of(kind, values) }))
    }

    /// Adds a boolean combination.
    pub fn add_csg(&mut self, op: Op, args: Vec<NodeId>) -> NodeId {
        self.add(Node::Csg { op, args })
    }

    /// Adds a transform above a child.
    pub fn add_transform(&mut self, matrix: Affine, child: NodeId) -> NodeId {
        self.add(Node::Transform { transform: LocalTransform::Matrix(matrix), child })
    }

    /// Adds an object at the root.
    pub fn add_object(&mut self, name: &str, material: Option<&str>, node: NodeId) -> NodeId {
        let id = self.add(Node::Object {
            name: name.into(),
            material: material.map(Into::into),
            priority: 0,
            node,
            contents: Vec::new(),
            clip: false,
        });
        self.objects.push(id);
        id
    }
}
