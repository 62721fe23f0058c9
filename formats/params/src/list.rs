//! List values.

use crate::control::{Control, TableKey};
use crate::field::Field;
use crate::raw::Raw;

/// Type of a list entry. If `T` implements it, `Vec<T>` is a [`Field`].
pub trait Item: Sized {
    /// Whether a single entry may be written without brackets.
    const ALLOW_SINGLE: bool;
    /// Keys of the entries, if they are tables.
    const KEYS: &'static [TableKey] = &[];

    /// Returns a description of the list, in words.
    fn expected_list() -> String;

    /// Returns the name of an entry in messages.
    fn entry_name(index: usize, raw: &Raw) -> String {
        let _ = raw;
        format!("entry {index}")
    }

    /// Converts `raw` to an entry.
    ///
    /// Fails with the reason; `None` if [`Self::expected_list`] already says everything.
    fn read(raw: &Raw) -> Result<Self, Option<String>>;

    /// Whether the value is allowed in a list.
    fn in_range(&self) -> bool;

    /// Returns the value as TOML.
    fn to_toml(&self) -> String;
}

impl<T: Item> Field for Vec<T> {
    type Range = ();

    fn expected((): &()) -> String {
        T::expected_list()
    }

    fn control((): &()) -> Control {
        if T::KEYS.is_empty() { Control::Text } else { Control::Tables(T::KEYS) }
    }

    fn from_raw(raw: &Raw) -> Option<Self> {
        Self::read(raw, &()).ok()
    }

    fn in_range(&self, (): &()) -> bool {
        self.iter().all(T::in_range)
    }

    fn to_toml(&self) -> Option<String> {
        Some(format!("[{}]", self.iter().map(T::to_toml).collect::<Vec<_>>().join(", ")))
    }

    fn read(raw: &Raw, (): &()) -> Result<Self, String> {
        let whole = || raw.unexpected(&T::expected_list());
        let items = match raw {
            Raw::Array(items) => items.as_slice(),
            one if T::ALLOW_SINGLE => std::slice::from_ref(one),
            _ => return Err(whole()),
        };
        let mut list = Self::new();
        for (i, item) in items.iter().enumerate() {
            let read = T::read(item);
            list.push(read.map_err(|reason| {
                reason.map_or_else(whole, |reason| format!("{}: {reason}", T::entry_name(i, item)))
            })?);
        }
        if list.iter().all(T::in_range) { Ok(list) } else { Err(whole()) }
    }
}

/// List entries that are names.
impl Item for String {
    const ALLOW_SINGLE: bool = true;

    fn expected_list() -> String {
        "a list of strings".into()
    }

    fn read(raw: &Raw) -> Result<Self, Option<String>> {
        Self::from_raw(raw).ok_or(None)
    }

    fn in_range(&self) -> bool {
        true
    }

    fn to_toml(&self) -> String {
        toml::Value::from(self.as_str()).to_string()
    }
}
