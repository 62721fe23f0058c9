//! Checks the dependencies of the shaders: a WGSL file that uses declarations of other files must list them in its
//! first line.

use super::sources::without_comments;
use pelage_tests::documents::{Document, documents};
use std::collections::{BTreeMap, BTreeSet};

/// Folder of the shaders.
const SOURCES: &str = "runtime/src/";

/// Returns the identifiers in a source, except members (`.x`) and attributes (`@x`).
fn identifiers(code: &str) -> impl Iterator<Item = &str> {
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    code.split(move |c: char| !is_word(c)).filter(move |word| {
        let at = word.as_ptr() as usize - code.as_ptr() as usize;
        let before = code[..at].chars().next_back();
        word.starts_with(|c: char| c.is_alphabetic()) && !matches!(before, Some('.' | '@'))
    })
}

/// Returns the names that a file declares at module scope.
fn declared(code: &str) -> BTreeSet<&str> {
    let mut names = BTreeSet::new();
    for line in code.lines().filter(|line| !line.starts_with([' ', '}'])) {
        let words: Vec<&str> = line.split(|c: char| !(c.is_alphanumeric() || c == '_')).collect();
        let keyword = words.iter().position(|w| matches!(*w, "fn" | "struct" | "const" | "override" | "alias" | "var"));
        let Some(keyword) = keyword else { continue };
        // In `var<storage, read_write> name: Type`, the name is the last word before the colon.
        let declaration = line[line.find(words[keyword]).unwrap_or(0)..].split([':', '=', '(', '{']).next();
        let last = declaration.unwrap_or_default().trim_end_matches([' ', ';']).rsplit(' ').next().unwrap_or_default();
        if !last.is_empty() && last != words[keyword] {
            names.insert(last);
        }
    }
    names
}

/// Returns the names that a file declares in functions, as parameters and as members.
fn local(code: &str) -> BTreeSet<&str> {
    let mut names = BTreeSet::new();
    let words: Vec<&str> = identifiers(code).collect();
    for pair in words.windows(2) {
        if matches!(pair[0], "let" | "var" | "const") {
            names.insert(pair[1]);
        }
    }
    for (at, _) in code.match_indices(':') {
        let name = code[..at].rsplit(|c: char| !(c.is_alphanumeric() || c == '_')).next().unwrap_or_default();
        names.insert(name);
    }
    names
}

/// Returns the files of `owners` that may be in the same shader as `user`, joined by " or ". Files of different passes
/// are never in the same shader. A published form in `study` replaces the file of the same name.
fn providers(user: &str, owners: &BTreeSet<&str>) -> String {
    let folder = user.rsplit_once('/').map_or("", |(folder, _)| folder);
    let mut files: Vec<&str> = owners.iter().copied().collect();
    files.retain(|file| !file.starts_with("passes/") || file.rsplit_once('/').is_some_and(|(of, _)| of == folder));
    if files.iter().any(|file| !file.starts_with("study/")) {
        files.retain(|file| !file.starts_with("study/"));
    }
    files.join(" or ")
}

/// Returns the required first line of each shader that uses other files.
fn first_lines(shaders: &[Document]) -> BTreeMap<&str, String> {
    let sources: Vec<(&str, String)> = shaders.iter().map(|d| (d.path.as_str(), without_comments(&d.text))).collect();
    let mut owners = BTreeMap::<&str, BTreeSet<&str>>::new();
    for (path, code) in &sources {
        for name in declared(code) {
            owners.entry(name).or_default().insert(path.trim_start_matches(SOURCES).trim_end_matches(".wgsl"));
        }
    }
    let mut lines = BTreeMap::new();
    for (path, code) in &sources {
        let (own, local) = (declared(code), local(code));
        let foreign = identifiers(code).filter(|name| !own.contains(name) && !local.contains(name));
        let used: BTreeSet<String> =
            foreign.filter_map(|name| Some(providers(path.trim_start_matches(SOURCES), owners.get(name)?))).collect();
        let used: Vec<String> = used.into_iter().filter(|files| !files.is_empty()).collect();
        if !used.is_empty() {
            lines.insert(*path, format!("//! uses {}", used.join(", ")));
        }
    }
    lines
}

#[test]
fn shaders_begin_with_the_files_that_they_use() {
    let shaders: Vec<Document> = documents(&["wgsl"]).into_iter().filter(|d| d.path.starts_with(SOURCES)).collect();
    let expected = first_lines(&shaders);
    assert!(expected.len() > 30, "{}", expected.len());
    let mut faults = Vec::new();
    for shader in &shaders {
        let header: Vec<&str> = shader.text.lines().take_while(|line| line.starts_with("//! ")).collect();
        let header = header.join(" ").replace(" //! ", " ");
        let wanted = expected.get(shader.path.as_str()).cloned().unwrap_or_default();
        if header != wanted {
            faults.push(format!("{}: found {header:?}, expected {wanted:?}", shader.path));
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn shader_uses_are_found_and_local_names_ignored() {
    let document = |path: &str, text: &str| Document { path: format!("{SOURCES}{path}"), text: text.into() };
    let shaders = [
        document(
            "a.wgsl",
            "const N: u32 = 4u;\nstruct Hair {\n    at: f32,\n}\nfn bend(x: f32) -> f32 { return x; }\n",
        ),
        document("b.wgsl", "fn grow(hair: Hair) -> f32 {\n    let other = 1.0; // bend\n    return bend(hair.N);\n}\n"),
        document("c.wgsl", "fn none(bend: f32) -> f32 { return bend; }\n"),
        document("d.wgsl", "@group(0) @binding(1) var<storage, read_write> hairs: array<f32, N>;\n"),
    ];
    let lines = first_lines(&shaders);
    assert_eq!(lines.get("runtime/src/b.wgsl").map(String::as_str), Some("//! uses a"));
    assert_eq!(lines.get("runtime/src/d.wgsl").map(String::as_str), Some("//! uses a"));
    assert_eq!(lines.len(), 2, "{lines:?}");
}
