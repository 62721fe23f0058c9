//! Unchecked values.

use std::fmt;
use toml::de::DeValue;

/// TOML value without its location.
#[derive(Clone, Debug, PartialEq)]
pub enum Raw {
    /// Integer.
    Integer(i128),
    /// Number with a point or an exponent, or `nan` or `inf`.
    Float(f64),
    /// Boolean, `true` or `false`.
    Bool(bool),
    /// String.
    String(String),
    /// Array.
    Array(Vec<Raw>),
    /// Keys and values, in file order.
    Table(Vec<(String, Raw)>),
    /// Date, or a number too large to represent; the text says which.
    Other(&'static str),
}

impl Raw {
    /// Converts a value of the TOML parser.
    pub fn from_de(value: &DeValue<'_>) -> Self {
        match value {
            DeValue::String(s) => Self::String(s.to_string()),
            DeValue::Integer(i) => match i128::from_str_radix(i.as_str(), i.radix()) {
                Ok(i) => Self::Integer(i),
                Err(_) => Self::Other("an integer with too many digits"),
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

    /// Converts a parsed TOML value.
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

    /// Parses a word of a command line. Text that is not a TOML value (`curly`, `#aabbcc`, `Eye*`) becomes a string.
    pub fn from_word(word: &str) -> Self {
        match DeValue::parse(word) {
            Ok(parsed) => Self::from_de(parsed.get_ref()),
            Err(_) => Self::String(word.to_owned()),
        }
    }

    /// Returns the value as a number.
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Integer(i) => Some(*i as f64),
            Self::Float(f) => Some(*f),
            _ => None,
        }
    }

    /// Returns the message for an unexpected value.
    pub fn unexpected(&self, expected: &str) -> String {
        format!("found {self}, expected {expected}")
    }
}

/// Formats the value for messages. Long values are truncated.
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
