//! Files of meshes that keep the objects of a scene: what is written is read back.

use std::path::Path;
use std::sync::Arc;

use shotline::math::{Affine, ComposedTransform, Vec3};
use shotline::scene::{Material, Node, NodeId, Scene, Units};
use shotline::solid::mesh::{Topology, TriangleMesh};
use shotline_io::{load, save};

/// A closed mesh with coordinates that float32 does not hold, and a vertex of no face.
fn tetrahedron(size: f64) -> TriangleMesh {
    let corners =
        [Vec3::new(0.1, 0.2, -0.0), Vec3::X, Vec3::new(0.0, 1.0 / 3.0, 0.0), Vec3::new(0.1, 0.1, 0.7)];
    let mut vertices: Vec<Vec3> = corners.iter().map(|corner| *corner * size).collect();
    vertices.insert(1, Vec3::NAN);
    TriangleMesh::new(vertices, vec![[0, 3, 2], [0, 2, 4], [2, 3, 4], [3, 0, 4]])
}

/// A name that every format has to write with care.
const ODD: &str = "a \"b\" <c> & d";

fn shift(x: f64) -> Affine {
    Affine::translation(Vec3::new(x, 0.1, 0.0))
}

/// Three objects: a pin that is placed twice, a pair of meshes, and one without a material.
fn scene() -> Scene {
    let color = |color| Material { color, ..Material::default() };
    let mut scene = Scene::default()
        .with_units(Units::Millimetres)
        .with_material("steel", Material { specular: Some(0.5), ..color(Some([0.2, 0.4, 1.0])) })
        .with_material("a 'rare' <earth>", Material { density: Some(3.0), ..color(Some([1.0, 0.0, 0.6])) })
        .with_material("air", Material::default());
    let small = scene.add(Node::Mesh { mesh: Arc::new(tetrahedron(1.0)), file: None });
    let large = scene.add(Node::Mesh { mesh: Arc::new(tetrahedron(3.0)), file: None });
    scene.add_object("pin", Some("steel"), small);
    let pin = scene.objects[0];
    let turned = Affine::rotation_xyz(Vec3::new(0.0, 0.0, 30.0)).then_after(&shift(5.0));
    let placed = scene.add_transform(turned, pin);
    scene.objects.push(placed);
    let far = scene.add_transform(shift(10.0), large);
    let pair = scene.add(Node::Group { members: vec![large, far] });
    scene.add_object(ODD, Some("a 'rare' <earth>"), pair);
    let mirror = scene.add_transform(Affine::scaling(Vec3::new(-1.0, 1.0, 1.0)), small);
    let mirror = scene.add_transform(shift(-20.0), mirror);
    scene.add_object("plain", None, mirror);
    scene
}

/// An object at the root: its name, its material, its mesh and where it is placed.
struct Found<'s> {
    name: &'s str,
    material: Option<&'s str>,
    mesh: &'s Arc<TriangleMesh>,
    placed: Affine,
}

impl Found<'_> {
    /// The corners of each face in the world.
    fn corners(&self) -> Vec<Vec3> {
        let corner = |vertex: &u32| self.placed.point(self.mesh.vertices[*vertex as usize]);
        self.mesh.faces.iter().flatten().map(corner).collect()
    }
}

fn found(scene: &Scene) -> Vec<Found<'_>> {
    let below = |mut id: NodeId, mut placed: ComposedTransform| {
        while let Node::Transform { transform, child } = scene.node(id) {
            (id, placed) = (*child, transform.inside(&placed));
        }
        (id, placed)
    };
    let of_root = |root: &NodeId| {
        let (id, placed) = below(*root, ComposedTransform::IDENTITY);
        let Node::Object { name, material, node, .. } = scene.node(id) else { panic!("no object") };
        let (id, placed) = below(*node, placed);
        let Node::Mesh { mesh, .. } = scene.node(id) else { panic!("no mesh") };
        Found {
            name,
            material: material.as_deref(),
            mesh,
            placed: placed.placement().unwrap().parent_from_local,
        }
    };
    scene.objects.iter().map(of_root).collect()
}

