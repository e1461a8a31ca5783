//! The findings of `check`: faults, which make a model not sound, and remarks and notes of readers, which do not.

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
    /// A line that names what is examined.
    Text(String),
    /// What could not be examined.
    Unexamined(String),
    Finding(Finding),
}

/// The verdict on a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Everything was examined, and there is no fault.
    Sound,
    /// There is a fault.
    NotSound,
    /// No fault was found, but something could not be examined.
    Unknown,
}

impl Verdict {
    fn text(self) -> &'static str {
        match self {
            Verdict::Sound => "sound",
            Verdict::NotSound => "not sound",
            Verdict::Unknown => "no fault found, but not examined in full",
        }
    }

    /// The exit code of `check`.
    pub fn exit_code(self) -> u8 {
        match self {
            Verdict::Sound => 0,
            Verdict::NotSound => 1,
            Verdict::Unknown => 3,
        }
    }
}

/// One kind of defect in one mesh or in the scene.
#[derive(Debug)]
struct Finding {
    severity: Severity,
    /// The mesh file, or `scene`.
    subject: String,
    /// The identifier in the JSON report.
    kind: &'static str,
    count: usize,
    text: String,
    first: Location,
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

/// Where a defect occurs first.
#[derive(Debug, Default)]
struct Location {
    faces: Vec<u32>,
    vertices: Vec<u32>,
    objects: Vec<String>,
    point: Option<Vec3>,
    spot: Option<Spot>,
}

impl Findings {
    /// Adds a line of the text report.
    pub fn line(&mut self, text: impl Into<String>) {
        self.lines.push(Line::Text(text.into()));
    }

    /// Adds what could not be examined, and why.
    pub fn unexamined(&mut self, what: impl Into<String>) {
        self.lines.push(Line::Unexamined(what.into()));
    }

    /// Adds what a reader ignored, dropped or repaired.
    pub fn add_note(&mut self, note: &Note) {
        self.add(Finding {
            severity: Severity::Note,
            subject: note.file.clone().unwrap_or_else(|| "scene".into()),
            kind: note.kind,
            count: note.count,
            text: note.to_string(),
            first: Location { spot: note.first, ..Location::default() },
        });
    }

    fn add(&mut self, finding: Finding) {
        self.lines.push(Line::Finding(finding));
    }

    fn findings(&self) -> impl Iterator<Item = &Finding> {
        self.lines.iter().filter_map(|line| match line {
            Line::Finding(finding) => Some(finding),
            Line::Text(_) | Line::Unexamined(_) => None,
        })
    }

    fn all_unexamined(&self) -> impl Iterator<Item = &String> {
        self.lines.iter().filter_map(|line| match line {
            Line::Unexamined(what) => Some(what),
            Line::Text(_) | Line::Finding(_) => None,
        })
    }

    /// The verdict of all findings together.
    pub fn verdict(&self) -> Verdict {
        if self.findings().any(|f| f.severity == Severity::Fault) {
            Verdict::NotSound
        } else if self.all_unexamined().next().is_some() {
            Verdict::Unknown
        } else {
            Verdict::Sound
        }
    }

    /// The report as text.
    pub fn to_text(&self, model: &str) -> String {
        let mut out = String::new();
        for line in &self.lines {
            out += &match line {
                Line::Text(text) => format!("{text}\n"),
                Line::Unexamined(what) => format!("  not examined: {what}\n"),
                Line::Finding(finding) => {
                    // Notes are printed before the line of the mesh, the other findings below it.
                    let indent = if finding.severity == Severity::Note { "" } else { "  " };
                    format!("{indent}{}: {}\n", finding.severity.name(), finding.text)
                }
            };
        }
        out += &format!("{model}: {}\n", self.verdict().text());
        out
    }

    /// The report as JSON.
    pub fn to_json(&self, model: &str) -> Value {
        json!({
            "model": model,
            "sound": match self.verdict() {
                Verdict::Sound => Value::Bool(true),
                Verdict::NotSound => Value::Bool(false),
                Verdict::Unknown => Value::Null,
            },
            "unexamined": self.all_unexamined().collect::<Vec<_>>(),
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
            "vertex": vertex(self.first.spot),
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
        "vertex": vertex(note.first),
    })
}

fn line(spot: Option<Spot>) -> Option<usize> {
    spot.and_then(|spot| if let Spot::Line(line) = spot { Some(line) } else { None })
}

fn byte(spot: Option<Spot>) -> Option<usize> {
    spot.and_then(|spot| if let Spot::Byte(byte) = spot { Some(byte) } else { None })
}

fn vertex(spot: Option<Spot>) -> Option<usize> {
    spot.and_then(|spot| if let Spot::Vertex(vertex) = spot { Some(vertex) } else { None })
}
