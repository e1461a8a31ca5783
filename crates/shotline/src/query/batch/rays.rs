//! What a batch is asked about, by number: rays and points are made one by one from whatever holds their numbers,
//! so that no copy of all of them is needed.

use std::ops::Range;

use super::BatchError;
use crate::math::Vec3;
use crate::ray::{InvalidRay, Ray};

/// Rays by number, made when they are asked for; by many threads, and more than once.
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
    /// How many there are.
    fn len(&self) -> usize;

    /// Whether there is none.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The ray of a row, below [`Rays::len`].
    ///
    /// # Errors
    /// [`InvalidRay`] if the numbers there are not a ray.
    fn ray(&self, row: usize) -> Result<Ray, InvalidRay>;

    /// Looks at some rows before any work starts. Rays that cannot be invalid need no look.
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

/// Points by number, made when they are asked for.
pub trait Points: Sync {
    /// How many there are.
    fn len(&self) -> usize;

    /// Whether there is none.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The point of a row, below [`Points::len`]. It must be finite to have an answer.
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
    /// Answers the first row that cannot be asked about.
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
