//! Value types of recipe keys: how each is read from TOML, checked, written and described.

use serde::{Deserialize, Serialize};
use toml::de::DeValue;

/// A TOML value without its place.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Raw {
    Integer(i128),
    Float(f64),
    Bool(bool),
    String(String),
    Array(Vec<Raw>),
    /// Keys and values in the order of the file.
    Table(Vec<(String, Raw)>),
    /// A date or a number too large to hold; the text says which.
    Other(&'static str),
}

impl Raw {
    pub(super) fn from_de(value: &DeValue<'_>) -> Self {
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

    fn number(&self) -> Option<f64> {
        match self {
            Self::Integer(i) => Some(*i as f64),
            Self::Float(f) => Some(*f),
            _ => None,
        }
    }
}

/// What was found, for messages. Long values are cut.
pub(super) fn describe_raw(raw: &Raw) -> String {
    let cut = |s: String| {
        if s.chars().count() > 40 { format!("{}…", s.chars().take(40).collect::<String>()) } else { s }
    };
    match raw {
        Raw::Integer(i) => i.to_string(),
        Raw::Float(f) => f.to_string(),
        Raw::Bool(b) => b.to_string(),
        Raw::String(s) => format!("the string {}", cut(format!("{s:?}"))),
        Raw::Array(items) => cut(format!("[{}]", items.iter().map(describe_raw).collect::<Vec<_>>().join(", "))),
        Raw::Table(_) => "a table".to_owned(),
        Raw::Other(what) => (*what).to_owned(),
    }
}

/// A type that a recipe key can have. `Range` is what its key restricts it to.
pub(super) trait Field: Sized {
    type Range;
    /// Type and range in words.
    fn expected(range: &Self::Range) -> String;
    fn from_raw(raw: &Raw) -> Option<Self>;
    fn in_range(&self, range: &Self::Range) -> bool;
    /// TOML, or `None` for a value that is left out.
    fn to_toml(&self) -> Option<String>;

    fn read(raw: &Raw, range: &Self::Range) -> Result<Self, String> {
        Self::from_raw(raw)
            .filter(|value| value.in_range(range))
            .ok_or_else(|| format!("found {}, expected {}", describe_raw(raw), Self::expected(range)))
    }

    fn check(&self, range: &Self::Range) -> Result<(), String> {
        if self.in_range(range) {
            return Ok(());
        }
        let found = self.to_toml().unwrap_or_default();
        Err(format!("found {found}, expected {}", Self::expected(range)))
    }
}

/// Inclusive.
pub(super) type Range<T> = std::ops::RangeInclusive<T>;

impl Field for f32 {
    type Range = Range<f32>;

    fn expected(range: &Self::Range) -> String {
        format!("a number {}..={}", range.start(), range.end())
    }

    fn from_raw(raw: &Raw) -> Option<Self> {
        raw.number().map(|v| v as f32)
    }

    fn in_range(&self, range: &Self::Range) -> bool {
        range.contains(self)
    }

    fn to_toml(&self) -> Option<String> {
        // `{:?}` is the shortest text that reads back as the same f32, and always has a point or an exponent, as TOML wants.
        Some(format!("{self:?}"))
    }
}

impl<T: Field> Field for Option<T> {
    type Range = T::Range;

    fn expected(range: &Self::Range) -> String {
        T::expected(range)
    }

    fn from_raw(raw: &Raw) -> Option<Self> {
        T::from_raw(raw).map(Some)
    }

    fn in_range(&self, range: &Self::Range) -> bool {
        self.as_ref().is_none_or(|v| v.in_range(range))
    }

    fn to_toml(&self) -> Option<String> {
        self.as_ref().and_then(Field::to_toml)
    }
}

/// Integers whose range is plain.
macro_rules! integer_field {
    ($($ty:ty)*) => { $(
        impl Field for $ty {
            type Range = Range<$ty>;

            fn expected(range: &Self::Range) -> String {
                format!("an integer {}..={}", range.start(), range.end())
            }

            fn from_raw(raw: &Raw) -> Option<Self> {
                match raw {
                    Raw::Integer(i) => <$ty>::try_from(*i).ok(),
                    _ => None,
                }
            }

            fn in_range(&self, range: &Self::Range) -> bool {
                range.contains(self)
            }

            fn to_toml(&self) -> Option<String> {
                Some(self.to_string())
            }
        }
    )* };
}
integer_field!(u32 u64);

/// A power of two.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub(super) struct PowerOfTwo(pub u32);

impl Field for PowerOfTwo {
    type Range = Range<u32>;

