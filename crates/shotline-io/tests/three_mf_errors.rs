//! Wrong 3MF files: each is refused with what is wrong, where, and how to mend it; none panics.

mod package;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use package::{RELS, TETRAHEDRON, model, package, tetrahedron, zip, zip_by};
use shotline::testkit::random::Random;
use shotline_io::{ReadOptions, load_bytes};
use zip::CompressionMethod;

const ITEM: &str = "<item objectid=\"1\"/>";

fn message(bytes: Vec<u8>) -> Option<String> {
    match load_bytes(Path::new("part.3mf"), bytes, ReadOptions::default()) {
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

/// The message for a model with an object 1, whose error is on this line.
#[track_caller]
fn expect_at(text: &str, line: usize, says: &str) {
    let message = message(package(text)).unwrap_or_else(|| panic!("read: {says}\n{text}"));
    assert!(message.starts_with(&format!("part.3mf/3D/3dmodel.model:{line}:")), "{message}\n{text}");
    assert!(message.contains(says) && message.contains("\nhelp: "), "{says}: {message}");
}

#[test]
fn wrong_meshes() {
    let whole = model(&tetrahedron(1, ""), ITEM);
    assert_eq!(message(package(&whole)), None);
    let vertex = "<vertex x=\"1\" y=\"0\" z=\"0\"/>";
    let triangle = "<triangle v1=\"0\" v2=\"2\" v3=\"1\"/>";
    for (old, new, says) in [
        (vertex, "<vertex x=\"a\" y=\"0\" z=\"0\"/>", "'a' is not a number"),
        (vertex, "<vertex x=\"1,5\" y=\"0\" z=\"0\"/>", "'1,5' is not a number"),
        (vertex, "<vertex x=\"NaN\" y=\"0\" z=\"0\"/>", "NaN is not finite"),
        (vertex, "<vertex x=\"1e999\" y=\"0\" z=\"0\"/>", "1e999 is not finite"),
        (vertex, "<vertex x=\"1\" y=\"0\"/>", "<vertex> has no attribute 'z'"),
        (vertex, "", "there is no vertex 3; it has 3, counted from 0"),
        (triangle, "<triangle v1=\"0\" v2=\"2\"/>", "<triangle> has no attribute 'v3'"),
        (triangle, "<triangle v1=\"0\" v2=\"2\" v3=\"-1\"/>", "'-1' is not a whole number"),
        (triangle, "<triangle v1=\"0\" v2=\"2\" v3=\"4294967296\"/>", "is not a whole number"),
        (triangle, "<triangle v1=\"0\" v2=\"2\" v3=\"4294967295\"/>", "there is no vertex 4294967295"),
        (triangle, "<triangle v1=\"0\" v2=\"2\" v3=\"1.5\"/>", "'1.5' is not a whole number"),
        (
            triangle,
            "<triangle v1=\"0\" v2=\"2\" v3=\"1\" pid=\"9\" p1=\"0\"/>",
            "there is no group of properties 9",
        ),
        (triangle, "<triangle v1=\"0\" v2=\"2\" v3=\"1\" pid=\"9\" p1=\"x\"/>", "'x' is not a whole number"),
        ("<vertices>", "<points>", "expected"),
        ("<mesh>", "<mesh><mesh/>", ""),
    ] {
        let text = whole.replacen(old, new, 1);
        if says.is_empty() {
            assert_eq!(message(package(&text)), None);
        } else {
            expect_at(&text, 4, says);
        }
    }
    for (mesh, says) in [
        ("<mesh/>", "object 1 has no <vertices>"),
        ("<mesh><vertices/></mesh>", "object 1 has no <triangles>"),
        ("<mesh><vertices/><triangles/></mesh>", "object 1 has no triangle"),
        ("", "object 1 must have a <mesh> or <components>, and not both"),
        ("<mesh/><components/>", "object 1 must have a <mesh> or <components>, and not both"),
    ] {
        expect_at(&model(&format!("<object id=\"1\">{mesh}</object>"), ITEM), 4, says);
    }
    let flat = whole
        .replace("v2=\"2\"", "v2=\"0\"")
        .replace("v2=\"1\"", "v2=\"0\"")
        .replace("v1=\"1\"", "v1=\"3\"")
        .replace("v1=\"2\"", "v1=\"3\"");
    expect_at(&flat, 4, "no triangle with three different corners");
}

#[test]
fn wrong_objects_and_items() {
    let object = tetrahedron(1, "");
    let component = |parts: &str| format!("<object id=\"2\"><components>{parts}</components></object>");
    for (resources, build, line, says) in [
        (tetrahedron(1, "").replace("id=\"1\"", ""), ITEM, 4, "<object> has no attribute 'id'"),
        (tetrahedron(1, "").replace("id=\"1\"", "id=\"x\""), ITEM, 4, "'x' is not a whole number"),
        (format!("{object}\n{object}"), ITEM, 5, "there are two objects 1"),
        (tetrahedron(1, "type=\"ghost\""), ITEM, 4, "there is no type of object 'ghost'"),
        (tetrahedron(1, "pid=\"5\""), ITEM, 4, "there is no group of properties 5"),
        (object.clone(), "<item objectid=\"2\"/>", 6, "there is no object 2"),
        (object.clone(), "<item/>", 6, "<item> has no attribute 'objectid'"),
        (object.clone(), "<item objectid=\"1\" transform=\"1 0 0\"/>", 6, "a transform is 12 numbers"),
        (
            object.clone(),
            "<item objectid=\"1\" transform=\"1 0 0 0 1 0 0 0 1 0 0 0 0\"/>",
            6,
            "a transform is 12 numbers",
        ),
        (
            object.clone(),
            "<item objectid=\"1\" transform=\"1 0 0 0 1 0 0 0 1 0 0 inf\"/>",
            6,
            "inf is not finite",
        ),
        (
            object.clone(),
            "<item objectid=\"1\" transform=\"1 0 0 0 1 0 0 0 1 0 0 z\"/>",
            6,
            "'z' is not a number",
        ),
        (
            component("<component objectid=\"2\"/>"),
            "<item objectid=\"2\"/>",
            4,
            "object 2 consists of itself",
        ),
        (component("<component objectid=\"7\"/>"), "<item objectid=\"2\"/>", 4, "there is no object 7"),
        (component("<component/>"), "<item objectid=\"2\"/>", 4, "<component> has no attribute 'objectid'"),
        (
            format!(
                "{}\n<object id=\"3\"><components><component objectid=\"2\"/></components></object>",
                component("<component objectid=\"3\"/>")
            ),
            "<item objectid=\"3\"/>",
            4,
            "object 3 consists of itself",
        ),
        (
            "<basematerials id=\"4\"><base name=\"a\" displaycolor=\"red\"/></basematerials>".into(),
            "",
            4,
            "'red' is no colour",
        ),
        (
            "<basematerials id=\"4\"><base name=\"a\"/></basematerials>".into(),
            "",
            4,
            "<base> has no attribute 'displaycolor'",
        ),
        ("<basematerials><base name=\"a\"/></basematerials>".into(), "", 4, "no attribute"),
        (
            "<m:colorgroup id=\"4\"><m:color color=\"#12345\"/></m:colorgroup>".into(),
            "",
            4,
            "'#12345' is no colour",
        ),
        ("<m:colorgroup id=\"4\"><m:color color=\"#+12345\"/></m:colorgroup>".into(), "", 4, "is no colour"),
        (
            "<m:colorgroup id=\"4\"/><m:colorgroup id=\"4\"/>".into(),
            "",
            4,
            "there are two groups of properties 4",
        ),
        (
            format!("<m:colorgroup id=\"4\"/>\n{}", tetrahedron(1, "pid=\"4\" pindex=\"1\"")),
            ITEM,
            5,
            "group 4 has 0 properties; there is none of index 1",
        ),
    ] {
        expect_at(&model(&resources, build), line, says);
    }
    expect(package(&model(&object, "")), "the model builds no object");
    expect(package(&model(&component(""), "<item objectid=\"2\"/>")), "the model builds no object");
    expect(package(&model(&tetrahedron(1, "type=\"support\""), ITEM)), "the model builds no object");
    let elsewhere = "<item objectid=\"1\" p:path=\"/3D/none.model\"/>";
    expect(package(&model(&object, elsewhere)), "the package has no part '3D/none.model'");
}

#[test]
fn wrong_models() {
    let whole = model(&tetrahedron(1, ""), ITEM);
    for (old, new, line, says) in [
        ("unit=\"millimeter\"", "unit=\"mm\"", 2, "'mm' is no unit of 3MF"),
        (
            "<model ",
            "<model requiredextensions=\"x\" ",
            2,
            "requires the extension urn:x, which is not known",
        ),
        ("<model ", "<model requiredextensions=\"m z\" ", 2, "'z' is no prefix of a namespace"),
        ("<resources>", "<resource>", 5, ""),
        ("</model>", "", 6, "the file ends before its elements do"),
        ("<build>", "<build", 6, ""),
        ("<build>", "<build a=\"1\" a=\"2\">", 6, "the attribute 'a' is given twice"),
        ("<build>", "<build>&nothing;", 6, ""),
    ] {
        expect_at(&whole.replace(old, new), line, says);
    }
    expect_at("<model><build/></model>", 1, "the model has no <resources>");
    expect_at("<part/>", 1, "the root element is <part>, not <model>");
    expect(package(""), "part.3mf/3D/3dmodel.model:1:1: ");
    let bytes = whole.clone().into_bytes();
    let with = |bytes: &[u8]| zip(&[("_rels/.rels", RELS.as_bytes()), ("3D/3dmodel.model", bytes)]);
    let mut wrong = bytes.clone();
    wrong[120] = 0xFF;
    expect(with(&wrong), "the text is not UTF-8 from here on");
    let wide: Vec<u8> = whole.encode_utf16().flat_map(u16::to_le_bytes).collect();
    expect(with(&[&[0xFF, 0xFE], &wide[..]].concat()), "is UTF-16 text");
    let entities = "<!DOCTYPE model [<!ENTITY a \"aaaa\">]>\n<model>&a;</model>";
    assert!(message(package(entities)).is_some());
    let deep = format!("{}{}", "<a>".repeat(200_000), "</a>".repeat(200_000));
    assert!(message(package(&deep)).is_some());
}

#[test]
fn wrong_packages() {
    let text = model(&tetrahedron(1, ""), ITEM);
    expect(zip(&[]), "the package has no part '_rels/.rels'");
    expect(b"PK\x03\x04".to_vec(), "is no zip file, or a damaged one");
    expect(b"".to_vec(), "is no zip file, or a damaged one");
    expect(zip(&[("_rels/.rels", RELS.as_bytes())]), "the package has no part '3D/3dmodel.model'");
    let rels = |rels: &[u8]| zip(&[("_rels/.rels", rels), ("3D/3dmodel.model", text.as_bytes())]);
    expect(rels(b"<Relationships/>"), "_rels/.rels: the relationship to a model is missing");
    expect(rels(b"<Relationships>"), "_rels/.rels: ");
    expect(rels(b"\xFF\xFF\xFF"), "_rels/.rels: ");
    expect(rels(RELS.replace("/3D/3dmodel.model", "").as_bytes()), "the package has no part ''");
    let whole = package(&text);
    for end in (0..whole.len()).step_by(5) {
        expect(whole[..end].to_vec(), "is no zip file, or a damaged one");
    }
    // A byte of the content that is not what the checksum says.
    let mut stored = zip_by(
        CompressionMethod::Stored,
        &[("_rels/.rels", RELS.as_bytes()), ("3D/3dmodel.model", text.as_bytes())],
    );
    let at = stored.windows(9).position(|word| word == b"resources").unwrap();
    stored[at + 30] ^= 1;
    expect(stored, "the part '3D/3dmodel.model' cannot be unpacked");
    // Methods of packing that are not read, and one that does not exist.
    for (number, says) in [(14, "is packed by LZMA, which is not supported"), (77, "is packed by method 77")]
    {
        let mut strange = whole.clone();
        for at in 0..strange.len() - 4 {
            match &strange[at..at + 4] {
                b"PK\x03\x04" => strange[at + 8] = number,
                b"PK\x01\x02" => strange[at + 10] = number,
                _ => {}
            }
        }
        expect(strange, says);
    }
    let mut secret = whole;
    for at in 0..secret.len() - 4 {
        match &secret[at..at + 4] {
            b"PK\x03\x04" => secret[at + 6] |= 1,
            b"PK\x01\x02" => secret[at + 8] |= 1,
            _ => {}
        }
    }
    expect(secret, "cannot be unpacked");
}

#[test]
fn damaged_files_never_panic() {
    let groups = "<basematerials id=\"10\"><base name=\"a\" displaycolor=\"#FF0000\"/></basematerials>";
    let painted = TETRAHEDRON.replacen("v3=\"1\"/>", "v3=\"1\" pid=\"10\" p1=\"0\"/>", 1);
    let resources = format!(
        "{groups}{}<object id=\"2\"><components><component objectid=\"1\" transform=\"1 0 0 0 1 0 0 0 1 5 0 0\"/>\
         </components></object><object id=\"3\">{painted}</object>",
        tetrahedron(1, "pid=\"10\" pindex=\"0\"")
    );
    let text = model(&resources, "<item objectid=\"2\"/><item objectid=\"3\"/>");
    let parts = |text: &[u8]| {
        zip_by(CompressionMethod::Stored, &[("_rels/.rels", RELS.as_bytes()), ("3D/3dmodel.model", text)])
    };
    let (packed, mut random) = (package(&text), Random::new(13));
    for case in 0..20_000 {
        // Half of the time the package is damaged, half of the time the model within a package that is sound.
        let bytes = if case % 2 == 0 {
            damaged(&packed, &mut random)
        } else {
            parts(&damaged(text.as_bytes(), &mut random))
        };
        let outcome = catch_unwind(AssertUnwindSafe(|| message(bytes.clone())));
        assert!(
            outcome.is_ok_and(|message| message.is_none_or(|m| !m.is_empty())),
            "{}",
            String::from_utf8_lossy(&bytes)
        );
    }
}

fn damaged(whole: &[u8], random: &mut Random) -> Vec<u8> {
    const WORDS: [&str; 6] = ["-1", "4294967295", "1e999", "\"", "<", "/>"];
    let mut bytes = whole.to_vec();
    for _ in 0..=random.below(3) {
        let at = random.below(bytes.len().max(1)).min(bytes.len());
        let end = (at + 1 + random.below(6)).min(bytes.len());
        match random.below(6) {
            0 => bytes.truncate(at),
            1 => drop(bytes.drain(at..end)),
            2 => bytes.splice(at..end, WORDS[random.below(WORDS.len())].bytes()).for_each(drop),
            3 => bytes.extend_from_within(at..end),
            4 if at < bytes.len() => bytes[at] ^= 1 << random.below(8),
            _ if at < bytes.len() => bytes[at] = random.bits() as u8,
            _ => {}
        }
    }
    bytes
}
