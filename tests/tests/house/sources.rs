//! Reads the names that a crate's sources use: imports and paths. Re-exports are followed to the declaring module.
//!
//! Items compiled only for tests are skipped. This is not a full parser and supports only this project's style. A path
//! counts if it begins with `crate`, `super`, `self` or a child module of the file.

use pelage_tests::binary::walk;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Module path as a list of names, such as `passes::skin`; empty for the crate root.
pub type Module = Vec<String>;

/// Modules that each file uses, by the file's module.
pub type Dependencies = BTreeMap<Module, BTreeSet<Module>>;

/// Returns the module path of a file in `src`, such as `passes::skin` for `passes/skin/mod.rs`.
fn module_of(file: &Path, source: &Path) -> Module {
    let inside = file.strip_prefix(source).expect("the file is in the source folder").with_extension("");
    let mut names: Module = inside.iter().map(|part| part.to_string_lossy().into_owned()).collect();
    if names.last().is_some_and(|name| name == "mod" || name == "lib") {
        names.pop();
    }
    names
}

fn is_test(module: &[String]) -> bool {
    module.iter().any(|name| name == "tests" || name == "probe" || name.ends_with("_tests"))
}

/// Returns the code of all modules in a folder `src`.
pub fn modules(source: &Path) -> BTreeMap<Module, String> {
    let mut files = Vec::new();
    walk(source, &mut files);
    files.retain(|file| file.extension().is_some_and(|e| e == "rs"));
    let read = |file: PathBuf| {
        let text = std::fs::read_to_string(&file).expect("the source file is readable");
        (module_of(&file, source), code_of(&text))
    };
    files.into_iter().map(read).filter(|(module, _)| !is_test(module)).collect()
}

/// Returns the offset of the end of the first brace block in `code`.
fn end_of_braces(code: &str) -> usize {
    let mut depth = 0;
    for (at, c) in code.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth == 1 => return at + 1,
            '}' => depth -= 1,
            _ => {}
        }
    }
    code.len()
}

/// Returns the code without line comments.
pub fn without_comments(text: &str) -> String {
    text.lines().map(|line| line.split("//").next().unwrap_or("")).collect::<Vec<_>>().join("\n")
}

/// Returns the code without comments and without items compiled only for tests.
fn code_of(text: &str) -> String {
    const TESTS: &str = "#[cfg(test)]";
    let mut code = without_comments(text);
    while let Some(start) = code.find(TESTS) {
        let rest = &code[start + TESTS.len()..];
        let (semicolon, brace) = (rest.find(';'), rest.find('{'));
        let length = match (semicolon, brace) {
            (Some(s), b) if b.is_none_or(|b| s < b) => s + 1,
            (_, Some(b)) => b + end_of_braces(&rest[b..]),
            _ => rest.len(),
        };
        code.replace_range(start..start + TESTS.len() + length, "");
    }
    code
}

/// Adds all paths that an expression such as `a::b`, `a::{b, c::d as e}` or `a::*` refers to, with their local names.
/// Returns the number of bytes read.
fn expand_path(text: &str, mut path: Module, own: &[String], found: &mut BTreeSet<(Module, String)>) -> usize {
    let skip = |at: usize| at + text[at..].len() - text[at..].trim_start().len();
    let mut at = 0;
    loop {
        let name: String = text[at..].chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
        at += name.len();
        match name.as_str() {
            "" => {}
            "crate" => path.clear(),
            "self" if path.is_empty() => path = own.to_vec(),
            "self" => {}
            // The first `super` means the parent of this file; each further one means the next parent.
            "super" if path.is_empty() => path = own[..own.len().saturating_sub(1)].to_vec(),
            "super" => drop(path.pop()),
            _ => path.push(name),
        }
        if text[at..].starts_with("::{") {
            at = skip(at + 3);
            while !text[at..].starts_with('}') && !text[at..].is_empty() {
                let length = expand_path(&text[at..], path.clone(), own, found);
                at = skip(at + length);
                // Text that cannot be parsed is skipped.
                at = if text[at..].starts_with(',') || length == 0 { skip(at + 1) } else { at };
            }
            return at + 1;
        }
        if !text[at..].starts_with("::") {
            let called = text[at..].strip_prefix(" as ").map(|name| {
                let name: String = name.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
                at += 4 + name.len();
                name
            });
            let called = called.unwrap_or_else(|| path.last().cloned().unwrap_or_default());
            found.insert((path, called));
            return at;
        }
        at += 2;
    }
}

/// Path that code uses.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct UsedPath {
    /// Path from the crate root.
    pub path: Module,
    /// Local name in the file.
    pub called: String,
    /// Whether `pub use` re-exports the path.
    pub handed_on: bool,
}

