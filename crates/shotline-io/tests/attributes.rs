//! Colours, normals, texture coordinates, names and materials of mesh files.

use std::path::Path;

use shotline::math::Vec3;
use shotline::scene::{Node, Scene};
use shotline::solid::mesh::{Attribute, NO_ROW, TriangleMesh};
use shotline_io::{Document, load, load_bytes, save};

fn ok(name: &str, text: impl Into<Vec<u8>>) -> Document {
    load_bytes(Path::new(name), text.into(), shotline_io::ReadOptions::default())
        .unwrap_or_else(|error| panic!("{error}"))
}

fn meshes(scene: &Scene) -> Vec<&TriangleMesh> {
    let meshes = scene.nodes.iter();
    meshes.filter_map(|node| if let Node::Mesh { mesh, .. } = node { Some(&**mesh) } else { None }).collect()
}

/// The values of an attribute at the corners of a face; empty for a corner without one.
fn values(mesh: &TriangleMesh, name: &str, face: u32) -> [Vec<f64>; 3] {
    let attribute = mesh.attribute(name).unwrap();
    [0, 1, 2]
        .map(|corner| mesh.corner_value(attribute, face, corner).map(<[f64]>::to_vec).unwrap_or_default())
}

/// The name, the material and the number of triangles of each object.
fn objects(scene: &Scene) -> Vec<(&str, Option<&str>, usize)> {
    let object = |node: &Node| {
        let Node::Object { name, material, node, .. } = node else { return None };
        let Node::Mesh { mesh, .. } = scene.node(*node) else { return None };
        Some((name.clone(), material.clone(), mesh.faces.len()))
    };
    let found: Vec<_> = scene.objects.iter().filter_map(|id| object(scene.node(*id))).collect();
    let leak = |text: String| -> &'static str { text.leak() };
    found.into_iter().map(|(name, material, count)| (leak(name), material.map(leak), count)).collect()
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0.5 1 9\nvn 0 0 1\n";

#[test]
fn corners_of_obj_polygons_keep_their_values_when_they_are_cut() {
    let document = ok("a.obj", format!("{SQUARE}f 1/4 2/3/1 3/2 4/-4\n"));
    let [mesh] = meshes(&document.scene)[..] else { panic!() };
    assert_eq!(mesh.faces, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(values(mesh, "uv", 0), [vec![0.5, 1.0], vec![1.0, 1.0], vec![1.0, 0.0]]);
    assert_eq!(values(mesh, "uv", 1), [vec![0.5, 1.0], vec![1.0, 0.0], vec![0.0, 0.0]]);
    assert_eq!(values(mesh, "normal", 0), [vec![], vec![0.0, 0.0, 1.0], vec![]]);
    // Repeated corners are dropped with their values, and short faces too.
    let repeated = ok("a.obj", format!("{SQUARE}f 1/1 2/2\nf 1/1 2/2 2/3 3/3 4/4 1/2\nf 2/2 3/3 4/1\n"));
    let [mesh] = meshes(&repeated.scene)[..] else { panic!() };
    assert_eq!(values(mesh, "uv", 1)[2], [0.5, 1.0]);
    assert_eq!(values(mesh, "uv", 2), [vec![1.0, 0.0], vec![1.0, 1.0], vec![0.0, 0.0]]);
    assert!(mesh.attribute("normal").is_none());
    assert_eq!(mesh.attribute("uv").unwrap().rows(), 4);
}

/// A tetrahedron with a corner at x.
fn tetrahedron(x: f64, first: i64) -> String {
    let f = |a: i64, b: i64, c: i64| format!("f {} {} {}\n", first + a, first + b, first + c);
    let vertices = format!("v {x} 0 0\nv {} 0 0\nv {x} 1 0\nv {x} 0 1\n", x + 1.0);
    vertices + &f(0, 2, 1) + &f(0, 1, 3) + &f(1, 2, 3) + &f(2, 0, 3)
}

#[test]
fn objects_and_materials_of_an_obj_become_those_of_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("parts.obj");
    let body = tetrahedron(0.0, 1).replace("f 2 3 4", "usemtl paint\nf 2 3 4");
    let text = format!(
        "mtllib look.mtl none.mtl\no body\nusemtl steel blue\n{body}o lid\n{}\nusemtl glass\n{}g\n",
        tetrahedron(3.0, 5),
        tetrahedron(6.0, 9)
    );
    let mtl =
        "# look\nnewmtl steel blue\nKd 0.25 0.5 1\nKs 0.1 0.3 0.2\nNs 96\nmap_Kd x.png\nnewmtl paint\nKd 2\n";
    std::fs::write(&path, text).unwrap();
    std::fs::write(folder.path().join("look.mtl"), mtl).unwrap();
    let document = load(&path).unwrap();
    assert!(document.source.files().eq([folder.path().join("look.mtl")]));
    assert_eq!(
        objects(&document.scene),
        [("body", Some("steel blue"), 4), ("lid:paint", Some("paint"), 4), ("lid:glass", Some("glass"), 4)]
    );
    let (name, steel) = &document.scene.materials[0];
    assert_eq!(
        (name.as_str(), steel.color, steel.specular, steel.shininess),
        ("steel blue", Some([0.25, 0.5, 1.0]), Some(0.3), Some(96.0))
    );
    let (name, paint) = &document.scene.materials[1];
    assert_eq!((name.as_str(), paint.color), ("paint", Some([1.0; 3])));
    let kinds: Vec<_> = document.notes.iter().map(|note| note.kind).collect();
    assert_eq!(kinds, ["materials_not_read", "materials_of_faces"]);
    let told: Vec<_> = document.notes.iter().map(ToString::to_string).collect();
    assert!(
        told[0].contains("the materials of 'none.mtl' were not read: 'none.mtl' cannot be opened"),
        "{told:?}"
    );
    // The objects, their materials and their polygons come back from a scene file.
    let saved = folder.path().join("parts.json");
    save(&saved, &document.scene).unwrap();
    let back = load(&saved).unwrap().scene;
    assert_eq!(objects(&back), objects(&document.scene));
    assert_eq!(back.materials, document.scene.materials);
    assert_eq!(meshes(&back), meshes(&document.scene));
    assert_eq!(meshes(&back)[1].polygon(0), 4);
}

#[test]
fn broken_and_outlying_material_files_are_noted() {
    let folder = tempfile::tempdir().unwrap();
    let told = |mtl: &[u8], name: &str| {
        let path = folder.path().join("a.obj");
        std::fs::write(folder.path().join("a.mtl"), mtl).unwrap();
        std::fs::write(&path, format!("mtllib {name}\nusemtl x\n{}", tetrahedron(0.0, 1))).unwrap();
        let document = load(&path).unwrap();
        assert_eq!(objects(&document.scene), [("a", Some("x"), 4)]);
        document.notes.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
    };
    assert_eq!(told(b"newmtl x\nKd 1 0 0\nKd spectral x.rfl 1\nKs xyz 1 1\nNs -1\nillum 2\n", "a.mtl"), "");
    assert!(told(b"newmtl x\nKd 1 red 0\n", "a.mtl").contains("a.mtl:2:6: 'red' is not a number"));
    assert!(told(b"newmtl x\nKd nan 0 0\n", "a.mtl").contains("nan is not finite"));
    assert!(told(b"\xFF\xFEn\0", "a.mtl").contains("UTF-16"));
    assert!(told(b"", "../a.mtl").contains("cannot be opened") || told(b"", "../a.mtl").contains("outside"));
    assert!(told(b"", "/etc/hostname").contains("absolute"));
}

#[test]
fn solids_of_an_stl_are_objects() {
    let facet = |corners: [[f64; 3]; 3]| {
        let vertices: String = corners.iter().map(|[x, y, z]| format!("vertex {x} {y} {z}\n")).collect();
        format!("facet normal 0 0 0\nouter loop\n{vertices}endloop\nendfacet\n")
    };
    let solid = |name: &str, x: f64| {
        let corner = [[x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [x, 1.0, 0.0], [x, 0.0, 1.0]];
        let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let facets: String = faces.map(|face| facet(face.map(|i: usize| corner[i]))).concat();
        format!("solid {name}\n{facets}endsolid {name}\n")
    };
    let two = solid("left part", 0.0) + &solid("right", 5.0);
    let expected = [("left part", None, 4), ("right", None, 4)];
    assert_eq!(objects(&ok("two.stl", two.clone()).scene), expected);
    assert_eq!(objects(&ok("two.stl", two.replace('\n', " ")).scene), expected);
    let unnamed = ok("two.stl", solid("", 0.0) + &solid("", 5.0));
    assert_eq!(objects(&unnamed.scene), [("two", None, 8)]);
}

const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                   property float nx\nproperty float ny\nproperty float nz\nproperty uchar red\nproperty uchar green\n\
                   property uchar blue\nproperty float s\nproperty float t\nproperty float quality\nproperty float p_0\n\
                   property float p_1\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
                   0 0 0 0 0 1 255 0 51 0 0 9 1 2\n1 0 0 0 0 1 0 255 0 1 0 8 3 4\n0 1 0 0 0 1 0 0 255 0 1 7 5 6\n3 0 1 2\n";

#[test]
fn properties_of_ply_vertices_are_attributes() {
    let document = ok("a.ply", PLY);
    assert!(document.notes.is_empty(), "{:?}", document.notes);
    let [mesh] = meshes(&document.scene)[..] else { panic!() };
    let names: Vec<_> = mesh.attributes.iter().map(|a| (a.name.as_str(), a.width)).collect();
    assert_eq!(names, [("color", 3), ("normal", 3), ("uv", 2), ("quality", 1), ("p", 2)]);
    assert_eq!(values(mesh, "color", 0)[0], [1.0, 0.0, 0.2]);
    assert_eq!(values(mesh, "uv", 0)[2], [0.0, 1.0]);
    assert_eq!(values(mesh, "p", 0)[1], [3.0, 4.0]);
}

#[test]
fn texture_coordinates_and_colours_of_ply_faces_are_attributes() {
    let text = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
                element face 2\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n\
                property list uchar int vertex_indices\nproperty list uchar float texcoord\nend_header\n\
                0 0 0\n1 0 0\n1 1 0\n0 1 0\n255 0 0 4 0 1 2 3 8 0 0 1 0 1 1 0 1\n0 0 255 3 0 2 1 5 1 2 3 4 5\n";
    let document = ok("a.ply", text);
    let [mesh] = meshes(&document.scene)[..] else { panic!() };
    assert_eq!(values(mesh, "uv", 1), [vec![0.0, 0.0], vec![1.0, 1.0], vec![0.0, 1.0]]);
    // Five numbers are no coordinates of three corners.
    let notes: Vec<String> = document.notes.iter().map(ToString::to_string).collect();
    let [left_out, _cut] = &notes[..] else { panic!("{notes:?}") };
    assert!(left_out.contains("1 list of values of the corners of a face was left out"), "{left_out}");
    assert!(left_out.ends_with("'texcoord' on line 19"), "{left_out}");
    assert!(values(mesh, "uv", 2).iter().all(Vec::is_empty));
    assert_eq!(values(mesh, "color", 1)[0], [1.0, 0.0, 0.0]);
    assert_eq!(values(mesh, "color", 2)[2], [0.0, 0.0, 1.0]);
}

#[test]
fn colours_of_faces_are_noted_where_vertices_have_colours() {
    let text = PLY.replace(
        "element face 1\n",
        "element face 1\nproperty uchar r\nproperty uchar g\nproperty uchar b\n",
    );
    let document = ok("a.ply", text.replace("\n3 0 1 2", "\n1 2 3 3 0 1 2"));
    let [mesh] = meshes(&document.scene)[..] else { panic!() };
    assert_eq!(values(mesh, "color", 0)[0], [1.0, 0.0, 0.2]);
    let [note] = &document.notes[..] else { panic!("{:?}", document.notes) };
    assert_eq!(note.kind, "attributes_left_out");
    assert!(note.text.ends_with("color of faces, since vertices have it"), "{note}");
}

#[test]
fn attributes_keep_apart_in_ply() {
    let names = ["a b", "a_b", "red", "green", "blue", "x", "color", "s", "t"];
    let corner = Some(vec![[0, 1, 2], [1, 2, 3]]);
    let value = |i: usize| vec![i as f64, 0.25, 1.0, 0.5];
    let mut mesh = painted();
    mesh.attributes =
        names.iter().enumerate().map(|(i, name)| Attribute::of_vertices(*name, 1, value(i))).collect();
    let of_corners = Attribute::of_vertices("a\tb", 1, value(names.len()));
    mesh.attributes.push(Attribute { corners: corner.clone(), ..of_corners });
    let mut scene = Scene::default();
    let node = scene.add(Node::Mesh { mesh: mesh.clone().into(), file: None });
    scene.add_object("painted", None, node);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.ply");
    let notes = save(&path, &scene).unwrap();
    let renamed = "'a b' is 'a_b_2', ";
    assert!(notes.iter().any(|note| note.contains(renamed)), "{notes:?}");
    let noted = save(folder.path().join("a.json"), &scene).unwrap();
    assert!(
        noted.iter().any(|note| note.starts_with("a-mesh0.ply: ") && note.contains(renamed)),
        "{noted:?}"
    );
    let back = load(&path).unwrap().scene;
    let [found] = meshes(&back)[..] else { panic!() };
    let mut firsts: Vec<f64> = found.attributes.iter().map(|a| a.values[0]).collect();
    firsts.sort_by(f64::total_cmp);
    assert_eq!(firsts, (0..=names.len()).map(|i| i as f64).collect::<Vec<_>>());
    // A single number that is called a colour is not in 256 steps.
    assert_eq!(found.attribute("color").unwrap().values, mesh.attribute("color").unwrap().values);
}

/// A mesh with attributes of all forms.
fn painted() -> TriangleMesh {
    let mut mesh = TriangleMesh::new(vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z], vec![[0, 2, 1], [0, 1, 3]]);
    let of_vertices = |name: &str, width, step: f64| {
        Attribute::of_vertices(name, width, (0..4 * width).map(|i| i as f64 * step).collect())
    };
    let corners = Some(vec![[0, 1, NO_ROW], [3, 3, 2]]);
    mesh.attributes = vec![
        of_vertices("color", 3, 1.0 / 255.0),
        of_vertices("normal", 3, 0.125),
        of_vertices("heat", 1, 0.1),
        of_vertices("flow", 2, 0.1),
        Attribute { corners: corners.clone(), ..of_vertices("uv", 2, 0.3) },
        Attribute { corners, ..of_vertices("weight", 1, 0.7) },
    ];
    mesh
}

#[test]
fn ply_and_obj_keep_attributes() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = painted();
    let mut scene = Scene::default();
    let node = scene.add(Node::Mesh { mesh: mesh.clone().into(), file: None });
    scene.add_object("painted", None, node);
    let written = |name: &str| {
        let path = folder.path().join(name);
        let notes = save(&path, &scene).unwrap();
        (notes, load(&path).unwrap().scene)
    };
    let bits =
        |value: Vec<f64>| value.iter().filter(|x| !x.is_nan()).map(|x| x.to_bits()).collect::<Vec<_>>();
    let check = |back: &Scene, names: &[&str]| {
        let [found] = meshes(back)[..] else { panic!() };
        assert_eq!(found.attributes.len(), names.len());
        for name in names {
            for face in [0, 1] {
                let (a, b) = (values(found, name, face), values(&mesh, name, face));
                assert_eq!(a.map(bits), b.map(bits), "{name}");
            }
        }
    };
    let (notes, ply) = written("a.ply");
    check(&ply, &["color", "normal", "heat", "flow", "uv", "weight"]);
    assert!(notes.is_empty(), "{notes:?}");
    let head = String::from_utf8_lossy(&std::fs::read(folder.path().join("a.ply")).unwrap()).into_owned();
    for line in ["uchar red", "float nx", "double heat", "double flow_1", "list uchar double texcoord"] {
        assert!(head.contains(&format!("property {line}\n")), "{line}");
    }
    let (notes, obj) = written("a.obj");
    check(&obj, &["color", "uv", "normal"]);
    assert_eq!(notes, ["attributes of corners are lost: heat, flow, weight"]);
    let (notes, stl) = written("a.stl");
    check(&stl, &[]);
    assert!(notes.iter().any(|note| note.contains("color, normal, heat, flow, uv, weight")), "{notes:?}");
    // A scene file names the file that still holds the mesh, attributes included.
    let mut named = load(folder.path().join("a.ply")).unwrap().scene;
    save(folder.path().join("same.json"), &named).unwrap();
    assert!(!folder.path().join("same-mesh0.ply").exists());
    let Node::Mesh { mesh, .. } = &mut named.nodes[0] else { panic!() };
    std::sync::Arc::make_mut(mesh).attributes[0].values[0] = 1.0;
    save(folder.path().join("other.json"), &named).unwrap();
    assert!(folder.path().join("other-mesh0.ply").exists());
}
