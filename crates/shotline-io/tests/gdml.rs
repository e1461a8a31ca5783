//! GDML files: what they mean, as Geant4 reads them.

use std::path::Path;

use shotline::compile::compile;
use shotline::math::Vec3;
use shotline::query::{Caster, Overlaps};
use shotline::ray::{Ray, Span};
use shotline_io::{Document, ReadOptions, load, load_bytes};

/// A file whose world is a box of 100 mm with these contents.
fn file(define: &str, solids: &str, volumes: &str, contents: &str) -> String {
    format!(
        "<gdml><define>{define}</define><materials><material name=\"Al\" Z=\"13\"><D value=\"2.7\"/></material></materials>\
         <solids><box name=\"hall\" x=\"100\" y=\"100\" z=\"100\"/>{solids}</solids>\
         <structure>{volumes}<volume name=\"world\"><materialref ref=\"Al\"/><solidref ref=\"hall\"/>{contents}</volume>\
         </structure><setup name=\"Default\" version=\"1.0\"><world ref=\"world\"/></setup></gdml>"
    )
}

fn read(text: &str) -> Document {
    let read = load_bytes(Path::new("part.gdml"), text.as_bytes().to_vec(), ReadOptions::default());
    read.unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// The names of the paths that own some points.
fn owners(text: &str, points: &[[f64; 3]]) -> Vec<String> {
    let document = read(text);
    let world = compile(&document.scene, Default::default());
    let world = world.unwrap_or_else(|errors| panic!("{}", document.diagnostics(&errors)));
    let mut caster = Caster::new(&world);
    let mut owner = |p: &[f64; 3]| caster.owner_at(Vec3::from(*p)).expect("solids");
    points.iter().map(|p| owner(p).map_or("-".into(), |(_, path)| world.path_name(path))).collect()
}

/// A volume `v` of a box that reaches from the origin to 10, 2 and 2 mm.
const ARM: (&str, &str) = (
    "<box name=\"b\" x=\"10\" y=\"2\" z=\"2\"/><multiUnion name=\"arm\"><multiUnionNode name=\"n\"><solid ref=\"b\"/>\
     <position x=\"5\" y=\"1\" z=\"1\"/></multiUnionNode></multiUnion>",
    "<volume name=\"v\"><materialref ref=\"Al\"/><solidref ref=\"arm\"/></volume>",
);

fn placed(placement: &str) -> String {
    file("<variable name=\"i\" value=\"0\"/>", ARM.0, ARM.1, placement)
}

#[test]
fn the_rotation_of_a_volume_turns_its_mothers_frame() {
    let physvol = |what: &str| placed(&format!("<physvol name=\"a\">{what}<volumeref ref=\"v\"/></physvol>"));
    // A quarter turn about z takes the arm to -y, and one of an operand takes it to +y.
    let turned = physvol("<rotation z=\"90\" unit=\"deg\"/>");
    assert_eq!(owners(&turned, &[[1.0, -9.0, 1.0], [1.0, 9.0, 1.0]]), ["world/a", "world"]);
    // The inverse of turns about x and then z: about -z, which takes the arm to -y, and then about -x, which takes it to +z.
    let turned = physvol("<rotation x=\"90\" z=\"90\" unit=\"deg\"/><position x=\"3\"/>");
    let points = [[4.0, 1.0, 9.0], [4.0, -1.0, -9.0], [4.0, 1.0, -9.0], [4.0, -1.0, 9.0]];
    assert_eq!(owners(&turned, &points), ["world/a", "world", "world", "world"]);
    let operand = file(
        "",
        &format!(
            "{}<box name=\"dot\" x=\"1\" y=\"1\" z=\"1\"/><union name=\"u\"><first ref=\"dot\"/><second ref=\"arm\"/>\
             <rotation z=\"90\" unit=\"deg\"/></union>",
            ARM.0
        ),
        "<volume name=\"w\"><solidref ref=\"u\"/></volume>",
        "<physvol><volumeref ref=\"w\"/></physvol>",
    );
    assert_eq!(owners(&operand, &[[-1.0, 9.0, 1.0], [1.0, -9.0, 1.0]]), ["world/w_PV", "world"]);
    let mirrored = physvol("<scale x=\"-1\"/>");
    assert_eq!(owners(&mirrored, &[[-9.0, 1.0, 1.0], [9.0, 1.0, 1.0]]), ["world/a", "world"]);
}

#[test]
fn placements_are_named_as_in_the_file() {
    let text = placed(
        "<physvol><volumeref ref=\"v\"/></physvol>\
         <physvol name=\"b\" copynumber=\"4\"><volumeref ref=\"v\"/><position y=\"5\"/></physvol>\
         <loop for=\"i\" from=\"1\" to=\"3\" step=\"2\"><physvol name=\"c[i]\" copynumber=\"i\"><volumeref ref=\"v\"/>\
         <position z=\"5*i\"/></physvol></loop>",
    );
    let points = [[1.0; 3], [1.0, 6.0, 1.0], [1.0, 1.0, 6.0], [1.0, 1.0, 16.0], [1.0, 1.0, 11.0], [99.0; 3]];
    let expected = ["world/v_PV", "world/b[4]", "world/c_0[1]", "world/c_2[3]", "world", "-"];
    assert_eq!(owners(&text, &points), expected);
}

#[test]
fn replicas_and_divisions_fill_their_mother() {
    let along = |direction: &str, width: &str| {
        let volume = format!(
            "<volume name=\"s\"><solidref ref=\"slice\"/></volume><volume name=\"m\"><solidref ref=\"tube\"/>\
             <replicavol number=\"4\"><volumeref ref=\"s\"/><replicate_along_axis><direction {direction}=\"1\"/>\
             <width value=\"{width}\" unit=\"{}\"/><offset value=\"0\" unit=\"{}\"/></replicate_along_axis></replicavol></volume>",
            if direction == "phi" { "deg" } else { "mm" },
            if direction == "phi" { "deg" } else { "mm" },
        );
        let slice = match direction {
            "phi" => "rmax=\"8\" z=\"8\" startphi=\"-45\" deltaphi=\"90\"",
            "z" => "rmax=\"8\" z=\"2\" deltaphi=\"360\"",
            _ => "rmax=\"2\" z=\"8\" deltaphi=\"360\"",
        };
        let solids = format!(
            "<tube name=\"tube\" rmax=\"8\" z=\"8\" deltaphi=\"360\" aunit=\"deg\"/><tube name=\"slice\" {slice} aunit=\"deg\"/>"
        );
        file("", &solids, &volume, "<physvol><volumeref ref=\"m\"/></physvol>")
    };
    let path = |i: usize| format!("world/m_PV/s_PV[{i}]");
    let z = owners(&along("z", "2"), &[[1.0, 0.0, -3.0], [1.0, 0.0, -1.0], [1.0, 0.0, 3.0]]);
    assert_eq!(z, [path(0), path(1), path(3)]);
    let phi = owners(
        &along("phi", "90"),
        &[[3.0, 2.0, 0.0], [-3.0, 2.0, 0.0], [-3.0, -2.0, 0.0], [3.0, -2.0, 0.0]],
    );
    assert_eq!(phi, [path(0), path(1), path(2), path(3)]);
    let rho = owners(&along("rho", "2"), &[[1.0, 0.0, 3.0], [0.0, 3.0, 0.0], [-7.0, 0.0, 0.0]]);
    assert_eq!(rho, [path(0), path(1), path(3)]);

    let division = |axis: &str, rest: &str| {
        let volume = format!(
            "<volume name=\"s\"><solidref ref=\"hall\"/></volume><volume name=\"m\"><solidref ref=\"hall\"/>\
             <divisionvol axis=\"{axis}\" {rest} unit=\"mm\"><volumeref ref=\"s\"/></divisionvol></volume>"
        );
        file("", "", &volume, "<physvol><volumeref ref=\"m\"/></physvol>")
    };
    let x = owners(
        &division("kXAxis", "width=\"20\" offset=\"10\""),
        &[[-45.0, 0.0, 0.0], [-39.0, 1.0, 1.0], [30.0, 1.0, 1.0], [49.0, 0.0, 0.0]],
    );
    assert_eq!(x, ["world/m_PV".to_owned(), path(0), path(3), "world/m_PV".into()]);
    let y = owners(&division("kYAxis", "number=\"5\""), &[[1.0, -49.0, 0.0], [1.0, 49.0, 0.0]]);
    assert_eq!(y, [path(0), path(4)]);
}

/// Replicas of replicas of replicas: a billion voxels, of which none is stored.
#[test]
fn many_replicas_are_not_stored() {
    let replicas = |of: &str, direction: &str| {
        format!(
            "<replicavol number=\"1000\"><volumeref ref=\"{of}\"/><replicate_along_axis><direction {direction}=\"1\"/>\
             <width value=\"0.1\" unit=\"mm\"/><offset value=\"0\" unit=\"mm\"/></replicate_along_axis></replicavol>"
        )
    };
    let volume = |name: &str, contents: &str| {
        format!("<volume name=\"{name}\"><solidref ref=\"{name}_box\"/>{contents}</volume>")
    };
    let solids = [("voxel", 0.1, 0.1), ("row", 100.0, 0.1), ("layer", 100.0, 100.0)];
    let solids =
        solids.map(|(name, x, y)| format!("<box name=\"{name}_box\" x=\"{x}\" y=\"{y}\" z=\"0.1\"/>"));
    let volumes = volume("voxel", "")
        + &volume("row", &replicas("voxel", "x"))
        + &volume("layer", &replicas("row", "y"));
    let text = file("", &solids.concat(), &volumes, &replicas("layer", "z"));
    let path = |z: usize, y: usize, x: usize| format!("world/layer_PV[{z}]/row_PV[{y}]/voxel_PV[{x}]");
    let found = owners(&text, &[[-49.95, 0.05, 49.95], [0.05, 0.15, 0.25]]);
    assert_eq!(found, [path(999, 500, 0), path(502, 501, 500)]);
    let world = read(&text).scene.compile().expect("a world");
    assert_eq!(world.path_count(), 1_001_001_001);
    assert!(world.stats().memory_bytes < 20_000, "{}", world.stats().memory_bytes);
    let ray = Ray::new(Vec3::new(-60.0, 0.05, 0.05), Vec3::X).expect("a ray");
    let mut segments = Vec::new();
    Caster::new(&world).segments(&ray, Span::FORWARD, Overlaps::Priority, &mut segments).expect("solids");
    assert_eq!(segments.len(), 1000);
    assert!(segments.iter().all(|segment| (segment.length - 0.1).abs() < 1e-12));
    let division =
        "<divisionvol axis=\"kZAxis\" number=\"500\" unit=\"mm\"><volumeref ref=\"s\"/></divisionvol>";
    let volume = "<volume name=\"s\"><solidref ref=\"hall\"/></volume>";
    let found = owners(&file("", "", volume, division), &[[1.0, 1.0, -49.9], [1.0, 1.0, 49.9]]);
    assert_eq!(found, ["world/s_PV[0]", "world/s_PV[499]"]);
}

#[test]
fn parameterised_volumes_have_dimensions_of_their_own() {
    let volume = "<volume name=\"s\"><solidref ref=\"hall\"/></volume>";
    let contents = "<paramvol ncopies=\"2\"><volumeref ref=\"s\"/><parameterised_position_size>\
        <parameters number=\"1\"><position x=\"-20\"/><box_dimensions x=\"4\" y=\"4\" z=\"4\"/></parameters>\
        <parameters number=\"2\"><position x=\"20\"/><tube_dimensions InR=\"1\" OutR=\"3\" hz=\"8\" StartPhi=\"0\" DeltaPhi=\"360\" aunit=\"deg\"/>\
        </parameters></parameterised_position_size></paramvol>";
    let points = [[-18.5, 1.0, 1.0], [-17.5, 1.0, 1.0], [22.0, 0.0, 3.5], [20.0, 0.0, 0.0]];
    let expected = ["world/s_param[0]", "world", "world/s_param[1]", "world"];
    assert_eq!(owners(&file("", "", volume, contents), &points), expected);
}

#[test]
fn definitions_may_be_of_optics_and_have_the_names_of_geant4() {
    let define = "<matrix name=\"RINDEX\" coldim=\"2\" values=\"2.034*eV 1.3435 4.136*eV 1.3608\"/>\
        <matrix name=\"row\" coldim=\"2\" values=\"7 8\"/><constant name=\"e1\" value=\"5*keV*300*kelvin\"/>\
        <expression name=\"side\"> RINDEX_0_1*0 + row_1 <!-- and --> - row[1] </expression>";
    let solids = "<box name=\"dot\" x=\"20*side\" y=\"20\" z=\"20\"/>";
    let volume = "<volume name=\"d\"><solidref ref=\"dot\"/></volume>";
    let text = file(define, solids, volume, "<physvol><volumeref ref=\"d\"/></physvol>");
    assert_eq!(owners(&text, &[[9.0; 3], [11.0, 0.0, 0.0]]), ["world/d_PV", "world"]);
}

#[test]
fn corners_of_facets_that_differ_by_rounding_are_joined() {
    let define = "<position name=\"a\"/><position name=\"b\" x=\"10\"/><position name=\"b2\" x=\"10+1e-12\"/>\
        <position name=\"c\" y=\"10\"/><position name=\"d\" z=\"10\"/>";
    // One facet faces inwards, and one is given relative to its first corner.
    let solids = "<tessellated name=\"t\"><triangular vertex1=\"a\" vertex2=\"c\" vertex3=\"b\"/>\
        <triangular vertex1=\"a\" vertex2=\"d\" vertex3=\"b2\"/><triangular vertex1=\"b\" vertex2=\"c\" vertex3=\"d\"/>\
        <triangular vertex1=\"a\" vertex2=\"d\" vertex3=\"c\" type=\"RELATIVE\"/></tessellated>";
    let volume = "<volume name=\"v\"><solidref ref=\"t\"/></volume>";
    let text = file(define, solids, volume, "<physvol><volumeref ref=\"v\"/></physvol>");
    assert_eq!(owners(&text, &[[1.0; 3], [-1.0, 1.0, 1.0], [9.0; 3]]), ["world/v_PV", "world", "world"]);
    assert!(read(&text).notes.iter().any(|note| note.kind == "facets_turned"));
}

#[test]
fn materials_have_densities_and_elements_by_mass() {
    let materials = "<element name=\"H\" Z=\"1\"><atom value=\"1\"/></element><element name=\"O\" Z=\"8\"><atom value=\"16\"/></element>\
        <material name=\"W0x1f\"><D value=\"1000\" unit=\"kg/m3\"/><composite n=\"2\" ref=\"H\"/><composite n=\"1\" ref=\"O\"/></material>\
        <material name=\"W2\"><D value=\"1\"/><composite n=\"1\" ref=\"G4_C\"/><composite n=\"2\" ref=\"O\"/></material>\
        <material name=\"M\"><D value=\"1290\" unit=\"mg/cm3\"/><fraction n=\"0.25\" ref=\"W0x1f\"/><fraction n=\"0.75\" ref=\"O\"/></material>";
    let text = file(
        "",
        "",
        "<volume name=\"g\"><materialref ref=\"G4_WATER\"/><solidref ref=\"hall\"/></volume>\
         <volume name=\"u\"><materialref ref=\"G4_UNOBTAINIUM\"/><solidref ref=\"hall\"/></volume>",
        "",
    )
    .replace("</materials>", &format!("{materials}</materials>"));
    let document = read(&text);
    let known = |name: &str| &document.scene.materials.iter().find(|(known, _)| known == name).expect(name).1;
    assert_eq!((known("W0x1f").density, known("M").density), (Some(1.0), Some(1.29)));
    let share = |material: &str, element: &str| {
        known(material).composition.iter().find(|(name, _)| name == element).map_or(0.0, |(_, share)| *share)
    };
    assert!((share("W0x1f", "H") - 2.0 / 18.0).abs() < 1e-15);
    assert!((share("M", "H") - 0.25 * 2.0 / 18.0).abs() < 1e-15 && share("M", "O") > 0.97);
    // Those that Geant4 defines itself.
    assert_eq!((known("G4_WATER").density, share("G4_WATER", "O") > 0.888), (Some(1.0), true));
    assert!((share("W2", "C") - 12.011 / (12.011 + 32.0)).abs() < 1e-15);
    let kinds: Vec<_> = document.notes.iter().map(|note| note.kind).collect();
    assert_eq!((kinds, known("G4_UNOBTAINIUM").density), (vec!["unknown_materials"], None));
}

/// Modules and entities are read from the folder of the file.
#[test]
fn parts_may_be_in_other_files() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("a file");
    write(
        "part.gdml",
        &placed("<physvol name=\"inner\"><volumeref ref=\"v\"/></physvol>").replace("\"100\"", "\"30\""),
    );
    write("solids.xml", "<?xml version=\"1.0\"?>\n<box name=\"small\" x=\"2\" y=\"2\" z=\"2\"/>");
    let contents = "<physvol><file name=\"part.gdml\"/><position x=\"-20\"/></physvol>\
        <physvol><file name=\"part.gdml\" volname=\"v\"/><position x=\"20\"/></physvol>\
        <physvol><volumeref ref=\"s\"/><position y=\"40\"/></physvol>";
    let volume = "<volume name=\"s\"><solidref ref=\"small\"/></volume>";
    let text = format!(
        "<!DOCTYPE gdml [<!ENTITY more SYSTEM \"solids.xml\">]>{}",
        file("", "&more;", volume, contents)
    );
    write("main.gdml", &text);
    let document = load(folder.path().join("main.gdml")).unwrap_or_else(|error| panic!("{error}"));
    let mut files: Vec<_> = document.source.files().filter_map(Path::file_name).collect();
    files.sort();
    assert_eq!(files, ["part.gdml", "solids.xml"]);
    let world = compile(&document.scene, Default::default()).expect("a world");
    let mut caster = Caster::new(&world);
    let mut owner = |x: f64, y: f64| {
        let found = caster.owner_at(Vec3::new(x, y, 0.5)).expect("solids");
        found.map_or("-".into(), |(_, path)| world.path_name(path))
    };
    let found = [owner(-30.0, 0.5), owner(-15.0, 0.5), owner(25.0, 0.5), owner(0.5, 40.5), owner(0.5, 20.0)];
    assert_eq!(found, ["world/world_PV", "world/world_PV/inner", "world/v_PV", "world/s_PV", "world"]);
}

/// Everything that is read can be written as a scene, which has the same paths.
#[test]
fn geometries_are_written_as_scenes() {
    let text = placed(
        "<physvol name=\"a\" copynumber=\"2\"><volumeref ref=\"v\"/><rotation x=\"10\" y=\"20\" z=\"30\" unit=\"deg\"/></physvol>",
    );
    let document = read(&text);
    let written = shotline_io::write_scene(&document.scene).expect("a scene");
    let again = shotline_io::parse_scene(written, None).expect("what was written");
    let [first, second] =
        [&document.scene, &again.scene].map(|scene| compile(scene, Default::default()).expect("a world"));
    assert_eq!(first.path_count(), second.path_count());
    for path in 0..first.path_count() {
        assert_eq!(first.path_name(path), second.path_name(path));
    }
    assert_eq!(first.bounds(), second.bounds());
}
