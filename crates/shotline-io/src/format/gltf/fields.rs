//! Typed access to the values of a glTF file. Every error has the position of the value.

use crate::diagnostic::RawDiagnostic;
use crate::json::{Content, Tree, ValueId};

/// What a part of a reader returns.
pub(super) type Read<T> = Result<T, RawDiagnostic>;

/// A value of the JSON text.
#[derive(Clone, Copy, Debug)]
pub(super) struct Field<'j> {
    tree: &'j Tree<'j>,
    id: ValueId,
}

impl<'j> Field<'j> {
    pub(super) fn new(tree: &'j Tree<'j>, id: ValueId) -> Field<'j> {
        Field { tree, id }
    }

    /// The bytes of the text.
    pub(super) fn range(self) -> std::ops::Range<usize> {
        self.tree.range(self.id)
    }

    /// An error that marks this value.
    pub(super) fn error(self, message: impl Into<String>) -> RawDiagnostic {
        RawDiagnostic::text(self.range(), message)
    }

    /// The value of a key. `None` if there is none, or it is null.
    pub(super) fn get(self, key: &str) -> Option<Field<'j>> {
        let id = self.tree.get(self.id, key)?;
        let is_null = matches!(self.tree.content(id), Content::Null);
        (!is_null).then_some(Field { tree: self.tree, id })
    }

    /// The value of a key, which must be there.
    pub(super) fn required(self, key: &str, what: &str) -> Read<Field<'j>> {
        self.get(key).ok_or_else(|| self.error(format!("{what} has no \"{key}\"")))
    }

    /// An extension of this object.
    pub(super) fn extension(self, name: &str) -> Option<Field<'j>> {
        self.get("extensions")?.get(name)
    }

    /// The keys and values of an object.
    pub(super) fn members(self, what: &str) -> Read<impl Iterator<Item = (&'j str, Field<'j>)>> {
        match self.tree.content(self.id) {
            Content::Object(members) => Ok(members
                .iter()
                .map(move |member| (member.key.as_ref(), Field { tree: self.tree, id: member.value }))),
            _ => Err(self.mismatch(what, "an object { ... }")),
        }
    }

    /// The elements of an array.
    pub(super) fn elements(self, what: &str) -> Read<List<'j>> {
        match self.tree.content(self.id) {
            Content::Array(ids) => Ok(List { tree: self.tree, ids }),
            _ => Err(self.mismatch(what, "an array [ ... ]")),
        }
    }

    /// The elements of the array that is the value of a key; none if there is no such key.
    pub(super) fn list(self, key: &str) -> Read<List<'j>> {
        match self.get(key) {
            Some(field) => field.elements(&format!("\"{key}\"")),
            None => Ok(List { tree: self.tree, ids: &[] }),
        }
    }

    pub(super) fn number(self, what: &str) -> Read<f64> {
        match self.tree.content(self.id) {
            Content::Number(x) => Ok(*x),
            _ => Err(self.mismatch(what, "a number")),
        }
    }

    /// A whole number of at least 0.
    pub(super) fn whole(self, what: &str) -> Read<usize> {
        let x = self.number(what)?;
        // Up to 2^53 whole numbers are exact.
        if x.fract() == 0.0 && (0.0..9e15).contains(&x) {
            return Ok(x as usize);
        }
        Err(self.error(format!("{what} must be a whole number of at least 0, not {x}")))
    }

    /// The whole number of a key, or 0 if there is none.
    pub(super) fn whole_or_zero(self, key: &str) -> Read<usize> {
        self.get(key).map_or(Ok(0), |field| field.whole(&format!("\"{key}\"")))
    }

    pub(super) fn text(self, what: &str) -> Read<&'j str> {
        match self.tree.content(self.id) {
            Content::Text(text) => Ok(text),
            _ => Err(self.mismatch(what, "a string")),
        }
    }

    /// A name, if the object has one.
    pub(super) fn name(self) -> Option<&'j str> {
        self.get("name").and_then(|name| name.text("").ok()).filter(|name| !name.is_empty())
    }

    /// Whether the value of a key is `true`.
    pub(super) fn flag(self, key: &str) -> bool {
        self.get(key).is_some_and(|field| matches!(self.tree.content(field.id), Content::Bool(true)))
    }

    /// An array of numbers.
    pub(super) fn numbers<const N: usize>(self, what: &str) -> Read<[f64; N]> {
        let wrong = || self.mismatch(what, &format!("an array of {N} numbers"));
        let elements = self.elements(what).map_err(|_| wrong())?;
        if elements.len() != N {
            return Err(wrong());
        }
        let mut numbers = [0.0; N];
        for (number, element) in numbers.iter_mut().zip(elements.iter()) {
            *number = element.number(&format!("each of {what}"))?;
        }
        Ok(numbers)
    }

    /// The number of an element of a list of the file.
    pub(super) fn index(self, what: &str, list: &List) -> Read<usize> {
        let index = self.whole(&format!("the number of a {what}"))?;
        if index < list.len() {
            return Ok(index);
        }
        let message = format!("there is no {what} {index}; the file has {}, counted from 0", list.len());
        Err(self.error(message))
    }

    fn mismatch(self, what: &str, expected: &str) -> RawDiagnostic {
        let found = match self.tree.content(self.id) {
            Content::Null | Content::Wrong => "null".to_owned(),
            Content::Bool(value) => value.to_string(),
            Content::Number(_) => "a number".to_owned(),
            Content::Text(_) => "a string".to_owned(),
            Content::Array(elements) => format!("an array of {}", elements.len()),
            Content::Object(_) => "an object".to_owned(),
        };
        self.error(format!("{what} must be {expected}, not {found}"))
    }
}

/// The elements of an array.
#[derive(Clone, Copy, Debug)]
pub(super) struct List<'j> {
    tree: &'j Tree<'j>,
    ids: &'j [ValueId],
}

impl<'j> List<'j> {
    pub(super) fn len(&self) -> usize {
        self.ids.len()
    }

    pub(super) fn get(&self, index: usize) -> Option<Field<'j>> {
        self.ids.get(index).map(|id| Field { tree: self.tree, id: *id })
    }

    pub(super) fn iter(self) -> impl DoubleEndedIterator<Item = Field<'j>> + ExactSizeIterator {
        self.ids.iter().map(move |id| Field { tree: self.tree, id: *id })
    }
}
