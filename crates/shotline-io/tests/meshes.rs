//! Mesh files are written and read back; wrong ones are reported.

use shotline::math::{Affine, Vec3};
use shotline::scene::{Node, Scene};
use shotline::solid::mesh::TriangleMesh;
use shotline_io::{Spot, load, read_mesh, save, write_scene};

fn tetrahedron() -> TriangleMesh {
    let vertices =
        vec![Vec3::new(0.1, -0.0, 1e-300), Vec3::new(1.0, 0.0, 0.0), Vec3::Y, Vec3::new(0.0, 1e300, 0.3)];
    TriangleMesh::new(vertices, vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
}

fn scene_of(mesh: TriangleMesh) -> Scene {
    let mut scene = Scene::default();
    let node = scene.add(Node::Mesh { mesh: mesh.into(), file: None });
    scene.add_object("part", None, node);
    scene
}

fn bits(mesh: &TriangleMesh) -> Vec<[[u64; 3]; 3]> {
    let corner = |i: u32| mesh.vertices[i as usize].to_array().map(f64::to_bits);
    mesh.faces.iter().map(|f| f.map(corner)).collect()
}

#[test]
fn every_format_keeps_every_bit() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = tetrahedron();
    for name in ["a.ply", "a.obj", "a.stl"] {
        let path = folder.path().join(name);
        let notes = save(&path, &scene_of(mesh.clone())).unwrap();
        assert_eq!(notes.len(), usize::from(name == "a.stl"), "{notes:?}");
        let back = read_mesh(&path).unwrap();
        assert_eq!(bits(&back), bits(&mesh), "{name}");
        assert_eq!(back.vertices.len(), 4, "{name}");
    }
}

#[test]
fn float32_coordinates_go_to_binary_stl() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.stl");
    let mut mesh = tetrahedron();
    mesh.vertices[0] = Vec3::new(0.5, 0.25, -2.0);
    mesh.vertices[3] = Vec3::Z;
    assert!(save(&path, &scene_of(mesh.clone())).unwrap().is_empty());
    assert_eq!(std::fs::metadata(&path).unwrap().len(), 84 + 4 * 50);
    assert_eq!(bits(&read_mesh(&path).unwrap()), bits(&mesh));
}

#[test]
fn a_bare_mesh_is_a_scene_of_one_object() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bolt.ply");
    save(&path, &scene_of(tetrahedron())).unwrap();
    let document = load(&path).unwrap();
    let Node::Object { name, material: None, .. } = document.scene.node(document.scene.objects[0]) else {
        panic!()
    };
    assert_eq!(name, "bolt");
    assert!(write_scene(&document.scene).unwrap().contains(r#""file": "bolt.ply""#));
}

#[test]
fn meshes_are_saved_beside_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rig.json");
    let notes = save(&path, &scene_of(tetrahedron())).unwrap();
    assert_eq!(notes, ["a mesh was written to rig-mesh0.ply"]);
    let document = load(&path).unwrap();
    let found = document
        .scene
        .nodes
        .iter()
        .find_map(|n| if let Node::Mesh { mesh, .. } = n { Some(mesh) } else { None });
    assert_eq!(bits(found.unwrap()), bits(&tetrahedron()));
    assert!(save(&path, &document.scene).unwrap().is_empty());
    // A mesh of another scene stays as it is.
    let other = folder.path().join("rig.ply");
    std::fs::rename(folder.path().join("rig-mesh0.ply"), &other).unwrap();
    std::fs::write(folder.path().join("rig-mesh0.ply"), "not ours").unwrap();
    assert_eq!(save(&path, &scene_of(tetrahedron())).unwrap(), ["a mesh was written to rig-mesh1.ply"]);
    assert_eq!(std::fs::read(folder.path().join("rig-mesh0.ply")).unwrap(), b"not ours");
}

#[test]
fn what_is_lost_in_stl_is_noted() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.stl");
    let mut mesh = tetrahedron();
    mesh.vertices.push(mesh.vertices[0]);
    mesh.faces[1] = mesh.faces[1].map(|v| if v == 0 { 4 } else { v });
    mesh.vertices.push(Vec3::splat(0.1));
    let notes = save(&path, &scene_of(mesh)).unwrap();
    assert!(notes[0].contains("would move"), "{notes:?}");
    assert!(notes[1].starts_with("vertices lost: 2 of 6"), "{notes:?}");
    assert_eq!(read_mesh(&path).unwrap().vertices.len(), 4);
}

