//! Which objects a picture shows.

use clap::Args;
use shotline::scene::{HiddenObjects, Node, Scene};

use crate::failure::Failure;
use crate::progress::{self, Quiet};

/// The objects that are shown.
#[derive(Args, Debug)]
pub struct Shown {
    /// Leave out the objects of this name, but not what they contain; * stands for any letters. May be given several times.
    /// Default: the outermost object of a scene of nested volumes, which would hide all others
    #[arg(long, value_name = "NAME")]
    hide: Vec<String>,
    /// Show the objects of this name and what they contain, and no others; * stands for any letters. May be given several times
    #[arg(long, value_name = "NAME", conflicts_with = "hide")]
    only: Vec<String>,
}

impl Shown {
    /// The objects of a scene that are not shown.
    ///
    /// # Errors
    /// If no object has one of the names.
    pub fn hidden(&self, scene: &Scene, quiet: Quiet) -> Result<HiddenObjects, Failure> {
        for pattern in self.hide.iter().chain(&self.only) {
            let is_named = |node: &Node| matches!(node, Node::Object { name, .. } if matches(pattern, name));
            if !scene.nodes.iter().any(is_named) {
                let help = "`shotline info` lists the objects; * stands for any letters";
                return Err(Failure::new(format!("no object is named '{pattern}'\nhelp: {help}")));
            }
        }
        let any = |patterns: &[String], name: &str| patterns.iter().any(|pattern| matches(pattern, name));
        if !self.only.is_empty() {
            return Ok(scene.showing_only(|name| any(&self.only, name)));
        }
        if !self.hide.is_empty() {
            return Ok(scene.hiding(|name| any(&self.hide, name)));
        }
        let enclosures = scene.enclosures();
        if enclosures.is_empty() {
            return Ok(HiddenObjects::default());
        }
        let names = enclosures.iter().map(|name| format!("'{name}'")).collect::<Vec<_>>().join(", ");
        progress::note(
            &format!("{names} is not shown, for it encloses the other objects; --only NAME shows it"),
            quiet,
        );
        Ok(scene.hiding(|name| enclosures.contains(&name)))
    }
}

/// Whether a name is one that a pattern stands for: the parts between the stars follow each other in it.
fn matches(pattern: &str, name: &str) -> bool {
    let mut parts = pattern.split('*');
    let first = parts.next().unwrap_or_default();
    let Some(mut rest) = name.strip_prefix(first) else { return false };
    let Some(last) = parts.next_back() else { return rest.is_empty() };
    for part in parts {
        match rest.find(part) {
            Some(at) => rest = &rest[at + part.len()..],
            None => return false,
        }
    }
    rest.ends_with(last)
}

#[cfg(test)]
mod tests {
    use super::matches;

    #[test]
    fn a_star_stands_for_any_letters() {
        for (pattern, name) in [
            ("a", "a"),
            ("*", ""),
            ("*", "x"),
            ("a*", "a0x1"),
            ("*b", "ab"),
            ("a*c*e", "abcde"),
            ("a**", "ab"),
            ("é*", "éa"),
        ] {
            assert!(matches(pattern, name), "{pattern} {name}");
        }
        for (pattern, name) in
            [("a", "ab"), ("b", "ab"), ("a*", "b"), ("a*a", "a"), ("*c*b", "abc"), ("", "a")]
        {
            assert!(!matches(pattern, name), "{pattern} {name}");
        }
    }
}
