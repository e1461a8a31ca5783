//! The shipped scenes, the scenes of the documentation and the commands of the README work.

mod sandbox;

use std::fs;
use std::path::{Path, PathBuf};

use sandbox::Sandbox;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).unwrap().to_path_buf()
}

fn read(path: &str) -> String {
    fs::read_to_string(root().join(path)).unwrap()
}

/// The code blocks of a page with one of the given languages.
fn blocks<'a>(page: &'a str, marks: &[&str]) -> Vec<&'a str> {
    let pieces: Vec<&str> = page.split("\n```").collect();
    let inside = pieces.iter().skip(1).step_by(2);
    let marked = inside.filter_map(|block| block.split_once('\n'));
    marked.filter(|(mark, _)| marks.contains(mark)).map(|(_, text)| text).collect()
}

#[track_caller]
fn assert_sound(sandbox: &Sandbox, model: &str) {
    let result = sandbox.run(&["check", model]);
    assert_eq!(result.code, Some(0), "{model}\n{}{}", result.stdout, result.stderr);
    assert!(result.stdout.ends_with(": sound\n"), "{}", result.stdout);
}

#[test]
fn every_shipped_scene_is_sound() {
    let sandbox = Sandbox::new();
    let mut count = 0;
    for entry in fs::read_dir(root().join("scenes")).unwrap() {
        let path = entry.unwrap().path();
        assert_sound(&sandbox, path.to_str().unwrap());
        count += 1;
    }
    assert!(count >= 8, "{count}");
}

#[test]
fn every_scene_of_the_documentation_is_sound() {
    let mut pages = vec!["README.md".to_string()];
    for entry in fs::read_dir(root().join("docs")).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        pages.extend(name.ends_with(".md").then(|| format!("docs/{name}")));
    }
    let mut count = 0;
    for page in pages {
        for block in blocks(&read(&page), &["json", "jsonc"]) {
            // Some blocks are only excerpts of scenes.
            if block.contains("\"shotline\"") && block.contains("\"objects\"") && !block.contains("...") {
                let sandbox =
                    Sandbox::new().with("scene.json", block).with("part.ply", sandbox::cube_ply(12));
                assert_sound(&sandbox, "scene.json");
                count += 1;
            }
        }
    }
    assert!(count >= 1);
}

/// Runs every line of the block, in order, in a folder that contains only the scenes. The pictures are small, so that
/// the test is fast.
#[test]
fn every_command_of_the_readme_runs_on_a_fresh_clone() {
    let readme = read("README.md");
    let commands =
        blocks(&readme, &["sh"]).into_iter().find(|block| block.contains("shotline render")).unwrap();
    let sandbox = Sandbox::new();
    fs::create_dir(sandbox.path("scenes")).unwrap();
    for entry in fs::read_dir(root().join("scenes")).unwrap() {
        let path = entry.unwrap().path();
        fs::copy(&path, sandbox.path("scenes").join(path.file_name().unwrap())).unwrap();
    }
    let mut count = 0;
    for line in commands.lines() {
        let line = line.split(" #").next().unwrap().trim();
        let mut args: Vec<&str> = line.split_whitespace().collect();
        assert_eq!(args.remove(0), "shotline", "{line}");
        match args[0] {
            "render" => {
                let frames = args.iter().position(|arg| *arg == "--frames");
                frames.iter().for_each(|at| args[at + 1] = "2");
                let samples = args.iter().position(|arg| *arg == "--samples");
                samples.iter().for_each(|at| args[at + 1] = "1");
                args.extend(["--size", "16x12"]);
            }
            // It runs until it is interrupted, and has tests of its own.
            "view" => continue,
            _ => {}
        }
        let result = sandbox.run(&args);
        assert_eq!(result.code, Some(0), "{line}\n{}{}", result.stdout, result.stderr);
        count += 1;
    }
    assert!(count >= 8, "{count}");
}

/// The second example of `check --help`.
#[test]
fn a_sound_scene_has_segments_and_measures() {
    let scene = root().join("scenes/section.json");
    let scene = scene.to_str().unwrap();
    let sandbox = Sandbox::new().with_rays("rays.npy", &[[-9.0, 0.1, 3.05, 1.0, 0.0, 0.0]]);
    sandbox.run(&["cast", scene, "--rays", "rays.npy", "--query", "segments", "-o", "out.npz"]).ok();
    let text = sandbox.run(&["measure", scene, "--rays", "480"]).ok();
    assert!(text.contains("unbounded") && text.contains("lever"), "{text}");
}
