//! `shotline render`.

mod sandbox;

use std::fs;

use sandbox::{DRILLED, Sandbox, cube_ply};

#[test]
fn the_same_picture_for_every_accelerator_and_number_of_threads() {
    let sandbox = Sandbox::new().with("drilled.json", DRILLED);
    let mut first: Option<Vec<u8>> = None;
    for accel in shotline::accel::NAMES {
        for threads in ["1", "2"] {
            let args = ["render", "drilled.json", "-o", "out.png", "--size", "40x30", "--accel", accel];
            sandbox.run(&[&args[..], &["--threads", threads]].concat()).ok();
            let bytes = fs::read(sandbox.path("out.png")).unwrap();
            assert!(bytes.starts_with(b"\x89PNG"));
            assert!(first.get_or_insert_with(|| bytes.clone()) == &bytes, "{accel} with {threads} threads");
        }
    }
}

#[test]
fn every_look_renders_a_picture() {
    let sandbox = Sandbox::new().with("drilled.json", DRILLED).with("cube.ply", cube_ply(12));
    for look in shotline_render::LOOKS {
        for (model, background) in [("drilled.json", "transparent"), ("cube.ply", "#336699")] {
            let args = ["render", model, "-o", "out.png", "--size", "16x12", "--samples", "1"];
            let result =
                sandbox.run(&[&args[..], &["--look", look.name, "--background", background]].concat());
            assert_eq!((result.ok().as_str(), sandbox.path("out.png").exists()), ("", true));
            fs::remove_file(sandbox.path("out.png")).unwrap();
        }
    }
}

#[test]
fn invalid_options_are_errors() {
    let sandbox = Sandbox::new().with("drilled.json", DRILLED).with("open.ply", cube_ply(10));
    let render = |rest: &[&str]| sandbox.run(&[&["render", "drilled.json", "-o", "out.png"], rest].concat());
    render(&["--size", "0x10"]).fails_with(&["error: --size: a picture of 0x10 pixels"]);
    render(&["--size", "10"]).fails_with(&["--size", "800x600"]);
    render(&["--samples", "0"]).fails_with(&["error: --samples: 0 samples per pixel"]);
    render(&["--samples", "-1"]).fails_with(&["--samples", "expected a whole number, 0 or more"]);
    render(&["--look", "loud"]).fails_with(&["loud", "lit", "thickness"]);
    render(&["--background", "#12"]).fails_with(&["--background", "#336699"]);
    let thickness = ["render", "open.ply", "-o", "out.png", "--look", "thickness", "--size", "8x8"];
    sandbox.run(&thickness).fails_with(&["open.ply", "thickness", "open edges"]);
    assert!(!sandbox.path("out.png").exists());
}

#[test]
fn pictures_are_seen_from_elsewhere() {
    let sandbox = Sandbox::new().with("drilled.json", DRILLED);
    let render = |rest: &[&str]| {
        let size = ["render", "drilled.json", "-o", "out.png", "--size", "40x30", "--samples", "1"];
        sandbox.run(&[&size[..], rest].concat())
    };
    let picture = |rest: &[&str]| {
        render(rest).ok();
        fs::read(sandbox.path("out.png")).unwrap()
    };
    let mut seen = vec![picture(&[])];
    for rest in [
        &["--view", "front"][..],
        &["--view", "top"],
        &["--view", "iso", "--fov", "20"],
        &["--eye", "9,-8,7"],
        &["--eye", "9,-8,7", "--target=-1,0,0.5", "--up", "1,0,1"],
        &["--zoom", "2"],
        &["--fov", "60"],
    ] {
        let now = picture(rest);
        assert!(!seen.contains(&now), "{rest:?}");
        seen.push(now);
    }
    assert_eq!(picture(&["--zoom", "1"]), seen[0]);
    render(&["--view", "side"]).fails_with(&["--view", "side", "front, back, left, right, top, bottom, iso"]);
    render(&["--view", "top", "--eye", "1,2,3"]).fails_with(&["--view", "--eye", "cannot be used with"]);
    render(&["--zoom", "0"]).fails_with(&["error: --zoom: the zoom is 0, but must be positive"]);
    for zoom in ["1e-308", "1e-20"] {
        let message =
            format!("error: --zoom: a zoom of {zoom} leaves the camera an angle of view of 0 or of 180");
        render(&["--zoom", zoom]).fails_with(&[&message]);
    }
    render(&["--fov", "190"]).fails_with(&["`fov` is 190 degrees"]);
    render(&["--eye", "1,2"]).fails_with(&["--eye", "three numbers"]);
    render(&["--eye", "1,2,3", "--target", "1,2,3"]).fails_with(&["`eye` and `target` are the same point"]);
}

