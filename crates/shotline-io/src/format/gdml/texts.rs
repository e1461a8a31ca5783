//! The texts of a GDML document: the file itself and the files that its entities include, and where a part of the tree stands
//! in them.

use std::ops::Range;
use std::path::{Path, PathBuf};

use roxmltree::{Document, Error, Node, ParsingOptions};

use crate::bytes::text_start;
use crate::diagnostic::RawDiagnostic;
use crate::error::ReadError;
use crate::files::read_regular;
use crate::options::PathPolicy;
use crate::paths::{folder_of, resolve};
use crate::xml::{self, offset_of};

use super::MAX_BYTES;

/// A file and its text.
#[derive(Clone, Debug)]
pub(super) struct Text {
    pub(super) path: PathBuf,
    /// How entities name it; empty for the file itself.
    uri: String,
    pub(super) text: String,
}

/// How many bytes the entities of a document may expand to in its attributes and texts, at most.
const MAX_EXPANSION: u64 = 1 << 30;

impl Text {
    pub(super) fn of(path: &Path, bytes: Vec<u8>) -> Result<Text, ReadError> {
        let refuse = |diagnostic: RawDiagnostic, bytes: &[u8]| {
            Err(ReadError::new(Some(path), bytes, diagnostic.into()))
        };
        if let Err(diagnostic) = text_start(&bytes) {
            return refuse(diagnostic, &bytes);
        }
        match String::from_utf8(bytes) {
            Ok(text) => Ok(Text { path: path.into(), uri: String::new(), text }),
            Err(error) => {
                let at = error.utf8_error().valid_up_to();
                let diagnostic = RawDiagnostic::text(at..at + 1, "the text is not UTF-8 from here on")
                    .help("save the file as UTF-8");
                refuse(diagnostic, error.as_bytes())
            }
        }
    }

    /// The text behind a text declaration, which XML allows at the beginning of an included file.
    fn content(&self) -> &str {
        let text = self.text.trim_start_matches('\u{FEFF}');
        match text.strip_prefix("<?xml").and_then(|rest| rest.find("?>").map(|end| &rest[end + 2..])) {
            Some(rest) => rest,
            None => text,
        }
    }
}

/// The text of a file, followed by those of the files that its entities include.
pub(super) fn read_texts(
    main: Text,
    scene_folder: &Path,
    policy: PathPolicy,
) -> Result<Vec<Text>, ReadError> {
    let folder = folder_of(&main.path).to_path_buf();
    let mut uris: Vec<String> = Vec::new();
    if main.text.contains("<!ENTITY") {
        check_expansion(&main)?;
        let found = std::cell::RefCell::new(&mut uris);
        let note = |_: Option<&str>, uri: &str| {
            found.borrow_mut().push(uri.to_owned());
            Ok(Some(""))
        };
        // What is wrong with the file is reported when it is parsed with its entities.
        let _ = Document::parse_with_options(&main.text, options(&note, std::slice::from_ref(&main)));
    }
    uris.sort();
    uris.dedup();
    let mut texts = vec![main];
    for uri in uris {
        let refuse = |why: String, help: String| {
            let main = &texts[0];
            let diagnostic = match main.text.find(uri.as_str()) {
                Some(at) => RawDiagnostic::text(at..at + uri.len(), why),
                None => RawDiagnostic::file(why),
            };
            ReadError::new(Some(&main.path), main.text.as_bytes(), diagnostic.help(help).into())
        };
        let path = resolve(&folder, scene_folder, &uri, policy)
            .map_err(|refusal| refuse(refusal.why, refusal.help))?;
        let text = Text::of(&path, read_regular(&path, MAX_BYTES)?)?;
        texts.push(Text { uri, ..text });
    }
    Ok(texts)
}

/// Refuses entities that could expand to more than memory holds, by a bound on what they expand to.
fn check_expansion(main: &Text) -> Result<(), ReadError> {
    let (bytes, end) = (main.text.as_bytes(), main.text.rfind("]>").unwrap_or(main.text.len()));
    let references = |bytes: &[u8]| bytes.iter().filter(|b| **b == b'&').count() as u64;
    // The parser follows at most 255 references within one.
    let nested = if references(&bytes[..end]) > 0 { 255 } else { 1 };
    let expansion = references(bytes).saturating_mul(end as u64).saturating_mul(nested);
    if expansion <= MAX_EXPANSION {
        return Ok(());
    }
    let message = format!("the entities could expand to {} MiB", expansion >> 20);
    let at = main.text.find("<!ENTITY").unwrap_or(0);
    let diagnostic = RawDiagnostic::text(at..at + 1, message).help("write out what they stand for");
    Err(ReadError::new(Some(&main.path), bytes, diagnostic.into()))
}

