//! Broken GDML files: each is an error that names the line, says what is wrong and how to mend it.

use std::path::Path;

use shotline::compile::compile;
use shotline::math::Vec3;
use shotline::query::{Caster, Overlaps};
use shotline::ray::{Ray, Span};
use shotline_io::{ReadOptions, load, load_bytes};

/// A file with these sections; `#` is replaced by what is broken.
fn file(define: &str, materials: &str, solids: &str, structure: &str, setup: &str) -> String {
    format!(
        "<?xml version=\"1.0\"?>\n<gdml>\n<define>{define}</define>\n<materials>{materials}</materials>\n\
         <solids>\n<box name=\"b\" x=\"10\" y=\"10\" z=\"10\"/>\n{solids}\n</solids>\n\
         <structure>\n{structure}\n<volume name=\"world\"><materialref ref=\"Al\"/><solidref ref=\"b\"/></volume>\n\
         </structure>\n{setup}\n</gdml>\n"
    )
}

const AL: &str = "<material name=\"Al\" Z=\"13\"><D value=\"2.7\"/><atom value=\"26.98\"/></material>";
const SETUP: &str = "<setup name=\"Default\" version=\"1.0\"><world ref=\"world\"/></setup>";

fn with_define(text: &str) -> String {
    file(text, AL, "", "", SETUP)
}

fn with_materials(text: &str) -> String {
    file("", &format!("{AL}{text}"), "", "", SETUP)
}

fn with_solid(text: &str) -> String {
    file("", AL, text, "", SETUP)
}

fn with_volume(text: &str) -> String {
    file("", AL, "", text, SETUP)
}

/// The message for a text, or nothing if it is read.
fn message(text: &str) -> String {
    match load_bytes(Path::new("part.gdml"), text.as_bytes().to_vec(), ReadOptions::default()) {
        Ok(document) => match compile(&document.scene, Default::default()) {
            Ok(_) => String::new(),
            Err(errors) => document.diagnostics(&errors).to_string(),
        },
        Err(error) => error.to_string(),
    }
}

/// Checks that the message names the line, says this and has help.
fn expect(text: &str, line: usize, says: &str) {
    let message = message(text);
    assert!(message.starts_with(&format!("part.gdml:{line}:")), "line {line}: {message}\n{text}");
    assert!(message.contains(says), "{says}: {message}");
    assert!(message.contains("\nhelp: "), "{message}");
}

#[test]
fn the_file_without_an_error_is_read() {
    for text in [with_define(""), with_materials(""), with_solid(""), with_volume("")] {
        assert_eq!(message(&text), "");
    }
}

#[test]
fn broken_definitions() {
    for (text, says) in [
        ("<constant name=\"a\" value=\"2*\"/>", "'2*' has no value: a number is missing at the end"),
        ("<constant name=\"a\" value=\"bb+1\"/>", "'bb' is not defined"),
        ("<constant name=\"a\" value=\"1/0\"/>", "it divides by zero"),
        ("<constant value=\"1\"/>", "<constant> lacks the attribute \"name\""),
        ("<constant name=\"a\" val=\"1\"/>", "<constant> lacks the attribute \"value\""),
        ("<expression name=\"a\">sine(1)</expression>", "there is no function 'sine'"),
        ("<position name=\"p\" x=\"1\" unit=\"furlong\"/>", "'furlong' is no unit of length"),
        ("<rotation name=\"r\" x=\"1\" unit=\"mm\"/>", "'mm' is no unit of angle"),
        ("<matrix name=\"m\" coldim=\"2\" values=\"1 2 3\"/>", "3 values do not fill rows of 2"),
        ("<matrix name=\"m\" coldim=\"0\" values=\"1\"/>", "must be a whole number from 1"),
        (
            "<matrix name=\"m\" coldim=\"2\" values=\"1 2 3 4\"/><constant name=\"a\" value=\"m[3,1]\"/>",
            "has no element [3,1]",
        ),
        (
            "<matrix name=\"m\" coldim=\"1\" values=\"1 2\"/><constant name=\"a\" value=\"m[0]\"/>",
            "not a whole number from 1",
        ),
        ("<constant name=\"a\" value=\"m_18446744073709551615\"/>", "is not defined"),
        ("<place name=\"p\"/>", "<place> is no definition"),
        ("<loop for=\"i\" to=\"3\"/>", "'i' is not a defined variable"),
        ("<variable name=\"i\" value=\"1\"/><loop for=\"i\" to=\"3\" step=\"0\"/>", "has no end"),
        ("<variable name=\"i\" value=\"1\"/><loop for=\"i\" to=\"1e9\"/>", "are more than 4000000"),
    ] {
        expect(&with_define(text), 3, says);
    }
}

