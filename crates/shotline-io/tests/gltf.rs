//! glTF files that are read: their meshes, instances, materials, cameras and lights.

mod glb;
mod reading;

use glb::{Glb, SIDES, cube, cube_file, indices};
use reading::{ok, refused};
use serde_json::{Value, json};
use shotline::compile::compile;
use shotline::math::{ComposedTransform, Vec3};
use shotline::scene::{Lens, LightSource, Node, NodeId, Scene, Units};
use shotline::solid::mesh::{Topology, TriangleMesh};
use shotline_io::{Document, Effect, FORMATS, ReadOptions, load, load_bytes};

fn meshes(scene: &Scene) -> Vec<&TriangleMesh> {
    let mut found = Vec::new();
    for node in &scene.nodes {
        if let Node::Mesh { mesh, .. } = node {
            found.push(mesh.as_ref());
        }
    }
    found
}

/// The objects of a scene by their names, with their materials, their meshes, and a corner of each in the world.
fn objects(scene: &Scene) -> Vec<(String, Option<String>, NodeId, [f64; 3])> {
    let found = scene.objects.iter().map(|root| {
        let (mut id, mut placed) = (*root, ComposedTransform::IDENTITY);
        while let Node::Transform { transform, child } = scene.node(id) {
            (id, placed) = (*child, transform.inside(&placed));
        }
        let Node::Object { name, material, node, .. } = scene.node(id) else { panic!("an object") };
        let Node::Mesh { mesh, .. } = scene.node(*node) else { panic!("a mesh") };
        let world = placed.placement().unwrap().parent_from_local;
        (name.clone(), material.clone(), *node, world.point(mesh.vertices[0]).to_array())
    });
    found.collect()
}

fn names(document: &Document) -> Vec<String> {
    objects(&document.scene).into_iter().map(|(name, ..)| name).collect()
}

fn kinds(document: &Document) -> Vec<(&'static str, usize)> {
    document.notes.iter().map(|note| (note.kind, note.count)).collect()
}

#[track_caller]
fn assert_is_cube(mesh: &TriangleMesh) {
    let topology = Topology::of(mesh).unwrap();
    assert!(topology.is_closed());
    assert_eq!((mesh.vertices.len(), mesh.faces.len(), topology.signed_volume), (8, 12, 1.0));
}

#[test]
fn vertices_that_are_split_at_seams_become_one() {
    let document = ok("part.glb", cube_file(json!({})));
    assert_eq!((names(&document), document.scene.units), (vec!["cube".into()], Some(Units::Metres)));
    assert!(document.notes.is_empty(), "{:?}", document.notes);
    let mesh = meshes(&document.scene)[0];
    assert_is_cube(mesh);
    compile(&document.scene, Default::default()).unwrap();
    let normal = mesh.attribute("normal").unwrap();
    for (face, (_, expected)) in SIDES.iter().flat_map(|side| [side, side]).enumerate() {
        for corner in 0..3 {
            let found = mesh.corner_value(normal, face as u32, corner).unwrap();
            assert_eq!(found, expected.map(f64::from));
        }
    }
    let uv = mesh.attribute("uv").unwrap();
    assert_eq!((uv.width, mesh.corner_value(uv, 11, 2).unwrap()), (2, &[1.0, 0.0][..]));
}

