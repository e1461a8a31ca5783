//! What a scene loses in GDML, and what GDML cannot hold.

use crate::diagnostic::Diagnostics;
use crate::error::WriteError;

/// How many names a note lists.
const LISTED: usize = 5;

/// A loss, with the number of things that it happens to and the names of the first.
#[derive(Debug)]
struct Loss {
    what: &'static str,
    count: usize,
    names: Vec<String>,
}

/// What is found while a scene is written.
#[derive(Debug, Default)]
pub(super) struct Report {
    losses: Vec<Loss>,
    notes: Vec<String>,
    errors: Vec<String>,
    unlisted: usize,
}

/// Something that cannot be written and has been reported.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reported;

impl Report {
    /// Notes what happens to something of a name.
    pub(super) fn lose(&mut self, what: &'static str, name: &str) {
        let at = self.losses.iter().position(|loss| loss.what == what).unwrap_or_else(|| {
            self.losses.push(Loss { what, count: 0, names: Vec::new() });
            self.losses.len() - 1
        });
        let loss = &mut self.losses[at];
        loss.count += 1;
        let name = format!("'{name}'");
        if loss.names.len() < LISTED && !loss.names.contains(&name) {
            loss.names.push(name);
        }
    }

    pub(super) fn note(&mut self, note: String) {
        self.notes.push(note);
    }

    /// Adds what cannot be written.
    pub(super) fn refuse(&mut self, error: String) -> Reported {
        if self.errors.contains(&error) {
            return Reported;
        }
        if self.errors.len() < Diagnostics::MAX_LISTED {
            self.errors.push(error);
        } else {
            self.unlisted += 1;
        }
        Reported
    }

    /// Whether something cannot be written.
    pub(super) fn is_refused(&self) -> bool {
        !self.errors.is_empty()
    }

    /// The notes, or everything that cannot be written.
    pub(super) fn finish(mut self) -> Result<Vec<String>, WriteError> {
        if self.unlisted > 0 {
            self.errors.push(format!("and {} more", self.unlisted));
        }
        if !self.errors.is_empty() {
            return Err(WriteError::Unwritable(self.errors.join("\n")));
        }
        for Loss { what, count, names } in self.losses {
            let more = count - names.len().min(count);
            let rest = if more > 0 { format!(" and {more} more") } else { String::new() };
            self.notes.push(format!("{what}: {}{rest}", names.join(", ")));
        }
        Ok(self.notes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn losses_are_counted_and_errors_listed() {
        let mut report = Report::default();
        (0..7).for_each(|i| report.lose("changed names", &format!("a{i}")));
        report.note("the world is new".into());
        let notes = report.finish().expect("nothing is refused");
        assert_eq!(notes, ["the world is new", "changed names: 'a0', 'a1', 'a2', 'a3', 'a4' and 2 more"]);
        let mut report = Report::default();
        for i in 0..150 {
            let _ = report.refuse(format!("no {i}"));
        }
        let error = report.finish().expect_err("something is refused").to_string();
        assert!(error.contains("no 99\nand 50 more") && !error.contains("no 100"), "{error}");
    }
}
