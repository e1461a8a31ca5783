//! Checks the layers of the code: which module may import which, and a few rules for files.
//!
//! The file `mod.rs` is the interface of its folder. It declares the folder's files, and they may use what it
//! defines. Imports between sibling files must not form a cycle; a folder counts as one file. `lib.rs` is the
//! interface of its crate.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

#[path = "layering/source.rs"]
mod source;

use source::{Crate, Module, rust_files, tokens};

/// The modules of the core, lowest first, each with all modules it imports. An unused entry is also an error and
/// must be removed.
const IMPORTS: &[(&str, &[&str])] = &[
    ("math", &[]),
    ("roots", &["math"]),
    ("polygon", &["math"]),
    ("ray", &["math"]),
    ("aabb", &["math", "ray"]),
    ("region", &["math", "aabb"]),
    ("crossing", &[]),
    ("contact", &["math", "crossing"]),
    ("outline", &["math", "aabb"]),
    ("trace", &["math", "crossing", "outline"]),
    ("budget", &[]),
    ("counters", &[]),
    ("tags", &[]),
    ("pool", &[]),
    ("scratch", &["trace", "budget", "counters", "tags"]),
    ("simd", &["math"]),
    ("lanes", &["math", "ray", "aabb", "simd"]),
    ("accel", &["math", "aabb", "counters", "pool", "simd", "lanes", "outline"]),
    (
        "solid",
        &[
            "math", "roots", "polygon", "ray", "aabb", "region", "crossing", "contact", "trace", "counters",
            "scratch", "tags", "pool", "simd", "lanes", "accel",
        ],
    ),
    ("csg", &["math", "ray", "aabb", "region", "crossing", "contact", "simd", "lanes"]),
    ("lecture", &["math", "roots", "crossing", "solid", "csg"]),
    ("scene", &["math", "solid", "csg"]),
    ("shape", &["math", "solid", "scene"]),
    ("compile", &["math", "aabb", "region", "accel", "solid", "csg", "scene"]),
    (
        "query",
        &[
            "math", "ray", "aabb", "crossing", "contact", "trace", "budget", "counters", "tags", "pool",
            "scratch", "simd", "lanes", "outline", "accel", "solid", "csg", "compile",
        ],
    ),
    ("prelude", &["math", "ray", "scene", "shape", "compile", "query"]),
    ("measure", &["math", "ray", "aabb", "region", "pool", "scratch", "solid", "scene", "compile", "query"]),
    (
        "testkit",
        &[
            "math", "ray", "aabb", "crossing", "counters", "scratch", "accel", "solid", "scene", "compile",
            "query", "measure",
        ],
    ),
];

/// Our crates, lowest first: the dependencies of each, and the additional ones of its tests and examples.
const CRATES: &[(&str, &[&str], &[&str])] = &[
    ("shotline", &[], &[]),
    ("shotline-io", &["shotline"], &[]),
    ("shotline-render", &["shotline"], &["shotline-io"]),
    ("shotline-tessellate", &["shotline"], &[]),
    ("shotline-cli", &["shotline", "shotline-io", "shotline-render", "shotline-tessellate"], &[]),
];

/// The packages whose files must not import each other in a cycle, by folder. `python` is the native half of the Python
/// package.
const ACYCLIC: &[&str] = &[
    "crates/shotline",
    "crates/shotline-io",
    "crates/shotline-render",
    "crates/shotline-tessellate",
    "crates/shotline-cli",
    "python",
];

/// Files that may contain `unsafe`.
const UNSAFE: &[&str] = &["crates/shotline/src/simd/avx2.rs", "crates/shotline/src/simd/avx512.rs"];

const MAX_LINES: usize = 500;

const VAGUE_NAMES: &[&str] = &["utils", "util", "misc", "common", "helpers"];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).unwrap().to_path_buf()
}

fn shown(path: &Path) -> String {
    path.strip_prefix(root()).unwrap_or(path).display().to_string()
}

#[track_caller]
fn assert_none(problems: &[String]) {
    assert!(problems.is_empty(), "\n  {}\n", problems.join("\n  "));
}

