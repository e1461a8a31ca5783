//! The fast builder: sorts items along a Morton curve and splits them at the borders of its cells (Lauterbach et al.
//! 2009, "Fast BVH construction on GPUs"; Karras 2012).

use super::{Bvh, MAX_LEAF, Node};
use crate::aabb::Aabb;
use crate::accel::prim_ref::{PrimRef, bounding_box, partition_unbounded};
use crate::math::Vec3;

/// Bits of a code for each axis. So a path from the root has at most 63 splits between cells and 30 within one.
const BITS: u32 = 21;

/// An item with its position on the curve.
struct MortonRef {
    code: u64,
    bounds: Aabb,
    item: u32,
}

pub(super) fn build(boxes: &[Aabb]) -> Bvh {
    let (bounded, unbounded) = partition_unbounded(boxes);
    let refs = sorted_by_morton_code(&bounded);
    let mut nodes = Vec::new();
    if !refs.is_empty() {
        nodes.push(Node { bounds: Aabb::EMPTY, first: 0, count: refs.len() as u32 });
        split_all(&mut nodes, &refs);
        compute_bounds(&mut nodes, &refs);
    }
    Bvh {
        nodes,
        items: refs.iter().map(|p| p.item).collect(),
        unbounded,
        has_duplicate_refs: false,
        refit_data: None,
    }
}

fn sorted_by_morton_code(items: &[PrimRef]) -> Vec<MortonRef> {
    let whole = bounding_box(items);
    let cells = Vec3::splat((1u64 << BITS) as f64) / whole.size();
    let mut refs: Vec<MortonRef> = items
        .iter()
        .map(|&PrimRef { bounds, item }| {
            // An axis without extent gives NaN, which becomes cell 0.
            let cell = (bounds.centre() - whole.min) * cells;
            let code = (0..3).map(|axis| spread_bits(cell[axis] as u64) << axis).sum();
            MortonRef { code, bounds, item }
        })
        .collect();
    refs.sort_unstable_by_key(|p| (p.code, p.item));
    refs
}

/// The bits of a cell number, with two zeros between neighbours.
fn spread_bits(cell: u64) -> u64 {
    let mut x = cell.min((1 << BITS) - 1);
    x = (x | x << 32) & 0x001f_0000_0000_ffff;
    x = (x | x << 16) & 0x001f_0000_ff00_00ff;
    x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}

/// Splits nodes until they are leaves. Works depth first, so that nodes close in the tree are close in memory.
fn split_all(nodes: &mut Vec<Node<Aabb>>, refs: &[MortonRef]) {
    let mut open = vec![0];
    while let Some(index) = open.pop() {
        let Node { first: start, count, .. } = nodes[index];
        if count as usize <= MAX_LEAF {
            continue;
        }
        let left = split(&refs[start as usize..][..count as usize]) as u32;
        let children = nodes.len();
        (nodes[index].first, nodes[index].count) = (children as u32, 0);
        for (first, count) in [(start, left), (start + left, count - left)] {
            nodes.push(Node { bounds: Aabb::EMPTY, first, count });
        }
        open.extend([children + 1, children]);
    }
}

/// How many references of a run go left: those without the highest bit in which any codes differ, or half of them if
/// all codes are equal.
fn split(run: &[MortonRef]) -> usize {
    let differing = run[0].code ^ run[run.len() - 1].code;
    match differing.checked_ilog2() {
        Some(bit) => run.partition_point(|p| p.code >> bit & 1 == 0),
        None => run.len() / 2,
    }
}

/// Computes all boxes, children first.
fn compute_bounds(nodes: &mut [Node<Aabb>], refs: &[MortonRef]) {
    for index in (0..nodes.len()).rev() {
        let Node { first, count, .. } = nodes[index];
        let first = first as usize;
        nodes[index].bounds = if count == 0 {
            nodes[first].bounds.union(&nodes[first + 1].bounds)
        } else {
            refs[first..][..count as usize].iter().fold(Aabb::EMPTY, |all, p| all.union(&p.bounds))
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_are_spread() {
        for cell in [0, 1, 2, 3, 0x1f_ffff, 0x12_3456, 0x0a_aaaa] {
            let expected = (0..BITS).fold(0, |all, bit| all | (cell >> bit & 1) << (3 * bit));
            assert_eq!(spread_bits(cell), expected, "{cell}");
        }
        assert_eq!(spread_bits(u64::MAX), 0x1249_2492_4924_9249);
    }
}
