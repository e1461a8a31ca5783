//! Which corners of cells are inside an object, and where edges of cells cross its surface.

use std::collections::HashMap;
use std::ops::Range;

use shotline::math::Vec3;
use shotline::query::batch::BatchError;
use shotline::ray::Ray;

use crate::octree::{Cell, Edge, Index, Octree, key};
use crate::surface::{Line, Surface, SurfaceCrossing};

/// How far rays along edges begin before them and end behind them, in parts of their lengths: a crossing that rounding puts
/// beside an end that is on the surface is found.
const BEYOND: f64 = 1e-3;

/// Where an edge crosses the surface.
#[derive(Clone, Copy, Debug)]
pub struct Crossing {
    /// Whether the edge enters the object here.
    pub entering: bool,
    pub position: Vec3,
    /// The unit normal, out of the object; NaN where rounding hides the crossing.
    pub normal: Vec3,
}

/// What is known of an object at the corners and edges of cells.
#[derive(Debug, Default)]
pub struct Samples {
    /// Whether each corner is inside.
    inside: HashMap<u64, bool>,
    /// For each edge the indices of its crossings.
    edges: HashMap<u64, Range<u32>>,
    crossings: Vec<Crossing>,
    /// Points of the surface: those given, all in which edges cross it, and others within the cells that have such edges.
    pub points: Vec<Vec3>,
}

impl Samples {
    /// Samples without cells, and with points of the surface.
    pub fn with_points(points: Vec<Vec3>) -> Samples {
        Samples { points, ..Samples::default() }
    }

    /// Adds the corners and edges of new cells.
    pub fn add(&mut self, octree: &Octree, cells: &[Cell], surface: &Surface) -> Result<(), BatchError> {
        self.add_corners(octree, cells, surface)?;
        self.add_edges(octree, cells, surface)?;
        self.add_points_within(octree, cells, surface)
    }

    /// Whether a corner of a cell is inside; `None` if no cell has this corner.
    pub fn inside(&self, corner: Index) -> Option<bool> {
        self.inside.get(&key(corner)).copied()
    }

    /// The crossings of an edge in order: it enters and leaves in turn, from the side of its start to that of its end.
    pub fn crossings(&self, edge: &Edge) -> &[Crossing] {
        self.edges
            .get(&key(edge.middle()))
            .map_or(&[], |range| &self.crossings[range.start as usize..range.end as usize])
    }

    fn add_corners(&mut self, octree: &Octree, cells: &[Cell], surface: &Surface) -> Result<(), BatchError> {
        let mut corners = Vec::new();
        for cell in cells {
            for corner in (0..8).map(|number| cell.corner(number)) {
                self.inside.entry(key(corner)).or_insert_with(|| {
                    corners.push((corner, cell.size));
                    false
                });
            }
        }
        let along =
            |&(corner, size): &(Index, u32)| Ray::new(octree.position(corner), Vec3::X * octree.length(size));
        surface.cast(&corners, along, |(corner, _), line| {
            self.inside.insert(key(*corner), line.starts_inside);
        })
    }

    fn add_edges(&mut self, octree: &Octree, cells: &[Cell], surface: &Surface) -> Result<(), BatchError> {
        let mut edges = Vec::new();
        for edge in cells.iter().flat_map(Cell::edges) {
            self.edges.entry(key(edge.middle())).or_insert_with(|| {
                edges.push(edge);
                0..0
            });
        }
        let along = |edge: &Edge| {
            let (start, end) = (octree.position(edge.start), octree.position(edge.end()));
            Ray::new(start - (end - start) * BEYOND, (end - start) * (1.0 + 2.0 * BEYOND))
        };
        surface.cast(&edges, along, |edge, line| self.add_edge(octree, edge, line))
    }

    /// Adds where diagonals of cells cross the surface, which the edges may not see: an end of a thin wall, or a thin bar.
    fn add_points_within(
        &mut self,
        octree: &Octree,
        cells: &[Cell],
        surface: &Surface,
    ) -> Result<(), BatchError> {
        let is_crossed = |cell: &&Cell| cell.edges().any(|edge| !self.crossings(&edge).is_empty());
        let of_cell =
            |cell: &Cell| [0, 1, 2, 3].map(|corner| [corner, 7 - corner].map(|corner| cell.corner(corner)));
        let diagonals: Vec<[Index; 2]> = cells.iter().filter(is_crossed).flat_map(of_cell).collect();
        let ends = |diagonal: &[Index; 2]| diagonal.map(|corner| octree.position(corner));
        let along = |diagonal: &[Index; 2]| {
            let [start, end] = ends(diagonal);
            Ray::new(start, end - start)
        };
        surface.cast(&diagonals, along, |diagonal, line| {
            let [start, end] = ends(diagonal);
            self.points.extend(line.crossings.iter().map(|crossing| start + (end - start) * crossing.t));
        })
    }

    fn add_edge(&mut self, octree: &Octree, edge: &Edge, line: &Line) {
        let (start, end) = (octree.position(edge.start), octree.position(edge.end()));
        let crossing = |crossing: &SurfaceCrossing| {
            let part = crossing.t * (1.0 + 2.0 * BEYOND) - BEYOND;
            let position = start + (end - start) * part.clamp(0.0, 1.0);
            (part, Crossing { entering: crossing.entering, position, normal: crossing.normal })
        };
        let all: Vec<(f64, Crossing)> = line.crossings.iter().map(crossing).collect();
        let on_edge =
            all.iter().filter(|(part, _)| (0.0..=1.0).contains(part)).map(|(_, crossing)| *crossing);
        self.points.extend(on_edge.clone().map(|crossing| crossing.position));
        let ends = [edge.start, edge.end()].map(|end| self.inside(end) == Some(true));
        let first = self.crossings.len();
        if !self.add_in_turn(on_edge, ends)
            && !self.add_in_turn(all.iter().map(|(_, crossing)| *crossing), ends)
        {
            // Rounding hides the crossing.
            let middle = Crossing { entering: ends[1], position: (start + end) / 2.0, normal: Vec3::NAN };
            self.crossings.extend((ends[0] != ends[1]).then_some(middle));
        }
        self.edges.insert(key(edge.middle()), first as u32..self.crossings.len() as u32);
    }

    /// Adds crossings that enter and leave in turn, and returns true, if they lead from the side of one end to that of the other.
    fn add_in_turn(
        &mut self,
        crossings: impl Iterator<Item = Crossing>,
        [mut is_inside, ends_inside]: [bool; 2],
    ) -> bool {
        let before = self.crossings.len();
        for crossing in crossings.filter(|crossing| !crossing.normal.is_nan()) {
            if crossing.entering != is_inside {
                is_inside = crossing.entering;
                self.crossings.push(crossing);
            }
        }
        if is_inside != ends_inside {
            self.crossings.truncate(before);
        }
        is_inside == ends_inside
    }
}
