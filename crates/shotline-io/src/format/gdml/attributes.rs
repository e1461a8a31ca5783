//! The attributes of elements: names, references, numbers with units.

use shotline::math::Vec3;

use super::units::Measure;
use super::{Element, Module, elements, expression, tag};
use crate::suggest;

/// An error that has been reported already.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reported;

/// The deepest nesting of loops, which are run by recursion.
const MAX_LOOPS: usize = 32;

pub(super) type Found<T> = Result<T, Reported>;

impl Module<'_> {
    /// The text of an attribute, if it is there.
    pub(super) fn given<'a>(&self, element: Element<'a>, key: &str) -> Option<&'a str> {
        element.attribute(self.written(key))
    }

    /// What the files call an attribute at this place.
    fn written<'k>(&self, key: &'k str) -> &'k str {
        self.renamed.iter().find(|(name, _)| *name == key).map_or(key, |(_, written)| written)
    }

    /// The text of an attribute that must be there.
    pub(super) fn text<'a>(&mut self, element: Element<'a>, key: &str) -> Found<&'a str> {
        let key = self.written(key);
        match element.attribute(key) {
            Some(text) => Ok(text),
            None => {
                let message = format!("<{}> lacks the attribute \"{key}\"", tag(element));
                let given: Vec<_> = element.attributes().map(|attribute| attribute.name()).collect();
                let help = match suggest::nearest_name(key, given) {
                    Some(near) => format!("is \"{near}\" meant?"),
                    None => format!("add {key}=\"...\""),
                };
                Err(self.report(element, None, message, help))
            }
        }
    }

    /// The name of an element, with the indices of a loop written out.
    pub(super) fn name(&mut self, element: Element) -> Found<String> {
        let name = self.text(element, "name")?;
        self.written_out(element, "name", name, self.loops > 0)
    }

    /// The name that an element refers to by an attribute.
    pub(super) fn reference(&mut self, element: Element, key: &str) -> Found<String> {
        let name = self.text(element, key)?;
        self.written_out(element, key, name, self.loops > 0)
    }

    /// A name in which `[i]` stands for `_` and the number before i, as Geant4 names what loops make.
    pub(super) fn written_out(
        &mut self,
        element: Element,
        key: &str,
        name: &str,
        loops: bool,
    ) -> Found<String> {
        let (mut out, mut rest) = (String::new(), name.trim());
        while let Some((start, behind)) = rest.split_once('[').filter(|_| loops) {
            let Some((indices, end)) = behind.split_once(']') else {
                let message = "a ']' is missing in this name";
                return Err(self.report(element, Some(key), message, "close the bracket"));
            };
            out.push_str(start.trim());
            for index in indices.split(',') {
                let before = self.evaluate(element, key, index)? - 1.0;
                out.push_str(&format!("_{}", before as i64));
            }
            rest = end;
        }
        out.push_str(rest.trim());
        Ok(out)
    }

    /// The value of an expression in an attribute.
    pub(super) fn evaluate(&mut self, element: Element, key: &str, text: &str) -> Found<f64> {
        // Nearly all are plain numbers.
        if let Ok(number) = text.trim().parse::<f64>()
            && number.is_finite()
        {
            return Ok(number);
        }
        match expression::evaluate(text, &self.definitions) {
            Ok(value) => Ok(value),
            Err(why) => {
                let mut shown: String = text.trim().chars().take(60).collect();
                if shown.len() < text.trim().len() {
                    shown.push_str("...");
                }
                let message = format!("'{shown}' has no value: {why}");
                let help = "an expression has numbers, defined names, units, + - * / ^ and functions";
                Err(self.report(element, Some(key), message, help))
            }
        }
    }

    /// The number of an attribute, or the default.
    pub(super) fn number_or(&mut self, element: Element, key: &str, default: f64) -> Found<f64> {
        match self.given(element, key) {
            Some(text) => self.evaluate(element, key, text),
            None => Ok(default),
        }
    }

    /// The number of an attribute that must be there.
    pub(super) fn number(&mut self, element: Element, key: &str) -> Found<f64> {
        let text = self.text(element, key)?;
        self.evaluate(element, key, text)
    }

    /// The whole number of an attribute, at least 1 and not so large that it could not be meant.
    pub(super) fn count(&mut self, element: Element, key: &str) -> Found<usize> {
        let number = self.number(element, key)?;
        if (1.0..=1e9).contains(&number) && number.fract() == 0.0 {
            return Ok(number as usize);
        }
        let message = format!("\"{key}\" is {number}, but must be a whole number from 1");
        Err(self.report(element, Some(key), message, "correct the number"))
    }

    /// The factor of the unit that an attribute names, to millimetres, degrees or g/cm^3.
    pub(super) fn factor(&mut self, element: Element, key: &str, measure: Measure) -> Found<f64> {
        let Some(unit) = element.attribute(key).map(str::trim).filter(|unit| !unit.is_empty()) else {
            return Ok(measure.default_factor());
        };
        match measure.factor(unit) {
            Some(factor) => Ok(factor),
            None => {
                let message = format!("'{unit}' is no unit of {}", measure.noun());
                let known: Vec<_> = measure.names().collect();
                Err(self.report(element, Some(key), message, suggest::hint(unit, &known)))
            }
        }
    }

    /// A length in millimetres.
    pub(super) fn length(&mut self, element: Element, key: &str) -> Found<f64> {
        Ok(self.number(element, key)? * self.factor(element, "lunit", Measure::Length)?)
    }

    /// A length in millimetres, or 0.
    pub(super) fn length_or_zero(&mut self, element: Element, key: &str) -> Found<f64> {
        Ok(self.number_or(element, key, 0.0)? * self.factor(element, "lunit", Measure::Length)?)
    }

    /// A length in millimetres that must be positive.
    pub(super) fn positive(&mut self, element: Element, key: &str) -> Found<f64> {
        let length = self.length(element, key)?;
        if length > 0.0 {
            return Ok(length);
        }
        let message = format!("\"{key}\" is {length} mm, but must be positive");
        Err(self.report(element, Some(key), message, "correct the length"))
    }

    /// A radius in millimetres that must not be negative, or 0.
    pub(super) fn radius(&mut self, element: Element, key: &str) -> Found<f64> {
        let length = self.length_or_zero(element, key)?;
        if length >= 0.0 {
            return Ok(length);
        }
        let message = format!("\"{key}\" is {length} mm, but must not be negative");
        Err(self.report(element, Some(key), message, "correct the radius"))
    }

    /// An inner and an outer radius in millimetres, the second above the first.
    pub(super) fn radii(&mut self, element: Element, inner: &str, outer: &str) -> Found<[f64; 2]> {
        let radii = [self.radius(element, inner)?, self.positive(element, outer)?];
        if radii[0] < radii[1] {
            return Ok(radii);
        }
        let message =
            format!("\"{outer}\" is {} mm, but must be above \"{inner}\", {} mm", radii[1], radii[0]);
        Err(self.report(element, Some(outer), message, "exchange or correct the radii"))
    }

    /// An angle in degrees, or the default.
    pub(super) fn angle_or(&mut self, element: Element, key: &str, default: f64) -> Found<f64> {
        match self.given(element, key) {
            Some(text) => {
                let value = self.evaluate(element, key, text)?;
                Ok(value * self.factor(element, "aunit", Measure::Angle)?)
            }
            None => Ok(default),
        }
    }

    /// An angle in degrees that must be there.
    pub(super) fn angle(&mut self, element: Element, key: &str) -> Found<f64> {
        self.text(element, key)?;
        self.angle_or(element, key, 0.0)
    }

    /// Where a sector begins and how much of a turn it takes, in degrees. Geant4 takes up to 1e-9 less than a full turn for one.
    pub(super) fn sector(&mut self, element: Element, start: &str, extent: &str) -> Found<[f64; 2]> {
        let [phi0, dphi] = [self.angle_or(element, start, 0.0)?, self.angle(element, extent)?];
        if dphi >= 360.0 - 3e-8 {
            return Ok([0.0, 360.0]);
        }
        if dphi > 0.0 {
            return Ok([phi0, dphi]);
        }
        let message = format!("\"{extent}\" is {dphi} degrees, but must be positive");
        Err(self.report(element, Some(extent), message, "correct the angle"))
    }

    /// The vector of the attributes x, y and z in a unit; an absent one is `missing`.
    pub(super) fn vector(&mut self, element: Element, measure: Option<Measure>, missing: f64) -> Found<Vec3> {
        let mut v = [missing; 3];
        for (x, key) in v.iter_mut().zip(["x", "y", "z"]) {
            *x = self.number_or(element, key, missing)?;
        }
        let factor = match measure {
            Some(measure) => self.factor(element, "unit", measure)?,
            None => 1.0,
        };
        Ok(Vec3::from(v) * factor)
    }

    /// Runs a body for each value of the variable of a loop.
    pub(super) fn repeat(&mut self, element: Element, body: &mut dyn FnMut(&mut Self, Element)) -> Found<()> {
        let variable = self.text(element, "for")?;
        if !self.definitions.is_variable(variable) {
            let message = format!("'{variable}' is not a defined variable");
            let help = format!("add <variable name=\"{variable}\" value=\"0\"/> to <define>");
            return Err(self.report(element, Some("for"), message, help));
        }
        let first = match element.attribute("from") {
            Some(_) => self.number(element, "from")?,
            None => self.definitions.values[variable],
        };
        let (last, step) = (self.number(element, "to")?, self.number_or(element, "step", 1.0)?);
        if step <= 0.0 && first <= last {
            let message = format!("the loop from {first} to {last} in steps of {step} has no end");
            return Err(self.report(element, Some("step"), message, "the step must be positive"));
        }
        if self.loops >= MAX_LOOPS {
            let message = format!("the loops are nested more than {MAX_LOOPS} deep");
            return Err(self.report(element, None, message, "write out the outer ones"));
        }
        // What is known to be too much is refused before it is begun.
        if (last - first) / step > self.reader.copies as f64 {
            self.count_copies(element, usize::MAX)?;
        }
        let mut value = first;
        self.loops += 1;
        while value <= last {
            if let Err(reported) = self.count_copies(element, 1) {
                self.loops -= 1;
                return Err(reported);
            }
            self.definitions.values.insert(variable.to_owned(), value);
            elements(element).for_each(|child| body(self, child));
            value += step;
        }
        self.loops -= 1;
        Ok(())
    }
}
