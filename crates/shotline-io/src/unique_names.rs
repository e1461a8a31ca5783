//! Names that are each given once.

use std::collections::{HashMap, HashSet};

/// The names that are in use.
#[derive(Debug, Default)]
pub(crate) struct UniqueNames {
    taken: HashSet<String>,
    /// The number with which the search for a free name goes on.
    next: HashMap<String, usize>,
}

impl UniqueNames {
    /// Keeps a name from others.
    pub(crate) fn reserve(&mut self, name: String) {
        self.taken.insert(name);
    }

    /// The name itself, or with a number if it is in use.
    pub(crate) fn free(&mut self, name: &str) -> String {
        self.free_by(name, |name, number| format!("{name}_{number}"))
    }

    /// The name itself, or as made from it and a number if it is in use.
    pub(crate) fn free_by(&mut self, name: &str, numbered: impl Fn(&str, usize) -> String) -> String {
        let mut found = name.to_owned();
        let number = self.next.entry(found.clone()).or_insert(1);
        while self.taken.contains(&found) {
            *number += 1;
            found = numbered(name, *number);
        }
        self.taken.insert(found.clone());
        found
    }
}