#[test]
fn nodes_with_one_mesh_share_it() {
    let document = ok(
        "part.glb",
        cube_file(json!({
            "nodes": [
                { "name": "arm", "translation": [10, 0, 0], "children": [1, 2, 3] },
                { "mesh": 0, "name": "hand", "scale": [2, 2, -2] },
                { "mesh": 0, "name": "hand", "rotation": [0, 0, 0.70710677, 0.70710677], "translation": [0, 5, 0] },
                { "mesh": 0, "matrix": [0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 7, 1], "children": [4] },
                { "mesh": 0, "translation": [1, 2, 3] },
            ],
            "scenes": [{ "nodes": [0] }],
        })),
    );
    let found = objects(&document.scene);
    let names: Vec<&str> = found.iter().map(|(name, ..)| name.as_str()).collect();
    assert_eq!(names, ["hand", "hand_2", "cube", "cube_2"]);
    assert_eq!(meshes(&document.scene).len(), 1);
    let corner = meshes(&document.scene)[0].vertices[3];
    assert_eq!(corner, Vec3::new(1.0, 0.0, 0.0));
    let transforms = |index: usize| {
        let (mut id, mut count, mut placed) = (document.scene.objects[index], 0, ComposedTransform::IDENTITY);
        while let Node::Transform { transform, child } = document.scene.node(id) {
            (id, count, placed) = (*child, count + 1, transform.inside(&placed));
        }
        (count, placed.placement().unwrap().parent_from_local.point(corner).to_array())
    };
    assert_eq!(transforms(0), (2, [12.0, 0.0, 0.0]));
    let (count, [x, y, z]) = transforms(1);
    assert!(count == 2 && (x - 10.0).abs() < 1e-15 && y == 6.0 && z == 0.0, "{x} {y} {z}");
    assert_eq!(transforms(2), (2, [10.0, 1.0, 7.0]));
    // (1, 0, 0) is shifted to (2, 2, 3), exchanged to (2, 2, 3), raised by 7 and shifted by 10.
    assert_eq!(transforms(3), (3, [12.0, 2.0, 10.0]));
    compile(&document.scene, Default::default()).unwrap();
}

#[test]
fn strips_fans_and_lists_without_indices_are_triangles() {
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0], [0.0, 2.0, 0.0]];
    let area = |mode: usize, order: Option<&[u16]>, count: usize| {
        let mut glb = Glb::default();
        let positions = glb.floats("VEC3", 3, &corners[..count].concat());
        let mut primitive = json!({ "attributes": { "POSITION": positions }, "mode": mode });
        if let Some(order) = order {
            primitive["indices"] = json!(glb.indices(order));
        }
        let keys = json!({ "meshes": [{ "primitives": [primitive] }], "nodes": [{ "mesh": 0 }] });
        let document = ok("part.glb", glb.file(keys));
        let mesh = meshes(&document.scene)[0].clone();
        let area_of = |[a, b, c]: [Vec3; 3]| (b - a).cross(c - a).z / 2.0;
        (0..mesh.faces.len()).map(|face| area_of(mesh.corners(face as u32))).collect::<Vec<f64>>()
    };
    assert_eq!(area(4, None, 3), [0.5]);
    assert_eq!(area(4, Some(&[0, 1, 2, 2, 1, 3]), 4), [0.5, 0.5]);
    assert_eq!(area(5, None, 5), [0.5, 0.5, 0.5]);
    assert_eq!(area(6, Some(&[0, 1, 3, 2]), 4), [0.5, 0.5]);
    // Repeated vertices lead from one part of a strip to the next, which keeps its orientation.
    assert_eq!(area(5, Some(&[0, 1, 2, 2, 2, 3, 4]), 5), [0.5, 0.5]);
    // The rest of a list that is no triangle does not count.
    assert_eq!(area(4, None, 5), [0.5]);
}

#[test]
fn numbers_of_every_type_are_read() {
    let cube_of = |component: u32, one: &[u8], stride: usize, normalized: bool, index: (u32, usize)| {
        let mut glb = Glb::default();
        let mut bytes = Vec::new();
        for corner in SIDES.iter().flat_map(|(corners, _)| corners) {
            let first = bytes.len();
            for x in corner {
                bytes.extend(if *x == 0.0 { vec![0; one.len()] } else { one.to_vec() });
            }
            bytes.resize(first + stride, 0xEE);
        }
        let positions = glb.accessor(component, "VEC3", 24, &bytes);
        glb.views[0]["byteStride"] = json!(stride);
        glb.accessors[0]["normalized"] = json!(normalized);
        let order: Vec<u8> =
            indices(6).iter().flat_map(|i| u32::from(*i).to_le_bytes()[..index.1].to_vec()).collect();
        let indices = glb.accessor(index.0, "SCALAR", 36, &order);
        let primitive = json!({ "attributes": { "POSITION": positions }, "indices": indices });
        let keys = json!({
            "meshes": [{ "primitives": [primitive] }],
            "nodes": [{ "mesh": 0 }],
            "extensionsRequired": ["KHR_mesh_quantization"],
            "extensionsUsed": ["KHR_mesh_quantization"],
        });
        let document = ok("part.glb", glb.file(keys));
        assert_is_cube(meshes(&document.scene)[0]);
    };
    cube_of(5126, &1f32.to_le_bytes(), 16, false, (5121, 1));
    cube_of(5126, &1f32.to_le_bytes(), 12, false, (5125, 4));
    cube_of(5120, &[127], 4, true, (5123, 2));
    cube_of(5121, &[255], 4, true, (5123, 2));
    cube_of(5122, &[0xff, 0x7f], 8, true, (5123, 2));
    cube_of(5123, &[0xff, 0xff], 8, true, (5123, 2));
    cube_of(5123, &[1, 0], 8, false, (5123, 2));
    cube_of(5120, &[1], 4, false, (5123, 2));
}

