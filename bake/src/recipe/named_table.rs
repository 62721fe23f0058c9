//! Tables with a name, for single materials (`[[groom.material]]`, `[[ink.material]]` and `[[fibre.material]]`) and for
//! groups of hair.

/// Declares a named table, and how its list and its keys are read, checked and written. All keys but `name` are
/// optional, unless the function after `checked by` requires them. A key with a default gets a method of the same name
/// that returns the value or the default.
macro_rules! named_table {
    ($(#[$struct_meta:meta])* $table:ident of $what:literal $(checked by $check:path)? {
        $($(#[doc = $doc:literal])+ $key:ident: $ty:ty $(= $default:expr)?, in $range:expr;)+
    }) => {
        $(#[$struct_meta])*
        #[derive(Clone, Debug, Default, PartialEq)]
        pub struct $table {
            #[doc = concat!("Name of ", $what, ".")]
            pub name: String,
            $($(#[doc = $doc])+ pub $key: Option<$ty>,)+
        }

        impl $table {
            $($(
                #[doc = concat!("Returns `", stringify!($key), "`, or its default.")]
                pub fn $key(&self) -> $ty {
                    Option::clone(&self.$key).unwrap_or($default)
                }
            )?)+

            /// Sets a key other than `name`.
            fn set(&mut self, key: &str, raw: &pelage_params::Raw) -> Result<(), String> {
                match key {
                    $(stringify!($key) => self.$key = Some(<$ty as pelage_params::Field>::read(raw, &$range)?),)+
                    _ => return Err(pelage_params::unknown_key(key, &[$(stringify!($key)),+])),
                }
                Ok(())
            }
        }

        impl crate::recipe::NamedTable for $table {
            fn table_name(&self) -> &str {
                &self.name
            }
        }

        impl pelage_params::Item for $table {
            const ALLOW_SINGLE: bool = false;
            const KEYS: &'static [pelage_params::TableKey] = &[$(pelage_params::TableKey {
                name: stringify!($key),
                doc: concat!($($doc, "\n"),+),
                expected: || <$ty as pelage_params::Field>::expected(&$range),
                default: || None$(.or_else(|| <$ty as pelage_params::Field>::to_display(&$default)))?,
            }),+];

            fn expected_list() -> String {
                let keys: Vec<_> = Self::KEYS.iter().map(|key| key.name).collect();
                format!("a list of tables, each with name and any of {}", keys.join(", "))
            }

            fn entry_name(index: usize, _: &pelage_params::Raw) -> String {
                format!("table {index}")
            }

            fn read(raw: &pelage_params::Raw) -> Result<Self, Option<String>> {
                use pelage_params::Raw;
                let Raw::Table(table) = raw else {
                    return Err(Some(raw.unexpected("a table")));
                };
                let mut read = Self::default();
                for (key, value) in table {
                    match (key.as_str(), value) {
                        ("name", Raw::String(name)) => read.name.clone_from(name),
                        ("name", other) => return Err(Some(format!("name: {}", other.unexpected("a string")))),
                        _ => read.set(key, value).map_err(|reason| format!("{key}: {reason}"))?,
                    }
                }
                if read.name.is_empty() {
                    return Err(Some(concat!("found no name, expected the name of ", $what).into()));
                }
                $($check(&read).map_err(Some)?;)?
                Ok(read)
            }

            fn in_range(&self) -> bool {
                !self.name.is_empty()
                    $(&& self.$key.as_ref().is_none_or(|map| pelage_params::Field::in_range(map, &$range)))+
                    $(&& $check(self).is_ok())?
            }

            fn to_toml(&self) -> String {
                let mut items = vec![format!("name = {}", toml::Value::from(self.name.as_str()))];
                $(if let Some(text) = self.$key.as_ref().and_then(pelage_params::Field::to_toml) {
                    items.push(format!("{} = {text}", stringify!($key)));
                })+
                format!("{{ {} }}", items.join(", "))
            }
        }
    };
}
pub(super) use named_table;

/// Table of a recipe for the materials or groups of hair that its name matches.
pub trait NamedTable {
    /// Returns the name. `*` matches any characters, `?` one.
    fn table_name(&self) -> &str;
}
