//! Knobs, tables of them, and sets of tables.

use crate::control::Control;
use crate::error::OutOfRange;
use crate::raw::Raw;

/// What is known of a knob without a value of it.
#[derive(Clone, Copy, Debug)]
pub struct Knob {
    /// `table.key`.
    pub name: &'static str,
    /// Its key in earlier files, which are still read; `table.key` where the table was another.
    pub was: &'static [&'static str],
    /// What it means, with unit and what the ends of the range do.
    pub doc: &'static str,
    /// Type and range, such as `a number 0..=1`.
    pub expected: fn() -> String,
    /// How a window shows it.
    pub control: fn() -> Control,
    /// What a word of a command line stands for.
    pub raw_of_word: fn(&str) -> Raw,
}

impl Knob {
    /// The table that it stands in.
    pub fn table(&self) -> &'static str {
        self.name.split_once('.').map_or("", |(table, _)| table)
    }

    /// Its key there.
    pub fn key(&self) -> &'static str {
        self.name.split_once('.').map_or(self.name, |(_, key)| key)
    }

    /// Whether `table.key` names it, or did in earlier files.
    pub(crate) fn answers_to(&self, table: &str, key: &str) -> bool {
        let is_here = self.table() == table;
        let was = |old: &&str| (is_here && *old == key) || old.split_once('.') == Some((table, key));
        (is_here && self.key() == key) || self.was.iter().any(was)
    }

    /// Its value in `set` as TOML, or `None` where it is left out, or the set has no such knob.
    pub fn value<S: Tables>(&self, set: &S) -> Option<String> {
        let at = S::TABLES.iter().position(|table| table.name == self.table())?;
        set.tables().get(at)?.write(self.key())
    }
}

/// Values of a table of knobs; [`params!`](crate::params) makes one.
pub trait Table {
    /// Its knobs, in the order of declaration.
    fn knobs(&self) -> &'static [Knob];

    /// Sets one.
    ///
    /// # Errors
    /// What was found and what was expected; nothing is changed then.
    fn read(&mut self, key: &str, raw: &Raw) -> Result<(), String>;

    /// The value of one as TOML, or `None` where it is left out.
    fn write(&self, key: &str) -> Option<String>;

    /// Whether one is in its range.
    ///
    /// # Errors
    /// What was found and what was expected.
    fn check(&self, key: &str) -> Result<(), String>;
}

/// What is known of a table without values.
#[derive(Clone, Copy, Debug)]
pub struct TableInfo {
    /// Its name in a file.
    pub name: &'static str,
    /// What it is about.
    pub doc: &'static str,
    /// Its knobs, in the order of declaration.
    pub knobs: &'static [Knob],
}

/// Tables that stand in one file; [`tables!`](crate::tables) makes it.
pub trait Tables: Default {
    /// What is known of the tables, in the order in which they are written.
    const TABLES: &'static [TableInfo];
    /// A `key=value` for messages.
    const EXAMPLE: &'static str;

    /// The tables, in the order of [`Self::TABLES`].
    fn tables(&self) -> Vec<&dyn Table>;

    /// The tables, to be changed, in the same order.
    fn tables_mut(&mut self) -> Vec<&mut dyn Table>;

    /// Reason why a table or `table.key` is unknown here and would be known to another build;
    /// `None` (default) for a mistake.
    fn elsewhere(_name: &str) -> Option<String> {
        None
    }
}

/// Every knob of a set in order.
pub fn knobs<S: Tables>() -> impl Iterator<Item = &'static Knob> {
    S::TABLES.iter().flat_map(|table| table.knobs)
}

/// The knob of that name, `table.key`, whether it is called so or was.
pub(crate) fn knob_named<S: Tables>(name: &str) -> Option<&'static Knob> {
    let (table, key) = name.split_once('.')?;
    knobs::<S>().find(|knob| knob.answers_to(table, key))
}

/// Checks every value of a set against its range.
///
/// # Errors
/// The first that is outside.
pub fn validate<S: Tables>(set: &S) -> Result<(), OutOfRange> {
    set.tables().into_iter().try_for_each(validate_table)
}

/// Checks every value of a table against its range.
///
/// # Errors
/// The first that is outside.
pub fn validate_table(table: &dyn Table) -> Result<(), OutOfRange> {
    table
        .knobs()
        .iter()
        .try_for_each(|knob| table.check(knob.key()).map_err(|reason| OutOfRange { name: knob.name, reason }))
}

/// Whether two names are one; what [`tables!`](crate::tables) asks while it is compiled.
pub const fn same(a: &str, b: &str) -> bool {
    let (a, b) = (a.as_bytes(), b.as_bytes());
    let mut i = 0;
    while i < a.len() && i < b.len() && a[i] == b[i] {
        i += 1;
    }
    a.len() == b.len() && i == a.len()
}
