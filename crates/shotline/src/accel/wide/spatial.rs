//! Builds a binary tree of triangles with spatial splits: where the boxes of two children would overlap, a plane may cut
//! triangles instead, which are then items of both children (Stich, Friedrich and Dietrich 2009, "Spatial splits in
//! bounding volume hierarchies").

use rayon::iter::{IndexedParallelIterator, IntoParallelIterator, ParallelIterator};

use super::binary::{BinaryNode, Content, Part};
use super::bins::{Binning, Bins};
use super::bounds::{Bounds, Extent, ItemBox};
use super::cut::{Plane, Triangle, best_plane, cut};
use super::emit::emit;
use super::{Frame, LEAF_COST, LEAF_SIZE, MAX_HEURISTIC_DEPTH, NONE, PARALLEL, WideBvh};
use crate::aabb::Aabb;
use crate::accel::collapse::{self, Costs};
use crate::math::Vec3;

/// Maximum mean number of references to a triangle. It bounds the memory.
const MAX_SPREAD: usize = 2;

/// Spatial splits are tried where the area of the children's overlap is more than this fraction of the root's.
const OVERLAP: f32 = 1e-5;

/// Builds a tree over finite triangles within given bounds. Returns it with the triangles of each leaf: a triangle may be
/// in several leaves, but is in each of them at most once.
pub(crate) fn build_with_spatial_splits(
    bounds: &Aabb,
    count: usize,
    corners: impl Fn(u32) -> [Vec3; 3] + Sync,
) -> (WideBvh, Vec<[u32; LEAF_SIZE]>) {
    if count == 0 {
        return (WideBvh::default(), Vec::new());
    }
    let frame = Frame::of(bounds);
    let references = (0..count as u32)
        .into_par_iter()
        .with_min_len(PARALLEL)
        .map(|item| ItemBox::new(item, frame.outward(&Aabb::around(corners(item)))));
    let references: Vec<ItemBox> = references.collect();
    let extent = Extent::of(&references);
    let triangle = |item: u32| corners(item).map(|v| frame.coordinates(v));
    let builder = Builder { triangle: &triangle, overlap: OVERLAP * extent.bounds.half_area() };
    let root = Task { references, extent, depth: 0, spare: count * (MAX_SPREAD - 1) };
    let (tree, _) = builder.build_part(root);
    emit(frame, &tree)
}

struct Builder<'a> {
    triangle: &'a (dyn Fn(u32) -> Triangle + Sync),
    /// Spatial splits are tried where the children overlap by more than this area.
    overlap: f32,
}

/// A subtree to build. Splits in it may add at most `spare` references.
struct Task {
    references: Vec<ItemBox>,
    extent: Extent,
    depth: usize,
    spare: usize,
}

impl Builder<'_> {
    fn build_part(&self, task: Task) -> (Part, Costs) {
        let (count, bounds) = (task.references.len(), task.extent.bounds);
        if count < PARALLEL {
            let mut nodes = Vec::with_capacity(count);
            let costs = self.build_nodes(&mut nodes, task, &mut Bins::default());
            return (Part::Whole(nodes), costs);
        }
        let [left, right] = self.divide(task, &mut Bins::default());
        let ((left, left_costs), (right, right_costs)) =
            rayon::join(|| self.build_part(left), || self.build_part(right));
        let (forests, costs) = collapse::of_split(bounds.half_area(), &left_costs, &right_costs);
        let node = BinaryNode::new(&bounds, count, Content::Split { right: 0, forests });
        (Part::Split(node, Box::new([left, right])), costs)
    }

    /// Appends the nodes of a subtree.
    fn build_nodes(&self, nodes: &mut Vec<BinaryNode>, task: Task, bins: &mut Bins) -> Costs {
        let (count, bounds) = (task.references.len(), task.extent.bounds);
        if count <= LEAF_SIZE {
            let leaf = std::array::from_fn(|i| task.references.get(i).map_or(NONE, ItemBox::item));
            nodes.push(BinaryNode::new(&bounds, count, Content::Leaf(leaf)));
            return collapse::of_leaf(bounds.half_area() * LEAF_COST);
        }
        let [left, right] = self.divide(task, bins);
        let index = nodes.len();
        nodes.push(BinaryNode::new(&bounds, count, Content::Leaf([NONE; LEAF_SIZE])));
        let left_costs = self.build_nodes(nodes, left, bins);
        let right_index = nodes.len() as u32;
        let right_costs = self.build_nodes(nodes, right, bins);
        let (forests, costs) = collapse::of_split(bounds.half_area(), &left_costs, &right_costs);
        nodes[index].content = Content::Split { right: right_index, forests };
        costs
    }

    /// Divides a subtree with more than one reference.
    fn divide(&self, task: Task, bins: &mut Bins) -> [Task; 2] {
        let Task { mut references, extent, depth, spare } = task;
        let count = references.len();
        let is_shallow = depth < MAX_HEURISTIC_DEPTH;
        let split = if is_shallow {
            bins.fill(&references, Binning::of(count, &extent.centres));
            bins.best_split()
        } else {
            None
        };
        let left = split.map_or(0, |split| split.partition(&mut references).0);
        let left = if left > 0 && left < count { left } else { count / 2 };
        let [left_extent, right_extent] = [Extent::of(&references[..left]), Extent::of(&references[left..])];
        let area = |extent: &Extent, count: usize| extent.bounds.half_area() * count as f32;
        let cost = area(&left_extent, left) + area(&right_extent, count - left);
        let shared = left_extent.bounds.intersection(right_extent.bounds);
        let plane = (is_shallow && spare > 0 && !shared.is_empty() && shared.half_area() > self.overlap)
            .then(|| best_plane(&references, &extent.bounds, spare, self.triangle))
            .flatten()
            .filter(|plane| plane.cost < cost);
        let (left, right) =
            plane.and_then(|plane| self.cut(&references, &plane, spare)).unwrap_or_else(|| {
                let right = references.split_off(left);
                (references, right)
            });
        let listed = left.len() + right.len();
        let spare = spare - (listed - count);
        let task = |references: Vec<ItemBox>| Task {
            extent: Extent::of(&references),
            depth: depth + 1,
            spare: spare * references.len() / listed,
            references,
        };
        [task(left), task(right)]
    }

    /// The references below a plane and those above; `None` if a side is empty or there are too many.
    fn cut(
        &self,
        references: &[ItemBox],
        plane: &Plane,
        spare: usize,
    ) -> Option<(Vec<ItemBox>, Vec<ItemBox>)> {
        let (mut below, mut above) = (Vec::new(), Vec::new());
        for reference in references {
            let bounds = reference.bounds();
            if bounds.high(plane.axis) <= plane.at {
                below.push(*reference);
            } else if bounds.low(plane.axis) >= plane.at {
                above.push(*reference);
            } else {
                let parts = cut(&(self.triangle)(reference.item()), &bounds, plane.axis, plane.at);
                if parts.iter().all(Bounds::is_empty) {
                    below.push(*reference);
                }
                for (part, side) in parts.iter().zip([&mut below, &mut above]) {
                    if !part.is_empty() {
                        side.push(reference.within(part));
                    }
                }
            }
        }
        let fits = below.len() + above.len() <= references.len() + spare;
        (fits && !below.is_empty() && !above.is_empty()).then_some((below, above))
    }
}
