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
    let help = sandbox.run(&["--help"]).ok();
    let listed = help.split("Commands:").nth(1).unwrap().split("Options:").next().unwrap();
    let commands: Vec<&str> = listed
        .lines()
        .filter(|line| line.starts_with("  ") && !line.starts_with("   "))
        .filter_map(|line| line.split_whitespace().next())
        .filter(|&command| command != "help")
        .collect();
    assert!(commands.contains(&"slice") && commands.contains(&"cast"), "{commands:?}");
    for command in commands {
        let page = folder.join(format!("shotline-{command}.1"));
        assert!(page.is_file(), "no manual page of '{command}'");
    }
    sandbox.run(&["man", "rendr"]).fails_with(&["there is no command 'rendr'", "the commands are render, "]);
    sandbox.run(&["man", "-o", "nowhere"]).fails_with(&["nowhere"]);
}
