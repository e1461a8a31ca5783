//! Edges: dark outlines where what a picture shows changes, as in a technical drawing.
//!
//! Rays are cast on a lattice that is finer than the pixels and does not depend on them, on tiles or on samples. Where two neighbours
//! are [apart](apart::are_apart), rays between them find where, up to a small part of a pixel. What is not an edge, but a curved
//! surface seen from the side, is recognised by this: halves of the distance are no longer apart. The lines are discs around the
//! points that were found, which are so close to each other that their union has smooth borders.

mod apart;

use shotline::query::batch::BatchError;
use shotline::ray::Ray;

use self::apart::{Sight, are_apart};
use crate::camera::{CameraError, View};
use crate::color::Rgb;
use crate::exposure::Exposure;
use crate::tile::Tile;
use crate::tracer::{SampleRays, Tracer};

/// Half the width of a line in pixels.
const RADIUS: f64 = 0.75;
/// Lattice points in a pixel, across and down.
const LATTICE: i64 = 2;
/// How often the distance of two neighbours is halved.
const HALVINGS: u32 = 3;
/// Places in a pixel, across and down, of which a line covers some.
const PLACES: u32 = 8;
/// The linear colour of lines.
const INK: Rgb = Rgb::new(0.006, 0.007, 0.010);

/// How much darker lines make what is behind surfaces that are seen through.
const BEHIND: f64 = 0.5;

/// Which surfaces have edges.
#[derive(Clone, Copy)]
enum Layer {
    /// The first ones.
    First,
    /// The first ones that are not seen through.
    Opaque,
}

/// What looks at positions in the picture.
struct Eye<'a, 'w> {
    view: &'a View,
    tracer: &'a mut Tracer<'w>,
    layer: Layer,
}

/// Why the edges of a tile are not known.
pub(crate) enum EdgesError {
    Camera(CameraError),
    Cast(BatchError),
}

impl From<CameraError> for EdgesError {
    fn from(error: CameraError) -> EdgesError {
        EdgesError::Camera(error)
    }
}

impl From<BatchError> for EdgesError {
    fn from(error: BatchError) -> EdgesError {
        EdgesError::Cast(error)
    }
}

/// The share of each pixel of a tile that lines cover, row by row. Lines behind what is seen through count as [`BEHIND`].
pub(crate) fn coverage(tile: &Tile, view: &View, tracer: &mut Tracer) -> Result<Vec<f64>, EdgesError> {
    let places = |places: u64| f64::from(places.count_ones()) / f64::from(PLACES * PLACES);
    let first = covered(tile, &mut Eye { view, tracer, layer: Layer::First })?;
    if tracer.is_opaque() {
        return Ok(first.into_iter().map(places).collect());
    }
    let behind = covered(tile, &mut Eye { view, tracer, layer: Layer::Opaque })?;
    let share = |(first, behind): (u64, u64)| places(first) + BEHIND * places(behind & !first);
    Ok(first.into_iter().zip(behind).map(share).collect())
}

/// By pixel of a tile, the places that lines cover.
fn covered(tile: &Tile, eye: &mut Eye) -> Result<Vec<u64>, EdgesError> {
    let pairs = neighbours(tile, eye)?;
    let mut lines = Lines { tile, covered: vec![0; tile.width as usize * tile.height as usize] };
    for [a, b] in narrowed(pairs, eye)? {
        lines.add([(a.x + b.x) / 2.0, (a.y + b.y) / 2.0]);
    }
    Ok(lines.covered)
}

/// Draws the lines over developed pixels.
pub(crate) fn draw(exposure: &mut Exposure) {
    for sample in exposure.samples.iter_mut().filter(|sample| sample.ink > 0.0) {
        sample.color = sample.color * (1.0 - sample.ink) + INK * sample.ink;
        sample.alpha = sample.alpha * (1.0 - sample.ink) + sample.ink;
    }
}

/// What is seen at a position in the picture, in pixels.
#[derive(Clone, Copy)]
struct Spot {
    x: f64,
    y: f64,
    sight: Sight,
}

