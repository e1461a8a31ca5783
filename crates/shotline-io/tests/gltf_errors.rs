//! Wrong glTF files: each is refused with what is wrong, where, and how to mend it, or read with a note; none panics.

mod glb;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use glb::{Glb, cube, cube_file, pack};
use serde_json::{Value, json};
use shotline::testkit::random::Random;
use shotline_io::{Location, ReadOptions, load_bytes};

fn message(bytes: Vec<u8>) -> Option<String> {
    match load_bytes(Path::new("part.glb"), bytes, ReadOptions::default()) {
        Ok(_) => None,
        Err(error) => {
            assert!(error.diagnostics.iter().all(|found| found.help.is_some()), "{error}");
            Some(error.to_string())
        }
    }
}

#[track_caller]
fn expect(bytes: Vec<u8>, says: &str) {
    let message = message(bytes).expect(says);
    assert!(message.contains(says), "{says}: {message}");
}

/// A file of a cube whose JSON is changed.
fn changed(change: impl FnOnce(&mut Value, &mut Glb)) -> Vec<u8> {
    let mut glb = Glb::default();
    let (attributes, order) = cube(&mut glb);
    let mut json = glb.json(json!({
        "meshes": [{ "name": "cube", "primitives": [{ "attributes": attributes, "indices": order, "material": 0 }] }],
        "nodes": [{ "mesh": 0, "name": "a" }, { "children": [0] }],
        "scenes": [{ "nodes": [1] }], "scene": 0, "materials": [{}],
    }));
    change(&mut json, &mut glb);
    pack(&json.to_string(), &glb.bin)
}

/// Sets the value at a pointer of the JSON.
fn set(pointer: &str, value: Value) -> Vec<u8> {
    changed(|json, _| {
        let (parent, key) = pointer.rsplit_once('/').unwrap();
        let parent = json.pointer_mut(parent).unwrap_or_else(|| panic!("{pointer}"));
        match key.parse::<usize>() {
            Ok(index) => parent[index] = value,
            Err(_) => parent[key] = value,
        }
    })
}

