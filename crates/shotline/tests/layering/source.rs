//! The parts of Rust sources that the layering tests need: modules and their imports, without comments, strings
//! and tests.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// A module path below the root of its crate: `["solid", "mesh"]`.
pub type Module = Vec<String>;

/// A file of a crate that is compiled outside tests.
pub struct File {
    pub path: PathBuf,
    pub module: Module,
    pub imports: Vec<Import>,
}

/// A path to another item of the same crate.
pub struct Import {
    pub line: usize,
    pub target: Module,
    /// The name it is bound to, if it is part of a `use`.
    name: Option<String>,
}

/// The files of one crate.
pub struct Crate {
    pub files: Vec<File>,
    /// The target of a name in a module, if the name is imported.
    imported: BTreeMap<(Module, String), Module>,
}

impl Crate {
    /// Reads all files below `src`.
    pub fn read(src: &Path) -> Crate {
        let mut sources = Vec::new();
        let mut tests: BTreeSet<Module> = BTreeSet::new();
        for path in rust_files(src) {
            let module = module_of(path.strip_prefix(src).unwrap());
            let (tokens, test_modules) = without_tests(tokens(&fs::read_to_string(&path).unwrap()));
            tests.extend(test_modules.into_iter().map(|name| child(&module, &name)));
            sources.push((path, module, tokens));
        }
        sources.retain(|(_, module, _)| !(1..=module.len()).any(|n| tests.contains(&module[..n])));
        let modules: BTreeSet<Module> = sources.iter().map(|(_, module, _)| module.clone()).collect();
        let mut files = Vec::new();
        for (path, module, tokens) in sources {
            let imports = imports(&tokens, &module, &modules);
            files.push(File { path, module, imports });
        }
        let mut imported = BTreeMap::new();
        for file in &files {
            for import in &file.imports {
                if let Some(name) = &import.name {
                    imported.insert((file.module.clone(), name.clone()), import.target.clone());
                }
            }
        }
        Crate { files, imported }
    }

    /// Returns the module of the file that defines the target of a path, following re-exports.
    pub fn home(&self, target: &Module) -> Module {
        let is_file = |path: &[String]| self.files.iter().any(|f| f.module == path);
        let mut target = target.clone();
        for _ in 0..16 {
            let depth = (0..=target.len()).rev().find(|&n| is_file(&target[..n])).unwrap_or(0);
            let Some(name) = target.get(depth) else { break };
            let Some(origin) = self.imported.get(&(target[..depth].to_vec(), name.clone())) else {
                target.truncate(depth);
                break;
            };
            target = [&origin[..], &target[depth + 1..]].concat();
        }
        target
    }
}

/// All `.rs` files below a folder, sorted.
pub fn rust_files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut entries: Vec<PathBuf> = fs::read_dir(folder)
        .unwrap_or_else(|e| panic!("{}: {e}", folder.display()))
        .map(|e| e.unwrap().path())
        .collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            found.extend(rust_files(&path));
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
    found
}

fn module_of(file: &Path) -> Module {
    let mut module: Module =
        file.with_extension("").iter().map(|part| part.to_str().unwrap().to_string()).collect();
    module.pop_if(|last| matches!(last.as_str(), "mod" | "lib" | "main"));
    module
}

fn child(module: &[String], name: &str) -> Module {
    [module, &[name.to_string()]].concat()
}

/// An identifier, number, `::` or punctuation character, with its line.
#[derive(Clone)]
pub struct Token {
    pub text: String,
    pub line: usize,
}

/// Returns the tokens of a source, without comments, strings and character literals.
pub fn tokens(source: &str) -> Vec<Token> {
    let chars: Vec<char> = source.chars().collect();
    let at = |i: usize| chars.get(i).copied().unwrap_or('\0');
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let (mut out, mut i, mut line) = (Vec::new(), 0, 1);
    while i < chars.len() {
        let begin = i;
        if at(i) == '/' && at(i + 1) == '/' {
            while i < chars.len() && at(i) != '\n' {
                i += 1;
            }
        } else if at(i) == '/' && at(i + 1) == '*' {
            let mut depth = 0;
            loop {
                match (at(i), at(i + 1)) {
                    ('/', '*') => (depth, i) = (depth + 1, i + 2),
                    ('*', '/') => (depth, i) = (depth - 1, i + 2),
                    _ => i += 1,
                }
                if depth == 0 || i >= chars.len() {
                    break;
                }
            }
        } else if at(i) == '"' {
            i += 1;
            while i < chars.len() && at(i) != '"' {
                i += if at(i) == '\\' { 2 } else { 1 };
            }
            i += 1;
        } else if at(i) == '\'' {
            i += match (at(i + 1), at(i + 2)) {
                ('\\', _) => 3 + (i + 3..).take_while(|&k| k < chars.len() && at(k) != '\'').count() + 1,
                (_, '\'') => 3,
                _ => 1, // a lifetime
            };
        } else if is_word(at(i)) {
            while is_word(at(i)) {
                i += 1;
            }
            let word: String = chars[begin..i].iter().collect();
            let hashes = (i..).take_while(|&k| at(k) == '#').count();
            if matches!(word.as_str(), "r" | "br" | "cr") && at(i + hashes) == '"' {
                let end: String = std::iter::once('"').chain(std::iter::repeat_n('#', hashes)).collect();
                i += hashes + 1;
                while i < chars.len() && !end.chars().enumerate().all(|(k, c)| at(i + k) == c) {
                    i += 1;
                }
                i += hashes + 1;
            } else {
                out.push(Token { text: word, line });
            }
        } else if at(i) == ':' && at(i + 1) == ':' {
            out.push(Token { text: "::".into(), line });
            i += 2;
        } else {
            if !at(i).is_whitespace() {
                out.push(Token { text: at(i).to_string(), line });
            }
            i += 1;
        }
        line += chars[begin..i.min(chars.len())].iter().filter(|c| **c == '\n').count();
    }
    out
}

