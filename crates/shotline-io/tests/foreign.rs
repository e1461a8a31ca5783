//! Files as other programs write them: valid and nearly valid files are read, and notes report what was dropped or
//! repaired.

use std::path::Path;

use shotline::math::Vec3;
use shotline::scene::Node;
use shotline::solid::mesh::TriangleMesh;
use shotline_io::{Document, Effect, FORMATS, ReadError, Spot};

fn read(extension: &str, bytes: &[u8]) -> Result<Document, ReadError> {
    let format = FORMATS.iter().find(|f| f.extensions.contains(&extension)).unwrap();
    format.read(Path::new(&format!("part.{extension}")), bytes.to_vec())
}

#[track_caller]
fn mesh_of(document: &Document) -> &TriangleMesh {
    let Node::Mesh { mesh, .. } = &document.scene.nodes[0] else { panic!("{document:?}") };
    mesh
}

/// The document of a file that must be readable. Its extension selects the format.
#[track_caller]
fn ok(name: &str, bytes: &[u8]) -> Document {
    let extension = name.rsplit('.').next().unwrap();
    read(extension, bytes)
        .unwrap_or_else(|error| panic!("{name}: {error}\n{}", String::from_utf8_lossy(bytes)))
}

fn case(name: &str) -> Vec<u8> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../testdata/cases").join(name);
    std::fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// Six times the volume that the faces enclose.
fn volume(mesh: &TriangleMesh) -> f64 {
    (0..mesh.faces.len() as u32).map(|i| mesh.corners(i)).map(|[a, b, c]| a.dot(b.cross(c))).sum()
}

fn area(mesh: &TriangleMesh) -> f64 {
    let area = |[a, b, c]: [Vec3; 3]| (b - a).cross(c - a).length() / 2.0;
    (0..mesh.faces.len() as u32).map(|i| area(mesh.corners(i))).sum()
}

/// The kinds of the notes whose effect is that the model may have changed.
fn changes(document: &Document) -> Vec<&'static str> {
    document.notes.iter().filter(|n| n.effect == Effect::Changed).map(|n| n.kind).collect()
}

fn note(document: &Document, kind: &str) -> (usize, Option<Spot>) {
    let found = document.notes.iter().find(|n| n.kind == kind);
    found.map_or_else(|| panic!("no {kind} in {:?}", document.notes), |n| (n.count, n.first))
}

/// A tetrahedron of volume 1/6.
const POINTS: [&str; 4] = ["0 0 0", "1 0 0", "0 1 0", "0 0 1"];
const FACES: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];

/// The lines of the tetrahedron in a text format.
fn lines(extension: &str) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    match extension {
        "obj" => {
            lines.extend(POINTS.iter().map(|p| format!("v {p}")));
            lines.extend(FACES.iter().map(|[a, b, c]| format!("f {} {} {}", a + 1, b + 1, c + 1)));
        }
        "ply" => {
            let head = "ply|format ascii 1.0|element vertex 4|property float x|property float y|property float z|\
                        element face 4|property list uchar int vertex_indices|end_header";
            lines.extend(head.split('|').map(String::from));
            lines.extend(POINTS.iter().map(ToString::to_string));
            lines.extend(FACES.iter().map(|[a, b, c]| format!("3 {a} {b} {c}")));
        }
        _ => {
            lines.push("solid part".into());
            for face in FACES {
                lines.extend(["facet normal 0 0 1".into(), "outer loop".into()]);
                lines.extend(face.iter().map(|i| format!("vertex {}", POINTS[*i])));
                lines.extend(["endloop".into(), "endfacet".into()]);
            }
            lines.push("endsolid part".into());
        }
    }
    lines
}

