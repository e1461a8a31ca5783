//! The objects, groups and materials of an OBJ file.

use std::collections::HashSet;

use crate::bytes::Word;
use crate::mesh_file::{MeshFile, Section};

/// The names under which faces stand, from one face to the next change.
#[derive(Default)]
pub(super) struct Sections {
    now: Names,
    all: Vec<(u32, Names)>,
    /// The files of materials.
    pub(super) files: Vec<String>,
}

#[derive(Clone, Default)]
struct Names {
    object: String,
    group: String,
    material: String,
}

impl Sections {
    /// A line `o`, before the face with this number.
    pub(super) fn object(&mut self, line: &[Word], face: usize) {
        self.now.object = rest(line);
        self.begin(face);
    }

    /// A line `g`.
    pub(super) fn group(&mut self, line: &[Word], face: usize) {
        self.now.group = rest(line);
        self.begin(face);
    }

    /// A line `usemtl`.
    pub(super) fn material(&mut self, line: &[Word], face: usize) {
        self.now.material = rest(line);
        self.begin(face);
    }

    fn begin(&mut self, face: usize) {
        let Ok(face) = u32::try_from(face) else { return };
        // Names without faces are of no interest.
        self.all.pop_if(|(first, _)| *first == face);
        self.all.push((face, self.now.clone()));
    }

    /// Gives the sections to the mesh. Faces are named by `o`, or by `g` where all have the same `o`.
    pub(super) fn give(self, found: MeshFile) -> MeshFile {
        let count = |name: fn(&Names) -> &String| {
            self.all
                .iter()
                .map(|(_, names)| name(names))
                .filter(|n| !n.is_empty())
                .collect::<HashSet<_>>()
                .len()
        };
        let by_group = count(|names| &names.object) < 2 && count(|names| &names.group) > 1;
        let section = |(first, names): &(u32, Names)| Section {
            first: *first,
            name: if by_group { names.group.clone() } else { names.object.clone() },
            material: names.material.clone(),
        };
        let sections = self.all.iter().map(section).collect();
        MeshFile { sections, material_files: self.files, ..found }
    }
}

/// The words behind a keyword: names may have blanks.
fn rest(line: &[Word]) -> String {
    line[1..].iter().map(Word::text).collect::<Vec<_>>().join(" ")
}