/// What is set, and what the error says.
fn wrong_values() -> Vec<(&'static str, Value, &'static str)> {
    vec![
        ("/asset", json!(null), "the file has no \"asset\""),
        ("/asset/version", json!("1.0"), "this is version 1.0 of glTF"),
        ("/asset/version", json!(2), "the version of glTF must be a string"),
        ("/asset/minVersion", json!("2.1"), "this is version 2.1 of glTF"),
        (
            "/extensionsRequired",
            json!(["KHR_draco_mesh_compression"]),
            "requires the extension KHR_draco_mesh_compression",
        ),
        (
            "/extensionsRequired",
            json!(["EXT_meshopt_compression"]),
            "requires the extension EXT_meshopt_compression",
        ),
        ("/extensionsRequired", json!([7]), "each of \"extensionsRequired\" must be a string, not a number"),
        ("/buffers/0/byteLength", json!(1e6), "buffer 0 has"),
        ("/buffers/0/byteLength", json!(-4), "\"byteLength\" must be a whole number of at least 0, not -4"),
        ("/buffers/0/byteLength", json!(null), "buffer 0 has no \"byteLength\""),
        ("/buffers", json!([{ "byteLength": 0 }, { "byteLength": 4 }]), "buffer 1 has no \"uri\""),
        ("/buffers", json!({}), "\"buffers\" must be an array"),
        ("/bufferViews/0/byteOffset", json!(1e9), "ends behind the"),
        ("/bufferViews/0/byteOffset", json!(8e15), "ends behind the"),
        ("/bufferViews/0/byteLength", json!(1e9), "buffer view 0 of 1000000000 bytes"),
        (
            "/bufferViews/0/byteLength",
            json!(8),
            "24 values from byte 0 on end behind the 8 bytes of the buffer view",
        ),
        ("/bufferViews/0/buffer", json!(3), "of buffer 3"),
        ("/bufferViews/0/byteStride", json!(4), "its values of 12 bytes begin every 4 bytes"),
        ("/bufferViews/0/byteStride", json!(252), "24 values from byte 0 on end behind"),
        ("/bufferViews/0/byteStride", json!(0), "begin every 0 bytes"),
        ("/accessors/0/byteOffset", json!(4), "24 values from byte 4 on end behind"),
        ("/accessors/0/byteOffset", json!(8e15), "end behind"),
        ("/accessors/0/byteOffset", json!(0.5), "\"byteOffset\" must be a whole number"),
        ("/accessors/0/count", json!(25), "mesh 0 'cube', primitive 0, POSITION: accessor 0: 25 values"),
        ("/accessors/0/count", json!(-1), "\"count\" must be a whole number of at least 0, not -1"),
        ("/accessors/0/count", json!(4e9), "accessor 0: 4000000000 values"),
        ("/accessors/0/count", json!(8e15), "end behind"),
        ("/accessors/0/count", json!("24"), "\"count\" must be a number, not a string"),
        ("/accessors/0/componentType", json!(5130), "there is no component type 5130"),
        ("/accessors/0/type", json!("VEC2"), "its values have 2 numbers each, not 3"),
        ("/accessors/0/type", json!("MAT4"), "values of the type 'MAT4' have no use here"),
        ("/accessors/0/type", json!(null), "it has no \"type\""),
        ("/accessors/0/bufferView", json!(9), "there is no buffer view 9; the file has 4, counted from 0"),
        ("/accessors/1/count", json!(23), "there are 23 values for 24 vertices"),
        ("/accessors/1/type", json!("SCALAR"), "NORMAL: accessor 1: its values have 1 numbers each, not 3"),
        ("/accessors/2/type", json!("VEC3"), "TEXCOORD_0: accessor 2"),
        ("/accessors/3/componentType", json!(5126), "its values are no indices"),
        ("/accessors/3/type", json!("VEC2"), "its values are no indices"),
        ("/accessors/3/componentType", json!(5120), "its values are no indices"),
        ("/accessors/3/count", json!(37), "indices: accessor 3: 37 values"),
        ("/accessors/0/sparse", json!({ "count": 1 }), "\"sparse\" has no \"indices\""),
        (
            "/accessors/0/sparse",
            json!({ "count": 1, "indices": { "bufferView": 3, "componentType": 5123 },
            "values": { "bufferView": 9 } }),
            "there is no buffer view 9",
        ),
        (
            "/accessors/0/sparse",
            json!({ "count": 1, "indices": { "bufferView": 0, "componentType": 5123, "byteOffset": 26 },
            "values": { "bufferView": 0 } }),
            "it replaces value 16256, but has 24 values",
        ),
        (
            "/accessors/0/sparse",
            json!({ "count": 4e9, "indices": { "bufferView": 3, "componentType": 5123 },
            "values": { "bufferView": 0 } }),
            "many times more numbers than it has bytes",
        ),
        ("/meshes/0/primitives", json!(null), "mesh 0 'cube' has no \"primitives\""),
        ("/meshes/0/primitives/0/mode", json!(7), "there is no mode 7"),
        ("/meshes/0/primitives/0/indices", json!(4), "primitive 0, indices: there is no accessor 4"),
        ("/meshes/0/primitives/0/material", json!(1), "there is no material 1; the file has 1"),
        (
            "/meshes/0/primitives/0/attributes",
            json!({}),
            "mesh 0 'cube', primitive 0 has no attribute POSITION",
        ),
        ("/meshes/0/primitives/0/attributes", json!([]), "\"attributes\" must be an object"),
        (
            "/meshes/0/primitives/0/attributes/POSITION",
            json!(-1),
            "primitive 0, POSITION: the number of a accessor",
        ),
        ("/nodes/0/mesh", json!(1), "there is no mesh 1; the file has 1, counted from 0"),
        ("/nodes/0/matrix", json!([1, 0, 0]), "\"matrix\" must be an array of 16 numbers, not an array of 3"),
        (
            "/nodes/0/matrix",
            json!([1, 0, 0, 5, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]),
            "the matrix of node 0 is not affine",
        ),
        ("/nodes/0/rotation", json!([0, 0, 0, 0]), "the rotation of node 0 is no quaternion"),
        ("/nodes/0/scale", json!([1, 2]), "\"scale\" must be an array of 3 numbers"),
        ("/nodes/0/translation", json!(["1", 2, 3]), "each of \"translation\" must be a number"),
        ("/nodes/1/children", json!([0, 0]), "node 0 is a child of node 1, and of node 1 as well"),
        ("/nodes/1/children", json!([7]), "there is no node 7"),
        ("/nodes/1/children", json!([1]), "node 1 is below itself"),
        ("/nodes/0/children", json!([1]), "is below itself"),
        ("/nodes/1/camera", json!(0), "there is no camera 0; the file has 0"),
        (
            "/nodes/1/extensions",
            json!({ "KHR_lights_punctual": { "light": 0 } }),
            "the file has no list of lights",
        ),
        ("/scenes/0/nodes", json!([0]), "node 0 is no root of the scene: it is a child of node 1"),
        ("/scenes/0/nodes", json!([1, 1]), "node 1 stands twice in the scene"),
        ("/scenes/0/nodes", json!([]), "the scene has no mesh with triangles"),
        ("/scene", json!(4), "there is no scene 4"),
        (
            "/materials/0/pbrMetallicRoughness",
            json!({ "baseColorFactor": [1, 1, 1] }),
            "must be an array of 4 numbers",
        ),
    ]
}