/// Saves the scene and reads it back; returns the notes too.
fn saved(scene: &Scene, path: &Path) -> (Scene, Vec<String>) {
    let notes = save(path, scene).unwrap();
    let first = std::fs::read(path).unwrap();
    save(path, scene).unwrap();
    assert_eq!(std::fs::read(path).unwrap(), first, "the bytes are the same each time");
    let back = load(path).unwrap();
    // Formats of text keep the vertex that no face uses.
    let is_known = |kind| ["vertices_not_finite", "unused_vertices"].contains(&kind);
    assert!(back.notes.iter().all(|note| is_known(note.kind)), "{:?}", back.notes);
    (back.scene, notes)
}

fn color(scene: &Scene, name: &str) -> Option<[f64; 3]> {
    scene.materials.iter().find(|(known, _)| known == name).expect(name).1.color
}

/// The corners in the world of the objects of [`scene`], and the names of their materials.
fn expected() -> Vec<(&'static str, Option<&'static str>, Vec<Vec3>)> {
    let corners = |size: f64, placed: Affine, order: [usize; 3]| -> Vec<Vec3> {
        let mesh = tetrahedron(size);
        let of_face = |face: &[u32; 3]| order.map(|i| placed.point(mesh.vertices[face[i] as usize]));
        mesh.faces.iter().flat_map(of_face).collect()
    };
    let turned = Affine::rotation_xyz(Vec3::new(0.0, 0.0, 30.0)).then_after(&shift(5.0));
    let mirrored = shift(-20.0).then_after(&Affine::scaling(Vec3::new(-1.0, 1.0, 1.0)));
    let plain = [0, 1, 2];
    let pair = [corners(3.0, Affine::IDENTITY, plain), corners(3.0, shift(10.0), plain)].concat();
    vec![
        ("pin", Some("steel"), corners(1.0, Affine::IDENTITY, plain)),
        ("pin_2", Some("steel"), corners(1.0, turned, plain)),
        (ODD, Some("a 'rare' <earth>"), pair),
        ("plain", None, corners(1.0, mirrored, [0, 2, 1])),
    ]
}

#[track_caller]
fn assert_objects(back: &Scene, second: &str, materials: bool, tolerance: f64, world: impl Fn(Vec3) -> Vec3) {
    let found = found(back);
    assert_eq!(found.len(), 4);
    for (found, (name, material, corners)) in found.iter().zip(expected()) {
        let name = if name == "pin_2" { second } else { name };
        assert_eq!((found.name, found.material), (name, material.filter(|_| materials)));
        assert!(Topology::of(found.mesh).unwrap().is_closed(), "{name}");
        let mut distances = found.corners().into_iter().zip(&corners).map(|(a, b)| (a - world(*b)).length());
        // The faces of a mesh that a transform mirrors are stored in the other direction.
        let is_mirrored = found.placed.determinant() < 0.0;
        assert_eq!(found.mesh.faces.len() * 3, corners.len());
        assert!(is_mirrored || distances.all(|distance| distance <= tolerance), "{name}");
    }
}

#[test]
fn obj_keeps_objects_and_materials() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("my part.obj");
    let (back, notes) = saved(&scene(), &path);
    assert_objects(&back, "pin_2", true, 0.0, |corner| corner);
    assert_eq!(color(&back, "steel"), Some([0.2, 0.4, 1.0]));
    assert_eq!(back.materials[0].1.specular, Some(0.5));
    assert_eq!(color(&back, "a 'rare' <earth>"), Some([1.0, 0.0, 0.6]));
    let told = [
        "the units, mm, are lost",
        "of materials only names, colours and highlights are kept",
        "the materials were written to my_part.mtl",
    ];
    told.iter().for_each(|note| assert!(notes.iter().any(|other| other == note), "{note}: {notes:?}"));
    // The only change of a name is that of the second placement of the pin.
    assert!(notes.iter().any(|note| note.ends_with("each must differ and be one line: 1")), "{notes:?}");
}

#[test]
fn other_files_of_materials_are_not_overwritten() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.mtl"), "newmtl mine\n").unwrap();
    let (back, notes) = saved(&scene(), &folder.path().join("a.obj"));
    assert_eq!(notes.last().unwrap(), "the materials were written to a-1.mtl");
    assert_eq!(color(&back, "steel"), Some([0.2, 0.4, 1.0]));
    assert_eq!(std::fs::read(folder.path().join("a.mtl")).unwrap(), b"newmtl mine\n");
    // A scene without materials has no such file.
    let mut bare = scene();
    bare.materials.clear();
    save(folder.path().join("b.obj"), &bare).unwrap();
    assert!(!folder.path().join("b.mtl").exists());
}

