//! Rays and points, read in place from arrays.

use std::ops::Range;

use numpy::{PyReadonlyArray2, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use shotline::math::Vec3;
use shotline::query::batch::{Points, Rays};
use shotline::ray::{InvalidRay, Ray};

/// The origins and directions of rays, in rows of three numbers.
#[derive(Clone, Copy, Debug)]
pub struct RayRows<'a> {
    origins: Rows<'a>,
    directions: Rows<'a>,
    /// The rows, if origins and directions are in one array.
    rows_of_six: Option<&'a [[f64; 6]]>,
    count: usize,
}

/// Rows of three numbers at a fixed step; with a step of 0 all rows are the same.
#[derive(Clone, Copy, Debug)]
struct Rows<'a> {
    numbers: &'a [f64],
    step: usize,
}

impl Rows<'_> {
    #[inline]
    fn get(&self, row: usize) -> Vec3 {
        // The constructor has checked the length.
        self.numbers
            .get(row * self.step..)
            .and_then(|rest| rest.first_chunk())
            .map_or(Vec3::NAN, |&v| v.into())
    }
}

impl<'a> RayRows<'a> {
    /// Takes origins and directions of shape (n, 3), or (3,) for one that all rays share; or both in one array of shape
    /// (n, 6).
    pub fn new(
        count: usize,
        origins: &'a PyReadonlyArrayDyn<f64>,
        directions: Option<&'a PyReadonlyArrayDyn<f64>>,
    ) -> PyResult<RayRows<'a>> {
        let rows = |array: &'a PyReadonlyArrayDyn<f64>| -> PyResult<Rows<'a>> {
            let numbers = array.as_slice()?;
            match array.shape() {
                [3] => Ok(Rows { numbers, step: 0 }),
                [n, 3] if *n == count => Ok(Rows { numbers, step: 3 }),
                shape => Err(PyValueError::new_err(format!(
                    "not an array of {count} points: its shape is {shape:?}"
                ))),
            }
        };
        match directions {
            Some(directions) => Ok(RayRows {
                origins: rows(origins)?,
                directions: rows(directions)?,
                rows_of_six: None,
                count,
            }),
            None => {
                let numbers = origins.as_slice()?;
                if origins.shape() != [count, 6] {
                    return Err(PyValueError::new_err(format!(
                        "not an array of {count} rays of six numbers"
                    )));
                }
                let directions = Rows { numbers: numbers.get(3..).unwrap_or_default(), step: 6 };
                let rows_of_six = Some(numbers.as_chunks().0);
                Ok(RayRows { origins: Rows { numbers, step: 6 }, directions, rows_of_six, count })
            }
        }
    }
}

impl Rays for RayRows<'_> {
    fn len(&self) -> usize {
        self.count
    }

    #[inline]
    fn ray(&self, row: usize) -> Result<Ray, InvalidRay> {
        Ray::new(self.origins.get(row), self.directions.get(row))
    }

    fn numbers(&self, rows: Range<usize>) -> Option<&[[f64; 6]]> {
        self.rows_of_six?.get(rows)
    }
}

/// Points of shape (n, 3).
#[derive(Clone, Copy, Debug)]
pub struct PointRows<'a>(Rows<'a>);

impl<'a> PointRows<'a> {
    pub fn new(points: &'a PyReadonlyArray2<f64>) -> PyResult<PointRows<'a>> {
        if points.shape()[1] != 3 {
            return Err(PyValueError::new_err("points have three coordinates"));
        }
        Ok(PointRows(Rows { numbers: points.as_slice()?, step: 3 }))
    }
}

impl Points for PointRows<'_> {
    fn len(&self) -> usize {
        self.0.numbers.len() / 3
    }

    #[inline]
    fn point(&self, row: usize) -> Vec3 {
        self.0.get(row)
    }
}
