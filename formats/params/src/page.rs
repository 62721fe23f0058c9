//! Reference page of a set of tables.

use crate::control::Control;
use crate::knob::{Knob, Tables};

/// Maximum line width of a page.
const COLUMNS: usize = 120;

/// Returns all keys of a set as Markdown. Each table has a heading and its description; each key has an entry with
/// default, type, range, meaning, and the meanings of its words.
///
/// * `title`, `introduction`: heading and paragraphs at the top
/// * `picture`: Markdown line that illustrates a key, for keys that have one
///
/// Lines are at most 120 columns wide where words allow it.
pub fn reference_page<S: Tables>(
    title: &str,
    introduction: &[&str],
    picture: impl Fn(&str) -> Option<String>,
) -> String {
    let defaults = S::default();
    let mut page = format!("# {title}\n");
    for paragraph in introduction {
        page += &format!("\n{}\n", wrap("", paragraph));
    }
    for (info, values) in S::TABLES.iter().zip(defaults.tables()) {
        let doc = one_line(info.doc);
        // The struct's documentation begins with the table's name, which the heading already shows.
        let doc = doc.strip_prefix(&format!("`[{}]`: ", info.name)).unwrap_or(&doc);
        page += &format!("\n## `[{}]`\n\n{}\n", info.name, wrap("", &capital(doc)));
        for knob in info.knobs {
            page += &entry(knob, values.write(knob.key()));
            if let Some(line) = picture(knob.name) {
                page += &format!("\n  {line}\n");
            }
        }
    }
    page
}

fn entry(knob: &Knob, default: Option<String>) -> String {
    let default = default.map_or("left out".to_owned(), |value| format!("`{value}`"));
    let head = format!("**`{}`**: {}; default {default}.", knob.key(), (knob.expected)());
    let mut entry = format!("\n- {}\n{}\n", wrap("  ", &head), indented(&one_line(knob.doc)));
    let mut item = |text: String| entry += &format!("  - {}\n", wrap("    ", &text));
    match (knob.control)() {
        Control::Choice(choices) => choices.iter().for_each(|c| item(format!("`{}`: {}", c.word, one_line(c.doc)))),
        Control::Tables(keys) => {
            for k in keys {
                let default = (k.default)().map_or_else(String::new, |value| format!("; default `{value}`"));
                item(format!("`{}`: {}{default}. {}", k.name, (k.expected)(), one_line(k.doc)));
            }
        }
        _ => (),
    }
    entry
}

fn indented(text: &str) -> String {
    format!("  {}", wrap("  ", text))
}

fn one_line(doc: &str) -> String {
    doc.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// Breaks a text at spaces into lines of at most 120 columns. All lines but the first begin with `indent`; the first
/// leaves room for an indent of that width. No line begins with a character that Markdown reads as a list or heading.
pub fn wrap(indent: &str, text: &str) -> String {
    let mut lines = vec![String::new()];
    for word in text.split(' ') {
        let line = lines.last().map_or(0, |line| line.chars().count());
        let long = indent.len() + 2 + line + 1 + word.chars().count() > COLUMNS;
        match lines.last_mut() {
            Some(line) if line.is_empty() || !long || word.starts_with(['-', '+', '*', '#']) => {
                if !line.is_empty() {
                    line.push(' ');
                }
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines.join(&format!("\n{indent}"))
}
