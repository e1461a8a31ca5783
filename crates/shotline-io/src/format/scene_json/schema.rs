//! The JSON Schema of scene files, generated from the tables that the reader uses.

use serde_json::{Map, Value, json};
use shotline::accel::NAMES;
use shotline::scene::Units;
use shotline::solid::{self, Layout};

use super::keys::{
    ACCEL, CAMERA, COPIES, Key, LIGHT, MATERIAL, MESH, MESH_FILE, MOTION, OBJECT, OPS, PLACEMENT, ROTATION,
    Shape, TOP, WELD, names,
};
use crate::format::mesh_format_names;

/// The schema as text, as published in `docs/scene.schema.json`.
pub fn scene_schema() -> String {
    let mut definitions = Map::new();
    definitions.extend(PLACEMENT.iter().map(|key| (key.name.to_string(), placement(key))));
    definitions.insert("shape".into(), shape());
    definitions.insert("object".into(), placed(OBJECT, &["node"], parts_of_object(), "An object."));
    let member =
        json!({ "if": { "required": ["node"] }, "then": reference("object"), "else": reference("shape") });
    definitions.insert("member".into(), member);
    let shares = json!({ "type": "object", "additionalProperties": { "type": "number", "minimum": 0 } });
    let composition = [("composition".to_string(), shares)].into_iter().collect();
    definitions.insert("material".into(), closed(MATERIAL, &[], composition));
    definitions.insert("light".into(), light());
    let mut schema = closed(TOP, &["shotline"], top());
    schema["$schema"] = json!("https://json-schema.org/draft/2020-12/schema");
    schema["title"] = json!("shotline scene");
    schema["description"] = json!("Comments and trailing commas are allowed. See docs/scene-format.md.");
    schema["$defs"] = Value::Object(definitions);
    format!("{schema:#}\n")
}

fn top() -> Map<String, Value> {
    let named = |what: &str| json!({ "type": "object", "additionalProperties": reference(what) });
    let mut camera = closed(CAMERA, &["eye", "target"], Map::new());
    camera["not"] = json!({ "required": ["fov", "height"] });
    let reusable =
        json!({ "anyOf": [reference("object"), placed(&[], &["ref"], part_name(), "A part of defs.")] });
    let turn = [("rotate".to_string(), reference("rotate"))].into_iter().collect();
    let motion = closed(MOTION, &["object"], turn);
    let refs = [
        ("shotline", json!({ "const": 1 })),
        ("units", units()),
        ("defs", named("member")),
        ("objects", json!({ "type": "array", "items": reusable })),
        ("materials", named("material")),
        ("camera", camera),
        ("lights", json!({ "type": "array", "items": reference("light") })),
        ("accel", accelerator(about(TOP, "accel"))),
        ("motions", json!({ "type": "array", "items": motion })),
    ];
    refs.map(|(key, value)| (key.to_string(), value)).into_iter().collect()
}

fn units() -> Value {
    let names: Vec<_> = Units::ALL.iter().map(|(name, _)| *name).chain([Units::NONE]).collect();
    json!({ "enum": names, "description": about(TOP, "units") })
}

fn parts_of_object() -> Map<String, Value> {
    let contents = json!({ "type": "array", "items": reference("member") });
    let parts = [("node", reference("shape")), ("contents", contents)];
    parts.map(|(key, value)| (key.to_string(), value)).into_iter().collect()
}

fn part_name() -> Map<String, Value> {
    [("ref".to_string(), json!({ "type": "string", "description": "The name of a part in defs." }))]
        .into_iter()
        .collect()
}

fn light() -> Value {
    let mut light = closed(LIGHT, &[], Map::new());
    light["oneOf"] =
        json!([{ "required": ["point"] }, { "required": ["direction"] }, { "required": ["ambient"] }]);
    light["properties"]["ambient"]["const"] = json!(true);
    light
}

/// Leaves of every kind, operations and references. Each form is selected by its key. With `oneOf` a validator would try
/// every operation at every level of nesting, which takes exponential time.
fn shape() -> Value {
    let leaves = solid::KINDS.iter().map(|kind| when("kind", json!({ "const": kind.name }), leaf(kind)));
    let mut forms: Vec<Value> = leaves.collect();
    forms.push(when("kind", json!({ "const": MESH }), mesh()));
    forms.extend(OPS.iter().map(|(op, about)| when("op", json!({ "const": op }), operation(op, about))));
    forms.extend(COPIES.iter().map(|(op, about, keys, required)| {
        when("op", json!({ "const": op }), copies(op, about, keys, *required))
    }));
    forms.push(when("ref", json!({}), placed(&[], &["ref"], part_name(), "A part of defs.")));
    let kinds: Vec<_> = solid::KINDS.iter().map(|k| k.name).chain([MESH]).collect();
    let ops: Vec<_> = OPS.iter().map(|(op, _)| *op).chain(COPIES.iter().map(|(op, ..)| *op)).collect();
    json!({
        "type": "object",
        "properties": { "kind": { "enum": kinds }, "op": { "enum": ops } },
        "oneOf": [{ "required": ["kind"] }, { "required": ["op"] }, { "required": ["ref"] }],
        "allOf": forms,
    })
}

/// The schema of an object that has a certain key.
fn when(key: &str, value: Value, then: Value) -> Value {
    json!({ "if": { "required": [key], "properties": { key: value } }, "then": then })
}

