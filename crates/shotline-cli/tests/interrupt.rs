//! Ctrl-C ends long work cleanly.
#![cfg(unix)]

mod sandbox;

use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::Duration;

use sandbox::{Sandbox, nested_spheres};

/// Enough work for minutes: every ray tests each of many spheres.
fn slow() -> Sandbox {
    let spheres: Vec<String> = (0..2000)
        .map(|i| {
            let (x, y) = (i % 50, i / 50);
            format!(r#"{{"name": "s{i}", "node": {{"kind": "sphere", "radius": 0.4, "translate": [{x}, {y}, 0]}}}}"#)
        })
        .collect();
    let scene = format!(r#"{{"shotline": 1, "objects": [{}]}}"#, spheres.join(",\n"));
    let ray = |i: i32| [f64::from(i % 50), f64::from(i % 40), -5.0, 0.001, 0.002, 1.0];
    let rays: Vec<[f64; 6]> = (0..400_000).map(ray).collect();
    Sandbox::new().with("scene.json", scene).with_rays("rays.npy", &rays)
}

/// Interrupts a running command: it must exit with code 130, leave no file and print nothing.
#[track_caller]
fn assert_ends_cleanly(sandbox: &Sandbox, args: &[&str], after: Duration) {
    let child = sandbox.command(args).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    sleep(after);
    let killed = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(killed.success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(output.stdout.is_empty());
    assert_eq!(sandbox.files(), ["rays.npy", "scene.json"]);
}

#[test]
fn ctrl_c_leaves_nothing_behind() {
    let model = ["scene.json", "--rays", "rays.npy", "--query", "crossings", "--accel", "brute"];
    let sandbox = slow();
    let after = Duration::from_millis(1500);
    assert_ends_cleanly(&sandbox, &[&["cast", "-o", "out.npz"], &model[..]].concat(), after);
    assert_ends_cleanly(&sandbox, &[&["bench"], &model[..]].concat(), after);
    assert_ends_cleanly(
        &sandbox,
        &["measure", "scene.json", "--method", "rays", "--rays", "1000000000"],
        after,
    );
}

/// The ray passes the boxes of all spheres and meets none: no query ends before the limit of steps, which takes
/// seconds. (A ray that meets spheres reaches the limit of crossings sooner than the signal arrives.)
#[test]
fn ctrl_c_ends_a_single_ray() {
    let sandbox = nested_spheres().with_rays("rays.npy", &[[-5.0, 0.9, 0.9, 1.0, 0.0, 0.0]]);
    for query in ["closest", "count", "crossings", "segments"] {
        let args = ["cast", "scene.json", "--rays", "rays.npy", "--query", query, "-o", "out.npz"];
        assert_ends_cleanly(&sandbox, &args, Duration::from_millis(400));
    }
}
