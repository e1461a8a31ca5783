//! Orders of nodes, without recursion: scenes may be nested deeper than a stack allows.

use shotline::scene::{Node, NodeId, Scene};

/// The nodes at and below some nodes, children first, each once. `None` if there is a cycle, or a number of no node.
pub(super) fn postorder(scene: &Scene, from: impl Iterator<Item = NodeId>) -> Option<Vec<NodeId>> {
    let mut order = Vec::new();
    let mut states = vec![State::New; scene.nodes.len()];
    let mut todo: Vec<NodeId> = from.collect();
    todo.reverse();
    while let Some(id) = todo.last().copied() {
        let state = states.get_mut(id.0 as usize)?;
        match *state {
            State::New => {
                *state = State::Open;
                for child in scene.node(id).children().rev() {
                    match states.get(child.0 as usize)? {
                        State::New => todo.push(child),
                        State::Open => return None,
                        State::Done => {}
                    }
                }
            }
            State::Open => {
                *state = State::Done;
                order.push(id);
                todo.pop();
            }
            State::Done => {
                todo.pop();
            }
        }
    }
    Some(order)
}

#[derive(Clone, Copy, PartialEq)]
enum State {
    New,
    /// Its children are being visited.
    Open,
    Done,
}

/// The nodes of a shape that are not in `known`, children first. Objects within the shape are no part of it.
pub(super) fn parts_of_shape(scene: &Scene, shape: NodeId, known: impl Fn(NodeId) -> bool) -> Vec<NodeId> {
    let mut order = Vec::new();
    let mut visited = std::collections::HashSet::new();
    let mut todo = vec![(shape, false)];
    while let Some((id, is_left)) = todo.pop() {
        if is_left {
            order.push(id);
        } else if !known(id) && !matches!(scene.node(id), Node::Object { .. }) && visited.insert(id) {
            todo.push((id, true));
            todo.extend(scene.node(id).children().rev().map(|child| (child, false)));
        }
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;
    use shotline::scene::Op;

    #[test]
    fn children_come_first_and_cycles_are_found() {
        let mut scene = Scene::default();
        let ball = scene.add_solid("sphere", &[&[1.0]]).expect("a kind");
        let pair = scene.add_csg(Op::Union, vec![ball, ball]);
        let both = scene.add_csg(Op::Difference, vec![pair, ball]);
        assert_eq!(postorder(&scene, [both].into_iter()), Some(vec![ball, pair, both]));
        assert_eq!(parts_of_shape(&scene, both, |id| id == pair), [ball, both]);
        let end = scene.add(Node::Group { members: vec![both] });
        scene.nodes[ball.0 as usize] = Node::Group { members: vec![end] };
        assert_eq!(postorder(&scene, [both].into_iter()), None);
        scene.nodes[ball.0 as usize] = Node::Group { members: vec![NodeId(99)] };
        assert_eq!(postorder(&scene, [both].into_iter()), None);
    }
}
