//! The outlines of regions that are given by the intervals of rows.

use std::collections::BTreeMap;

/// A corner: the column where an interval ends, exactly, and the number of the line between rows, from the top.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Corner {
    column: f64,
    line: usize,
}

impl Corner {
    /// A key that is equal for equal corners.
    fn key(self) -> (usize, u64) {
        // A sum with 0 turns -0 into 0.
        (self.line, (self.column + 0.0).to_bits())
    }
}

/// A point of an outline: columns from the left side, and rows from the top.
pub type Point = [f64; 2];

/// A step between rows up to this many columns is drawn as a slope: the boundary goes on between the middles of the rows.
const MOST_SLOPE: f64 = 8.0;

/// The closed outlines of a region, outer ones clockwise and those of holes counterclockwise. `rows` are the intervals of each
/// row, ascending and apart.
///
/// Along the middle of each row the outline is exact. From one row to the next it is straight, unless the boundary is along
/// the rows: then it is the line between the rows.
pub fn outlines(rows: &[Vec<[f64; 2]>]) -> Vec<Vec<Point>> {
    let mut edges = Edges::default();
    let none = Vec::new();
    for line in 0..=rows.len() {
        let above = if line > 0 { &rows[line - 1] } else { &none };
        let below = rows.get(line).unwrap_or(&none);
        edges.add_line(line, above, below);
        for &[from, to] in below {
            edges.add(Corner { column: from, line: line + 1 }, Corner { column: from, line });
            edges.add(Corner { column: to, line }, Corner { column: to, line: line + 1 });
        }
    }
    edges.loops().iter().map(|corners| sloped(corners)).collect()
}

/// Edges by the corner where they begin.
#[derive(Default)]
struct Edges(BTreeMap<(usize, u64), Vec<[Corner; 2]>>);

impl Edges {
    fn add(&mut self, from: Corner, to: Corner) {
        self.0.entry(from.key()).or_default().push([from, to]);
    }

    /// Adds the edges on the line between two rows: where only one of them is inside.
    fn add_line(&mut self, line: usize, above: &[[f64; 2]], below: &[[f64; 2]]) {
        let mut ends: Vec<f64> = above.iter().chain(below).flatten().copied().collect();
        ends.sort_unstable_by(f64::total_cmp);
        ends.dedup();
        let is_inside = |row: &[[f64; 2]], x: f64| {
            let after = row.partition_point(|[from, _]| *from <= x);
            after > 0 && x < row[after - 1][1]
        };
        for pair in ends.windows(2) {
            let [from, to] = [pair[0], pair[1]].map(|column| Corner { column, line });
            // The intervals begin and end at these ends, so that the first decides for all between.
            match (is_inside(above, pair[0]), is_inside(below, pair[0])) {
                (false, true) => self.add(from, to),
                (true, false) => self.add(to, from),
                _ => {}
            }
        }
    }

    /// Joins the edges to closed loops of corners.
    fn loops(mut self) -> Vec<Vec<Corner>> {
        let mut loops = Vec::new();
        while let Some(mut entry) = self.0.first_entry() {
            let edge = entry.get_mut().pop();
            if entry.get().is_empty() {
                entry.remove();
            }
            let Some([first, mut at]) = edge else { continue };
            let mut corners = vec![first];
            while at.key() != first.key() {
                let Some(next) = self.take_from(at) else { break };
                corners.push(at);
                at = next;
            }
            loops.push(corners);
        }
        loops
    }

    /// Takes an edge that begins at a corner, and returns its other end.
    fn take_from(&mut self, at: Corner) -> Option<Corner> {
        let from = self.0.get_mut(&at.key())?;
        let edge = from.pop();
        if from.is_empty() {
            self.0.remove(&at.key());
        }
        edge.map(|[_, to]| to)
    }
}

