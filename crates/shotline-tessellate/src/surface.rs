//! What rays tell of the surface of an object.

use shotline::compile::World;
use shotline::math::Vec3;
use shotline::query::batch::{self, BatchError, CrossingRows, Fields, Rays, Run};
use shotline::ray::{InvalidRay, Ray, Span};

/// Rays that are cast at once, so that memory does not grow with their number.
const ROUND: usize = 1 << 17;

/// The `kind` of an event at a point inside of which a ray starts, and of one where it crosses a surface.
const START: i8 = 1;
const SURFACE: i8 = 0;

/// The surface of an object: of the union of all its instances.
pub struct Surface<'w> {
    pub world: &'w World,
    pub object: u32,
    pub run: Run<'w>,
}

/// A ray for each of some items.
struct RaysOf<'a, T, F> {
    items: &'a [T],
    ray: F,
}

impl<T: Sync, F: Fn(&T) -> Result<Ray, InvalidRay> + Sync> Rays for RaysOf<'_, T, F> {
    fn len(&self) -> usize {
        self.items.len()
    }

    fn ray(&self, row: usize) -> Result<Ray, InvalidRay> {
        (self.ray)(&self.items[row])
    }
}

/// What a ray tells of the points up to the end of its direction.
#[derive(Clone, Debug, Default)]
pub struct Line {
    /// Whether its first point is inside.
    pub starts_inside: bool,
    /// In order.
    pub crossings: Vec<SurfaceCrossing>,
}

/// Where a ray crosses the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceCrossing {
    pub t: f64,
    pub entering: bool,
    /// The unit normal, out of the object.
    pub normal: Vec3,
}

impl Surface<'_> {
    /// Casts a ray for each of some items, from its origin to the end of its direction, and calls `each` with what it tells.
    pub fn cast<T: Sync>(
        &self,
        items: &[T],
        ray: impl Fn(&T) -> Result<Ray, InvalidRay> + Sync,
        mut each: impl FnMut(&T, &Line),
    ) -> Result<(), BatchError> {
        let fields = Fields::NORMAL | Fields::OBJECT | Fields::ENTERING | Fields::KIND;
        let span = Span::new(0.0, 1.0).unwrap_or(Span::FORWARD);
        let mut line = Line::default();
        for items in items.chunks(ROUND) {
            let rays = RaysOf { items, ray: &ray };
            let rows = batch::crossings(self.world, &rays, span, Run { fields, ..self.run })?;
            for (number, item) in items.iter().enumerate() {
                self.read(&rows, number, &mut line);
                each(item, &line);
            }
        }
        Ok(())
    }

    /// Reads what a ray tells from the rows of a batch.
    fn read(&self, rows: &CrossingRows, ray: usize, line: &mut Line) {
        let range = rows.ray_splits[ray] as usize..rows.ray_splits[ray + 1] as usize;
        line.starts_inside = false;
        line.crossings.clear();
        let mut depth = 0;
        for row in range.filter(|row| rows.object[*row] as u32 == self.object) {
            let entering = rows.entering[row];
            let before = depth;
            depth += if entering { 1 } else { -1 };
            line.starts_inside |= rows.kind[row] == START;
            let is_outermost = before == 0 || depth == 0;
            if is_outermost && rows.kind[row] == SURFACE {
                let normal = Vec3::from_array(rows.normal[row]);
                line.add(SurfaceCrossing { t: rows.t[row], entering, normal });
            }
        }
    }
}

impl Line {
    /// Adds a crossing. Where one instance ends and another begins at the same place there is no surface.
    fn add(&mut self, crossing: SurfaceCrossing) {
        let is_undone = |last: &&SurfaceCrossing| last.t == crossing.t && last.entering != crossing.entering;
        if self.crossings.last().filter(is_undone).is_some() {
            self.crossings.pop();
        } else {
            self.crossings.push(crossing);
        }
    }
}
