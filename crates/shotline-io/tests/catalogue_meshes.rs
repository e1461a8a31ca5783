//! The catalogue of bad input, for mesh files: one test per row. Headers that announce more data than the file has, and
//! the memory that they may cost, are tested in `hostile.rs`; the files that a scene may name in `scene_files.rs`.

use std::path::Path;

use shotline::compile::{Options, compile};
use shotline::math::Vec3;
use shotline::scene::Node;
use shotline::solid::mesh::{Topology, TriangleMesh};
use shotline_io::{Document, FORMATS, ReadError, Spot};

fn read(extension: &str, bytes: &[u8]) -> Result<Document, ReadError> {
    let format = FORMATS.iter().find(|f| f.extensions.contains(&extension)).unwrap();
    format.read(Path::new(&format!("part.{extension}")), bytes.to_vec())
}

fn mesh(document: &Document) -> &TriangleMesh {
    match &document.scene.nodes[0] {
        Node::Mesh { mesh, .. } => mesh,
        other => panic!("{other:?}"),
    }
}

/// Asserts that reading fails with a message that contains every fragment and a help.
#[track_caller]
fn refused(extension: &str, bytes: impl AsRef<[u8]>, fragments: &[&str]) {
    let shown = read(extension, bytes.as_ref()).expect_err("broken").to_string();
    for fragment in fragments {
        assert!(shown.contains(fragment), "{fragment}\nis not in\n{shown}");
    }
    assert!(shown.contains("\nhelp: "), "{shown}");
}

fn ply(vertices: &[&str], faces: &[&str]) -> String {
    format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n{}\n{}\n",
        vertices.len(),
        faces.len(),
        vertices.join("\n"),
        faces.join("\n")
    )
}

