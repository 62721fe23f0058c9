//! Checks the language of the sources: counts banned first words of comments and banned phrases per folder, and finds
//! long lines.
//!
//! `language.txt` holds the committed counts. The test fails if a count rises. A count that has fallen must be lowered
//! in the file, so that it cannot rise again. Long lines are not allowed at all.

use pelage_tests::binary::workspace;
use pelage_tests::documents::{Document, documents, long_lines, tracked_texts};
use std::collections::BTreeMap;

/// Words that no comment, and no paragraph of one, may begin with.
const FIRST_WORDS: [&str; 10] = ["What", "Who", "Whoever", "Of", "As", "That", "It", "Its", "One", "Another"];

/// Phrases that comments and documents avoid.
const PHRASES: [&str; 11] = [
    "anew",
    "whoever",
    "of late",
    "hangs on",
    "hang on",
    "in the place of",
    "what it is about",
    "is told",
    "are told",
    "dearer",
    "dearest",
];

/// Largest number of characters in a line of a text file.
const COLUMNS: usize = 120;

/// Endings of files that may have longer lines, because programs write them.
const DATA: [&str; 6] = [".json", ".lock", ".svg", ".csv", ".pelage", "proptest-regressions/recipe/tests.txt"];

/// Text in documents that are generated from comments in the code. Their lines are slightly longer than the comments.
const GENERATED: &str = "\nThis page is made from ";

/// Files with quotations or word lists, in which phrases are not counted.
const QUOTING: [&str; 1] = ["tests/tests/house/language.rs"];

/// Counts of one folder.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Counts {
    /// Number of doc comments that begin with one of [`FIRST_WORDS`].
    first_words: usize,
    /// Number of lines in comments or documents that contain one of [`PHRASES`].
    phrases: usize,
}

/// Returns the marker and the text of a comment line.
fn comment(line: &str) -> Option<(&str, &str)> {
    let line = line.trim_start();
    ["///", "//!", "//"].into_iter().find_map(|marker| Some((marker, line.strip_prefix(marker)?)))
}

/// Returns true if the text contains the phrase as whole words.
fn contains_phrase(text: &str, phrase: &str) -> bool {
    let bounded = |end: Option<char>| !end.is_some_and(|c| c.is_alphanumeric() || c == '_');
    text.match_indices(phrase)
        .any(|(at, _)| bounded(text[..at].chars().next_back()) && bounded(text[at + phrase.len()..].chars().next()))
}

fn counts(document: &Document) -> Counts {
    let mut counts = Counts::default();
    let markdown = document.path.ends_with(".md");
    let (mut marker_before, mut ends_paragraph) = ("", false);
    for line in document.text.lines() {
        let (marker, text) = if markdown { ("", line) } else { comment(line).unwrap_or_default() };
        let text = text.trim_start();
        if !marker.is_empty() && (marker != marker_before || ends_paragraph) {
            let first = text.split(|c: char| !c.is_alphanumeric()).next().unwrap_or_default();
            counts.first_words += usize::from(FIRST_WORDS.contains(&first));
        }
        (marker_before, ends_paragraph) = (marker, text.is_empty());
        let text = text.to_lowercase();
        if !QUOTING.contains(&document.path.as_str()) && PHRASES.iter().any(|phrase| contains_phrase(&text, phrase)) {
            counts.phrases += 1;
        }
    }
    counts
}

/// Returns the folder that a file is counted for: the folder of its crate, or `documents`.
fn folder(path: &str) -> String {
    if path.ends_with(".md") {
        return "documents".into();
    }
    let mut parts = path.split('/');
    let first = parts.next().unwrap_or_default();
    match parts.next() {
        Some(second) if first != "formats" && second != "src" => format!("{first}/{second}"),
        _ => first.to_owned(),
    }
}

fn table(all: &BTreeMap<String, Counts>) -> String {
    let rows = all.iter().map(|(folder, c)| format!("{folder} {} {}\n", c.first_words, c.phrases));
    format!("# folder, first words, phrases\n{}", rows.collect::<String>())
}

#[test]
fn language_faults_only_become_fewer() {
    let mut all = BTreeMap::<String, Counts>::new();
    for document in documents(&["rs", "wgsl", "md"]) {
        let found = counts(&document);
        let sum = all.entry(folder(&document.path)).or_default();
        sum.first_words += found.first_words;
        sum.phrases += found.phrases;
    }
    let path = workspace().join("tests/tests/house/language.txt");
    let committed = std::fs::read_to_string(&path).unwrap_or_default();
    let counted = table(&all);
    assert_eq!(
        committed,
        counted,
        "{}: a count rose (fix the text), or fell (write the new count)\n{counted}",
        path.display()
    );
}

/// Returns the long lines of a file as `path:line`. Tables, pictures and code in Markdown are exempt.
fn long(document: &Document) -> Vec<String> {
    let Document { path, text } = document;
    let markdown = path.ends_with(".md");
    if DATA.iter().any(|ending| path.ends_with(ending)) || (markdown && text.contains(GENERATED)) {
        return Vec::new();
    }
    let lines: Vec<usize> = if markdown {
        long_lines(text, COLUMNS).into_iter().map(|(line, _)| line).collect()
    } else {
        (1..).zip(text.lines()).filter(|(_, text)| text.chars().count() > COLUMNS).map(|(line, _)| line).collect()
    };
    lines.iter().map(|line| format!("{path}:{line}")).collect()
}

#[test]
fn no_line_is_over_120_columns() {
    let all = tracked_texts();
    assert!(all.len() > 1000, "only {} text files", all.len());
    let found: Vec<String> = all.iter().flat_map(long).collect();
    assert!(found.is_empty(), "lines of over {COLUMNS} columns: {found:#?}");
}

#[test]
fn each_language_rule_detects_its_fault() {
    let text =
        "//! Of its bytes.\n\n/// Reads a file.\n/// It is whole.\nfn a() {}\n// made anew, whoever asks\n// renewed";
    let document = |path: &str, text: String| Document { path: path.into(), text };
    assert_eq!(counts(&document("bake/src/lib.rs", text.into())), Counts { first_words: 1, phrases: 1 });
    assert_eq!(counts(&document("a.rs", "// One ball.\n//\n// That is all.".into())).first_words, 2);
    assert_eq!(counts(&document("README.md", "It is dearer.\n".into())).phrases, 1);
    let wide = |path: &str| long(&document(path, format!("{:120}\n{:121}", "", "ä")));
    assert_eq!(wide("run"), ["run:2"]);
    assert!(wide("a.json").is_empty());
    assert_eq!(long(&document("README.md", format!("| {:121}\n{:121}", "", "ä"))), ["README.md:2"]);
    assert_eq!(folder("runtime/stage/src/lib.rs"), "runtime/stage");
    assert_eq!(folder("runtime/src/lib.rs"), "runtime");
    assert_eq!(folder("formats/params/src/lib.rs"), "formats");
}
