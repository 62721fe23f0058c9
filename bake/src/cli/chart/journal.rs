//! Rows that are measured, kept until the table is whole: a chart that was killed goes on where it stopped.
//!
//! `TOPIC.rows.jsonl` beside the table holds a line for each, `{"key": …, "row": 3, "cells": […]}`. Lines with another key are of another model, recipe,
//! tool or adapter, and a line that was cut off is none.

use crate::cli::exit::Failure;
use pelage_bake::BakeError;
use pelage_bake::chart::Cell;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

/// The rows so far.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    key: String,
    rows: BTreeMap<usize, Vec<Cell>>,
    file: Option<File>,
}

impl Journal {
    /// Reads what an earlier run left in `folder`.
    ///
    /// * `key`: stands for everything that a row depends on
    /// * `restart`: forgets what is there
    pub fn open(folder: &Path, topic: &str, key: &str, restart: bool) -> Result<Self, Failure> {
        let path = folder.join(format!("{topic}.rows.jsonl"));
        let fail = |action| move |path: &Path, source| Failure::from(io_error(path, action, source));
        let text = match std::fs::read_to_string(&path) {
            Ok(text) if !restart => text,
            Ok(_) => String::new(),
            Err(error) if error.kind() == io::ErrorKind::NotFound => String::new(),
            Err(error) => return Err(fail("read")(&path, error)),
        };
        let lines = text.split_inclusive('\n').filter(|line| line.ends_with('\n'));
        let rows: BTreeMap<usize, Vec<Cell>> = lines.filter_map(|line| parse(line, key)).collect();
        let mut journal = Self { path, key: key.to_owned(), rows, file: None };
        // Written anew, so that it holds what counts and nothing that was cut off.
        if !text.is_empty() || restart {
            journal.remove()?;
            let rows = std::mem::take(&mut journal.rows);
            rows.into_iter().try_for_each(|(number, cells)| journal.add(number, &cells))?;
        }
        Ok(journal)
    }

    /// The figures of a row, where an earlier run has measured it.
    pub fn cells(&self, number: usize) -> Option<&Vec<Cell>> {
        self.rows.get(&number)
    }

    /// Notes a row down; when this returns, it outlives the process.
    pub fn add(&mut self, number: usize, cells: &[Cell]) -> Result<(), Failure> {
        let line = json!({ "key": self.key, "row": number, "cells": cells.iter().map(write).collect::<Vec<_>>() });
        let fail = |source| Failure::from(io_error(&self.path, "write", source));
        if self.file.is_none() {
            let opened = OpenOptions::new().create(true).append(true).open(&self.path).map_err(fail)?;
            self.file = Some(opened);
        }
        if let Some(file) = &mut self.file {
            file.write_all(format!("{line}\n").as_bytes()).and_then(|()| file.sync_data()).map_err(fail)?;
        }
        self.rows.insert(number, cells.to_vec());
        Ok(())
    }

    /// Removes the journal where `written`, the rows of the table that was just written, are all that it holds. A run for a few rows must not take from a
    /// whole one what that has measured so far.
    pub fn finish(mut self, written: &[usize]) -> Result<(), Failure> {
        if self.rows.keys().all(|number| written.contains(number)) { self.remove() } else { Ok(()) }
    }

    fn remove(&mut self) -> Result<(), Failure> {
        self.file = None;
        match std::fs::remove_file(&self.path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(io_error(&self.path, "remove", error).into()),
            _ => Ok(()),
        }
    }
}

fn io_error(path: &Path, action: &'static str, source: io::Error) -> BakeError {
    BakeError::Io { path: path.to_owned(), action, source }
}

/// A cell, to the last bit: JSON has no word for what is not finite, so that is an object.
fn write(cell: &Cell) -> Value {
    match cell {
        Cell::Number(x) if !x.is_finite() => json!({ "number": x.to_string() }),
        Cell::Number(x) => json!(x),
        Cell::Text(text) => json!(text),
        Cell::Empty => Value::Null,
    }
}

fn read(value: &Value) -> Option<Cell> {
    Some(match value {
        Value::Null => Cell::Empty,
        Value::String(text) => Cell::Text(text.clone()),
        Value::Object(object) => Cell::Number(object.get("number")?.as_str()?.parse().ok()?),
        other => Cell::Number(other.as_f64()?),
    })
}

fn parse(line: &str, key: &str) -> Option<(usize, Vec<Cell>)> {
    let line: Value = serde_json::from_str(line).ok()?;
    if line["key"] != key {
        return None;
    }
    let cells: Option<Vec<Cell>> = line["cells"].as_array()?.iter().map(read).collect();
    Some((usize::try_from(line["row"].as_u64()?).ok()?, cells?))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
    use super::*;

    fn cells(x: f64) -> Vec<Cell> {
        vec![Cell::Number(x), Cell::Text("a \"b\"\n".into()), Cell::Empty]
    }

    #[test]
    fn rows_outlive_a_run_that_was_killed() {
        let folder = tempfile::tempdir().unwrap();
        let open = |key: &str, restart| Journal::open(folder.path(), "t", key, restart).unwrap();
        let path = folder.path().join("t.rows.jsonl");
        assert!(open("a", false).rows.is_empty() && !path.exists());
        let values = [0.1 + 0.2, f64::NEG_INFINITY, 1e-300, 3.0];
        let mut journal = open("a", false);
        values.iter().enumerate().for_each(|(i, x)| journal.add(i + 1, &cells(*x)).unwrap());
        // Killed within a line.
        drop(journal);
        let whole = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, &whole[..whole.len() - 5]).unwrap();
        let mut journal = open("a", false);
        assert_eq!(journal.rows.keys().copied().collect::<Vec<_>>(), [1, 2, 3]);
        assert!(values[..3].iter().enumerate().all(|(i, x)| journal.cells(i + 1) == Some(&cells(*x))));
        // What is added then is no continuation of the line that was cut off.
        journal.add(4, &cells(f64::NAN)).unwrap();
        let again = open("a", false);
        assert_eq!(again.rows.len(), 4);
        assert!(matches!(again.cells(4).unwrap()[0], Cell::Number(x) if x.is_nan()));
        // A table of two of the rows leaves the others.
        again.finish(&[1, 2]).unwrap();
        assert_eq!(open("a", false).rows.len(), 4);
        open("a", false).finish(&[1, 2, 3, 4]).unwrap();
        assert!(!path.exists());
    }

    #[test]
    fn rows_of_another_model_do_not_count() {
        let folder = tempfile::tempdir().unwrap();
        let open = |key: &str, restart| Journal::open(folder.path(), "t", key, restart).unwrap();
        open("a", false).add(1, &cells(1.0)).unwrap();
        assert_eq!(open("a", false).rows.len(), 1);
        assert!(open("b", false).rows.is_empty());
        open("b", false).add(1, &cells(2.0)).unwrap();
        assert_eq!(open("b", true).rows.len(), 0);
        assert!(open("b", false).rows.is_empty());
    }
}