/// Every combination of byte order mark, line break, indentation, comment and ending, in every text format.
#[test]
fn text_files_are_read_with_any_mark_line_break_indentation_and_comment() {
    let mut count = 0;
    for extension in ["obj", "ply", "stl"] {
        for mark in ["", "\u{FEFF}"] {
            for line_break in ["\n", "\r\n", "\r", "\n\n", "\r\r\n"] {
                for indent in ["", " ", "\t"] {
                    for comment in ["", " # c", " # f 1 2 3", "\t#"] {
                        for end in ["", "last", "\u{1A}", "  "] {
                            count += 1;
                            let name =
                                format!("{mark:?} {line_break:?} {indent:?} {comment:?} {end:?}.{extension}");
                            let is_head = |line: &str| {
                                extension == "ply" && !line.starts_with(|c: char| c.is_ascii_digit())
                            };
                            let line = |line: &String| {
                                let comment = if is_head(line) { "" } else { comment };
                                let indent = if line == "ply" { "" } else { indent };
                                format!("{indent}{line}{comment}")
                            };
                            let text = lines(extension).iter().map(line).collect::<Vec<_>>().join(line_break);
                            let end = if end == "last" { line_break } else { end };
                            let end =
                                if comment.is_empty() { end.into() } else { format!("{line_break}{end}") };
                            let document = ok(&name, format!("{mark}{text}{end}").as_bytes());
                            let mesh = mesh_of(&document);
                            assert_eq!((mesh.faces.len(), volume(mesh)), (4, 1.0), "{name}");
                            assert!(changes(&document).is_empty(), "{name}: {:?}", document.notes);
                        }
                    }
                }
            }
        }
    }
    assert_eq!(count, 3 * 2 * 5 * 3 * 4 * 4);
}

#[test]
fn locations_are_correct_with_any_mark_and_line_break() {
    for mark in ["", "\u{FEFF}"] {
        for line_break in ["\n", "\r\n", "\r"] {
            let with = |line: &str| {
                let text = ["v 0 0 0", "v 1 0 0", "v 0 1 0", line, "f 1 2 3", ""].join(line_break);
                read("obj", format!("{mark}{text}").as_bytes())
            };
            let shown = with("f 1 2 x").unwrap_err().to_string();
            assert!(shown.starts_with("part.obj:4:7: 'x' is not a vertex"), "{shown}");
            assert!(shown.contains("\n    f 1 2 x\n          ^\n"), "{shown}");
            assert_eq!(note(&with("what 1").unwrap(), "unknown_keyword"), (1, Some(Spot::Line(4))));
            let first = format!("{mark}v 0 0{line_break}f 1 1 1");
            let shown = read("obj", first.as_bytes()).unwrap_err().to_string();
            assert!(
                shown.starts_with("part.obj:1:1: a vertex has three coordinates\n    v 0 0\n    ^^^^^"),
                "{shown}"
            );
        }
    }
}

#[test]
fn utf16_and_utf32_are_reported_by_name() {
    let wide = |text: &str, swap: bool, mark: bool| {
        let units = mark.then_some(0xFEFF).into_iter().chain(text.encode_utf16());
        units.flat_map(|u| if swap { u.to_be_bytes() } else { u.to_le_bytes() }).collect::<Vec<u8>>()
    };
    for extension in ["obj", "ply", "stl", "json"] {
        let text =
            if extension == "json" { "{ \"shotline\": 1 }".into() } else { lines(extension).join("\n") };
        for (swap, mark) in [(false, true), (true, true), (false, false), (true, false)] {
            let shown = read(extension, &wide(&text, swap, mark)).unwrap_err().to_string();
            assert!(shown.contains(" is UTF-16 text; save it as UTF-8\nhelp: "), "{extension}: {shown}");
        }
        let wider: Vec<u8> =
            "\u{FEFF}".chars().chain(text.chars()).flat_map(|c| (c as u32).to_le_bytes()).collect();
        let shown = read(extension, &wider).unwrap_err().to_string();
        assert!(shown.contains(" is UTF-32 text; save it as UTF-8"), "{extension}: {shown}");
    }
    // Scene files may have a mark and CR line breaks, which also end comments.
    let scene = "\u{FEFF}{ // a comment\r \"shotline\": 1,\r \"objects\": [] }";
    assert!(read("json", scene.as_bytes()).is_ok());
}

