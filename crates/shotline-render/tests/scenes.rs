//! Every example scene loads, compiles and renders in every look.

use std::path::Path;

use shotline::compile::{Options, compile};
use shotline::query::batch::Run;
use shotline_render::{LOOKS, Settings, render};

#[test]
fn every_example_renders_in_every_look() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut scenes = 0;
    for path in files.filter(|p| p.extension().is_some_and(|e| e == "json")) {
        let document = shotline_io::load(&path).unwrap_or_else(|e| panic!("{e}"));
        let world = compile(&document.scene, Options::default())
            .unwrap_or_else(|e| panic!("{}", document.diagnostics(&e)));
        for look in LOOKS {
            let settings = Settings { width: 40, height: 30, samples: 1, look, ..Settings::default() };
            let image = render(&world, &document.scene, &settings, Run::default()).unwrap();
            let first = image.pixel(0, 0);
            let case = format!("{} as {}", path.display(), look.name);
            assert!(image.pixels().iter().any(|p| *p != first), "{case} is empty");
            assert!(
                image.pixels().iter().flatten().all(|x| x.is_finite()),
                "{case} has pixels that are not finite"
            );
        }
        scenes += 1;
    }
    assert!(scenes >= 6, "{scenes}");
}