/// What is seen at some positions.
fn look_at(positions: &[[f64; 2]], eye: &mut Eye) -> Result<Vec<Spot>, EdgesError> {
    let Eye { view, tracer, layer } = eye;
    let (mut rays, mut spots) = (SampleRays::default(), Vec::with_capacity(positions.len()));
    for (number, &[x, y]) in (0..).zip(positions) {
        let ray: Ray = view.ray(x, y)?;
        rays.push(ray, number);
        spots.push(Spot { x, y, sight: Sight { ray, point: None } });
    }
    tracer.begin(rays.len());
    let points = match layer {
        Layer::First => tracer.surfaces(&rays)?,
        Layer::Opaque => tracer.opaque_surfaces(&rays)?,
    };
    for point in points {
        spots[point.ray].sight.point = Some(point);
    }
    Ok(spots)
}

/// The neighbours on the lattice that are apart, in all rows and columns of which a line can reach into a tile.
fn neighbours(tile: &Tile, eye: &mut Eye) -> Result<Vec<[Spot; 2]>, EdgesError> {
    let margin = (RADIUS * LATTICE as f64).ceil() as i64;
    let range = |start: u32, count: u32| {
        let start = i64::from(start) * LATTICE;
        start - margin..start + i64::from(count) * LATTICE + margin
    };
    let (columns, rows) = (range(tile.left, tile.width), range(tile.top, tile.height));
    let position = |number: i64| (number as f64 + 0.5) / LATTICE as f64;
    let positions: Vec<_> =
        rows.flat_map(|row| columns.clone().map(move |column| [position(column), position(row)])).collect();
    let spots = look_at(&positions, eye)?;
    let across = (columns.end - columns.start) as usize;
    let mut pairs = Vec::new();
    for (number, spot) in spots.iter().enumerate() {
        let right = (number + 1) % across != 0;
        let others = [right.then_some(number + 1), Some(number + across)];
        for other in others.into_iter().flatten().filter_map(|other| spots.get(other)) {
            if are_apart(&spot.sight, &other.sight) {
                pairs.push([*spot, *other]);
            }
        }
    }
    Ok(pairs)
}

/// Halves the distance of pairs that are apart; a pair neither of whose halves is apart goes.
fn narrowed(mut pairs: Vec<[Spot; 2]>, eye: &mut Eye) -> Result<Vec<[Spot; 2]>, EdgesError> {
    for _ in 0..HALVINGS {
        let middles: Vec<_> = pairs.iter().map(|[a, b]| [(a.x + b.x) / 2.0, (a.y + b.y) / 2.0]).collect();
        let middles = look_at(&middles, eye)?;
        pairs = pairs
            .into_iter()
            .zip(middles)
            .filter_map(|([a, b], middle)| {
                [[a, middle], [middle, b]].into_iter().find(|[a, b]| are_apart(&a.sight, &b.sight))
            })
            .collect();
    }
    Ok(pairs)
}

/// What lines cover of a tile.
struct Lines<'a> {
    tile: &'a Tile,
    /// By pixel, a bit for each of its places, row by row.
    covered: Vec<u64>,
}

impl Lines<'_> {
    /// Adds a disc around a point of the picture.
    fn add(&mut self, [x, y]: [f64; 2]) {
        let &Tile { left, top, width, height } = self.tile;
        let range = |x: f64, start: u32, count: u32| {
            let first = (x - RADIUS).floor().max(f64::from(start)) as u32;
            first..((x + RADIUS).floor() as u32 + 1).min(start + count)
        };
        if x + RADIUS < f64::from(left) || y + RADIUS < f64::from(top) {
            return;
        }
        for row in range(y, top, height) {
            for column in range(x, left, width) {
                let index = (row - top) as usize * width as usize + (column - left) as usize;
                self.covered[index] |= places_in_disc(x - f64::from(column), y - f64::from(row));
            }
        }
    }
}

/// The places of a pixel that are in the disc around a point, which is relative to its upper left corner.
fn places_in_disc(x: f64, y: f64) -> u64 {
    let at = |number: u32| (f64::from(number) + 0.5) / f64::from(PLACES);
    let mut bits = 0;
    for row in 0..PLACES {
        for column in 0..PLACES {
            let (across, down) = (at(column) - x, at(row) - y);
            if across * across + down * down < RADIUS * RADIUS {
                bits |= 1 << (row * PLACES + column);
            }
        }
    }
    bits
}
