//! The published schema and the table of kinds are those that the code generates, and the schema agrees with the
//! reader.

use std::path::{Path, PathBuf};

use serde_json::Value;
use shotline::solid::{KINDS, Kind, Layout, Param};
use shotline_io::{load, parse_scene, scene_schema};

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

#[test]
fn the_published_schema_is_up_to_date() {
    let path = repository().join("docs/scene.schema.json");
    if std::env::var_os("UPDATE_SCHEMA").is_some() {
        std::fs::write(&path, scene_schema()).unwrap();
    }
    let published = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        published == scene_schema(),
        "run the tests with UPDATE_SCHEMA=1 to update docs/scene.schema.json"
    );
}

/// A validator for the keywords of JSON Schema that the scene schema uses. A complete implementation would add about
/// seventy crates.
struct Schema(Value);

impl Schema {
    fn published() -> Schema {
        Schema(serde_json::from_str(&scene_schema()).unwrap())
    }

    fn is_valid(&self, value: &Value) -> bool {
        self.accepts(&self.0, value)
    }

    fn accepts(&self, schema: &Value, value: &Value) -> bool {
        let rules = schema.as_object().expect("a schema is an object");
        rules.iter().all(|(rule, operand)| self.holds(rule, operand, schema, value))
    }

    fn holds(&self, rule: &str, operand: &Value, schema: &Value, value: &Value) -> bool {
        let count = |schemas: &Value| each(schemas).filter(|s| self.accepts(s, value)).count();
        let all_items = |schema: &Value| each(value).all(|item| self.accepts(schema, item));
        let length = value.as_array().map(|a| a.len() as u64);
        match rule {
            "$schema" | "title" | "description" | "default" | "$defs" => true,
            "$ref" => self.accepts(self.0.pointer(&operand.as_str().unwrap()[1..]).unwrap(), value),
            "type" => is_of_type(value, operand.as_str().unwrap()),
            "const" => value == operand,
            "enum" => each(operand).any(|known| known == value),
            "if" => {
                let branch = if self.accepts(operand, value) { "then" } else { "else" };
                schema.get(branch).is_none_or(|s| self.accepts(s, value))
            }
            "then" | "else" => true,
            "allOf" => each(operand).all(|s| self.accepts(s, value)),
            "anyOf" => count(operand) > 0,
            "oneOf" => count(operand) == 1,
            "not" => !self.accepts(operand, value),
            "items" => all_items(operand),
            "minItems" => length.is_none_or(|n| n >= operand.as_u64().unwrap()),
            "maxItems" => length.is_none_or(|n| n <= operand.as_u64().unwrap()),
            "required" => each(operand).all(|key| value.get(key.as_str().unwrap()).is_some()),
            "properties" => {
                members(operand).all(|(key, s)| value.get(key).is_none_or(|v| self.accepts(s, v)))
            }
            "dependentSchemas" => {
                members(operand).all(|(key, s)| value.get(key).is_none() || self.accepts(s, value))
            }
            "additionalProperties" => members(value)
                .filter(|(key, _)| schema.get("properties").and_then(|known| known.get(key)).is_none())
                .all(|(_, v)| {
                    if operand.is_object() { self.accepts(operand, v) } else { operand == &Value::Bool(true) }
                }),
            _ => panic!("the schema uses the rule '{rule}', which is not checked here"),
        }
    }
}

fn each(array: &Value) -> impl Iterator<Item = &Value> {
    array.as_array().into_iter().flatten()
}

fn members(object: &Value) -> impl Iterator<Item = (&String, &Value)> {
    object.as_object().into_iter().flatten()
}

fn is_of_type(value: &Value, name: &str) -> bool {
    match name {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "boolean" => value.is_boolean(),
        "number" => value.is_number(),
        "integer" => value.as_f64().is_some_and(|x| x.fract() == 0.0),
        _ => panic!("unknown type '{name}'"),
    }
}

/// The table of the kinds of solids, from their declarations.
fn table_of_kinds() -> String {
    let numbers = |values: &[f64]| values.iter().map(f64::to_string).collect::<Vec<_>>().join(", ");
    let parameter = |p: &Param| {
        let count = match p.layout {
            Layout::Numbers(1) => String::new(),
            Layout::Numbers(count) => format!(" [{count}]"),
            Layout::Rows { columns, .. } => format!(" [[{}], ...]", columns.join(", ")),
        };
        format!("`{}`{count}{}", p.name, p.default.map_or(String::new(), |d| format!(" = {}", numbers(d))))
    };
    let row = |kind: &&Kind| {
        let parameters: Vec<_> = kind.params.iter().map(parameter).collect();
        format!("| `{}` | {} | {} |\n", kind.name, parameters.join(", "), kind.interior)
    };
    let head = "| kind | parameters | interior |\n|---|---|---|\n";
    head.to_owned() + &KINDS.iter().map(row).collect::<String>()
}