#[test]
fn edges_are_for_looks_that_show_surfaces() {
    let sandbox = Sandbox::new().with("drilled.json", DRILLED);
    let with_edges = picture(&sandbox, "drilled.json", &["--edges"]);
    assert!(with_edges != picture(&sandbox, "drilled.json", &[]));
    assert!(
        with_edges == picture(&sandbox, "drilled.json", &["--edges", "--threads", "1", "--accel", "brute"])
    );
    let args = ["render", "drilled.json", "-o", "other.png", "--edges", "--look", "thickness"];
    sandbox.run(&args).fails_with(&["error: --edges: the look 'thickness' has no edges", "'lit', 'normal'"]);
    assert!(!sandbox.path("other.png").exists());
}

#[test]
fn cuts_are_hatched() {
    let sandbox = Sandbox::new().with("nest.json", NEST);
    let flat = picture(&sandbox, "nest.json", &["--clip=0,-1,0,0"]);
    assert!(picture(&sandbox, "nest.json", &["--clip=0,-1,0,0", "--hatch"]) != flat);
    let render =
        |rest: &[&str]| sandbox.run(&[&["render", "nest.json", "-o", "out.png", "-q"], rest].concat());
    render(&["--hatch"]).fails_with(&["--clip"]);
    let depth = ["--hatch", "--clip", "x=0", "--look", "depth"];
    render(&depth).fails_with(&["error: --hatch: the look 'depth' hatches no cuts; choose 'lit'"]);
}

#[test]
fn objects_are_seen_through() {
    let sandbox = Sandbox::new().with("nest.json", NEST);
    let opaque = picture(&sandbox, "nest.json", &[]);
    let through = picture(&sandbox, "nest.json", &["--opacity", "out*=0.3"]);
    assert!(through != opaque && picture(&sandbox, "nest.json", &["--opacity", "*=1"]) == opaque);
    for rest in [["--accel", "brute"], ["--threads", "1"]] {
        assert!(
            picture(&sandbox, "nest.json", &[&["--opacity", "outer=0.3"], &rest[..]].concat()) == through
        );
    }
    let render =
        |rest: &[&str]| sandbox.run(&[&["render", "nest.json", "-o", "out.png", "-q"], rest].concat());
    for wrong in ["outer", "=0.3", "outer=x"] {
        render(&["--opacity", wrong]).fails_with(&["--opacity", wrong, "as in wall=0.3"]);
    }
    render(&["--opacity", "outer=2"]).fails_with(&["error: --opacity: the opacity of 'outer' is 2"]);
    render(&["--opacity", "ghost=0.2"]).fails_with(&["error: --opacity: no object is named 'ghost'", "info"]);
    render(&["--opacity", "outer=0.2", "--look", "xray"])
        .fails_with(&["--opacity: the look 'xray'", "'lit'"]);
}

#[test]
fn the_suffix_says_what_is_written() {
    let sandbox = Sandbox::new().with("drilled.json", DRILLED);
    let render = |file: &str, rest: &[&str]| {
        let args = ["render", "drilled.json", "-o", file, "--size", "40x30", "--samples", "1"];
        sandbox.run(&[&args[..], rest].concat())
    };
    for file in ["out.jpg", "out.JPEG"] {
        render(file, &[]).ok();
        let jpeg = fs::read(sandbox.path(file)).unwrap();
        assert!(jpeg.starts_with(b"\xff\xd8\xff") && jpeg.ends_with(b"\xff\xd9"));
    }
    render("out.gif", &[]).fails_with(&["out.gif", ".png or .apng or .jpg or .jpeg, not .gif"]);
    render("no.jpg", &["--frames", "3"]).fails_with(&["no.jpg: cannot be written", "no frames", ".png"]);
    render("no.jpg", &["--background", "transparent"]).fails_with(&["no.jpg", "transparent", ".png"]);
    assert!(!sandbox.path("no.jpg").exists());
}

/// The number of frames that an animated PNG announces, and the number that it contains.
fn frames(png: &[u8]) -> (u32, usize) {
    let chunk = |name: &[u8]| png.windows(4).position(|w| w == name);
    let at = chunk(b"acTL").expect("an animation") + 4;
    let announced = u32::from_be_bytes(png[at..at + 4].try_into().unwrap());
    (announced, png.windows(4).filter(|w| w == b"fcTL").count())
}

#[test]
fn coherence_does_not_change_frames() {
    let moving = DRILLED.trim_end().trim_end_matches('}').to_string()
        + r#", "motions": [{ "object": "slab", "rotate": [0, 0, 90], "translate": [0.5, 0, 0] }] }"#;
    let sandbox = Sandbox::new().with("moving.json", &moving);
    let movie = |rest: &[&str]| {
        let args = ["render", "moving.json", "-o", "out.png", "--size", "40x30", "--frames", "4"];
        sandbox.run(&[&args[..], rest].concat()).ok();
        fs::read(sandbox.path("out.png")).unwrap()
    };
    let first = movie(&[]);
    assert_eq!(frames(&first), (4, 4));
    for rest in [
        ["--coherence", "none"],
        ["--coherence", "neighbours,frames"],
        ["--accel", "octree"],
        ["--threads", "1"],
    ] {
        assert!(movie(&rest) == first, "{rest:?}");
    }
    assert!(movie(&["--orbit", "-30"]) != first);
    for orbit in ["nan", "inf"] {
        let command = ["render", "moving.json", "-o", "out.png", "--frames", "2", "--orbit", orbit];
        sandbox.run(&command).fails_with(&["--orbit", "is not finite"]);
    }
    sandbox.run(&["render", "moving.json", "-o", "out.png", "--orbit", "9"]).fails_with(&["--frames"]);
    sandbox.run(&["render", "moving.json", "-o", "out.png", "--frames", "0"]).fails_with(&["--frames"]);
}

