//! Where input comes from and output goes: standard streams, endings, links, protected and full places, signals.

mod place;

use std::fs;
use std::io::Write;
use std::process::Stdio;

use place::{DRILLED, Place, npy};

const RAY: [f64; 6] = [-9.0, 0.1, 2.0, 1.0, 0.0, 0.0];

fn place() -> Place {
    Place::new().with("drilled.json", DRILLED).with_rays("rays.npy", &[RAY, RAY])
}

/// Runs with bytes on standard input; answers those of standard output.
fn piped(place: &Place, args: &[&str], input: &[u8]) -> (Option<i32>, Vec<u8>, String) {
    let mut command = place.command(args);
    command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    // A program that refuses its options reads nothing.
    let _ = child.stdin.take().unwrap().write_all(input);
    let output = child.wait_with_output().unwrap();
    (output.status.code(), output.stdout, String::from_utf8(output.stderr).unwrap())
}

#[test]
fn a_dash_is_standard_input_and_output() {
    let place = place();
    place.run(&["cast", "drilled.json", "--rays", "rays.npy", "--query", "crossings", "-o", "a.npz"]).ok();
    let expected = fs::read(place.path("a.npz")).unwrap();
    let rays = npy(&[2, 6], &[RAY, RAY].concat());
    let cast = ["cast", "drilled.json", "--rays", "-", "--query", "crossings", "-o", "-", "--stats"];
    let (code, out, errors) = piped(&place, &cast, &rays);
    assert_eq!((code, &out), (Some(0), &expected), "{errors}");
    assert!(errors.contains("rays_per_s"), "{errors}");
    let from_scene = ["cast", "-", "--rays", "rays.npy", "--query", "crossings", "-o", "-"];
    assert_eq!(piped(&place, &from_scene, DRILLED.as_bytes()).1, expected);
    let (code, png, _) = piped(&place, &["render", "-", "--size", "8x6", "-o", "-"], DRILLED.as_bytes());
    assert!(code == Some(0) && png.starts_with(b"\x89PNG"));
    let (code, text, _) = piped(&place, &["check", "-"], place::cube_ply(12).as_bytes());
    let text = String::from_utf8(text).unwrap();
    assert!(code == Some(0) && text.starts_with("stdin: ") && text.ends_with("\nstdin: sound\n"), "{text}");
    let (code, _, errors) = piped(&place, &cast, b"rubbish");
    assert!(
        code == Some(2) && errors.starts_with("error: stdin: byte 0: this is not a .npy file"),
        "{errors}"
    );
    let (code, text, errors) = piped(&place, &["convert", "drilled.json", "-"], b"");
    assert!(code == Some(0) && text.starts_with(b"{"), "{errors}");
    let both = ["cast", "-", "--rays", "-", "--query", "any", "-o", "a.npz"];
    let (code, _, errors) = piped(&place, &both, b"");
    assert!(code == Some(2) && errors.contains("both"), "{errors}");
    assert_eq!(place.files(), ["a.npz", "drilled.json", "rays.npy"]);
}

#[test]
fn a_wrong_ending_is_refused_with_the_right_one() {
    let place = place();
    place.run(&["render", "drilled.json", "-o", "a.jpg"]).refused(&["a.jpg", ".png", ".jpg"]);
    let cast = ["cast", "drilled.json", "--rays", "rays.npy", "--query", "any", "-o", "a.csv"];
    place.run(&cast).refused(&["a.csv", ".npz"]);
    place.run(&["compare", "drilled.json", "-o", "a.svg"]).refused(&["a.svg", ".png"]);
    place.run(&["convert", "drilled.json", "a.step"]).refused(&["a.step", ".json", ".ply"]);
    assert_eq!(place.files(), ["drilled.json", "rays.npy"]);
}

#[cfg(unix)]
#[test]
fn an_output_that_is_an_input_is_refused_whatever_it_is_called() {
    let place = place().with("cube.ply", place::cube_ply(12));
    fs::hard_link(place.path("rays.npy"), place.path("hard.npz")).unwrap();
    std::os::unix::fs::symlink("rays.npy", place.path("soft.npz")).unwrap();
    let before = fs::read(place.path("rays.npy")).unwrap();
    for output in ["hard.npz", "soft.npz"] {
        let cast = ["cast", "drilled.json", "--rays", "rays.npy", "--query", "any", "-o", output];
        place.run(&cast).refused(&[output, "rays.npy", "input"]);
    }
    place.run(&["convert", "cube.ply", "./cube.ply"]).refused(&["cube.ply", "input"]);
    assert_eq!(fs::read(place.path("rays.npy")).unwrap(), before);
}

#[cfg(unix)]
#[test]
fn a_link_is_written_through_and_a_protected_file_left_alone() {
    use std::os::unix::fs::PermissionsExt;
    let place = place();
    let render = |output: &str| place.run(&["render", "drilled.json", "--size", "8x6", "-o", output]);
    std::os::unix::fs::symlink("real.png", place.path("link.png")).unwrap();
    for _ in 0..2 {
        render("link.png").ok();
        assert!(fs::symlink_metadata(place.path("link.png")).unwrap().is_symlink());
        assert!(fs::read(place.path("real.png")).unwrap().starts_with(b"\x89PNG"));
    }
    let kept = place.with("kept.png", "kept");
    fs::set_permissions(kept.path("kept.png"), fs::Permissions::from_mode(0o444)).unwrap();
    kept.run(&["render", "drilled.json", "--size", "8x6", "-o", "kept.png"])
        .refused(&["kept.png", "protected"]);
    assert_eq!(fs::read(kept.path("kept.png")).unwrap(), b"kept");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_one_message() {
    let place = place();
    let cast = |query| ["cast", "drilled.json", "--rays", "rays.npy", "--query", query, "-o", "/dev/full"];
    for args in [&cast("crossings")[..], &["render", "drilled.json", "--size", "8x6", "-o", "/dev/full"]] {
        let answer = place.run(args);
        assert_eq!(answer.stderr.lines().count(), 1, "{}", answer.stderr);
        answer.refused(&["/dev/full", "No space"]);
    }
}

/// Whenever they come: before, while and after the file is written.
#[cfg(target_os = "linux")]
#[test]
fn signals_to_end_leave_no_temporary_file() {
    let many = vec![RAY; 200_000];
    let place = Place::new().with("drilled.json", DRILLED).with_rays("rays.npy", &many);
    for signal in ["TERM", "HUP", "INT"] {
        for delay in [30, 120, 250] {
            let args = [
                "cast",
                "drilled.json",
                "--rays",
                "rays.npy",
                "--query",
                "crossings",
                "-o",
                "out.npz",
                "--threads",
                "1",
            ];
            let mut child = place.command(&args).stderr(Stdio::piped()).spawn().unwrap();
            std::thread::sleep(std::time::Duration::from_millis(delay));
            let id = child.id().to_string();
            std::process::Command::new("kill").args([&format!("-{signal}"), &id]).status().unwrap();
            let _ = child.wait().unwrap();
            let left: Vec<String> =
                place.files().into_iter().filter(|name| name.starts_with(".shotline-")).collect();
            assert!(left.is_empty(), "{signal} after {delay} ms: {left:?}");
        }
    }
}