#[test]
fn broken_materials() {
    for (text, says) in [
        ("<material name=\"x\"><D value=\"-1\"/></material>", "the density is -1 g/cm3"),
        ("<material name=\"x\"><D value=\"1\" unit=\"kg\"/></material>", "'kg' is no unit of density"),
        (
            "<material name=\"x\"><fraction n=\"1\" ref=\"Be\"/></material>",
            "there is no element or material 'Be'",
        ),
        ("<element name=\"x\"><fraction n=\"1\" ref=\"Be9\"/></element>", "there is no isotope 'Be9'"),
        ("<metal name=\"x\"/>", "<metal> has no meaning in <materials>"),
    ] {
        expect(&with_materials(text), 4, says);
    }
}

#[test]
fn broken_solids() {
    for (text, says) in [
        ("<box name=\"x\" x=\"1\" y=\"1\"/>", "<box> lacks the attribute \"z\""),
        ("<box name=\"x\" x=\"1\" y=\"1\" z=\"-2\"/>", "\"z\" is -2 mm, but must be positive"),
        ("<box name=\"x\" x=\"1\" y=\"1\" z=\"1\" lunit=\"deg\"/>", "'deg' is no unit of length"),
        (
            "<tube name=\"x\" rmin=\"2\" rmax=\"1\" z=\"1\" deltaphi=\"1\"/>",
            "\"rmax\" is 1 mm, but must be above \"rmin\", 2 mm",
        ),
        ("<tube name=\"x\" rmin=\"-1\" rmax=\"1\" z=\"1\" deltaphi=\"1\"/>", "must not be negative"),
        ("<tube name=\"x\" rmax=\"1\" z=\"1\"/>", "<tube> lacks the attribute \"deltaphi\""),
        ("<tube name=\"x\" rmax=\"1\" z=\"1\" deltaphi=\"-1\"/>", "but must be positive"),
        (
            "<union name=\"x\"><first ref=\"b\"/><second ref=\"c\"/></union>",
            "there is no solid 'c' before this line",
        ),
        ("<union name=\"x\"><first ref=\"b\"/></union>", "lacks its first or second solid"),
        (
            "<union name=\"x\"><first ref=\"b\"/><second ref=\"b\"/><positionref ref=\"p\"/></union>",
            "there is no position 'p'",
        ),
        (
            "<union name=\"x\"><first ref=\"b\"/><second ref=\"b\"/><third ref=\"b\"/></union>",
            "<third> has no meaning in <union>",
        ),
        ("<multiUnion name=\"x\"/>", "the union has no solids"),
        (
            "<tessellated name=\"x\"><triangular vertex1=\"v1\" vertex2=\"v2\" vertex3=\"v3\"/></tessellated>",
            "there is no position 'v1'",
        ),
        ("<frustum name=\"x\"/>", "1 of <frustum> is not supported"),
        (
            "<polycone name=\"x\" deltaphi=\"1\"><zplane z=\"1\" rmax=\"1\"/></polycone>",
            "has 1 of the 2 <zplane> it needs",
        ),
    ] {
        expect(&with_solid(text), 7, says);
    }
}

