//! Errors of the XML parser, and where things stand in a text.

use std::ops::Range;

use roxmltree::{Error, Node};

use crate::diagnostic::RawDiagnostic;
use crate::lines::line_starts;

/// The error of the parser at a byte of a text.
pub(crate) fn syntax_error(at: usize, error: &Error) -> RawDiagnostic {
    let message = match error {
        Error::EntityReferenceLoop(_) => "an entity refers to itself, or to too many others".into(),
        Error::UnknownEntityReference(name, _) => format!("the entity '&{name};' is not defined"),
        Error::NodesLimitReached => "the entities expand to too many elements".into(),
        Error::UnclosedRootNode => "the file ends before its elements do".into(),
        Error::DuplicatedAttribute(name, _) => format!("the attribute '{name}' is given twice"),
        // The parser's messages contain the position, which is shown already.
        error => error.to_string().replace(&format!(" at {}", error.pos()), ""),
    };
    RawDiagnostic::text(at..at + 1, message).help("correct the XML of this line")
}

/// Where in a text an error is.
pub(crate) fn offset_of(text: &str, error: &Error) -> usize {
    if matches!(error, Error::UnclosedRootNode | Error::NoRootNode) {
        return text.trim_end().len();
    }
    let (row, column) = (error.pos().row as usize, error.pos().col as usize);
    let start = match row {
        0 | 1 => 0,
        row => line_starts(text.as_bytes()).nth(row - 2).unwrap_or(text.len()),
    };
    let line = text[start..].lines().next().unwrap_or("");
    start + line.char_indices().nth(column.saturating_sub(1)).map_or(line.len(), |(at, _)| at)
}

/// The value of an attribute of an element in its text, or the start tag if it has no such attribute.
pub(crate) fn place_of(element: Node, attribute: &str) -> Range<usize> {
    let found = element.attributes().find(|found| found.name() == attribute);
    found.map_or_else(|| start_tag(element), |found| found.range_value())
}

/// The start tag of an element.
pub(crate) fn start_tag(element: Node) -> Range<usize> {
    let whole = element.range();
    let text = element.document().input_text().get(whole.clone()).unwrap_or_default();
    whole.start..text.find('>').map_or(whole.end, |end| whole.start + end + 1)
}
