//! What a window needs to know of a knob to show it.

/// One of the words that a knob can be set to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Choice {
    /// As it stands in a file.
    pub word: &'static str,
    /// What it means.
    pub doc: &'static str,
    /// What it was called in earlier files: still read.
    pub was: &'static [&'static str],
}

/// A key of the tables that a list has.
#[derive(Clone, Copy, Debug)]
pub struct TableKey {
    /// As it stands in a file.
    pub name: &'static str,
    /// What it means.
    pub doc: &'static str,
    /// Type and range, such as `a number 0..=1`.
    pub expected: fn() -> String,
    /// Default as TOML; `None` where it is left out or depends on other values.
    pub default: fn() -> Option<String>,
}

impl PartialEq for TableKey {
    fn eq(&self, other: &Self) -> bool {
        let all = |key: &Self| (key.name, key.doc, (key.expected)(), (key.default)());
        all(self) == all(other)
    }
}

/// How a knob is shown: what it holds, and from where to where.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Control {
    /// On or off.
    Toggle,
    /// A number.
    Number {
        /// Least value.
        least: f64,
        /// Greatest value.
        most: f64,
        /// Whether only whole numbers are allowed.
        whole: bool,
        /// Whether a slider should run through the logarithm: the range is above 0 and spans a factor of a thousand or more.
        logarithmic: bool,
    },
    /// A power of two.
    PowerOfTwo {
        /// Least value.
        least: u32,
        /// Greatest value.
        most: u32,
    },
    /// Several numbers of one range.
    Vector {
        /// How many.
        len: usize,
        /// Least value of each.
        least: f64,
        /// Greatest value of each.
        most: f64,
    },
    /// A colour in sRGB.
    Color,
    /// One of a few words.
    Choice(&'static [Choice]),
    /// A list of tables with these keys.
    Tables(&'static [TableKey]),
    /// What only text can say: names, paths, lists.
    Text,
}

impl Control {
    /// That of a number in a range.
    pub fn number(least: f64, most: f64, whole: bool) -> Self {
        Self::Number { least, most, whole, logarithmic: least > 0.0 && most / least >= 1000.0 }
    }
}
