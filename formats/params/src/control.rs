//! Description of a knob for a user interface.

/// Word that a knob can be set to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Choice {
    /// Spelling in a file.
    pub word: &'static str,
    /// Meaning.
    pub doc: &'static str,
    /// Deprecated spellings, still read.
    pub was: &'static [&'static str],
}

/// Key in the tables of a list-valued knob.
#[derive(Clone, Copy, Debug)]
pub struct TableKey {
    /// Spelling in a file.
    pub name: &'static str,
    /// Meaning.
    pub doc: &'static str,
    /// Type and range, such as `a number 0..=1`.
    pub expected: fn() -> String,
    /// Default as TOML; `None` if the key is unset by default, or if its default depends on other values.
    pub default: fn() -> Option<String>,
}

impl PartialEq for TableKey {
    fn eq(&self, other: &Self) -> bool {
        let all = |key: &Self| (key.name, key.doc, (key.expected)(), (key.default)());
        all(self) == all(other)
    }
}

/// Kind of control that shows a knob, with the range of its value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Control {
    /// Switch, on or off.
    Toggle,
    /// Number.
    Number {
        /// Minimum.
        least: f64,
        /// Maximum.
        most: f64,
        /// Whether only whole numbers are allowed.
        whole: bool,
        /// Whether a slider should be logarithmic: the range is above 0 and spans a factor of a thousand or more.
        logarithmic: bool,
    },
    /// Power of two.
    PowerOfTwo {
        /// Minimum.
        least: u32,
        /// Maximum.
        most: u32,
    },
    /// Several numbers with a common range.
    Vector {
        /// Number of components.
        len: usize,
        /// Minimum of each component.
        least: f64,
        /// Maximum of each component.
        most: f64,
    },
    /// Colour in sRGB.
    Color,
    /// Choice between a few words.
    Choice(&'static [Choice]),
    /// List of tables with these keys.
    Tables(&'static [TableKey]),
    /// Free text: names, paths, lists.
    Text,
}

impl Control {
    /// Returns the control for a number in a range.
    pub fn number(least: f64, most: f64, whole: bool) -> Self {
        Self::Number { least, most, whole, logarithmic: least > 0.0 && most / least >= 1000.0 }
    }
}
