//! Comb marks in a recipe: `surface.comb_marks`.

use pelage_params::{Field, Item, Range, Raw};

/// A direction of the comb at a place; what lies between marks follows from them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CombMarkParams {
    /// Name, for messages.
    pub name: String,
    /// Place near the skin, metres, in world space at rest.
    pub at: [f32; 3],
    /// Direction there, any length but 0.
    pub direction: [f32; 3],
}

const PLACE: Range<f32> = -1e6..=1e6;

impl CombMarkParams {
    fn from_table(table: &[(String, Raw)]) -> Result<Self, String> {
        let mut mark = Self::default();
        let mut seen = [false; 3];
        for (key, raw) in table {
            let (slot, read) = match key.as_str() {
                "name" => (0, <String as Field>::read(raw, &()).map(|name| mark.name = name)),
                "at" => (1, <[f32; 3]>::read(raw, &PLACE).map(|at| mark.at = at)),
                "direction" => (2, <[f32; 3]>::read(raw, &PLACE).map(|d| mark.direction = d)),
                _ => return Err(format!("unknown key {key:?}, expected name, at and direction")),
            };
            read.map_err(|reason| format!("{key}: {reason}"))?;
            seen[slot] = true;
        }
        match seen.iter().position(|s| !s) {
            Some(k) => Err(format!("{} is missing", ["name", "at", "direction"][k])),
            None => Ok(mark),
        }
    }
}

impl Item for CombMarkParams {
    const ALONE: bool = false;

    fn expected_list() -> String {
        "a list of tables such as { name = \"nose\", at = [0, 1, 0.5], direction = [0, 0, -1] } with directions other than 0".into()
    }

    fn read(raw: &Raw) -> Result<Self, Option<String>> {
        match raw {
            Raw::Table(table) => Self::from_table(table).map_err(Some),
            other => Err(Some(other.instead_of("a table"))),
        }
    }

    fn in_range(&self) -> bool {
        self.at.in_range(&PLACE) && self.direction.in_range(&PLACE) && self.direction != [0.0; 3]
    }

    fn to_toml(&self) -> String {
        let vector = |v: &[f32; 3]| v.to_toml().unwrap_or_default();
        let name = toml::Value::from(self.name.as_str());
        format!("{{ name = {name}, at = {}, direction = {} }}", vector(&self.at), vector(&self.direction))
    }
}
