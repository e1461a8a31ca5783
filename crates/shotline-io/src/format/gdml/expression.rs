//! Expressions in attribute values, with the operators, functions and precedences of CLHEP's evaluator, which Geant4 uses:
//! powers bind tighter than signs, and signs tighter than products.

use std::f64::consts;

/// What an expression may name.
pub(super) trait Names {
    /// The value of a constant or variable.
    fn value(&self, name: &str) -> Option<f64>;

    /// The element of a matrix at indices from 1.
    fn element(&self, matrix: &str, indices: &[usize]) -> Result<f64, String>;
}

/// The deepest nesting of parentheses, signs and powers: an expression is evaluated by recursion.
const MAX_DEPTH: usize = 200;

/// The value of an expression; an empty one is 0.
///
/// # Errors
/// What is wrong, in terms of the expression.
pub(super) fn evaluate(text: &str, names: &dyn Names) -> Result<f64, String> {
    let mut parser = Parser { text, at: 0, depth: 0, names };
    if parser.peek().is_none() {
        return Ok(0.0);
    }
    let value = parser.binary(0)?;
    match parser.peek() {
        None if value.is_finite() => Ok(value),
        None => Err(format!("the value is {value}")),
        Some(c) => Err(format!("there is an unexpected '{c}'")),
    }
}

