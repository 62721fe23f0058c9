//! Knobs, tables of knobs, and sets of tables.

use crate::control::Control;
use crate::error::OutOfRange;
use crate::raw::Raw;

/// Declaration of a knob, without a value.
#[derive(Clone, Copy, Debug)]
pub struct Knob {
    /// Full name, `table.key`.
    pub name: &'static str,
    /// Deprecated keys that are still read; written `table.key` if the key was in a different table.
    pub was: &'static [&'static str],
    /// Meaning, with unit and the effect of both ends of the range.
    pub doc: &'static str,
    /// Conditions without which the knob has no effect. `table.key=word` and `table.key!=word` refer to another knob of
    /// the set; the word of an unset knob is `none`. All other conditions are names that the application defines.
    pub needs: &'static [&'static str],
    /// Type and range, such as `a number 0..=1`.
    pub expected: fn() -> String,
    /// Control that shows the knob in a window.
    pub control: fn() -> Control,
    /// Parses a command-line word into an unchecked value.
    pub parse_word: fn(&str) -> Raw,
}

impl Knob {
    /// Returns the name of the table that contains the knob.
    pub fn table(&self) -> &'static str {
        self.name.split_once('.').map_or("", |(table, _)| table)
    }

    /// Returns the key within the table.
    pub fn key(&self) -> &'static str {
        self.name.split_once('.').map_or(self.name, |(_, key)| key)
    }

    /// Whether `table.key` is the current or a deprecated name of the knob.
    pub(crate) fn has_name(&self, table: &str, key: &str) -> bool {
        let is_here = self.table() == table;
        let was = |old: &&str| (is_here && *old == key) || old.split_once('.') == Some((table, key));
        (is_here && self.key() == key) || self.was.iter().any(was)
    }

    /// Returns the knob's value in `set` as TOML; `None` if the value is unset or the set has no such knob.
    pub fn value<S: Tables>(&self, set: &S) -> Option<String> {
        let at = S::TABLES.iter().position(|table| table.name == self.table())?;
        set.tables().get(at)?.write(self.key())
    }
}

/// Values of a table of knobs. Implemented by [`params!`](crate::params).
pub trait Table {
    /// Returns the table's knobs, in the order of declaration.
    fn knobs(&self) -> &'static [Knob];

    /// Sets the value of a key.
    ///
    /// Fails with a message about the value found and the value expected; the table is then unchanged.
    fn read(&mut self, key: &str, raw: &Raw) -> Result<(), String>;

    /// Returns the value of a key as TOML; `None` if it is unset.
    fn write(&self, key: &str) -> Option<String>;

    /// Checks the value of a key against its range.
    ///
    /// Fails with a message about the value found and the value expected.
    fn check(&self, key: &str) -> Result<(), String>;
}

/// Declaration of a table, without values.
#[derive(Clone, Copy, Debug)]
pub struct TableInfo {
    /// Name in a file.
    pub name: &'static str,
    /// Description.
    pub doc: &'static str,
    /// Conditions without which none of the knobs has an effect, except for the knob that a condition names; see
    /// [`Knob::needs`].
    pub needs: &'static [&'static str],
    /// Knobs, in the order of declaration.
    pub knobs: &'static [Knob],
}

impl TableInfo {
    /// Returns the first condition of a knob of this table that is not met; `None` if the knob has an effect.
    ///
    /// * `value`: value of a knob as TOML, by its full name
    /// * `holds`: whether a condition holds that the application defines
    pub fn unmet(
        &self,
        knob: &Knob,
        value: impl Fn(&str) -> Option<String>,
        holds: impl Fn(&str) -> bool,
    ) -> Option<&'static str> {
        let is_word = |name: &str, word: &str| value(name).as_deref().unwrap_or("none").trim_matches('"') == word;
        let is_met = |need: &str| match (need.split_once("!="), need.split_once('=')) {
            (Some((name, word)), _) => !is_word(name, word),
            (None, Some((name, word))) => is_word(name, word),
            (None, None) => holds(need),
        };
        // A table's switch has an effect while it is off.
        let of_table = self.needs.iter().filter(|need| need.split(['!', '=']).next() != Some(knob.name));
        of_table.chain(knob.needs).copied().find(|need| !is_met(need))
    }
}

/// Set of tables in one file. Implemented by [`tables!`](crate::tables).
pub trait Tables: Default {
    /// Declarations of the tables, in the order in which they are written.
    const TABLES: &'static [TableInfo];
    /// Example `key=value` for messages.
    const EXAMPLE: &'static str;

    /// Returns the tables, in the order of [`Self::TABLES`].
    fn tables(&self) -> Vec<&dyn Table>;

    /// Returns the tables mutably, in the same order.
    fn tables_mut(&mut self) -> Vec<&mut dyn Table>;

    /// Returns the reason why a table or `table.key` is unavailable in this build although another build knows it.
    /// `None` (default) if the name is simply a mistake.
    fn unavailable_reason(_name: &str) -> Option<String> {
        None
    }
}

/// Returns every knob of a set, in order.
pub fn knobs<S: Tables>() -> impl Iterator<Item = &'static Knob> {
    S::TABLES.iter().flat_map(|table| table.knobs)
}

/// Returns the knob with the current or deprecated name `table.key`.
pub(crate) fn knob_named<S: Tables>(name: &str) -> Option<&'static Knob> {
    let (table, key) = name.split_once('.')?;
    knobs::<S>().find(|knob| knob.has_name(table, key))
}

/// Checks every value of a set against its range.
///
/// Fails with the first value outside its range.
pub fn validate<S: Tables>(set: &S) -> Result<(), OutOfRange> {
    set.tables().into_iter().try_for_each(validate_table)
}

/// Checks every value of a table against its range.
///
/// Fails with the first value outside its range.
pub fn validate_table(table: &dyn Table) -> Result<(), OutOfRange> {
    table
        .knobs()
        .iter()
        .try_for_each(|knob| table.check(knob.key()).map_err(|reason| OutOfRange { name: knob.name, reason }))
}

/// Whether two names are equal, as a `const fn` for the compile-time check of [`tables!`](crate::tables).
pub const fn str_eq(a: &str, b: &str) -> bool {
    let (a, b) = (a.as_bytes(), b.as_bytes());
    let mut i = 0;
    while i < a.len() && i < b.len() && a[i] == b[i] {
        i += 1;
    }
    a.len() == b.len() && i == a.len()
}
