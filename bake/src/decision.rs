//! Values that a recipe leaves open and the bake chooses, each with the recipe line that would set it.

use serde::Serialize;

/// Value that the recipe left open and the bake chose.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Decision {
    /// Name of the value, in words: `length of hair`.
    pub what: &'static str,
    /// Value chosen, in words: `31 mm`.
    pub chosen: String,
    /// Recipe line that states the same value: `hair.length_m = 0.031`.
    pub line: String,
}

impl Decision {
    /// Describes a chosen length, metres, as a value of the recipe key `key`.
    pub fn length(what: &'static str, key: &str, metres: f32) -> Self {
        Self { what, chosen: metres_in_words(metres), line: format!("{key} = {metres}") }
    }
}

/// Formats a length for people, with three digits in a suitable unit.
pub fn metres_in_words(metres: f32) -> String {
    let (number, unit) = match metres {
        m if m < 1e-3 => (m * 1e6, "µm"),
        m if m < 1.0 => (m * 1e3, "mm"),
        m => (m, "m"),
    };
    let digits = if number < 10.0 { 1 } else { 0 };
    format!("{number:.digits$} {unit}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_printed_in_suitable_units() {
        let said = [0.000_25, 0.0042, 0.031, 0.999, 1.25, 140.0].map(metres_in_words);
        assert_eq!(said, ["250 µm", "4.2 mm", "31 mm", "999 mm", "1.2 m", "140 m"]);
        let decision = Decision::length("length of hair", "hair.length_m", 0.031);
        assert_eq!((decision.chosen.as_str(), decision.line.as_str()), ("31 mm", "hair.length_m = 0.031"));
    }
}
