//! The declaration of a kind of solid: its name, its parameters and how to build it. Scene files, constructors,
//! documentation and the conformance suite all read it from here.

use std::sync::Arc;

use super::{Parts, Solid};
use crate::math::Vec3;

/// A kind of solid.
#[derive(Debug)]
pub struct Kind {
    /// The name in scene files.
    pub name: &'static str,
    /// One line of documentation.
    pub summary: &'static str,
    /// The points of the interior in terms of the parameters, for the table of kinds in the documentation.
    pub interior: &'static str,
    /// The parameters. Parameters with a default come last.
    pub params: &'static [Param],
    /// Checks the parameters and builds the solid.
    pub build: Build,
    /// Parameter sets for the conformance suite, typical and extreme ones, in the order of `params`.
    pub examples: &'static [&'static [&'static [f64]]],
}

/// How a kind is built.
#[derive(Clone, Copy, Debug)]
pub enum Build {
    /// As one solid.
    Solid(fn(&Params) -> Result<Arc<dyn Solid>, ParamError>),
    /// As a combination of solids.
    Parts(fn(&Params) -> Result<Parts, ParamError>),
}

impl Kind {
    /// Checks the parameters and builds the solid, or the solids that it is a combination of.
    ///
    /// # Errors
    /// [`ParamError`] names the wrong parameter.
    pub fn build(&self, params: &Params) -> Result<Parts, ParamError> {
        self.params.iter().try_for_each(|param| params.check_rows(param))?;
        match self.build {
            Build::Solid(build) => build(params).map(|solid| {
                let surfaces = solid.surfaces();
                Parts::Solid(solid, surfaces)
            }),
            Build::Parts(build) => build(params),
        }
    }

    /// How the numbers of a parameter are arranged; `None` if there is no such parameter.
    pub fn layout(&self, name: &str) -> Option<Layout> {
        self.params.iter().find(|param| param.name == name).map(|param| param.layout)
    }
}

/// A parameter of a kind.
#[derive(Debug)]
pub struct Param {
    /// The key in scene files.
    pub name: &'static str,
    /// What the numbers measure.
    pub quantity: Quantity,
    /// How many numbers it has, and how they are arranged.
    pub layout: Layout,
    /// The default value. `None` if the parameter is required.
    pub default: Option<&'static [f64]>,
    /// One line of documentation.
    pub summary: &'static str,
}

/// How the numbers of a parameter are arranged in scene files and in Python. [`Params`] holds them without structure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layout {
    /// This many numbers.
    Numbers(usize),
    /// Any number of rows of the same numbers.
    Rows {
        /// The names of the numbers of a row.
        columns: &'static [&'static str],
        /// The least number of rows.
        least: usize,
    },
}

/// What the numbers of a parameter measure, which determines how they scale with the size of the solid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// A length in the unit of the scene.
    Length,
    /// An angle in degrees.
    Angle,
    /// A vector whose length does not matter.
    Direction,
    /// Coefficients of a polynomial in the coordinates, or the columns of rows. Each scales with this power of the size.
    Coefficients(&'static [i32]),
}

impl Param {
    /// A length.
    pub const fn length(name: &'static str, summary: &'static str) -> Param {
        Param::new(name, Quantity::Length, 1, summary)
    }

    /// A point, or three lengths along the axes.
    pub const fn lengths(name: &'static str, summary: &'static str) -> Param {
        Param::new(name, Quantity::Length, 3, summary)
    }

    /// An angle in degrees.
    pub const fn angle(name: &'static str, summary: &'static str) -> Param {
        Param::new(name, Quantity::Angle, 1, summary)
    }

    /// A direction.
    pub const fn direction(name: &'static str, summary: &'static str) -> Param {
        Param::new(name, Quantity::Direction, 3, summary)
    }

    /// Coefficients of a polynomial, with the power of the size with which each scales.
    pub const fn coefficients(name: &'static str, powers: &'static [i32], summary: &'static str) -> Param {
        Param::new(name, Quantity::Coefficients(powers), powers.len(), summary)
    }

