//! Which members of a group are apart from all others.

use shotline::aabb::Aabb;
use shotline::math::{Lattice, Vec3};

use crate::disjoint_sets::DisjointSets;

/// The members that belong together, since their boxes are closer than a gap: the members of each set, in order.
pub fn clusters(boxes: &[Aabb], gap: f64) -> Vec<Vec<usize>> {
    let mut sets = DisjointSets::of(boxes.len());
    let mut by_start: Vec<usize> = (0..boxes.len()).filter(|i| !boxes[*i].is_empty()).collect();
    by_start.sort_by(|a, b| boxes[*a].min.x.total_cmp(&boxes[*b].min.x));
    // Sweep and prune along x: the members that may reach the next one.
    let mut open: Vec<usize> = Vec::new();
    for next in by_start {
        let beginning = boxes[next].min.x - gap;
        open.retain(|member| boxes[*member].max.x >= beginning);
        open.iter()
            .filter(|member| are_near(&boxes[**member], &boxes[next], gap))
            .for_each(|member| sets.join(*member, next));
        open.push(next);
    }
    let (numbers, count) = sets.numbered();
    let mut clusters = vec![Vec::new(); count];
    numbers.iter().enumerate().for_each(|(member, set)| clusters[*set as usize].push(member));
    clusters
}

fn are_near(a: &Aabb, b: &Aabb, gap: f64) -> bool {
    let gap = Vec3::splat(gap);
    (a.min - gap).cmple(b.max).all() && (b.min - gap).cmple(a.max).all()
}

/// Whether boxes of a size, one in each cell of a lattice, are apart by more than a gap.
pub fn cells_are_apart(lattice: &Lattice, size: Vec3, gap: f64) -> bool {
    match *lattice {
        // Where rows are shifted along x, the boxes of two rows are apart along y.
        Lattice::Rectangular { counts, pitch, .. } => {
            (0..3).all(|axis| counts[axis] < 2 || size[axis] + gap < pitch[axis].abs())
        }
        Lattice::Hexagonal { rings, pitch, layers, height } => {
            // The next rows are shifted by half a pitch.
            let [x, y] = [size.x + gap, size.y + gap].map(|side| side / pitch.abs());
            let is_in_cell = x < 1.0 && y < 0.75_f64.sqrt() || x < 0.5 && y < 3.0_f64.sqrt();
            (rings < 2 || is_in_cell) && (layers < 2 || size.z + gap < height.abs())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube(x: f64, y: f64) -> Aabb {
        let min = Vec3::new(x, y, 0.0);
        Aabb { min, max: min + Vec3::ONE }
    }

    #[test]
    fn what_is_near_belongs_together() {
        let boxes =
            [cube(0.0, 0.0), cube(5.0, 0.0), cube(0.5, 1.05), cube(2.0, 0.0), cube(0.0, 5.0), Aabb::EMPTY];
        assert_eq!(clusters(&boxes, 0.1), [vec![0, 2], vec![1], vec![3], vec![4], vec![5]]);
        assert_eq!(clusters(&boxes, 0.01).len(), 6);
        // A chain belongs together.
        assert_eq!(clusters(&boxes, 1.0), [vec![0, 2, 3], vec![1], vec![4], vec![5]]);
        let all = Aabb { min: Vec3::splat(f64::NEG_INFINITY), max: Vec3::splat(f64::INFINITY) };
        assert_eq!(clusters(&[cube(0.0, 0.0), all, cube(9.0, 0.0)], 0.0), [vec![0, 1, 2]]);
    }

    #[test]
    fn cells_of_lattices_are_apart_where_they_are_smaller_than_the_pitch() {
        let apart = |lattice: &Lattice, size: [f64; 3]| cells_are_apart(lattice, size.into(), 0.1);
        let rows = Lattice::rectangular([4, 2, 1], [1.0, 2.0, 0.0]);
        assert!(
            apart(&rows, [0.8, 1.8, 9.0])
                && !apart(&rows, [0.95, 1.8, 9.0])
                && !apart(&rows, [0.8, 1.95, 9.0])
        );
        let staggered = Lattice::Rectangular { counts: [4, 2, 1], pitch: [1.0, 1.0, 0.0], stagger: true };
        assert!(apart(&staggered, [0.8, 0.8, 9.0]) && !apart(&staggered, [0.3, 1.0, 9.0]));
        let hexagons = Lattice::Hexagonal { rings: 3, pitch: 1.0, layers: 2, height: 1.0 };
        assert!(apart(&hexagons, [0.8, 0.76, 0.8]) && !apart(&hexagons, [0.8, 0.77, 0.8]));
        assert!(!apart(&hexagons, [0.95, 0.6, 0.8]) && apart(&hexagons, [0.3, 1.6, 0.8]));
        assert!(!apart(&hexagons, [0.3, 1.7, 0.8]));
        assert!(!apart(&hexagons, [0.6, 0.6, 1.0]));
    }
}