#[test]
fn wrong_values_are_refused_where_they_stand() {
    assert_eq!(message(changed(|_, _| {})), None);
    for (pointer, value, says) in wrong_values() {
        let shown = format!("{pointer} {value}");
        let bytes = set(pointer, value);
        let error = load_bytes(Path::new("part.glb"), bytes, ReadOptions::default()).expect_err(&shown);
        assert!(error.to_string().contains(says), "{shown}: {error}");
        assert!(error.diagnostics.iter().all(|found| found.help.is_some()), "{error}");
        let is_in_text =
            |found: &shotline_io::Diagnostic| matches!(found.location, Location::Text { line: 1, .. });
        assert!(says.contains("no mesh with") || error.diagnostics.iter().all(is_in_text), "{error}");
    }
}

#[test]
fn wrong_cameras_and_lights() {
    let with = |camera: Value, light: Value| {
        changed(|json, _| {
            json["cameras"] = json!([camera]);
            json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [light] } });
            json["nodes"][0]["camera"] = json!(0);
            json["nodes"][1]["extensions"] = json!({ "KHR_lights_punctual": { "light": 0 } });
        })
    };
    let (camera, light) =
        (json!({ "type": "perspective", "perspective": { "yfov": 1 } }), json!({ "type": "point" }));
    assert_eq!(message(with(camera.clone(), light.clone())), None);
    for (wrong, says) in [
        (json!({}), "the camera has no \"type\""),
        (json!({ "type": "fisheye" }), "there is no camera of the type 'fisheye'"),
        (json!({ "type": "perspective" }), "the camera has no \"perspective\""),
        (json!({ "type": "perspective", "perspective": { "yfov": 0 } }), "the angle of view must be above 0"),
        (
            json!({ "type": "perspective", "perspective": { "yfov": 3.2 } }),
            "the angle of view must be above 0",
        ),
        (
            json!({ "type": "orthographic", "orthographic": { "ymag": 0 } }),
            "the height of the picture must not be 0",
        ),
    ] {
        expect(with(wrong, light.clone()), says);
    }
    for (wrong, says) in [
        (json!({}), "the light has no \"type\""),
        (json!({ "type": "area" }), "there is no light of the type 'area'"),
        (json!({ "type": "point", "intensity": -1 }), "the intensity of a light must not be negative"),
        (json!({ "type": "point", "color": [1, 1] }), "\"color\" must be an array of 3 numbers"),
    ] {
        expect(with(camera.clone(), wrong), says);
    }
}

