//! JSON with comments and trailing commas, read into a [`Tree`].
//!
//! This crate has its own parser, because no existing one fits: `jsonc-parser` stops at 512 levels of brackets, about
//! 200 solids nested in one another, and at the first error; `serde_json` keeps no positions. This one has an
//! explicit stack, so that depth only takes memory, and continues after every error that leaves the brackets balanced.

use std::collections::HashSet;
use std::ops::Range;

use super::token;
use super::value_tree::{Content, Member, Tree, ValueId};
use crate::diagnostic::{Diagnostics, RawDiagnostic};

/// The maximum depth of nested brackets. A solid nested in a boolean operation takes two levels.
const MAX_DEPTH: usize = 20_000;

/// Parses a text. Returns `None` if its brackets are not balanced; all errors are in `diagnostics`.
pub(crate) fn parse<'t>(text: &'t str, diagnostics: &mut Diagnostics) -> Option<(Tree<'t>, ValueId)> {
    let mut parser = Parser {
        text,
        at: 0,
        tree: Tree::default(),
        open: Vec::new(),
        elements: Vec::new(),
        members: Vec::new(),
        diagnostics,
    };
    match parser.document() {
        Ok(root) => Some((parser.tree, root)),
        Err(diagnostic) => {
            parser.diagnostics.push(diagnostic);
            None
        }
    }
}

struct Parser<'t, 'f> {
    text: &'t str,
    at: usize,
    tree: Tree<'t>,
    open: Vec<Open>,
    /// The elements of all open arrays, those of the innermost last: so a closed one takes no more memory than it needs.
    elements: Vec<ValueId>,
    /// The same for the members of open objects.
    members: Vec<Member<'t>>,
    diagnostics: &'f mut Diagnostics,
}

/// A container that is not closed yet.
struct Open {
    id: ValueId,
    brace: bool,
    /// The number of its first element or member.
    first: usize,
    /// Whether a member may begin: after the opening bracket or a comma.
    ready: bool,
}

