//! Reading, setting and writing sets of tables.

use crate::error::ParamError;
use crate::knob::{Knob, Tables, knob_named, knobs};
use crate::nearest::nearest;
use crate::raw::Raw;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// TOML text without the byte order mark that some editors write, with byte positions in the original.
struct Source<'a> {
    text: &'a str,
    body: &'a str,
}

impl<'a> Source<'a> {
    fn new(text: &'a str) -> Self {
        Self { text, body: text.strip_prefix('\u{feff}').unwrap_or(text) }
    }

    fn parse(&self) -> Result<Spanned<DeTable<'a>>, ParamError> {
        let broken = |e: toml::de::Error| self.fail(e.span().map_or(0, |s| s.start), "", e.message().trim().to_owned());
        DeTable::parse(self.body).map_err(broken)
    }

    /// Returns an error at offset `byte` of the body.
    fn fail(&self, byte: usize, key: &str, reason: String) -> ParamError {
        let before = self.text.len() - self.body.len() + byte;
        let line = self.text.bytes().take(before).filter(|b| *b == b'\n').count() + 1;
        ParamError { line: Some(line), key: key.to_owned(), reason }
    }
}

/// Reads a TOML text: keys in the text are set, everything else keeps its value.
///
/// Fails with line and key of malformed TOML, an unknown table or key, a wrong type or a value outside its range. Keys
/// before the error are already set.
pub fn read<S: Tables>(set: &mut S, text: &str) -> Result<(), ParamError> {
    let source = Source::new(text);
    for (name, value) in source.parse()?.get_ref() {
        let fault = |at: usize, fault: ParamError| source.fail(at, &fault.key, fault.reason);
        let at = name.span().start;
        match value.get_ref() {
            DeValue::Table(entries) if has_table::<S>(name.get_ref()) => {
                for (key, value) in entries {
                    read_key(set, name.get_ref(), key.get_ref(), &Raw::from_de(value.get_ref()))
                        .map_err(|error| fault(key.span().start, error))?;
                }
            }
            other => return Err(fault(at, not_a_table::<S>(name.get_ref(), &Raw::from_de(other)))),
        }
    }
    Ok(())
}

/// Reads a parsed table like [`read`], such as one inside another file.
///
/// Fails like [`read`], without a line.
pub fn read_table<S: Tables>(set: &mut S, document: &toml::Table) -> Result<(), ParamError> {
    for (name, value) in document {
        match value {
            toml::Value::Table(entries) if has_table::<S>(name) => {
                for (key, value) in entries {
                    read_key(set, name, key, &Raw::from_value(value))?;
                }
            }
            other => return Err(not_a_table::<S>(name, &Raw::from_value(other))),
        }
    }
    Ok(())
}

fn has_table<S: Tables>(name: &str) -> bool {
    S::TABLES.iter().any(|table| table.name == name)
}

/// Returns the error for a top-level entry that is not one of the tables.
fn not_a_table<S: Tables>(name: &str, found: &Raw) -> ParamError {
    let reason = if has_table::<S>(name) { found.unexpected("a table") } else { unknown_table::<S>(name) };
    ParamError { line: None, key: name.to_owned(), reason }
}

fn read_key<S: Tables>(set: &mut S, table: &str, key: &str, raw: &Raw) -> Result<(), ParamError> {
    let name = format!("{table}.{key}");
    let fail = |reason: String| ParamError { line: None, key: name.clone(), reason };
    let knob = knob_named::<S>(&name).ok_or_else(|| fail(unknown_key::<S>(&name)))?;
    let at = S::TABLES.iter().position(|table| table.name == knob.table());
    let values = at.and_then(|at| set.tables_mut().into_iter().nth(at));
    values.map_or(Ok(()), |values| values.read(knob.key(), raw)).map_err(fail)
}

/// Sets one value, as in `hair.length_m=0.02`. Strings need no quotes: `hair.style=curly`.
///
/// Fails like [`read`], without a line; the set is then unchanged.
pub fn set<S: Tables>(set: &mut S, assignment: &str) -> Result<(), ParamError> {
    let Some((name, word)) = assignment.split_once('=') else {
        let reason = format!("found no '=', expected key=value, such as {}", S::EXAMPLE);
        return Err(ParamError { line: None, key: assignment.to_owned(), reason });
    };
    set_word(set, name.trim(), word.trim())
}

