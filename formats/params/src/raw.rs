//! Values before they are understood.

use std::fmt;
use toml::de::DeValue;

/// A TOML value without its place.
#[derive(Clone, Debug, PartialEq)]
pub enum Raw {
    /// An integer.
    Integer(i128),
    /// A number with a point or an exponent, or one that is none (`nan`, `inf`).
    Float(f64),
    /// `true` or `false`.
    Bool(bool),
    /// A string.
    String(String),
    /// Values in brackets.
    Array(Vec<Raw>),
    /// Keys and values in the order of the file.
    Table(Vec<(String, Raw)>),
    /// A date or a number too large to hold; the text says which.
    Other(&'static str),
}

impl Raw {
    /// From what the TOML parser found.
    pub fn from_de(value: &DeValue<'_>) -> Self {
        match value {
            DeValue::String(s) => Self::String(s.to_string()),
            DeValue::Integer(i) => match i128::from_str_radix(i.as_str(), i.radix()) {
                Ok(i) => Self::Integer(i),
                Err(_) => Self::Other("an integer of too many digits"),
            },
            DeValue::Float(f) => match f.as_str().parse() {
                Ok(f) => Self::Float(f),
                Err(_) => Self::Other("a number that cannot be read"),
            },
            DeValue::Boolean(b) => Self::Bool(*b),
            DeValue::Datetime(_) => Self::Other("a date"),
            DeValue::Array(items) => Self::Array(items.iter().map(|v| Self::from_de(v.get_ref())).collect()),
            DeValue::Table(table) => {
                Self::Table(table.iter().map(|(k, v)| (k.get_ref().to_string(), Self::from_de(v.get_ref()))).collect())
            }
        }
    }

    /// From a value that was read before.
    pub fn from_value(value: &toml::Value) -> Self {
        match value {
            toml::Value::String(s) => Self::String(s.clone()),
            toml::Value::Integer(i) => Self::Integer((*i).into()),
            toml::Value::Float(f) => Self::Float(*f),
            toml::Value::Boolean(b) => Self::Bool(*b),
            toml::Value::Datetime(_) => Self::Other("a date"),
            toml::Value::Array(items) => Self::Array(items.iter().map(Self::from_value).collect()),
            toml::Value::Table(table) => {
                Self::Table(table.iter().map(|(key, value)| (key.clone(), Self::from_value(value))).collect())
            }
        }
    }

    /// From a word of a command line: what is no TOML value on its own (`curly`, `#aabbcc`, `Eye*`) is the string it looks like.
    pub fn from_word(word: &str) -> Self {
        match DeValue::parse(word) {
            Ok(parsed) => Self::from_de(parsed.get_ref()),
            Err(_) => Self::String(word.to_owned()),
        }
    }

    /// As a number.
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Integer(i) => Some(*i as f64),
            Self::Float(f) => Some(*f),
            _ => None,
        }
    }

    /// The message for a value that is not what it should be.
    pub fn instead_of(&self, expected: &str) -> String {
        format!("found {self}, expected {expected}")
    }
}

/// What was found, for messages. Long values are cut.
impl fmt::Display for Raw {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let cut = |s: String| {
            if s.chars().count() > 40 { format!("{}…", s.chars().take(40).collect::<String>()) } else { s }
        };
        match self {
            Self::Integer(i) => write!(f, "{i}"),
            Self::Float(x) => write!(f, "{x}"),
            Self::Bool(b) => write!(f, "{b}"),
            Self::String(s) => write!(f, "the string {}", cut(format!("{s:?}"))),
            Self::Array(items) => {
                f.write_str(&cut(format!("[{}]", items.iter().map(Self::to_string).collect::<Vec<_>>().join(", "))))
            }
            Self::Table(_) => f.write_str("a table"),
            Self::Other(what) => f.write_str(what),
        }
    }
}
