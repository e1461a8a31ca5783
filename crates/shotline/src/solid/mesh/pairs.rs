//! Finds pairs of items that come near to each other without testing all pairs.
//!
//! Items go into a tree of oriented boxes, which is traversed against itself. That alone would still visit all pairs of
//! items with a common corner, such as the faces of a fan, because all their boxes hold the corner. So corners of many
//! items are *hubs*. Items are grouped by their hubs, and no pair with a common hub is visited; the caller must find
//! those pairs by other means.
//!
//! Items without area are left out against each other: along a line there may be very many, and nothing is between them.

use std::collections::HashMap;

use rayon::prelude::*;

use super::effort::{Effort, Steps};
use super::obb::Obb;
use crate::math::Vec3;

/// A corner of more items than this is a hub.
const HUB: usize = 24;

/// Trees of more items than this are built and traversed in parallel.
const MANY: usize = 2048;

/// A convex set: the hull of its points, some of which may be equal.
#[derive(Clone, Copy, Debug)]
pub(super) struct Item {
    pub(super) points: [Vec3; 4],
    /// The indices of its corners, each once; [`NONE`] in unused entries.
    pub(super) corners: [u32; 3],
    /// Whether the face that it stands for has no area.
    pub(super) has_no_area: bool,
}

/// Marks an unused entry.
pub(super) const NONE: u32 = u32::MAX;

/// Items prepared for a search for pairs.
pub(super) struct Pairs<'a> {
    items: &'a [Item],
    groups: Vec<Group>,
    root: Option<Node>,
    effort: &'a Effort<'a>,
    /// The items at each hub.
    pub(super) hubs: Vec<(u32, Vec<u32>)>,
}

/// What the items of a group have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
struct Group {
    /// Their hubs in ascending order; [`NONE`] in unused entries.
    hubs: [u32; 3],
    have_no_area: bool,
}

impl Group {
    /// Whether no pairs of one item of each group are visited.
    fn is_left_out_against(&self, other: &Group) -> bool {
        let is_shared = |hub: &u32| *hub != NONE && other.hubs.contains(hub);
        self.have_no_area && other.have_no_area || self.hubs.iter().any(is_shared)
    }
}

struct Node {
    bounds: Obb,
    /// The group, if all items below the node belong to one.
    group: Option<u32>,
    below: Below,
}

enum Below {
    Items(Vec<u32>),
    Nodes(Box<[Node; 2]>),
}

