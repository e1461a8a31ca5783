//! One function for each fault that was ever found in the readers and writers, with what was wrong. Each has the
//! shortest file that showed it.
//!
//! Faults of the core are in `shotline/tests/regressions.rs`, those of the Python package in
//! `python/tests/test_regressions.py`.

mod reading;

use std::path::Path;
use std::sync::Arc;

use shotline::math::Vec3;
use shotline::prelude::*;
use shotline::scene::{MeshFile, Node};
use shotline::solid::mesh::{TriangleMesh, Weld};
use shotline_io::{Document, Effect, ReadOptions, load, load_bytes, parse_scene, save, write_scene};

use reading::{ok, refused};

/// A tetrahedron of volume 1/6 in each text format.
const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
                   element face 4\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n\
                   3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n";

/// The fifth vertex is the fourth but for rounding, as CAD writes it: only welding closes the mesh.
const NOISY: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 2.7e-17 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 5\n";

fn stl() -> String {
    let facet = |[a, b, c]: [&str; 3]| {
        format!("facet normal 0 0 0\nouter loop\nvertex {a}\nvertex {b}\nvertex {c}\nendloop\nendfacet\n")
    };
    let [o, x, y, z] = ["0 0 0", "1 0 0", "0 1 0", "0 0 1"];
    format!("solid part\n{}endsolid part\n", [[o, y, x], [o, x, z], [x, y, z], [y, o, z]].map(facet).concat())
}

/// The same as binary STL, with a count, and with bytes behind each triangle.
fn binary_stl(count: u32, behind: &[u8]) -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes.extend(count.to_le_bytes());
    let corners = [[0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for face in [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]] {
        bytes.extend([0; 12]);
        bytes.extend(face.iter().flat_map(|i: &usize| corners[*i]).flat_map(f32::to_le_bytes));
        bytes.extend((behind.len() as u16).to_le_bytes());
        bytes.extend(behind);
    }
    bytes
}

#[track_caller]
fn mesh_of(document: &Document) -> &TriangleMesh {
    let mesh = document.scene.nodes.iter().find_map(|node| match node {
        Node::Mesh { mesh, .. } => Some(mesh),
        _ => None,
    });
    mesh.unwrap_or_else(|| panic!("{document:?}"))
}

/// It is read as the tetrahedron, and one note says what was dropped or repaired, or none where nothing was.
#[track_caller]
fn is_the_tetrahedron(name: &str, bytes: impl AsRef<[u8]>, changed: &[&str]) {
    let document = ok(name, bytes);
    let mesh = mesh_of(&document);
    let six_volumes = |face| {
        let [a, b, c] = mesh.corners(face);
        a.dot(b.cross(c))
    };
    assert_eq!((mesh.faces.len(), (0..4).map(six_volumes).sum::<f64>()), (4, 1.0), "{name}");
    let notes = document.notes.iter().filter(|note| note.effect == Effect::Changed);
    assert_eq!(notes.map(|note| note.kind).collect::<Vec<_>>(), changed, "{name}");
}

fn area(mesh: &TriangleMesh) -> f64 {
    let faces = (0..mesh.faces.len() as u32).map(|face| mesh.corners(face));
    faces.map(|[a, b, c]| (b - a).cross(c - a).length() / 2.0).sum()
}

// Texts

/// The mark before the first `v` of an OBJ made it an unknown keyword: the vertex was dropped and all others took the
/// number before theirs, without a note. PLY and STL were refused.
#[test]
fn a_byte_order_mark_swallows_no_vertex() {
    is_the_tetrahedron("a.obj", format!("\u{FEFF}{OBJ}"), &[]);
    is_the_tetrahedron("a.ply", format!("\u{FEFF}{PLY}"), &[]);
    is_the_tetrahedron("a.stl", format!("\u{FEFF}{}", stl()), &[]);
}

/// Lines that end in CR alone were one long line, and files of them had no faces.
#[test]
fn lines_may_end_in_cr() {
    for (name, text) in [("a.obj", OBJ), ("a.ply", PLY), ("a.stl", &stl())] {
        is_the_tetrahedron(name, text.replace('\n', "\r"), &[]);
    }
}

/// A comment behind a face was refused, though one behind a vertex was read.
#[test]
fn comments_may_follow_any_line_of_an_obj() {
    is_the_tetrahedron("a.obj", OBJ.replace('\n', " # here\n"), &[]);
}

/// A text STL that begins with a comment was taken for a binary one of 10^9 triangles; in others comments were read as
/// facets.
#[test]
fn comments_of_text_stl_are_no_facets() {
    let comment = "# facet normal 0 0 1 outer loop vertex 0 0 5 vertex 1 0 5 vertex 0 1 5 endloop endfacet\n";
    is_the_tetrahedron("a.stl", format!("{comment}{}", stl()), &[]);
    is_the_tetrahedron("a.stl", stl().replace("endfacet\n", &format!("endfacet\n{comment}")), &[]);
}

