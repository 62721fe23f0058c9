//! A crate's sources, read for what each file names: its imports and the paths in its code, with re-exports followed to where things are declared.
//!
//! What only tests compile is left out. It is a reader of this project's style and no compiler: a path counts where it begins with `crate`, `super`,
//! `self` or a module of the file's own.

use pelage_tests::binary::walk;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// A module, `passes::skin` as its names; the crate's root is empty.
pub type Module = Vec<String>;

/// Each file's module with the modules of the files that it names.
pub type Arrows = BTreeMap<Module, BTreeSet<Module>>;

/// Module path of a file below `src`: `passes/skin/mod.rs` is `passes::skin`.
fn module_of(file: &Path, source: &Path) -> Module {
    let inside = file.strip_prefix(source).expect("inside the sources").with_extension("");
    let mut names: Module = inside.iter().map(|part| part.to_string_lossy().into_owned()).collect();
    if names.last().is_some_and(|name| name == "mod" || name == "lib") {
        names.pop();
    }
    names
}

fn is_test(module: &[String]) -> bool {
    module.iter().any(|name| name == "tests" || name == "probe" || name.ends_with("_tests"))
}

/// The modules below a folder `src`, with their code.
pub fn modules(source: &Path) -> BTreeMap<Module, String> {
    let mut files = Vec::new();
    walk(source, &mut files);
    files.retain(|file| file.extension().is_some_and(|e| e == "rs"));
    let read = |file: PathBuf| {
        let text = std::fs::read_to_string(&file).expect("a source file");
        (module_of(&file, source), code_of(&text))
    };
    files.into_iter().map(read).filter(|(module, _)| !is_test(module)).collect()
}

/// Where the braces that open first in `code` close again.
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

/// Code without comments, and without items that only tests compile.
fn code_of(text: &str) -> String {
    const TESTS: &str = "#[cfg(test)]";
    let mut code = text.lines().map(|line| line.split("//").next().unwrap_or("")).collect::<Vec<_>>().join("\n");
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

/// Adds what a path stands for, `a::b`, `a::{b, c::d as e}` or `a::*`, with its last name as it is called here; returns how far it reaches.
fn unfold(text: &str, mut path: Module, own: &[String], found: &mut BTreeSet<(Module, String)>) -> usize {
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
            // The first of several leads from this file, each other one a step up.
            "super" if path.is_empty() => path = own[..own.len().saturating_sub(1)].to_vec(),
            "super" => drop(path.pop()),
            _ => path.push(name),
        }
        if text[at..].starts_with("::{") {
            at = skip(at + 3);
            while !text[at..].starts_with('}') && !text[at..].is_empty() {
                let length = unfold(&text[at..], path.clone(), own, found);
                at = skip(at + length);
                // What cannot be read is passed over.
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

/// A path that code names.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Named {
    /// From the crate's root.
    pub path: Module,
    /// Its last name, as it is called in the file.
    pub called: String,
    /// It is handed on: `pub use`.
    pub handed_on: bool,
}

/// Paths that the code of module `own` names. `children`: its modules that are files.
pub fn named(code: &str, own: &[String], children: &BTreeSet<String>) -> BTreeSet<Named> {
    // Where modules within the file begin and end.
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
            // In braces of an import a name goes on from what stands before them; who may see an item is no import.
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
            unfold(&code[start..], path, &module, &mut paths);
            let statement = code[line..start].trim_start();
            let handed_on = statement.contains("pub") && before.ends_with("use") && module == own;
            found.extend(paths.into_iter().map(|(path, called)| Named { path, called, handed_on }));
        }
    }
    found
}

/// Which file names which. What a file hands on of its own modules is no arrow from it, and leads whoever imports it there on to where it is declared.
pub fn arrows(modules: &BTreeMap<Module, String>) -> Arrows {
    let children = |own: &Module| -> BTreeSet<String> {
        let child = |m: &Module| m.len() == own.len() + 1 && m.starts_with(own);
        modules.keys().filter(|m| child(m)).filter_map(|m| m.last().cloned()).collect()
    };
    let all: BTreeMap<&Module, BTreeSet<Named>> =
        modules.iter().map(|(own, code)| (own, named(code, own, &children(own)))).collect();
    let mut handed_on: BTreeMap<(Module, String), Module> = BTreeMap::new();
    for (own, names) in &all {
        for name in names.iter().filter(|name| name.handed_on) {
            handed_on.insert(((*own).clone(), name.called.clone()), name.path.clone());
        }
    }
    let home = |path: &Module| -> Option<Module> {
        let mut path = path.clone();
        // Handed on a few times at most.
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
    let mut out = Arrows::new();
    for (own, names) in &all {
        let counts = |name: &&Named| !(name.handed_on && name.path.starts_with(own));
        let targets = names.iter().filter(counts).filter_map(|name| home(&name.path));
        out.insert((*own).clone(), targets.filter(|target| target != *own).collect());
    }
    out
}

/// Files that lead back to themselves.
pub fn circle(arrows: &Arrows) -> Option<Vec<Module>> {
    fn walk(at: &Module, arrows: &Arrows, done: &mut BTreeSet<Module>, way: &mut Vec<Module>) -> Option<Vec<Module>> {
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