#[test]
fn small_files_of_other_programs_are_read() {
    let tetrahedra = [
        "binary-tail.stl",
        "bom-silent.obj",
        "bom.ply",
        "bom.stl",
        "comment-end.obj",
        "comment-first.stl",
        "cr-only.obj",
        "cr-only.ply",
        "cr-only.stl",
        "nan-unused.obj",
        "nan-unused.ply",
        "two-corner-face.obj",
        "two-corner-face.ply",
    ];
    for name in tetrahedra {
        let document = ok(name, &case(name));
        assert_eq!((mesh_of(&document).faces.len(), volume(mesh_of(&document))), (4, 1.0), "{name}");
    }
    for name in ["bom.obj", "inline-comment.obj"] {
        let document = ok(name, &case(name));
        assert_eq!((mesh_of(&document).faces.len(), volume(mesh_of(&document))), (12, 48.0), "{name}");
    }
    let noted = |name: &str, kind: &str| note(&ok(name, &case(name)), kind);
    assert_eq!(noted("bom.obj", "unused_vertices"), (1, Some(Spot::Vertex(9))));
    assert_eq!(noted("binary-tail.stl", "extra_bytes"), (1, Some(Spot::Byte(284))));
    assert_eq!(noted("nan-unused.obj", "vertices_not_finite"), (1, Some(Spot::Line(5))));
    assert_eq!(noted("nan-unused.ply", "vertices_not_finite"), (1, Some(Spot::Line(14))));
    assert_eq!(noted("two-corner-face.obj", "short_faces"), (1, Some(Spot::Line(9))));
    assert_eq!(noted("two-corner-face.ply", "short_faces"), (1, Some(Spot::Line(18))));
    for name in ["bom.obj", "cr-only.stl", "comment-first.stl", "bom-silent.obj"] {
        assert!(changes(&ok(name, &case(name))).is_empty(), "{name}");
    }
}

#[test]
fn triangles_of_concave_polygons_stay_inside_the_outline_and_keep_its_number() {
    let sheet = ok("concave-sheet.obj", &case("concave-sheet.obj"));
    assert_eq!((mesh_of(&sheet).faces.len(), area(mesh_of(&sheet))), (4, 3.0));
    let prism = ok("concave-prism.obj", &case("concave-prism.obj"));
    let mesh = mesh_of(&prism);
    assert!((volume(mesh) / 6.0 - 3.0).abs() < 1e-5 && (area(mesh) - 14.0).abs() < 1e-4, "{}", volume(mesh));
    assert_eq!(mesh.polygons[..8], [0, 0, 0, 0, 1, 1, 1, 1]);
    assert_eq!(mesh.polygons.last(), Some(&7));
    assert_eq!(note(&prism, "polygons_cut"), (8, Some(Spot::Line(13))));
}

#[test]
fn dropped_faces_keep_the_numbers_of_the_others() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2\nf 1 2 3\nf 1 1 2 2\nf 1 1 2 4 4 3 1\nf 2 3 4\n";
    let document = ok("a.obj", text.as_bytes());
    let mesh = mesh_of(&document);
    assert_eq!(mesh.faces, [[0, 1, 2], [0, 1, 3], [0, 3, 2], [1, 2, 3]]);
    assert_eq!((mesh.polygons.as_slice(), mesh.polygon(3)), (&[1, 3, 3, 4][..], 4));
    assert_eq!(note(&document, "short_faces"), (2, Some(Spot::Line(5))));
    let plain = ok("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    assert!(mesh_of(&plain).polygons.is_empty() && mesh_of(&plain).polygon(0) == 0);
}

#[test]
fn self_crossing_polygons_are_noted() {
    let text = "v 0 0 0\nv 1 1 0\nv 1 0 0\nv 0 1 0\nf 1 2 3 4\n";
    let document = ok("a.obj", text.as_bytes());
    assert_eq!(note(&document, "crossed_polygons"), (1, Some(Spot::Line(5))));
    assert_eq!(mesh_of(&document).faces.len(), 2);
}