/// The folders of `crates`.
fn crates() -> Vec<PathBuf> {
    let entries = fs::read_dir(root().join("crates")).unwrap().map(|e| e.unwrap().path());
    let mut found: Vec<PathBuf> = entries.filter(|path| path.join("Cargo.toml").exists()).collect();
    found.sort();
    found
}

fn package(folder: &str) -> Crate {
    Crate::read(&root().join(folder).join("src"))
}

/// Collects everything in the repository except hidden files and build products.
fn repository(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let hidden = name.starts_with('.') && name != ".ci";
        if hidden || matches!(name.as_str(), "target" | "out" | "__pycache__") || path.is_symlink() {
            continue;
        }
        found.push(path.clone());
        if path.is_dir() {
            repository(&path, found);
        }
    }
    found.sort();
}

#[test]
fn the_core_imports_downwards() {
    let core = package("crates/shotline");
    let allowed: BTreeMap<&str, &[&str]> = IMPORTS.iter().copied().collect();
    let mut problems = Vec::new();
    for (i, (module, targets)) in IMPORTS.iter().enumerate() {
        for target in *targets {
            if !IMPORTS[..i].iter().any(|(below, _)| below == target) {
                problems.push(format!("the table lets {module} import {target}, which is not below it"));
            }
        }
    }
    let mut used = BTreeSet::new();
    for file in &core.files {
        let Some(from) = file.module.first() else { continue };
        let Some(targets) = allowed.get(from.as_str()) else {
            problems.push(format!("{}: the module {from} is not in the table", shown(&file.path)));
            continue;
        };
        for import in &file.imports {
            let Some(to) = import.target.first().filter(|to| *to != from) else { continue };
            used.insert((from.clone(), to.clone()));
            if allowed.contains_key(to.as_str()) && !targets.contains(&to.as_str()) {
                problems.push(format!("{}:{}: {from} may not import {to}", shown(&file.path), import.line));
            }
        }
    }
    for (from, targets) in IMPORTS {
        for to in *targets {
            if !used.contains(&(from.to_string(), to.to_string())) {
                problems.push(format!("{from} no longer imports {to}: take the arrow out of the table"));
            }
        }
    }
    assert_none(&problems);
}

#[test]
fn files_do_not_import_in_a_circle() {
    let mut problems = Vec::new();
    for folder in ACYCLIC {
        let arrows = arrows_between_files(&package(folder));
        let Some(cycle) = arrows.keys().find_map(|start| cycle(&arrows, start)) else { continue };
        problems.extend(cycle.iter().map(|(from, to)| {
            format!("{}: {} imports {}", arrows[from][to], from.join("::"), to.join("::"))
        }));
    }
    assert_none(&problems);
}

/// Maps a file or folder to the siblings it imports, with the location of the first import.
fn arrows_between_files(package: &Crate) -> BTreeMap<Module, BTreeMap<Module, String>> {
    let mut arrows: BTreeMap<Module, BTreeMap<Module, String>> = BTreeMap::new();
    for file in &package.files {
        for import in &file.imports {
            let to = package.home(&import.target);
            let shared = file.module.iter().zip(&to).take_while(|(a, b)| a == b).count();
            if shared == file.module.len() || shared == to.len() {
                continue; // between the mod.rs of a folder and its files
            }
            let location = format!("{}:{}", shown(&file.path), import.line);
            let from = file.module[..=shared].to_vec();
            arrows.entry(from).or_default().entry(to[..=shared].to_vec()).or_insert(location);
        }
    }
    arrows
}

/// Returns the edges of a shortest cycle through a module.
fn cycle(
    arrows: &BTreeMap<Module, BTreeMap<Module, String>>,
    start: &Module,
) -> Option<Vec<(Module, Module)>> {
    let mut reached_from: BTreeMap<Module, Module> = BTreeMap::new();
    let mut queue = std::collections::VecDeque::from([start.clone()]);
    while let Some(from) = queue.pop_front() {
        for to in arrows.get(&from).into_iter().flat_map(BTreeMap::keys) {
            if reached_from.contains_key(to) {
                continue;
            }
            reached_from.insert(to.clone(), from.clone());
            if to == start {
                let mut way = vec![(from.clone(), to.clone())];
                while way[0].0 != *start {
                    let here = way[0].0.clone();
                    way.insert(0, (reached_from[&here].clone(), here));
                }
                return Some(way);
            }
            queue.push_back(to.clone());
        }
    }
    None
}

