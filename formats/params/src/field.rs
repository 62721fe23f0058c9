//! Value types of knobs: reading, checking, writing, description and control of each.

use crate::control::Control;
use crate::raw::Raw;

/// Value type of a knob. `Range` is the restriction that a declaration can state.
pub trait Field: Sized {
    /// Restriction of the values in a declaration; `()` if the type has none.
    type Range;

    /// Returns type and range in words.
    fn expected(range: &Self::Range) -> String;

    /// Returns the control that shows the value; a text field unless the type overrides it.
    fn control(range: &Self::Range) -> Control {
        let _ = range;
        Control::Text
    }

    /// Converts `raw` to a value, without a range check; `None` if it has the wrong type.
    fn from_raw(raw: &Raw) -> Option<Self>;

    /// Whether the value is in its range; true for types without one.
    fn in_range(&self, range: &Self::Range) -> bool {
        let _ = range;
        true
    }

    /// Returns the value as TOML; `None` if the key is unset.
    fn to_toml(&self) -> Option<String>;

    /// Returns the value for documentation, as TOML with no more digits than a reader needs.
    fn to_display(&self) -> Option<String> {
        self.to_toml()
    }

    /// Parses a command-line word into an unchecked value.
    fn parse_word(word: &str) -> Raw {
        Raw::from_word(word)
    }

    /// Converts `raw` to a value and checks it against its range.
    ///
    /// Fails with a message about the value found and the value expected.
    fn read(raw: &Raw, range: &Self::Range) -> Result<Self, String> {
        Self::from_raw(raw).filter(|value| value.in_range(range)).ok_or_else(|| raw.unexpected(&Self::expected(range)))
    }

    /// Checks the value against its range.
    ///
    /// Fails with a message about the value found and the value expected.
    fn check(&self, range: &Self::Range) -> Result<(), String> {
        if self.in_range(range) {
            return Ok(());
        }
        let found = self.to_toml().unwrap_or_default();
        Err(format!("found {found}, expected {}", Self::expected(range)))
    }
}

/// Inclusive range.
pub type Range<T> = std::ops::RangeInclusive<T>;

impl Field for f32 {
    type Range = Range<f32>;

    fn expected(range: &Self::Range) -> String {
        format!("a number {}..={}", range.start(), range.end())
    }

    fn control(range: &Self::Range) -> Control {
        Control::number((*range.start()).into(), (*range.end()).into(), false)
    }

    fn from_raw(raw: &Raw) -> Option<Self> {
        raw.number().map(|v| v as f32)
    }

    fn in_range(&self, range: &Self::Range) -> bool {
        range.contains(self)
    }

    fn to_toml(&self) -> Option<String> {
        // `{:?}` gives the shortest text that reads back as the same f32. It always has a point or an exponent, as TOML
        // requires.
        Some(format!("{self:?}"))
    }

    fn parse_word(word: &str) -> Raw {
        parse_number(word)
    }
}

/// Parses a number from the command line, including forms that TOML does not accept: `.5`, `3.`, `+007`.
fn parse_number(word: &str) -> Raw {
    match (Raw::from_word(word.trim()), word.trim().parse()) {
        (Raw::String(_), Ok(number)) => Raw::Float(number),
        (Raw::String(text), Err(_)) => Raw::String(text),
        (raw, _) => raw,
    }
}

/// Parses comma-separated numbers, `1,2,3`, or a TOML array.
fn parse_numbers(word: &str) -> Raw {
    let items: Vec<Raw> = word.split(',').map(parse_number).collect();
    match Raw::from_word(word) {
        Raw::String(_) if items.iter().all(|item| item.number().is_some()) => Raw::Array(items),
        raw => raw,
    }
}

impl<T: Field> Field for Option<T> {
    type Range = T::Range;

    fn expected(range: &Self::Range) -> String {
        T::expected(range)
    }

