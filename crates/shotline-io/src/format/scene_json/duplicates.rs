//! Notes of names that several objects of a scene file share.

use std::collections::HashSet;
use std::ops::Range;

use shotline::scene::{Node, Scene};

use super::find_param;
use crate::location::RawLocation;
use crate::note::{Effect, Note, NoteKind, Notes};

const DUPLICATE_NAMES: NoteKind = NoteKind {
    name: "duplicate_names",
    effect: Effect::Kept,
    one: "a name stands for 2 objects: it is given a second time",
    many: "# objects have the name of an earlier one, and each such name stands for all that have it",
};

/// Notes the objects that have the name of an earlier one. `spans` are the bytes of each node in the text. An object with
/// several instances counts once.
pub(super) fn duplicate_names(scene: &Scene, spans: &[Range<usize>], text: &str) -> Vec<Note> {
    let (mut names, mut notes) = (HashSet::with_capacity(scene.objects.len()), Notes::default());
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
        // An object without a name has no key "name".
        let at =
            text.get(span.clone()).and_then(|node| find_param(node, "name")).map_or(0, |range| range.start);
        let at = RawLocation::Text(span.start + at..span.end);
        if count == 1 {
            // A note of a single name quotes it within the sentence.
            notes.add(&DUPLICATE_NAMES, at);
            let mut notes = notes.finish(text.as_bytes());
            let insert_name =
                |note: &mut Note| note.text = note.text.replace("a name", &format!("the name '{name}'"));
            notes.iter_mut().for_each(insert_name);
            return notes;
        }
        notes.quote(&DUPLICATE_NAMES, at, || name.clone());
        notes.add_many(&DUPLICATE_NAMES, count - 1, RawLocation::File);
    }
    notes.finish(text.as_bytes())
}