impl<'a> Pairs<'a> {
    /// Prepares a search. Once the effort is over, this and all later calls return early with incomplete results.
    pub(super) fn of(items: &'a [Item], effort: &'a Effort<'a>) -> Pairs<'a> {
        let mut at_corner: HashMap<u32, Vec<u32>> = HashMap::new();
        for (i, item) in (0..).zip(items) {
            if effort.is_over() {
                break;
            }
            for corner in item.corners.into_iter().filter(|c| *c != NONE) {
                at_corner.entry(corner).or_default().push(i);
            }
        }
        at_corner.retain(|_, items| items.len() > HUB);
        let group_of = |item: &Item| {
            let mut hubs = item.corners.map(|c| if at_corner.contains_key(&c) { c } else { NONE });
            hubs.sort_unstable();
            Group { hubs, have_no_area: item.has_no_area }
        };
        let mut grouped: HashMap<Group, Vec<u32>> = HashMap::new();
        let numbered = (0..).zip(items).take_while(|_| !effort.is_over());
        numbered.for_each(|(i, item)| grouped.entry(group_of(item)).or_default().push(i));
        let mut grouped: Vec<_> = grouped.into_iter().collect();
        grouped.sort_unstable();
        let nodes = (0..).zip(&mut grouped).map(|(g, (_, members))| within_group(items, members, g, effort));
        let root = over_groups(nodes.collect());
        let mut hubs: Vec<_> = at_corner.into_iter().collect();
        hubs.sort_unstable();
        Pairs { items, groups: grouped.into_iter().map(|(group, _)| group).collect(), root, effort, hubs }
    }

    /// Visits once every pair of items whose hulls have a common point, except pairs with a common hub and pairs of items
    /// without area. Some other pairs that are near to each other are visited too. `merge` combines the results of visits.
    pub(super) fn visit<S: Default + Send>(
        &self,
        visit: &(impl Fn(u32, u32, &mut S) + Sync),
        merge: &(impl Fn(S, S) -> S + Sync),
    ) -> S {
        let traversal = PairTraversal { pairs: self, visit, merge };
        self.root.as_ref().map_or_else(S::default, |root| traversal.within(root, self.items.len()))
    }

    /// Whether no pairs of one item of each node are visited.
    fn are_left_out(&self, a: &Node, b: &Node) -> bool {
        let group = |node: &Node| node.group.map(|g| &self.groups[g as usize]);
        group(a).zip(group(b)).is_some_and(|(a, b)| a.is_left_out_against(b))
    }
}

/// Builds a tree over the items of a group.
fn within_group(items: &[Item], members: &mut [u32], group: u32, effort: &Effort) -> Node {
    let points = |i: &u32| items[*i as usize].points;
    let bounds = Obb::around(members.iter().flat_map(points));
    let middle = |i: &u32| points(i).iter().sum::<Vec3>();
    let below = if members.len() <= 2 || effort.is_over() {
        Below::Items(members.to_vec())
    } else {
        let axis = bounds.widest_axis(members.iter().map(|i| middle(i) / 4.0));
        let half = members.len() / 2;
        // Ties are broken by index, so that the tree is deterministic.
        members.select_nth_unstable_by(half, |i, j| {
            middle(i).dot(axis).total_cmp(&middle(j).dot(axis)).then(i.cmp(j))
        });
        let (a, b) = members.split_at_mut(half);
        let (mut build_a, mut build_b) =
            ((|| within_group(items, a, group, effort)), (|| within_group(items, b, group, effort)));
        let (a, b) = if half > MANY { rayon::join(build_a, build_b) } else { (build_a(), build_b()) };
        Below::Nodes(Box::new([a, b]))
    };
    Node { bounds, group: Some(group), below }
}

/// Builds a tree over the trees of groups.
fn over_groups(mut nodes: Vec<Node>) -> Option<Node> {
    if nodes.len() <= 1 {
        return nodes.pop();
    }
    let centres = nodes.iter().map(|node| node.bounds.centre());
    let axis = Obb::around(centres.clone()).widest_axis(centres);
    nodes.sort_by(|a, b| a.bounds.centre().dot(axis).total_cmp(&b.bounds.centre().dot(axis)));
    let after = nodes.split_off(nodes.len() / 2);
    let (a, b) = (over_groups(nodes)?, over_groups(after)?);
    Some(Node { bounds: a.bounds.union(&b.bounds), group: None, below: Below::Nodes(Box::new([a, b])) })
}

/// A traversal of a tree against itself.
struct PairTraversal<'a, V, M> {
    pairs: &'a Pairs<'a>,
    visit: &'a V,
    merge: &'a M,
}

