//! OFF files.

mod reading;

use reading::{ok, refused};
use shotline::math::Vec3;
use shotline::scene::Node;
use shotline::solid::mesh::TriangleMesh;
use shotline_io::{Document, Effect, load, save};

const TETRAHEDRON: &str = "OFF\n4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n";

fn mesh(document: &Document) -> &TriangleMesh {
    let mesh = document.scene.nodes.iter().find_map(|node| match node {
        Node::Mesh { mesh, .. } => Some(mesh),
        _ => None,
    });
    mesh.expect("a mesh")
}

#[test]
fn variants_of_one_tetrahedron_are_the_same() {
    let plain = ok("part.off", TETRAHEDRON);
    assert_eq!((mesh(&plain).vertices.len(), mesh(&plain).faces[1]), (4, [0, 1, 3]));
    assert!(plain.notes.iter().all(|note| note.effect == Effect::Kept));
    for variant in [
        TETRAHEDRON.replace('\n', "\r\n"),
        TETRAHEDRON.replace('\n', "\r"),
        TETRAHEDRON.replace("OFF\n", "OFF "),
        TETRAHEDRON.replace("OFF\n", ""),
        TETRAHEDRON.replace("4 4 6", "# counts\n\n4 4 # without edges"),
        format!("\u{feff}# by a program\n{TETRAHEDRON}\n\n# end\n"),
        TETRAHEDRON.replace("OFF", "COFF").replace("1 0 0\n", "1 0 0 255 0 0 255\n"),
        TETRAHEDRON.replace("OFF", "NOFF").replace("0 0 1\n", "0 0 1 0 0 1\n"),
        TETRAHEDRON.replace("3 0 1 3", "  3\t0 1 3  0.5 0.5 0.5"),
    ] {
        assert_eq!(mesh(&ok("part.off", &variant)), mesh(&plain), "{variant}");
    }
    // Without a name the header tells the format.
    assert_eq!(mesh(&ok("-", TETRAHEDRON)), mesh(&plain));
    let coloured = ok("part.off", TETRAHEDRON.replace("3 0 1 3", "3 0 1 3 255 0 0"));
    let skipped = coloured.notes.iter().find(|note| note.kind == "not_read").expect("a note");
    assert_eq!(skipped.text, "colours, normals and texture coordinates on 1 line were not read");
}

#[test]
fn faces_have_any_number_of_corners() {
    let text = "OFF 5 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\nnan 0 0\n4 0 1 2 3\n2 0 1\n";
    let document = ok("part.off", text);
    let found = mesh(&document);
    assert_eq!((found.faces.len(), &found.polygons[..]), (2, &[0, 0][..]));
    let kinds: Vec<_> = document.notes.iter().map(|note| note.kind).collect();
    for kind in ["polygons_cut", "short_faces", "vertices_not_finite"] {
        assert!(kinds.contains(&kind), "{kinds:?}");
    }
    let more = ok("part.off", format!("{TETRAHEDRON}1 2 3\n"));
    assert!(more.notes.iter().any(|note| note.kind == "lines_behind" && note.effect == Effect::Changed));
}

#[test]
fn what_is_wrong_is_told_with_its_line() {
    let changed = |from: &str, to: &str| TETRAHEDRON.replacen(from, to, 1);
    for (text, why) in [
        ("".to_owned(), "has no numbers of vertices and faces"),
        ("OFF\n".to_owned(), "has no numbers of vertices and faces"),
        ("OFF BINARY\n4 4 6\n".to_owned(), "part.off:1:5: binary OFF files are not read"),
        ("4OFF\n4 4 6\n".to_owned(), "'4OFF' has vertices of another dimension than 3"),
        (changed("4 4 6", "4"), "part.off:2:1: here are the numbers of vertices and faces expected"),
        (changed("4 4 6", "4 -4 6"), "part.off:2:3: '-4' is not a number of vertices or faces"),
        (changed("0 1 0", "0 1,5 0"), "part.off:5:3: '1,5' is not a number"),
        (changed("0 1 0", "0 1"), "part.off:5:1: a vertex has three coordinates, on one line"),
        (changed("0 1 0", "0 nan 0"), "part.off:5:3: this vertex has a coordinate that is NaN"),
        (changed("3 0 2 1", "3 0 2"), "part.off:7:1: a face of 3 corners has 2 on its line"),
        (changed("3 0 2 1", "3 0 2 x"), "part.off:7:7: 'x' is not the number of a vertex"),
        (changed("3 0 2 1", "3 0 2 4"), "part.off:7:1: there is no vertex 4; the file has 4, counted from 0"),
        (changed("3 0 2 1", "3 0 2 -1"), "there is no vertex -1"),
        (changed("3 0 2 1", "3.0 0 2 1"), "part.off:7:1: '3.0' is not the number of corners of a face"),
        (changed("4 4 6", "4 5 6"), "promises 5 faces, but has 4"),
        (changed("4 4 6", "4000000000 4 6"), "promises 4000000000 vertices, but has 8"),
        ("OFF 4 4 6 0 0 0 1 0 0 0 1 0 0 0 1 3 0 2 1".to_owned(), "promises 4 vertices, but has 0"),
        ("OFF\n3 0 0\n0 0 0\n1 0 0\n0 1 0\n".to_owned(), "has no faces"),
    ] {
        refused("part.off", text, why);
    }
}

#[test]
fn what_is_written_is_read_again() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("part.off");
    let moved = TETRAHEDRON.replace("0 1 0", "0.1 1e-300 -0.0");
    let document = ok("part.off", &moved);
    save(&path, &document.scene).expect("a file");
    let again = load(&path).expect("a mesh");
    assert_eq!(mesh(&again), mesh(&document));
    assert_eq!(
        mesh(&again).vertices[2].to_array().map(f64::to_bits),
        [0.1, 1e-300, -0.0_f64].map(f64::to_bits)
    );
    assert_eq!(mesh(&again).vertices[3], Vec3::Z);
}
