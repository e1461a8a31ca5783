//! Which nodes of a scene become meshes.
//!
//! A part that is placed several times becomes a mesh once, if its copies are apart from everything else in their object.
//! Everything else in an object becomes one mesh.

use std::collections::HashMap;

use shotline::aabb::Aabb;
use shotline::compile::InvalidScene;
use shotline::scene::{LocalTransform, Node, NodeId, Scene};

use crate::apart::{cells_are_apart, clusters};
use crate::boxes::boxes;
use crate::graph::{matrix, postorder, scale_of_similarity};
use crate::uses::{Use, uses};

/// The most members of a group, and cells of a lattice, that are looked at one by one.
const MOST_MEMBERS: usize = 1 << 15;

/// A shape that becomes a mesh.
#[derive(Clone, Debug)]
pub struct Piece {
    /// The node that the mesh takes the place of.
    pub node: NodeId,
    /// The transforms from the object's root, outermost first, if the mesh is in world coordinates.
    pub placed: Vec<LocalTransform>,
    /// By how much it is enlarged where it is placed.
    pub stretch: f64,
    /// The object that it belongs to; the first, if it belongs to several.
    pub object: NodeId,
}

/// Which nodes become meshes.
pub struct Plan {
    /// The scene, in which groups are divided so that each piece is a node.
    pub scene: Scene,
    /// The pieces; none is below another one.
    pub pieces: Vec<Piece>,
}

/// What becomes of a node of a shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Role {
    /// It was not looked at.
    Undecided,
    /// It is made of meshes only, and stays.
    Kept,
    /// It becomes a mesh.
    Whole,
    /// Its children become meshes, or stay.
    Divided,
}

impl Plan {
    /// Decides what becomes a mesh in a valid scene, for meshes within a tolerance.
    pub fn of(scene: &Scene, tolerance: f64) -> Result<Plan, InvalidScene> {
        let mut scene = scene.clone();
        group_shapes_beside_objects(&mut scene);
        let order = postorder(&scene, &scene.objects);
        let uses = uses(&scene, &order);
        let mut division = Division::of(scene, &order, uses)?;
        order.into_iter().for_each(|id| division.decide(id, tolerance));
        let pieces = division.pieces();
        Ok(Plan { scene: division.scene, pieces })
    }
}

/// Puts the shapes of a group that also has objects into a group of their own, since they are one part of the object around them.
fn group_shapes_beside_objects(scene: &mut Scene) {
    let holds_objects = holds_objects(scene);
    for number in 0..scene.nodes.len() {
        let Node::Group { members } = &scene.nodes[number] else { continue };
        let (mut kept, shapes): (Vec<NodeId>, Vec<NodeId>) =
            members.iter().partition(|member| holds_objects[member.0 as usize]);
        if !kept.is_empty() && shapes.len() > 1 {
            kept.push(scene.add(Node::Group { members: shapes }));
            scene.nodes[number] = Node::Group { members: kept };
        }
    }
}

/// Whether each node is an object or has one below it.
fn holds_objects(scene: &Scene) -> Vec<bool> {
    let mut holds = vec![false; scene.nodes.len()];
    for id in postorder(scene, &scene.objects) {
        let node = scene.node(id);
        holds[id.0 as usize] =
            matches!(node, Node::Object { .. }) || node.children().any(|child| holds[child.0 as usize]);
    }
    holds
}

/// The state of a plan.
struct Division {
    scene: Scene,
    /// How nodes are placed; new ones like those that they are made of.
    uses: Vec<Use>,
    holds_objects: Vec<bool>,
    roles: Vec<Role>,
    /// How often the part below each node that is placed most often is.
    most_uses: Vec<f64>,
    /// Boxes around the members of groups that may be divided.
    boxes: HashMap<NodeId, Aabb>,
}

impl Division {
    fn of(scene: Scene, order: &[NodeId], uses: Vec<Use>) -> Result<Division, InvalidScene> {
        let holds_objects = holds_objects(&scene);
        let count = scene.nodes.len();
        let mut most_uses = vec![0.0; count];
        let mut shared = Vec::new();
        for id in order {
            let own = uses[id.0 as usize].count;
            let of_children = scene.node(*id).children().map(|child| most_uses[child.0 as usize]);
            let most = of_children.fold(own, f64::max);
            most_uses[id.0 as usize] = most;
            let is_collection = matches!(scene.node(*id), Node::Group { .. } | Node::Lattice { .. });
            if most > own && is_collection && !holds_objects[id.0 as usize] {
                shared.push(*id);
            }
        }
        let boxes = boxes(&scene, &shared)?;
        Ok(Division { roles: vec![Role::Undecided; count], scene, uses, holds_objects, most_uses, boxes })
    }

