//! The part of a plane that a slice shows.

use shotline::aabb::Aabb;
use shotline::compile::World;
use shotline::math::Vec3;
use shotline::measure::object_bounds;
use shotline::scene::Scene;

use super::SliceError;
use super::plane::SlicePlane;

/// The margin around the objects, as a share of the longer side.
const MARGIN: f64 = 0.04;

/// The pixels along the longer side where no size is given.
const LONGER_SIDE: f64 = 800.0;

/// The largest ratio of the sides of an area that is chosen.
const MAX_RATIO: f64 = 3.0;

/// A rectangle in a plane, in the coordinates of its axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Area {
    /// The lower left corner.
    pub min: [f64; 2],
    /// The upper right corner.
    pub max: [f64; 2],
}

impl Area {
    /// A rectangle between two corners.
    ///
    /// # Errors
    /// [`SliceError::Area`] if it has no area, or is not finite.
    pub fn new(min: [f64; 2], max: [f64; 2]) -> Result<Area, SliceError> {
        let area = Area { min, max };
        let is_valid = area.size().iter().all(|side| *side > 0.0 && side.is_finite());
        if is_valid { Ok(area) } else { Err(SliceError::Area) }
    }

    /// Its width and its height.
    pub fn size(&self) -> [f64; 2] {
        [self.max[0] - self.min[0], self.max[1] - self.min[1]]
    }

    /// The same middle, and other sides.
    fn with_size(&self, size: [f64; 2]) -> Area {
        let middle = [0, 1].map(|i| self.min[i].midpoint(self.max[i]));
        Area {
            min: [0, 1].map(|i| middle[i] - size[i] / 2.0),
            max: [0, 1].map(|i| middle[i] + size[i] / 2.0),
        }
    }

    /// The rectangle of some points of a plane; `None` without points.
    fn around(plane: &SlicePlane, points: impl Iterator<Item = Vec3>) -> Option<Area> {
        let coordinates = points.map(|p| [plane.u().dot(p), plane.v().dot(p)]);
        coordinates.map(|p| Area { min: p, max: p }).reduce(Area::union)
    }

    fn union(self, other: Area) -> Area {
        Area {
            min: [0, 1].map(|i| self.min[i].min(other.min[i])),
            max: [0, 1].map(|i| self.max[i].max(other.max[i])),
        }
    }
}

/// The area and the number of pixels of a slice, each as given or else chosen. Pixels are square, unless both are given.
pub fn frame(
    world: &World,
    plane: &SlicePlane,
    area: Option<Area>,
    size: Option<(u32, u32)>,
) -> Result<(Area, (u32, u32)), SliceError> {
    let chosen = match area {
        Some(area) => area,
        None => default_area(world, plane, size)?,
    };
    let size = size.unwrap_or_else(|| {
        let [width, height] = chosen.size();
        let scale = LONGER_SIDE / width.max(height);
        let pixels = |side: f64| (side * scale).round().max(1.0) as u32;
        (pixels(width), pixels(height))
    });
    Ok((chosen, size))
}

/// The area of a slice in which what is shown by default fills the picture: that of everything but the objects that enclose all
/// others, as in pictures. `None` if there are none, and the default of a slice holds.
pub fn area_within_enclosures(scene: &Scene, plane: &SlicePlane, size: Option<(u32, u32)>) -> Option<Area> {
    let hidden = scene.hiding_enclosures();
    if hidden.is_empty() {
        return None;
    }
    default_area(&scene.without(&hidden).compile().ok()?, plane, size).ok()
}

/// The rectangle of what is bounded in the plane, or next to it if nothing is, with a margin.
fn default_area(world: &World, plane: &SlicePlane, size: Option<(u32, u32)>) -> Result<Area, SliceError> {
    let all = world.finite_bounds();
    if all.is_empty() || !all.is_finite() {
        return Err(SliceError::NothingBounded);
    }
    // Where objects are nested too deep to be told apart, all count together.
    let boxes = object_bounds(world).unwrap_or_else(|_| vec![all]);
    let finite = boxes.iter().filter(|b| b.is_finite() && !b.is_empty());
    let met = finite.filter_map(|b| Area::around(plane, meeting(b, plane))).reduce(Area::union);
    let met = met.or_else(|| Area::around(plane, meeting(&all, plane)));
    let found = met.or_else(|| Area::around(plane, corners(&all))).ok_or(SliceError::NothingBounded)?;
    let [width, height] = found.size();
    let longer = width.max(height);
    // A point has no size of its own.
    let longer = if longer > 0.0 { longer } else { found.min[0].abs().max(found.min[1].abs()).max(1.0) };
    let sides = [width, height].map(|side| side + 2.0 * MARGIN * longer);
    let least = longer * (1.0 + 2.0 * MARGIN) / MAX_RATIO;
    let area = found.with_size(widened(sides.map(|side| side.max(least)), size));
    Area::new(area.min, area.max)
}

/// The sides, the shorter one made longer so that pixels are square.
fn widened([width, height]: [f64; 2], size: Option<(u32, u32)>) -> [f64; 2] {
    match size {
        Some((columns, rows)) if columns > 0 && rows > 0 => {
            let side = (width / f64::from(columns)).max(height / f64::from(rows));
            [side * f64::from(columns), side * f64::from(rows)]
        }
        _ => [width, height],
    }
}

/// The eight corners of a box; two that differ in one bit are the ends of an edge.
fn corners(b: &Aabb) -> impl Iterator<Item = Vec3> + use<> {
    let ends = [b.min, b.max];
    (0..8).map(move |i: usize| Vec3::new(ends[i & 1].x, ends[i >> 1 & 1].y, ends[i >> 2].z))
}

/// Where the edges of a box meet a plane; none if the box is beside it.
fn meeting(b: &Aabb, plane: &SlicePlane) -> impl Iterator<Item = Vec3> + use<> {
    let corners: Vec<Vec3> = corners(b).collect();
    let plane = *plane;
    let height = move |p: Vec3| plane.normal().dot(p) - plane.distance();
    let edges = (0..8).flat_map(|i: usize| (0..3).map(move |bit| (i, i | 1 << bit))).filter(|(i, j)| i != j);
    edges.filter_map(move |(i, j)| {
        let (a, b) = (corners[i], corners[j]);
        let (below, above) = (height(a), height(b));
        let share = below / (below - above);
        match (below == 0.0, above == 0.0) {
            (true, _) => Some(a),
            (_, true) => Some(b),
            _ => ((below < 0.0) != (above < 0.0)).then(|| a + (b - a) * share),
        }
    })
}
