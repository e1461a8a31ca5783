//! Ctrl-C ends long work cleanly.
#![cfg(unix)]

mod place;

use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::Duration;

use place::Place;

#[test]
fn ctrl_c_leaves_nothing_behind() {
    // Enough work for minutes: every ray asks each of many spheres.
    let spheres: Vec<String> = (0..2000)
        .map(|i| {
            let (x, y) = (i % 50, i / 50);
            format!(r#"{{"name": "s{i}", "node": {{"kind": "sphere", "radius": 0.4, "translate": [{x}, {y}, 0]}}}}"#)
        })
        .collect();
    let scene = format!(r#"{{"shotline": 1, "objects": [{}]}}"#, spheres.join(",\n"));
    let ray = |i: i32| [f64::from(i % 50), f64::from(i % 40), -5.0, 0.001, 0.002, 1.0];
    let rays: Vec<[f64; 6]> = (0..400_000).map(ray).collect();
    let place = Place::new().with("scene.json", scene).with_rays("rays.npy", &rays);
    let args = [
        "cast",
        "scene.json",
        "--rays",
        "rays.npy",
        "--query",
        "crossings",
        "-o",
        "out.npz",
        "--accel",
        "brute",
    ];
    let child = place.command(&args).stderr(Stdio::piped()).spawn().unwrap();
    sleep(Duration::from_millis(1500));
    let killed = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(killed.success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(place.files(), ["rays.npy", "scene.json"]);
}
