//! Scene files: what is read, what is refused, and with which messages.

use std::path::Path;

use shotline::compile::{Options, compile};
use shotline::math::Vec3;
use shotline::scene::{Lens, LightSource, LocalTransform, Node, NodeId, Rotation, Units};
use shotline_io::{Document, Effect, Location, load, parse_scene};

fn read(text: &str) -> Document {
    parse_scene(text, None).unwrap_or_else(|e| panic!("{e}"))
}

fn refused(text: &str) -> String {
    parse_scene(text, None).expect_err(text).to_string()
}

/// A file with these objects.
fn scene(objects: &str) -> String {
    format!("{{\"shotline\": 1, \"objects\": [{objects}]}}")
}

const BALL: &str = r#"{"kind": "sphere", "radius": 1}"#;

#[test]
fn references_share_nodes() {
    let document = read(
        r#"{ "shotline": 1,
             "defs": { "later": { "op": "union", "args": [{ "ref": "ball" }, { "ref": "ball" }] },
                       "ball": { "kind": "sphere", "radius": 2 }, "alias": { "ref": "ball" } },
             "objects": [ { "node": { "ref": "later" } }, { "node": { "ref": "alias", "translate": [1, 2, 3] } } ] }"#,
    );
    let scene = &document.scene;
    let [(_, later), (_, ball), (_, alias)] = scene.defs[..] else { panic!() };
    assert_eq!(ball, alias);
    assert!(matches!(scene.node(later), Node::Csg { args, .. } if *args == [ball, ball]));
    let Node::Object { name, node, .. } = scene.node(scene.objects[1]) else { panic!() };
    assert_eq!(name, "object1");
    assert!(matches!(scene.node(*node), Node::Transform { child, .. } if *child == ball));
}

#[test]
fn every_section_is_read() {
    let document = read(
        r#"{ "shotline": 1, "$schema": "scene.schema.json", "units": "mm",
             "objects": [ { "name": "a", "material": "steel", "priority": -3,
                            "node": { "kind": "sphere", "radius": 1, "scale": 2,
                                      "rotate": { "axis": [0, 0, 2], "degrees": 30 } } } ],
             "materials": { "steel": { "mu": 0.5, "density": 7.8, "color": [0, 0.5, 1], "specular": 0.25,
                                       "shininess": 20, "mirror": 0 }, "air": {} },
             "camera": { "eye": [0, 0, 5], "target": [0, 0, 0], "height": 3 },
             "lights": [ { "direction": [0, 0, -1], "color": [1, 1, 0] }, { "ambient": true, "intensity": 0.1 } ] }"#,
    );
    let scene = document.scene;
    assert_eq!(scene.units, Some(Units::Millimetres));
    assert_eq!(scene.materials[0].1.density, Some(7.8));
    let camera = scene.camera.unwrap();
    assert_eq!((camera.up, camera.lens), (Vec3::Y, Lens::Orthographic { height: 3.0 }));
    assert_eq!(scene.lights[1].source, LightSource::Ambient);
    let Node::Object { priority: -3, node, .. } = scene.nodes[scene.objects[0].0 as usize] else { panic!() };
    let Node::Transform { transform, .. } = scene.nodes[node.0 as usize] else { panic!() };
    let about = Rotation::About { axis: Vec3::new(0.0, 0.0, 2.0), degrees: 30.0 };
    let steps = LocalTransform::Steps { scale: Some(Vec3::splat(2.0)), rotate: Some(about), translate: None };
    assert_eq!(transform, steps);
}