/// A file in UTF-16 was refused because it has no faces, which does not help.
#[test]
fn utf_16_is_named() {
    let wide: Vec<u8> = format!("\u{FEFF}{OBJ}").encode_utf16().flat_map(u16::to_le_bytes).collect();
    refused("a.obj", wide, "is UTF-16 text; save it as UTF-8");
}

/// Zero bytes were read as blanks, so that `1\0 5` was two numbers.
#[test]
fn zero_bytes_are_no_blanks() {
    refused("a.obj", OBJ.replacen("v 1 0 0", "v 1\x005 0 0", 1), "zero byte (NUL)");
    refused("a.ply", PLY.replacen("1 0 0", "1\x005 0 0", 1), "zero byte (NUL)");
}

/// `float` in the header of a text PLY rounded its numbers to float32.
#[test]
fn floats_of_text_ply_keep_their_digits() {
    let document = ok("a.ply", PLY.replacen("\n1 0 0", "\n5000000.1 0 0", 1));
    assert_eq!(mesh_of(&document).vertices[1].x, 5_000_000.1);
}

// Meshes

/// Polygons were cut into fans from their first corner, which cover notches: the area of this one was 3.5.
#[test]
fn polygons_are_cut_within_their_outline() {
    let ell = "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\n";
    for first in 0..6 {
        let corners: String = (0..6).map(|i| format!(" {}", (first + i) % 6 + 1)).collect();
        let document = ok("a.obj", format!("{ell}f{corners}\n"));
        let mesh = mesh_of(&document);
        assert_eq!((mesh.faces.len(), area(mesh)), (4, 3.0), "from corner {first}");
        assert!((0..4).all(|face| mesh.polygon(face) == 0));
        let sheet = Scene::of([Object::new("it", Shape::triangles(Arc::new(mesh.clone())).unwrap())]);
        let into_the_notch = Ray::new(Vec3::new(1.5, 1.5, -1.0), Vec3::Z).unwrap();
        let world = sheet.compile().unwrap();
        assert_eq!(Caster::new(&world).any(&into_the_notch, Span::FORWARD), Ok(false));
    }
}

/// Polygons that touch themselves in a corner were cut across their outline, depending on the corner that comes first.
#[test]
fn polygons_that_touch_themselves_are_cut_within_too() {
    // An hourglass of two triangles of area 1 each.
    let hourglass = [1, 2, 3, 4, 5, 3];
    for first in 0..6 {
        let corners: String = (0..6).map(|i| format!(" {}", hourglass[(first + i) % 6])).collect();
        let document = ok("a.obj", format!("v 0 0 0\nv 2 0 0\nv 1 1 0\nv 2 2 0\nv 0 2 0\nf{corners}\n"));
        assert_eq!(area(mesh_of(&document)), 2.0, "from corner {first}");
    }
}

/// A vertex that is not finite was refused though no face uses it.
#[test]
fn vertices_that_no_face_uses_may_hold_anything() {
    let ply = PLY.replace("vertex 4", "vertex 5").replace("0 0 1\n3", "0 0 1\n{odd} 0 0\n3");
    for odd in ["nan", "inf", "-1.#IND", "1e999"] {
        for (name, text) in [("a.obj", format!("{OBJ}v {odd} 0 0\n")), ("a.ply", ply.replace("{odd}", odd))] {
            is_the_tetrahedron(name, &text, &[]);
            let notes = ok(name, &text).notes;
            assert!(
                notes.iter().any(|note| note.kind == "vertices_not_finite" && note.count == 1),
                "{notes:?}"
            );
        }
    }
}

/// One face of two corners, as exporters leave them, made the file unreadable.
#[test]
fn faces_of_two_corners_are_dropped_with_a_note() {
    is_the_tetrahedron("a.obj", format!("{OBJ}f 1 2\n"), &["short_faces"]);
    is_the_tetrahedron("a.ply", PLY.replace("face 4", "face 5") + "2 0 1\n", &["short_faces"]);
}

/// Spare bytes at the end of a binary STL were refused by a message that contradicts itself, and so were attributes and
/// a count of 0.
#[test]
fn binary_stl_with_spare_bytes_and_wrong_counts_is_read() {
    is_the_tetrahedron("a.stl", binary_stl(4, b""), &[]);
    is_the_tetrahedron("a.stl", binary_stl(4, b"abcdef"), &[]);
    for length in [1, 49, 92] {
        is_the_tetrahedron("a.stl", [binary_stl(4, b""), vec![b'\n'; length]].concat(), &["extra_bytes"]);
    }
    is_the_tetrahedron("a.stl", binary_stl(0, b""), &["wrong_count"]);
    refused("a.stl", binary_stl(5, b""), "says 5 triangles, but the file ends after 4");
}

