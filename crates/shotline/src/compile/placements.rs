//! The placements of a level: listed, or the cells of a lattice, which are computed.

use std::borrow::Cow;
use std::ops::Range;

use super::lattice_cells::LatticeCells;
use super::names::NameId;
use crate::aabb::Aabb;
use crate::accel::Accelerator;
use crate::math::Affine;

/// An object that begins in a level and has several placements there: those of its shape and of what it contains.
#[derive(Clone, Debug)]
pub(crate) struct ObjectScope {
    pub object: u32,
    /// The scope in the same level that it is in; `None` if that is where the level is placed.
    pub parent: Option<u32>,
    /// Its paths, of those of the level.
    pub paths: Range<u64>,
}

/// The placements of a group, or of an object with what it contains.
#[derive(Clone, Debug, Default)]
pub(crate) struct Level {
    /// The placements. Those of a lattice are the elements that its cells hold, each in a cell that is not shifted.
    pub placements: Vec<Placement>,
    pub lattice: Option<Box<LatticeCells>>,
    pub scopes: Vec<ObjectScope>,
    pub accel: Option<Box<dyn Accelerator>>,
    /// The frame of the boxes of the placements, from that of the level, if it is another: see `compile/box_frame.rs`.
    pub box_frame: Option<Box<Affine>>,
    pub(super) accel_name: &'static str,
    pub bounds: Aabb,
    /// Number of bodies below, counted once for every placement.
    pub path_count: u64,
    pub leaf_count: u64,
}

/// A body or a level, placed.
#[derive(Clone, Debug)]
pub(crate) struct Placement {
    /// The inverse transform `T^-1`, by which rays are transformed.
    pub local_from_parent: Affine,
    /// In the frame of the level, or in that of its boxes if it has one.
    pub bounds: Aabb,
    pub target: Target,
    /// The object that begins here or in a scope around it; `None` where the object is named further up.
    pub object: Option<u32>,
    /// The innermost scope in the level that it is in. If its object is another, the object begins at this placement.
    pub scope: Option<u32>,
    /// Number of paths of the level that come before this placement.
    pub first_path: u64,
    pub(super) name: NameId,
}

#[derive(Clone, Copy, Debug)]
pub(crate) enum Target {
    Body(u32),
    Level(u32),
}

impl Level {
    /// The number of placements.
    pub fn placement_count(&self) -> u32 {
        self.lattice.as_ref().map_or(self.placements.len() as u32, |cells| cells.count())
    }

    /// Whether there is a placement with this number.
    pub fn has_placement(&self, number: u32) -> bool {
        let is_used = |cells: &LatticeCells| cells.element(number).is_some();
        number < self.placement_count() && self.lattice.as_deref().is_none_or(is_used)
    }

    /// A placement. The cell of a lattice must not be empty.
    #[inline]
    pub fn placement(&self, number: u32) -> Cow<'_, Placement> {
        match &self.lattice {
            None => Cow::Borrowed(&self.placements[number as usize]),
            Some(cells) => Cow::Owned(self.cell(cells, number)),
        }
    }

    /// The box of a placement, in the frame of the boxes.
    #[inline]
    pub fn bounds_of(&self, number: u32) -> Aabb {
        match &self.lattice {
            None => self.placements[number as usize].bounds,
            Some(cells) => cells.bounds(number, cells.element(number).unwrap_or_default()),
        }
    }

    /// The transform into a placement.
    #[inline]
    pub fn frame_of(&self, number: u32) -> Affine {
        match &self.lattice {
            None => self.placements[number as usize].local_from_parent,
            Some(cells) => cells.local_from_parent(number, cells.element(number).unwrap_or_default()),
        }
    }

    #[inline(never)]
    fn cell(&self, cells: &LatticeCells, number: u32) -> Placement {
        let element = cells.element(number).unwrap_or_default();
        Placement {
            local_from_parent: cells.local_from_parent(number, element),
            bounds: cells.bounds(number, element),
            first_path: cells.first_path(number),
            ..self.placements[element as usize].clone()
        }
    }

    /// The number of the placement that a path of the level runs through.
    #[inline]
    pub fn placement_of_path(&self, path: u64) -> u32 {
        match &self.lattice {
            None => self.listed_of_path(path) as u32,
            Some(cells) => cells.cell_of_path(path),
        }
    }

    /// Most levels have as many paths in each placement: there the first guess is right, without a search.
    #[inline]
    fn listed_of_path(&self, path: u64) -> usize {
        let begins = |number: usize| self.placements.get(number).map_or(u64::MAX, |placed| placed.first_path);
        let share = path as f64 / self.path_count as f64;
        let guess = ((share * self.placements.len() as f64) as usize).min(self.placements.len() - 1);
        if begins(guess) <= path && path < begins(guess + 1) {
            return guess;
        }
        self.placements.partition_point(|placed| placed.first_path <= path) - 1
    }

    /// The numbers of the placements; the empty cells of a lattice are left out.
    pub fn numbers(&self) -> impl Iterator<Item = u32> {
        self.numbers_by(1)
    }

    /// The numbers of some placements, at equal steps.
    pub fn numbers_by(&self, step: u32) -> impl Iterator<Item = u32> {
        (0..self.placement_count()).step_by(step as usize).filter(|&number| self.has_placement(number))
    }

    /// Whether it is a lattice of which every cell holds the same element.
    pub fn has_equal_cells(&self) -> bool {
        self.lattice.as_ref().is_some_and(|cells| cells.table().is_none())
    }
}