#[test]
fn ignored_lines_of_an_obj_are_noted() {
    let text = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\nvn 0 0 1\nusemtl red\ng a\nf 1//1 2//1 3//1\n\
                l 1 2\nvp 0 0\ncurv 0 1 1 2\nwhat\n# in C:\\parts\\\nf 3 2 1 \\\n # c\nf 1 \\\n3 2#c\n";
    let document = ok("a.obj", text.as_bytes());
    assert_eq!(mesh_of(&document).faces, [[0, 1, 2], [2, 1, 0], [0, 2, 1]]);
    let all = document.notes.iter().find(|n| n.kind == "not_read").unwrap();
    assert_eq!(
        (all.count, all.effect, all.text.as_str()),
        (1, Effect::Kept, "1 line was not read: points and lines")
    );
    assert_eq!(note(&document, "materials_not_read"), (1, None));
    assert_eq!(note(&document, "curved_surfaces"), (2, Some(Spot::Line(12))));
    assert_eq!(note(&document, "unknown_keyword"), (1, Some(Spot::Line(14))));
}

/// In a comment a backslash does not join lines: the vertex on the next line is read.
#[test]
fn a_backslash_at_the_end_of_a_comment_does_not_join_lines() {
    let text = "# C:\\parts\\\nv 0 0 0\nv 1 0 0 # \\\nv 0 1 0\nf 1 2 3\n";
    assert_eq!(mesh_of(&ok("a.obj", text.as_bytes())).vertices.len(), 3);
}

#[test]
fn vertices_that_are_not_finite_are_errors_only_if_a_face_uses_them() {
    for odd in
        ["nan", "NaN", "-nan", "inf", "-inf", "infinity", "1e999", "-1.#IND", "1.#QNAN", "1.#INF", "nan(ind)"]
    {
        let text = format!("v {odd} 0 0\nv 0 0 0\nv 1 0 0\nv 0 1 {odd}\nv 0 1 0\nf 2 3 5\n");
        let document = ok("a.obj", text.as_bytes());
        assert_eq!(mesh_of(&document).faces, [[1, 2, 4]], "{odd}");
        assert_eq!(note(&document, "vertices_not_finite"), (2, Some(Spot::Line(1))));
        let used = format!("{text}f 1 2 3\n");
        let shown = read("obj", used.as_bytes()).unwrap_err().to_string();
        assert!(
            shown.starts_with("part.obj:1:3: this vertex has a coordinate that is NaN or infinite"),
            "{shown}"
        );
        let ply = lines("ply")
            .join("\n")
            .replace("vertex 4", "vertex 5")
            .replace("0 0 1\n", &format!("0 0 1\n1 {odd} 1\n"));
        assert_eq!(volume(mesh_of(&ok("a.ply", ply.as_bytes()))), 1.0, "{odd}");
        let shown = read("ply", ply.replace("3 2 0 3", "3 4 0 3").as_bytes()).unwrap_err().to_string();
        assert!(shown.starts_with("part.ply:14:1: this vertex has"), "{shown}");
    }
    for bad in ["3.1+e2", "1,5", "0x10", "one", "1.2.3"] {
        let shown = read("obj", format!("v 0 {bad} 0\nf 1 1 1\n").as_bytes()).unwrap_err().to_string();
        assert!(shown.starts_with(&format!("part.obj:1:5: '{bad}' is not a number")), "{shown}");
    }
}

fn with_head(head: &str, rows: &[&str]) -> String {
    format!(
        "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\nproperty float z\n{head}\nend_header\n\
             0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 2 0\n1 2 0\n{}\n",
        rows.join("\n")
    )
}

