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
    render(&["--size", "0x10"]).refused(&["0x10"]);
    render(&["--size", "10"]).refused(&["--size", "800x600"]);
    render(&["--samples", "0"]).refused(&["samples"]);
    render(&["--look", "loud"]).refused(&["loud", "lit", "thickness"]);
    render(&["--background", "#12"]).refused(&["--background", "#336699"]);
    let thickness = ["render", "open.ply", "-o", "out.png", "--look", "thickness", "--size", "8x8"];
    place.run(&thickness).refused(&["open.ply", "thickness", "open edges"]);
    assert!(!place.path("out.png").exists());
}
