//! The steps of one ray, as text and as JSON.

use clap::ValueEnum;
use serde::Deserialize;
use serde_json::{Map, Value, json};
use shotline::compile::World;
use shotline::crossing::{Crossing, NO_PRIMITIVE};
use shotline::query::{Caster, QueryError, Scope};
use shotline::ray::Ray;
use shotline::trace::{Act, Step, Trace};

use crate::number::{counted, json as number, short};

/// The query whose steps are reported.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TraceQuery {
    /// Every crossing
    Crossings,
    /// The first crossing: what lies behind it is not examined
    Closest,
    /// Whether there is any crossing
    Any,
}

/// The recorded steps of a ray.
#[derive(Debug)]
pub struct TraceReport {
    trace: Trace,
}

/// The maximum number of crossings on a line.
const MAX_LISTED: usize = 8;

impl TraceReport {
    /// Casts the ray and records its first `max_steps` steps.
    ///
    /// # Errors
    /// The error of the query.
    pub fn new(
        world: &World,
        ray: &Ray,
        scope: Scope,
        query: TraceQuery,
        max_steps: usize,
    ) -> Result<TraceReport, QueryError> {
        let mut caster = Caster::new(world);
        caster.record(max_steps);
        match query {
            TraceQuery::Crossings => caster.crossings(ray, scope, &mut Vec::new())?,
            TraceQuery::Closest => drop(caster.closest(ray, scope)?),
            TraceQuery::Any => drop(caster.any(ray, scope)?),
        }
        Ok(TraceReport { trace: caster.take_trace() })
    }

    /// The steps.
    pub fn trace(&self) -> &Trace {
        &self.trace
    }

    /// A step in words.
    pub fn text_of(&self, step: &Step) -> String {
        describe(&step.act).replace(char::is_control, "\u{FFFD}")
    }

    /// One line per step: where on the ray, and what was done, indented by depth.
    pub fn to_text(&self) -> String {
        let t = |step: &Step| step.t.map_or_else(String::new, short);
        let steps = &self.trace.steps;
        let width = steps.iter().map(|step| t(step).len()).max().unwrap_or(0).max(1);
        let mut out = format!("  {:>width$}  step\n", "t");
        let mut rest = steps.iter().peekable();
        while let Some(step) = rest.next() {
            let mut line = describe(&step.act);
            // A test and its result are on one line.
            if let (Act::Test { .. }, Some(Act::Found { crossings })) =
                (&step.act, rest.peek().map(|s| &s.act))
            {
                line += &format!(": {}", list(crossings));
                rest.next();
            }
            let line = format!("  {:>width$}  {:indent$}{line}", t(step), "", indent = 2 * step.depth);
            out += &line.replace(char::is_control, "\u{FFFD}");
            out.push('\n');
        }
        if self.trace.left_out > 0 {
            let all = steps.len() as u64 + self.trace.left_out;
            let left_out = counted(self.trace.left_out, "more step is", "more steps are");
            out += &format!("  {left_out} left out; --steps {all} shows all\n");
        }
        out
    }

    /// One object per step.
    pub fn to_json(&self) -> Value {
        json!({
            "steps": self.trace.steps.iter().map(step).collect::<Vec<_>>(),
            "left_out": self.trace.left_out,
        })
    }
}