#[test]
fn sparse_accessors_replace_values() {
    for is_zero in [false, true] {
        let mut glb = Glb::default();
        let triangle = if is_zero { [0.0; 9] } else { [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 5.0, 5.0, 5.0] };
        glb.floats("VEC3", 3, &triangle);
        if is_zero {
            glb.accessors[0].as_object_mut().unwrap().remove("bufferView");
        }
        let at = glb.view(&[1, 2]);
        let new: Vec<u8> = [2f32, 0.0, 0.0, 0.0, 1.0, 0.0].iter().flat_map(|x| x.to_le_bytes()).collect();
        let new = glb.view(&new);
        glb.accessors[0]["sparse"] = json!({ "count": 2,
            "indices": { "bufferView": at, "componentType": 5121 }, "values": { "bufferView": new } });
        let keys = json!({ "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }],
            "nodes": [{ "mesh": 0 }] });
        let document = ok("part.glb", glb.file(keys));
        let expected = [Vec3::ZERO, Vec3::new(2.0, 0.0, 0.0), Vec3::new(0.0, 1.0, 0.0)];
        assert_eq!(meshes(&document.scene)[0].vertices, expected);
    }
}

/// A file whose sides have these materials; `None` leaves the side out.
fn painted(materials: [Option<usize>; 6]) -> Document {
    let mut glb = Glb::default();
    let (attributes, _) = cube(&mut glb);
    let all = indices(6);
    let mut primitives = Vec::new();
    for (side, material) in materials.iter().enumerate() {
        let Some(material) = material else { continue };
        let indices = glb.indices(&all[6 * side..6 * side + 6]);
        primitives.push(json!({ "attributes": attributes, "indices": indices, "material": material }));
    }
    ok(
        "part.glb",
        glb.file(json!({
            "meshes": [{ "name": "cube", "primitives": primitives }],
            "nodes": [{ "mesh": 0 }],
            "materials": [{ "name": "red" }, { "name": "red" }, {}],
        })),
    )
}

#[test]
fn materials_divide_a_mesh_unless_that_would_open_it() {
    let whole = painted([Some(1); 6]);
    assert_is_cube(meshes(&whole.scene)[0]);
    assert_eq!(objects(&whole.scene)[0].1.as_deref(), Some("red_2"));
    assert!(whole.notes.is_empty());

    // None of the parts would be closed.
    let joined = painted([Some(0), Some(2), Some(2), Some(1), Some(2), Some(1)]);
    assert_eq!(meshes(&joined.scene).len(), 1);
    assert_is_cube(meshes(&joined.scene)[0]);
    assert_eq!(objects(&joined.scene)[0].1.as_deref(), Some("material2"));
    assert_eq!(kinds(&joined), [("materials_joined", 1)]);
    assert_eq!(meshes(&joined.scene)[0].attributes.len(), 2);

    // The whole is open.
    let open = painted([Some(0), Some(1), Some(1), None, Some(1), Some(1)]);
    assert_eq!(names(&open), ["cube", "cube_2"]);
    assert_eq!(meshes(&open.scene).iter().map(|mesh| mesh.faces.len()).collect::<Vec<_>>(), [2, 8]);
}

