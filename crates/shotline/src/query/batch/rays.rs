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
    /// Returns the first invalid row as an error.
    fn check(&self, rows: Range<usize>) -> Result<(), (usize, BatchError)>;
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

    fn check(&self, rows: Range<usize>) -> Result<(), (usize, BatchError)> {
        rows.into_iter().try_for_each(|row| self.row(row).map(drop).map_err(|error| (row, error)))
    }
}
