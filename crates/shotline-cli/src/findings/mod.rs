//! What `check` has found: faults, which make a model not sound, and remarks and notes of readers, which do not.

mod mesh;
mod scene;

use serde_json::{Value, json};
use shotline::math::Vec3;
use shotline_io::{Effect, Note, Spot};

use crate::number::json_vector;

/// Everything found in a model.
#[derive(Debug, Default)]
pub struct Findings {
    lines: Vec<Line>,
}

#[derive(Debug)]
enum Line {
    /// What is looked at, or could not be.
    Text(String),
    Finding(Finding),
}

/// One kind of defect in one part of a model.
#[derive(Debug)]
struct Finding {
    severity: Severity,
    /// The mesh, or what else it concerns.
    subject: String,
    /// A name for programs.
    kind: &'static str,
    count: usize,
    text: String,
    first: Place,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Severity {
    Fault,
    Remark,
    Note,
}

impl Severity {
    fn name(self) -> &'static str {
        match self {
            Severity::Fault => "fault",
            Severity::Remark => "remark",
            Severity::Note => "note",
        }
    }
}

/// Where a defect is.
#[derive(Debug, Default)]
struct Place {
    faces: Vec<u32>,
    vertices: Vec<u32>,
    objects: Vec<String>,
    point: Option<Vec3>,
    spot: Option<Spot>,
}

impl Findings {
    /// Adds a line for people.
    pub fn line(&mut self, text: impl Into<String>) {
        self.lines.push(Line::Text(text.into()));
    }

    /// Adds what a reader passed over, dropped or repaired.
    pub fn add_note(&mut self, note: &Note) {
        self.add(Finding {
            severity: Severity::Note,
            subject: note.file.clone().unwrap_or_else(|| "scene".into()),
            kind: note.kind,
            count: note.count,
            text: note.to_string(),
            first: Place { spot: note.first, ..Place::default() },
        });
    }

    fn add(&mut self, finding: Finding) {
        self.lines.push(Line::Finding(finding));
    }

    fn findings(&self) -> impl Iterator<Item = &Finding> {
        self.lines.iter().filter_map(|line| match line {
            Line::Finding(finding) => Some(finding),
            Line::Text(_) => None,
        })
    }

    /// Whether there is no fault.
    pub fn are_sound(&self) -> bool {
        self.findings().all(|f| f.severity != Severity::Fault)
    }

    /// The report for people.
    pub fn to_text(&self, model: &str) -> String {
        let mut out = String::new();
        for line in &self.lines {
            out += &match line {
                Line::Text(text) => format!("{text}\n"),
                Line::Finding(finding) => {
                    // Notes stand before the mesh to which they belong, the others below it.
                    let indent = if finding.severity == Severity::Note { "" } else { "  " };
                    format!("{indent}{}: {}\n", finding.severity.name(), finding.text)
                }
            };
        }
        out += &format!("{model}: {}\n", if self.are_sound() { "sound" } else { "not sound" });
        out
    }

    /// The report for programs.
    pub fn to_json(&self, model: &str) -> Value {
        json!({
            "model": model,
            "sound": self.are_sound(),
            "findings": self.findings().map(Finding::to_json).collect::<Vec<_>>(),
        })
    }
}

impl Finding {
    fn to_json(&self) -> Value {
        json!({
            "severity": self.severity.name(),
            "subject": self.subject,
            "kind": self.kind,
            "count": self.count,
            "text": self.text,
            "faces": self.first.faces,
            "vertices": self.first.vertices,
            "objects": self.first.objects,
            "point": self.first.point.map(json_vector),
            "line": line(self.first.spot),
            "byte": byte(self.first.spot),
        })
    }
}

/// A note as JSON, as `info` prints it.
pub fn note_to_json(note: &Note) -> Value {
    json!({
        "kind": note.kind,
        "changed": note.effect == Effect::Changed,
        "count": note.count,
        "text": note.to_string(),
        "file": note.file,
        "line": line(note.first),
        "byte": byte(note.first),
    })
}

fn line(spot: Option<Spot>) -> Option<usize> {
    spot.and_then(|spot| if let Spot::Line(line) = spot { Some(line) } else { None })
}

fn byte(spot: Option<Spot>) -> Option<usize> {
    spot.and_then(|spot| if let Spot::Byte(byte) = spot { Some(byte) } else { None })
}
