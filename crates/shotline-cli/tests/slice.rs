//! `shotline slice`.

mod sandbox;

use std::fs::{self, File};
use std::io::Read;

use sandbox::{DRILLED, Sandbox, cube_ply};

const SCENE: &str = r#"{ "shotline": 1, "units": "cm", "materials": { "steel": {"color": [0.5, 0.5, 0.6]} },
  "objects": [
    { "name": "left", "material": "steel", "node": { "kind": "box", "min": [-2, -1, -1], "max": [0.75, 1, 1] } },
    { "name": "right", "node": { "kind": "box", "min": [0, -1, -1], "max": [2, 1, 1] } } ] }
"#;

/// The description and the data of an array of an .npz file.
fn array(path: &std::path::Path, name: &str) -> (String, Vec<u8>) {
    let mut zip = zip::ZipArchive::new(File::open(path).unwrap()).unwrap();
    let mut bytes = Vec::new();
    zip.by_name(&format!("{name}.npy")).unwrap().read_to_end(&mut bytes).unwrap();
    let start = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    (String::from_utf8(bytes[10..start].to_vec()).unwrap(), bytes[start..].to_vec())
}

fn i32s(bytes: &[u8]) -> Vec<i32> {
    bytes.chunks(4).map(|b| i32::from_le_bytes(b.try_into().unwrap())).collect()
}

#[test]
fn a_slice_is_written_as_jpeg_too() {
    let sandbox = Sandbox::new().with("scene.json", SCENE);
    sandbox.run(&["slice", "scene.json", "-o", "out.jpg", "--size", "60x40", "-q"]).ok();
    let jpeg = fs::read(sandbox.path("out.jpg")).unwrap();
    assert!(jpeg.starts_with(b"\xff\xd8\xff") && jpeg.ends_with(b"\xff\xd9"));
}

#[test]
fn arrays_have_the_owners_and_the_names() {
    let sandbox = Sandbox::new().with("scene.json", SCENE);
    let args = ["slice", "scene.json", "-o", "out.npz", "--area", "-4,-2,4,2", "--size", "8x4"];
    let result = sandbox.run(&args);
    assert!(
        result.stderr.contains("note: 'left' and 'right' overlap on 2 pixels, as at ("),
        "{}",
        result.stderr
    );
    result.ok();
    let path = sandbox.path("out.npz");
    let (head, data) = array(&path, "object");
    assert!(head.contains("'<i4'") && head.contains("(4, 8"), "{head}");
    let row = [-1, -1, 0, 0, 1, 1, -1, -1];
    assert_eq!(i32s(&data), [&[-1; 8], &row[..], &row[..], &[-1; 8]].concat());
    assert_eq!(i32s(&array(&path, "material").1)[8..16], [-1, -1, 0, 0, -1, -1, -1, -1]);
    assert_eq!(i32s(&array(&path, "overlap").1)[8..16], [-1, -1, -1, -1, 0, -1, -1, -1]);
    assert!(array(&path, "path").0.contains("'<i8'"));
    let texts =
        |name| String::from_utf8(array(&path, name).1.into_iter().filter(|b| *b != 0).collect()).unwrap();
    assert_eq!(
        ["object_names", "material_names", "path_names"].map(texts),
        ["leftright", "steel", "leftright"]
    );
    let area: Vec<f64> =
        array(&path, "area").1.chunks(8).map(|b| f64::from_le_bytes(b.try_into().unwrap())).collect();
    assert_eq!(area, [-4.0, -2.0, 4.0, 2.0]);
    for name in ["origin", "u", "v", "overlap_first", "overlap_second", "overlap_kind"] {
        array(&path, name);
    }
}

#[test]
fn every_format_and_colouring_is_written() {
    let sandbox = Sandbox::new().with("scene.json", SCENE).with("cube.ply", cube_ply(12));
    for model in ["scene.json", "cube.ply"] {
        for by in ["object", "material", "instance"] {
            let run = |output: &str| {
                let args =
                    ["slice", model, "-o", output, "--plane", "1,2,1,0.5", "--by", by, "--size", "60x40"];
                sandbox.run(&[&args[..], &["--overlaps", "-q"]].concat()).ok()
            };
            assert_eq!((run("out.png"), run("out.svg")), (String::new(), String::new()));
            assert!(fs::read(sandbox.path("out.png")).unwrap().starts_with(b"\x89PNG"));
            let svg = fs::read_to_string(sandbox.path("out.svg")).unwrap();
            assert!(
                svg.starts_with("<svg") && svg.ends_with("</svg>\n") && svg.contains(&format!("by {by}"))
            );
        }
    }
}