#[test]
fn text_stl_keeps_objects() {
    let folder = tempfile::tempdir().unwrap();
    let (back, notes) = saved(&scene(), &folder.path().join("a.stl"));
    assert_objects(&back, "pin_2", false, 0.0, |corner| corner);
    assert!(notes.iter().any(|note| note == "materials are lost"), "{notes:?}");
    // Words of the format in names are no part of it.
    let mut odd = scene();
    let node = odd.add(Node::Mesh { mesh: Arc::new(tetrahedron(1.0)), file: None });
    let node = odd.add_transform(shift(50.0), node);
    odd.add_object("endsolid # facet \n normal 0 0 1", None, node);
    let (back, _) = saved(&odd, &folder.path().join("b.stl"));
    assert_eq!(found(&back)[4].name, "endsolid_ _ facet_ normal 0 0 1");
    // Binary files hold one solid.
    let mut round = Scene::default();
    for x in [0.0, 4.0] {
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z].map(|corner| corner + Vec3::X * x).to_vec();
        let mesh = TriangleMesh::new(corners, vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]);
        let node = round.add(Node::Mesh { mesh: mesh.into(), file: None });
        round.add_object(&format!("at {x}"), None, node);
    }
    let (back, notes) = saved(&round, &folder.path().join("c.stl"));
    assert_eq!(notes, ["2 objects were joined into one mesh: binary STL holds one, without a name"]);
    assert_eq!(found(&back).len(), 1);
}

#[test]
fn three_mf_keeps_objects_materials_and_every_bit() {
    let folder = tempfile::tempdir().unwrap();
    let (back, notes) = saved(&scene(), &folder.path().join("a.3mf"));
    assert_objects(&back, "pin", true, 0.0, |corner| corner);
    assert_eq!(back.units, Some(Units::Millimetres));
    assert_eq!(color(&back, "steel"), Some([0.2, 0.4, 1.0]));
    let told = [
        "of materials only names and colours are kept",
        "objects of several meshes, which were joined into one: 1",
        "materials without a colour became white: 1",
    ];
    assert_eq!(notes, told);
    let found = found(&back);
    assert!(Arc::ptr_eq(found[0].mesh, found[1].mesh), "the pin is stored once");
    let bits = |mesh: &TriangleMesh| -> Vec<[u64; 3]> {
        mesh.vertices.iter().filter(|v| v.is_finite()).map(|v| v.to_array().map(f64::to_bits)).collect()
    };
    assert_eq!(bits(found[0].mesh), bits(&tetrahedron(1.0)));
}

#[test]
fn units_that_three_mf_lacks_are_scaled() {
    let folder = tempfile::tempdir().unwrap();
    let (back, notes) = saved(&scene().with_units(Units::Kilometres), &folder.path().join("a.3mf"));
    assert!(
        notes.contains(&"3MF has no unit of kilometres: the items of the build are scaled to meters".into())
    );
    assert_eq!(back.units, Some(Units::Metres));
    assert_objects(&back, "pin", true, 1e-10, |corner| corner * 1000.0);
    let bare = Scene { units: None, ..scene() };
    let (_, notes) = saved(&bare, &folder.path().join("b.3mf"));
    assert!(notes.contains(&"the scene has no units: its lengths are written as millimetres".into()));
}

#[test]
fn gltf_keeps_objects_and_materials_in_float32() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["a.glb", "a.gltf", "A.GLTF"] {
        let (back, notes) = saved(&scene(), &folder.path().join(name));
        let y_up = |corner: Vec3| Vec3::new(corner.x, corner.z, -corner.y) * 1e-3;
        assert_objects(&back, "pin_2", true, 1e-8, y_up);
        assert_eq!(back.units, Some(Units::Metres));
        for (name, expected) in [("steel", [0.2, 0.4, 1.0]), ("a 'rare' <earth>", [1.0, 0.0, 0.6])] {
            let color = color(&back, name).unwrap();
            assert!(color.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{color:?}");
        }
        assert_eq!(color(&back, "air"), None);
        let found = found(&back);
        // The pin and the mirrored object are one mesh with and without a material.
        assert!(Arc::ptr_eq(found[0].mesh, found[1].mesh) && Arc::ptr_eq(found[0].mesh, found[3].mesh));
        let rounded = tetrahedron(1.0).vertices.into_iter().filter(|v| v.is_finite());
        let rounded: Vec<Vec3> =
            rounded.map(|v| Vec3::from_array(v.to_array().map(|x| f64::from(x as f32)))).collect();
        assert_eq!(found[0].mesh.vertices, rounded);
        let told = [
            "of materials only names and colours are kept",
            "objects of several meshes, which were joined into one: 1",
            "z is up in the scene, y in glTF: the root node turns it, and scales mm to metres",
        ];
        assert_eq!(notes[..3], told);
        assert!(notes[3].starts_with("vertices rounded to float32: 9 of 12, by at most "), "{notes:?}");
    }
    let text = std::fs::read_to_string(folder.path().join("a.gltf")).unwrap();
    assert!(text.starts_with("{\"asset\":{\"version\":\"2.0\""));
    assert_eq!(&std::fs::read(folder.path().join("a.glb")).unwrap()[..4], b"glTF");
}