#[test]
fn meshes_are_joined_and_mirrors_reverse_faces() {
    let folder = tempfile::tempdir().unwrap();
    let mut scene = scene_of(tetrahedron());
    let placed = scene.add_transform(Affine::scaling(Vec3::new(-1.0, 1.0, 1.0)), shotline::scene::NodeId(0));
    scene.add_object("mirrored", None, placed);
    let notes = save(folder.path().join("a.obj"), &scene).unwrap();
    let expected = [
        "shared meshes are written out for each of their placements, 2 in all",
        "vertices moved into place, and rounded to float64: 4",
    ];
    assert_eq!(notes, expected);
    let back = read_mesh(folder.path().join("a.obj")).unwrap();
    assert_eq!((back.vertices.len(), back.faces.len()), (8, 8));
    assert_eq!(back.faces[4], [4, 5, 6]);
    let notes = save(folder.path().join("a.off"), &scene).unwrap();
    assert_eq!(notes[0], "2 objects were joined into one mesh; their names are lost");
    scene.add_solid("sphere", &[&[1.0]]);
    let ball = shotline::scene::NodeId(scene.nodes.len() as u32 - 1);
    scene.add_object("ball", None, ball);
    let refused = save(folder.path().join("a.obj"), &scene).unwrap_err().to_string();
    assert!(refused.contains("has a solid of the kind sphere"), "{refused}");
}

fn refusal(name: &str, text: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, text).unwrap();
    let shown = load(&path).unwrap_err().to_string();
    shown.replace(&format!("{}/", folder.path().display()), "")
}

#[test]
fn wrong_meshes_are_refused_with_the_location() {
    let obj = refusal("a.obj", "v 0 0 0\nv 1 0 nan\nv 0 1 0\nf 1 2 3\n");
    assert_eq!(
        obj,
        "a.obj:2:7: this vertex has a coordinate that is NaN or infinite, and faces use it\n    v 1 0 nan\n          ^^^\n\
         help: mend this line, or export the mesh again"
    );
    let obj = refusal("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n");
    assert!(obj.starts_with("a.obj:4:1: there is no vertex 9; the file has 3, counted from 1"), "{obj}");
    assert!(refusal("a.obj", "v 0 0 0\nf 0 1 1\n").contains("a.obj:2:3: vertices count from 1"));
    assert!(refusal("a.obj", "v 0 0 0\nf 1 1 -2\n").contains("counts back further"));
    assert!(refusal("a.obj", "v 0 0 0\n").contains("has no faces"));
    let head = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n";
    assert!(
        refusal("a.ply", &format!("{head}0 inf 0\n3 0 1 2\n"))
            .contains("a.ply:12:1: this vertex has a coord")
    );
    assert!(
        refusal("a.ply", &format!("{head}0 1 0\n3 0 1 3\n"))
            .contains("13:1: face 0 names vertex 3, but there are 3")
    );
    assert!(refusal("a.ply", &format!("{head}0 1 0\n3 0 1 -1\n")).contains("names vertex -1"));
    assert!(refusal("a.ply", &format!("{head}0 1\n3 0 1 2\n")).contains("12:1: numbers are missing"));
    assert!(refusal("a.ply", &format!("{head}0 1 0\n2 0 1\n")).contains("has no faces"));
    assert!(refusal("a.ply", &format!("{head}0 1 0\n")).contains("ends before its last row"));
    let stl =
        "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nendloop\nendfacet\nendsolid\n";
    assert!(refusal("a.stl", stl).contains("a.stl:7:1: this facet has 2 corners; it needs three"));
    assert!(refusal("a.stl", &stl[..38]).contains("byte 38: the file ends within a facet"));
    assert!(refusal("a.txt", "hello").contains("is of no known format"));
    assert!(refusal("a.json", "\u{FEFF}").contains("a value is missing"));
}

#[test]
fn polygons_are_cut_and_counted() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.obj");
    std::fs::write(&path, "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1/1 2/2/2 3//3 4\nf -4 -3 -2\n").unwrap();
    let document = load(&path).unwrap();
    let note = document.notes.iter().find(|n| n.kind == "polygons_cut").unwrap();
    assert!(note.to_string().ends_with("a.obj: 1 polygon was cut into triangles, on line 5"), "{note}");
    assert_eq!((note.kind, note.count, note.first), ("polygons_cut", 1, Some(Spot::Line(5))));
    assert_eq!(read_mesh(&path).unwrap().faces, [[0, 1, 2], [0, 2, 3], [0, 1, 2]]);
}

#[cfg(unix)]
#[test]
fn only_regular_files_are_opened() {
    assert!(load("/dev/null").unwrap_err().to_string().contains("is not a regular file"));
    assert!(load("/nowhere/a.ply").unwrap_err().to_string().contains("cannot be read"));
}