impl<'t> Parser<'t, '_> {
    fn document(&mut self) -> Result<ValueId, RawDiagnostic> {
        self.skip_trivia()?;
        let root = self.begin_value()?;
        while !self.open.is_empty() {
            self.step()?;
        }
        self.skip_trivia()?;
        match self.peek() {
            None => Ok(root),
            Some(c) => Err(RawDiagnostic::text(self.here(c), "something follows the end of the scene")
                .help("a file holds one { ... }; is there a closing bracket too many?")),
        }
    }

    /// Reads a comma, a closing bracket or the beginning of a member of the innermost open container.
    fn step(&mut self) -> Result<(), RawDiagnostic> {
        self.skip_trivia()?;
        let next = self.peek();
        let Some(open) = self.open.last_mut() else { return Ok(()) };
        let (id, brace, ready) = (open.id, open.brace, open.ready);
        let Some(c) = next else {
            let opening = self.tree.range(id);
            let bracket = if brace { '{' } else { '[' };
            return Err(RawDiagnostic::text(
                opening,
                format!("the end of the file comes before the end of this '{bracket}'"),
            ));
        };
        match c {
            '}' | ']' => return self.close(id, brace, c),
            ',' => {
                open.ready = true;
                if ready {
                    self.diagnostics
                        .push(RawDiagnostic::text(self.at..self.at + 1, "nothing stands before this comma"));
                }
                self.at += 1;
                return Ok(());
            }
            _ => open.ready = false,
        }
        if !ready {
            self.diagnostics.push(RawDiagnostic::text(self.here(c), "a comma is missing before this"));
        }
        let key = if brace { Some(self.key()?) } else { None };
        // It is added here before it begins, as its own content follows if it is a container.
        let value = self.tree.next();
        match key {
            Some((key, range)) => self.members.push(Member::new(key, range, value)),
            None => self.elements.push(value),
        }
        self.begin_value()?;
        Ok(())
    }

    fn close(&mut self, id: ValueId, brace: bool, found: char) -> Result<(), RawDiagnostic> {
        let (opening, expected) = if brace { ('{', '}') } else { ('[', ']') };
        if found != expected {
            let diagnostic =
                RawDiagnostic::text(self.at..self.at + 1, format!("'{found}' closes a '{opening}'"));
            return Err(diagnostic.help(format!("use '{expected}', or is one missing before?")));
        }
        self.at += 1;
        let first = self.open.pop().map_or(0, |open| open.first);
        let content = if brace {
            report_duplicates(&self.members[first..], self.diagnostics);
            Content::Object(self.members.drain(first..).collect())
        } else {
            Content::Array(self.elements.drain(first..).collect())
        };
        self.tree.complete(id, self.at, content);
        Ok(())
    }

    /// Reads a scalar, or the opening bracket of a container, which is pushed on the stack.
    fn begin_value(&mut self) -> Result<ValueId, RawDiagnostic> {
        let start = self.at;
        let content = match self.peek() {
            None => {
                return Err(RawDiagnostic::text(start..start, "a value is missing at the end of the file"));
            }
            Some('{') => return self.open(true),
            Some('[') => return self.open(false),
            Some('"' | '\'') => Content::Text(self.string()?.0),
            Some('-' | '+' | '.' | '0'..='9') => {
                let range =
                    self.run_ascii(|b| b.is_ascii_alphanumeric() || matches!(b, b'+' | b'-' | b'.' | b'_'));
                self.or_report(token::number(self.text, range).map(Content::Number))
            }
            Some(c) if c.is_alphabetic() || c == '_' || c == '$' => {
                let range = self.run(|c| c.is_alphanumeric() || c == '_' || c == '$');
                self.or_report(token::word(self.text, range))
            }
            Some(c) => {
                return Err(RawDiagnostic::text(self.here(c), format!("a value is expected, not '{c}'")));
            }
        };
        Ok(self.tree.add(start..self.at, content))
    }

    fn open(&mut self, brace: bool) -> Result<ValueId, RawDiagnostic> {
        if self.open.len() >= MAX_DEPTH {
            let diagnostic = RawDiagnostic::text(
                self.at..self.at + 1,
                format!("brackets are nested more than {MAX_DEPTH} deep"),
            );
            return Err(diagnostic.help("name the inner parts in \"defs\" and use {\"ref\": NAME}"));
        }
        let id = self.tree.add(self.at..self.at + 1, Content::Null);
        let first = if brace { self.members.len() } else { self.elements.len() };
        self.open.push(Open { id, brace, first, ready: true });
        self.at += 1;
        Ok(id)
    }

    fn key(&mut self) -> Result<(std::borrow::Cow<'t, str>, Range<usize>), RawDiagnostic> {
        let (key, range) = match self.peek() {
            Some('"' | '\'') => self.string()?,
            Some(c) if c.is_alphanumeric() || c == '_' || c == '$' => {
                let range = self.run(|c| c.is_alphanumeric() || c == '_' || c == '$');
                let key = &self.text[range.clone()];
                self.diagnostics.push(
                    RawDiagnostic::text(range.clone(), format!("the key '{key}' stands without quotes"))
                        .help(format!("write \"{key}\"")),
                );
                (key.into(), range)
            }
            other => {
                let c = other.unwrap_or(' ');
                return Err(RawDiagnostic::text(
                    self.here(c),
                    format!("a key in quotes is expected, not '{c}'"),
                ));
            }
        };
        self.skip_trivia()?;
        match self.peek() {
            Some(':') => self.at += 1,
            _ => return Err(RawDiagnostic::text(range, "a ':' and a value must follow this key")),
        }
        self.skip_trivia()?;
        Ok((key, range))
    }

    /// A string, and its range with the quotes.
    fn string(&mut self) -> Result<(std::borrow::Cow<'t, str>, Range<usize>), RawDiagnostic> {
        let start = self.at;
        let bytes = self.text.as_bytes();
        let quote = bytes[start];
        let mut end = start + 1;
        while bytes.get(end).is_some_and(|b| *b != quote && !matches!(b, b'\n' | b'\r')) {
            end += if bytes[end] == b'\\' { 2 } else { 1 };
        }
        if bytes.get(end) != Some(&quote) {
            let shown = self.text[start..].find(['\n', '\r']).unwrap_or(self.text.len() - start);
            return Err(RawDiagnostic::text(start..start + shown, "this string does not end on its line"));
        }
        self.at = end + 1;
        if quote == b'\'' {
            self.diagnostics.push(RawDiagnostic::text(start..self.at, "strings stand in double quotes"));
        }
        let diagnostics = &mut *self.diagnostics;
        Ok((token::unescape(self.text, start + 1..end, &mut |f| diagnostics.push(f)), start..self.at))
    }

    fn or_report(&mut self, content: Result<Content<'t>, RawDiagnostic>) -> Content<'t> {
        content.unwrap_or_else(|diagnostic| {
            self.diagnostics.push(diagnostic);
            Content::Wrong
        })
    }

    fn peek(&self) -> Option<char> {
        match self.text.as_bytes().get(self.at) {
            Some(byte) if byte.is_ascii() => Some(char::from(*byte)),
            _ => self.text[self.at..].chars().next(),
        }
    }

    fn here(&self, c: char) -> Range<usize> {
        self.at..(self.at + c.len_utf8()).min(self.text.len())
    }

    /// Moves past a run of characters.
    fn run(&mut self, belongs: fn(char) -> bool) -> Range<usize> {
        let rest = &self.text[self.at..];
        let start = self.at;
        self.at += rest.find(|c| !belongs(c)).unwrap_or(rest.len());
        start..self.at
    }

    /// Moves past a run of ASCII characters, of which numbers consist: most of a large scene are numbers.
    fn run_ascii(&mut self, belongs: fn(&u8) -> bool) -> Range<usize> {
        let start = self.at;
        self.at += self.text.as_bytes()[start..].iter().take_while(|b| belongs(b)).count();
        start..self.at
    }

    /// Moves past white space, comments and a byte order mark at the start.
    fn skip_trivia(&mut self) -> Result<(), RawDiagnostic> {
        if self.at == 0 && self.text.starts_with('\u{FEFF}') {
            self.at = '\u{FEFF}'.len_utf8();
        }
        loop {
            let rest = &self.text[self.at..];
            let blank = rest.bytes().take_while(|b| matches!(b, b' ' | b'\t' | b'\n' | b'\r')).count();
            let rest = &rest[blank..];
            self.at += blank;
            if rest.starts_with("//") {
                self.at += rest.find(['\n', '\r']).unwrap_or(rest.len());
            } else if let Some(comment) = rest.strip_prefix("/*") {
                match comment.find("*/") {
                    Some(end) => self.at += end + 4,
                    None => return Err(RawDiagnostic::text(self.at..self.at + 2, "this comment has no end")),
                }
            } else {
                return Ok(());
            }
        }
    }
}

