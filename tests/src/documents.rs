//! Reads the project's documents for tests: their text, the names that they mention, and their citations.

use crate::binary::workspace;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Text file of the repository.
#[derive(Clone, Debug)]
pub struct Document {
    /// Path relative to the repository root, with slashes.
    pub path: String,
    /// Text of the file.
    pub text: String,
}

/// Folders to skip, because their files are not written by people.
const SKIPPED: [&str; 5] = ["target", ".git", "out", "corpus", "node_modules"];

/// Returns all text files of the repository with one of the given extensions, ordered by path.
///
/// # Panics
///
/// If a folder or file cannot be read. Skipping it would leave it unchecked.
pub fn documents(extensions: &[&str]) -> Vec<Document> {
    let mut found = Vec::new();
    collect(workspace(), extensions, &mut found);
    found.sort_by(|a, b| a.path.cmp(&b.path));
    found
}

/// Returns all text files that git tracks, ordered by path. Files that are not UTF-8 are skipped.
///
/// # Panics
///
/// If git cannot be run, or a file cannot be read.
pub fn tracked_texts() -> Vec<Document> {
    let listed = std::process::Command::new("git").args(["ls-files", "-z"]).current_dir(workspace()).output();
    let listed = listed.unwrap_or_else(|e| panic!("git ls-files: {e}"));
    assert!(listed.status.success(), "git ls-files: {}", String::from_utf8_lossy(&listed.stderr));
    let names = String::from_utf8_lossy(&listed.stdout);
    let text = |path: &str| {
        let file = workspace().join(path);
        // Deleted files remain in the index until the deletion is staged.
        let bytes = file.exists().then(|| std::fs::read(&file).unwrap_or_else(|e| panic!("{path}: {e}")))?;
        Some(Document { path: path.to_owned(), text: String::from_utf8(bytes).ok()? })
    };
    names.split_terminator('\0').filter_map(text).collect()
}

fn collect(folder: &Path, extensions: &[&str], found: &mut Vec<Document>) {
    for entry in std::fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display())) {
        let entry = entry.unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
        let path = entry.path();
        let name = entry.file_name().to_string_lossy().into_owned();
        if path.is_dir() {
            if !SKIPPED.contains(&name.as_str()) {
                collect(&path, extensions, found);
            }
        } else if path.extension().is_some_and(|e| extensions.iter().any(|wanted| e == *wanted)) {
            let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
            let path = path.strip_prefix(workspace()).unwrap_or(&path).to_string_lossy().replace('\\', "/");
            found.push(Document { path, text });
        }
    }
}

/// Returns the section numbers of the formula sheet that a text cites, as in "formulas 3.2", "formulas 4.6, 3.2" or
/// "formulas §6.1".
pub fn cited_formulas(text: &str) -> Vec<String> {
    let mut cited = Vec::new();
    for (at, word) in text.match_indices("formulas") {
        let mut rest = text[at + word.len()..].trim_start_matches(".md");
        loop {
            rest = rest.trim_start_matches([' ', ',', '§']);
            let end = rest.find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap_or(rest.len());
            let number = rest[..end].trim_end_matches('.');
            if !number.contains('.') {
                break;
            }
            cited.push(number.to_owned());
            rest = &rest[end..];
        }
    }
    cited
}

/// Returns the section numbers in a document's headings, such as "4.2" of `### 4.2 Layer-wise shadow maps`.
pub fn numbered_headings(markdown: &str) -> BTreeSet<String> {
    let headings = markdown.lines().filter(|line| line.starts_with('#'));
    headings
        .filter_map(|line| line.trim_start_matches('#').split_whitespace().next())
        .filter(|word| word.starts_with(|c: char| c.is_ascii_digit()))
        .map(str::to_owned)
        .collect()
}

/// Returns the names of Markdown files in a text, such as `FORMAT.md` or `bake/docs/artists.md`.
pub fn named_documents(text: &str) -> Vec<String> {
    let part = |c: char| c.is_ascii_alphanumeric() || "._-/".contains(c);
    let words = text.split(|c: char| !part(c)).map(|word| word.trim_matches('.'));
    words.filter(|word| word.len() > 3 && word.ends_with(".md")).map(str::to_owned).collect()
}

