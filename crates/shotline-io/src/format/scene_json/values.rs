//! Typed access to the values of a tree. A value of the wrong type is reported once, with its location, and read as
//! `None`.

use std::borrow::Cow;
use std::fmt::Display;

use shotline::accel::NAMES;
use shotline::solid::{Layout, Param};

use super::keys::{ACCEL, PLACEMENT, names};
use crate::diagnostic::{Diagnostics, RawDiagnostic};
use crate::json::{Content, Member, Tree, ValueId};
use crate::suggest;

/// A tree being read.
pub(super) struct Values<'r, 't> {
    pub(super) tree: &'r Tree<'t>,
    pub(super) diagnostics: &'r mut Diagnostics,
}

impl<'r, 't> Values<'r, 't> {
    pub(super) fn report(&mut self, at: ValueId, message: impl Into<String>, help: impl Into<String>) {
        self.diagnostics.push(RawDiagnostic::text(self.tree.range(at), message).help(help));
    }

    /// Suggests a known name. Bounded, so that neither a thousand errors nor a million names make this slow.
    pub(super) fn hint<'n>(&self, written: &str, known: impl Iterator<Item = &'n str>) -> String {
        if self.diagnostics.is_full() {
            return String::new();
        }
        suggest::hint(written, &known.take(10_000).collect::<Vec<_>>())
    }

    /// Reports a value of the wrong type.
    fn mismatch(&mut self, at: ValueId, what: &str, expected: &str) {
        let found = match self.tree.content(at) {
            Content::Wrong => return,
            Content::Null => "null".to_string(),
            Content::Bool(value) => value.to_string(),
            Content::Number(_) => "a number".to_string(),
            Content::Text(_) => "a string".to_string(),
            Content::Array(elements) => format!("an array of {}", elements.len()),
            Content::Object(_) => "an object".to_string(),
        };
        self.diagnostics.push(RawDiagnostic::text(
            self.tree.range(at),
            format!("{what} must be {expected}, not {found}"),
        ));
    }

    pub(super) fn is_text(&self, at: ValueId) -> bool {
        matches!(self.tree.content(at), Content::Text(_))
    }

    pub(super) fn number(&mut self, at: ValueId, what: &str) -> Option<f64> {
        match self.tree.content(at) {
            Content::Number(x) => Some(*x),
            _ => {
                self.mismatch(at, what, "a number");
                None
            }
        }
    }

    /// The accelerator that a node or the scene chooses.
    pub(super) fn accel(&mut self, owner: ValueId) -> Option<&'static str> {
        let at = self.tree.get(owner, ACCEL.name)?;
        let written = self.text(at, "\"accel\"")?;
        let known = NAMES.iter().find(|name| **name == written).copied();
        if known.is_none() {
            let help = self.hint(written, NAMES.iter().copied());
            self.report(at, format!("there is no accelerator named '{written}'"), help);
        }
        known
    }

    /// An array of `count` numbers.
    pub(super) fn numbers(&mut self, at: ValueId, what: &str, count: usize) -> Option<Vec<f64>> {
        match self.tree.content(at) {
            Content::Array(elements) if elements.len() == count => {
                let mut numbers = Some(Vec::with_capacity(count));
                for element in elements {
                    match self.tree.content(*element) {
                        Content::Number(x) => numbers.iter_mut().for_each(|numbers| numbers.push(*x)),
                        _ => {
                            self.mismatch(*element, &format!("each of {what}"), "a number");
                            numbers = None;
                        }
                    }
                }
                numbers
            }
            _ => {
                self.mismatch(at, what, &format!("an array of {count} numbers"));
                None
            }
        }
    }

    /// The numbers of a parameter that is an array of rows, one row after the other.
    pub(super) fn rows(&mut self, at: ValueId, param: &Param) -> Option<Vec<f64>> {
        let Layout::Rows { columns, least } = param.layout else { return None };
        match self.tree.content(at) {
            Content::Array(rows) if rows.len() >= least => {
                let mut numbers = Some(Vec::with_capacity(rows.len() * columns.len()));
                for (i, row) in rows.iter().enumerate() {
                    let what = format!("row {} of {}", i + 1, param.name);
                    let read = self.numbers(*row, &what, columns.len());
                    numbers = numbers.zip(read).map(|(mut all, row)| {
                        all.extend(row);
                        all
                    });
                }
                numbers
            }
            _ => {
                self.mismatch(at, param.name, &layout_in_words(param.layout));
                None
            }
        }
    }

    pub(super) fn vector(&mut self, at: ValueId, what: &str) -> Option<[f64; 3]> {
        self.numbers(at, what, 3).map(|n| [n[0], n[1], n[2]])
    }

    pub(super) fn integer(&mut self, at: ValueId, what: &str) -> Option<i32> {
        let x = self.number(at, what)?;
        // Integers of this size are exact in float64.
        if x.fract() == 0.0 && (f64::from(i32::MIN)..=f64::from(i32::MAX)).contains(&x) {
            return Some(x as i32);
        }
        self.report(at, format!("{what} must be a whole number"), "from -2147483648 to 2147483647");
        None
    }

    pub(super) fn text(&mut self, at: ValueId, what: &str) -> Option<&'r Cow<'t, str>> {
        match self.tree.content(at) {
            Content::Text(text) => Some(text),
            _ => {
                self.mismatch(at, what, "a string");
                None
            }
        }
    }

    pub(super) fn boolean(&mut self, at: ValueId, what: &str) -> Option<bool> {
        match self.tree.content(at) {
            Content::Bool(value) => Some(*value),
            _ => {
                self.mismatch(at, what, "true or false");
                None
            }
        }
    }

    pub(super) fn array(&mut self, at: ValueId, what: &str) -> Option<&'r [ValueId]> {
        match self.tree.content(at) {
            Content::Array(elements) => Some(elements),
            _ => {
                self.mismatch(at, what, "an array [ ... ]");
                None
            }
        }
    }

    pub(super) fn object(&mut self, at: ValueId, what: &str) -> Option<&'r [Member<'t>]> {
        match self.tree.content(at) {
            Content::Object(members) => Some(members),
            _ => {
                self.mismatch(at, what, "an object { ... }");
                None
            }
        }
    }

    /// The value of a key; if it is absent, that is reported with what the key takes.
    pub(super) fn required(&mut self, at: ValueId, what: &str, key: &str, takes: &str) -> Option<ValueId> {
        let found = self.tree.get(at, key);
        if found.is_none() {
            self.report_at_start(at, format!("{what} lacks \"{key}\""), format!("add \"{key}\", {takes}"));
        }
        found
    }

    /// Reports a diagnostic of an object as a whole, at its opening bracket.
    pub(super) fn report_at_start(
        &mut self,
        at: ValueId,
        message: impl Into<String>,
        help: impl Into<String>,
    ) {
        let start = self.tree.range(at).start;
        self.diagnostics.push(RawDiagnostic::text(start..start + 1, message).help(help));
    }

    /// Reports unknown keys of an object, and returns the known keys that were probably meant.
    pub(super) fn only<'k>(&mut self, at: ValueId, what: impl Display, known: &[&'k str]) -> Vec<&'k str> {
        let mut meant = Vec::new();
        for member in self.tree.members(at) {
            let key = member.key.as_ref();
            if known.contains(&key) {
                continue;
            }
            let message = format!("{what} has no key '{key}'");
            let help = help_with_key(key, known).unwrap_or_else(|| self.hint(key, known.iter().copied()));
            self.diagnostics.push(RawDiagnostic::text(member.key_range(), message).help(help));
            if self.diagnostics.is_full() {
                continue;
            }
            meant.extend(suggest::nearest_name(key, known.iter().copied()));
        }
        meant
    }
}

/// What a parameter takes, as text.
pub(super) fn layout_in_words(layout: Layout) -> String {
    match layout {
        Layout::Numbers(count) => numbers_in_words(count),
        Layout::Rows { columns, least } => {
            format!("an array of at least {least} rows [{}]", columns.join(", "))
        }
    }
}

/// What a parameter of `count` numbers takes, as text.
pub(super) fn numbers_in_words(count: usize) -> String {
    match count {
        1 => "a number".into(),
        3 => "three numbers [x, y, z]".into(),
        _ => format!("{count} numbers [...]"),
    }
}

/// Help for keys that other programs use or that belong elsewhere.
fn help_with_key(key: &str, known: &[&str]) -> Option<String> {
    let is_position = matches!(key, "center" | "centre" | "position" | "pos" | "origin" | "location");
    if is_position && known.contains(&"translate") {
        return Some("solids are placed with \"translate\": [x, y, z]".into());
    }
    let is_placement = names(PLACEMENT).any(|placement| placement == key);
    is_placement.then(|| "place the shape in \"node\" instead".into())
}
