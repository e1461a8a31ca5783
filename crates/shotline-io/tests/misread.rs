//! Files that an earlier version misread.

mod reading;

use std::path::Path;

use shotline::math::Vec3;
use shotline::scene::Node;
use shotline::solid::mesh::{TriangleMesh, Weld};
use shotline_io::{Document, Effect, ReadOptions, load_bytes, parse_scene};

use reading::{ok, refused};

#[track_caller]
fn mesh_of(document: &Document) -> &TriangleMesh {
    let Node::Mesh { mesh, .. } = &document.scene.nodes[0] else { panic!("{document:?}") };
    mesh
}

#[track_caller]
fn noted(document: &Document, kind: &str, count: usize, effect: Effect) {
    let found = document.notes.iter().find(|n| n.kind == kind);
    let note = found.unwrap_or_else(|| panic!("no {kind} in {:?}", document.notes));
    assert_eq!((note.count, note.effect), (count, effect), "{note}");
}

const STL: &str = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n\
                   endfacet\nendsolid a\n";
const FACET: &str = "facet normal 0 0 1 outer loop vertex 0 0 5 vertex 1 0 5 vertex 0 1 5 endloop endfacet";

#[test]
fn facets_in_comments_of_text_stl_are_ignored() {
    for comment in [
        format!("# {FACET}"),
        format!("#{FACET}"),
        "# facet normal 0 0 1".into(),
        FACET.replace(' ', "\n# ").replacen("facet", "# facet", 1),
    ] {
        let whole = [
            format!("{comment}\n{STL}"),
            format!("{STL}{comment}\n"),
            STL.replacen("facet", &format!("{comment}\nfacet"), 1),
            STL.replace("endsolid", &format!("{comment}\nendsolid")),
            STL.replace("outer", &format!("{comment}\nouter")),
            STL.replace("normal 0 0 1\n", &format!("normal 0 0 1 {comment}\n")),
            STL.replace("solid a\n", &format!("solid a {comment}\n")),
        ];
        for text in whole {
            let document = ok("a.stl", &text);
            assert_eq!(mesh_of(&document).faces.len(), 1, "{text}");
            assert!(document.notes.is_empty(), "{text}: {:?}", document.notes);
        }
    }
}

#[test]
fn names_and_text_outside_of_solids_are_not_read_as_facets() {
    for name in ["facet normal", "facet normal 0 0 0", "facet", "a facet normal of a part", "part #3", "#"] {
        let document = ok("a.stl", STL.replace("solid a", &format!("solid {name}")));
        assert_eq!(mesh_of(&document).faces.len(), 1, "{name}");
        assert!(document.notes.is_empty(), "{name}: {:?}", document.notes);
    }
    // On one line the name ends where the facet begins.
    assert_eq!(mesh_of(&ok("a.stl", format!("solid part #3 {FACET} endsolid"))).faces.len(), 1);
    for text in
        ["see facet normal 0 0 1 in the manual", "facet normal vectors are not used", "facets of a part"]
    {
        for text in [format!("{text}\n{STL}"), format!("{STL}{text}\n")] {
            let document = ok("a.stl", &text);
            assert_eq!(mesh_of(&document).faces.len(), 1, "{text}");
            noted(&document, "text_outside", 1, Effect::Kept);
        }
    }
}

#[test]
fn broken_facets_of_text_stl_are_located() {
    let twice = STL.replace("endsolid a", &STL["solid a\n".len()..]);
    refused("a.stl", twice.replacen("endfacet\n", "", 1), "8:1: 'endfacet' is missing before this 'facet'");
    let before = format!("facet normal 0 0 1\n{STL}");
    refused("a.stl", &before, "2:1: 'endfacet' is missing before this 'solid'");
    refused("a.stl", &before, "stands before the first 'solid'");
    refused("a.stl", STL.replace("facet normal 0 0 1\n", ""), "'outer' stands outside of a facet");
    refused(
        "a.stl",
        STL.replace("vertex 1 0 0\nvertex 0 1 0\n", ""),
        "this facet has 1 corner; it needs three",
    );
}

const OBJ: &str = "v 0 0 0\nv 1.5 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                   element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1.5 0 0\n0 1 0\n3 0 1 2\n";