#[test]
fn closed_parts_of_a_mesh_become_objects() {
    let mut glb = Glb::default();
    let (attributes, order) = cube(&mut glb);
    let primitive =
        |material: usize| json!({ "attributes": attributes, "indices": order, "material": material });
    let keys = json!({
        "meshes": [{ "primitives": [primitive(0), primitive(1)] }, { "primitives": [primitive(1)] }],
        "nodes": [{ "mesh": 0 }, { "mesh": 1, "translation": [3, 0, 0] }],
        "materials": [{ "pbrMetallicRoughness": { "baseColorFactor": [1, 0.2158605, 0, 1] } }, {}],
    });
    let document = ok("part.glb", glb.file(keys));
    let found = objects(&document.scene);
    assert_eq!(names(&document), ["node0", "node0_2", "node1"]);
    // What is made of the same accessors is one mesh.
    assert_eq!((found[1].2, found[2].2), (found[0].2, found[0].2));
    assert_eq!(found[1].1.as_deref(), Some("material1"));
    let color = document.scene.materials[0].1.color.unwrap();
    assert!((color[0] - 1.0).abs() < 1e-15 && (color[1] - 128.0 / 255.0).abs() < 1e-6 && color[2] == 0.0);
    assert_eq!(document.scene.materials[1].1.color, None);
}