#[test]
fn every_second_triangle_of_a_strip_is_reversed() {
    let head = "element tristrips 1\nproperty list int int vertex_indices";
    let document = ok("a.ply", with_head(head, &["11 0 1 2 3 4 5 -1 5 4 -1 0"]).as_bytes());
    let forward = [[0, 1, 2], [2, 1, 3], [2, 3, 4], [4, 3, 5]];
    assert_eq!(mesh_of(&document).faces, forward);
    assert!(area(mesh_of(&document)) == 2.0 && mesh_of(&document).corners(1)[0] == Vec3::Y);
    assert_eq!(note(&document, "short_faces").0, 2);
    // Strips joined by seams, and a strip beside faces.
    let document = ok("a.ply", with_head(head, &["8 0 1 2 2 3 3 4 5"]).as_bytes());
    assert_eq!(mesh_of(&document).faces, [[0, 1, 2], [4, 3, 5]]);
    assert_eq!(note(&document, "strip_seams").0, 4);
    let both = format!("element face 1\nproperty list uchar int vertex_indices\n{head}");
    let document = ok("a.ply", with_head(&both, &["4 0 1 3 2", "5 2 3 4 5 -1"]).as_bytes());
    assert_eq!(mesh_of(&document).faces, [[0, 1, 3], [0, 3, 2], [2, 3, 4], [4, 3, 5]]);
    let shown = read("ply", with_head(head, &["3 0 1 6"]).as_bytes()).unwrap_err().to_string();
    assert!(shown.contains("tristrips 0 names vertex 6, but there are 6, counted from 0"), "{shown}");
}

#[test]
fn malformed_ply_rows_and_headers() {
    let whole = lines("ply").join("\n");
    // Rows of faces that are longer than the header declares.
    let longer = whole.replace("3 0 2 1", "3 0 2 1 6 0.5 0.5 0 0 1 0").replace("3 2 0 3", "3 2 0 3 0");
    assert_eq!(note(&ok("a.ply", longer.as_bytes()), "extra_numbers"), (2, Some(Spot::Line(14))));
    // Everything on one line, and rows broken anywhere.
    let one = whole.replace('\n', " ");
    let document = ok("a.ply", one.as_bytes());
    assert_eq!((volume(mesh_of(&document)), note(&document, "loose_rows").0), (1.0, 1));
    let broken = whole.replace("3 0 2 1", "3 0\n2 1").replace("0 1 0\n0 0 1", "0 1\n0 0 0 1");
    assert_eq!(volume(mesh_of(&ok("a.ply", broken.as_bytes()))), 1.0);
    let more = format!("{one} 7");
    assert!(read("ply", more.as_bytes()).is_err());
    let after = format!("{whole}\nand more\n\n7\n");
    assert_eq!(note(&ok("a.ply", after.as_bytes()), "extra_lines"), (2, Some(Spot::Line(18))));
    // The signature of old versions of Blender.
    let signed = whole.replace("element vertex", "Created by Blender3D 2.47\nelement vertex");
    assert_eq!(note(&ok("a.ply", signed.as_bytes()), "header_lines"), (1, Some(Spot::Line(3))));
    let commented = whole.replace("0 1 0\n", "comment here\n# and here\n0 1 0\n");
    assert_eq!(volume(mesh_of(&ok("a.ply", commented.as_bytes()))), 1.0);
    let coloured = whole
        .replace("property float z", "property float z\nproperty uchar red")
        .replace("0 0 0", "0 0 0 9")
        .replace("\n1 0 0", "\n1 0 0 9")
        .replace("\n0 1 0", "\n0 1 0 9")
        .replace("\n0 0 1", "\n0 0 1 9");
    let document = ok("a.ply", coloured.as_bytes());
    assert_eq!(mesh_of(&document).attribute("red").unwrap().values, [9.0; 4]);
    let listed = coloured.replace("uchar red", "list uchar uchar red").replace(" 9\n", " 1 9\n");
    let left_out = &ok("a.ply", listed.as_bytes()).notes[0];
    assert!(left_out.to_string().ends_with("1 property or element was not read: red"), "{left_out}");
}