/// The symbol of a binary operator, and what it does.
type Operator = (&'static str, fn(f64, f64) -> f64);

/// The binary operators, from those that bind loosest to those that bind tightest; an operator stands before those that it
/// begins with.
const OPERATORS: [&[Operator]; 6] = [
    &[("||", |a, b| truth(a != 0.0 || b != 0.0))],
    &[("&&", |a, b| truth(a != 0.0 && b != 0.0))],
    &[("==", |a, b| truth(a == b)), ("!=", |a, b| truth(a != b))],
    &[
        (">=", |a, b| truth(a >= b)),
        ("<=", |a, b| truth(a <= b)),
        (">", |a, b| truth(a > b)),
        ("<", |a, b| truth(a < b)),
    ],
    &[("+", |a, b| a + b), ("-", |a, b| a - b)],
    &[("*", |a, b| a * b), ("/", |a, b| a / b)],
];

fn truth(holds: bool) -> f64 {
    f64::from(u8::from(holds))
}

struct Parser<'t, 'n> {
    text: &'t str,
    at: usize,
    depth: usize,
    names: &'n dyn Names,
}

impl Parser<'_, '_> {
    /// The next character that is no space; `None` at the end.
    fn peek(&mut self) -> Option<char> {
        let rest = &self.text[self.at..];
        let spaces = rest.len() - rest.trim_start().len();
        self.at += spaces;
        self.text[self.at..].chars().next()
    }

    /// Goes past a symbol if it comes next.
    fn accept(&mut self, symbol: &str) -> bool {
        self.peek();
        let found = self.text[self.at..].starts_with(symbol);
        self.at += if found { symbol.len() } else { 0 };
        found
    }

    fn expect(&mut self, symbol: char) -> Result<(), String> {
        match self.peek() {
            Some(found) if found == symbol => {
                self.at += symbol.len_utf8();
                Ok(())
            }
            Some(found) => Err(format!("there is a '{found}' where a '{symbol}' is expected")),
            None => Err(format!("a '{symbol}' is missing at the end")),
        }
    }

    fn deeper<T>(&mut self, parse: impl FnOnce(&mut Self) -> Result<T, String>) -> Result<T, String> {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return Err(format!("it is nested more than {MAX_DEPTH} deep"));
        }
        let parsed = parse(self);
        self.depth -= 1;
        parsed
    }

    /// Operands joined by the operators of a level or of tighter ones.
    fn binary(&mut self, level: usize) -> Result<f64, String> {
        let Some(operators) = OPERATORS.get(level) else { return self.signed() };
        let mut value = self.binary(level + 1)?;
        loop {
            // A power is no product.
            if self.peek().is_none() || self.text[self.at..].starts_with("**") {
                return Ok(value);
            }
            let Some((symbol, apply)) = operators.iter().find(|(symbol, _)| self.accept(symbol)) else {
                return Ok(value);
            };
            let right = self.binary(level + 1)?;
            if *symbol == "/" && right == 0.0 {
                return Err("it divides by zero".into());
            }
            value = apply(value, right);
        }
    }

    fn signed(&mut self) -> Result<f64, String> {
        if self.accept("-") {
            return self.deeper(Self::signed).map(|x| -x);
        }
        if self.accept("+") {
            return self.deeper(Self::signed);
        }
        self.power()
    }

    /// Powers, which are evaluated from the left, as CLHEP does.
    fn power(&mut self) -> Result<f64, String> {
        let mut base = self.operand()?;
        while self.accept("**") || self.accept("^") {
            let exponent = match self.peek() {
                Some('-' | '+') => self.deeper(Self::sign_of_exponent)?,
                _ => self.operand()?,
            };
            base = libm::pow(base, exponent);
        }
        Ok(base)
    }

    fn sign_of_exponent(&mut self) -> Result<f64, String> {
        let negative = self.accept("-");
        if !negative {
            self.accept("+");
        }
        let value = match self.peek() {
            Some('-' | '+') => self.deeper(Self::sign_of_exponent)?,
            _ => self.operand()?,
        };
        Ok(if negative { -value } else { value })
    }

    fn operand(&mut self) -> Result<f64, String> {
        match self.peek() {
            None => Err("a number is missing at the end".into()),
            Some('(') => {
                self.at += 1;
                let value = self.deeper(|parser| parser.binary(0))?;
                self.expect(')')?;
                Ok(value)
            }
            Some(c) if c.is_ascii_digit() || c == '.' => self.number(),
            Some(c) if c.is_alphabetic() || c == '_' => self.name(),
            Some(c) => Err(format!("there is a '{c}' where a number is expected")),
        }
    }

    fn number(&mut self) -> Result<f64, String> {
        let rest = &self.text.as_bytes()[self.at..];
        let digits = |from: usize| rest[from..].iter().take_while(|b| b.is_ascii_digit()).count();
        let mut length = digits(0);
        if rest.get(length) == Some(&b'.') {
            length += 1 + digits(length + 1);
        }
        if matches!(rest.get(length), Some(b'e' | b'E')) {
            let sign = usize::from(matches!(rest.get(length + 1), Some(b'+' | b'-')));
            let exponent = digits(length + 1 + sign);
            length += if exponent > 0 { 1 + sign + exponent } else { 0 };
        }
        let written = &self.text[self.at..self.at + length];
        self.at += length;
        written.parse().map_err(|_| format!("'{written}' is not a number"))
    }

    /// A constant, a variable, a function, or an element of a matrix.
    fn name(&mut self) -> Result<f64, String> {
        let rest = &self.text[self.at..];
        let length = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
        let name = &rest[..length];
        self.at += length;
        match self.peek() {
            Some('(') => {
                let arguments = self.list('(', ')')?;
                call(name, &arguments)
            }
            Some('[') => {
                let indices = self.list('[', ']')?;
                let indices: Option<Vec<_>> = indices.into_iter().map(index).collect();
                let why = || format!("an index of the matrix '{name}' is not a whole number from 1");
                self.names.element(name, &indices.ok_or_else(why)?)
            }
            _ => match self.names.value(name).or_else(|| constant(name)) {
                Some(value) => Ok(value),
                None => Err(format!("'{name}' is not defined")),
            },
        }
    }

    fn list(&mut self, open: char, close: char) -> Result<Vec<f64>, String> {
        self.expect(open)?;
        let mut values = vec![self.deeper(|parser| parser.binary(0))?];
        while self.accept(",") {
            values.push(self.deeper(|parser| parser.binary(0))?);
        }
        self.expect(close)?;
        Ok(values)
    }
}

/// A whole number from 1.
fn index(x: f64) -> Option<usize> {
    ((1.0..=1e9).contains(&x) && x.fract() == 0.0).then_some(x as usize)
}

fn constant(name: &str) -> Option<f64> {
    match name {
        "pi" => Some(consts::PI),
        "e" => Some(consts::E),
        "gamma" => Some(0.577_215_664_901_532_9),
        _ => super::units::in_expressions(name),
    }
}

