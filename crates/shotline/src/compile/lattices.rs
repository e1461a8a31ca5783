//! Checks the lattices of a scene.

use super::SceneError;
use crate::scene::{EMPTY_CELL, Node, NodeId, Scene};

/// One error for each lattice whose parameters or table are wrong.
pub(super) fn check(scene: &Scene) -> Vec<SceneError> {
    (0..scene.nodes.len() as u32).filter_map(|id| fault(scene, NodeId(id))).collect()
}

fn fault(scene: &Scene, id: NodeId) -> Option<SceneError> {
    let Node::Lattice { lattice, elements, table } = scene.node(id) else { return None };
    let error = |param: &'static str, message: String, hint: &str| {
        Some(SceneError { param: Some(param), ..SceneError::at(id, message) }.with_hint(hint))
    };
    if elements.is_empty() {
        return error("args", "a lattice needs at least one element".into(), "say what its cells hold");
    }
    if let Some((param, must)) = lattice.fault() {
        let hint = "lattices of lattices may have more cells, and a transform may turn rows over";
        return error(param, format!("the {param} of a lattice {must}"), hint);
    }
    let table = table.as_ref()?;
    if table.len() as u64 != lattice.cell_count() {
        let message = format!("a lattice of {} cells has {} in its table", lattice.cell_count(), table.len());
        return error("cells", message, "list each cell: x runs fastest, then y, then z");
    }
    let is_known = |&element: &u32| element == EMPTY_CELL || (element as usize) < elements.len();
    let wrong = table.iter().position(|element| !is_known(element))?;
    let most = elements.len() - 1;
    let message = format!("cell {wrong} of a lattice holds element {}, but the last is {most}", table[wrong]);
    error("cells", message, "elements are counted from 0")
}