impl<V, M> PairTraversal<'_, V, M> {
    /// Visits the pairs below a node of about `items` items, distributed over threads.
    fn within<S: Default + Send>(&self, node: &Node, items: usize) -> S
    where
        V: Fn(u32, u32, &mut S) + Sync,
        M: Fn(S, S) -> S + Sync,
    {
        let half = items / 2;
        match &node.below {
            Below::Nodes(nodes) if half > MANY && !self.pairs.are_left_out(node, node) => {
                let [a, b] = &**nodes;
                let (one, (other, both)) = rayon::join(
                    || self.within(a, half),
                    || rayon::join(|| self.within(b, half), || self.between_in_parallel(a, b)),
                );
                (self.merge)((self.merge)(one, other), both)
            }
            _ => self.alone(|found, steps| self.below(node, found, steps)),
        }
    }

    /// The result of one thread.
    fn alone<S: Default>(&self, visit: impl FnOnce(&mut S, &mut Steps)) -> S {
        let mut found = S::default();
        visit(&mut found, &mut self.pairs.effort.steps());
        found
    }

    /// Visits the pairs below a node.
    fn below<S>(&self, node: &Node, found: &mut S, steps: &mut Steps)
    where
        V: Fn(u32, u32, &mut S) + Sync,
    {
        if !steps.step() || self.pairs.are_left_out(node, node) {
            return;
        }
        match &node.below {
            Below::Items(items) => {
                if let [i, j] = items[..] {
                    self.visit(i, j, found, steps);
                }
            }
            Below::Nodes(nodes) => {
                let [a, b] = &**nodes;
                self.between(a, b, found, steps);
                nodes.iter().for_each(|n| self.below(n, found, steps));
            }
        }
    }

    /// Visits the pairs of one item below each node, distributed over threads.
    fn between_in_parallel<S: Default + Send>(&self, a: &Node, b: &Node) -> S
    where
        V: Fn(u32, u32, &mut S) + Sync,
        M: Fn(S, S) -> S + Sync,
    {
        let mut front = vec![(a, b)];
        for _ in 0..6 {
            front = front.into_iter().flat_map(|(a, b)| self.opened(a, b)).collect();
        }
        let one = |(a, b)| self.alone(|found, steps| self.between(a, b, found, steps));
        let results: Vec<S> = front.into_par_iter().map(one).collect();
        results.into_iter().reduce(self.merge).unwrap_or_default()
    }

    /// Opens the larger of two nodes. Returns no pairs if the nodes are apart, and the pair itself if neither can be
    /// opened.
    fn opened<'n>(&self, a: &'n Node, b: &'n Node) -> Vec<(&'n Node, &'n Node)> {
        if self.pairs.are_left_out(a, b) || a.bounds.is_apart_from(&b.bounds) {
            return Vec::new();
        }
        match (&a.below, &b.below) {
            (Below::Items(_), Below::Items(_)) => vec![(a, b)],
            (Below::Nodes(nodes), Below::Items(_)) => nodes.iter().map(|n| (n, b)).collect(),
            (Below::Items(_), Below::Nodes(nodes)) => nodes.iter().map(|n| (a, n)).collect(),
            (Below::Nodes(nodes), Below::Nodes(_)) if a.bounds.size() > b.bounds.size() => {
                nodes.iter().map(|n| (n, b)).collect()
            }
            (_, Below::Nodes(nodes)) => nodes.iter().map(|n| (a, n)).collect(),
        }
    }

    fn between<S>(&self, a: &Node, b: &Node, found: &mut S, steps: &mut Steps)
    where
        V: Fn(u32, u32, &mut S) + Sync,
    {
        if !steps.step() || self.pairs.are_left_out(a, b) || a.bounds.is_apart_from(&b.bounds) {
            return;
        }
        match (&a.below, &b.below) {
            (Below::Items(of_a), Below::Items(of_b)) => {
                for i in of_a {
                    of_b.iter().for_each(|j| self.visit(*i.min(j), *i.max(j), found, steps));
                }
            }
            (Below::Nodes(nodes), Below::Nodes(_)) if a.bounds.size() > b.bounds.size() => {
                nodes.iter().for_each(|n| self.between(n, b, found, steps));
            }
            (_, Below::Nodes(nodes)) => nodes.iter().for_each(|n| self.between(a, n, found, steps)),
            (Below::Nodes(nodes), Below::Items(_)) => {
                nodes.iter().for_each(|n| self.between(n, b, found, steps));
            }
        }
    }

    fn visit<S>(&self, i: u32, j: u32, found: &mut S, steps: &mut Steps)
    where
        V: Fn(u32, u32, &mut S) + Sync,
    {
        if steps.step() {
            (self.visit)(i, j, found);
        }
    }
}
