//! The scene in the README is valid.

use shotline::compile::{Options, compile};

const README: &str = include_str!("../../../README.md");

#[test]
fn the_example_scene_compiles() {
    let (_, rest) = README.split_once("```jsonc\n").expect("a scene in the README");
    let (text, _) = rest.split_once("```").expect("its end");
    let document = shotline_io::parse_scene(text, None).unwrap_or_else(|e| panic!("{e}"));
    let world = compile(&document.scene, Options::default()).expect("a sound scene");
    assert_eq!(world.object_names(), ["plate", "bolts"]);
    assert_eq!(world.stats().virtual_leaves, 10);
}
