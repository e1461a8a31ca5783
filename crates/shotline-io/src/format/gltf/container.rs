//! The container: GLB, a binary file of chunks, or the JSON text itself.

use std::ops::Range;

use super::fields::Read;
use crate::bytes::Cursor;
use crate::diagnostic::RawDiagnostic;
use crate::location::RawLocation;
use crate::note::{Effect, NoteKind, Notes};

pub(super) const MAGIC: &[u8] = b"glTF";

/// The types of the chunks that have a meaning.
const JSON: &[u8] = b"JSON";
const BIN: &[u8] = b"BIN\0";

/// Where in a file its parts are.
#[derive(Debug, PartialEq)]
pub(super) struct Container {
    pub(super) json: Range<usize>,
    /// The binary buffer of a GLB file.
    pub(super) bin: Option<Range<usize>>,
}

const BEHIND: NoteKind = NoteKind {
    name: "extra_bytes",
    effect: Effect::Changed,
    one: "1 byte behind the end of the GLB was not read",
    many: "# bytes behind the end of the GLB were not read",
};

/// The parts of a file.
///
/// # Errors
/// If it is a GLB whose chunks do not fit its size.
pub(super) fn parts(bytes: &[u8], notes: &mut Notes) -> Read<Container> {
    if !bytes.starts_with(MAGIC) {
        return Ok(Container { json: 0..bytes.len(), bin: None });
    }
    let mut cursor = Cursor::new(bytes, MAGIC.len());
    let (Some(version), Some(length)) = (word(&mut cursor), word(&mut cursor)) else {
        return Err(RawDiagnostic::byte(bytes.len(), "the file ends within the head of the GLB"));
    };
    if version != 2 {
        let message = format!("this is version {version} of the GLB container");
        return Err(RawDiagnostic::byte(4, message).help("only version 2 is read; convert it to glTF 2.0"));
    }
    if length > bytes.len() {
        let message = format!("the head promises {length} bytes, but the file has {}", bytes.len());
        return Err(RawDiagnostic::byte(8, message).help("the file is cut off; copy it again"));
    }
    if length < cursor.at {
        return Err(RawDiagnostic::byte(8, format!("the head says that the file has {length} bytes")));
    }
    notes.add_many(&BEHIND, bytes.len() - length, RawLocation::Byte(length));
    let mut cursor = Cursor::new(&bytes[..length], cursor.at);
    let Some((JSON, json)) = chunk(&mut cursor)? else {
        let message = "the first chunk of the GLB is not its JSON";
        return Err(RawDiagnostic::byte(12, message));
    };
    let mut bin = None;
    while let Some((kind, range)) = chunk(&mut cursor)? {
        // Chunks of other types are to be passed over, says the format.
        if kind == BIN && bin.is_none() {
            bin = Some(range);
        }
    }
    Ok(Container { json: trimmed(bytes, json), bin })
}

fn word(cursor: &mut Cursor) -> Option<usize> {
    let bytes = cursor.take(4)?;
    Some(u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]) as usize)
}

/// The type and the content of the next chunk; `None` at the end.
fn chunk<'b>(cursor: &mut Cursor<'b>) -> Read<Option<(&'b [u8], Range<usize>)>> {
    let start = cursor.at;
    if cursor.left() == 0 {
        return Ok(None);
    }
    let (Some(length), Some(kind)) = (word(cursor), cursor.take(4)) else {
        return Err(RawDiagnostic::byte(start, "the file ends within the head of a chunk"));
    };
    let (first, left) = (cursor.at, cursor.left());
    if cursor.take(length).is_none() {
        let message = format!("a chunk of {length} bytes begins here, but only {left} bytes follow");
        return Err(RawDiagnostic::byte(start, message).help("the file is cut off; copy it again"));
    }
    Ok(Some((kind, first..first + length)))
}

/// Without the zeros with which some programs fill up the JSON.
fn trimmed(bytes: &[u8], json: Range<usize>) -> Range<usize> {
    let zeros = bytes[json.clone()].iter().rev().take_while(|b| **b == 0).count();
    json.start..json.end - zeros
}

/// A GLB of a JSON text and a buffer, each filled up to a multiple of four bytes; `None` if it is too large.
pub(super) fn glb(json: &[u8], buffer: &[u8]) -> Option<Vec<u8>> {
    let chunks = [(JSON, json, b' '), (BIN, buffer, 0)];
    let body: usize = chunks.iter().map(|(_, content, _)| 8 + content.len().next_multiple_of(4)).sum();
    let whole = 12 + body;
    let mut out = Vec::with_capacity(whole);
    out.extend_from_slice(MAGIC);
    out.extend(2_u32.to_le_bytes());
    out.extend(u32::try_from(whole).ok()?.to_le_bytes());
    for (kind, content, filler) in chunks {
        let length = content.len().next_multiple_of(4);
        out.extend(u32::try_from(length).ok()?.to_le_bytes());
        out.extend_from_slice(kind);
        out.extend_from_slice(content);
        out.resize(out.len() + length - content.len(), filler);
    }
    Some(out)
}
