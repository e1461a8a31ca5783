//! The rays of a batch, and what to do with rows that are not valid rays.

use clap::ValueEnum;
use shotline::math::Vec3;
use shotline::ray::{InvalidRay, Ray};

/// What to do with a row that is not a valid ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum OnInvalid {
    /// End with an error that names the first such row
    Error,
    /// Count it and report a miss
    Miss,
}

/// Rays, and the rows of the file in which they are.
#[derive(Debug)]
pub struct Rays {
    /// The valid rays, in order.
    pub valid: Vec<Ray>,
    /// How many rows there are.
    pub rows: usize,
    /// The row of each valid ray; `None` if every row is valid, so that ray i is in row i.
    rows_of_valid: Option<Vec<usize>>,
}

/// A row that is not a valid ray.
#[derive(Debug, PartialEq)]
pub struct InvalidRow {
    /// Its number, from 0.
    pub row: usize,
    /// Its numbers.
    pub numbers: [f64; 6],
    /// Why it is not a valid ray.
    pub why: InvalidRay,
}

/// Why rows cannot be cast.
#[derive(Debug, PartialEq)]
pub enum RaysError {
    /// A row is not a valid ray.
    InvalidRow(InvalidRow),
    /// They do not fit into memory.
    OutOfMemory,
}

impl Rays {
    /// Checks rows of origin and direction.
    ///
    /// # Errors
    /// The first row that is not a valid ray, unless such rows are misses; or too little memory.
    pub fn new(rows: &[[f64; 6]], on_invalid: OnInvalid) -> Result<Rays, RaysError> {
        let mut valid = Vec::new();
        valid.try_reserve_exact(rows.len()).map_err(|_| RaysError::OutOfMemory)?;
        let mut rows_of_valid = None;
        for (row, &numbers) in rows.iter().enumerate() {
            let [ox, oy, oz, dx, dy, dz] = numbers;
            match Ray::new(Vec3::new(ox, oy, oz), Vec3::new(dx, dy, dz)) {
                Ok(ray) => {
                    valid.push(ray);
                    rows_of_valid.iter_mut().for_each(|list: &mut Vec<usize>| list.push(row));
                }
                Err(why) if on_invalid == OnInvalid::Error => {
                    return Err(RaysError::InvalidRow(InvalidRow { row, numbers, why }));
                }
                Err(_) => {
                    rows_of_valid.get_or_insert_with(|| (0..row).collect());
                }
            }
        }
        Ok(Rays { valid, rows: rows.len(), rows_of_valid })
    }

    /// Rays that are all valid.
    pub fn all(valid: Vec<Ray>) -> Rays {
        Rays { rows: valid.len(), valid, rows_of_valid: None }
    }

    /// How many rows are not valid rays.
    pub fn invalid(&self) -> usize {
        self.rows - self.valid.len()
    }

    /// The row of a valid ray.
    pub fn row(&self, valid: usize) -> usize {
        self.rows_of_valid.as_ref().and_then(|rows| rows.get(valid).copied()).unwrap_or(valid)
    }

    /// From a value per valid ray to a value per row.
    pub fn by_row<T: Clone>(&self, values: Vec<T>, miss: T) -> Vec<T> {
        let Some(rows) = &self.rows_of_valid else { return values };
        let mut out = vec![miss; self.rows];
        for (&row, value) in rows.iter().zip(values) {
            out[row] = value;
        }
        out
    }

    /// From `width` numbers per valid ray to `width` numbers per row: zeros for invalid rows.
    pub fn rows_by_row(&self, values: Vec<f64>, width: usize) -> Vec<f64> {
        let Some(rows) = &self.rows_of_valid else { return values };
        let mut out = vec![0.0; self.rows * width];
        for (&row, values) in rows.iter().zip(values.chunks_exact(width.max(1))) {
            out[row * width..][..width].copy_from_slice(values);
        }
        out
    }

    /// From splits between valid rays to splits between rows.
    pub fn splits_by_row(&self, splits: Vec<i64>) -> Vec<i64> {
        let Some(rows) = &self.rows_of_valid else { return splits };
        let mut out = vec![0; self.rows + 1];
        for (&row, pair) in rows.iter().zip(splits.windows(2)) {
            out[row + 1] = pair[1] - pair[0];
        }
        for i in 1..out.len() {
            out[i] += out[i - 1];
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: [f64; 6] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0];
    const ZERO: [f64; 6] = [0.0; 6];

    #[test]
    fn the_first_invalid_row_is_named() {
        let bad = Rays::new(&[GOOD, GOOD, ZERO, ZERO], OnInvalid::Error).unwrap_err();
        assert_eq!(
            bad,
            RaysError::InvalidRow(InvalidRow { row: 2, numbers: ZERO, why: InvalidRay::ZeroDirection })
        );
    }

    #[test]
    fn results_return_to_their_rows() {
        let rays = Rays::new(&[ZERO, GOOD, ZERO, GOOD], OnInvalid::Miss).unwrap();
        assert_eq!((rays.valid.len(), rays.invalid(), rays.row(1)), (2, 2, 3));
        assert_eq!(rays.by_row(vec![5, 6], -1), [-1, 5, -1, 6]);
        assert_eq!(rays.splits_by_row(vec![0, 3, 4]), [0, 0, 3, 3, 4]);
        assert_eq!(rays.rows_by_row(vec![5.0, 6.0, 7.0, 8.0], 2), [0.0, 0.0, 5.0, 6.0, 0.0, 0.0, 7.0, 8.0]);
        assert!(rays.rows_by_row(vec![], 0).is_empty());
        let all = Rays::new(&[GOOD, GOOD], OnInvalid::Miss).unwrap();
        assert_eq!((all.row(1), all.by_row(vec![5, 6], -1)), (1, vec![5, 6]));
    }
}