    /// Decides on a node, after those below it.
    fn decide(&mut self, id: NodeId, tolerance: f64) {
        let index = id.0 as usize;
        let (node, own) = (self.scene.node(id), self.uses[index].count);
        let is_kept = match node {
            Node::Mesh { .. } => true,
            Node::Solid { .. } | Node::Csg { .. } => false,
            _ => node.children().all(|child| self.roles[child.0 as usize] == Role::Kept),
        };
        let most = node.children().map(|child| self.most_uses[child.0 as usize]).fold(own, f64::max);
        let role = if self.holds_objects[index] {
            Role::Divided
        } else if is_kept {
            Role::Kept
        } else if most > own && self.divide(id, tolerance) {
            Role::Divided
        } else {
            Role::Whole
        };
        self.roles[index] = role;
        self.most_uses[index] = if role == Role::Divided { most } else { own };
    }

    /// Whether the parts of a node are apart. If only some are, the others become members of a group of their own.
    fn divide(&mut self, id: NodeId, tolerance: f64) -> bool {
        let gap = 2.0 * tolerance / self.uses[id.0 as usize].stretch;
        match self.scene.node(id) {
            Node::Transform { transform, .. } => scale_of_similarity(&matrix([transform])).is_some(),
            Node::Lattice { lattice, elements, .. } => {
                let around = elements.iter().map(|element| self.boxes[element]);
                let size = around.fold(Aabb::EMPTY, |all, one| all.union(&one)).size();
                cells_are_apart(lattice, size, gap)
            }
            Node::Group { members } if members.len() <= MOST_MEMBERS => {
                let boxes: Vec<Aabb> = members.iter().map(|member| self.boxes[member]).collect();
                let members = members.clone();
                let clusters = clusters(&boxes, gap);
                self.divide_group(id, &members, &clusters)
            }
            _ => false,
        }
    }

    /// Makes each cluster a member of a group, if a part that is placed more often than the group is alone in one.
    fn divide_group(&mut self, id: NodeId, members: &[NodeId], clusters: &[Vec<usize>]) -> bool {
        let alone = clusters.iter().filter(|cluster| cluster.len() == 1).map(|cluster| members[cluster[0]]);
        let most = alone.map(|member| self.most_uses[member.0 as usize]).fold(0.0, f64::max);
        if most <= self.uses[id.0 as usize].count {
            return false;
        }
        let new = clusters.iter().map(|cluster| match cluster[..] {
            [only] => members[only],
            _ => self.add_whole(id, cluster.iter().map(|member| members[*member]).collect()),
        });
        let members = new.collect();
        self.scene.nodes[id.0 as usize] = Node::Group { members };
        true
    }

    /// Adds a group of members of another, which becomes one mesh.
    fn add_whole(&mut self, group: NodeId, members: Vec<NodeId>) -> NodeId {
        let of_group = self.uses[group.0 as usize].clone();
        self.most_uses.push(of_group.count);
        self.uses.push(of_group);
        self.holds_objects.push(false);
        self.roles.push(Role::Whole);
        self.scene.add(Node::Group { members })
    }

    /// The nodes that become meshes.
    fn pieces(&mut self) -> Vec<Piece> {
        let mut pieces = Vec::new();
        let mut seen = vec![false; self.scene.nodes.len()];
        for root in 0..self.scene.objects.len() {
            let mut todo = vec![self.scene.objects[root]];
            if let Some((piece, object)) = self.in_world(todo[0]) {
                self.scene.objects[root] = object;
                pieces.push(piece);
                continue;
            }
            while let Some(id) = todo.pop() {
                let index = id.0 as usize;
                if std::mem::replace(&mut seen[index], true) {
                    continue;
                }
                match (self.roles[index], self.uses[index].object) {
                    (Role::Divided, _) => todo.extend(self.scene.node(id).children().rev()),
                    (Role::Whole, Some(object)) => {
                        let stretch = self.uses[index].stretch;
                        pieces.push(Piece { node: id, placed: Vec::new(), stretch, object });
                    }
                    _ => {}
                }
            }
        }
        pieces
    }

    /// The piece of a root in world coordinates, and its object, if nothing else is of this object or its shape.
    fn in_world(&self, root: NodeId) -> Option<(Piece, NodeId)> {
        let (mut id, mut placed) = (root, Vec::new());
        while let Node::Transform { transform, child } = self.scene.node(id) {
            placed.push(*transform);
            id = *child;
        }
        let Node::Object { node: shape, contents, .. } = self.scene.node(id) else { return None };
        let is_whole = self.roles[shape.0 as usize] == Role::Whole && contents.is_empty();
        let is_alone = self.uses[shape.0 as usize].count == 1.0;
        (is_whole && is_alone).then_some((Piece { node: *shape, placed, stretch: 1.0, object: id }, id))
    }
}
