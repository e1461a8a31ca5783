//! The section `define`: constants, variables, quantities, expressions, matrices, positions, rotations and scales.

use std::collections::{HashMap, HashSet};

use shotline::math::Vec3;

use super::attributes::Found;
use super::expression::Names;
use super::units::{Measure, of_quantity};
use super::{Element, Module, elements, tag};
use crate::suggest;

/// What a file defines.
#[derive(Default)]
pub(super) struct Definitions {
    /// Constants, variables and quantities.
    pub(super) values: HashMap<String, f64>,
    variables: HashSet<String>,
    /// Matrices, with their numbers of columns.
    matrices: HashMap<String, (usize, Vec<f64>)>,
    /// Positions in millimetres.
    positions: HashMap<String, Vec3>,
    /// Rotations in degrees about x, y and z.
    rotations: HashMap<String, Vec3>,
    scales: HashMap<String, Vec3>,
}

impl Definitions {
    pub(super) fn is_variable(&self, name: &str) -> bool {
        self.variables.contains(name)
    }
}

impl Definitions {
    /// The element of a matrix by the name that Geant4 gives it: that of the matrix and the indices from 0, as in `m_0_1`.
    fn element_by_name(&self, name: &str) -> Option<f64> {
        let (rest, last) = name.rsplit_once('_')?;
        let index = |digits: &str| digits.parse::<usize>().ok()?.checked_add(1);
        let last = index(last)?;
        if self.matrices.contains_key(rest) {
            return self.element(rest, &[last]).ok();
        }
        let (matrix, first) = rest.rsplit_once('_')?;
        self.element(matrix, &[index(first)?, last]).ok()
    }
}

impl Names for Definitions {
    fn value(&self, name: &str) -> Option<f64> {
        self.values.get(name).copied().or_else(|| self.element_by_name(name))
    }

    fn element(&self, matrix: &str, indices: &[usize]) -> Result<f64, String> {
        let Some((columns, numbers)) = self.matrices.get(matrix) else {
            return Err(format!("there is no matrix '{matrix}'"));
        };
        let rows = numbers.len() / columns;
        // A matrix of one row or one column takes one index.
        let (row, column) = match *indices {
            [i] if rows == 1 => (1, i),
            [i] if *columns == 1 => (i, 1),
            [i, j] => (i, j),
            _ => return Err(format!("the matrix '{matrix}' of {rows} x {columns} takes two indices")),
        };
        if row > rows || column > *columns {
            let given = indices.iter().map(usize::to_string).collect::<Vec<_>>().join(",");
            return Err(format!("the matrix '{matrix}' is {rows} x {columns}, and has no element [{given}]"));
        }
        Ok(numbers[(row - 1) * columns + column - 1])
    }
}

/// What a definition holds that is placed or scaled by it.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Vector {
    Position,
    Rotation,
    Scale,
}

impl Vector {
    fn measure(self) -> Option<Measure> {
        match self {
            Vector::Position => Some(Measure::Length),
            Vector::Rotation => Some(Measure::Angle),
            Vector::Scale => None,
        }
    }

    fn missing(self) -> f64 {
        if self == Vector::Scale { 1.0 } else { 0.0 }
    }

    fn noun(self) -> &'static str {
        match self {
            Vector::Position => "position",
            Vector::Rotation => "rotation",
            Vector::Scale => "scale",
        }
    }
}

impl Module<'_> {
    /// Reads the definitions; one that is wrong is reported, and the others are read.
    pub(super) fn define(&mut self, section: Element) {
        for element in elements(section) {
            // What is wrong has been reported.
            let _ = self.definition(element);
        }
    }

    fn definition(&mut self, element: Element) -> Found<()> {
        let vector = match tag(element) {
            "constant" | "variable" | "quantity" | "expression" => return self.value(element),
            "matrix" => return self.matrix(element),
            "position" => Vector::Position,
            "rotation" => Vector::Rotation,
            "scale" => Vector::Scale,
            "loop" => {
                return self.repeat(element, &mut |module, child| {
                    let _ = module.definition(child);
                });
            }
            other => {
                let message = format!("<{other}> is no definition");
                let known = [
                    "constant",
                    "variable",
                    "quantity",
                    "expression",
                    "matrix",
                    "position",
                    "rotation",
                    "scale",
                ];
                return Err(self.report(element, None, message, suggest::hint(other, &known)));
            }
        };
        let name = self.name(element)?;
        let value = self.vector(element, vector.measure(), vector.missing())?;
        self.vectors(vector).insert(name, value);
        Ok(())
    }

    fn vectors(&mut self, vector: Vector) -> &mut HashMap<String, Vec3> {
        match vector {
            Vector::Position => &mut self.definitions.positions,
            Vector::Rotation => &mut self.definitions.rotations,
            Vector::Scale => &mut self.definitions.scales,
        }
    }

    fn value(&mut self, element: Element) -> Found<()> {
        let name = self.text(element, "name")?.trim().to_owned();
        let value = match tag(element) {
            "expression" => {
                let texts = element.children().filter(|child| child.is_text());
                let text: String = texts.filter_map(|child| child.text()).collect();
                self.evaluate(element, "", &text)?
            }
            "quantity" => {
                let factor = element.attribute("unit").map_or(1.0, |unit| of_quantity(unit.trim()));
                self.number(element, "value")? * factor
            }
            _ => self.number(element, "value")?,
        };
        if tag(element) == "variable" {
            self.definitions.variables.insert(name.clone());
        }
        self.definitions.values.insert(name, value);
        Ok(())
    }

    fn matrix(&mut self, element: Element) -> Found<()> {
        let name = self.name(element)?;
        let columns = self.count(element, "coldim")?;
        let mut numbers = Vec::new();
        for word in self.text(element, "values")?.split_whitespace() {
            numbers.push(self.evaluate(element, "values", word)?);
        }
        if numbers.is_empty() || !numbers.len().is_multiple_of(columns) {
            let message = format!("{} values do not fill rows of {columns}", numbers.len());
            return Err(self.report(element, Some("values"), message, "correct \"coldim\" or the values"));
        }
        self.definitions.matrices.insert(name, (columns, numbers));
        Ok(())
    }

    /// The vector that an element gives itself or refers to.
    pub(super) fn vector_of(&mut self, element: Element, vector: Vector) -> Found<Vec3> {
        if !tag(element).ends_with("ref") {
            return self.vector(element, vector.measure(), vector.missing());
        }
        let name = self.reference(element, "ref")?;
        self.defined_vector(element, "ref", vector, &name)
    }

    /// A vector by its name in an attribute.
    pub(super) fn defined_vector(
        &mut self,
        element: Element,
        key: &str,
        vector: Vector,
        name: &str,
    ) -> Found<Vec3> {
        let known = self.vectors(vector);
        if let Some(value) = known.get(name) {
            return Ok(*value);
        }
        let help = suggest::hint(name, &known.keys().map(String::as_str).collect::<Vec<_>>());
        let message = format!("there is no {} '{name}'", vector.noun());
        Err(self.report(element, Some(key), message, help))
    }
}
