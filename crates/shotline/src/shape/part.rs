//! The nodes behind shapes and objects.

use std::fmt::{self, Display, Formatter};
use std::sync::Arc;

use crate::scene::{LocalTransform, Op};
use crate::solid::mesh::TriangleMesh;
use crate::solid::{Kind, Params};

/// A node with those below it; each becomes one node of the scene.
#[derive(Clone)]
pub(super) struct Part {
    pub what: What,
    pub accel: Option<&'static str>,
    pub children: Vec<Arc<Part>>,
}

/// What a node is by itself.
#[derive(Clone)]
pub(super) enum What {
    Solid {
        kind: &'static Kind,
        params: Params,
    },
    Mesh(Arc<TriangleMesh>),
    Combination(Op),
    Group,
    /// A placed child.
    Placed(LocalTransform),
    /// An object; its child is its shape.
    Object {
        name: String,
        material: Option<String>,
        priority: i32,
    },
}

impl Part {
    pub(super) fn new(what: What, children: Vec<Arc<Part>>) -> Part {
        Part { what, accel: None, children }
    }

    pub(super) fn placed(child: &Arc<Part>, transform: LocalTransform) -> Arc<Part> {
        Arc::new(Part::new(What::Placed(transform), vec![child.clone()]))
    }
}

/// Without recursion: each node gives its children away before it is dropped, if nothing else holds it.
impl Drop for Part {
    fn drop(&mut self) {
        let mut pending = std::mem::take(&mut self.children);
        while let Some(part) = pending.pop() {
            if let Some(mut part) = Arc::into_inner(part) {
                pending.append(&mut part.children);
            }
        }
    }
}

/// The node without what is below it.
impl Display for Part {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        match &self.what {
            What::Solid { kind, params } => {
                f.write_str(kind.name)?;
                params.entries.iter().try_for_each(|(name, numbers)| match **numbers {
                    [number] => write!(f, " {name}={number}"),
                    _ => write!(f, " {name}={numbers:?}"),
                })
            }
            What::Mesh(mesh) => write!(f, "mesh of {} faces", mesh.faces.len()),
            What::Combination(op) => write!(f, "{} of {}", op.name(), self.children.len()),
            What::Group => write!(f, "group of {}", self.children.len()),
            What::Placed(_) => f.write_str("placed"),
            What::Object { name, .. } => write!(f, "object {name:?}"),
        }
    }
}