/// Removes items under `#[cfg(test)]`. Also returns the names of test modules that are in separate files.
fn without_tests(tokens: Vec<Token>) -> (Vec<Token>, Vec<String>) {
    let text = |i: usize| tokens.get(i).map_or("", |t: &Token| t.text.as_str());
    let is_attribute = |i: usize| text(i) == "#" && text(i + 1) == "[";
    let (mut kept, mut modules, mut i) = (Vec::new(), Vec::new(), 0);
    while i < tokens.len() {
        let end = if is_attribute(i) { closing(&tokens, i + 1) } else { i + 1 };
        let words: Vec<&str> = (i..end).map(text).collect();
        let is_test = is_attribute(i)
            && words.get(2) == Some(&"cfg")
            && words.contains(&"test")
            && !words.contains(&"not")
            && !words.contains(&"any");
        if !is_test {
            kept.extend_from_slice(&tokens[i..end]);
            i = end;
            continue;
        }
        i = end;
        while is_attribute(i) {
            i = closing(&tokens, i + 1);
        }
        let item = i;
        while i < tokens.len() && !matches!(text(i), ";" | "{") {
            i = if matches!(text(i), "(" | "[") { closing(&tokens, i) } else { i + 1 };
        }
        if text(i) == ";" {
            let name = (item..i).find(|&k| text(k) == "mod").map(|k| text(k + 1).to_string());
            modules.extend(name);
            i += 1;
        } else {
            i = closing(&tokens, i);
        }
    }
    (kept, modules)
}

/// Returns the index after the bracket that closes the one at `open`.
fn closing(tokens: &[Token], open: usize) -> usize {
    let mut depth = 0;
    for (i, token) in tokens.iter().enumerate().skip(open) {
        match token.text.as_str() {
            "(" | "[" | "{" => depth += 1,
            ")" | "]" | "}" => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return i + 1;
        }
    }
    tokens.len()
}

/// The imports of a file: every `use`, and every path that begins with `crate`, `super` or `self`.
fn imports(tokens: &[Token], module: &[String], modules: &BTreeSet<Module>) -> Vec<Import> {
    let text = |i: usize| tokens.get(i).map_or("", |t: &Token| t.text.as_str());
    let mut found: Vec<(usize, Vec<String>, Option<String>)> = Vec::new();
    let mut i = 0;
    while i < tokens.len() {
        if text(i) == "use" {
            i = use_tree(tokens, i + 1, Vec::new(), &mut found);
        } else if matches!(text(i), "crate" | "super" | "self") && text(i + 1) == "::" {
            let line = tokens[i].line;
            let mut path = vec![text(i).to_string()];
            while text(i + 1) == "::" && text(i + 2).starts_with(|c: char| c.is_alphabetic() || c == '_') {
                path.push(text(i + 2).to_string());
                i += 2;
            }
            found.push((line, path, None));
            i += 1;
        } else {
            i += 1;
        }
    }
    let imports = found.into_iter().filter_map(|(line, path, name)| {
        let target = absolute(&path, module, modules)?;
        Some(Import { line, target, name })
    });
    imports.collect()
}

/// Parses one branch of a `use` and returns the index after it.
fn use_tree(
    tokens: &[Token],
    mut i: usize,
    mut path: Vec<String>,
    out: &mut Vec<(usize, Vec<String>, Option<String>)>,
) -> usize {
    let text = |i: usize| tokens.get(i).map_or("", |t: &Token| t.text.as_str());
    if text(i) == "::" {
        i += 1;
    }
    while text(i) != "{" {
        path.push(text(i).to_string());
        if text(i + 1) != "::" {
            let line = tokens.get(i).map_or(0, |t| t.line);
            if path.len() > 1 {
                path.pop_if(|last| last == "self");
            }
            let name = if text(i + 1) == "as" { Some(text(i + 2).to_string()) } else { path.last().cloned() };
            out.push((line, path, name));
            return if text(i + 1) == "as" { i + 3 } else { i + 1 };
        }
        i += 2;
    }
    let end = closing(tokens, i);
    i += 1;
    while i + 1 < end {
        i = use_tree(tokens, i, path.clone(), out);
        if text(i) == "," {
            i += 1;
        }
    }
    end
}

/// Returns a path from the root of the crate. `None` if it leads to another crate.
fn absolute(path: &[String], module: &[String], modules: &BTreeSet<Module>) -> Option<Module> {
    let mut base = module.to_vec();
    let mut rest = path;
    match path.first()?.as_str() {
        "crate" => (base, rest) = (Vec::new(), &path[1..]),
        "self" | "super" => {
            while let Some(step @ ("self" | "super")) = rest.first().map(String::as_str) {
                if step == "super" {
                    base.pop();
                }
                rest = &rest[1..];
            }
        }
        first if modules.contains(&child(module, first)) => {}
        _ => return None,
    }
    Some([&base[..], rest].concat())
}