/// Sets the value of one key from a word of a command line.
///
/// Fails like [`set`].
pub fn set_word<S: Tables>(set: &mut S, name: &str, word: &str) -> Result<(), ParamError> {
    let fail = |reason: String| ParamError { line: None, key: name.to_owned(), reason };
    let knob = knob_named::<S>(name).ok_or_else(|| fail(unknown_key::<S>(name)))?;
    read_key(set, knob.table(), knob.key(), &(knob.parse_word)(word)).map_err(|error| fail(error.reason))
}

/// Returns the set as TOML with every key that has a value, in the order of declaration. Reading it gives an equal set.
pub fn to_toml<S: Tables>(set: &S) -> String {
    write(set, |_, _| String::new())
}

/// Returns the set as TOML like [`to_toml`], with each key's meaning, type and range as comments. Keys without a value
/// are commented out.
pub fn to_documented_toml<S: Tables>(set: &S) -> String {
    to_noted_toml(set, |_| Vec::new())
}

/// Returns the set as TOML like [`to_documented_toml`], with the lines of `note` as further comments directly above
/// each key.
pub fn to_noted_toml<S: Tables>(set: &S, note: impl Fn(&Knob) -> Vec<String>) -> String {
    write(set, |knob, value| {
        let mut lines = String::new();
        for line in knob.doc.lines().map(str::trim) {
            lines += &format!("# {line}\n");
        }
        lines += &format!("# Expects {}.\n", (knob.expected)());
        for line in note(knob).iter().flat_map(|note| note.lines()) {
            lines += &format!("# {line}\n");
        }
        if value.is_none() {
            lines += &format!("# {} =\n", knob.key());
        }
        lines
    })
}

fn write<S: Tables>(set: &S, comment: impl Fn(&Knob, Option<&str>) -> String) -> String {
    let mut text = String::new();
    for (info, table) in S::TABLES.iter().zip(set.tables()) {
        let gap = if text.is_empty() { "" } else { "\n" };
        text += &format!("{gap}[{}]\n", info.name);
        for knob in info.knobs {
            let value = table.write(knob.key());
            text += &comment(knob, value.as_deref());
            if let Some(value) = value {
                text += &format!("{} = {value}\n", knob.key());
            }
        }
    }
    text
}

fn unknown_table<S: Tables>(name: &str) -> String {
    if let Some(reason) = S::unavailable_reason(name) {
        return reason;
    }
    let all: Vec<_> = S::TABLES.iter().map(|table| table.name).collect();
    match nearest(name, all.iter().copied()) {
        Some(near) => format!("unknown table; did you mean [{near}]? Tables: {}", all.join(", ")),
        None => format!("unknown table, expected one of {}", all.join(", ")),
    }
}

fn unknown_key<S: Tables>(name: &str) -> String {
    if let Some(reason) = S::unavailable_reason(name) {
        return reason;
    }
    let (table, key) = name.split_once('.').unwrap_or(("", name));
    // First try the name as a key without its unit, then as a key under the wrong table.
    let whole = knobs::<S>().find(|k| k.name.strip_prefix(name).is_some_and(|rest| rest.starts_with('_')));
    let moved = knobs::<S>().find(|k| k.key() == key);
    let known = S::TABLES.iter().find(|info| info.name == table);
    let near = whole.or(moved).map(|k| k.name).or_else(|| {
        match known {
            Some(info) => nearest(key, info.knobs.iter().map(Knob::key))
                .and_then(|near| info.knobs.iter().find(|k| k.key() == near))
                .map(|k| k.name),
            // Also compare a name that has no table with the bare keys.
            None => nearest(name, knobs::<S>().map(|k| k.name)).or_else(|| {
                let near = nearest(key, knobs::<S>().map(Knob::key))?;
                knobs::<S>().find(|k| k.key() == near).map(|k| k.name)
            }),
        }
    });
    match (near, known) {
        (Some(near), _) => format!("unknown key; did you mean {near}?"),
        (None, Some(info)) => {
            let keys: Vec<_> = info.knobs.iter().map(Knob::key).collect();
            format!("unknown key; {table} has {}", keys.join(", "))
        }
        (None, None) => {
            format!("unknown key, expected one such as {}", S::EXAMPLE.split('=').next().unwrap_or_default())
        }
    }
}