/// Returns the paths that the code of the module `own` uses. `children` lists those of its child modules that have
/// their own files.
pub fn used_paths(code: &str, own: &[String], children: &BTreeSet<String>) -> BTreeSet<UsedPath> {
    // Finds the inline module that contains an offset.
    let inner = |at: usize| {
        let mut module = own.to_vec();
        for (start, _) in code.match_indices("mod ") {
            let name: String = code[start + 4..].chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
            let body = start + 4 + name.len();
            if code[body..].starts_with(" {") && (body..body + end_of_braces(&code[body..])).contains(&at) {
                module.push(name);
            }
        }
        module
    };
    let mut found = BTreeSet::new();
    let firsts = ["crate", "super", "self"].into_iter().chain(children.iter().map(String::as_str));
    for first in firsts {
        for (start, _) in code.match_indices(&format!("{first}::")) {
            let before = code[..start].trim_end_matches(' ');
            let glued = code[..start].chars().next_back().is_some_and(|c| c.is_alphanumeric() || "_:".contains(c));
            // A name within the braces of an import continues the path before the braces. The path in `pub(in …)` is a
            // visibility, not an import.
            let line = code[..start].rfind(';').map_or(0, |at| at + 1);
            let continued = children.contains(first)
                && code[line..start].rfind("::{").is_some_and(|open| {
                    let open = line + open + 2;
                    open + end_of_braces(&code[open..]) > start
                });
            if glued || continued || before.ends_with("pub(in") {
                continue;
            }
            let module = inner(start);
            let path = if children.contains(first) { own.to_vec() } else { Vec::new() };
            let mut paths = BTreeSet::new();
            expand_path(&code[start..], path, &module, &mut paths);
            let statement = code[line..start].trim_start();
            let handed_on = statement.contains("pub") && before.ends_with("use") && module == own;
            found.extend(paths.into_iter().map(|(path, called)| UsedPath { path, called, handed_on }));
        }
    }
    found
}

/// Returns the dependencies between files. If a file re-exports an item of its child module, this is not a dependency
/// of the file. Files that import the item depend on the module that declares it.
pub fn dependencies(modules: &BTreeMap<Module, String>) -> Dependencies {
    let children = |own: &Module| -> BTreeSet<String> {
        let child = |m: &Module| m.len() == own.len() + 1 && m.starts_with(own);
        modules.keys().filter(|m| child(m)).filter_map(|m| m.last().cloned()).collect()
    };
    let all: BTreeMap<&Module, BTreeSet<UsedPath>> =
        modules.iter().map(|(own, code)| (own, used_paths(code, own, &children(own)))).collect();
    let mut handed_on: BTreeMap<(Module, String), Module> = BTreeMap::new();
    for (own, names) in &all {
        for name in names.iter().filter(|name| name.handed_on) {
            handed_on.insert(((*own).clone(), name.called.clone()), name.path.clone());
        }
    }
    let home = |path: &Module| -> Option<Module> {
        let mut path = path.clone();
        // Limits the length of re-export chains.
        for _ in 0..8 {
            let module = (0..=path.len()).rev().map(|n| path[..n].to_vec()).find(|m| modules.contains_key(m))?;
            let further = path.get(module.len()).and_then(|name| handed_on.get(&(module.clone(), name.clone())));
            match further {
                Some(next) => path = next.iter().chain(&path[module.len() + 1..]).cloned().collect(),
                None => return Some(module),
            }
        }
        None
    };
    let mut out = Dependencies::new();
    for (own, names) in &all {
        let counts = |name: &&UsedPath| !(name.handed_on && name.path.starts_with(own));
        let targets = names.iter().filter(counts).filter_map(|name| home(&name.path));
        out.insert((*own).clone(), targets.filter(|target| target != *own).collect());
    }
    out
}

/// Returns the files of a dependency cycle, if there is one.
pub fn find_cycle(arrows: &Dependencies) -> Option<Vec<Module>> {
    fn walk(
        at: &Module,
        arrows: &Dependencies,
        done: &mut BTreeSet<Module>,
        way: &mut Vec<Module>,
    ) -> Option<Vec<Module>> {
        if let Some(from) = way.iter().position(|seen| seen == at) {
            return Some(way[from..].to_vec());
        }
        if !done.insert(at.clone()) {
            return None;
        }
        way.push(at.clone());
        let found = arrows.get(at).into_iter().flatten().find_map(|next| walk(next, arrows, done, way));
        way.pop();
        found
    }
    let (mut done, mut way) = (BTreeSet::new(), Vec::new());
    arrows.keys().find_map(|start| walk(start, arrows, &mut done, &mut way))
}
