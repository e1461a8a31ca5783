//! The input of a batch: rays and points are created by index, one at a time, from the caller's data, so that
//! no copy of all of them is needed.

use std::ops::Range;

use super::BatchError;
use crate::math::Vec3;
use crate::ray::{InvalidRay, Ray};

/// Rays by index, created on demand. Many threads may request the same ray, and more than once.
///
/// ```
/// use shotline::math::Vec3;
/// use shotline::query::batch::Rays;
/// use shotline::ray::{InvalidRay, Ray};
///
/// /// Downwards from the points of a plane.
/// struct Grid {
///     width: usize,
///     height: usize,
/// }
///
/// impl Rays for Grid {
///     fn len(&self) -> usize {
///         self.width * self.height
///     }
///     fn ray(&self, row: usize) -> Result<Ray, InvalidRay> {
///         let (x, y) = ((row % self.width) as f64, (row / self.width) as f64);
///         Ray::new(Vec3::new(x, y, 10.0), -Vec3::Z)
///     }
/// }
/// ```
pub trait Rays: Sync {
    /// The number of rays.
    fn len(&self) -> usize;

    /// Whether there are no rays.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the ray of a row; `row` is below [`Rays::len`].
    ///
    /// # Errors
    /// [`InvalidRay`] if the values of the row are not a ray.
    fn ray(&self, row: usize) -> Result<Ray, InvalidRay>;

    /// The numbers of some rows, origin and direction, where they are stored like that: they are then read in place.
    fn numbers(&self, _rows: Range<usize>) -> Option<&[[f64; 6]]> {
        None
    }

    /// Validates some rows before any work starts. Rays that cannot be invalid need no check.
    ///
    /// # Errors
    /// The first row that is not a ray.
    fn check(&self, rows: Range<usize>) -> Result<(), (usize, InvalidRay)> {
        rows.into_iter().try_for_each(|row| self.ray(row).map(drop).map_err(|error| (row, error)))
    }
}

impl<T: AsRef<[Ray]> + Sync + ?Sized> Rays for T {
    fn len(&self) -> usize {
        self.as_ref().len()
    }

    fn ray(&self, row: usize) -> Result<Ray, InvalidRay> {
        Ok(self.as_ref()[row])
    }

    fn numbers(&self, rows: Range<usize>) -> Option<&[[f64; 6]]> {
        Some(bytemuck::cast_slice(self.as_ref().get(rows)?))
    }

    fn check(&self, _rows: Range<usize>) -> Result<(), (usize, InvalidRay)> {
        Ok(())
    }
}

/// Points by index, created on demand.
pub trait Points: Sync {
    /// The number of points.
    fn len(&self) -> usize;

    /// Whether there are no points.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the point of a row; `row` is below [`Points::len`]. A point that is not finite is an error of
    /// the batch.
    fn point(&self, row: usize) -> Vec3;
}

impl<T: AsRef<[Vec3]> + Sync + ?Sized> Points for T {
    fn len(&self) -> usize {
        self.as_ref().len()
    }

    fn point(&self, row: usize) -> Vec3 {
        self.as_ref()[row]
    }
}

/// Rays or points, with the errors of a batch.
pub(super) trait Rows: Sync {
    type Row;
    fn len(&self) -> usize;
    fn row(&self, row: usize) -> Result<Self::Row, BatchError>;
    /// The rays of some rows, origin and direction, in place or copied to memory of the caller. Returns the first
    /// invalid row as an error.
    fn rays<'m>(
        &'m self,
        rows: Range<usize>,
        memory: &'m mut Vec<[f64; 6]>,
    ) -> Result<&'m [[f64; 6]], (usize, BatchError)>;
    /// Returns the first invalid row as an error.
    fn check(&self, rows: Range<usize>) -> Result<(), (usize, BatchError)>;
}

/// Rays as rows of six numbers, origin and direction, which are read in place.
///
/// ```
/// use shotline::query::batch::{Rays, RowsOfSix};
/// let rows = RowsOfSix(&[[0.0, 0.0, 9.0, 0.0, 0.0, -1.0]]);
/// assert_eq!(rows.ray(0).unwrap().at(2.0).z, 7.0);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct RowsOfSix<'a>(pub &'a [[f64; 6]]);

impl Rays for RowsOfSix<'_> {
    fn len(&self) -> usize {
        self.0.len()
    }

    #[inline]
    fn ray(&self, row: usize) -> Result<Ray, InvalidRay> {
        let [ox, oy, oz, dx, dy, dz] = self.0[row];
        Ray::new(Vec3::new(ox, oy, oz), Vec3::new(dx, dy, dz))
    }

    fn numbers(&self, rows: Range<usize>) -> Option<&[[f64; 6]]> {
        self.0.get(rows)
    }
}

/// Whether six numbers are a ray, as [`Ray::new`] says.
#[inline]
fn is_ray(row: &[f64; 6]) -> bool {
    // A sum of zeros is not a number exactly if one of them is not finite.
    let zeros = row.iter().fold(0.0, |sum, x| sum + x * 0.0);
    zeros == 0.0 && row[3..] != [0.0; 3]
}

pub(super) struct RayRows<'a, R: ?Sized>(pub &'a R);

impl<R: Rays + ?Sized> Rows for RayRows<'_, R> {
    type Row = Ray;

    fn len(&self) -> usize {
        self.0.len()
    }

    fn row(&self, row: usize) -> Result<Ray, BatchError> {
        self.0.ray(row).map_err(|error| BatchError::Ray { row, error })
    }

    fn rays<'m>(
        &'m self,
        rows: Range<usize>,
        memory: &'m mut Vec<[f64; 6]>,
    ) -> Result<&'m [[f64; 6]], (usize, BatchError)> {
        if let Some(numbers) = self.0.numbers(rows.clone()) {
            let invalid = numbers.iter().position(|row| !is_ray(row));
            return match invalid.map(|at| rows.start + at) {
                Some(row) => Err((row, self.row(row).err().unwrap_or(BatchError::Cancelled))),
                None => Ok(numbers),
            };
        }
        memory.clear();
        for row in rows {
            let ray = self.row(row).map_err(|error| (row, error))?;
            let (o, d) = (ray.origin(), ray.direction());
            memory.push([o.x, o.y, o.z, d.x, d.y, d.z]);
        }
        Ok(memory)
    }

    fn check(&self, rows: Range<usize>) -> Result<(), (usize, BatchError)> {
        self.0.check(rows).map_err(|(row, error)| (row, BatchError::Ray { row, error }))
    }
}

pub(super) struct PointRows<'a, P: ?Sized>(pub &'a P);

impl<P: Points + ?Sized> Rows for PointRows<'_, P> {
    type Row = Vec3;

    fn len(&self) -> usize {
        self.0.len()
    }

    fn row(&self, row: usize) -> Result<Vec3, BatchError> {
        let point = self.0.point(row);
        if point.is_finite() { Ok(point) } else { Err(BatchError::Point { row }) }
    }

    fn rays<'m>(
        &'m self,
        rows: Range<usize>,
        memory: &'m mut Vec<[f64; 6]>,
    ) -> Result<&'m [[f64; 6]], (usize, BatchError)> {
        memory.clear();
        for row in rows {
            let p = self.row(row).map_err(|error| (row, error))?;
            memory.push([p.x, p.y, p.z, 0.0, 0.0, 1.0]);
        }
        Ok(memory)
    }

    fn check(&self, rows: Range<usize>) -> Result<(), (usize, BatchError)> {
        rows.into_iter().try_for_each(|row| self.row(row).map(drop).map_err(|error| (row, error)))
    }
}
