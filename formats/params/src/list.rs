//! Lists of things.

use crate::control::{Control, TableKey};
use crate::field::Field;
use crate::raw::Raw;

/// What a list can hold. `Vec<T>` is then a [`Field`].
pub trait Item: Sized {
    /// Whether one alone may stand without brackets.
    const ALONE: bool;
    /// Keys of those that are tables.
    const KEYS: &'static [TableKey] = &[];

    /// What a list of them is, in words.
    fn expected_list() -> String;

    /// What an entry is called in messages.
    fn place(index: usize, raw: &Raw) -> String {
        let _ = raw;
        format!("entry {index}")
    }

    /// The value of that TOML.
    ///
    /// # Errors
    /// What is wrong with it; `None` where [`Self::expected_list`] says all that there is to say.
    fn read(raw: &Raw) -> Result<Self, Option<String>>;

    /// Whether it may stand in a list.
    fn in_range(&self) -> bool;

    /// TOML.
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
        let whole = || raw.instead_of(&T::expected_list());
        let items = match raw {
            Raw::Array(items) => items.as_slice(),
            one if T::ALONE => std::slice::from_ref(one),
            _ => return Err(whole()),
        };
        let mut list = Self::new();
        for (i, item) in items.iter().enumerate() {
            let read = T::read(item);
            list.push(
                read.map_err(|reason| reason.map_or_else(whole, |reason| format!("{}: {reason}", T::place(i, item))))?,
            );
        }
        if list.iter().all(T::in_range) { Ok(list) } else { Err(whole()) }
    }
}

/// Names.
impl Item for String {
    const ALONE: bool = true;

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
