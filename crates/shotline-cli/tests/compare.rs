//! `shotline compare`.

mod place;

use place::{DRILLED, Place};

#[test]
fn every_accelerator_has_a_row_and_a_picture() {
    let place = Place::new().with("drilled.json", DRILLED);
    let text = place.run(&["compare", "drilled.json", "-o", "work.png"]).ok();
    for name in shotline::accel::NAMES {
        let row = text.lines().find(|line| line.trim_start().starts_with(name));
        // Of a small model each structure answers all rays of the picture.
        assert!(row.is_some_and(|row| row.contains("76800")), "no '{name}' in\n{text}");
    }
    let picture: Vec<u8> = std::fs::read(place.path("work.png")).unwrap();
    assert!(picture.starts_with(b"\x89PNG"));
}
