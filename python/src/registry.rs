//! The registries of the core, from which the Python half makes its classes.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use shotline::accel;
use shotline::math::{Affine, ComposedTransform};
use shotline::scene::Units;
use shotline::solid::{self, KINDS, Layout, Param, ParamError, Params};

/// A parameter: name, count of numbers, names of these if there are any number of rows of them, default, summary.
type Parameter = (&'static str, usize, Option<&'static [&'static str]>, Option<Vec<f64>>, &'static str);

/// The kinds of solids: name, summary, parameters.
#[pyfunction]
pub fn kinds() -> Vec<(&'static str, &'static str, Vec<Parameter>)> {
    let parameter = |p: &Param| {
        let (count, columns) = match p.layout {
            Layout::Numbers(count) => (count, None),
            Layout::Rows { columns, .. } => (columns.len(), Some(columns)),
        };
        (p.name, count, columns, p.default.map(<[f64]>::to_vec), p.summary)
    };
    KINDS.iter().map(|kind| (kind.name, kind.summary, kind.params.iter().map(parameter).collect())).collect()
}

/// Checks the parameters of a solid, given in the order of its kind; rows one after the other.
#[pyfunction]
pub fn check_solid(kind: &str, values: Vec<Vec<f64>>) -> PyResult<()> {
    let kind =
        solid::kind(kind).ok_or_else(|| PyValueError::new_err(format!("there is no solid '{kind}'")))?;
    let values: Vec<&[f64]> = values.iter().map(Vec::as_slice).collect();
    match kind.build(&Params::of(kind, &values)) {
        Ok(_) => Ok(()),
        Err(ParamError { param, why }) => Err(PyValueError::new_err(format!("{param} {why}"))),
    }
}

/// The names of the accelerators, and the default.
#[pyfunction]
pub fn accelerators() -> (Vec<&'static str>, &'static str) {
    (accel::NAMES.to_vec(), accel::DEFAULT)
}

/// The units of length of scenes, and the name for no unit.
#[pyfunction]
pub fn units() -> Vec<&'static str> {
    Units::ALL.iter().map(|(name, _)| *name).chain([Units::NONE]).collect()
}

/// The counters: names and summaries.
#[pyfunction]
pub fn counters() -> Vec<(&'static str, &'static str)> {
    shotline::counters::COUNTERS.iter().map(|counter| (counter.name, counter.summary)).collect()
}

/// The argument of a transform step: a rotation about an axis, or numbers.
#[derive(FromPyObject)]
pub enum Amount {
    About {
        #[pyo3(item)]
        axis: [f64; 3],
        #[pyo3(item)]
        degrees: f64,
    },
    Numbers(Vec<f64>),
}

/// The matrix of transform steps, the innermost first: computed in double-double and rounded once; 12 numbers.
#[pyfunction]
pub fn compose(steps: Vec<(String, Amount)>) -> PyResult<[f64; 12]> {
    let bad = |name: &str| PyValueError::new_err(format!("{name} takes other numbers"));
    let mut chain = ComposedTransform::IDENTITY;
    for (name, amount) in steps.iter().rev() {
        let matrix = match (name.as_str(), amount) {
            (_, Amount::About { axis, degrees }) => Affine::rotation_about((*axis).into(), *degrees),
            ("transform", Amount::Numbers(n)) => {
                Affine::from_row_major(n.as_slice().try_into().map_err(|_| bad(name))?)
            }
            (_, Amount::Numbers(n)) => {
                let v = <[f64; 3]>::try_from(n.as_slice()).map_err(|_| bad(name))?.into();
                match name.as_str() {
                    "translate" => Affine::translation(v),
                    "rotate" => Affine::rotation_xyz(v),
                    "scale" => Affine::scaling(v),
                    _ => return Err(bad(name)),
                }
            }
        };
        chain = chain.then(&matrix);
    }
    let placement = chain.placement().map_err(|e| PyValueError::new_err(e.to_string()))?;
    let rows = placement.parent_from_local.rows;
    Ok(std::array::from_fn(|i| rows[i / 4][i % 4]))
}