#[test]
fn zero_bytes_in_text_are_not_white_space() {
    for (name, text, line) in
        [("a.obj", OBJ, 2), ("a.ply", PLY, 11), ("a.stl", &STL.replace("1 0 0", "1.5 0 0"), 5)]
    {
        refused(name, text.replace("1.5", "1\x005"), &format!("{name}:{line}:"));
        refused(name, text.replace("1.5", "1\x005"), "zero byte (NUL)");
        refused(name, text.replace("1.5 0 0\n", "1.5 0 0\n\0\0\0\0\0\0\n"), "zero byte (NUL)");
        let document = ok(name, format!("{text}\0\0\0\0"));
        noted(&document, "zero_bytes", 4, Effect::Changed);
        assert!(!mesh_of(&document).faces.is_empty());
    }
    let error = parse_scene("{\"shotline\": 1,\n \"objects\": [\0]}", None).unwrap_err().to_string();
    assert!(error.contains("2:14: ") && error.contains("zero byte (NUL)"), "{error}");
}

#[test]
fn floats_of_text_ply_keep_their_digits() {
    let document = ok("a.ply", PLY.replace("1.5", "5000000.1"));
    assert_eq!(mesh_of(&document).vertices[1], Vec3::new(5_000_000.1, 0.0, 0.0));
    assert!(document.notes.is_empty());
    assert_eq!(mesh_of(&ok("a.ply", PLY.replace("1.5", "1e39"))).vertices[1].x, 1e39);
}

#[test]
fn integers_of_text_ply_outside_of_their_type_are_noted_or_refused() {
    for (ty, number) in
        [("uchar", "256"), ("uchar", "-1"), ("char", "128"), ("int", "99999999999"), ("ushort", "65536")]
    {
        let document =
            ok("a.ply", PLY.replace("property float x", &format!("property {ty} x")).replace("1.5", number));
        assert_eq!(mesh_of(&document).vertices[1].x, number.parse::<f64>().unwrap());
        noted(&document, "beyond_type", 1, Effect::Changed);
    }
    refused("a.ply", PLY.replace("3 0 1 2", "3 0 1 99999999999"), "13:7: 99999999999 is not within");
    refused("a.ply", PLY.replace("3 0 1 2", "259 0 1 2"), "13:1: 259 is not within 0 and 255");
    refused("a.ply", PLY.replace("ascii 1.0", "ascii 2.0"), "2:14: there is no version 2.0 of PLY");
}

#[test]
fn attributes_of_obj_vertices_and_corners_are_noted() {
    for (line, what) in [("v 0 0 0 2", "weights of vertices"), ("v 0 0 0 0", "weights of vertices")] {
        let document = ok("a.obj", OBJ.replacen("v 0 0 0", line, 1));
        noted(&document, "not_read", 1, Effect::Kept);
        assert!(document.notes.iter().any(|n| n.text.contains(what)), "{line}: {:?}", document.notes);
    }
    for line in ["v 0 0 0 1.0", "v 0 0 0 0.5 0.5 0.5", "v 0 0 0 1 0.5 0.5 0.5"] {
        assert!(ok("a.obj", OBJ.replacen("v 0 0 0", line, 1)).notes.is_empty());
    }
    for line in ["v 0 0 0 1 2", "v 0 0 0 x"] {
        noted(&ok("a.obj", OBJ.replacen("v 0 0 0", line, 1)), "extra_numbers", 1, Effect::Changed);
    }
    for corner in ["4/x", "4/1/1/1", "4/0", "4//x", "4/1.5"] {
        refused("a.obj", OBJ.replace("f 3 1 4", &format!("f 3 1 {corner}")), "8:7: ");
    }
    for corner in ["4/-99", "4/7", "4//2", "4//-3"] {
        let document = ok("a.obj", OBJ.replace("f 3 1 4", &format!("vt 0 0\nf 3 1 {corner}")));
        noted(&document, "no_such_attribute", 1, Effect::Kept);
    }
    let later =
        ok("a.obj", format!("{OBJ}f 1/1/ 2//1 3/-1\nvt 0 0\nvn 0 0 1\n").replace("f 1 3", "vt 0 0\nf 1 3"));
    assert!(later.notes.iter().all(|n| n.kind != "no_such_attribute"), "{:?}", later.notes);
}

#[test]
fn commands_of_an_obj_are_noted() {
    let document = ok("a.obj", format!("{OBJ}call other.obj\ncsh -ls\n"));
    noted(&document, "commands", 2, Effect::Changed);
}

