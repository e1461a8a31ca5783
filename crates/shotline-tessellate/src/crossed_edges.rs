//! The edges of a grid that cross the surface of an object.

use shotline::compile::World;
use shotline::math::Vec3;
use shotline::query::batch::{self, BatchError, CrossingRows, Fields, Rays, Run};

use crate::grid::{Grid, Lines};

/// Where a line crosses the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceCrossing {
    pub t: f64,
    pub entering: bool,
    /// The unit normal, out of the object.
    pub normal: Vec3,
}

/// An edge of the grid with one end inside and one outside.
#[derive(Clone, Copy, Debug)]
pub struct CrossedEdge {
    pub axis: usize,
    /// Its first point.
    pub start: [usize; 3],
    /// Whether its first point is outside.
    pub entering: bool,
    pub position: Vec3,
    /// NaN where rounding hides the crossing.
    pub normal: Vec3,
}

/// All edges that cross the surface.
#[derive(Debug, Default)]
pub struct CrossedEdges {
    pub edges: Vec<CrossedEdge>,
    /// All points in which lines of the grid cross the surface, also where two are on one edge, whose ends are both inside or
    /// both outside then: what is thinner than a cell.
    pub points: Vec<Vec3>,
}

impl CrossedEdges {
    /// Finds them for one object of a world.
    pub fn of(world: &World, object: u32, grid: &Grid, run: Run) -> Result<CrossedEdges, BatchError> {
        let mut inside = vec![false; grid.points(0) * grid.points(1) * grid.points(2)];
        let mut found = CrossedEdges::default();
        for axis in 0..3 {
            let lines = Lines { grid, axis };
            let fields = Fields::NORMAL | Fields::OBJECT | Fields::ENTERING;
            let rows = batch::crossings(world, &lines, shotline::ray::Span::FORWARD, Run { fields, ..run })?;
            for line in 0..lines.len() {
                let crossings = of_object(&rows, line, object);
                // The lines along x decide which points are inside; other lines may see a point that is on the
                // surface up to rounding on the other side.
                if axis == 0 {
                    mark_inside(&crossings, &lines, line, &mut inside);
                }
                found.add_line(&crossings, &lines, line, &inside);
            }
        }
        Ok(found)
    }

    fn add_line(&mut self, crossings: &[SurfaceCrossing], lines: &Lines, line: usize, inside: &[bool]) {
        let grid = lines.grid;
        let (mut start, mut rest) = (lines.start(line), crossings);
        self.points.extend(crossings.iter().map(|crossing| lines.position(start, crossing.t)));
        for k in 0..grid.cells[lines.axis] {
            let count = rest.iter().take_while(|crossing| crossing.t < (k + 1) as f64).count();
            let (here, after) = rest.split_at(count);
            rest = after;
            start[lines.axis] = k;
            let mut end = start;
            end[lines.axis] += 1;
            let (is_inside, then_inside) = (inside[grid.number(start)], inside[grid.number(end)]);
            if is_inside != then_inside {
                let crossing = here.iter().find(|crossing| crossing.entering == then_inside);
                self.edges.push(edge(lines, start, then_inside, crossing));
            }
        }
    }
}

fn edge(lines: &Lines, start: [usize; 3], entering: bool, crossing: Option<&SurfaceCrossing>) -> CrossedEdge {
    let k = start[lines.axis] as f64;
    let (t, normal) = crossing.map_or((k + 0.5, Vec3::NAN), |crossing| (crossing.t, crossing.normal));
    let position = lines.position(start, t.clamp(k, k + 1.0));
    CrossedEdge { axis: lines.axis, start, entering, position, normal }
}

/// The crossings of a line with the union of all instances of an object.
pub fn of_object(rows: &CrossingRows, line: usize, object: u32) -> Vec<SurfaceCrossing> {
    let range = rows.ray_splits[line] as usize..rows.ray_splits[line + 1] as usize;
    let mut depth = 0;
    let mut found = Vec::new();
    for row in range.filter(|row| rows.object[*row] as u32 == object) {
        let entering = rows.entering[row];
        let before = depth;
        depth += if entering { 1 } else { -1 };
        if before == 0 || depth == 0 {
            let normal = Vec3::from_array(rows.normal[row]);
            found.push(SurfaceCrossing { t: rows.t[row], entering, normal });
        }
    }
    // Where one instance ends and another begins at the same place there is no surface.
    let mut kept: Vec<SurfaceCrossing> = Vec::with_capacity(found.len());
    for crossing in found {
        match kept.last() {
            Some(last) if last.t == crossing.t && last.entering != crossing.entering => {
                kept.pop();
            }
            _ => kept.push(crossing),
        }
    }
    kept
}

fn mark_inside(crossings: &[SurfaceCrossing], lines: &Lines, line: usize, inside: &mut [bool]) {
    let (mut index, mut is_inside, mut rest) = (lines.start(line), false, crossings);
    for k in 0..lines.grid.points(lines.axis) {
        while let Some(first) = rest.first().filter(|first| first.t < k as f64) {
            is_inside = first.entering;
            rest = &rest[1..];
        }
        index[lines.axis] = k;
        inside[lines.grid.number(index)] = is_inside;
    }
}