#[test]
fn colours_of_vertices_are_kept() {
    let mut glb = Glb::default();
    let positions = glb.floats("VEC3", 3, &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    let colors = glb.accessor(5121, "VEC4", 3, &[255, 0, 0, 255, 0, 255, 0, 51, 0, 0, 255, 0]);
    glb.accessors[colors]["normalized"] = json!(true);
    let tangent = glb.floats("VEC4", 4, &[0.0; 12]);
    let attributes =
        json!({ "POSITION": positions, "COLOR_0": colors, "TANGENT": tangent, "_MINE": tangent });
    let keys =
        json!({ "meshes": [{ "primitives": [{ "attributes": attributes }] }], "nodes": [{ "mesh": 0 }] });
    let document = ok("part.glb", glb.file(keys));
    let mesh = meshes(&document.scene)[0];
    let color = mesh.attribute("color").unwrap();
    let found: Vec<f64> =
        mesh.corner_value(color, 0, 1).unwrap().iter().map(|x| (x * 1e9).round() / 1e9).collect();
    assert_eq!(found, [0.0, 1.0, 0.0, 0.2]);
    assert_eq!(kinds(&document), [("attributes_not_read", 2)]);
}

#[test]
fn cameras_and_lights_are_placed_by_their_nodes() {
    let turned = json!([0, 0.70710677, 0, 0.70710677]);
    let document = ok(
        "part.glb",
        cube_file(json!({
            "extensionsUsed": ["KHR_lights_punctual"],
            "extensions": { "KHR_lights_punctual": { "lights": [
                { "type": "point", "color": [1, 0, 0], "intensity": 500 },
                { "type": "spot", "intensity": 1000 },
                { "type": "directional" },
            ] } },
            "cameras": [
                { "type": "perspective", "perspective": { "yfov": 0.5, "znear": 0.1 } },
                { "type": "orthographic", "orthographic": { "xmag": 3, "ymag": 2, "znear": 0, "zfar": 9 } },
            ],
            "nodes": [
                { "translation": [0, 0, 5], "rotation": turned, "scale": [2, 2, 2], "children": [1, 2, 3] },
                { "mesh": 0 },
                { "camera": 0, "translation": [0, 0, 1] },
                { "camera": 1, "children": [4, 5] },
                { "extensions": { "KHR_lights_punctual": { "light": 0 } }, "translation": [1, 0, 0], "children": [6] },
                { "extensions": { "KHR_lights_punctual": { "light": 2 } } },
                { "extensions": { "KHR_lights_punctual": { "light": 1 } } },
            ],
        })),
    );
    let near = |a: Vec3, b: [f64; 3]| assert!((a - Vec3::from_array(b)).length() < 1e-14, "{a}");
    let camera = document.scene.camera.unwrap();
    near(camera.eye, [2.0, 0.0, 5.0]);
    near(camera.target, [1.0, 0.0, 5.0]);
    near(camera.up, [0.0, 1.0, 0.0]);
    assert_eq!(camera.lens, Lens::Pinhole { fov: 0.5f64.to_degrees() });
    let lights = &document.scene.lights;
    let intensities: Vec<Option<f64>> = lights.iter().map(|light| light.intensity).collect();
    assert_eq!(intensities, [Some(0.5), None, None]);
    match (lights[0].source, lights[2].source) {
        (LightSource::Point(at), LightSource::Directional(along)) => {
            near(at, [0.0, 0.0, 3.0]);
            near(along, [-1.0, 0.0, 0.0]);
        }
        other => panic!("{other:?}"),
    }
    let color = lights[0].color.unwrap();
    assert!((color[0] - 1.0).abs() < 1e-15 && color[1..] == [0.0; 2]);
    assert_eq!(kinds(&document), [("cameras", 1), ("spots", 1), ("light_intensities", 2)]);
    let flat = ok(
        "part.glb",
        cube_file(json!({
            "cameras": [{ "type": "orthographic", "orthographic": { "ymag": -2 } }],
            "nodes": [{ "mesh": 0, "camera": 0 }],
        })),
    );
    assert_eq!(flat.scene.camera.unwrap().lens, Lens::Orthographic { height: 4.0 });
}

#[test]
fn what_is_not_read_is_noted() {
    let mut glb = Glb::default();
    let (attributes, order) = cube(&mut glb);
    let keys = json!({
        "extensionsUsed": ["EXT_mesh_gpu_instancing", "MINE"],
        "animations": [{}, {}],
        "meshes": [{ "primitives": [
            { "attributes": attributes, "indices": order, "targets": [{ "POSITION": 0 }] },
            { "attributes": { "POSITION": 0 }, "mode": 1 },
            { "attributes": { "POSITION": 0 }, "mode": 0 },
            { "attributes": { "POSITION": 0 }, "indices": glb.indices(&[1, 1, 1]) },
        ] }],
        "nodes": [{ "mesh": 0, "skin": 0 }, { "scale": [1, 0, 1], "children": [2] }, { "mesh": 0 }],
        "scenes": [{ "name": "a", "nodes": [0, 1] }, { "name": "b", "nodes": [1] }],
        "materials": [{ "pbrMetallicRoughness": { "roughnessFactor": 0.5 } }, { "alphaMode": "BLEND" },
            { "doubleSided": true, "alphaMode": "OPAQUE", "emissiveFactor": [0, 0, 0] }],
    });
    let document = ok("part.glb", glb.file(keys.clone()));
    let mut found = kinds(&document);
    found.sort_unstable();
    let expected = [
        ("animations", 2),
        ("extensions_not_read", 2),
        ("flat_nodes", 1),
        ("morph_targets", 1),
        ("no_triangles", 1),
        ("points_and_lines", 2),
        ("setups", 2),
        ("skins", 1),
        ("surfaces_not_read", 2),
    ];
    assert_eq!(found, expected);
    let skin = document.notes.iter().find(|note| note.kind == "skins").unwrap();
    assert_eq!(skin.effect, Effect::Changed);
    assert!(skin.to_string().starts_with("part.glb: 1 mesh with a skin"), "{skin}");
    let read = |setup: &str| {
        let options = ReadOptions { setup: Some(setup.into()), ..ReadOptions::default() };
        load_bytes("part.glb".as_ref(), glb.file(keys.clone()), options).map_err(|error| error.to_string())
    };
    assert_eq!(names(&read("a").unwrap()), ["node0"]);
    assert!(read("b").unwrap_err().contains("no mesh with triangles"));
    assert!(read("c").unwrap_err().contains("there is no scene 'c'\nhelp: "));
}

#[test]
fn buffers_are_in_files_and_in_the_text() {
    let folder = std::env::temp_dir().join(format!("shotline-gltf-{}", std::process::id()));
    std::fs::create_dir_all(folder.join("sub")).unwrap();
    let mut glb = Glb::default();
    let (attributes, order) = cube(&mut glb);
    std::fs::write(folder.join("sub/a b.bin"), &glb.bin).unwrap();
    std::fs::write(folder.join("short.bin"), &glb.bin[..20]).unwrap();
    let text = |uri: &str| {
        glb.json(json!({
            "buffers": [{ "byteLength": glb.bin.len(), "uri": uri }],
            "meshes": [{ "primitives": [{ "attributes": attributes, "indices": order }] }],
            "nodes": [{ "mesh": 0 }],
        }))
        .to_string()
    };
    let read = |uri: &str| {
        let path = folder.join("part.gltf");
        std::fs::write(&path, text(uri)).unwrap();
        load(&path).map_err(|error| error.to_string())
    };
    let document = read("sub/a%20b.bin").unwrap();
    assert_is_cube(meshes(&document.scene)[0]);
    assert!(document.source.files().eq([folder.join("sub/a b.bin")]));
    let data = format!("data:application/octet-stream;base64,{}", base64(&glb.bin));
    assert_is_cube(meshes(&read(&data).unwrap().scene)[0]);
    for (uri, says) in [
        ("none.bin", "buffer 0: 'none.bin' cannot be opened"),
        ("short.bin", "buffer 0 has 20 bytes, not"),
        ("../part.bin", "cannot be opened"),
        ("/etc/passwd", "the path of this file is absolute"),
        ("https://x.org/a.bin", "buffer 0 lies elsewhere"),
        ("a%zz.bin", "% without two hexadecimal digits"),
        ("data:;base64,AA?A", "the data of buffer 0 are not Base64"),
        ("sub", "is a folder"),
    ] {
        let error = read(uri).unwrap_err();
        assert!(
            error.contains(says) && error.contains("part.gltf:1:") && error.contains("\nhelp: "),
            "{error}"
        );
    }
    std::fs::remove_dir_all(&folder).unwrap();
}

fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for group in bytes.chunks(3) {
        let bits = group.iter().fold(0u32, |bits, b| bits << 8 | u32::from(*b)) << (8 * (3 - group.len()));
        let digits = (0..4).map(|i| DIGITS[(bits >> (18 - 6 * i)) as usize & 63] as char);
        text.extend(digits.take(group.len() + 1).chain(std::iter::repeat_n('=', 3 - group.len())));
    }
    text
}