/// The header ends with the same line break as its other lines. After a lone CR or LF, the data may begin with the byte
/// of the other one.
#[test]
fn binary_ply_data_begins_after_one_line_break() {
    for line_break in ["\n", "\r\n", "\r"] {
        let head = [
            "ply",
            "format binary_little_endian 1.0",
            "element vertex 4",
            "property uchar x",
            "property uchar y",
            "property uchar z",
            "element face 1",
            "property list uchar uchar vertex_indices",
            "end_header",
            "",
        ];
        for first in [b'\n', b'\r', 0] {
            let mut bytes = head.join(line_break).into_bytes();
            bytes.extend([first, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 3, 0, 1, 2]);
            let document = ok("a.ply", &bytes);
            assert_eq!(mesh_of(&document).vertices[0].x, f64::from(first), "{line_break:?} {first}");
            assert!(changes(&document).is_empty());
            bytes.extend(b"tail");
            assert_eq!(note(&ok("a.ply", &bytes), "extra_bytes"), (4, Some(Spot::Byte(bytes.len() - 4))));
        }
    }
}

/// The cube from -1 to 1 as binary STL of 12 triangles. `count` is the number that the file declares.
fn cube(count: u32, attribute: u16, payload: &[u8], tail: &[u8]) -> Vec<u8> {
    let corner = |i: usize| [i >> 2 & 1, i >> 1 & 1, i & 1].map(|b| b as f32 * 2.0 - 1.0);
    let quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
    let mut bytes = b"x".to_vec();
    bytes.resize(80, b' ');
    bytes.extend(count.to_le_bytes());
    for [a, b, c, d] in quads {
        for face in [[a, b, c], [a, c, d]] {
            bytes.extend([0; 12]);
            bytes.extend(face.iter().flat_map(|i| corner(*i)).flat_map(f32::to_le_bytes));
            bytes.extend(attribute.to_le_bytes());
            bytes.extend(payload);
        }
    }
    bytes.extend(tail);
    bytes
}

#[test]
fn binary_stl_with_extra_bytes_or_a_wrong_count() {
    let read_all = |bytes: &[u8]| {
        let document = ok("a.stl", bytes);
        assert_eq!((mesh_of(&document).faces.len(), volume(mesh_of(&document)).abs()), (12, 48.0));
        document
    };
    assert!(read_all(&cube(12, 0, b"", b"")).notes.is_empty());
    assert_eq!(note(&read_all(&cube(12, 0x8FFF, b"", b"")), "not_read"), (12, Some(Spot::Byte(132))));
    for length in (1..=104).chain([150, 500, 10_000]) {
        for fill in [0, b'\n', 0xFF] {
            let document = read_all(&cube(12, 0, b"", &vec![fill; length]));
            assert_eq!(note(&document, "extra_bytes"), (length, Some(Spot::Byte(684))), "{fill}");
        }
    }
    for length in [1, 2, 4, 6, 50, 56, 100] {
        let document = read_all(&cube(12, length, &vec![b'a'; length.into()], b""));
        assert_eq!(note(&document, "attribute_bytes"), (12 * usize::from(length), Some(Spot::Byte(134))));
        assert!(changes(&document).is_empty());
    }
    for count in 0..12 {
        let document = read_all(&cube(count, 0, b"", b""));
        assert_eq!(note(&document, "wrong_count"), (12 - count as usize, Some(Spot::Byte(80))));
    }
}

#[test]
fn binary_stl_with_fewer_triangles_than_declared_is_one_error() {
    for count in [13, 500, u32::MAX] {
        let shown = read("stl", &cube(count, 0, b"", b"")).unwrap_err().to_string();
        let expected = format!(
            "byte 684: the count at byte 80 says {count} triangles, but the file ends after 12\nhelp:"
        );
        assert!(shown.contains(&expected), "{shown}");
    }
    let shown = read("stl", &cube(13, 0, b"", b"abc")).unwrap_err().to_string();
    assert!(shown.contains("but the file ends after 12 and 3 bytes of another"), "{shown}");
    let shown = read("stl", &cube(0, 0, b"", b"abc")).unwrap_err().to_string();
    assert!(shown.contains("says that there are no triangles, and the 603 bytes behind it"), "{shown}");
    let shown = read(
        "stl",
        b"<html><body>not found, as servers say it when files have moved away from them</body></html>",
    );
    assert!(shown.unwrap_err().to_string().contains("is a text, but not of an STL"));
}

