//! The nodes behind shapes and objects.

use std::fmt::{self, Display, Formatter};
use std::sync::Arc;

use crate::math::Lattice;
use crate::scene::{LocalTransform, Op};
use crate::solid::mesh::TriangleMesh;
use crate::solid::{Kind, Layout, Params};

/// A node with its children; each becomes one node of the scene.
#[derive(Clone)]
pub(super) struct ShapeNode {
    pub kind: NodeKind,
    pub accel: Option<&'static str>,
    pub children: Vec<Arc<ShapeNode>>,
}

/// The content of a node, without its children.
#[derive(Clone)]
pub(super) enum NodeKind {
    Solid {
        kind: &'static Kind,
        params: Params,
    },
    Mesh(Arc<TriangleMesh>),
    Combination(Op),
    Group,
    Lattice {
        lattice: Lattice,
        table: Option<Arc<[u32]>>,
    },
    /// A transformed child.
    Placed(LocalTransform),
    /// An object; its children are its shape, and what it contains.
    Object {
        name: String,
        material: Option<String>,
        priority: i32,
        clip: bool,
    },
}

impl ShapeNode {
    pub(super) fn new(kind: NodeKind, children: Vec<Arc<ShapeNode>>) -> ShapeNode {
        ShapeNode { kind, accel: None, children }
    }

    pub(super) fn placed(child: &Arc<ShapeNode>, transform: LocalTransform) -> Arc<ShapeNode> {
        Arc::new(ShapeNode::new(NodeKind::Placed(transform), vec![child.clone()]))
    }
}

/// Not recursive, since nodes may be deep: the children of a node that nothing else refers to are moved to a list
/// before the node is dropped.
impl Drop for ShapeNode {
    fn drop(&mut self) {
        let mut pending = std::mem::take(&mut self.children);
        while let Some(node) = pending.pop() {
            if let Some(mut node) = Arc::into_inner(node) {
                pending.append(&mut node.children);
            }
        }
    }
}

/// The node without its children.
impl Display for ShapeNode {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        match &self.kind {
            NodeKind::Solid { kind, params } => {
                f.write_str(kind.name)?;
                params.entries.iter().try_for_each(|(name, numbers)| match (kind.layout(name), &**numbers) {
                    (Some(Layout::Rows { columns, .. }), numbers) => {
                        let rows: Vec<_> = numbers.chunks(columns.len()).collect();
                        write!(f, " {name}={rows:?}")
                    }
                    (_, [number]) => write!(f, " {name}={number}"),
                    _ => write!(f, " {name}={numbers:?}"),
                })
            }
            NodeKind::Mesh(mesh) => write!(f, "mesh of {} faces", mesh.faces.len()),
            NodeKind::Combination(op) => write!(f, "{} of {}", op.name(), self.children.len()),
            NodeKind::Group => write!(f, "group of {}", self.children.len()),
            NodeKind::Lattice { lattice, .. } => write!(f, "lattice of {}", lattice.cell_count()),
            NodeKind::Placed(_) => f.write_str("placed"),
            NodeKind::Object { name, .. } => write!(f, "object {name:?}"),
        }
    }
}