    fn control(range: &Self::Range) -> Control {
        T::control(range)
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

    fn parse_word(word: &str) -> Raw {
        T::parse_word(word)
    }

    fn read(raw: &Raw, range: &Self::Range) -> Result<Self, String> {
        // `T::read` may give a more precise error than the range check: a list names the faulty entry.
        T::read(raw, range).map(Some)
    }

    fn check(&self, range: &Self::Range) -> Result<(), String> {
        self.as_ref().map_or(Ok(()), |value| value.check(range))
    }
}

/// Implements `Field` for integers with a plain range.
macro_rules! integer_field {
    ($($ty:ty, $to_f64:expr;)*) => { $(
        impl Field for $ty {
            type Range = Range<$ty>;

            fn expected(range: &Self::Range) -> String {
                format!("an integer {}..={}", range.start(), range.end())
            }

            fn control(range: &Self::Range) -> Control {
                Control::number($to_f64(*range.start()), $to_f64(*range.end()), true)
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

            fn parse_word(word: &str) -> Raw {
                // Accept `007` as an integer on the command line, although TOML does not.
                word.trim().parse().map_or_else(|_| Raw::from_word(word), Raw::Integer)
            }
        }
    )* };
}
integer_field!(u32, f64::from; u64, |x| x as f64;);

/// Power of two.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PowerOfTwo(pub u32);

impl Field for PowerOfTwo {
    type Range = Range<u32>;

    fn expected(range: &Self::Range) -> String {
        format!("a power of two {}..={}", range.start(), range.end())
    }

    fn control(range: &Self::Range) -> Control {
        Control::PowerOfTwo { least: *range.start(), most: *range.end() }
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

    fn parse_word(word: &str) -> Raw {
        u32::parse_word(word)
    }
}

impl Field for bool {
    type Range = ();

    fn expected((): &()) -> String {
        "true or false".into()
    }

    fn control((): &()) -> Control {
        Control::Toggle
    }

    fn from_raw(raw: &Raw) -> Option<Self> {
        match raw {
            Raw::Bool(b) => Some(*b),
            _ => None,
        }
    }

    fn to_toml(&self) -> Option<String> {
        Some(self.to_string())
    }

    fn parse_word(word: &str) -> Raw {
        match word {
            "on" => Raw::Bool(true),
            "off" => Raw::Bool(false),
            _ => Raw::from_word(word),
        }
    }
}

impl Field for [f32; 3] {
    type Range = Range<f32>;

    fn expected(range: &Self::Range) -> String {
        format!("three numbers {}..={} in brackets", range.start(), range.end())
    }

    fn control(range: &Self::Range) -> Control {
        Control::Vector { len: 3, least: (*range.start()).into(), most: (*range.end()).into() }
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

    fn parse_word(word: &str) -> Raw {
        parse_numbers(word)
    }
}

/// Returns the three bytes of `#rrggbb`.
pub fn hex(text: &str) -> Option<[u8; 3]> {
    let digits = text.strip_prefix('#').filter(|d| d.len() == 6 && d.bytes().all(|b| b.is_ascii_hexdigit()))?;
    let [_, r, g, b] = u32::from_str_radix(digits, 16).ok()?.to_be_bytes();
    Some([r, g, b])
}

/// Colour in sRGB, each channel 0..=1. In a file `[r, g, b]` or `"#rrggbb"`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SrgbColor(pub [f32; 3]);

impl SrgbColor {
    /// Converts `0xrrggbb` to a colour.
    pub const fn hex(rgb: u32) -> Self {
        Self([(rgb >> 16 & 255) as f32 / 255.0, (rgb >> 8 & 255) as f32 / 255.0, (rgb & 255) as f32 / 255.0])
    }
}

impl Field for SrgbColor {
    type Range = ();

    fn expected((): &()) -> String {
        "\"#rrggbb\" or [r, g, b] with numbers 0..=1".into()
    }

    fn control((): &()) -> Control {
        Control::Color
    }

    fn from_raw(raw: &Raw) -> Option<Self> {
        match raw {
            Raw::String(text) => hex(text).map(|rgb| Self(rgb.map(|byte| f32::from(byte) / 255.0))),
            _ => <[f32; 3]>::from_raw(raw).map(Self),
        }
    }

    fn in_range(&self, (): &()) -> bool {
        self.0.in_range(&(0.0..=1.0))
    }

    fn to_toml(&self) -> Option<String> {
        self.0.to_toml()
    }

    fn to_display(&self) -> Option<String> {
        let [r, g, b] = self.0.map(|x| (x * 255.0).round() as u8);
        Some(format!("\"#{r:02x}{g:02x}{b:02x}\""))
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

    fn to_toml(&self) -> Option<String> {
        Some(toml::Value::from(self.as_str()).to_string())
    }
}
