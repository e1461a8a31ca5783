//! The rays of a bundle in the frame of a level.

use super::level_paths;
use crate::aabb::BoxRay;
use crate::accel::{BEAM_RAYS, Beam, BeamRays};
use crate::compile::Level;
use crate::math::Vec3;
use crate::ray::{Line, Span};

/// A visit of a level: a level that rays of a bundle have entered.
#[derive(Debug)]
pub(super) struct LevelVisit<'w> {
    pub level: &'w Level,
    /// The rays, if there are several.
    pub many: Option<Box<ManyRays>>,
    /// The path to the level.
    pub path: u32,
    pub object: u32,
    pub first_path: u64,
    /// Unique for each visit of a bundle.
    pub serial: u32,
    /// Whether placements need tags, because the accelerator may return one of them more than once.
    pub has_duplicate_refs: bool,
    /// The number of pending entries and of offers in it. At 0 its memory is reused.
    pub uses: u32,
}

impl<'w> LevelVisit<'w> {
    /// A visit of the root, or of another level whose path is still to be set. `many` are its rays unless it has only one.
    pub fn new(level: &'w Level, many: Option<Box<ManyRays>>) -> LevelVisit<'w> {
        LevelVisit {
            level,
            many,
            path: level_paths::ROOT,
            object: 0,
            first_path: 0,
            serial: 0,
            has_duplicate_refs: false,
            uses: 0,
        }
    }
}

/// The only ray of a visit.
#[derive(Clone, Copy, Debug)]
pub(super) struct OneRay {
    /// Its place in the bundle.
    pub place: usize,
    pub line: Line,
    pub boxes: BoxRay,
}

/// Several rays, each at its place in the bundle.
#[derive(Debug)]
pub(super) struct ManyRays {
    /// A mask of the places.
    pub places: u32,
    pub lines: [Line; BEAM_RAYS],
    pub boxes: BeamRays,
    pub beam: Beam,
}

impl Default for ManyRays {
    /// No rays.
    fn default() -> ManyRays {
        let lines = [Line::exact(Vec3::ZERO, Vec3::X); BEAM_RAYS];
        ManyRays { places: 0, lines, boxes: BeamRays::default(), beam: Beam::default() }
    }
}

impl ManyRays {
    /// Sets lines without errors at the first places.
    pub fn set_exact(&mut self, lines: &[Line], span: Span) {
        self.places = u32::MAX >> (BEAM_RAYS - lines.len());
        let mut rays = [(Vec3::ZERO, Vec3::X); BEAM_RAYS];
        for (place, line) in lines.iter().enumerate() {
            self.lines[place] = *line;
            rays[place] = (line.o, line.d);
        }
        if self.boxes.set_exact(&rays[..lines.len()], &BoxRay::new(&lines[0], span)) {
            self.beam = self.boxes.beam();
        } else {
            self.set(self.places, |place| lines[place], span);
        }
    }

    /// Sets lines at the places of a mask.
    pub fn set(&mut self, places: u32, line: impl Fn(usize) -> Line, span: Span) {
        self.places = places;
        self.boxes.fill(&BoxRay::new(&line(places.trailing_zeros() as usize), span));
        for place in ones(places) {
            self.lines[place] = line(place);
            self.boxes.set(place, &BoxRay::new(&self.lines[place], span));
        }
        self.beam = self.boxes.beam();
    }
}

impl OneRay {
    /// The ray of a line.
    pub fn new(place: usize, line: Line, span: Span) -> OneRay {
        OneRay { place, line, boxes: BoxRay::new(&line, span) }
    }
}

/// The positions of the ones of a mask.
pub(super) fn ones(mut mask: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let place = (mask != 0).then(|| mask.trailing_zeros() as usize)?;
        mask &= mask - 1;
        Some(place)
    })
}