/// Up to this many keys are compared one by one, which is faster than a hash.
const FEW_KEYS: usize = 8;

fn report_duplicates(members: &[Member], diagnostics: &mut Diagnostics) {
    let has_twin = |(i, member): (usize, &Member)| members[..i].iter().any(|other| other.key == member.key);
    if members.len() <= FEW_KEYS && !members.iter().enumerate().any(has_twin) {
        return;
    }
    let mut seen = HashSet::new();
    for member in members {
        if !seen.insert(&member.key) {
            let diagnostic = RawDiagnostic::text(
                member.key_range(),
                format!("the key '{}' stands here twice", member.key),
            );
            diagnostics.push(diagnostic.help("keep one of them"));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn messages(text: &str) -> Vec<String> {
        let mut diagnostics = Diagnostics::default();
        parse(text, &mut diagnostics);
        diagnostics.listed.into_iter().map(|f| f.message).collect()
    }

    #[test]
    fn common_extensions_are_accepted() {
        for text in [
            "\u{FEFF}{}",
            "[1, 2,]",
            "{\"a\": 1,} // end",
            "/* a */ {/**/\"a\":/*/ */[]}",
            "\"\\u00e4\"",
            " 7 ",
        ] {
            assert_eq!(messages(text), Vec::<String>::new(), "{text}");
        }
    }

    #[test]
    fn all_errors_are_reported() {
        let found = messages("{\"a\": NaN, \"a\": 1e400, b: 'x' \"c\": 01, \"d\": \"\\ud800\",, \"e\": +1}");
        assert_eq!(found.len(), 10, "{found:#?}");
    }

    #[test]
    fn containers_have_their_own_content() {
        let mut diagnostics = Diagnostics::default();
        let text = "{\"a\": [1, [2, 3], {\"b\": [], \"c\": [4]}, 5], \"d\": {}, \"e\": 6}";
        let (tree, root) = parse(text, &mut diagnostics).expect("it is balanced");
        let keys = |id| tree.members(id).iter().map(|member| member.key.as_ref()).collect::<Vec<_>>();
        let elements = |id| match tree.content(id) {
            Content::Array(elements) => elements.to_vec(),
            other => panic!("{other:?}"),
        };
        let written = |id| &text[tree.range(id)];
        assert_eq!(keys(root), ["a", "d", "e"]);
        let of_a = elements(tree.get(root, "a").unwrap());
        assert_eq!(of_a.iter().map(|&id| written(id)).collect::<Vec<_>>()[..2], ["1", "[2, 3]"]);
        assert_eq!((of_a.len(), written(of_a[3])), (4, "5"));
        assert_eq!(keys(of_a[2]), ["b", "c"]);
        assert_eq!(elements(tree.get(of_a[2], "b").unwrap()), []);
        assert_eq!(elements(tree.get(of_a[2], "c").unwrap()).len(), 1);
        assert_eq!(&text[tree.members(root)[2].key_range()], "\"e\"");
        assert_eq!(keys(tree.get(root, "d").unwrap()).len(), 0);
    }

    #[test]
    fn unbalanced_brackets_end_parsing() {
        for text in [
            "", "{", "[1", "{\"a\"", "{\"a\":", "{\"a\":}", "[}", "{]", "{} {}", "[1] x", "\"abc", "\"a\\",
            "/*", "@", "{1:2}",
        ] {
            assert!(!messages(text).is_empty(), "{text}");
        }
    }

    #[test]
    fn depth_is_limited_only_by_our_own_limit() {
        let nest = |n: usize| "[".repeat(n) + &"]".repeat(n);
        assert!(messages(&nest(MAX_DEPTH)).is_empty());
        assert!(messages(&nest(MAX_DEPTH + 1))[0].contains("nested more than"));
        assert!(messages(&"[".repeat(3_000_000))[0].contains("nested more than"));
    }
}