    fn expected(range: &Self::Range) -> String {
        format!("a power of two {}..={}", range.start(), range.end())
    }

    fn from_raw(raw: &Raw) -> Option<Self> {
        u32::from_raw(raw).map(Self)
    }

    fn in_range(&self, range: &Self::Range) -> bool {
        self.0.is_power_of_two() && range.contains(&self.0)
    }

    fn to_toml(&self) -> Option<String> {
        self.0.to_toml()
    }
}

impl Field for bool {
    type Range = ();

    fn expected((): &()) -> String {
        "true or false".into()
    }

    fn from_raw(raw: &Raw) -> Option<Self> {
        match raw {
            Raw::Bool(b) => Some(*b),
            _ => None,
        }
    }

    fn in_range(&self, (): &()) -> bool {
        true
    }

    fn to_toml(&self) -> Option<String> {
        Some(self.to_string())
    }
}

impl Field for [f32; 3] {
    type Range = Range<f32>;

    fn expected(range: &Self::Range) -> String {
        format!("three numbers {}..={} in brackets", range.start(), range.end())
    }

    fn from_raw(raw: &Raw) -> Option<Self> {
        match raw {
            Raw::Array(items) => match items.as_slice() {
                [r, g, b] => Some([r.number()? as f32, g.number()? as f32, b.number()? as f32]),
                _ => None,
            },
            _ => None,
        }
    }

    fn in_range(&self, range: &Self::Range) -> bool {
        self.iter().all(|v| range.contains(v))
    }

    fn to_toml(&self) -> Option<String> {
        Some(format!("[{:?}, {:?}, {:?}]", self[0], self[1], self[2]))
    }
}

/// A colour in sRGB, each channel 0..=1. In a recipe `[r, g, b]` or `"#rrggbb"`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct SrgbColor(pub [f32; 3]);

impl SrgbColor {
    /// From the three bytes of `#rrggbb`.
    pub const fn hex(rgb: u32) -> Self {
        Self([(rgb >> 16 & 255) as f32 / 255.0, (rgb >> 8 & 255) as f32 / 255.0, (rgb & 255) as f32 / 255.0])
    }
}

impl Field for SrgbColor {
    type Range = ();

    fn expected((): &()) -> String {
        "\"#rrggbb\" or [r, g, b] with numbers 0..=1".into()
    }

    fn from_raw(raw: &Raw) -> Option<Self> {
        match raw {
            Raw::String(s) => {
                let digits =
                    s.strip_prefix('#').filter(|d| d.len() == 6 && d.bytes().all(|b| b.is_ascii_hexdigit()))?;
                u32::from_str_radix(digits, 16).ok().map(Self::hex)
            }
            _ => <[f32; 3]>::from_raw(raw).map(Self),
        }
    }

    fn in_range(&self, (): &()) -> bool {
        self.0.in_range(&(0.0..=1.0))
    }

    fn to_toml(&self) -> Option<String> {
        self.0.to_toml()
    }
}

impl Field for String {
    type Range = ();

    fn expected((): &()) -> String {
        "a string".into()
    }

    fn from_raw(raw: &Raw) -> Option<Self> {
        match raw {
            Raw::String(s) => Some(s.clone()),
            _ => None,
        }
    }

    fn in_range(&self, (): &()) -> bool {
        true
    }

    fn to_toml(&self) -> Option<String> {
        Some(toml::Value::from(self.as_str()).to_string())
    }
}

/// Names; one alone may stand without brackets.
impl Field for Vec<String> {
    type Range = ();

    fn expected((): &()) -> String {
        "a list of strings".into()
    }

    fn from_raw(raw: &Raw) -> Option<Self> {
        let string = |raw: &Raw| match raw {
            Raw::String(s) => Some(s.clone()),
            _ => None,
        };
        match raw {
            Raw::Array(items) => items.iter().map(string).collect(),
            _ => string(raw).map(|s| vec![s]),
        }
    }

    fn in_range(&self, (): &()) -> bool {
        true
    }

    fn to_toml(&self) -> Option<String> {
        let items: Vec<_> = self.iter().map(|s| toml::Value::from(s.as_str()).to_string()).collect();
        Some(format!("[{}]", items.join(", ")))
    }
}