#[test]
fn text_stl_of_other_programs() {
    let whole = lines("stl").join("\n");
    let kept = |text: &str| {
        let document = ok("a.stl", text.as_bytes());
        assert_eq!((mesh_of(&document).faces.len(), volume(mesh_of(&document))), (4, 1.0), "{text}");
        assert!(changes(&document).is_empty(), "{text}: {:?}", document.notes);
        document.notes.iter().map(|n| (n.kind, n.count)).collect::<Vec<_>>()
    };
    assert_eq!(kept(&whole.replace('\n', " ")), []);
    assert_eq!(kept(&whole.to_uppercase()), []);
    assert_eq!(kept(&whole.replace("endsolid part", "end solid part")), []);
    assert_eq!(kept(&whole.replace("endloop", "end loop").replace("endfacet", "end facet")), []);
    assert_eq!(kept(&whole.replace("solid part", "solid my facet of a solid")), []);
    assert_eq!(kept(&whole.replace("solid part", "solid")), []);
    assert_eq!(kept(&whole.replace("normal 0 0 1", "normal nan -1.#IND inf")), []);
    assert_eq!(kept(&whole.replace("normal 0 0 1", "")), []);
    assert_eq!(kept(&format!("# made by\n# someone\n{whole}")), []);
    assert_eq!(kept(&format!("made by a solid program\n{whole}")), [("text_outside", 1)]);
    assert_eq!(kept(&format!("{whole}\nand more\nof it\n")), [("text_outside", 2)]);
    assert_eq!(
        kept(&whole.replace("facet normal", "color 0.5 0.5 0.5\nfacet normal")),
        [("colours_not_read", 4)]
    );
    assert_eq!(kept(&whole.replace("outer loop", "color 1 0 0\nouter loop")), [("colours_not_read", 4)]);
    let (first, second) = whole.split_at(whole.match_indices("facet normal").nth(2).unwrap().0);
    let two = format!("{first}endsolid part\nsolid other\n{second}");
    assert_eq!(kept(&two), [("groups_joined", 1)]);
    assert_eq!(kept(&two.replace('\n', " ")), [("groups_joined", 1)]);
    assert_eq!(kept(&two.replacen("endsolid part", "", 1)), [("groups_joined", 1)]);
    let open = ok("a.stl", whole.replace("endsolid part", "").as_bytes());
    assert_eq!((volume(mesh_of(&open)), changes(&open)), (1.0, vec!["no_endsolid"]));
    let quad = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\nvertex 0 1 0\n\
                endloop\nendfacet\nendsolid\n";
    assert_eq!(mesh_of(&ok("a.stl", quad.as_bytes())).faces, [[0, 1, 2], [0, 2, 3]]);
}

/// A format that does not follow from the file name is detected from the contents, with or without a byte order mark.
#[test]
fn contents_with_marks_are_recognised() {
    for (extension, name) in [("obj", "OBJ"), ("ply", "PLY"), ("stl", "STL")] {
        for (mark, line_break) in [("", "\n"), ("\u{FEFF}", "\r"), ("\u{FEFF}", "\r\n"), ("", " ")] {
            if extension == "obj" && line_break == " " {
                continue;
            }
            let bytes = format!("{mark}{}", lines(extension).join(line_break)).into_bytes();
            let found = FORMATS.iter().find(|f| (f.detect)(&bytes)).map(|f| f.name);
            assert_eq!(found, Some(name), "{mark:?} {line_break:?}");
        }
    }
}
