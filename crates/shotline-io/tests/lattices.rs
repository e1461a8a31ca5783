//! Lattices in scene files.

use shotline::math::Vec3;
use shotline::query::Caster;
use shotline::ray::{Ray, Span};
use shotline_io::{Document, ReadError, write_scene};

/// A scene with one node, which may use a ball of radius 1/4.
fn text(node: &str) -> String {
    format!(
        r#"{{"shotline": 1, "defs": {{"ball": {{"kind": "sphere", "radius": 0.25}}}}, "objects": [{{"name": "o", "node": {node}}}]}}"#
    )
}

fn parse_scene(text: &str) -> Result<Document, ReadError> {
    shotline_io::parse_scene(text, None)
}

fn count(node: &str, o: [f64; 3], d: [f64; 3]) -> u64 {
    let scene = parse_scene(&text(node)).unwrap_or_else(|error| panic!("{error}")).scene;
    let again = parse_scene(&write_scene(&scene).unwrap()).unwrap_or_else(|error| panic!("{error}")).scene;
    assert_eq!(format!("{scene:?}"), format!("{again:?}"));
    let world = scene.compile().unwrap_or_else(|error| panic!("{error}"));
    let ray = Ray::new(Vec3::from(o), Vec3::from(d)).unwrap();
    Caster::new(&world).count(&ray, Span::FORWARD).unwrap()
}