fn describe(act: &Act) -> String {
    match act {
        Act::EnterLevel { path, placements } => {
            let placements = counted(*placements as u64, "placement", "placements");
            if path.is_empty() {
                format!("the scene: {placements}")
            } else {
                format!("level {path}: {placements}")
            }
        }
        Act::EnterBody { path, leaves } => {
            format!("body {path}: {}", counted(*leaves as u64, "leaf", "leaves"))
        }
        Act::Expand { node } => format!("open {node}"),
        Act::PushNode { node } => format!("+ {node}"),
        Act::PushItem { item } => format!("+ {item}"),
        Act::Miss { item } => format!("- {item}: its box is missed"),
        Act::Saved { item } => format!("- {item}: tested before, by its tag"),
        Act::Test { item } => format!("test {item}"),
        Act::Run { met, tested, saved, hits, limit } => {
            let mut out = format!("{} tested", counted(*met, "node", "nodes"));
            out += &format!(", {}", counted(*tested, "triangle", "triangles"));
            if *saved > 0 {
                out += &format!(", {saved} saved by tags");
            }
            if !hits.is_empty() {
                out += &format!(": {}", list(hits));
            }
            if limit.is_finite() {
                out += &format!("; limit {}", short(*limit));
            }
            out
        }
        Act::Found { crossings } => format!("crossings: {}", list(crossings)),
        Act::Before { item, crossing } => {
            format!("{}: before its box, only counted", toggled(item, crossing))
        }
        Act::Toggle { item, crossing } => toggled(item, crossing),
        Act::Boundary { entering } => format!("=> {}", direction(*entering)),
        Act::Start => "=> in (start)".into(),
        Act::End => "=> out (end)".into(),
        Act::Done { pending } => {
            let entries = counted(*pending as u64, "pending entry is", "pending entries are");
            format!("done: {entries} never opened")
        }
    }
}

fn toggled(item: &str, crossing: &Crossing) -> String {
    format!("cross {} {item}", if crossing.entering { "into" } else { "out of" })
}

fn direction(entering: bool) -> &'static str {
    if entering { "in" } else { "out" }
}

fn list(crossings: &[Crossing]) -> String {
    let one = |c: &Crossing| {
        let triangle = triangle(c).map_or_else(String::new, |i| format!(" (triangle {i})"));
        format!("{} at {}{triangle}", direction(c.entering), short(c.t))
    };
    if crossings.is_empty() {
        return "nothing".into();
    }
    let mut entries: Vec<String> = crossings.iter().take(MAX_LISTED).map(one).collect();
    if crossings.len() > MAX_LISTED {
        entries.push(format!("{} more", crossings.len() - MAX_LISTED));
    }
    entries.join(", ")
}

fn triangle(crossing: &Crossing) -> Option<u32> {
    Some(crossing.primitive).filter(|&p| p != NO_PRIMITIVE)
}

fn step(step: &Step) -> Value {
    let (name, more) = match &step.act {
        Act::EnterLevel { path, placements } => ("level", json!({ "path": path, "placements": placements })),
        Act::EnterBody { path, leaves } => ("body", json!({ "path": path, "leaves": leaves })),
        Act::Expand { node } => ("open", json!({ "part": node })),
        Act::PushNode { node } => ("offer", json!({ "part": node })),
        Act::PushItem { item } => ("offer", json!({ "item": item })),
        Act::Miss { item } => ("miss", json!({ "item": item })),
        Act::Saved { item } => ("saved", json!({ "item": item })),
        Act::Test { item } => ("test", json!({ "item": item })),
        Act::Run { met, tested, saved, hits, limit } => (
            "run",
            json!({
                "met": met,
                "tested": tested,
                "saved": saved,
                "hits": hits.iter().map(crossing).collect::<Vec<_>>(),
                "limit": number(*limit),
            }),
        ),
        Act::Found { crossings } => {
            ("found", json!({ "crossings": crossings.iter().map(crossing).collect::<Vec<_>>() }))
        }
        Act::Before { item, crossing: c } => ("before", json!({ "item": item, "crossing": crossing(c) })),
        Act::Toggle { item, crossing: c } => ("cross", json!({ "item": item, "crossing": crossing(c) })),
        Act::Boundary { entering } => ("boundary", json!({ "entering": entering, "kind": "surface" })),
        Act::Start => ("boundary", json!({ "entering": true, "kind": "start" })),
        Act::End => ("boundary", json!({ "entering": false, "kind": "end" })),
        Act::Done { pending } => ("done", json!({ "pending": pending })),
    };
    let mut object = Map::new();
    object.insert("depth".into(), json!(step.depth));
    object.insert("t".into(), step.t.map_or(Value::Null, number));
    object.insert("step".into(), name.into());
    if let Value::Object(more) = more {
        object.extend(more);
    }
    Value::Object(object)
}

fn crossing(c: &Crossing) -> Value {
    json!({ "t": number(c.t), "t_err": number(c.t_err), "entering": c.entering, "triangle": triangle(c) })
}
