//! Input and output: standard streams, file name extensions, links, protected files, full disks, signals.

mod sandbox;

use std::fs;
use std::io::Write;
use std::process::Stdio;

use sandbox::{DRILLED, Sandbox, npy};

const RAY: [f64; 6] = [-9.0, 0.1, 2.0, 1.0, 0.0, 0.0];

fn sandbox() -> Sandbox {
    Sandbox::new().with("drilled.json", DRILLED).with_rays("rays.npy", &[RAY, RAY])
}

/// Runs with bytes on standard input; returns the exit code, standard output and standard error.
fn piped(sandbox: &Sandbox, args: &[&str], input: &[u8]) -> (Option<i32>, Vec<u8>, String) {
    let mut command = sandbox.command(args);
    command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    // A program that fails on its options reads nothing.
    let _ = child.stdin.take().unwrap().write_all(input);
    let output = child.wait_with_output().unwrap();
    (output.status.code(), output.stdout, String::from_utf8(output.stderr).unwrap())
}

#[test]
fn a_dash_is_standard_input_and_output() {
    let sandbox = sandbox();
    sandbox.run(&["cast", "drilled.json", "--rays", "rays.npy", "--query", "crossings", "-o", "a.npz"]).ok();
    let expected = fs::read(sandbox.path("a.npz")).unwrap();
    let rays = npy(&[2, 6], &[RAY, RAY].concat());
    let cast = ["cast", "drilled.json", "--rays", "-", "--query", "crossings", "-o", "-", "--stats"];
    let (code, out, errors) = piped(&sandbox, &cast, &rays);
    assert_eq!((code, &out), (Some(0), &expected), "{errors}");
    assert!(errors.contains("rays_per_s"), "{errors}");
    let from_scene = ["cast", "-", "--rays", "rays.npy", "--query", "crossings", "-o", "-"];
    assert_eq!(piped(&sandbox, &from_scene, DRILLED.as_bytes()).1, expected);
    let (code, png, _) = piped(&sandbox, &["render", "-", "--size", "8x6", "-o", "-"], DRILLED.as_bytes());
    assert!(code == Some(0) && png.starts_with(b"\x89PNG"));
    let (code, text, _) = piped(&sandbox, &["check", "-"], sandbox::cube_ply(12).as_bytes());
    let text = String::from_utf8(text).unwrap();
    assert!(code == Some(0) && text.starts_with("stdin: ") && text.ends_with("\nstdin: sound\n"), "{text}");
    let (code, _, errors) = piped(&sandbox, &cast, b"rubbish");
    assert!(
        code == Some(2) && errors.starts_with("error: stdin: byte 0: this is not a .npy file"),
        "{errors}"
    );
    let (code, text, errors) = piped(&sandbox, &["convert", "drilled.json", "-"], b"");
    assert!(code == Some(0) && text.starts_with(b"{"), "{errors}");
    let both = ["cast", "-", "--rays", "-", "--query", "any", "-o", "a.npz"];
    let (code, _, errors) = piped(&sandbox, &both, b"");
    assert!(code == Some(2) && errors.contains("both"), "{errors}");
    assert_eq!(sandbox.files(), ["a.npz", "drilled.json", "rays.npy"]);
}

#[test]
fn a_wrong_extension_is_an_error_that_names_the_right_one() {
    let sandbox = sandbox();
    sandbox.run(&["render", "drilled.json", "-o", "a.gif"]).fails_with(&["a.gif", ".png", ".jpg"]);
    let cast = ["cast", "drilled.json", "--rays", "rays.npy", "--query", "any", "-o", "a.txt"];
    sandbox.run(&cast).fails_with(&["a.txt", ".npz", ".csv"]);
    sandbox.run(&["compare", "drilled.json", "-o", "a.svg"]).fails_with(&["a.svg", ".png"]);
    sandbox.run(&["convert", "drilled.json", "a.step"]).fails_with(&["a.step", ".json", ".ply"]);
    assert_eq!(sandbox.files(), ["drilled.json", "rays.npy"]);
}

#[cfg(unix)]
#[test]
fn an_output_that_is_an_input_is_an_error_under_any_name() {
    let sandbox = sandbox().with("cube.ply", sandbox::cube_ply(12));
    fs::hard_link(sandbox.path("rays.npy"), sandbox.path("hard.npz")).unwrap();
    std::os::unix::fs::symlink("rays.npy", sandbox.path("soft.npz")).unwrap();
    let before = fs::read(sandbox.path("rays.npy")).unwrap();
    for output in ["hard.npz", "soft.npz"] {
        let cast = ["cast", "drilled.json", "--rays", "rays.npy", "--query", "any", "-o", output];
        sandbox.run(&cast).fails_with(&[output, "rays.npy", "input"]);
    }
    sandbox.run(&["convert", "cube.ply", "./cube.ply"]).fails_with(&["cube.ply", "input"]);
    assert_eq!(fs::read(sandbox.path("rays.npy")).unwrap(), before);
}

#[cfg(unix)]
#[test]
fn links_are_followed_and_protected_files_are_kept() {
    use std::os::unix::fs::PermissionsExt;
    let sandbox = sandbox();
    let render = |output: &str| sandbox.run(&["render", "drilled.json", "--size", "8x6", "-o", output]);
    std::os::unix::fs::symlink("real.png", sandbox.path("link.png")).unwrap();
    for _ in 0..2 {
        render("link.png").ok();
        assert!(fs::symlink_metadata(sandbox.path("link.png")).unwrap().is_symlink());
        assert!(fs::read(sandbox.path("real.png")).unwrap().starts_with(b"\x89PNG"));
    }
    let kept = sandbox.with("kept.png", "kept");
    fs::set_permissions(kept.path("kept.png"), fs::Permissions::from_mode(0o444)).unwrap();
    kept.run(&["render", "drilled.json", "--size", "8x6", "-o", "kept.png"])
        .fails_with(&["kept.png", "protected"]);
    assert_eq!(fs::read(kept.path("kept.png")).unwrap(), b"kept");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_one_message() {
    let sandbox = sandbox();
    let cast = |query| ["cast", "drilled.json", "--rays", "rays.npy", "--query", query, "-o", "/dev/full"];
    for args in [&cast("crossings")[..], &["render", "drilled.json", "--size", "8x6", "-o", "/dev/full"]] {
        let result = sandbox.run(args);
        assert_eq!(result.stderr.lines().count(), 1, "{}", result.stderr);
        result.fails_with(&["/dev/full", "No space"]);
    }
}

/// Signals before, during and after the write of the file.
#[cfg(target_os = "linux")]
#[test]
fn termination_signals_leave_no_temporary_file() {
    let many = vec![RAY; 200_000];
    let sandbox = Sandbox::new().with("drilled.json", DRILLED).with_rays("rays.npy", &many);
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
            let mut child = sandbox.command(&args).stderr(Stdio::piped()).spawn().unwrap();
            std::thread::sleep(std::time::Duration::from_millis(delay));
            let id = child.id().to_string();
            std::process::Command::new("kill").args([&format!("-{signal}"), &id]).status().unwrap();
            let _ = child.wait().unwrap();
            let left: Vec<String> =
                sandbox.files().into_iter().filter(|name| name.starts_with(".shotline-")).collect();
            assert!(left.is_empty(), "{signal} after {delay} ms: {left:?}");
        }
    }
}