/// Turns the steps of a loop into slopes.
fn sloped(corners: &[Corner]) -> Vec<Point> {
    let count = corners.len();
    let mut out: Vec<Point> = Vec::with_capacity(count);
    // The way along a boundary between rows, as the sum of its steps, begins after an edge along a row's end.
    let is_vertical = |i: usize| corners[i % count].line != corners[(i + 1) % count].line;
    let Some(start) = (0..count).find(|&i| is_vertical(i)) else { return Vec::new() };
    let mut i = start;
    while i < start + count {
        // A vertical edge, then the horizontal ones up to the next vertical edge.
        let [from, to] = [corners[i % count], corners[(i + 1) % count]];
        let middle = from.line.midpoint(to.line) as f64 + 0.5;
        out.push([from.column, middle]);
        let mut next = i + 1;
        while !is_vertical(next) {
            next += 1;
        }
        let [after, end] = [corners[next % count], corners[(next + 1) % count]];
        let goes_on = (to.line > from.line) == (end.line > after.line);
        let step = (after.column - to.column).abs();
        if !goes_on || step > MOST_SLOPE {
            out.push([to.column, to.line as f64]);
            out.push([after.column, after.line as f64]);
        }
        i = next;
    }
    without_straight(out)
}

/// Leaves out the points within a straight line along the rows' ends.
fn without_straight(points: Vec<Point>) -> Vec<Point> {
    let count = points.len();
    let is_needed = |i: usize| {
        let [before, at, after] = [points[(i + count - 1) % count], points[i], points[(i + 1) % count]];
        !(before[0] == at[0] && at[0] == after[0])
    };
    (0..count).filter(|&i| is_needed(i)).map(|i| points[i]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(points: &[Point]) -> f64 {
        let next = points.iter().cycle().skip(1);
        points.iter().zip(next).map(|([x0, y0], [x1, y1])| (x0 * y1 - x1 * y0) / 2.0).sum()
    }

    #[test]
    fn a_rectangle_has_four_corners() {
        let found = outlines(&[vec![], vec![[1.5, 4.0]], vec![[1.5, 4.0]], vec![[1.5, 4.0]], vec![]]);
        assert_eq!(found.len(), 1);
        assert_eq!((found[0].len(), area(&found[0])), (4, 7.5), "{found:?}");
    }

    #[test]
    fn holes_run_the_other_way() {
        let (whole, holed) = (vec![[0.0, 9.0]], vec![[0.0, 4.0], [5.0, 9.0]]);
        let found = outlines(&[whole.clone(), whole.clone(), holed.clone(), holed, whole]);
        let mut areas: Vec<f64> = found.iter().map(|points| area(points)).collect();
        areas.sort_by(f64::total_cmp);
        assert_eq!(areas, [-2.0, 45.0]);
    }

    #[test]
    fn slopes_are_straight_and_shelves_are_not() {
        let slope: Vec<Vec<[f64; 2]>> = (0..6).map(|i| vec![[0.0, 5.0 + f64::from(i)]]).collect();
        let found = outlines(&slope);
        // The corners on the right, of the first and the last row, and the points in the middles of rows.
        assert!(found[0].contains(&[7.0, 2.5]) && !found[0].contains(&[7.0, 3.0]), "{found:?}");
        let shelf = outlines(&[vec![[0.0, 5.0]], vec![[0.0, 50.0]]]);
        assert!(shelf[0].contains(&[5.0, 1.0]) && shelf[0].contains(&[50.0, 1.0]), "{shelf:?}");
        assert_eq!(area(&shelf[0]), 55.0);
    }

    /// Regions that share a boundary share its points, so that there is no gap.
    #[test]
    fn neighbours_leave_no_gap() {
        let ends: Vec<f64> = (0..40).map(|i| 20.0 + 10.0 * (f64::from(i) / 6.0).sin()).collect();
        let left: Vec<_> = ends.iter().map(|&end| vec![[0.0, end]]).collect();
        let right: Vec<_> = ends.iter().map(|&end| vec![[end, 50.0]]).collect();
        let sum: f64 = outlines(&left).iter().chain(&outlines(&right)).map(|points| area(points)).sum();
        assert!((sum - 2000.0).abs() < 1e-9, "{sum}");
    }
}