#[test]
fn groups_may_contain_objects_and_default_names_count_all_objects() {
    let group = format!(r#"{{"op": "group", "args": [{{"node": {BALL}, "translate": [1, 0, 0]}}, {BALL}]}}"#);
    let document = read(&scene(&format!(r#"{{"node": {group}}}, {{"name": "x", "node": {BALL}}}"#)));
    let names = document.scene.nodes.iter().filter_map(|n| match n {
        Node::Object { name, .. } => Some(name.as_str()),
        _ => None,
    });
    assert_eq!(names.collect::<Vec<_>>(), ["object0", "x", "object2"]);
    compile(&document.scene, Options::default()).unwrap();
}

#[test]
fn deep_nests_are_read() {
    for depth in [500, 5000] {
        let open = r#"{"op": "difference", "args": ["#.repeat(depth);
        let nest = format!("{open}{BALL}{}", format!(", {BALL}]}}").repeat(depth));
        let document = read(&scene(&format!("{{\"node\": {nest}}}")));
        assert_eq!(document.scene.nodes.len(), 2 * depth + 2);
        let text = shotline_io::write_scene(&document.scene).unwrap();
        assert_eq!(read(&text).scene.nodes.len(), 2 * depth + 2);
    }
    let bomb = scene(&r#"{"op": "union", "args": ["#.repeat(1_000_000));
    assert!(refused(&bomb).contains("nested more than 20000 deep"));
}

#[test]
fn every_mistake_is_reported_with_location_and_help() {
    let text = r#"{
  "shotline": 1,
  "objects": [
    { "node": { "kind": "sphere", "raduis": 2 } },
    { "node": { "kind": "spere", "radius": 2 }, "materal": "steel" },
    { "node": { "op": "intersecton", "args": [{ "ref": "bal" }] } },
    { "node": { "kind": "sphere", "radius": [1, 2] }, "material": "stel" },
    { "node": { "kind": "sphere", "radius": NaN } }
  ],
  "defs": { "ball": { "kind": "sphere", "radius": 1, "transform": [1], "scale": 2 } },
  "materials": { "steel": { "mu": -1 } }
}"#;
    let shown = refused(text);
    let expected = [
        "4:35: a sphere has no key 'raduis'\n        { \"node\": { \"kind\": \"sphere\", \"raduis\": 2 } },\n                                      ^^^^^^^^\nhelp: did you mean 'radius'?",
        "5:25: there is no kind 'spere'",
        "help: did you mean 'sphere'?",
        "5:49: an object has no key 'materal'",
        "help: did you mean 'material'?",
        "6:23: there is no operation 'intersecton'",
        "help: did you mean 'intersection'?",
        "6:56: there is no 'bal' in \"defs\"",
        "help: did you mean 'ball'?",
        "7:45: radius must be a number, not an array of 2",
        "7:67: there is no 'stel' in \"materials\"",
        "help: did you mean 'steel'?",
        "8:45: NaN is not a number",
        "10:67: \"transform\" must be an array of 12 numbers, not an array of 1",
        "10:81: this node has a \"transform\" as well",
        "11:35: \"mu\" is -1",
    ];
    assert!(!shown.contains("lacks"), "a mistyped key is not missing as well:\n{shown}");
    for fragment in expected {
        assert!(shown.contains(fragment), "{fragment}\nis not in\n{shown}");
    }
}

#[test]
fn mistakes_are_explained() {
    let cases = [
        (r#"{"objects": []}"#, "lacks \"shotline\": 1"),
        (r#"{"shotline": 2}"#, "version 2"),
        ("[]", "a scene must be an object"),
        (r#"{"shotline": 1, "shotline": 1}"#, "stands here twice"),
        (r#"{"shotline": 1, "object": []}"#, "did you mean 'objects'?"),
        (r#"{"shotline": 1} {}"#, "something follows the end"),
        (r#"{"shotline": 1, "units": "\ud800"}"#, "surrogate"),
        (r#"{"shotline": 1, "units": 5}"#, "\"units\" must be a string, not a number"),
        (r#"{"shotline": 1, "defs": {"a": {"ref": "b"}, "b": {"ref": "a"}}}"#, "only refer to one another"),
        (r#"{"shotline": 1, "defs": {"a": {"ref": "a"}}}"#, "only refer to one another"),
        (r#"{"shotline": 1, "camera": {"eye": [0,0,0], "target": [0,0,0]}}"#, "stands at its own target"),
        (
            r#"{"shotline": 1, "camera": {"eye": [0,0,1], "target": [0,0,0], "fov": 180}}"#,
            "below 180 degrees",
        ),
        (r#"{"shotline": 1, "lights": [{"color": [1, 1, 2]}]}"#, "exactly one source"),
        (r#"{"shotline": 1, "lights": [{"ambient": false}]}"#, "can only be true"),
        (r#"{"shotline": 1, "materials": {"a": {"color": [1, 1, 2]}}}"#, "the component 2"),
    ];
    for (text, message) in cases {
        let shown = refused(text);
        assert!(shown.contains(message), "{message}\nis not in\n{shown}");
    }
    let nodes = [
        (r#"{"sphere": {"radius": 1}}"#, r#"write {"kind": "sphere", ...}"#),
        (r#"{"type": "sphere", "radius": 1}"#, "write \"kind\" instead of \"type\""),
        (r#"{"union": []}"#, r#"write {"op": "union", "args": [...]}"#),
        (r#"{"knid": "sphere"}"#, "did you mean 'kind' instead of 'knid'?"),
        (r#"{"kind": "sphere", "op": "union"}"#, "both \"kind\" and \"op\""),
        (r#"{"kind": "sphere", "radius": 1, "center": [0, 0, 0]}"#, "\"translate\": [x, y, z]"),
        (r#"{"kind": "sphere", "radius": 1e400}"#, "1e400 is too large"),
        (r#"{"kind": "sphere", "radius": "1"}"#, "radius must be a number, not a string"),
        (r#"{"op": "union", "args": []}"#, "has no args"),
        (r#"{"op": "union", "args": [{"node": {}}]}"#, "an object cannot stand here"),
        (r#"{"ref": "x"}"#, "there is no 'x' in \"defs\""),
        (r#"{"ref": "x", "radius": 1}"#, "a reference has no key 'radius'"),
        (
            r#"{"kind": "sphere", "radius": 1, "rotate": {"axis": [0, 0, 0], "degrees": 5}}"#,
            "axis of this rotation is zero",
        ),
        (r#"{"kind": "sphere"}"#, "this sphere lacks \"radius\""),
        (r#"{"kind": "sphere"}"#, "help: add \"radius\", a number: "),
        (r#"{"kind": "box", "min": [0, 0, 0]}"#, "help: add \"max\", three numbers [x, y, z]: "),
        (r#"{"op": "union"}"#, "help: add \"args\", a list of nodes"),
        (r#"{"args": []}"#, "needs \"kind\", \"op\" or \"ref\""),
        ("5", "a node must be an object { ... }, not a number"),
        (r#"{"kind": "mesh", "file": "a.ply"}"#, "has no folder"),
    ];
    for (node, message) in nodes {
        let shown = refused(&scene(&format!("{{\"node\": {node}}}")));
        assert!(shown.contains(message), "{message}\nis not in\n{shown}");
    }
    let mistyped = refused(&scene(r#"{"node": {"op": "differnce", "args": []}}"#));
    assert!(mistyped.contains("did you mean 'difference'?") && !mistyped.contains("no args"), "{mistyped}");
    let wrapped = refused(&scene(BALL));
    assert!(
        wrapped.contains("an object needs \"node\"") && wrapped.contains("help: an object is"),
        "{wrapped}"
    );
}

#[test]
fn errors_of_the_compiler_are_located_in_the_file() {
    let document = read(
        r#"{ "shotline": 1,
  "defs": { "a": { "op": "union", "args": [{ "ref": "b" }] }, "b": { "op": "union", "args": [{ "ref": "a" }] } },
  "objects": [
    { "node": { "kind": "sphere", "radius": -1 } },
    { "node": { "kind": "sphere", "radius": 1, "scale": [1, 0, 1] } },
    { "node": { "ref": "a" } }
  ] }"#,
    );
    let errors = compile(&document.scene, Options::default()).unwrap_err();
    let shown = document.diagnostics(&errors).to_string();
    assert!(shown.contains("contains itself"), "{shown}");
    let sound =
        read(&document.source.text().replace(r#""ref": "a" }] }"#, r#""kind": "sphere", "radius": 3 }] }"#));
    let errors = compile(&sound.scene, Options::default()).unwrap_err();
    let shown = sound.diagnostics(&errors);
    let locations = shown.diagnostics.iter().map(|p| match &p.location {
        Location::Text { line, column, .. } => (*line, *column),
        other => panic!("{other:?}"),
    });
    assert_eq!(locations.collect::<Vec<_>>(), [(4, 45), (5, 57)], "{shown}");
}

#[test]
fn nodes_and_parameters_are_found_in_the_text() {
    let text = scene(&format!("{{\"node\": {BALL}}}"));
    let document = read(&text);
    let leaf = document.scene.nodes.iter().position(|n| matches!(n, Node::Solid { .. })).unwrap();
    let leaf = NodeId(leaf as u32);
    assert_eq!(&text[document.source.find(leaf, None).unwrap()], BALL);
    assert_eq!(&text[document.source.find(leaf, Some("radius")).unwrap()], "1");
}

const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                   element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

fn load_with_mesh(folder: &Path, file: &str) -> Result<Document, String> {
    let node = serde_json::json!({ "kind": "mesh", "file": file });
    let path = folder.join("scene.json");
    std::fs::write(&path, scene(&format!("{{\"node\": {node}}}, {{\"node\": {node}}}"))).unwrap();
    load(&path).map_err(|e| e.to_string())
}

#[test]
fn mesh_files_must_be_in_the_folder_of_the_scene() {
    let outer = tempfile::tempdir().unwrap();
    let folder = outer.path().join("scenes");
    std::fs::create_dir_all(folder.join("parts/empty.ply")).unwrap();
    for file in ["secret.ply", "scenes/a.ply", "scenes/parts/b.ply"] {
        std::fs::write(outer.path().join(file), PLY).unwrap();
    }
    std::fs::write(folder.join("bad.ply"), PLY.replace("3 0 1 2", "3 0 1 7")).unwrap();
    for file in ["a.ply", "./a.ply", "parts/b.ply", "parts/../a.ply"] {
        let document = load_with_mesh(&folder, file).unwrap();
        let meshes = document.scene.nodes.iter().filter_map(|n| match n {
            Node::Mesh { mesh, .. } => Some(mesh),
            _ => None,
        });
        let [a, b] = meshes.collect::<Vec<_>>()[..] else { panic!() };
        assert!(std::sync::Arc::ptr_eq(a, b));
    }
    let secret = outer.path().join("secret.ply");
    let cases = [
        ("../secret.ply", "outside of the scene's folder"),
        ("parts/../../secret.ply", "outside of the scene's folder"),
        (secret.to_str().unwrap(), "path of this file is absolute"),
        ("C:\\secret.ply", "path of this file is absolute"),
        ("\\\\host\\share\\a.ply", "path of this file is absolute"),
        ("none.ply", "'none.ply' cannot be opened"),
        ("a\u{0}.ply", "cannot be opened"),
        ("parts/empty.ply", "parts/empty.ply is a folder"),
        ("scene.json", "is a scene, not a mesh"),
        ("bad.ply", "bad.ply:13:1: face 0 names vertex 7, but there are 3"),
    ];
    for (file, message) in cases {
        let shown = load_with_mesh(&folder, file).expect_err(file);
        assert!(shown.contains(message), "{message}\nis not in\n{shown}");
        assert!(shown.contains("scene.json:1:"), "{shown}");
    }
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(&secret, folder.join("link.ply")).unwrap();
        assert!(load_with_mesh(&folder, "link.ply").unwrap_err().contains("outside"));
    }
}

#[test]
fn long_chains_and_many_mistakes_are_fast() {
    let chain: String = (0..30_000).map(|i| format!("\"p{i}\": {{\"ref\": \"p{}\"}}, ", i + 1)).collect();
    let file = |last: &str| format!("{{\"shotline\": 1, \"defs\": {{{chain}\"p30000\": {last}}}}}");
    assert_eq!(read(&file(BALL)).scene.nodes.len(), 1);
    assert!(refused(&file("{\"ref\": \"p7\"}")).contains("only refer to one another"));
    let unknown = refused(&file("{\"ref\": \"x\"}"));
    assert_eq!(unknown.matches("there is no 'x'").count(), 1);
    let wrong = "{\"node\": {\"ref\": \"y\", \"scale\": 1}},".repeat(30_000);
    let shown = refused(&format!(
        "{{\"shotline\": 1, \"defs\": {{{chain}\"p30000\": {BALL}}}, \"objects\": [{wrong}]}}"
    ));
    assert!(shown.ends_with("and 29900 more"));
}

#[test]
fn accelerators_are_chosen_by_name() {
    let scene = |accel: &str| {
        format!(
            r#"{{ "shotline": 1, "accel": "grid", "objects": [ {{ "node": {{ "op": "union", "accel": "{accel}",
                "args": [ {{ "kind": "sphere", "radius": 1 }} ] }} }} ] }}"#
        )
    };
    let read = parse_scene(scene("octree"), None).unwrap().scene;
    assert_eq!((read.accel, read.accels.into_values().collect::<Vec<_>>()), (Some("grid"), vec!["octree"]));
    let error = parse_scene(scene("octre"), None).unwrap_err().to_string();
    assert!(
        error.contains("no accelerator named 'octre'") && error.contains("did you mean 'octree'?"),
        "{error}"
    );
}

#[test]
fn lists_are_arrays_of_rows() {
    let polycone =
        |planes: &str| scene(&format!(r#"{{"node": {{"kind": "polycone", "planes": {planes}}}}}"#));
    let document = read(&polycone("[[0, 1, 2], [1, 1, 3]]"));
    let Node::Object { node, .. } = document.scene.node(document.scene.objects[0]) else { panic!() };
    let Node::Solid { params, .. } = document.scene.node(*node) else { panic!() };
    assert_eq!(params.entries[0].1[..], [0.0, 1.0, 2.0, 1.0, 1.0, 3.0]);
    let written = shotline_io::write_scene(&document.scene).expect("a scene");
    assert!(written.contains("\"planes\": [[0, 1, 2], [1, 1, 3]]"), "{written}");
    for (planes, message) in [
        ("[[0, 1, 2]]", "planes must be an array of at least 2 rows [z, rmin, rmax], not an array of 1"),
        ("[[0, 1, 2], [1, 1]]", "row 2 of planes must be an array of 3 numbers, not an array of 2"),
        ("[[0, 1, 2], [1, \"1\", 3]]", "each of row 2 of planes must be a number, not a string"),
        ("5", "planes must be an array of at least 2 rows [z, rmin, rmax], not a number"),
    ] {
        let found = refused(&polycone(planes));
        assert!(found.contains(message), "{found}");
    }
}

#[test]
fn duplicate_object_names_are_noted_with_the_first_location() {
    let ball = r#""node": { "kind": "sphere", "radius": 1 } }"#;
    let twice = format!(
        "{{ \"shotline\": 1, \"objects\": [\n  {{ \"name\": \"a\", {ball},\n  {{ \"name\": \"b\", {ball},\n  {{\n    \"name\": \"a\", {ball},\n  \
         {{ \"name\": \"a\", {ball}\n] }}"
    );
    let notes = parse_scene(twice, None).unwrap().notes;
    let shown = "2 objects have the name of an earlier one, and each such name stands for all that have it, the first 'a' on \
                 line 5";
    assert_eq!(notes.iter().map(ToString::to_string).collect::<Vec<_>>(), [shown]);
    assert_eq!((notes[0].kind, notes[0].count, notes[0].effect), ("duplicate_names", 2, Effect::Kept));
    // Default names count too. An object that is placed twice is one object.
    let given =
        format!("{{ \"shotline\": 1, \"objects\": [ {{ \"name\": \"object1\", {ball},\n  {{ {ball} ] }}");
    let notes = parse_scene(given, None).unwrap().notes;
    assert_eq!(
        notes[0].to_string(),
        "the name 'object1' stands for 2 objects: it is given a second time, on line 2"
    );
    let shared = format!(
        r#"{{ "shotline": 1, "defs": {{ "d": {{ "name": "a", {ball} }}, "objects": [ {{ "name": "all", "node":
            {{ "op": "group", "args": [ {{ "ref": "d" }}, {{ "ref": "d", "translate": [3, 0, 0] }} ] }} }} ] }}"#
    );
    assert_eq!(parse_scene(shared, None).unwrap().notes, []);
}