fn call(function: &str, arguments: &[f64]) -> Result<f64, String> {
    let value = match (function, arguments) {
        ("abs", [x]) => x.abs(),
        ("min", [a, b]) => a.min(*b),
        ("max", [a, b]) => a.max(*b),
        ("sqrt", [x]) => x.sqrt(),
        ("pow", [a, b]) => libm::pow(*a, *b),
        ("sin", [x]) => libm::sin(*x),
        ("cos", [x]) => libm::cos(*x),
        ("tan", [x]) => libm::tan(*x),
        ("asin", [x]) => libm::asin(*x),
        ("acos", [x]) => libm::acos(*x),
        ("atan", [x]) => libm::atan(*x),
        ("atan2", [y, x]) => libm::atan2(*y, *x),
        ("sinh", [x]) => libm::sinh(*x),
        ("cosh", [x]) => libm::cosh(*x),
        ("tanh", [x]) => libm::tanh(*x),
        ("exp", [x]) => libm::exp(*x),
        ("log", [x]) => libm::log(*x),
        ("log10", [x]) => libm::log10(*x),
        _ => return Err(format!("there is no function '{function}' of {} numbers", arguments.len())),
    };
    if value.is_finite() { Ok(value) } else { Err(format!("{function} gives {value}")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Some3;

    impl Names for Some3 {
        fn value(&self, name: &str) -> Option<f64> {
            (name == "x_1").then_some(3.0)
        }

        fn element(&self, matrix: &str, indices: &[usize]) -> Result<f64, String> {
            Ok(matrix.len() as f64 * 100.0 + indices.iter().fold(0.0, |sum, i| 10.0 * sum + *i as f64))
        }
    }

    #[test]
    fn expressions_have_the_precedences_of_clhep() {
        let cases = [
            ("", 0.0),
            (" 1.0e+2 ", 100.0),
            ("1.E-1 + .5", 0.6),
            ("-2^2", -4.0),
            ("2*-3", -6.0),
            ("2^3^2", 64.0),
            ("2**-1", 0.5),
            ("2^-1*4", 2.0),
            ("1-2-3", -4.0),
            ("12/2/3", 2.0),
            ("2*(1+x_1)", 8.0),
            ("-x_1*2", -6.0),
            ("3 >= 2 && 1 != 1 || 2 < 1", 0.0),
            ("1+1==2", 1.0),
            ("5*cm + 1*m", 1050.0),
            ("180*deg", consts::PI),
            ("max(1, min(5, x_1))", 3.0),
            ("m[x_1, 1+1]+1", 133.0),
            ("abs(-4)^2", 16.0),
            ("2e", f64::NAN),
        ];
        for (text, expected) in cases {
            match evaluate(text, &Some3) {
                Ok(value) => assert!((value - expected).abs() < 1e-12, "{text}: {value}"),
                Err(_) => assert!(expected.is_nan(), "{text}"),
            }
        }
    }

    #[test]
    fn errors_say_what_is_wrong() {
        let cases = [
            ("1+", "a number is missing at the end"),
            ("(1", "a ')' is missing at the end"),
            ("1)", "there is an unexpected ')'"),
            ("2*/3", "there is a '/' where a number is expected"),
            ("1/0", "it divides by zero"),
            ("speed", "'speed' is not defined"),
            ("sine(1)", "there is no function 'sine' of 1 numbers"),
            ("sqrt(-1)", "sqrt gives NaN"),
            ("m[0]", "an index of the matrix 'm' is not a whole number from 1"),
            ("m[1.5]", "an index of the matrix 'm' is not a whole number from 1"),
            ("1e400", "the value is inf"),
            ("3 4", "there is an unexpected '4'"),
            ("1 #", "there is an unexpected '#'"),
        ];
        for (text, why) in cases {
            let error = evaluate(text, &Some3).unwrap_err();
            assert!(error.contains(why), "{text}: {error}");
        }
        for deep in ["(".repeat(100_000), "-".repeat(100_000), "sin(".repeat(100_000)] {
            assert!(evaluate(&deep, &Some3).unwrap_err().contains("nested more than"), "{}", &deep[..3]);
        }
    }
}