#[test]
fn crates_depend_downwards() {
    let mut problems = Vec::new();
    for folder in crates() {
        let manifest = folder.join("Cargo.toml");
        let name = folder.file_name().unwrap().to_str().unwrap();
        let Some((_, depends, tests)) = CRATES.iter().find(|(known, ..)| *known == name) else {
            problems.push(format!("{}: the crate {name} is not in the table", shown(&manifest)));
            continue;
        };
        let mut section = String::new();
        for (i, line) in fs::read_to_string(&manifest).unwrap().lines().enumerate() {
            if line.starts_with('[') {
                section = line.to_string();
            }
            let key: String = line.chars().take_while(|c| c.is_alphanumeric() || "-_".contains(*c)).collect();
            let is_ours = CRATES.iter().any(|(ours, ..)| *ours == key);
            let is_allowed = depends.contains(&key.as_str())
                || section.contains("dev-dependencies") && (tests.contains(&key.as_str()) || key == name);
            if section.contains("dependencies") && is_ours && !is_allowed {
                problems.push(format!("{}:{}: {name} may not depend on {key}", shown(&manifest), i + 1));
            }
        }
    }
    assert_none(&problems);
}

#[test]
fn files_are_short() {
    let mut files: Vec<PathBuf> =
        crates().iter().flat_map(|folder| rust_files(&folder.join("src"))).collect();
    let mut all = Vec::new();
    repository(&root(), &mut all);
    let python = root().join("python");
    let is_source = |path: &PathBuf| path.extension().is_some_and(|e| e == "rs" || e == "py" || e == "pyi");
    files.extend(all.into_iter().filter(|path| path.starts_with(&python) && is_source(path)));
    let long = files.iter().filter_map(|path| {
        let lines = fs::read_to_string(path).unwrap().lines().count();
        (lines > MAX_LINES).then(|| format!("{}:{lines}: over {MAX_LINES} lines: split it", shown(path)))
    });
    assert_none(&long.collect::<Vec<_>>());
}

#[test]
fn names_say_something() {
    let mut all = Vec::new();
    repository(&root(), &mut all);
    let shapeless = all.iter().filter(|path| {
        let stem = path.file_stem().unwrap().to_string_lossy().to_lowercase();
        VAGUE_NAMES.contains(&stem.as_str())
    });
    let problem = |path: &PathBuf| format!("{}: name it after what it holds", shown(path));
    assert_none(&shapeless.map(problem).collect::<Vec<_>>());
}

#[test]
fn unsafe_stays_where_it_is_allowed() {
    let mut all = Vec::new();
    repository(&root(), &mut all);
    let mut problems = Vec::new();
    for path in all.iter().filter(|path| path.extension().is_some_and(|e| e == "rs")) {
        if UNSAFE.contains(&shown(path).as_str()) {
            continue;
        }
        for token in tokens(&fs::read_to_string(path).unwrap()) {
            if token.text == "unsafe" {
                problems.push(format!("{}:{}: unsafe is not allowed here", shown(path), token.line));
            }
        }
    }
    assert_none(&problems);
}

#[test]
fn no_file_names_a_path_of_a_machine() {
    // Split, so that this file does not contain such a path.
    let roots = ["work", "root", "home"].map(|name| format!("/{name}/"));
    let mut all = Vec::new();
    repository(&root(), &mut all);
    let mut problems = Vec::new();
    for path in all.iter().filter(|path| path.is_file()) {
        let Ok(text) = fs::read_to_string(path) else { continue };
        if text.contains('\0') {
            continue;
        }
        for (i, line) in text.lines().enumerate() {
            for machine in &roots {
                let begins = line.match_indices(machine.as_str()).any(|(at, _)| {
                    !line[..at].ends_with(|c: char| c.is_alphanumeric() || "._-~)}".contains(c))
                });
                if begins {
                    problems.push(format!("{}:{}: an absolute path, {machine}...", shown(path), i + 1));
                }
            }
        }
    }
    assert_none(&problems);
}
