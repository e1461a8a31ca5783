//! Membership by brute force: tests a point against a node of the scene without compilation, sweep or boxes.

use crate::math::{Affine, ComposedTransform, Vec3};
use crate::scene::{Node, NodeId, Op, Scene};
use crate::solid::Parts;
use crate::solid::mesh::MeshSolid;

/// A node prepared for point tests.
#[derive(Debug)]
enum PreparedNode {
    Parts(Parts),
    Moved(Affine, NodeId),
    Combined(Op, Vec<NodeId>),
    /// Shifted copies of nodes.
    Copies(Vec<(Vec3, NodeId)>),
}

/// A scene prepared for point tests. Deep scenes need a deep stack.
#[derive(Debug)]
pub struct Membership {
    nodes: Vec<PreparedNode>,
}

impl Membership {
    /// Prepares a scene that compiles without errors.
    ///
    /// # Panics
    /// If the scene does not compile.
    pub fn of(scene: &Scene) -> Membership {
        Membership { nodes: scene.nodes.iter().map(prepare).collect() }
    }

    /// Whether a point lies in the interior of a node.
    pub fn contains(&self, node: NodeId, p: Vec3) -> bool {
        match &self.nodes[node.0 as usize] {
            PreparedNode::Parts(parts) => parts.contains(p),
            PreparedNode::Moved(local_from_parent, child) => {
                self.contains(*child, local_from_parent.point(p))
            }
            PreparedNode::Copies(copies) => {
                copies.iter().any(|(shift, child)| self.contains(*child, p - *shift))
            }
            PreparedNode::Combined(op, args) => {
                let mut values = args.iter().map(|arg| self.contains(*arg, p));
                match op {
                    Op::Union => values.any(|v| v),
                    Op::Intersection => values.all(|v| v),
                    Op::Difference => values.next() == Some(true) && !values.any(|v| v),
                }
            }
        }
    }

    /// Whether membership differs from the expected value at a point and at a thousand points around it. A point
    /// on a surface, or within rounding of it, refutes nothing.
    pub fn certainly_differs(&self, node: NodeId, p: Vec3, reach: f64, expected: bool) -> bool {
        let wrong = |q: Vec3| self.contains(node, q) != expected;
        wrong(p) && spread(1000).all(|direction| wrong(p + direction * reach))
    }
}

/// Directions spread evenly over the sphere, along a spiral in steps of the golden angle.
fn spread(count: u32) -> impl Iterator<Item = Vec3> {
    (0..count).map(move |i| {
        let z = 1.0 - f64::from(2 * i + 1) / f64::from(count);
        let (sin, cos) = libm::sincos(f64::from(i) * 2.399963229728653);
        let rho = (1.0 - z * z).sqrt();
        Vec3::new(rho * cos, rho * sin, z)
    })
}

fn prepare(node: &Node) -> PreparedNode {
    match node {
        Node::Solid { kind, params } => {
            PreparedNode::Parts(kind.build(params).expect("a solid that was compiled"))
        }
        Node::Mesh { mesh, .. } => PreparedNode::Parts(Parts::of(
            MeshSolid::new(mesh.clone(), "brute").expect("a mesh that was compiled"),
        )),
        Node::Transform { transform, child } => {
            let placement = transform.inside(&ComposedTransform::IDENTITY).placement();
            PreparedNode::Moved(placement.expect("a transform that was compiled").local_from_parent, *child)
        }
        Node::Csg { op, args } => PreparedNode::Combined(*op, args.clone()),
        Node::Group { members } => PreparedNode::Combined(Op::Union, members.clone()),
        Node::Lattice { .. } => {
            PreparedNode::Copies(node.cells().map(|(_, shift, child)| (shift, child)).collect())
        }
        Node::Object { node, .. } => PreparedNode::Combined(Op::Union, vec![*node]),
    }
}