#[test]
fn lattices_are_read_and_written() {
    let lattice = |more: &str| format!(r#"{{"op": "lattice", "args": [{{"ref": "ball"}}], {more}}}"#);
    let rows = lattice(r#""counts": [4, 3, 2], "pitch": [1, 2, 3]"#);
    assert_eq!(count(&rows, [-5.0, 2.0, 3.0], [1.0, 0.0, 0.0]), 8);
    let staggered = lattice(r#""counts": [4, 3, 1], "pitch": [1, 1, 0], "stagger": true"#);
    assert_eq!(count(&staggered, [0.5, -5.0, 0.0], [0.0, 1.0, 0.0]), 2);
    let holes = lattice(r#""counts": [4, 1, 1], "pitch": [1, 0, 0], "cells": [0, null, 0, null]"#);
    assert_eq!(count(&holes, [-5.0, 0.0, 0.0], [1.0, 0.0, 0.0]), 4);
    let rings = r#"{"op": "hexagonal_lattice", "args": [{"ref": "ball"}], "rings": 3, "pitch": 1, "layers": 2, "height": 1}"#;
    assert_eq!(count(rings, [-5.0, 0.0, 1.0], [1.0, 0.0, 0.0]), 10);
    let single = r#"{"op": "hexagonal_lattice", "args": [{"ref": "ball"}, {"kind": "box", "min": [0,0,0], "max": [1,1,1]}], "rings": 1, "pitch": 1, "cells": [1]}"#;
    assert_eq!(count(single, [-5.0, 0.5, 0.5], [1.0, 0.0, 0.0]), 2);
}

#[test]
fn rings_are_groups_of_turned_copies() {
    let arm = r#"{"kind": "box", "min": [1, -0.25, 0], "max": [2, 0.25, 1]}"#;
    let ring = |more: &str| {
        let text = text(&format!(r#"{{"op": "ring", "args": [{arm}], {more}}}"#));
        parse_scene(&text).unwrap_or_else(|error| panic!("{error}")).scene.compile().unwrap()
    };
    let count = |more: &str, o: [f64; 3], d: [f64; 3]| {
        let ray = Ray::new(Vec3::from(o), Vec3::from(d)).unwrap();
        Caster::new(&ring(more)).count(&ray, Span::FORWARD).unwrap()
    };
    assert_eq!(count(r#""count": 4"#, [-5.0, 0.0, 0.5], [1.0, 0.0, 0.0]), 4);
    assert_eq!(count(r#""count": 4"#, [0.0, -5.0, 0.5], [0.0, 1.0, 0.0]), 4);
    assert_eq!(count(r#""count": 2, "step": 90"#, [0.0, -5.0, 0.5], [0.0, 1.0, 0.0]), 2);
    assert_eq!(ring(r#""count": 3"#).path_name(2), "o/box[2]");
}

#[test]
fn mistakes_in_lattices_are_explained() {
    let args = r#""args": [{"ref": "ball"}]"#;
    let cases = [
        (format!(r#"{{"op": "lattice", {args}, "pitch": [1, 1, 1]}}"#), "this lattice lacks \"counts\""),
        (
            format!(r#"{{"op": "lattice", {args}, "counts": [2, 2], "pitch": [1, 1, 1]}}"#),
            "three whole numbers",
        ),
        (
            format!(r#"{{"op": "lattice", {args}, "counts": [2, 2, 0], "pitch": [1, 1, 1]}}"#),
            "from 1 to 2147483648",
        ),
        (
            format!(r#"{{"op": "lattice", {args}, "counts": [2, 2, 1.5], "pitch": [1, 1, 1]}}"#),
            "whole numbers",
        ),
        (format!(r#"{{"op": "lattice", {args}, "counts": [2, 2, 1], "pitch": 1}}"#), "an array of 3 numbers"),
        (format!(r#"{{"op": "lattice", {args}, "count": [2, 2, 1], "pitch": [1, 1, 1]}}"#), "'counts'"),
        (format!(r#"{{"op": "lattise", {args}, "counts": [2, 2, 1], "pitch": [1, 1, 1]}}"#), "'lattice'"),
        (
            format!(
                r#"{{"op": "lattice", {args}, "counts": [2, 1, 1], "pitch": [1, 1, 1], "cells": [0, -1]}}"#
            ),
            "or null",
        ),
        (format!(r#"{{"op": "hexagonal_lattice", {args}, "rings": 0, "pitch": 1}}"#), "whole numbers"),
        (
            r#"{"op": "lattice", "args": [], "counts": [2, 1, 1], "pitch": [1, 1, 1]}"#.to_owned(),
            "has no args",
        ),
    ];
    let of_rings = [
        (format!(r#"{{"op": "ring", {args}, "count": 0}}"#), "whole numbers"),
        (format!(r#"{{"op": "ring", {args}, "count": 2000000}}"#), "too large"),
        (r#"{"op": "ring", "args": [{"ref": "ball"}, {"ref": "ball"}], "count": 2}"#.to_owned(), "one arg"),
    ];
    for (node, message) in cases.into_iter().chain(of_rings) {
        let error = parse_scene(&text(&node)).expect_err(&node).to_string();
        assert!(error.contains(message), "{message}\nis not in\n{error}");
    }
    // What the numbers are is checked when compiling.
    for (more, message) in [
        (r#""pitch": [-1, 1, 1], "counts": [2, 1, 1]"#, "positive where there is more than one cell"),
        (r#""pitch": [1, 1, 1], "counts": [2147483648, 2, 1]"#, "at most 2147483648 cells"),
        (
            r#""pitch": [1, 1, 1], "counts": [2, 1, 1], "cells": [0]"#,
            "a lattice of 2 cells has 1 in its table",
        ),
        (r#""pitch": [1, 1, 1], "counts": [2, 1, 1], "cells": [0, 1]"#, "holds element 1, but the last is 0"),
    ] {
        let scene = parse_scene(&text(&format!(r#"{{"op": "lattice", {args}, {more}}}"#))).unwrap().scene;
        let error = scene.compile().unwrap_err().to_string();
        assert!(error.contains(message), "{message}\nis not in\n{error}");
    }
}

#[test]
fn what_no_cell_holds_is_not_in_the_world() {
    let open = r#"{"kind": "box", "min": [0, 0, 0], "max": [1, 1, 1]}"#;
    let node = format!(
        r#"{{"op": "lattice", "args": [{{"ref": "ball"}}, {open}], "counts": [2, 1, 1], "pitch": [1, 1, 1], "cells": [0, null]}}"#
    );
    let world = parse_scene(&text(&node)).unwrap().scene.compile().unwrap();
    assert_eq!(world.path_count(), 1);
    assert!(world.bounds().max.x < 0.3);
}

/// The cells of nested lattices in a combination are all counted before any is written out.
#[test]
fn lattices_in_combinations_have_a_limit() {
    let lattice = |arg: &str, counts: &str| {
        format!(r#"{{"op": "lattice", "args": [{arg}], "counts": {counts}, "pitch": [1, 1, 1]}}"#)
    };
    let union = |node: &str| format!(r#"{{"op": "union", "args": [{node}]}}"#);
    let small = lattice(r#"{"ref": "ball"}"#, "[1024, 1, 1]");
    let huge = union(&lattice(&small, "[1024, 1024, 1]"));
    let error = parse_scene(&text(&huge)).unwrap().scene.compile().unwrap_err().to_string();
    assert!(error.contains("a combination of 1073741824 leaves"), "{error}");
    let few = union(&lattice(&lattice(r#"{"ref": "ball"}"#, "[3, 1, 1]"), "[1, 4, 1]"));
    assert_eq!(count(&few, [-5.0, 2.0, 0.0], [1.0, 0.0, 0.0]), 6);
}
