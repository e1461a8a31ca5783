//! Names as GDML takes them: names of XML without colons, each for one thing.

use crate::unique_names::UniqueNames;

/// The names that are in use.
#[derive(Debug, Default)]
pub(super) struct Names(UniqueNames);

impl Names {
    /// Keeps a name from others.
    pub(super) fn reserve(&mut self, name: String) {
        self.0.reserve(name);
    }

    /// The name itself, or with a number if it is in use.
    pub(super) fn free(&mut self, name: &str) -> String {
        self.0.free(name)
    }

    /// The name itself, or with an ending that Geant4 removes if it is in use.
    pub(super) fn free_for_geant4(&mut self, name: &str) -> String {
        self.0.free_by(name, |name, number| format!("{name}0x{number:x}"))
    }
}

/// A name of XML: with underscores for what it may not contain.
pub(super) fn as_xml_name(name: &str) -> String {
    let mut out = String::with_capacity(name.len());
    for c in name.chars() {
        let may_follow = is_start(c) || matches!(c, '-' | '.' | '0'..='9' | '\u{B7}');
        if out.is_empty() && may_follow && !is_start(c) {
            out.push('_');
        }
        out.push(if may_follow { c } else { '_' });
    }
    if out.is_empty() { "_".into() } else { out }
}

/// Whether a name of XML may begin with a letter (XML 1.0, production 4, without the colon).
fn is_start(c: char) -> bool {
    matches!(c, 'A'..='Z' | '_' | 'a'..='z' | '\u{C0}'..='\u{D6}' | '\u{D8}'..='\u{F6}' | '\u{F8}'..='\u{2FF}'
        | '\u{370}'..='\u{37D}' | '\u{37F}'..='\u{1FFF}' | '\u{200C}'..='\u{200D}' | '\u{2070}'..='\u{218F}'
        | '\u{2C00}'..='\u{2FEF}' | '\u{3001}'..='\u{D7FF}' | '\u{F900}'..='\u{FDCF}' | '\u{FDF0}'..='\u{FFFD}'
        | '\u{10000}'..='\u{EFFFF}')
}

/// A label as a name and a copy number: `cell[7]`.
pub(super) fn name_and_copy(label: &str) -> (&str, Option<i32>) {
    let split = label.strip_suffix(']').and_then(|rest| rest.rsplit_once('['));
    match split.and_then(|(name, number)| Some((name, number.parse::<i32>().ok()?, number))) {
        // Only a number that is written in the same way again.
        Some((name, copy, written)) if copy.to_string() == written => (name, Some(copy)),
        _ => (label, None),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_free_once() {
        let mut names = Names::default();
        names.reserve("lead".into());
        let found = ["lead", "tin", "tin", "tin"].map(|name| names.free(name));
        assert_eq!(found, ["lead_2", "tin", "tin_2", "tin_3"]);
        assert_eq!(names.free_for_geant4("lead"), "lead0x3");
    }

    #[test]
    fn names_are_made_names_of_xml() {
        let found = ["a.b-c_1", "7 up", "", "größe/µ", "-x", "a:b[3]"].map(as_xml_name);
        assert_eq!(found, ["a.b-c_1", "_7_up", "_", "größe__", "_-x", "a_b_3_"]);
    }

    #[test]
    fn labels_have_copy_numbers() {
        let found = ["cell[7]", "cell", "c[1][2]", "c[x]", "c[07]", "[3]", "c[-1]"].map(name_and_copy);
        let expected = [
            ("cell", Some(7)),
            ("cell", None),
            ("c[1]", Some(2)),
            ("c[x]", None),
            ("c[07]", None),
            ("", Some(3)),
            ("c", Some(-1)),
        ];
        assert_eq!(found, expected);
    }
}