#[test]
fn positions_that_are_not_finite_and_compressed_triangles() {
    for (number, bytes) in [(f32::NAN, 0), (f32::INFINITY, 4), (f32::NEG_INFINITY, 12)] {
        let file = changed(|_, glb| glb.bin[bytes..bytes + 4].copy_from_slice(&number.to_le_bytes()));
        expect(file, "mesh 0 'cube', primitive 0: vertex ");
    }
    expect(
        changed(|json, _| {
            json["meshes"][0]["primitives"][0]["extensions"] = json!({ "KHR_draco_mesh_compression": {} });
            json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
        }),
        "is compressed by KHR_draco_mesh_compression",
    );
    // Without compression the extension does not matter.
    let other = changed(|json, _| {
        json["meshes"][0]["primitives"][0]["extensions"] = json!({ "KHR_draco_mesh_compression": {} });
    });
    assert_eq!(message(other), None);
}

#[test]
fn texts_that_are_no_json() {
    for (text, says) in [
        ("", "a value is missing at the end of the file"),
        ("{", "the end of the file comes before the end of this '{'"),
        ("{\"asset\": {\"version\": \"2.0\"}", "the end of the file comes before"),
        ("[]", "the file has no \"asset\""),
        ("{\"asset\": NaN}", "NaN is not a number"),
        ("{\"asset\": 1, \"asset\": 2}", "stands here twice"),
        ("{\"asset\": {\"version\": \"2.0\"}} x", "something follows the end"),
        ("{\"asset\": 1e999}", "is too large for a float64"),
    ] {
        expect(pack(text, &[]), says);
    }
    let mut bytes = cube_file(json!({}));
    bytes[30] = 0xFF;
    expect(bytes, "the text is not UTF-8 from here on");
    let lines = "{\n  \"asset\": { \"version\": \"2.0\" },\n  \"scene\": 3\n}";
    let error =
        load_bytes(Path::new("part.gltf"), lines.into(), ReadOptions::default()).unwrap_err().to_string();
    assert!(error.starts_with("part.gltf:3:12: there is no scene 3"), "{error}");
}

#[test]
fn containers_that_are_cut_off_or_wrong() {
    let whole = cube_file(json!({}));
    for end in (4..whole.len()).step_by(7).chain([4, 11, 12, 19, 20]) {
        expect(whole[..end].to_vec(), if end < 12 { "ends within the head" } else { "the head promises" });
    }
    let with = |at: usize, word: u32| {
        let mut bytes = whole.clone();
        bytes[at..at + 4].copy_from_slice(&word.to_le_bytes());
        bytes
    };
    expect(with(4, 1), "this is version 1 of the GLB container");
    expect(with(8, 5), "the head says that the file has 5 bytes");
    expect(with(8, 12), "the first chunk of the GLB is not its JSON");
    expect(with(8, 17), "the file ends within the head of a chunk");
    expect(with(8, 24), "a chunk of");
    expect(with(8, u32::MAX), "the head promises 4294967295 bytes");
    expect(with(12, u32::MAX), "a chunk of 4294967295 bytes begins here");
    expect(with(12, 0), "a chunk of");
    expect(with(16, 7), "the first chunk of the GLB is not its JSON");
    let bin = whole.windows(4).position(|word| word == b"BIN\0").unwrap();
    expect(with(bin, 7), "buffer 0 has no \"uri\"");
    expect(with(bin - 4, u32::MAX), "a chunk of 4294967295 bytes begins here");
    expect(with(bin - 4, 4), "part.glb:");
    let more = [&whole[..], &[1, 2, 3]].concat();
    let document = load_bytes(Path::new("part.glb"), more, ReadOptions::default()).unwrap();
    assert_eq!(
        document.notes[0].to_string(),
        format!(
            "part.glb: 3 bytes behind the end of the GLB were not read, the first at byte {}",
            whole.len()
        )
    );
}

