//! The steps of one ray, in words and as JSON.

use clap::ValueEnum;
use serde_json::{Map, Value, json};
use shotline::compile::World;
use shotline::crossing::{Crossing, NO_PRIMITIVE};
use shotline::query::{Caster, QueryError, Scope};
use shotline::ray::Ray;
use shotline::trace::{Act, Step, Trace};

use crate::number::{counted, json as number, short};

/// What the ray is asked while it is watched.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Query {
    /// Every crossing
    Crossings,
    /// The first crossing: what lies behind it is not looked at
    Closest,
    /// Whether there is any crossing
    Any,
}

/// What a ray did.
#[derive(Debug)]
pub struct Steps {
    trace: Trace,
}

/// So many crossings stand on a line.
const LISTED: usize = 8;

impl Steps {
    /// Casts the ray and keeps its first steps.
    ///
    /// # Errors
    /// As the query.
    pub fn new(
        world: &World,
        ray: &Ray,
        scope: Scope,
        query: Query,
        most: usize,
    ) -> Result<Steps, QueryError> {
        let mut caster = Caster::new(world);
        caster.record(most);
        match query {
            Query::Crossings => caster.crossings(ray, scope, &mut Vec::new())?,
            Query::Closest => drop(caster.closest(ray, scope)?),
            Query::Any => drop(caster.any(ray, scope)?),
        }
        Ok(Steps { trace: caster.take_trace() })
    }

    /// A line a step: where on the ray, and what was done, indented by depth.
    pub fn to_text(&self) -> String {
        let t = |step: &Step| step.t.map_or_else(String::new, short);
        let steps = &self.trace.steps;
        let width = steps.iter().map(|step| t(step).len()).max().unwrap_or(0).max(1);
        let mut out = format!("  {:>width$}  step\n", "t");
        let mut rest = steps.iter().peekable();
        while let Some(step) = rest.next() {
            let mut line = in_words(&step.act);
            // What is answered at once stands on one line with the question.
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

    /// An object a step.
    pub fn to_json(&self) -> Value {
        json!({
            "steps": self.trace.steps.iter().map(step).collect::<Vec<_>>(),
            "left_out": self.trace.left_out,
        })
    }
}

fn in_words(act: &Act) -> String {
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
        Act::Saved { item } => format!("- {item}: met before, says its tag"),
        Act::Test { item } => format!("test {item}"),
        Act::Run { met, tested, saved, hits, limit } => {
            let mut out = format!("{} met", counted(*met, "part", "parts"));
            out += &format!(", {} tested", counted(*tested, "triangle", "triangles"));
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
        Act::Found { crossings } => format!("answer: {}", list(crossings)),
        Act::Before { item, crossing } => {
            format!("{}: before its box, only counted", toggled(item, crossing))
        }
        Act::Toggle { item, crossing } => toggled(item, crossing),
        Act::Boundary { entering } => format!("=> {}", way(*entering)),
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

fn way(entering: bool) -> &'static str {
    if entering { "in" } else { "out" }
}

fn list(crossings: &[Crossing]) -> String {
    let one = |c: &Crossing| {
        let triangle = triangle(c).map_or_else(String::new, |i| format!(" (triangle {i})"));
        format!("{} at {}{triangle}", way(c.entering), short(c.t))
    };
    if crossings.is_empty() {
        return "nothing".into();
    }
    let mut parts: Vec<String> = crossings.iter().take(LISTED).map(one).collect();
    if crossings.len() > LISTED {
        parts.push(format!("{} more", crossings.len() - LISTED));
    }
    parts.join(", ")
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