    /// A whole number, such as a number of sides.
    pub const fn count(name: &'static str, summary: &'static str) -> Param {
        Param::new(name, Quantity::Coefficients(&[0]), 1, summary)
    }

    /// At least so many rows of lengths.
    pub const fn rows(
        name: &'static str,
        columns: &'static [&'static str],
        least: usize,
        summary: &'static str,
    ) -> Param {
        let layout = Layout::Rows { columns, least };
        Param { name, quantity: Quantity::Length, layout, default: None, summary }
    }

    /// The same rows, with the power of the size with which each column scales.
    pub const fn scaling(self, powers: &'static [i32]) -> Param {
        Param { quantity: Quantity::Coefficients(powers), ..self }
    }

    const fn new(name: &'static str, quantity: Quantity, count: usize, summary: &'static str) -> Param {
        Param { name, quantity, layout: Layout::Numbers(count), default: None, summary }
    }

    /// The power of the solid's size with which the number at an index scales.
    pub fn power_of_length(&self, index: usize) -> i32 {
        match (self.quantity, self.layout) {
            (Quantity::Length, _) => 1,
            (Quantity::Angle | Quantity::Direction, _) => 0,
            (Quantity::Coefficients(powers), Layout::Numbers(_)) => powers[index],
            (Quantity::Coefficients(powers), Layout::Rows { .. }) => powers[index % powers.len()],
        }
    }

    /// The same parameter with a default value.
    pub const fn or(self, default: &'static [f64]) -> Param {
        Param { default: Some(default), ..self }
    }
}

/// The parameters of one solid, in the order of its kind's declaration.
#[derive(Clone, Debug, PartialEq)]
pub struct Params {
    /// Name and numbers.
    pub entries: Vec<(&'static str, Arc<[f64]>)>,
}

/// A parameter with an invalid value.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{param}: {why}")]
pub struct ParamError {
    /// The name of the parameter.
    pub param: &'static str,
    /// What is wrong, the value, and what is expected.
    pub why: String,
}

/// Parameters of which a kind makes no solid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{kind}: {} {}", error.param, error.why)]
pub struct InvalidSolid {
    /// The name of the kind.
    pub kind: &'static str,
    /// The parameter, its value, and what is expected.
    pub error: ParamError,
}

impl Params {
    /// Pairs values with the parameters of a kind, in their order. Omitted values get their defaults.
    pub fn of(kind: &Kind, values: &[&[f64]]) -> Params {
        let given = values.iter().copied().map(Some).chain(std::iter::repeat(None));
        let pair = |(param, value): (&Param, Option<&[f64]>)| {
            value.or(param.default).map(|numbers| (param.name, Arc::from(numbers)))
        };
        Params { entries: kind.params.iter().zip(given).filter_map(pair).collect() }
    }

    /// Checks that the numbers of a parameter make whole rows, and enough of them.
    fn check_rows(&self, param: &Param) -> Result<(), ParamError> {
        let Layout::Rows { columns, least } = param.layout else { return Ok(()) };
        let Some((_, numbers)) = self.entries.iter().find(|(n, _)| *n == param.name) else { return Ok(()) };
        let row = columns.join(", ");
        let why = match (numbers.len() % columns.len(), numbers.len() / columns.len()) {
            (0, rows) if rows >= least => return Ok(()),
            (0, rows) => format!("has {rows} rows, but takes at least {least} rows [{row}]"),
            _ => format!("has {} numbers, but takes rows of {} [{row}]", numbers.len(), columns.len()),
        };
        Err(ParamError { param: param.name, why })
    }

    /// Returns rows of finite numbers.
    ///
    /// # Errors
    /// [`ParamError`] if they are missing or not finite. It names the row.
    pub fn rows<const N: usize>(&self, name: &'static str) -> Result<Rows<N>, ParamError> {
        let numbers = self.entries.iter().find(|(n, _)| *n == name).map(|(_, numbers)| numbers.as_chunks().0);
        let missing = || ParamError { param: name, why: "is missing".into() };
        let rows = Rows { name, rows: numbers.ok_or_else(missing)?.to_vec() };
        match rows.rows.iter().position(|row| row.iter().any(|x| !x.is_finite())) {
            Some(row) => Err(rows.error(row, "but its numbers must be finite")),
            None => Ok(rows),
        }
    }

