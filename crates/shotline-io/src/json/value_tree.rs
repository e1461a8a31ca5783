//! The values of a JSON text, each with its byte range. They are stored in one list and refer to their children by index,
//! so that neither traversing nor dropping them needs a stack as deep as the text.

use std::borrow::Cow;
use std::ops::Range;

/// The index of a value in its [`Tree`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ValueId(u32);

/// A value and its byte range.
#[derive(Debug)]
pub(crate) struct Value<'t> {
    /// Texts are smaller than 4 GiB.
    span: (u32, u32),
    pub(crate) content: Content<'t>,
}

/// The content of a value.
#[derive(Debug)]
pub(crate) enum Content<'t> {
    Null,
    Bool(bool),
    Number(f64),
    Text(Cow<'t, str>),
    Array(Box<[ValueId]>),
    Object(Box<[Member<'t>]>),
    /// An invalid value, which has been reported already.
    Wrong,
}

/// A key of an object with its value.
#[derive(Debug)]
pub(crate) struct Member<'t> {
    pub(crate) key: Cow<'t, str>,
    pub(crate) value: ValueId,
    key_span: (u32, u32),
}

impl<'t> Member<'t> {
    pub(crate) fn new(key: Cow<'t, str>, range: Range<usize>, value: ValueId) -> Member<'t> {
        Member { key, value, key_span: (range.start as u32, range.end as u32) }
    }

    /// The bytes of the key, with its quotes.
    pub(crate) fn key_range(&self) -> Range<usize> {
        let (start, end) = self.key_span;
        start as usize..end as usize
    }
}

/// All values of a text.
#[derive(Debug, Default)]
pub(crate) struct Tree<'t> {
    values: Vec<Value<'t>>,
}

impl<'t> Tree<'t> {
    pub(crate) fn add(&mut self, range: Range<usize>, content: Content<'t>) -> ValueId {
        let id = self.next();
        self.values.push(Value { span: (range.start as u32, range.end as u32), content });
        id
    }

    pub(crate) fn content(&self, id: ValueId) -> &Content<'t> {
        &self.values[id.0 as usize].content
    }

    /// The id of the value that is added next.
    pub(crate) fn next(&self) -> ValueId {
        ValueId(self.values.len() as u32)
    }

    pub(crate) fn range(&self, id: ValueId) -> Range<usize> {
        let (start, end) = self.values[id.0 as usize].span;
        start as usize..end as usize
    }

    /// Completes a container, whose end and content were not known when it was added.
    pub(crate) fn complete(&mut self, id: ValueId, end: usize, content: Content<'t>) {
        let value = &mut self.values[id.0 as usize];
        value.span.1 = end as u32;
        value.content = content;
    }

    /// The members of an object; empty for any other value.
    pub(crate) fn members(&self, id: ValueId) -> &[Member<'t>] {
        match self.content(id) {
            Content::Object(members) => members,
            _ => &[],
        }
    }

    /// The value of an object's key.
    pub(crate) fn get(&self, id: ValueId, key: &str) -> Option<ValueId> {
        self.members(id).iter().find(|m| m.key == key).map(|m| m.value)
    }
}