#[test]
fn cells_of_lattices_and_nested_objects_are_objects() {
    let folder = tempfile::tempdir().unwrap();
    let one = Scene { objects: scene().objects[..1].to_vec(), ..scene() };
    save(folder.path().join("ball.ply"), &one).unwrap();
    let read = |text: &str| {
        std::fs::write(folder.path().join("a.json"), text).unwrap();
        load(folder.path().join("a.json")).unwrap().scene
    };
    let ball = r#"{"kind": "mesh", "file": "ball.ply"}"#;
    let lattice = |of: &str| {
        let node = format!(r#"{{"op": "lattice", "args": [{of}], "counts": [3, 1, 1], "pitch": [2, 1, 1]}}"#);
        read(&format!(r#"{{"shotline": 1, "units": "m", "objects": [{{"name": "row", "node": {node}}}]}}"#))
    };
    let row = lattice(ball);
    let balls = lattice(&format!(r#"{{"name": "ball", "node": {ball}}}"#));
    let inner = format!(r#"{{"name": "in", "node": {ball}}}"#);
    let outer = format!(r#"{{"name": "box", "priority": 2, "node": {ball}, "contents": [{inner}]}}"#);
    let nested = read(&format!(r#"{{"shotline": 1, "objects": [{outer}]}}"#));
    for name in ["a.glb", "a.3mf", "a.obj"] {
        let path = folder.path().join(name);
        let faces =
            |scene: &Scene| found(scene).iter().map(|found| found.mesh.faces.len()).collect::<Vec<_>>();
        assert_eq!(faces(&saved(&row, &path).0), [12], "{name}: an object is one mesh");
        let (back, _) = saved(&balls, &path);
        assert_eq!(faces(&back), [4, 4, 4], "{name}");
        let is_shared = Arc::ptr_eq(found(&back)[0].mesh, found(&back)[2].mesh);
        assert_eq!(is_shared, name != "a.obj", "{name}");
        let (back, notes) = saved(&nested, &path);
        assert_eq!(found(&back).iter().map(|found| found.name).collect::<Vec<_>>(), ["box", "in"], "{name}");
        let lost = "which objects contain others, and their priorities, are lost";
        assert!(notes.iter().any(|note| note == lost), "{notes:?}");
    }
}

#[test]
fn what_is_no_mesh_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |scene: &Scene, name: &str, says: &str| {
        let path = folder.path().join(name);
        let error = save(&path, scene).unwrap_err().to_string();
        assert!(error.contains(says), "{error}");
        assert!(!path.exists());
    };
    let mut round = scene();
    let ball = round.add_solid("sphere", &[&[1.0]]).unwrap();
    round.add_object("ball", None, ball);
    for (name, format) in [("a.glb", "glTF"), ("a.gltf", "glTF"), ("a.3mf", "3MF"), ("a.obj", "OBJ")] {
        let says = format!("{format} holds triangles only, and object 'ball' has a solid of the kind sphere");
        refused(&round, name, &says);
        refused(&Scene::default(), name, "and the scene has none");
    }
    let mut huge = Scene::default();
    let node = huge.add(Node::Mesh { mesh: Arc::new(tetrahedron(1e300)), file: None });
    huge.add_object("huge", None, node);
    refused(&huge, "a.glb", "object 'huge' has a vertex beyond the largest float32");
    saved(&huge, &folder.path().join("huge.3mf"));
}
