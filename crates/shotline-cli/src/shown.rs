//! Which objects a picture shows.

use clap::Args;
use shotline::scene::{HiddenObjects, Scene, UnknownObject};

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
        if !self.only.is_empty() || !self.hide.is_empty() {
            return hidden_by_name(scene, &self.hide, &self.only);
        }
        if !scene.enclosures().is_empty() {
            let names = enclosures_in_words(scene);
            progress::note(
                &format!("{names} is not shown, for it encloses the other objects; --only NAME shows it"),
                quiet,
            );
        }
        Ok(scene.hiding_enclosures())
    }
}

/// The names of the objects that enclose all others, as text.
pub fn enclosures_in_words(scene: &Scene) -> String {
    scene.enclosures().iter().map(|name| format!("'{name}'")).collect::<Vec<_>>().join(", ")
}

/// The objects of a scene that are hidden by name: those of some names, or all but those of others and what they contain.
///
/// # Errors
/// If no object has one of the names.
pub fn hidden_by_name(scene: &Scene, hide: &[String], only: &[String]) -> Result<HiddenObjects, Failure> {
    let hidden = if only.is_empty() { scene.hiding(hide) } else { scene.showing_only(only) };
    let unknown = |error: UnknownObject| {
        Failure::new(format!("{error}\nhelp: `shotline info` lists the objects; * stands for any letters"))
    };
    hidden.map_err(unknown)
}
