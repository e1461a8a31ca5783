//! Checks the lattices of a scene.

use super::SceneError;
use crate::scene::{EMPTY_CELL, Node, NodeId, Scene};

/// One error for each lattice whose parameters or table are wrong.
pub(super) fn check(scene: &Scene) -> Vec<SceneError> {
    let fault = |id: NodeId| {
        let Node::Lattice { lattice, elements, table } = scene.node(id) else { return None };
        let error = |param: &'static str, message: String| {
            Some(SceneError { param: Some(param), ..SceneError::at(id, message) })
        };
        if elements.is_empty() {
            return error("args", "a lattice has at least one element".into());
        }
        if let Some((param, must)) = lattice.fault() {
            return error(param, format!("the {param} of a lattice {must}"));
        }
        let Some(table) = table else { return None };
        if table.len() as u64 != lattice.cell_count() {
            let message =
                format!("{} cells are listed of a lattice of {}", table.len(), lattice.cell_count());
            return error("cells", message);
        }
        let is_known = |&element: &u32| element == EMPTY_CELL || (element as usize) < elements.len();
        let wrong = table.iter().position(|element| !is_known(element))?;
        let most = elements.len() - 1;
        error(
            "cells",
            format!("cell {wrong} of a lattice holds element {}, but the last is {most}", table[wrong]),
        )
    };
    (0..scene.nodes.len() as u32).filter_map(|id| fault(NodeId(id))).collect()
}
