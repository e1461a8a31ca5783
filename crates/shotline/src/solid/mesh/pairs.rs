//! Finds pairs of items that come near to each other without testing all pairs.
//!
//! Items go into a tree of oriented boxes, which is traversed against itself. That alone would still visit all pairs of
//! items with a common corner, such as the faces of a fan, because all their boxes hold the corner. So corners of many
//! items are *hubs*. Items are grouped by their hubs, and no pair with a common hub is visited; the caller must find
//! those pairs by other means.

use std::collections::HashMap;

use rayon::prelude::*;

use super::obb::Obb;
use super::stop::Stop;
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
}

/// Marks an unused entry.
pub(super) const NONE: u32 = u32::MAX;

/// Items prepared for a search for pairs.
pub(super) struct Pairs<'a> {
    items: &'a [Item],
    /// The hubs of each group of items, in ascending order; [`NONE`] in unused entries.
    groups: Vec<[u32; 3]>,
    root: Option<Node>,
    stop: Stop<'a>,
    /// The items at each hub.
    pub(super) hubs: Vec<(u32, Vec<u32>)>,
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
    /// Prepares a search. Once `stop` is set, this and all later calls return early with incomplete results.
    pub(super) fn of(items: &'a [Item], stop: Stop<'a>) -> Pairs<'a> {
        let mut at_corner: HashMap<u32, Vec<u32>> = HashMap::new();
        for (i, item) in (0..).zip(items) {
            if stop.is_set() {
                break;
            }
            for corner in item.corners.into_iter().filter(|c| *c != NONE) {
                at_corner.entry(corner).or_default().push(i);
            }
        }
        at_corner.retain(|_, items| items.len() > HUB);
        let hubs_of = |item: &Item| {
            let mut hubs = item.corners.map(|c| if at_corner.contains_key(&c) { c } else { NONE });
            hubs.sort_unstable();
            hubs
        };
        let mut grouped: HashMap<[u32; 3], Vec<u32>> = HashMap::new();
        let numbered = (0..).zip(items).take_while(|_| !stop.is_set());
        numbered.for_each(|(i, item)| grouped.entry(hubs_of(item)).or_default().push(i));
        let mut grouped: Vec<_> = grouped.into_iter().collect();
        grouped.sort_unstable();
        let nodes = (0..).zip(&mut grouped).map(|(g, (_, members))| within_group(items, members, g, stop));
        let root = over_groups(nodes.collect());
        let mut hubs: Vec<_> = at_corner.into_iter().collect();
        hubs.sort_unstable();
        Pairs { items, groups: grouped.into_iter().map(|(hubs, _)| hubs).collect(), root, stop, hubs }
    }

    /// Visits once every pair of items whose hulls have a common point, except pairs with a common hub. Some other
    /// pairs that are near to each other are visited too. `merge` combines the results of visits.
    pub(super) fn visit<S: Default + Send>(
        &self,
        visit: &(impl Fn(u32, u32, &mut S) + Sync),
        merge: &(impl Fn(S, S) -> S + Sync),
    ) -> S {
        let traversal = PairTraversal { pairs: self, visit, merge };
        self.root.as_ref().map_or_else(S::default, |root| traversal.within(root, self.items.len()))
    }

    fn share_a_hub(&self, a: Option<u32>, b: Option<u32>) -> bool {
        let hubs = |group: Option<u32>| group.map(|g| self.groups[g as usize]);
        match (hubs(a), hubs(b)) {
            (Some(a), Some(b)) => a.iter().any(|hub| *hub != NONE && b.contains(hub)),
            _ => false,
        }
    }
}

/// Builds a tree over the items of a group.
fn within_group(items: &[Item], members: &mut [u32], group: u32, stop: Stop) -> Node {
    let points = |i: &u32| items[*i as usize].points;
    let bounds = Obb::around(members.iter().flat_map(points));
    let middle = |i: &u32| points(i).iter().sum::<Vec3>();
    let below = if members.len() <= 2 || stop.is_set() {
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
            ((|| within_group(items, a, group, stop)), (|| within_group(items, b, group, stop)));
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
    /// Visits the pairs below a node of about `items` items.
    fn within<S: Default + Send>(&self, node: &Node, items: usize) -> S
    where
        V: Fn(u32, u32, &mut S) + Sync,
        M: Fn(S, S) -> S + Sync,
    {
        let mut found = S::default();
        if self.pairs.stop.is_set() || self.pairs.share_a_hub(node.group, node.group) {
            return found;
        }
        match &node.below {
            Below::Items(items) => {
                if let [i, j] = items[..] {
                    (self.visit)(i, j, &mut found);
                }
                found
            }
            Below::Nodes(nodes) => {
                let [a, b] = &**nodes;
                let half = items / 2;
                if half > MANY {
                    let (one, (other, both)) = rayon::join(
                        || self.within(a, half),
                        || rayon::join(|| self.within(b, half), || self.between_in_parallel(a, b)),
                    );
                    (self.merge)((self.merge)(one, other), both)
                } else {
                    self.between(a, b, &mut found);
                    let deeper = (self.merge)(self.within(a, half), self.within(b, half));
                    (self.merge)(found, deeper)
                }
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
        let one = |(a, b)| {
            let mut found = S::default();
            self.between(a, b, &mut found);
            found
        };
        let results: Vec<S> = front.into_par_iter().map(one).collect();
        results.into_iter().reduce(self.merge).unwrap_or_default()
    }

    /// Opens the larger of two nodes. Returns no pairs if the nodes are apart, and the pair itself if neither can be
    /// opened.
    fn opened<'n>(&self, a: &'n Node, b: &'n Node) -> Vec<(&'n Node, &'n Node)> {
        if self.pairs.share_a_hub(a.group, b.group) || a.bounds.is_apart_from(&b.bounds) {
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

    fn between<S>(&self, a: &Node, b: &Node, found: &mut S)
    where
        V: Fn(u32, u32, &mut S) + Sync,
    {
        if self.pairs.stop.is_set()
            || self.pairs.share_a_hub(a.group, b.group)
            || a.bounds.is_apart_from(&b.bounds)
        {
            return;
        }
        match (&a.below, &b.below) {
            (Below::Items(of_a), Below::Items(of_b)) => {
                for i in of_a {
                    of_b.iter().for_each(|j| (self.visit)(*i.min(j), *i.max(j), found));
                }
            }
            (Below::Nodes(nodes), Below::Nodes(_)) if a.bounds.size() > b.bounds.size() => {
                nodes.iter().for_each(|n| self.between(n, b, found));
            }
            (_, Below::Nodes(nodes)) => nodes.iter().for_each(|n| self.between(a, n, found)),
            (Below::Nodes(nodes), Below::Items(_)) => nodes.iter().for_each(|n| self.between(n, b, found)),
        }
    }
}