/// If `UPDATE_SCHEMA` is set, the table is written.
#[test]
fn the_page_of_the_format_has_the_table_of_kinds_and_a_valid_example() {
    let path = repository().join("docs/scene-format.md");
    let page = std::fs::read_to_string(&path).unwrap();
    let example = page.split("```jsonc\n").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    parse_scene(example, None).unwrap_or_else(|e| panic!("{e}"));
    let start = page.find("| kind | parameters").expect("the table of kinds");
    let end = start + page[start..].find("\n\n").expect("its end") + 1;
    if std::env::var_os("UPDATE_SCHEMA").is_some() {
        std::fs::write(&path, [&page[..start], &table_of_kinds(), &page[end..]].concat()).unwrap();
    } else {
        assert_eq!(page[start..end], table_of_kinds(), "UPDATE_SCHEMA=1 writes the table");
    }
}

#[test]
fn the_example_scenes_are_valid() {
    let schema = Schema::published();
    for entry in std::fs::read_dir(repository().join("scenes")).into_iter().flatten() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|e| e != "json") {
            continue;
        }
        let document = load(&path).unwrap_or_else(|e| panic!("{e}"));
        // The writer removes comments, which plain JSON does not allow.
        let plain: Value = serde_json::from_str(&shotline_io::write_scene(&document.scene).unwrap()).unwrap();
        assert!(schema.is_valid(&plain), "{}", path.display());
    }
}

#[test]
fn the_schema_and_the_reader_agree() {
    let schema = Schema::published();
    let ball = r#"{"kind": "sphere", "radius": 1}"#;
    let good = [
        r#"{"shotline": 1}"#.to_string(),
        format!(r#"{{"shotline": 1, "units": "mm", "objects": [{{"node": {ball}}}]}}"#),
        format!(r#"{{"shotline": 1, "defs": {{"a": {ball}, "b": {{"node": {ball}}}}}, "objects": [{{"ref": "b"}}]}}"#),
        format!(r#"{{"shotline": 1, "defs": {{"a": {{"op": "group", "args": [{{"node": {ball}, "scale": 2}}, {ball}]}}}}}}"#),
        r#"{"shotline": 1, "defs": {"a": {"kind": "sphere", "radius": 1, "rotate": {"axis": [0,0,1], "degrees": 9}}}}"#.into(),
        r#"{"shotline": 1, "lights": [{"ambient": true}], "camera": {"eye": [0,0,1], "target": [0,0,0], "fov": 9}}"#.into(),
    ];
    let bad = [
        "{}".to_string(),
        r#"{"shotline": 2}"#.into(),
        r#"{"shotline": 1, "object": []}"#.into(),
        r#"{"shotline": 1, "objects": [{"kind": "sphere", "radius": 1}]}"#.into(),
        r#"{"shotline": 1, "defs": {"a": {"kind": "sphere"}}}"#.into(),
        r#"{"shotline": 1, "defs": {"a": {"kind": "spere", "radius": 1}}}"#.into(),
        r#"{"shotline": 1, "defs": {"a": {"kind": "sphere", "radius": "1"}}}"#.into(),
        r#"{"shotline": 1, "defs": {"a": {"kind": "sphere", "radius": 1, "center": [0,0,0]}}}"#.into(),
        r#"{"shotline": 1, "defs": {"a": {"op": "union", "args": []}}}"#.into(),
        format!(r#"{{"shotline": 1, "defs": {{"a": {{"op": "union", "args": [{{"node": {ball}}}]}}}}}}"#),
        r#"{"shotline": 1, "defs": {"a": {"kind": "sphere", "radius": 1, "transform": [1,0,0,0,0,1,0,0,0,0,1,0], "scale": 2}}}"#.into(),
        r#"{"shotline": 1, "lights": [{"point": [0,0,0], "ambient": true}]}"#.into(),
        r#"{"shotline": 1, "camera": {"eye": [0,0,1], "target": [0,0,0], "fov": 9, "height": 9}}"#.into(),
    ];
    for text in &good {
        let value: Value = serde_json::from_str(text).unwrap();
        assert!(schema.is_valid(&value), "{text}");
        assert!(parse_scene(text.as_str(), None).is_ok(), "{text}");
    }
    for text in &bad {
        assert!(!schema.is_valid(&serde_json::from_str(text).unwrap()), "{text}");
        assert!(parse_scene(text.as_str(), None).is_err(), "{text}");
    }
}
