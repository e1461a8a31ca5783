//! `shotline compare`.

mod sandbox;

use sandbox::{DRILLED, Sandbox};

#[test]
fn every_accelerator_has_a_row_and_a_picture() {
    let sandbox = Sandbox::new().with("drilled.json", DRILLED);
    let text = sandbox.run(&["compare", "drilled.json", "-o", "work.png"]).ok();
    for name in shotline::accel::NAMES {
        let row = text.lines().find(|line| line.trim_start().starts_with(name));
        // With a small model each accelerator casts all rays of the picture.
        assert!(row.is_some_and(|row| row.contains("76800")), "no '{name}' in\n{text}");
    }
    let picture: Vec<u8> = std::fs::read(sandbox.path("work.png")).unwrap();
    assert!(picture.starts_with(b"\x89PNG"));
}