/// Returns the code spans of a document: text between single backticks, outside of code blocks.
pub fn code_spans(markdown: &str) -> Vec<String> {
    let prose = without_code(markdown);
    // A code span may continue on the next line of its paragraph.
    let paragraphs = prose.split("\n\n");
    paragraphs
        .flat_map(|p| p.split('`').skip(1).step_by(2).map(|span| span.replace('\n', " ")).collect::<Vec<_>>())
        .collect()
}

/// Returns the repository paths in the code spans of a document: those that begin with a top-level folder and contain
/// no wildcard.
pub fn named_paths(markdown: &str) -> Vec<String> {
    let top = ["assets/", "bake/", "formats/", "runtime/", "tests/", ".ci/"];
    let plain = |span: &String| !span.contains([' ', '*', '<', '{', '…', '$']);
    let path = |span: String| span.split(['#', ':']).next().unwrap_or_default().to_owned();
    code_spans(markdown).into_iter().filter(|s| top.iter().any(|t| s.starts_with(t)) && plain(s)).map(path).collect()
}

/// Returns the targets of a document's links and pictures within the repository. A target is a path relative to the
/// document's folder, and an anchor. Either may be empty.
pub fn links(markdown: &str) -> Vec<(String, String)> {
    let prose = without_code(markdown);
    let targets = prose.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    targets
        .filter(|target| !target.contains("://"))
        .map(|target| {
            let (path, anchor) = target.split_once('#').unwrap_or((target, ""));
            (path.to_owned(), anchor.to_owned())
        })
        .collect()
}

/// Returns the anchors of a Markdown document, which common hosts derive from its headings.
pub fn anchors(markdown: &str) -> BTreeSet<String> {
    let anchor = |heading: &str| -> String {
        let text = heading.trim_start_matches('#').trim().to_lowercase();
        let kept = text.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
        kept.map(|c| if c == ' ' { '-' } else { c }).collect()
    };
    without_code(markdown).lines().filter(|line| line.starts_with('#')).map(anchor).collect()
}

/// Returns the prose lines longer than `columns`, with their line numbers. Tables, pictures and code are exempt.
pub fn long_lines(markdown: &str, columns: usize) -> Vec<(usize, String)> {
    let prose = |line: &str| !line.starts_with(['|', '!', '<']);
    let lines = without_code(markdown);
    let numbered = lines.lines().enumerate().filter(|(_, line)| prose(line) && line.chars().count() > columns);
    numbered.map(|(i, line)| (i + 1, line.to_owned())).collect()
}

/// Replaces the lines of code blocks with empty lines.
fn without_code(markdown: &str) -> String {
    let mut fenced = false;
    let mut out = String::with_capacity(markdown.len());
    for line in markdown.lines() {
        let fence = line.trim_start().starts_with("```");
        fenced ^= fence;
        if !(fenced || fence || line.starts_with("    ")) {
            out += line;
        }
        out.push('\n');
    }
    out
}

/// Returns the file or folder that a path in a document refers to, below the workspace folder.
pub fn resolve(document: &Document, path: &str) -> PathBuf {
    let folder = workspace().join(&document.path);
    folder.parent().unwrap_or(workspace()).join(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formula_citations_are_found() {
        let text =
            "the formulas of ink, formulas 3.2; (formulas 4.6, 3.2), formulas.md 4.3 and formulas §6.1, 7 of them";
        assert_eq!(cited_formulas(text), ["3.2", "4.6", "3.2", "4.3", "6.1"]);
        assert_eq!(numbered_headings("# Sheet\n## 3 Breaks\n### 3.2 Products\n3.3 no").len(), 2);
    }

    #[test]
    fn paths_and_links_are_found() {
        let text = "See `bake/src/x.rs`, `tests/*.rs`, `a b` and [that](docs/a.md#one-two).\n\n\
                    ```\n`bake/no.rs`\n[no](no)\n```\n\
                    ![p](p.png) [w](https://x.y) [here](#one)";
        assert_eq!(named_paths(text), ["bake/src/x.rs"]);
        let found: Vec<_> = links(text).into_iter().map(|(path, anchor)| format!("{path}#{anchor}")).collect();
        assert_eq!(found, ["docs/a.md#one-two", "p.png#", "#one"]);
        assert!(anchors("## One, two `x`").contains("one-two-x"));
        assert_eq!(named_documents("as `FORMAT.md`, \"x\" or ../a/b.md. not .md"), ["FORMAT.md", "/a/b.md"]);
        assert_eq!(long_lines("short\n| a very long row |\na long line\n    a long line of code", 6).len(), 1);
    }
}
