//! Runs the program in a temporary folder, with small models and ray files.
#![allow(dead_code)] // each test file uses some of it

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

/// A folder that is removed when the value is dropped.
pub struct Sandbox {
    dir: tempfile::TempDir,
}

/// The exit code and the output of a run.
pub struct RunResult {
    pub code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

impl Sandbox {
    pub fn new() -> Sandbox {
        Sandbox { dir: tempfile::tempdir().unwrap() }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.dir.path().join(name)
    }

    /// Writes a file.
    pub fn with(self, name: &str, contents: impl AsRef<[u8]>) -> Sandbox {
        fs::write(self.path(name), contents).unwrap();
        self
    }

    /// Writes rays, one per row.
    pub fn with_rays(self, name: &str, rows: &[[f64; 6]]) -> Sandbox {
        let values: Vec<f64> = rows.concat();
        self.with(name, npy(&[rows.len(), 6], &values))
    }

    /// Runs the program in the folder.
    pub fn run(&self, args: &[&str]) -> RunResult {
        RunResult::of(self.command(args).output().unwrap())
    }

    pub fn command(&self, args: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_shotline"));
        command.current_dir(self.dir.path()).args(args);
        command
    }

    /// The names of the files in the folder, sorted.
    pub fn files(&self) -> Vec<String> {
        let names = fs::read_dir(self.dir.path()).unwrap();
        let mut names: Vec<_> =
            names.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }
}

impl RunResult {
    pub fn of(output: Output) -> RunResult {
        RunResult {
            code: output.status.code(),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
        }
    }

    /// Asserts success and returns stdout.
    pub fn ok(self) -> String {
        assert_eq!(self.code, Some(0), "{}", self.stderr);
        self.stdout
    }

    /// Asserts an error whose message contains every word, and neither a panic nor a backtrace.
    #[track_caller]
    pub fn fails_with(self, words: &[&str]) {
        assert_eq!(self.code, Some(2), "{}\n{}", self.stdout, self.stderr);
        assert!(self.stderr.starts_with("error: "), "{}", self.stderr);
        assert!(!self.stderr.contains("panicked") && !self.stderr.contains("backtrace"), "{}", self.stderr);
        for word in words {
            assert!(self.stderr.contains(word), "no '{word}' in: {}", self.stderr);
        }
    }
}

/// A .npy file, version 1.0, float64, C order.
pub fn npy(shape: &[usize], values: &[f64]) -> Vec<u8> {
    let shape: String = shape.iter().map(|n| format!("{n},")).collect();
    let mut header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({shape}), }}");
    while (10 + header.len() + 1) % 64 != 0 {
        header.push(' ');
    }
    header.push('\n');
    let mut out = b"\x93NUMPY\x01\x00".to_vec();
    out.extend((header.len() as u16).to_le_bytes());
    out.extend(header.as_bytes());
    out.extend(values.iter().flat_map(|x| x.to_le_bytes()));
    out
}

/// A ball with a square hole along z, of steel, in a box of air that does not touch it.
pub const DRILLED: &str = r#"{ "shotline": 1, "units": "mm",
  "materials": { "air": {}, "steel": {} },
  "objects": [
    { "name": "ball", "material": "steel", "node": { "op": "difference", "args": [
        { "kind": "sphere", "radius": 5 },
        { "kind": "box", "min": [-1, -1, -10], "max": [1, 1, 10] } ] } },
    { "name": "slab", "material": "air", "node":
        { "kind": "box", "min": [6, -2, -2], "max": [8, 2, 2] } } ] }
"#;

/// The first `faces` of the twelve triangles of the unit cube, as ASCII PLY.
pub fn cube_ply(faces: usize) -> String {
    let all = [
        [0, 2, 1],
        [1, 2, 3],
        [4, 5, 6],
        [5, 7, 6],
        [0, 1, 4],
        [1, 5, 4],
        [2, 6, 3],
        [3, 6, 7],
        [0, 4, 2],
        [2, 4, 6],
        [1, 3, 5],
        [3, 7, 5],
    ];
    let mut out = format!(
        "ply\nformat ascii 1.0\nelement vertex 8\nproperty double x\nproperty double y\nproperty double z\n\
         element face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
    );
    for i in 0..8 {
        out += &format!("{} {} {}\n", i & 1, i >> 1 & 1, i >> 2);
    }
    for [a, b, c] in &all[..faces] {
        out += &format!("3 {a} {b} {c}\n");
    }
    out
}

/// 2^40 coincident spheres: each group contains the one before twice.
pub fn nested_spheres() -> Sandbox {
    let group = |i: usize| {
        let below = i - 1;
        format!(
            r#""d{i}": {{"op": "group", "args": [{{"ref": "d{below}"}}, {{"ref": "d{below}", "translate": [0, 0, 0]}}]}}"#
        )
    };
    let groups: Vec<String> = (1..=40).map(group).collect();
    let scene = format!(
        r#"{{"shotline": 1, "defs": {{"d0": {{"kind": "sphere", "radius": 1}}, {}}},
            "objects": [{{"name": "all", "node": {{"ref": "d40"}}}}]}}"#,
        groups.join(", ")
    );
    Sandbox::new().with("scene.json", scene)
}