fn leaf(kind: &solid::Kind) -> Value {
    let mut own: Map<String, Value> =
        [("kind".to_string(), json!({ "const": kind.name }))].into_iter().collect();
    for param in kind.params {
        let mut schema = match param.layout {
            Layout::Numbers(1) => bare(Shape::Number),
            Layout::Numbers(count) => bare(Shape::Numbers(count)),
            Layout::Rows { columns, least } => {
                json!({ "type": "array", "items": bare(Shape::Numbers(columns.len())), "minItems": least })
            }
        };
        schema["description"] = json!(param.summary);
        match param.default {
            Some([x]) => schema["default"] = json!(x),
            Some(numbers) => schema["default"] = json!(numbers),
            None => {}
        }
        own.insert(param.name.into(), schema);
    }
    let given = kind.params.iter().filter(|p| p.default.is_none()).map(|p| p.name);
    let required: Vec<&str> = ["kind"].into_iter().chain(given).collect();
    placed(&[], &required, own, kind.summary)
}

fn mesh() -> Value {
    let weld = json!({ "anyOf": [{ "type": "number", "minimum": 0 }, { "const": "auto" }], "description": WELD.about });
    let about =
        format!("A {} file, relative to the scene file and not outside of its folder.", mesh_format_names());
    let own = [
        (MESH_FILE.name, described(MESH_FILE.shape, &about)),
        ("kind", json!({ "const": MESH })),
        (WELD.name, weld),
        (ACCEL.name, accelerator(ACCEL.about)),
    ];
    let own = own.map(|(key, value)| (key.to_string(), value)).into_iter().collect();
    placed(&[], &["kind", MESH_FILE.name], own, "A triangle mesh from a file.")
}

fn about(keys: &[Key], name: &str) -> &'static str {
    keys.iter().find(|key| key.name == name).map_or("", |key| key.about)
}

fn accelerator(about: &str) -> Value {
    json!({ "enum": NAMES, "description": about })
}

fn operation(op: &str, about: &str) -> Value {
    let (item, least) = if op == "group" { ("member", 0) } else { ("shape", 1) };
    let args = json!({ "type": "array", "items": reference(item), "minItems": least });
    let own = [("op", json!({ "const": op })), ("args", args), (ACCEL.name, accelerator(ACCEL.about))];
    let own = own.map(|(key, value)| (key.to_string(), value)).into_iter().collect();
    placed(&[], &["op", "args"], own, about)
}

fn copies(op: &str, about: &str, keys: &[Key], required: usize) -> Value {
    let args = json!({ "type": "array", "items": reference("member"), "minItems": 1 });
    let count = |key: &Key| match key.shape {
        Shape::Integer => Some((key.name, json!({ "type": "integer", "minimum": 1 }))),
        _ if key.name == "counts" => {
            let items = json!({ "type": "integer", "minimum": 1 });
            Some((key.name, json!({ "type": "array", "items": items, "minItems": 3, "maxItems": 3 })))
        }
        _ if key.name == "cells" => {
            let items = json!({ "type": ["integer", "null"], "minimum": 0 });
            Some((key.name, json!({ "type": "array", "items": items })))
        }
        _ => None,
    };
    let own = [("op", json!({ "const": op })), ("args", args), (ACCEL.name, accelerator(ACCEL.about))];
    let own = own.into_iter().chain(keys.iter().filter_map(count));
    let own = own.map(|(key, value)| (key.to_string(), value)).collect();
    let required = keys[..required].iter().map(|key| key.name);
    let required: Vec<_> = ["op", "args"].into_iter().chain(required).collect();
    placed(keys, &required, own, about)
}

/// An object that may also have a transform: a matrix or steps.
fn placed(keys: &[Key], required: &[&str], own: Map<String, Value>, about: &str) -> Value {
    let mut schema = closed(keys, required, own);
    for key in names(PLACEMENT) {
        schema["properties"][key] = reference(key);
    }
    let steps = ["scale", "rotate", "translate"].map(|step| json!({ "required": [step] }));
    schema["dependentSchemas"] = json!({ "transform": { "not": { "anyOf": steps } } });
    schema["description"] = json!(about);
    schema
}

/// The schema of a key of a transform.
fn placement(key: &Key) -> Value {
    let mut schema = match key.name {
        "scale" => json!({ "anyOf": [bare(Shape::Number), bare(Shape::Numbers(3))] }),
        "rotate" => {
            let about = closed(ROTATION, &["axis", "degrees"], Map::new());
            json!({ "anyOf": [bare(Shape::Numbers(3)), about] })
        }
        _ => bare(key.shape),
    };
    schema["description"] = json!(key.about);
    schema
}

/// An object with these keys and no others; `own` adds keys and replaces the schemas of some.
fn closed(keys: &[Key], required: &[&str], own: Map<String, Value>) -> Value {
    let known = keys.iter().map(|key| (key.name.to_string(), described(key.shape, key.about)));
    let mut properties: Map<String, Value> = known.collect();
    for (key, mut schema) in own {
        let about = properties.get(&key).and_then(|known| known.get("description"));
        if let Some(about) = about.filter(|_| schema.get("description").is_none()) {
            schema["description"] = about.clone();
        }
        properties.insert(key, schema);
    }
    let mut schema = json!({ "type": "object", "properties": properties, "additionalProperties": false });
    if !required.is_empty() {
        schema["required"] = json!(required);
    }
    schema
}

fn reference(name: &str) -> Value {
    json!({ "$ref": format!("#/$defs/{name}") })
}

fn described(shape: Shape, about: &str) -> Value {
    let mut schema = bare(shape);
    schema["description"] = json!(about);
    schema
}

fn bare(shape: Shape) -> Value {
    match shape {
        Shape::Number => json!({ "type": "number" }),
        Shape::Numbers(n) => {
            json!({ "type": "array", "items": { "type": "number" }, "minItems": n, "maxItems": n })
        }
        Shape::Integer => json!({ "type": "integer" }),
        Shape::Boolean => json!({ "type": "boolean" }),
        Shape::Text => json!({ "type": "string" }),
        Shape::Other => json!({}),
    }
}
