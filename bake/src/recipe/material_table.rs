//! Tables for single materials: `[[groom.material]]`, `[[ink.material]]`.

/// Declares such a table, and how its list and each of its keys are read, checked and written. Every key besides `name` may be left out.
macro_rules! material_table {
    ($(#[$struct_meta:meta])* $table:ident { $($(#[$meta:meta])* $key:ident: $ty:ty, in $range:expr;)+ }) => {
        $(#[$struct_meta])*
        #[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(deny_unknown_fields)]
        pub struct $table {
            /// Name of a material. `*` stands for any characters, `?` for one.
            pub name: String,
            $($(#[$meta])* #[serde(default, skip_serializing_if = "Option::is_none")] pub $key: Option<$ty>,)+
        }

        impl $table {
            /// Keys besides `name`.
            const KEYS: &[&str] = &[$(stringify!($key)),+];

            /// Sets `key`, which is not `name`.
            fn set(&mut self, key: &str, raw: &super::Raw) -> Result<(), String> {
                match key {
                    $(stringify!($key) => self.$key = Some(<$ty as super::field::Field>::read(raw, &$range)?),)+
                    _ => {
                        let near = super::nearest(key, Self::KEYS.iter().copied()).unwrap_or_default();
                        return Err(format!("unknown key; did you mean {near}?"));
                    }
                }
                Ok(())
            }

            fn in_range(&self) -> bool {
                use super::field::Field as _;
                !self.name.is_empty() $(&& self.$key.as_ref().is_none_or(|map| map.in_range(&$range)))+
            }

            fn to_toml(&self) -> String {
                let mut items = vec![format!("name = {}", toml::Value::from(self.name.as_str()))];
                $(if let Some(text) = self.$key.as_ref().and_then(super::field::Field::to_toml) {
                    items.push(format!("{} = {text}", stringify!($key)));
                })+
                format!("{{ {} }}", items.join(", "))
            }

            fn from_table(raw: &super::Raw) -> Result<Self, String> {
                use super::{Raw, describe_raw};
                let Raw::Table(table) = raw else {
                    return Err(format!("found {}, expected a table", describe_raw(raw)));
                };
                let mut read = Self::default();
                for (key, value) in table {
                    match (key.as_str(), value) {
                        ("name", Raw::String(name)) => read.name.clone_from(name),
                        ("name", other) => return Err(format!("name: found {}, expected a string", describe_raw(other))),
                        _ => read.set(key, value).map_err(|reason| format!("{key}: {reason}"))?,
                    }
                }
                if read.name.is_empty() {
                    return Err("found no name, expected the name of a material".into());
                }
                Ok(read)
            }
        }

        impl super::MaterialTable for $table {
            fn material_name(&self) -> &str {
                &self.name
            }
        }

        /// Tables in their order.
        impl super::field::Field for Vec<$table> {
            type Range = ();

            fn expected((): &()) -> String {
                format!("a list of tables with name and any of {}", $table::KEYS.join(", "))
            }

            fn from_raw(raw: &super::Raw) -> Option<Self> {
                Self::read(raw, &()).ok()
            }

            fn in_range(&self, (): &()) -> bool {
                self.iter().all($table::in_range)
            }

            fn to_toml(&self) -> Option<String> {
                Some(format!("[{}]", self.iter().map($table::to_toml).collect::<Vec<_>>().join(", ")))
            }

            fn read(raw: &super::Raw, (): &()) -> Result<Self, String> {
                let super::Raw::Array(tables) = raw else {
                    return Err(format!("found {}, expected {}", super::describe_raw(raw), Self::expected(&())));
                };
                let number = |(i, table)| $table::from_table(table).map_err(|reason| format!("table {i}: {reason}"));
                tables.iter().enumerate().map(number).collect()
            }
        }
    };
}
pub(super) use material_table;

/// What a recipe says about the materials of a name.
pub trait MaterialTable {
    /// Name of a material. `*` stands for any characters, `?` for one.
    fn material_name(&self) -> &str;
}
