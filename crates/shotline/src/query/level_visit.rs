//! The rays of a bundle in the frame of a level.

use super::level_boxes::box_ray;
use super::level_paths;
use crate::aabb::BoxRay;
use crate::accel::{BEAM_RAYS, Beam, BeamRays, BeamSome, ByRay};
use crate::compile::{Level, Placement};
use crate::lanes::{BoxLanes, LineLanes};
use crate::math::{Affine, Vec3};
use crate::ray::{Line, Span};
use crate::simd::{Doubles, Simd, Task, dispatch};

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
    /// The numbers of their lines, in the order of [`Line`]. Other places mean nothing, and errors mean nothing if the
    /// lines are exact.
    lines: [[ByRay; 3]; 4],
    are_exact: bool,
    pub boxes: BeamRays,
    pub beam: Beam,
}

impl Default for ManyRays {
    /// No rays.
    fn default() -> ManyRays {
        let lines = [[[[0.0; 8]; BEAM_RAYS / 8]; 3]; 4];
        ManyRays { places: 0, lines, are_exact: true, boxes: BeamRays::default(), beam: Beam::default() }
    }
}

impl ManyRays {
    /// Sets rays in world coordinates at the first places, and the first of them at the others.
    pub fn set_exact(&mut self, rows: &[[f64; 6]], is_loose: bool, span: Span) {
        self.places = u32::MAX >> (BEAM_RAYS - rows.len());
        self.are_exact = true;
        let [o, d, ..] = &mut self.lines;
        for place in 0..BEAM_RAYS {
            let row = &rows[if place < rows.len() { place } else { 0 }];
            for axis in 0..3 {
                o[axis][place / 8][place % 8] = row[axis];
                d[axis][place / 8][place % 8] = row[3 + axis];
            }
        }
        let first = BoxRay::new(&self.line(0), span);
        let [o, d, ..] = &self.lines;
        if !self.boxes.set_exact(o, d, &first) {
            (0..BEAM_RAYS).for_each(|place| {
                let ray = BoxRay::new(&self.line(place), span);
                self.boxes.set(place, &ray);
            });
        }
        self.set_beam(is_loose, span);
    }

    /// Sets the lines at the places of a mask to those of the rays of a level above, in the frame below it. Boxes may be in
    /// another frame than the lines.
    pub fn set_below(
        &mut self,
        above: &ManyRays,
        places: u32,
        local_from_parent: &Affine,
        box_frame: Option<&Affine>,
        span: Span,
    ) {
        (self.places, self.are_exact) = (places, false);
        self.boxes.set_span(span.t_min(), span.t_max());
        dispatch(Below { rays: self, above, local_from_parent, box_frame, span });
        self.set_beam(above.beam.is_loose, span);
    }

    fn set_beam(&mut self, is_loose: bool, span: Span) {
        self.beam = if is_loose { Beam::loose(span.t_min(), span.t_max()) } else { self.boxes.beam() };
    }

    /// Some of the rays, each up to its limit.
    pub fn some<'a>(&'a self, places: u32, limits: &'a ByRay) -> BeamSome<'a> {
        BeamSome { rays: &self.boxes, beam: &self.beam, places, limits }
    }

    /// The line at a place.
    pub fn line(&self, place: usize) -> Line {
        let number = |of: usize, axis: usize| self.lines[of][axis][place / 8][place % 8];
        let vector = |of: usize| Vec3::new(number(of, 0), number(of, 1), number(of, 2));
        let error = |of: usize| if self.are_exact { Vec3::ZERO } else { vector(of) };
        Line { o: vector(0), d: vector(1), o_err: error(2), d_err: error(3) }
    }

    /// The lines of some lanes.
    #[inline(always)]
    pub fn line_lanes<F: Doubles>(&self, lanes: &Lanes) -> LineLanes<F> {
        let zero = [F::splat(0.0); 3];
        LineLanes {
            o: self.vectors(0, lanes),
            d: self.vectors(1, lanes),
            o_err: if self.are_exact { zero } else { self.vectors(2, lanes) },
            d_err: if self.are_exact { zero } else { self.vectors(3, lanes) },
        }
    }

    #[inline(always)]
    fn vectors<F: Doubles>(&self, of: usize, lanes: &Lanes) -> [F; 3] {
        let [x, y, z] = &self.lines[of];
        [lanes.load(x), lanes.load(y), lanes.load(z)]
    }
}

