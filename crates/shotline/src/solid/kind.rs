//! What a kind of solid declares once: its name, its parameters, how it is built. Scene files, constructors,
//! documentation and the conformance suite all read it here.

use std::sync::Arc;

use super::Solid;
use crate::math::Vec3;

/// A kind of solid.
#[derive(Debug)]
pub struct Kind {
    /// The name in scene files.
    pub name: &'static str,
    /// One line of documentation.
    pub summary: &'static str,
    /// The parameters; all of them are required.
    pub params: &'static [Param],
    /// Checks the parameters and builds the solid.
    pub build: fn(&Params) -> Result<Arc<dyn Solid>, ParamError>,
    /// Parameter sets that the conformance suite tries, in the order of `params`: typical and extreme ones.
    pub examples: &'static [&'static [Value]],
}

/// A parameter of a kind.
#[derive(Debug)]
pub struct Param {
    /// The key in scene files.
    pub name: &'static str,
    /// What it takes.
    pub ty: ParamType,
    /// One line of documentation.
    pub summary: &'static str,
}

/// What a parameter takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParamType {
    /// A number.
    Number,
    /// So many numbers.
    Numbers(usize),
}

/// The value of a parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// A number.
    Number(f64),
    /// Three numbers.
    Vector([f64; 3]),
    /// Ten numbers, the coefficients of a quadric.
    Ten([f64; 10]),
}

impl Value {
    /// The numbers.
    pub fn numbers(&self) -> &[f64] {
        match self {
            Value::Number(x) => std::slice::from_ref(x),
            Value::Vector(v) => v,
            Value::Ten(v) => v,
        }
    }

    /// From one, three or ten numbers.
    pub fn from_numbers(numbers: &[f64]) -> Option<Value> {
        match numbers {
            [x] => Some(Value::Number(*x)),
            [x, y, z] => Some(Value::Vector([*x, *y, *z])),
            _ => numbers.try_into().ok().map(Value::Ten),
        }
    }
}

/// The parameters of one solid, in the order of its kind's declaration.
#[derive(Clone, Debug, PartialEq)]
pub struct Params {
    /// Name and value.
    pub entries: Vec<(&'static str, Value)>,
}

/// A parameter that does not make a solid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{param}: {why}")]
pub struct ParamError {
    /// The parameter.
    pub param: &'static str,
    /// What is wrong, with the value, and what is expected.
    pub why: String,
}

impl Params {
    /// Pairs the values of an example with the declared names.
    pub fn of(kind: &Kind, values: &[Value]) -> Params {
        Params { entries: kind.params.iter().map(|p| p.name).zip(values.iter().copied()).collect() }
    }

    fn get(&self, name: &'static str, count: usize) -> Result<&[f64], ParamError> {
        let error = |why: String| ParamError { param: name, why };
        let (_, value) =
            self.entries.iter().find(|(n, _)| *n == name).ok_or_else(|| error("is missing".into()))?;
        let numbers = value.numbers();
        if numbers.len() != count {
            return Err(error(format!("takes {count} numbers, not {}", numbers.len())));
        }
        match numbers.iter().find(|x| !x.is_finite()) {
            Some(x) => Err(error(format!("is {x}, but must be finite"))),
            None => Ok(numbers),
        }
    }

    /// A finite number.
    ///
    /// # Errors
    /// [`ParamError`] if it is missing or not finite.
    pub fn number(&self, name: &'static str) -> Result<f64, ParamError> {
        self.get(name, 1).map(|n| n[0])
    }

    /// A finite number above zero.
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

    /// Three finite numbers.
    ///
    /// # Errors
    /// [`ParamError`] if it is missing or not finite.
    pub fn vector(&self, name: &'static str) -> Result<Vec3, ParamError> {
        self.get(name, 3).map(|n| Vec3::new(n[0], n[1], n[2]))
    }

    /// Ten finite numbers.
    ///
    /// # Errors
    /// [`ParamError`] if it is missing or not finite.
    pub fn ten(&self, name: &'static str) -> Result<[f64; 10], ParamError> {
        self.get(name, 10).map(|n| std::array::from_fn(|i| n[i]))
    }

    /// Two numbers of which the second must be greater.
    ///
    /// # Errors
    /// [`ParamError`], naming the second, if they are missing, not finite or not ascending.
    pub fn ascending(&self, low: &'static str, high: &'static str) -> Result<(f64, f64), ParamError> {
        let (a, b) = (self.number(low)?, self.number(high)?);
        if a < b {
            Ok((a, b))
        } else {
            Err(ParamError { param: high, why: format!("is {b}, but must be greater than {low} = {a}") })
        }
    }
}