    fn get(&self, name: &'static str, count: usize) -> Result<&[f64], ParamError> {
        let error = |why: String| ParamError { param: name, why };
        let (_, numbers) =
            self.entries.iter().find(|(n, _)| *n == name).ok_or_else(|| error("is missing".into()))?;
        if numbers.len() != count {
            return Err(error(format!("takes {count} numbers, not {}", numbers.len())));
        }
        match numbers.iter().find(|x| !x.is_finite()) {
            Some(x) => Err(error(format!("is {x}, but must be finite"))),
            None => Ok(numbers),
        }
    }

    /// Returns a finite number.
    ///
    /// # Errors
    /// [`ParamError`] if it is missing or not finite.
    pub fn number(&self, name: &'static str) -> Result<f64, ParamError> {
        self.get(name, 1).map(|n| n[0])
    }

    /// Returns a finite number above zero.
    ///
    /// # Errors
    /// [`ParamError`] if it is missing, not finite or not positive.
    pub fn positive(&self, name: &'static str) -> Result<f64, ParamError> {
        let x = self.number(name)?;
        if x > 0.0 {
            Ok(x)
        } else {
            Err(ParamError { param: name, why: format!("is {x}, but must be positive") })
        }
    }

    /// Returns a finite number of at least zero.
    ///
    /// # Errors
    /// [`ParamError`] if it is missing, not finite or negative.
    pub fn not_negative(&self, name: &'static str) -> Result<f64, ParamError> {
        let x = self.number(name)?;
        if x >= 0.0 {
            Ok(x)
        } else {
            Err(ParamError { param: name, why: format!("is {x}, but must not be negative") })
        }
    }

    /// Returns a finite number that is not less than another parameter, which is named for the error.
    ///
    /// # Errors
    /// [`ParamError`] if it is missing, not finite or less.
    pub fn at_least(&self, name: &'static str, least: f64, of: &'static str) -> Result<f64, ParamError> {
        let x = self.number(name)?;
        if x >= least {
            Ok(x)
        } else {
            Err(ParamError { param: name, why: format!("is {x}, but must be at least {of} = {least}") })
        }
    }

    /// Returns three finite numbers.
    ///
    /// # Errors
    /// [`ParamError`] if it is missing or not finite.
    pub fn vector(&self, name: &'static str) -> Result<Vec3, ParamError> {
        self.get(name, 3).map(|n| Vec3::new(n[0], n[1], n[2]))
    }

    /// Returns ten finite numbers.
    ///
    /// # Errors
    /// [`ParamError`] if it is missing or not finite.
    pub fn coefficients(&self, name: &'static str) -> Result<[f64; 10], ParamError> {
        self.get(name, 10).map(|n| std::array::from_fn(|i| n[i]))
    }

    /// Returns two numbers, the second greater than the first.
    ///
    /// # Errors
    /// [`ParamError`] if they are missing, not finite or not ascending. It names the second.
    pub fn ascending(&self, low: &'static str, high: &'static str) -> Result<(f64, f64), ParamError> {
        let (a, b) = (self.number(low)?, self.number(high)?);
        if a < b {
            Ok((a, b))
        } else {
            Err(ParamError { param: high, why: format!("is {b}, but must be greater than {low} = {a}") })
        }
    }
}

/// The rows of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Rows<const N: usize> {
    /// The name of the parameter.
    pub name: &'static str,
    /// The numbers.
    pub rows: Vec<[f64; N]>,
}

impl<const N: usize> Rows<N> {
    /// The error that a row, counted from 0, has a wrong value: `why` says what is expected. Messages count rows from 1.
    pub fn error(&self, row: usize, why: &str) -> ParamError {
        let why = format!("row {} of {} is {:?}, {why}", row + 1, self.rows.len(), self.rows[row]);
        ParamError { param: self.name, why }
    }
}