#[test]
fn broken_structures() {
    let volume = |content: &str| {
        format!("<volume name=\"v\"><materialref ref=\"Al\"/><solidref ref=\"b\"/>{content}</volume>")
    };
    let placed = volume("<physvol name=\"a#[\"><volumeref ref=\"early\"/></physvol>");
    let many_brackets = format!("<volume name=\"early\"><solidref ref=\"b\"/></volume>{placed}")
        .replace('#', &"[-1e300]".repeat(50_000));
    for (text, says) in [
        ("<volume name=\"v\"><materialref ref=\"Al\"/></volume>".to_owned(), "the volume 'v' has no solid"),
        (
            "<volume name=\"v\"><materialref ref=\"Ai\"/><solidref ref=\"b\"/></volume>".to_owned(),
            "there is no material 'Ai'",
        ),
        (volume("<physvol><volumeref ref=\"v\"/></physvol>"), "there is no volume 'v' before this line"),
        (
            volume("<physvol><volumeref ref=\"world\"/></physvol>"),
            "there is no volume 'world' before this line",
        ),
        (volume("<physvol/>"), "the placement names no volume"),
        (volume("<physvol><file name=\"none.gdml\"/></physvol>"), "'none.gdml' cannot be opened"),
        (volume("<physvol><file name=\"/etc/passwd\"/></physvol>"), "the path of this file is absolute"),
        (volume("<physvol><file name=\"../../other.gdml\"/></physvol>"), "other.gdml"),
        (volume("<physvol name=\"a[\"><volumeref ref=\"v\"/></physvol>"), "there is no volume 'v'"),
        (many_brackets, "a ']' is missing"),
        (volume("<replicavol number=\"0\"/>"), "must be a whole number from 1"),
        (volume("<physvolume/>"), "1 of <physvolume> in <volume> is not supported"),
    ] {
        expect(&with_volume(&text), 10, says);
    }
}

#[test]
fn broken_setups() {
    let with_setup = |setup: &str| file("", AL, "", "", setup);
    expect(
        &with_setup("<setup name=\"Default\"><world ref=\"hall\"/></setup>"),
        13,
        "there is no volume 'hall'",
    );
    expect(&with_setup("<setup name=\"Default\"/>"), 13, "the setup has no <world>");
    let none = message(&with_setup(""));
    assert!(none.starts_with("part.gdml: the file has no setup"), "{none}");
}

#[test]
fn broken_xml() {
    let unclosed = with_solid("<union name=\"x\">");
    assert!(message(&unclosed).starts_with("part.gdml:8:"), "{}", message(&unclosed));
    // An element that begins in an entity and ends behind it, with characters of several bytes in between.
    let cut = "<!DOCTYPE gdml [<!ENTITY e \"<gdml><\u{e9}>\">]>\n<gdml>&e;\u{e9}\u{e9}\u{e9}</\u{e9}></gdml>";
    assert!(message(cut).contains("part.gdml"));
    let entity = with_solid("&parts;");
    assert!(
        message(&entity).contains("part.gdml:7:")
            && message(&entity).contains("the entity '&parts;' is not defined")
    );
    let loops = format!("<!DOCTYPE gdml [<!ENTITY a \"&b;\"><!ENTITY b \"&a;\">]>\n{}", "<gdml>&a;</gdml>");
    assert!(message(&loops).contains("an entity refers to itself"), "{}", message(&loops));
    let levels = (1..12).map(|i| format!("<!ENTITY e{i} \"{}\">", format!("&e{};", i - 1).repeat(10)));
    let bomb = format!(
        "<!DOCTYPE gdml [<!ENTITY e0 \"{}\">{}]>\n<gdml><define>&e11;</define></gdml>",
        "x".repeat(1000),
        levels.collect::<String>()
    );
    assert!(!message(&bomb).is_empty());
    let wide = format!(
        "<!DOCTYPE gdml [<!ENTITY e \"{}\">]>\n<gdml><define a=\"{}\"/></gdml>",
        "x".repeat(100_000),
        "&e;".repeat(100_000)
    );
    assert!(message(&wide).contains("could expand to"), "{}", &message(&wide)[..200]);
    assert!(message("<gdml>").contains("part.gdml"));
    assert!(message("").contains("part.gdml"));
    assert!(message("<root/>").contains("the root element is <root>, not <gdml>"));
    for nested in ["loop for=\"i\" to=\"1\"", "parameterised_position_size"] {
        let end = nested.split(' ').next().unwrap_or_default();
        let deep = format!("{}{}", format!("<{nested}>").repeat(50_000), format!("</{end}>").repeat(50_000));
        let contents = format!(
            "<volume name=\"v\"><solidref ref=\"b\"/><paramvol><volumeref ref=\"v\"/>{deep}</paramvol>{}</volume>",
            if end == "loop" { deep.as_str() } else { "" }
        );
        let text = with_volume(&contents).replace("<define>", "<define><variable name=\"i\" value=\"0\"/>");
        assert!(
            message(&text).contains("part.gdml:10:"),
            "{}",
            &message(&text)[..300.min(message(&text).len())]
        );
    }
    let deep = format!("<gdml>{}{}</gdml>", "<define>".repeat(100_000), "</define>".repeat(100_000));
    assert!(!message(&deep).is_empty());
}

