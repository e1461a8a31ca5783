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