#[test]
fn overlaps_are_named_and_marked() {
    let sandbox = Sandbox::new().with("scene.json", SCENE);
    let args = ["slice", "scene.json", "-o", "out.svg", "--size", "80x40"];
    sandbox.run(&args).ok();
    assert!(!fs::read_to_string(sandbox.path("out.svg")).unwrap().contains("overlap"));
    let marked = sandbox.run(&[&args[..], &["--overlaps"]].concat());
    assert!(marked.stderr.contains("'left' and 'right' overlap"), "{}", marked.stderr);
    let svg = fs::read_to_string(sandbox.path("out.svg")).unwrap();
    assert!(svg.contains(">'left' and 'right' overlap</text>"), "{svg}");
}

#[test]
fn a_plane_that_meets_nothing_is_noted() {
    let sandbox = Sandbox::new().with("drilled.json", DRILLED);
    let result =
        sandbox.run(&["slice", "drilled.json", "-o", "out.png", "--plane", "z=50", "--size", "30x20"]);
    assert!(
        result.stderr.contains("note: there is nothing in this area of the plane z = 50"),
        "{}",
        result.stderr
    );
    result.ok();
    assert!(sandbox.path("out.png").exists());
}

#[test]
fn invalid_options_are_errors() {
    let sandbox = Sandbox::new().with("drilled.json", DRILLED).with("open.ply", cube_ply(10));
    let run = |rest: &[&str]| sandbox.run(&[&["slice", "drilled.json", "-o", "out.png"], rest].concat());
    run(&["--plane", "w=1"]).fails_with(&["w=1", "expected a plane: x=1", "N.p = D"]);
    run(&["--plane", "0,0,0,1"]).fails_with(&["normal of the plane"]);
    run(&["--area", "1,2,3"]).fails_with(&["U0,V0,U1,V1"]);
    run(&["--area", "1,2,0,3"]).fails_with(&["U0 < U1"]);
    run(&["--size", "0x4"]).fails_with(&["error: --size: a slice of 0x4 pixels"]);
    run(&["--by", "colour"]).fails_with(&["colour", "object, material, instance"]);
    sandbox
        .run(&["slice", "drilled.json", "-o", "out.gif"])
        .fails_with(&["out.gif", ".png or .jpg or .jpeg or .svg or .npz"]);
    sandbox
        .run(&["slice", "drilled.json", "-o", "out"])
        .fails_with(&["use the extension .png, .jpg, .svg or .npz"]);
    sandbox
        .run(&["slice", "open.ply", "-o", "out.png", "--plane", "z=0.5"])
        .fails_with(&["open.ply", "open edges"]);
    let ground = r#"{"shotline": 1, "objects": [{"name": "g", "node": {"kind": "halfspace", "normal": [0, 0, 1], "offset": 0}}]}"#;
    let sandbox = sandbox.with("ground.json", ground);
    sandbox.run(&["slice", "ground.json", "-o", "out.png", "--plane", "x=0"]).fails_with(&["U0,V0,U1,V1"]);
    assert!(!sandbox.path("out.png").exists());
}

#[test]
fn an_object_around_all_others_does_not_make_them_small() {
    let hall = r#"{"shotline": 1, "objects": [{"name": "hall", "node": {"kind": "box", "min": [-500, -500, -500], "max": [500, 500, 500]}, "clip": true,
        "contents": [{"name": "ball", "node": {"kind": "sphere", "radius": 5}}]}]}"#;
    let sandbox = Sandbox::new().with("hall.json", hall);
    let run = |rest: &[&str]| {
        let output = sandbox.run(&[&["slice", "hall.json", "-o", "out.npz", "--size", "8x8"], rest].concat());
        let area = array(&sandbox.path("out.npz"), "area").1;
        (output, area.chunks(8).map(|b| f64::from_le_bytes(b.try_into().unwrap())).collect::<Vec<_>>())
    };
    let (output, area) = run(&[]);
    assert!(output.stderr.contains("the area is that of what 'hall' encloses"), "{}", output.stderr);
    assert!(area[2] > 5.0 && area[2] < 6.0 && area[0] == -area[2], "{area:?}");
    let (output, area) = run(&["--area", "-500,-500,500,500"]);
    assert!(!output.stderr.contains("hall"), "{}", output.stderr);
    assert_eq!(area, [-500.0, -500.0, 500.0, 500.0]);
}