/// `-` recognised binary STL only if its count fits its size.
#[test]
fn stl_without_a_name_is_recognised_as_files_are() {
    for bytes in [binary_stl(0, b""), binary_stl(4, b"abc"), [binary_stl(4, b""), b"more".to_vec()].concat()]
    {
        assert_eq!(mesh_of(&ok("-", bytes)).faces.len(), 4);
    }
}

/// Colours of vertices were dropped.
#[test]
fn colours_of_vertices_are_kept() {
    let document = ok("a.obj", OBJ.replacen("v 0 0 0", "v 0 0 0 0.5 0.25 0.75", 1));
    let color = mesh_of(&document).attribute("color").unwrap();
    assert_eq!(color.value(0), Some(&[0.5, 0.25, 0.75][..]));
    assert!(color.value(1).unwrap()[0].is_nan() && document.notes.is_empty());
}

/// `auto` joined parts with a gap between them that is far wider than rounding.
#[test]
fn auto_welding_joins_no_parts_with_a_narrow_gap() {
    // Its mirror image in x = -5e-13.
    let second = "v -1e-12 0 0\nv -1 0 0\nv -1e-12 1 0\nv -1e-12 0 1\nf -4 -3 -2\nf -4 -1 -3\nf -3 -1 -2\nf -2 -1 -4\n";
    let both = format!("{OBJ}{second}");
    let options = ReadOptions { weld: Some(Weld::Auto), ..ReadOptions::default() };
    let welded = load_bytes(Path::new("a.obj"), both.clone().into_bytes(), options).unwrap();
    assert_eq!(mesh_of(&welded), mesh_of(&ok("a.obj", both)));
    // What rounding left open is closed.
    assert_eq!(mesh_of(&ok("a.obj", NOISY)).welded(Weld::Auto).unwrap().1.merged, 1);
}

// Scenes

fn welded_scene() -> Scene {
    let mesh = Arc::new(mesh_of(&ok("a.obj", NOISY)).welded(Weld::Auto).unwrap().0);
    let file = Some(MeshFile { name: "noisy.obj".into(), weld: Some(Weld::Auto) });
    let mut scene = Scene::default();
    let node = scene.add(Node::Mesh { mesh, file });
    scene.add_object("it", None, node);
    scene
}

/// `write_scene` dropped `"weld"`, so that the scene that was read again was another model.
#[test]
fn a_saved_scene_keeps_how_its_meshes_were_welded() {
    let text = write_scene(&welded_scene()).unwrap();
    assert!(text.contains(r#""weld": "auto""#), "{text}");
}

/// A saved scene named mesh files outside of its folder, which it could not read again.
#[test]
fn meshes_outside_of_the_folder_are_copied_beside_the_scene() {
    let outer = tempfile::tempdir().unwrap();
    let inner = outer.path().join("inner");
    std::fs::create_dir(&inner).unwrap();
    std::fs::write(outer.path().join("part.obj"), OBJ).unwrap();
    let mut scene = Scene::default();
    let mesh = Arc::new(mesh_of(&ok("part.obj", OBJ)).clone());
    let file = Some(MeshFile { name: "../part.obj".into(), weld: None });
    let node = scene.add(Node::Mesh { mesh: mesh.clone(), file });
    scene.add_object("it", None, node);
    save(inner.join("scene.json"), &scene).unwrap();
    assert_eq!(mesh_of(&load(inner.join("scene.json")).unwrap()), &*mesh);
}

/// The numbers of the polygons of a file were lost when it was written as PLY.
#[test]
fn polygon_numbers_survive_ply() {
    let folder = tempfile::tempdir().unwrap();
    let square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nf 1 2 3 4\nf 2 5 3\n";
    let path = folder.path().join("a.ply");
    save(&path, &ok("a.obj", square).scene).unwrap();
    assert_eq!(mesh_of(&load(&path).unwrap()).polygons, [0, 0, 1]);
}

/// Two objects of one name were read without a note.
#[test]
fn names_of_several_objects_are_noted() {
    let ball = r#"{ "name": "a", "node": { "kind": "sphere", "radius": 1 } }"#;
    let document =
        parse_scene(format!(r#"{{ "shotline": 1, "objects": [ {ball}, {ball} ] }}"#), None).unwrap();
    assert_eq!(document.notes.iter().map(|note| note.kind).collect::<Vec<_>>(), ["duplicate_names"]);
}

/// Any text was accepted as a unit.
#[test]
fn unknown_units_are_refused() {
    let scene =
        |units: &str| parse_scene(format!(r#"{{ "shotline": 1, "units": "{units}", "objects": [] }}"#), None);
    assert_eq!(scene("mm").unwrap().scene.units, Some(Units::Millimetres));
    let said = scene("parnsips").unwrap_err().to_string();
    assert!(said.contains("parnsips"), "{said}");
}
