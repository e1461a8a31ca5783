//! Notes of names that several objects of a scene file have.

use std::collections::HashSet;
use std::ops::Range;

use shotline::scene::{Node, Scene};

use super::find_param;
use crate::fault::At;
use crate::note::{Effect, Note, NoteKind, Notes};

const DUPLICATE_NAMES: NoteKind = NoteKind {
    name: "duplicate_names",
    effect: Effect::Kept,
    one: "1 object has the name of another, and the name stands for both",
    many: "# objects have names of others, and each such name stands for all of its objects",
};

/// Notes the objects with a name that an earlier one has. `spans` are the bytes of each node in the text. An object that is
/// placed several times is one object.
pub(super) fn duplicate_names(scene: &Scene, spans: &[Range<usize>], text: &str) -> Vec<Note> {
    let (mut names, mut notes) = (HashSet::new(), Notes::default());
    let (mut first, mut count) = (None, 0);
    for (node, span) in scene.nodes.iter().zip(spans) {
        if let Node::Object { name, .. } = node
            && !names.insert(name.as_str())
        {
            count += 1;
            first = first.or(Some((name, span)));
        }
    }
    if let Some((name, span)) = first {
        // An object without a name is named after its number.
        let at =
            text.get(span.clone()).and_then(|node| find_param(node, "name")).map_or(0, |range| range.start);
        notes.quote(&DUPLICATE_NAMES, At::Text(span.start + at..span.end), || name.clone());
        notes.add_many(&DUPLICATE_NAMES, count - 1, At::File);
    }
    notes.finish(text.as_bytes())
}