#[test]
fn a_motion_of_an_unknown_object_is_an_error() {
    let moving = DRILLED.trim_end().trim_end_matches('}').to_string()
        + r#", "motions": [{ "object": "slap", "translate": [1, 0, 0] }] }"#;
    let sandbox = Sandbox::new().with("moving.json", &moving);
    let result = sandbox.run(&["render", "moving.json", "-o", "out.png", "--frames", "2"]);
    result.fails_with(&["no object named 'slap'", "did you mean 'slab'?"]);
}

/// A box of which a flush part is in front, as a nest and as a combination.
const NEST: &str = r#"{ "shotline": 1, "camera": { "eye": [3, -9, 4], "target": [0, 0, 0], "fov": 30 }, "objects": [
  { "name": "World", "clip": true, "node": { "kind": "box", "min": [-9, -9, -9], "max": [9, 9, 9] }, "contents": [
    { "name": "outer", "node": { "kind": "box", "min": [-2, -1, -2], "max": [2, 1, 2] }, "contents": [
      { "name": "inner", "node": { "kind": "box", "min": [-1, -1, -1], "max": [1, 0, 1] } } ] } ] } ] }"#;
const COMBINATION: &str = r#"{ "shotline": 1, "camera": { "eye": [3, -9, 4], "target": [0, 0, 0], "fov": 30 }, "objects": [
  { "name": "outer", "node": { "op": "difference", "args": [
    { "kind": "box", "min": [-2, -1, -2], "max": [2, 1, 2] }, { "kind": "box", "min": [-1, -1, -1], "max": [1, 0, 1] } ] } } ] }"#;

/// The bytes of a small picture.
fn picture(sandbox: &Sandbox, scene: &str, rest: &[&str]) -> Vec<u8> {
    let args = ["render", scene, "-o", "out.png", "--size", "40x30", "--samples", "2"];
    sandbox.run(&[&args[..], rest].concat()).ok();
    fs::read(sandbox.path("out.png")).unwrap()
}

#[test]
fn hidden_contents_leave_a_hole() {
    let sandbox = Sandbox::new().with("nest.json", NEST).with("combination.json", COMBINATION);
    for look in ["normal", "depth", "thickness"] {
        let hole = picture(&sandbox, "combination.json", &["--look", look]);
        let hide = ["--look", look, "--hide", "World", "--hide", "inner"];
        assert!(picture(&sandbox, "nest.json", &hide) == hole, "{look}");
        assert!(picture(&sandbox, "nest.json", &["--look", look]) != hole, "{look}");
        let cut = ["--clip", "x=0.25", "--clip=0,0,-2,1"];
        assert!(
            picture(&sandbox, "nest.json", &[&hide[..], &cut].concat())
                == picture(&sandbox, "combination.json", &[&["--look", look], &cut[..]].concat()),
            "{look}"
        );
    }
}

#[test]
fn a_cut_is_the_same_for_every_accelerator_and_number_of_threads() {
    let sandbox = Sandbox::new().with("nest.json", NEST).with("drilled.json", DRILLED);
    for scene in ["nest.json", "drilled.json"] {
        let cut = ["--clip", "y=0.5", "--clip", "0,0,1,1e-3"];
        let first = picture(&sandbox, scene, &cut);
        assert!(first != picture(&sandbox, scene, &[]));
        for rest in [["--accel", "octree"], ["--accel", "brute"], ["--threads", "1"]] {
            assert!(picture(&sandbox, scene, &[&cut[..], &rest].concat()) == first, "{scene} {rest:?}");
        }
    }
}

#[test]
fn planes_that_are_none_are_errors() {
    let sandbox = Sandbox::new().with("drilled.json", DRILLED);
    for (plane, why) in [
        ("w=1", "x=1, y=-2, z=0"),
        ("x=", "NX,NY,NZ,D"),
        ("1,2,3", "four numbers"),
        ("0,0,0,1", "the normal of the plane"),
        ("z=nan", "NaN or infinite"),
    ] {
        let result = sandbox.run(&["render", "drilled.json", "-o", "out.png", "--clip", plane]);
        result.fails_with(&["--clip", plane, why]);
    }
    // A plane that removes all leaves the background.
    sandbox.run(&["render", "drilled.json", "-o", "out.png", "--size", "8x8", "--clip", "x=-99"]).ok();
}