type Resolve<'x> = dyn Fn(Option<&str>, &str) -> Result<Option<&'x str>, String> + 'x;

fn options<'x>(resolve: &'x Resolve<'x>, texts: &[Text]) -> ParsingOptions<'x> {
    // An element has at least four bytes, and an entity may stand for many.
    let bytes: usize = texts.iter().map(|text| text.text.len()).sum();
    ParsingOptions {
        allow_dtd: true,
        nodes_limit: u32::try_from(bytes).unwrap_or(u32::MAX).saturating_add(1_000_000),
        entity_resolver: Some(resolve),
    }
}

/// Parses a file with its entities, and gives the tree to `read`.
pub(super) fn with_tree<T>(texts: &[Text], read: impl FnOnce(&Document) -> T) -> Result<T, ReadError> {
    let included = |_: Option<&str>, uri: &str| {
        Ok(texts.iter().find(|text| text.uri == uri).map(Text::content).or(Some("")))
    };
    match Document::parse_with_options(&texts[0].text, options(&included, texts)) {
        Ok(document) => Ok(read(&document)),
        Err(error) => Err(syntax_error(texts, &error)),
    }
}

/// The error of the parser. It knows the line but not the file, so each included file is parsed alone.
fn syntax_error(texts: &[Text], error: &Error) -> ReadError {
    const WRAP: &str = "<x>";
    for text in &texts[1..] {
        let wrapped = format!("{WRAP}{}</x>", text.content());
        let options = ParsingOptions { allow_dtd: true, ..ParsingOptions::default() };
        match Document::parse_with_options(&wrapped, options) {
            // What an entity stands for is known only in the file that includes this one.
            Ok(_) | Err(Error::UnknownEntityReference(..)) => {}
            Err(error) => {
                let before = text.text.len() - text.content().len();
                let at = before + offset_of(&wrapped, &error).saturating_sub(WRAP.len());
                return located(text, at.min(text.text.len()), &error);
            }
        }
    }
    located(&texts[0], offset_of(&texts[0].text, error), error)
}

fn located(text: &Text, at: usize, error: &Error) -> ReadError {
    ReadError::new(Some(&text.path), text.text.as_bytes(), xml::syntax_error(at, error).into())
}

/// Where an element stands: the number of its text, and its bytes there. The name of an element is a part of the text that
/// it stands in.
pub(super) fn place_of(texts: &[Text], node: Node) -> (usize, Range<usize>) {
    let name = node.tag_name().name().as_ptr() as usize;
    let holds = |text: &Text| {
        let start = text.text.as_ptr() as usize;
        (start..start + text.text.len()).contains(&name)
    };
    let number = texts.iter().position(holds).unwrap_or(0);
    let before = name.saturating_sub(texts[number].text.as_ptr() as usize);
    // The name follows the bracket, and possibly a prefix.
    let text = texts[number].text.get(..before).unwrap_or_default();
    let start = text.rfind('<').unwrap_or(text.len());
    (number, start..(start + node.range().len()).min(texts[number].text.len()))
}

/// Where the value of an attribute stands, or the element if it has no such attribute.
pub(super) fn place_of_attribute(texts: &[Text], node: Node, name: &str) -> (usize, Range<usize>) {
    let (number, element) = place_of(texts, node);
    match node.attribute_node(name) {
        Some(attribute) => {
            let value = attribute.range_value();
            let first = element.start + value.start.saturating_sub(node.range().start);
            (number, first..first + value.len())
        }
        None => (number, start_tag(&texts[number].text, element)),
    }
}

/// The start tag of an element, of which only the beginning is certain: it may end in another text than it begins in.
fn start_tag(text: &str, element: Range<usize>) -> Range<usize> {
    let rest = text.get(element.start..).unwrap_or_default();
    element.start..rest.find('>').map_or(element.end, |end| element.start + end + 1)
}