/// Sets rays to those of a level above.
struct Below<'a> {
    rays: &'a mut ManyRays,
    above: &'a ManyRays,
    local_from_parent: &'a Affine,
    box_frame: Option<&'a Affine>,
    span: Span,
}

impl Task for Below<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        let Below { rays, above, local_from_parent, box_frame, span } = self;
        let other = above.line(rays.places.trailing_zeros() as usize);
        for first in (0..BEAM_RAYS).step_by(S::Wide::LANES) {
            let used = (rays.places >> first) as u8;
            let lanes = Lanes::from(first);
            // Places that are not used hold another ray.
            let line = above.line_lanes::<S::Wide>(&lanes).where_set(used, &LineLanes::splat(&other));
            let line = line.in_frame(local_from_parent);
            for (to, vector) in rays.lines.iter_mut().zip([line.o, line.d, line.o_err, line.d_err]) {
                for axis in 0..3 {
                    vector[axis].store_some(&mut to[axis][first / 8], first % 8);
                }
            }
            let boxes = match box_frame {
                None => line,
                Some(frame) => line.in_frame(frame),
            };
            rays.boxes.set_lanes(first, &BoxLanes::new(&boxes, span));
        }
    }
}

/// The rays of a bundle that are in lanes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lanes {
    /// The places of the rays. Other lanes hold any ray.
    pub places: [u8; 8],
    /// A mask of the lanes with rays.
    pub used: u8,
    /// Whether the places follow each other, from a multiple of the number of lanes.
    is_contiguous: bool,
}

impl Lanes {
    /// The rays at the places from `first` on.
    #[inline(always)]
    fn from(first: usize) -> Lanes {
        Lanes { places: [first as u8; 8], used: u8::MAX, is_contiguous: true }
    }

    /// The rays of a mask, as many at a time as there are lanes: those of places that follow each other, unless that would
    /// leave many lanes unused.
    pub fn of(rays: u32, count: usize) -> impl Iterator<Item = Lanes> {
        let of_group = (1 << count) - 1;
        let groups = (0..BEAM_RAYS).step_by(count).filter(|first| rays >> first & of_group != 0).count();
        let gathers = (rays.count_ones() as usize).div_ceil(count) < groups;
        let mut rest = rays;
        std::iter::from_fn(move || {
            let first = (rest != 0).then(|| rest.trailing_zeros() as usize)?;
            let mut lanes = Lanes { places: [first as u8; 8], used: 0, is_contiguous: !gathers };
            if gathers {
                for (lane, place) in ones(rest).take(count).enumerate() {
                    lanes.places[lane] = place as u8;
                    lanes.used |= 1 << lane;
                    rest &= rest - 1;
                }
            } else {
                let first = first - first % count;
                (0..count).for_each(|lane| lanes.places[lane] = (first + lane) as u8);
                lanes.used = (rest >> first & of_group) as u8;
                rest &= !(of_group << first);
            }
            Some(lanes)
        })
    }

    /// The numbers of the rays.
    #[inline(always)]
    pub fn load<F: Doubles>(&self, numbers: &ByRay) -> F {
        if self.is_contiguous {
            let first = usize::from(self.places[0]);
            return F::load_some(&numbers[first / 8], first % 8);
        }
        let mut gathered = [0.0; 8];
        for (number, place) in gathered.iter_mut().zip(self.places) {
            *number = numbers.as_flattened()[usize::from(place)];
        }
        F::load_some(&gathered, 0)
    }
}

impl OneRay {
    /// The ray of a line.
    pub fn new(place: usize, line: Line, span: Span) -> OneRay {
        OneRay { place, line, boxes: BoxRay::new(&line, span) }
    }

    /// The ray of a line in a level that is placed in another, where the line is given.
    pub fn below(
        place: usize,
        (level_above, line_above): (&Level, &Line),
        placed: &Placement,
        level: &Level,
        span: Span,
    ) -> OneRay {
        let line = line_above.in_frame(&placed.local_from_parent);
        let boxes = match level.lattice {
            None => box_ray(level, &line, span),
            Some(_) => BoxRay::inside(&line, &box_ray(level_above, line_above, span), &placed.bounds),
        };
        OneRay { place, line, boxes }
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