/// Several errors are reported together, in the order of the file, without the errors that follow from them.
#[test]
fn all_errors_are_reported_and_none_that_follow() {
    let solids = "<box name=\"x\" x=\"1\" y=\"1\"/>\n<tube name=\"t\" rmax=\"0\" z=\"1\" deltaphi=\"1\"/>\n\
                  <union name=\"u\"><first ref=\"x\"/><second ref=\"t\"/></union>";
    let volume = "<volume name=\"v\"><materialref ref=\"Al\"/><solidref ref=\"u\"/></volume>\n\
                  <volume name=\"w\"><materialref ref=\"Al\"/><solidref ref=\"b\"/>\
                  <physvol><volumeref ref=\"v\"/></physvol></volume>";
    let text = file("", AL, solids, volume, SETUP);
    let message = message(&text);
    assert_eq!(message.matches("part.gdml:").count(), 2, "{message}");
    assert!(message.contains("part.gdml:7:") && message.contains("part.gdml:8:"), "{message}");
}

/// An error in a file that is included is shown in that file.
#[test]
fn errors_in_included_files_name_them() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("a file");
    let main = with_solid("&solids;")
        .replace("?>\n", "?>\n<!DOCTYPE gdml [<!ENTITY solids SYSTEM \"parts/solids.xml\">]>\n");
    std::fs::create_dir(folder.path().join("parts")).expect("a folder");
    write("main.gdml", &main);
    write("parts/solids.xml", "<?xml version=\"1.0\"?>\n<box name=\"x\"\n x=\"1\" y=\"0\" z=\"1\"/>\n");
    let error = load(folder.path().join("main.gdml")).expect_err("a wrong box").to_string();
    assert!(error.contains("solids.xml:3:11: \"y\" is 0 mm, but must be positive"), "{error}");
    write("parts/solids.xml", "<box name=\"x\" ");
    let error = load(folder.path().join("main.gdml")).expect_err("a broken file").to_string();
    assert!(error.contains("solids.xml:1:15: "), "{error}");
    let module = with_volume(
        "<volume name=\"v\"><solidref ref=\"b\"/><physvol><file name=\"module.gdml\"/></physvol></volume>",
    );
    write("main.gdml", &module);
    write("module.gdml", &with_solid("<box name=\"x\" x=\"1\" y=\"a\" z=\"1\"/>"));
    let error = load(folder.path().join("main.gdml")).expect_err("a wrong module").to_string();
    assert!(error.contains("module.gdml:7:") && error.contains("'a' is not defined"), "{error}");
    let placed = "<physvol><file name=\"module.gdml\"/></physvol>";
    write("main.gdml", &module.replace(placed, &placed.repeat(3)));
    write("module.gdml", "<gdml>");
    let error = load(folder.path().join("main.gdml")).expect_err("a broken module").to_string();
    assert_eq!(error.matches("this module cannot be read: module.gdml:1:").count(), 1, "{error}");
    write("main.gdml", &module);
    write("module.gdml", &module);
    let error = load(folder.path().join("main.gdml")).expect_err("a cycle").to_string();
    assert!(error.contains("'module.gdml' includes itself"), "{error}");
    write("main.gdml", &main.replace("parts/solids.xml", "/etc/passwd"));
    let error = load(folder.path().join("main.gdml")).expect_err("an absolute path").to_string();
    assert!(error.contains("the path of this file is absolute") && error.contains("main.gdml:2:"), "{error}");
}

