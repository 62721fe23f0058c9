//! Journal of measured rows, kept until the table is complete, so that an interrupted chart continues where it stopped.
//!
//! `TOPIC.rows.jsonl` beside the table has a line for each row, `{"key": …, "row": 3, "cells": […]}`. Lines with
//! another key belong to another model, recipe, tool or adapter. A truncated line is ignored.

use crate::chart::Cell;
use pelage_tool::exit::Failure;
use pelage_tool::journal::{Entry, Journal};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::path::Path;

/// Rows measured so far.
#[derive(Debug)]
pub struct Rows(Journal<Row>);

#[derive(Debug, Serialize, Deserialize)]
struct Row {
    row: usize,
    cells: Vec<Value>,
}

impl Entry for Row {
    fn number(&self) -> usize {
        self.row
    }
}

impl Rows {
    /// Reads the rows that an earlier run left in `folder`; see [`Journal::open`].
    pub fn open(folder: &Path, topic: &str, key: &str, restart: bool) -> Result<Self, Failure> {
        Journal::open(folder.join(format!("{topic}.rows.jsonl")), key, restart).map(Self)
    }

    /// Adds the rows of another machine's file, which is not modified. Returns how many of them belong to another
    /// model, recipe, tool or adapter.
    pub fn take(&mut self, path: &Path) -> Result<usize, Failure> {
        self.0.import(path)
    }

    /// Returns the path of the journal file.
    pub fn path(&self) -> &Path {
        self.0.path()
    }

    /// Returns the figures of a row, if an earlier run measured it.
    pub fn cells(&self, number: usize) -> Option<Vec<Cell>> {
        self.0.get(number)?.cells.iter().map(read).collect()
    }

    /// Returns the number of rows found for another model, recipe, tool or adapter.
    pub fn others(&self) -> usize {
        self.0.others()
    }

    /// Saves a row. Once this returns, the row survives an abort of the process.
    pub fn add(&mut self, number: usize, cells: &[Cell]) -> Result<(), Failure> {
        self.0.add(Row { row: number, cells: cells.iter().map(write).collect() })
    }

    /// Removes the journal if it holds only the rows `written`; see [`Journal::finish`].
    pub fn finish(self, written: &[usize]) -> Result<(), Failure> {
        self.0.finish(written)
    }
}

/// Converts a cell without loss. Numbers that are not finite, which JSON cannot represent, become an object.
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;

    fn cells(x: f64) -> Vec<Cell> {
        vec![Cell::Number(x), Cell::Text("a \"b\"\n".into()), Cell::Empty]
    }

    fn numbers(rows: &Rows) -> Vec<usize> {
        (0..9).filter(|number| rows.cells(*number).is_some()).collect()
    }

    #[test]
    fn rows_survive_a_killed_run() {
        let folder = tempfile::tempdir().unwrap();
        let open = |key: &str, restart| Rows::open(folder.path(), "t", key, restart).unwrap();
        let path = folder.path().join("t.rows.jsonl");
        assert!(numbers(&open("a", false)).is_empty() && !path.exists());
        let values = [0.1 + 0.2, f64::NEG_INFINITY, 1e-300, 3.0];
        let mut journal = open("a", false);
        values.iter().enumerate().for_each(|(i, x)| journal.add(i + 1, &cells(*x)).unwrap());
        // Simulates an interruption within a line.
        drop(journal);
        let whole = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, &whole[..whole.len() - 5]).unwrap();
        let mut journal = open("a", false);
        assert_eq!(numbers(&journal), [1, 2, 3]);
        assert!(values[..3].iter().enumerate().all(|(i, x)| journal.cells(i + 1) == Some(cells(*x))));
        // A row added afterwards does not continue the truncated line.
        journal.add(4, &cells(f64::NAN)).unwrap();
        let again = open("a", false);
        assert_eq!(numbers(&again).len(), 4);
        assert!(matches!(again.cells(4).unwrap()[0], Cell::Number(x) if x.is_nan()));
        // Finishing a table of two of the rows must keep the other rows.
        again.finish(&[1, 2]).unwrap();
        assert_eq!(numbers(&open("a", false)).len(), 4);
        open("a", false).finish(&[1, 2, 3, 4]).unwrap();
        assert!(!path.exists());
    }

    #[test]
    fn rows_of_another_model_are_ignored() {
        let folder = tempfile::tempdir().unwrap();
        let open = |key: &str, restart| Rows::open(folder.path(), "t", key, restart).unwrap();
        open("a", false).add(1, &cells(1.0)).unwrap();
        assert_eq!(numbers(&open("a", false)).len(), 1);
        assert!(numbers(&open("b", false)).is_empty());
        open("b", false).add(1, &cells(2.0)).unwrap();
        assert_eq!(numbers(&open("b", true)).len(), 0);
        assert!(numbers(&open("b", false)).is_empty());
    }
}
