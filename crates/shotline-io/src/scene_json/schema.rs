//! The JSON Schema of scene files, made from the tables that the reader itself uses.

use serde_json::{Map, Value, json};
use shotline::solid::{self, ParamType};

use super::keys::{CAMERA, Key, LIGHT, MATERIAL, MESH, MESH_FILE, OBJECT, OPS, PLACEMENT, ROTATION, TOP};
use super::values::Shape;

/// The schema as text, as published in `docs/scene.schema.json`.
pub fn scene_schema() -> String {
    let mut definitions = Map::new();
    definitions.insert("shape".into(), shape());
    definitions.insert("object".into(), object());
    let object = closed(vec![OBJECT, PLACEMENT], &["node"], override_node());
    let member = json!({ "if": { "required": ["node"] }, "then": object, "else": reference("shape") });
    definitions.insert("member".into(), member);
    definitions.insert("material".into(), closed(vec![MATERIAL], &[], Map::new()));
    definitions.insert("light".into(), light());
    let (known, refs) = top();
    let mut schema = closed(known, &["shotline"], refs);
    schema["$schema"] = json!("https://json-schema.org/draft/2020-12/schema");
    schema["title"] = json!("shotline scene");
    schema["description"] = json!("Comments and trailing commas are allowed. See docs/scene-format.md.");
    schema["$defs"] = Value::Object(definitions);
    format!("{schema:#}\n")
}

fn top() -> (Vec<&'static [Key]>, Map<String, Value>) {
    let named = |what: &str| json!({ "type": "object", "additionalProperties": reference(what) });
    let mut camera = closed(vec![CAMERA], &["eye", "target"], Map::new());
    camera["not"] = json!({ "required": ["fov", "height"] });
    let reusable = json!({ "anyOf": [reference("object"), closed(vec![], &["ref"], part_name())] });
    let refs = [
        ("shotline", json!({ "const": 1 })),
        ("defs", named("member")),
        ("objects", json!({ "type": "array", "items": reusable })),
        ("materials", named("material")),
        ("camera", camera),
        ("lights", json!({ "type": "array", "items": reference("light") })),
    ];
    (vec![TOP], refs.map(|(key, value)| (key.to_string(), value)).into_iter().collect())
}

fn object() -> Value {
    closed(vec![OBJECT], &["node"], override_node())
}

fn override_node() -> Map<String, Value> {
    [("node".to_string(), reference("shape"))].into_iter().collect()
}

fn part_name() -> Map<String, Value> {
    [("ref".to_string(), json!({ "type": "string", "description": "The name of a part in defs." }))]
        .into_iter()
        .collect()
}

fn light() -> Value {
    let mut light = closed(vec![LIGHT], &[], Map::new());
    light["oneOf"] =
        json!([{ "required": ["point"] }, { "required": ["direction"] }, { "required": ["ambient"] }]);
    light["properties"]["ambient"]["const"] = json!(true);
    light
}

/// Leaves of every kind, operations and references. Each form is looked at only if its key says so: with `oneOf` a
/// validator would try every operation at every level of a nest, which takes ages.
fn shape() -> Value {
    let leaves = solid::KINDS.iter().map(|kind| when("kind", json!({ "const": kind.name }), leaf(kind)));
    let mut forms: Vec<Value> = leaves.collect();
    forms.push(when("kind", json!({ "const": MESH }), mesh()));
    forms.extend(OPS.iter().map(|(op, about)| when("op", json!({ "const": op }), operation(op, about))));
    forms.push(when("ref", json!({}), placed(&[], &["ref"], part_name(), "A part of defs.")));
    let kinds: Vec<_> = solid::KINDS.iter().map(|k| k.name).chain([MESH]).collect();
    let ops: Vec<_> = OPS.iter().map(|(op, _)| *op).collect();
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
        let shape = match param.ty {
            ParamType::Number => Shape::Number,
            ParamType::Numbers(n) => Shape::Numbers(n),
        };
        own.insert(param.name.into(), described(shape, param.summary));
    }
    let required: Vec<&str> = ["kind"].into_iter().chain(kind.params.iter().map(|p| p.name)).collect();
    placed(&[], &required, own, kind.summary)
}

fn mesh() -> Value {
    let own = [("kind".to_string(), json!({ "const": MESH }))].into_iter().collect();
    placed(std::slice::from_ref(&MESH_FILE), &["kind", MESH_FILE.name], own, "A triangle mesh from a file.")
}

fn operation(op: &str, about: &str) -> Value {
    let (item, least) = if op == "group" { ("member", 0) } else { ("shape", 1) };
    let args = json!({ "type": "array", "items": reference(item), "minItems": least });
    let own = [("op".to_string(), json!({ "const": op })), ("args".to_string(), args)].into_iter().collect();
    placed(&[], &["op", "args"], own, about)
}

/// An object that may also carry a placement: a matrix or steps.
fn placed(keys: &'static [Key], required: &[&str], own: Map<String, Value>, about: &str) -> Value {
    let mut schema = closed(vec![keys, PLACEMENT], required, own);
    schema["description"] = json!(about);
    schema
}

/// An object with these keys and no others; `own` adds keys and replaces the schemas of some.
fn closed(keys: Vec<&'static [Key]>, required: &[&str], own: Map<String, Value>) -> Value {
    let mut properties = Map::new();
    let mut steps_or_matrix = false;
    for key in keys.into_iter().flatten() {
        let mut schema = match key.name {
            "scale" => json!({ "anyOf": [bare(Shape::Number), bare(Shape::Numbers(3))] }),
            "rotate" => {
                json!({ "anyOf": [bare(Shape::Numbers(3)), closed(vec![ROTATION], &["axis", "degrees"], Map::new())] })
            }
            _ => bare(key.shape),
        };
        schema["description"] = json!(key.about);
        steps_or_matrix |= key.name == "transform";
        properties.insert(key.name.into(), schema);
    }
    for (key, mut schema) in own {
        if let Some(about) = properties.get(&key).and_then(|known| known.get("description"))
            && schema.get("description").is_none()
        {
            schema["description"] = about.clone();
        }
        properties.insert(key, schema);
    }
    let mut schema = json!({ "type": "object", "properties": properties, "additionalProperties": false });
    if !required.is_empty() {
        schema["required"] = json!(required);
    }
    if steps_or_matrix {
        schema["dependentSchemas"] = json!({ "transform": { "not": { "anyOf": [
            { "required": ["scale"] }, { "required": ["rotate"] }, { "required": ["translate"] },
        ] } } });
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