#[test]
fn deep_and_wide_files_end_soon() {
    let deep = format!("{{\"asset\": {}{}}}", "[".repeat(1_000_000), "]".repeat(1_000_000));
    expect(pack(&deep, &[]), "nested more than");
    let nodes: Vec<Value> = (0..50_000).map(|i| json!({ "children": [(i + 1) % 50_000] })).collect();
    expect(changed(|json, _| json["nodes"] = json!(nodes)), "is below itself");
}

/// Random damage to files with all that is read.
#[test]
fn damaged_files_never_panic() {
    let seeds = [
        changed(|_, _| {}),
        changed(|json, _| {
            json["meshes"][0]["primitives"][0]["mode"] = json!(5);
            json["accessors"][0]["sparse"] = json!({ "count": 1,
                "indices": { "bufferView": 3, "componentType": 5123 }, "values": { "bufferView": 0 } });
            json["bufferViews"][0]["byteStride"] = json!(12);
            json["accessors"][3]["normalized"] = json!(true);
            json["cameras"] = json!([{ "type": "perspective", "perspective": { "yfov": 1 } }]);
            json["nodes"] = json!([{ "mesh": 0, "rotation": [0, 0, 1, 0], "scale": [1, 2, 3] },
                { "children": [0], "camera": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1] }]);
        }),
    ];
    let mut random = Random::new(11);
    for case in 0..20_000 {
        let seed = &seeds[case % seeds.len()];
        let bytes = damaged(seed, &mut random);
        let shown = || String::from_utf8_lossy(&bytes).into_owned();
        let outcome = catch_unwind(AssertUnwindSafe(|| message(bytes.clone())));
        assert!(outcome.is_ok_and(|message| message.is_none_or(|m| !m.is_empty())), "{}", shown());
    }
}

/// The bytes with one to three changes, after which the lengths of a GLB are often correct again.
fn damaged(whole: &[u8], random: &mut Random) -> Vec<u8> {
    const NUMBERS: [&str; 8] = ["-1", "0", "4294967295", "1e15", "0.5", "null", "[]", "\"\""];
    let mut bytes = whole.to_vec();
    for _ in 0..=random.below(3) {
        let at = random.below(bytes.len().max(1)).min(bytes.len());
        let end = (at + 1 + random.below(6)).min(bytes.len());
        match random.below(6) {
            0 => bytes.truncate(at),
            1 => drop(bytes.drain(at..end)),
            2 | 3 => {
                // A number of the JSON becomes another.
                let digit = bytes[at..].iter().position(u8::is_ascii_digit).map(|i| at + i);
                let Some(start) = digit else { continue };
                let end = bytes[start..]
                    .iter()
                    .position(|b| !b.is_ascii_digit())
                    .map_or(bytes.len(), |i| start + i);
                bytes.splice(start..end, NUMBERS[random.below(NUMBERS.len())].bytes()).for_each(drop);
            }
            4 if at < bytes.len() => bytes[at] ^= 1 << random.below(8),
            _ if at < bytes.len() => bytes[at] = random.bits() as u8,
            _ => {}
        }
    }
    if random.below(4) > 0
        && let Some(bin) = bytes.windows(4).position(|word| word == b"BIN\0").filter(|bin| *bin >= 24)
    {
        let length = bytes.len() as u32;
        bytes[8..12].copy_from_slice(&length.to_le_bytes());
        bytes[12..16].copy_from_slice(&((bin - 24) as u32).to_le_bytes());
        bytes[bin - 4..bin].copy_from_slice(&(length - bin as u32 - 4).to_le_bytes());
    }
    bytes
}