/// What is not supported is named with a count; the rest is read on request.
#[test]
fn unsupported_parts_are_left_out_on_request() {
    let text = with_solid("<frustum name=\"x\"/><frustum name=\"y\"/>")
        .replace(
            "<volume name=\"world\">",
            "<volume name=\"v\"><solidref ref=\"y\"/></volume><volume name=\"world\">",
        )
        .replace("ref=\"b\"/></volume>", "ref=\"b\"/><physvol><volumeref ref=\"v\"/></physvol></volume>");
    let options = ReadOptions { partial: true, ..ReadOptions::default() };
    let document = load_bytes(Path::new("part.gdml"), text.clone().into_bytes(), options).expect("the rest");
    assert_eq!(document.notes.len(), 1);
    assert_eq!(document.notes[0].to_string(), "part.gdml: 2 of <frustum> left out, the first on line 7");
    let refused = message(&text);
    assert!(refused.contains("2 of <frustum> are not supported; the first stands here"), "{refused}");
    assert!(refused.contains("--partial"), "{refused}");
}

#[test]
fn open_tessellated_solids_are_left_out_on_request() {
    let corner = |name: &str, x: u32, y: u32, z: u32| {
        format!("<position name=\"{name}\" x=\"{x}\" y=\"{y}\" z=\"{z}\"/>")
    };
    let corners = [corner("p", 0, 0, 0), corner("q", 1, 0, 0), corner("r", 0, 1, 0), corner("s", 0, 0, 1)];
    let solid = "<tessellated name=\"t\"><triangular vertex1=\"p\" vertex2=\"q\" vertex3=\"r\"/>\
        <triangular vertex1=\"p\" vertex2=\"q\" vertex3=\"s\"/></tessellated><box name=\"b\" x=\"9\" y=\"9\" z=\"9\"/>";
    let volumes = "<volume name=\"v\"><solidref ref=\"t\"/></volume>\
        <volume name=\"world\"><solidref ref=\"b\"/><physvol><volumeref ref=\"v\"/></physvol></volume>";
    let text = file(&corners.concat(), AL, solid, volumes, SETUP);
    let options = ReadOptions { partial: true, ..ReadOptions::default() };
    let document = load_bytes(Path::new("part.gdml"), text.into_bytes(), options).expect("the rest");
    let note = document.notes.last().map(|note| note.to_string()).unwrap_or_default();
    assert!(note.contains("1 of tessellated solids that are not closed left out"), "{note}");
    let world = compile(&document.scene, Default::default()).expect("a world");
    let mut segments = Vec::new();
    let ray = Ray::new(Vec3::new(-9.0, 0.1, 0.1), Vec3::X).expect("a ray");
    let met = Caster::new(&world).segments(&ray, Span::FORWARD, Overlaps::Priority, &mut segments);
    assert_eq!((met, segments.len()), (Ok(0), 1));
}

#[test]
fn a_setup_is_chosen_by_its_name() {
    let solids = "<box name=\"b\" x=\"9\" y=\"9\" z=\"9\"/>";
    let volumes = "<volume name=\"hall\"><solidref ref=\"b\"/></volume><volume name=\"tank\"><solidref ref=\"b\"/></volume>";
    let setups = "<setup name=\"Full\"><world ref=\"hall\"/></setup><setup name=\"Part\"><world ref=\"tank\"/></setup>";
    let text = file("", AL, solids, volumes, setups);
    let load = |setup: Option<&str>| {
        let options = ReadOptions { setup: setup.map(str::to_owned), ..ReadOptions::default() };
        load_bytes(Path::new("part.gdml"), text.clone().into_bytes(), options)
    };
    let world = |setup: Option<&str>| {
        let document = load(setup).expect("a file");
        let world = compile(&document.scene, Default::default()).expect("a world");
        (world.path_name(0), document.notes.len())
    };
    assert_eq!(world(None), ("hall".into(), 1));
    assert_eq!(world(Some("Part")), ("tank".into(), 0));
    let refused = load(Some("part")).expect_err("no such setup").to_string();
    assert!(
        refused.contains("there is no setup 'part'") && refused.contains("did you mean 'Part'?"),
        "{refused}"
    );
    let scene = br#"{"shotline": 1, "units": "mm", "objects": []}"#.to_vec();
    let options = ReadOptions { setup: Some("Full".into()), ..ReadOptions::default() };
    let refused = load_bytes(Path::new("a.json"), scene, options).expect_err("no setups").to_string();
    assert!(refused.contains("a scene file has no setups"), "{refused}");
}
