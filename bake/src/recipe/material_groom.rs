//! What a recipe says about the hair of single materials: `[[groom.material]]`.

use super::field::{Field, Range, Raw, describe_raw};
use super::maps::{ColorMap, ScalarMap, VectorMap};
use super::nearest;
use serde::{Deserialize, Serialize};

/// Range of maps that are shares.
pub(super) const SHARE: Range<f32> = 0.0..=1.0;
/// Range of the density map.
pub(super) const DENSITY: Range<f32> = 0.25..=4.0;

/// Declares [`MaterialGroom`] and how each of its keys is read and written.
macro_rules! overrides {
    ($($(#[$meta:meta])* $key:ident: $ty:ty, in $range:expr;)+) => {
        /// The groom of the materials that `name` matches: what is given here stands in for what `[groom]` says. Later tables win.
        #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
        #[serde(deny_unknown_fields)]
        pub struct MaterialGroom {
            /// Name of a material. `*` stands for any characters, `?` for one.
            pub name: String,
            $($(#[$meta])* #[serde(default, skip_serializing_if = "Option::is_none")] pub $key: Option<$ty>,)+
        }

        /// Keys besides `name`.
        const KEYS: &[&str] = &[$(stringify!($key)),+];

        impl MaterialGroom {
            /// Sets `key`, which is not `name`.
            fn set(&mut self, key: &str, raw: &Raw) -> Result<(), String> {
                match key {
                    $(stringify!($key) => self.$key = Some(<$ty>::read(raw, &$range)?),)+
                    _ => {
                        let near = nearest(key, KEYS.iter().copied()).unwrap_or_default();
                        return Err(format!("unknown key; did you mean {near}?"));
                    }
                }
                Ok(())
            }

            fn in_range(&self) -> bool {
                !self.name.is_empty() $(&& self.$key.as_ref().is_none_or(|map| map.in_range(&$range)))+
            }

            fn to_toml(&self) -> String {
                let mut items = vec![format!("name = {}", toml::Value::from(self.name.as_str()))];
                $(if let Some(text) = self.$key.as_ref().and_then(Field::to_toml) {
                    items.push(format!("{} = {text}", stringify!($key)));
                })+
                format!("{{ {} }}", items.join(", "))
            }
        }
    };
}

overrides! {
    /// As `groom.length`.
    length: ScalarMap, in SHARE;
    /// As `groom.density`.
    density: ScalarMap, in DENSITY;
    /// As `groom.lean`.
    lean: ScalarMap, in SHARE;
    /// As `groom.comb`.
    comb: VectorMap, in ();
    /// As `groom.wetness`.
    wetness: ScalarMap, in SHARE;
    /// As `groom.bare`.
    bare: ScalarMap, in SHARE;
    /// As `groom.color`.
    color: ColorMap, in ();
}

impl MaterialGroom {
    fn from_table(raw: &Raw) -> Result<Self, String> {
        let Raw::Table(table) = raw else {
            return Err(format!("found {}, expected a table", describe_raw(raw)));
        };
        let mut groom = Self::default();
        for (key, value) in table {
            match (key.as_str(), value) {
                ("name", Raw::String(name)) => groom.name.clone_from(name),
                ("name", other) => return Err(format!("name: found {}, expected a string", describe_raw(other))),
                _ => groom.set(key, value).map_err(|reason| format!("{key}: {reason}"))?,
            }
        }
        if groom.name.is_empty() {
            return Err("found no name, expected the name of a material".into());
        }
        Ok(groom)
    }
}

/// Tables in their order.
impl Field for Vec<MaterialGroom> {
    type Range = ();

    fn expected((): &()) -> String {
        format!("a list of tables with name and any of {}", KEYS.join(", "))
    }

    fn from_raw(raw: &Raw) -> Option<Self> {
        Self::read(raw, &()).ok()
    }

    fn in_range(&self, (): &()) -> bool {
        self.iter().all(MaterialGroom::in_range)
    }

    fn to_toml(&self) -> Option<String> {
        Some(format!("[{}]", self.iter().map(MaterialGroom::to_toml).collect::<Vec<_>>().join(", ")))
    }

    fn read(raw: &Raw, (): &()) -> Result<Self, String> {
        let Raw::Array(tables) = raw else {
            return Err(format!("found {}, expected {}", describe_raw(raw), Self::expected(&())));
        };
        let number = |(i, table)| MaterialGroom::from_table(table).map_err(|reason| format!("table {i}: {reason}"));
        tables.iter().enumerate().map(number).collect()
    }
}