/// Two triangles as binary STL: `count` is the declared number, `word` the attribute of each triangle, and `behind` the
/// bytes after it.
fn binary(count: u32, head: &str, word: u16, behind: &[u8]) -> Vec<u8> {
    let mut bytes = head.as_bytes().to_vec();
    bytes.resize(80, b' ');
    bytes.extend(count.to_le_bytes());
    for z in [0.0, 1.0] {
        bytes.extend([0; 12]);
        bytes.extend([0.0, 0.0, z, 1.0, 0.0, z, 0.0, 1.0, z].iter().flat_map(|x: &f32| x.to_le_bytes()));
        bytes.extend(word.to_le_bytes());
        bytes.extend(behind);
    }
    bytes
}

#[test]
fn attribute_words_and_colours_of_binary_stl_are_noted() {
    noted(&ok("a.stl", binary(2, "", 5, b"")), "not_read", 2, Effect::Kept);
    let coloured = ok("a.stl", binary(2, "COLOR=abcd", 0x8FFF, b""));
    noted(&coloured, "not_read", 2, Effect::Kept);
    noted(&coloured, "colours_not_read", 1, Effect::Kept);
    assert!(ok("a.stl", binary(2, "", 0, b"")).notes.is_empty());
}

#[test]
fn input_without_a_name_is_recognised_by_its_contents() {
    let mut behind = binary(2, "", 0, b"");
    behind.extend(b"some more bytes");
    for bytes in [binary(1, "", 0, b""), binary(0, "", 0, b""), binary(2, "", 3, b"abc"), behind] {
        assert_eq!(mesh_of(&ok("-", &bytes)).faces, mesh_of(&ok("a.stl", &bytes)).faces);
    }
    for text in [format!("made by a program\n{STL}"), format!("# made by a program\n{STL}")] {
        assert_eq!(mesh_of(&ok("-", text)).faces.len(), 1);
    }
    let noise: Vec<u8> = (0u32..2000).map(|i| (i.wrapping_mul(2_654_435_761) >> 13) as u8).collect();
    refused("-", noise, "is of no known format");
}

#[test]
fn meshes_whose_vertices_coincide_exactly_have_nothing_to_weld() {
    let twice = OBJ.replace("f 3 1 4", "v 0 0 1\nf 3 1 5");
    let options = ReadOptions { weld: Some(Weld::Auto), ..ReadOptions::default() };
    let document = load_bytes(Path::new("a.obj"), twice.into_bytes(), options).unwrap();
    noted(&document, "welded", 1, Effect::Kept);
    assert!(document.notes.iter().any(|n| n.text.starts_with("nothing to weld")), "{:?}", document.notes);
}

/// The faces of a box whose first vertex has this number.
fn sides(first: usize) -> String {
    let quads = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];
    quads.iter().map(|quad| format!("f{}\n", quad.map(|i| format!(" {}", i + first)).concat())).collect()
}

fn box_of([x, y, z]: [f64; 3], [a, b, c]: [f64; 3]) -> String {
    let corners = [[x, y, z], [a, y, z], [a, b, z], [x, b, z], [x, y, c], [a, y, c], [a, b, c], [x, b, c]];
    corners.iter().map(|[x, y, z]| format!("v {x:?} {y:?} {z:?}\n")).collect()
}

#[test]
fn auto_weld_keeps_thin_plates_and_gaps() {
    let far = 5e6;
    let plate = box_of([far; 3], [far + 1.0, far + 1.0, far + 5e-4]) + &sides(1);
    let thin = box_of([0.0; 3], [1.0, 1.0, 1e-9]) + &sides(1);
    let gap = |at: f64, gap: f64| {
        let first = box_of([at, 0.0, 0.0], [at + 1.0, 1.0, 1.0]);
        first + &box_of([at + 1.0 + gap, 0.0, 0.0], [at + 2.0 + gap, 1.0, 1.0]) + &sides(1) + &sides(9)
    };
    let wedge = "v 0 0 0\nv 1 0 0\nv 1 0 1e-08\nv 0 1 0\nv 1 1 0\nv 1 1 1e-08\nf 1 3 2\nf 4 5 6\nf 1 2 5 4\nf 2 3 6 5\nf 3 1 4 6\n";
    for text in [plate, thin, gap(0.0, 1e-12), gap(far, 5e-4), wedge.into()] {
        let options = ReadOptions { weld: Some(Weld::Auto), ..ReadOptions::default() };
        let welded = load_bytes(Path::new("a.obj"), text.clone().into_bytes(), options).unwrap();
        assert_eq!(mesh_of(&welded), mesh_of(&ok("a.obj", &text)));
        noted(&welded, "welded", 1, Effect::Kept);
    }
}
