//! Guide directions in a recipe: `surface.guides`.

use super::field::{Field, Range, Raw, describe_raw};
use serde::{Deserialize, Serialize};

/// A direction of the comb at a place; what lies between guides follows from them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GuideParams {
    /// Name, for messages.
    pub name: String,
    /// Place near the skin, metres, in world space at rest.
    pub at: [f32; 3],
    /// Direction there, any length but 0.
    pub direction: [f32; 3],
}

const PLACE: Range<f32> = -1e6..=1e6;

impl GuideParams {
    fn from_table(table: &[(String, Raw)]) -> Result<Self, String> {
        let mut guide = Self::default();
        let mut seen = [false; 3];
        for (key, raw) in table {
            let (slot, read) = match key.as_str() {
                "name" => (0, String::read(raw, &()).map(|name| guide.name = name)),
                "at" => (1, <[f32; 3]>::read(raw, &PLACE).map(|at| guide.at = at)),
                "direction" => (2, <[f32; 3]>::read(raw, &PLACE).map(|d| guide.direction = d)),
                _ => return Err(format!("unknown key {key:?}, expected name, at and direction")),
            };
            read.map_err(|reason| format!("{key}: {reason}"))?;
            seen[slot] = true;
        }
        match seen.iter().position(|s| !s) {
            Some(k) => Err(format!("{} is missing", ["name", "at", "direction"][k])),
            None => Ok(guide),
        }
    }
}

impl Field for Vec<GuideParams> {
    type Range = ();

    fn expected((): &()) -> String {
        "a list of tables such as { name = \"nose\", at = [0, 1, 0.5], direction = [0, 0, -1] } with directions other than 0".into()
    }

    fn from_raw(raw: &Raw) -> Option<Self> {
        let Raw::Array(items) = raw else { return None };
        let guide = |item: &Raw| match item {
            Raw::Table(table) => GuideParams::from_table(table).ok(),
            _ => None,
        };
        items.iter().map(guide).collect()
    }

    fn in_range(&self, (): &()) -> bool {
        self.iter().all(|g| g.at.in_range(&PLACE) && g.direction.in_range(&PLACE) && g.direction != [0.0; 3])
    }

    fn to_toml(&self) -> Option<String> {
        let vector = |v: &[f32; 3]| v.to_toml().unwrap_or_default();
        let guide = |g: &GuideParams| {
            let name = toml::Value::from(g.name.as_str());
            format!("{{ name = {name}, at = {}, direction = {} }}", vector(&g.at), vector(&g.direction))
        };
        Some(format!("[{}]", self.iter().map(guide).collect::<Vec<_>>().join(", ")))
    }

    fn read(raw: &Raw, range: &()) -> Result<Self, String> {
        if let Raw::Array(items) = raw {
            for (i, item) in items.iter().enumerate() {
                let Raw::Table(table) = item else {
                    return Err(format!("entry {i}: found {}, expected a table", describe_raw(item)));
                };
                GuideParams::from_table(table).map_err(|reason| format!("entry {i}: {reason}"))?;
            }
        }
        let found = || format!("found {}, expected {}", describe_raw(raw), Self::expected(range));
        Self::from_raw(raw).filter(|guides| guides.in_range(range)).ok_or_else(found)
    }
}
