//! `shotline completions` and `shotline man`.

mod sandbox;

use std::fs;

use sandbox::Sandbox;

#[test]
fn scripts_complete_commands_flags_and_names() {
    let sandbox = Sandbox::new();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = sandbox.run(&["completions", shell]).ok();
        for word in ["render", "--surfaces-only", "bvh_best", "thickness"] {
            // PowerShell and Elvish complete commands and flags only.
            let is_value = matches!(word, "bvh_best" | "thickness");
            let is_known = matches!(shell, "bash" | "zsh" | "fish") || !is_value;
            assert!(!is_known || script.contains(word.trim_start_matches("--")), "{shell}: {word}");
        }
    }
    sandbox.run(&["completions", "tcsh"]).fails_with(&["bash, elvish, fish, powershell, zsh"]);
}

#[test]
fn every_command_has_a_manual_page() {
    let sandbox = Sandbox::new();
    let page = sandbox.run(&["man", "render"]).ok();
    for words in [".TH shotline-render 1", "SH SYNOPSIS", "shotline render", "Examples:"] {
        assert!(page.contains(words), "no '{words}' in\n{page}");
    }
    assert!(sandbox.run(&["man"]).ok().contains("Every crossing of rays with exact solids"));
    let folder = sandbox.path("pages");
    fs::create_dir(&folder).unwrap();
    sandbox.run(&["man", "-o", "pages"]).ok();
    let mut names: Vec<String> = fs::read_dir(&folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    assert_eq!((names.len(), names[0].as_str()), (12, "shotline-bench.1"));
    sandbox.run(&["man", "rendr"]).fails_with(&["there is no command 'rendr'", "render, cast"]);
    sandbox.run(&["man", "-o", "nowhere"]).fails_with(&["nowhere"]);
}