/// Triangles without normals.
fn binary_stl(head: &[u8], triangles: &[[f32; 9]]) -> Vec<u8> {
    let mut bytes = head.to_vec();
    bytes.resize(80, 0);
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for corners in triangles {
        bytes.extend([0; 12]);
        bytes.extend(corners.iter().flat_map(|x| x.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

const TRIANGLE: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];

#[test]
fn empty_mesh() {
    refused("ply", ply(&["0 0 0"], &[]), &["part.ply: has no faces", "help: a mesh needs an element 'face'"]);
    refused("obj", "v 0 0 0\n", &["part.obj: has no faces", "help: a mesh needs lines 'f 1 2 3'"]);
    refused("obj", "", &["part.obj: has no faces"]);
    refused("stl", binary_stl(b"", &[]), &["part.stl: has no triangles"]);
    refused("stl", "solid a\nendsolid a\n", &["part.stl: has no triangles"]);
    refused("stl", "", &["part.stl: byte 0: the file ends within the head"]);
    // There are faces, but none with three different corners. Only the compiler checks that.
    let flat = read("obj", b"v 0 0 0\nf 1 1 1\n").unwrap();
    let errors = compile(&flat.scene, Options::default()).unwrap_err();
    assert!(errors[0].message.contains("no face with three different corners"), "{errors:?}");
}

#[test]
fn index_out_of_range_or_negative() {
    let three = ["0 0 0", "1 0 0", "0 1 0"];
    refused(
        "ply",
        ply(&three, &["3 0 1 2", "3 0 1 3"]),
        &["part.ply:14:1: face 1 names vertex 3, but there are 3"],
    );
    refused("ply", ply(&three, &["3 0 1 -1"]), &["part.ply:13:1: face 0 names vertex -1"]);
    refused(
        "ply",
        ply(&three, &["3 0 1 4294967296"]),
        &["4294967296 is not within -2147483648 and 2147483647"],
    );
    refused("ply", ply(&three, &["2 0 1"]), &["has no faces", "faces of three corners or more"]);
    refused("ply", ply(&three, &["0"]), &["has no faces"]);
    let obj = |face: &str| format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nf {face}\n");
    refused("obj", obj("1 2 4"), &["part.obj:4:1: there is no vertex 4; the file has 3, counted from 1"]);
    refused("obj", obj("1 2 0"), &["part.obj:4:7: vertices count from 1; there is no vertex 0"]);
    refused("obj", obj("1 2 -4"), &["part.obj:4:7: -4 counts back further than the 3 vertices before"]);
    refused("obj", obj("1 2 99999999999999999999"), &["'99999999999999999999' is not a vertex of a face"]);
}

#[test]
fn nan_vertices() {
    refused(
        "ply",
        ply(&["0 0 0", "1 nan 0"], &["3 0 1 1"]),
        &["part.ply:11:1: this vertex has a coordinate that is NaN or infinite, and faces use it"],
    );
    refused(
        "ply",
        ply(&["0 0 1e400"], &["3 0 0 0"]),
        &["this vertex has a coordinate that is NaN or infinite"],
    );
    refused(
        "obj",
        "v 0 inf 0\nf 1 1 1\n",
        &["part.obj:1:5: this vertex has a coordinate that is NaN or infinite, and faces use it"],
    );
    refused("stl", "solid a\nfacet\nvertex 0 0 NaN\n", &["part.stl:3:12: NaN is not finite"]);
    let mut broken = TRIANGLE;
    broken[4] = f32::NAN;
    refused(
        "stl",
        binary_stl(b"", &[TRIANGLE, broken]),
        &["byte 134: triangle 1 has a coordinate that is NaN"],
    );
}

/// Faces without area are counted and stay in the mesh, since their edges may close it.
#[test]
fn faces_without_area_or_doubled() {
    let pyramid = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    let vertices = vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z, Vec3::X * 0.5];
    let with = |more: &[[u32; 3]]| {
        let faces = pyramid.iter().chain(more).copied().collect();
        Topology::of(&TriangleMesh::new(vertices.clone(), faces)).unwrap()
    };
    let degenerate = with(&[[0, 0, 1]]);
    assert!(degenerate.is_closed() && degenerate.degenerate_faces.count == 1, "{degenerate:?}");
    // A sliver closes a T-junction: without it the mesh would be open.
    let sliver = [[0, 2, 1], [0, 4, 3], [4, 1, 3], [0, 1, 4], [1, 2, 3], [2, 0, 3]];
    let topology =
        |faces: &[[u32; 3]]| Topology::of(&TriangleMesh::new(vertices.clone(), faces.to_vec())).unwrap();
    let closed = topology(&sliver);
    assert!(closed.is_closed() && closed.zero_area_faces.count == 1, "{closed:?}");
    assert!(!topology(&[&sliver[..3], &sliver[4..]].concat()).is_closed());
    let doubled = with(&pyramid);
    assert!(doubled.is_closed() && doubled.duplicate_faces.count > 0, "{doubled:?}");
}

/// A file that is truncated at any byte is an error. Text may end after its last number.
#[test]
fn truncated_files() {
    let binary = "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
                  property float z\nelement face 1\nproperty list uchar uchar vertex_indices\nend_header\n";
    let binary = [binary.as_bytes(), &[0; 36], &[3, 0, 1, 2]].concat();
    assert!(read("ply", &binary).is_ok());
    for end in 0..binary.len() {
        refused("ply", &binary[..end], &["part.ply:"]);
    }
    let stl = binary_stl(b"solid", &[TRIANGLE, TRIANGLE]);
    for end in 0..stl.len() {
        refused("stl", &stl[..end], &["part.stl:"]);
    }
    refused(
        "stl",
        &stl[..134],
        &[
            "byte 134: the count at byte 80 says 2 triangles, but the file ends after 1",
            "help: the file is cut off",
        ],
    );
    let text = ply(&["0 0 0", "1 0 0", "0 1 0"], &["3 0 1 2"]);
    for end in 0..text.trim_end().len() {
        refused("ply", &text[..end], &["part.ply"]);
    }
}

#[test]
fn corrupt_ply_headers() {
    let cases = [
        ("plx\n", "byte 0: a PLY file begins with the line 'ply'"),
        ("ply\nend_header\n", "byte 0: the header has no format line"),
        ("ply\nformat ascii 1.0\n", "byte 21: the header has no end_header"),
        ("ply\nformat utf8 1.0\nend_header\n", "part.ply:2:8: there is no PLY format 'utf8'"),
        ("ply\nproperty int x\n", "part.ply:2:1: a property without an element"),
        ("ply\nelement vertex -1\n", "part.ply:2:16: '-1' is not a number of rows"),
        ("ply\nelement vertex 1e9\n", "'1e9' is not a number of rows"),
        ("ply\nelement a 1\nproperty half x\n", "part.ply:3:1: this is not a property of a known type"),
        ("ply\nelement a 1\nproperty list float int x\n", "this is not a property of a known type"),
        ("ply\nelement a 1\nhallo you\n", "part.ply:3:1: the header has no such line"),
        ("ply\nelement a 1\nproperty int\n", "part.ply:3:1: this line of the header is not complete"),
    ];
    for (text, message) in cases {
        refused("ply", text, &[message]);
    }
}

#[test]
fn impossible_list_lengths() {
    let corners = |line: &str| ply(&["0 0 0"], &[line]);
    refused("ply", corners("4294967296 0 0 0"), &["part.ply:11:1: 4294967296 is not within 0 and 255"]);
    refused("ply", corners("-1 0 0 0"), &["part.ply:11:1: -1 is not within 0 and 255"]);
    refused("ply", corners("3 0 0"), &["the list is longer than its line"]);
    let note = &read("ply", corners("3 0 0 0 0").as_bytes()).unwrap().notes[0];
    assert_eq!((note.kind, note.first), ("extra_numbers", Some(Spot::Line(11))));
}

/// Many binary files begin with "solid" like text files; the size decides.
#[test]
fn binary_stl_that_begins_with_solid() {
    let document = read("stl", &binary_stl(b"solid from some program", &[TRIANGLE])).unwrap();
    assert_eq!(mesh(&document).faces.len(), 1);
    let text = "solid binary\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
    assert_eq!(mesh(&read("stl", text.as_bytes()).unwrap()).faces.len(), 1);
    let spare = read("stl", &[binary_stl(b"solid", &[TRIANGLE]), vec![0]].concat()).unwrap();
    assert_eq!((mesh(&spare).faces.len(), spare.notes[0].kind), (1, "extra_bytes"));
}

#[test]
fn corrupt_text_stl() {
    let facet = |inner: &str| format!("solid a\nfacet\n{inner}\n");
    refused("stl", facet("vertex 0 0 0"), &["the file ends within a facet", "help: it is cut off"]);
    refused("stl", facet("vertex 0 0\nendfacet"), &["part.stl:3:1: a vertex has three coordinates"]);
    refused(
        "stl",
        facet("vertex 0 0 0\nendfacet"),
        &["part.stl:4:1: this facet has 1 corner; it needs three"],
    );
    refused("stl", facet("vertex 0 0 x"), &["part.stl:3:12: 'x' is not a number"]);
    refused("stl", facet("<html>"), &["part.stl:3:1: '<html>' is not a word of an STL file"]);
}

#[test]
fn unknown_format() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("part.xyz");
    std::fs::write(&path, "1 2 3").unwrap();
    let shown = shotline_io::load(&path).unwrap_err().to_string();
    assert!(
        shown.contains("is of no known format") && shown.contains("help: known are .gltf, .glb, .json"),
        "{shown}"
    );
}
