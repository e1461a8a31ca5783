//! `shotline render`.

mod place;

use std::fs;

use place::{DRILLED, Place, cube_ply};

#[test]
fn the_same_picture_for_every_accelerator_and_number_of_threads() {
    let place = Place::new().with("drilled.json", DRILLED);
    let mut first: Option<Vec<u8>> = None;
    for accel in shotline::accel::NAMES {
        for threads in ["1", "2"] {
            let args = ["render", "drilled.json", "-o", "out.png", "--size", "40x30", "--accel", accel];
            place.run(&[&args[..], &["--threads", threads]].concat()).ok();
            let bytes = fs::read(place.path("out.png")).unwrap();
            assert!(bytes.starts_with(b"\x89PNG"));
            assert!(first.get_or_insert_with(|| bytes.clone()) == &bytes, "{accel} with {threads} threads");
        }
    }
}

#[test]
fn every_look_has_a_picture() {
    let place = Place::new().with("drilled.json", DRILLED).with("cube.ply", cube_ply(12));
    for look in shotline_render::LOOKS {
        for (model, background) in [("drilled.json", "transparent"), ("cube.ply", "#336699")] {
            let args = ["render", model, "-o", "out.png", "--size", "16x12", "--samples", "1"];
            let answer = place.run(&[&args[..], &["--look", look.name, "--background", background]].concat());
            assert_eq!((answer.ok().as_str(), place.path("out.png").exists()), ("", true));
            fs::remove_file(place.path("out.png")).unwrap();
        }
    }
}

#[test]
fn bad_wishes_are_refused() {
    let place = Place::new().with("drilled.json", DRILLED).with("open.ply", cube_ply(10));
    let render = |rest: &[&str]| place.run(&[&["render", "drilled.json", "-o", "out.png"], rest].concat());
    render(&["--size", "0x10"]).refused(&["error: --size: a picture of 0x10 pixels"]);
    render(&["--size", "10"]).refused(&["--size", "800x600"]);
    render(&["--samples", "0"]).refused(&["error: --samples: 0 samples a pixel"]);
    render(&["--samples", "-1"]).refused(&["--samples", "expected a whole number, 0 or more"]);
    render(&["--look", "loud"]).refused(&["loud", "lit", "thickness"]);
    render(&["--background", "#12"]).refused(&["--background", "#336699"]);
    let thickness = ["render", "open.ply", "-o", "out.png", "--look", "thickness", "--size", "8x8"];
    place.run(&thickness).refused(&["open.ply", "thickness", "open edges"]);
    assert!(!place.path("out.png").exists());
}

/// The number of frames that an animated PNG announces, and of those that it holds.
fn frames(png: &[u8]) -> (u32, usize) {
    let chunk = |name: &[u8]| png.windows(4).position(|w| w == name);
    let at = chunk(b"acTL").expect("it is animated") + 4;
    let announced = u32::from_be_bytes(png[at..at + 4].try_into().unwrap());
    (announced, png.windows(4).filter(|w| w == b"fcTL").count())
}

#[test]
fn frames_are_the_same_whatever_is_taken_over() {
    let moving = DRILLED.trim_end().trim_end_matches('}').to_string()
        + r#", "motions": [{ "object": "slab", "rotate": [0, 0, 90], "translate": [0.5, 0, 0] }] }"#;
    let place = Place::new().with("moving.json", &moving);
    let movie = |rest: &[&str]| {
        let args = ["render", "moving.json", "-o", "out.png", "--size", "40x30", "--frames", "4"];
        place.run(&[&args[..], rest].concat()).ok();
        fs::read(place.path("out.png")).unwrap()
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
    place.run(&["render", "moving.json", "-o", "out.png", "--orbit", "9"]).refused(&["--frames"]);
    place.run(&["render", "moving.json", "-o", "out.png", "--frames", "0"]).refused(&["--frames"]);
}

#[test]
fn what_moves_must_be_there() {
    let moving = DRILLED.trim_end().trim_end_matches('}').to_string()
        + r#", "motions": [{ "object": "slap", "translate": [1, 0, 0] }] }"#;
    let place = Place::new().with("moving.json", &moving);
    let answer = place.run(&["render", "moving.json", "-o", "out.png", "--frames", "2"]);
    answer.refused(&["no object named 'slap'", "did you mean 'slab'?"]);
}
