//! The report as one JSON document. Infinite numbers and missing values are `null`.

use serde_json::{Value, json};
use shotline::query::{ConflictKind, HitKind};
use shotline::scene::Units;

use super::{CrossingRow, ShootReport};
use crate::number::{json as number, json_vector};

impl ShootReport {
    /// The report as JSON, every number with all its digits.
    pub fn to_json(&self) -> Value {
        json!({
            "ray": {
                "origin": json_vector(self.ray.origin()),
                "direction": json_vector(self.ray.direction()),
                "t_min": number(self.span.t_min()),
                "t_max": number(self.span.t_max()),
            },
            "units": self.units.map(Units::name),
            "crossings": self.crossings.iter().map(crossing).collect::<Vec<_>>(),
            "materials": self.totals.iter().map(|t| json!({
                "material": t.material,
                "length": number(t.length),
                "segments": t.segments,
            })).collect::<Vec<_>>(),
            "overlaps": self.overlaps.iter().map(|o| json!({
                "kind": match o.kind {
                    ConflictKind::Overlap => "overlap",
                    ConflictKind::Protrusion => "protrusion",
                },
                "first": o.first,
                "second": o.second,
                "t_in": number(o.t_in),
                "t_out": number(o.t_out),
            })).collect::<Vec<_>>(),
            "no_thickness": self.no_thickness.as_ref().map(ToString::to_string),
        })
    }
}

fn crossing(row: &CrossingRow) -> Value {
    let kind = match row.hit.kind {
        HitKind::Surface => "surface",
        HitKind::Start => "start",
        HitKind::End => "end",
    };
    json!({
        "t": number(row.hit.t),
        "t_err": number(row.hit.t_err),
        "distance": number(row.distance),
        "point": row.point.map(json_vector),
        "entering": row.hit.entering,
        "kind": kind,
        "object": row.object,
        "surface": row.surface,
        "material": row.material,
        "path": row.path,
        "normal": row.obliquity.map(|_| json_vector(row.hit.normal)),
        "obliquity": row.obliquity.map(number),
        "primitive": row.hit.primitive,
        "polygon": row.hit.polygon,
        "barycentric": row.hit.barycentric,
        "thickness": row.thickness.map(number),
    })
}