#[test]
fn the_contents_tell_the_format() {
    let name = |bytes: &[u8]| FORMATS.iter().find(|format| (format.detect)(bytes)).map(|format| format.name);
    assert_eq!(name(&cube_file(json!({}))), Some("glTF"));
    assert_eq!(name(b"{ \"scene\": 0, \"asset\": { \"version\": \"2.0\" } }"), Some("glTF"));
    assert_eq!(name(b"{ \"shotline\": 1, \"asset\": 1 }"), Some("scene"));
    assert_eq!(name(b"{}"), Some("scene"));
    // A GLB may be named like a text, and a text like a GLB.
    assert_eq!(names(&ok("part.gltf", cube_file(json!({})))), ["cube"]);
    refused("part.glb", "{}", "the file has no \"asset\"");
}

#[test]
fn a_deep_chain_of_nodes_is_read_and_a_hopeless_one_is_refused() {
    let chain = |depth: usize, meshes: usize| {
        let mut nodes: Vec<Value> = (0..depth)
            .map(|i| {
                json!({ "translation": [1, 0, 0], "children": if i + 1 == depth {
                (0..meshes).map(|m| depth + m).collect::<Vec<_>>() } else { vec![i + 1] } })
            })
            .collect();
        nodes.extend((0..meshes).map(|_| json!({ "mesh": 0 })));
        cube_file(json!({ "nodes": nodes }))
    };
    let document = ok("part.glb", chain(5000, 1));
    let (.., corner) = &objects(&document.scene)[0];
    assert_eq!(corner[0], 5000.0);
    compile(&document.scene, Default::default()).unwrap();
    refused("part.glb", chain(5000, 300), "nested too deeply");
}

#[test]
fn a_light_head_does_not_stand_for_a_heavy_scene() {
    // Each primitive is small; together they would be many times the file.
    let mut glb = Glb::default();
    let corners: Vec<f32> =
        (0..30_000u16).flat_map(|i| [f32::from(i), f32::from(i % 7), f32::from(i % 5)]).collect();
    glb.floats("VEC3", 3, &corners);
    for i in 0..200 {
        let mut accessor = glb.accessors[0].clone();
        accessor["count"] = json!(29_000 + i);
        glb.accessors.push(accessor);
    }
    let primitives: Vec<Value> = (1..200).map(|i| json!({ "attributes": { "POSITION": i } })).collect();
    let keys = json!({ "meshes": [{ "primitives": primitives }], "nodes": [{ "mesh": 0 }] });
    refused("part.glb", glb.file(keys), "many times more numbers than it has bytes");
    let mut glb = Glb::default();
    glb.accessors.push(json!({ "componentType": 5126, "type": "VEC3", "count": 4_000_000_000u64 }));
    let keys = json!({ "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }], "nodes": [{ "mesh": 0 }] });
    refused("part.glb", glb.file(keys), "it promises 4000000000 values");
}
