//! Declaration macros.

/// Declares an enum whose values are words in a file. `was` gives a deprecated word and `or` a deprecated boolean; both
/// are still read.
#[macro_export]
macro_rules! words {
    (
        $(#[$meta:meta])*
        $name:ident {
            $(
                $(#[doc = $doc:literal])+
                $(#[default $($no_args:tt)?])?
                $variant:ident = $word:literal $(was $old:literal)? $(or $flag:literal)?,
            )+
        }
    ) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
        pub enum $name {
            $($(#[doc = $doc])+ $(#[default $($no_args)?])? $variant,)+
        }

        impl $name {
            /// All values, in the order of declaration.
            pub const ALL: &[Self] = &[$(Self::$variant),+];

            /// Returns the word in a file.
            pub fn word(self) -> &'static str {
                match self { $(Self::$variant => $word),+ }
            }
        }

        impl $crate::Field for $name {
            type Range = ();

            fn expected((): &()) -> String {
                let words: Vec<_> = Self::ALL.iter().map(|v| format!("{:?}", v.word())).collect();
                match words.as_slice() {
                    [one] => one.clone(),
                    _ => format!("one of {}", words.join(", ")),
                }
            }

            fn control((): &()) -> $crate::Control {
                $crate::Control::Choice(&[
                    $($crate::Choice { word: $word, doc: concat!($($doc, "\n"),+), was: &[$($old)?] }),+
                ])
            }

            fn from_raw(raw: &$crate::Raw) -> Option<Self> {
                match raw {
                    $crate::Raw::String(s) => match s.as_str() {
                        $($word $(| $old)? => Some(Self::$variant),)+
                        _ => None,
                    },
                    // Accept a boolean, because some knobs used to be switches.
                    $($($crate::Raw::Bool($flag) => Some(Self::$variant),)?)+
                    _ => None,
                }
            }

            fn to_toml(&self) -> Option<String> {
                Some(format!("{:?}", self.word()))
            }
        }
    };
}

/// Declares a table of knobs: the struct, its defaults, its checks and its keys.
///
/// A field has the form `/// meaning`, `name: Type = default, in range, as Checked, or "word", clears other, was
/// "name", needs "condition";`, where everything after the default is optional.
///
/// * `in`: range; without one, all values of the type are allowed
/// * `as`: wrapper type whose [`Field`](crate::Field) does the checking, if the type alone is not specific enough
/// * `or`: word for the type's own default, so that an `Option` can be unset again
/// * `clears`: field that is reset when this one is set, because both describe the same thing and the later one counts
/// * `was`: deprecated key that is still read; written `table.key` if it was in a different table
/// * `needs`: condition without which the knob has no effect ([`Knob::needs`](crate::Knob::needs)); may be repeated,
///   and also follow the name of the table, for all of its knobs
#[macro_export]
macro_rules! params {
    (
        $(#[doc = $table_doc:literal])+
        $name:ident in $table:ident $(, needs $table_need:literal)* {
            $(
                $(#[doc = $doc:literal])+
                $field:ident: $ty:ty = $default:expr
                    $(, in $range:expr $(, as $wrap:ident)?)? $(, or $unset:literal)?
                    $(, clears $other:ident)? $(, was $old:literal)? $(, needs $need:literal)*;
            )+
        }
    ) => {
        $(#[doc = $table_doc])+
        #[derive(Clone, Debug, PartialEq)]
        pub struct $name {
            $(
                $(#[doc = $doc])+
                #[doc = concat!(
                    "\n\n" $(, "Range `", stringify!($range), "`. ")?, "Default `", stringify!($default), "`."
                )]
                pub $field: $ty,
            )+
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($field: $default),+ }
            }
        }

        impl $name {
            /// Declaration of the table.
            pub const TABLE: $crate::TableInfo = $crate::TableInfo {
                name: stringify!($table),
                doc: concat!($($table_doc, "\n"),+),
                needs: &[$($table_need),*],
                knobs: &[$($crate::Knob {
                    name: concat!(stringify!($table), ".", stringify!($field)),
                    was: &[$($old)?],
                    doc: concat!($($doc, "\n"),+),
                    needs: &[$($need),*],
                    expected: || {
                        let range = $crate::params!(@range $($range)?);
                        let expected = $crate::params!(@field expected, $ty $($(, $wrap)?)?)(&range);
                        $(let expected = format!("{:?} or {expected}", $unset);)?
                        expected
                    },
                    control: || {
                        $crate::params!(@field control, $ty $($(, $wrap)?)?)(&$crate::params!(@range $($range)?))
                    },
                    parse_word: |word| {
                        $(if word == $unset {
                            return $crate::Raw::String($unset.to_owned());
                        })?
                        $crate::params!(@field parse_word, $ty $($(, $wrap)?)?)(word)
                    },
                }),+],
            };

            /// Checks every field against its range.
            ///
            /// Fails with the first value outside its range, with what was found and what was expected.
            pub fn validate(&self) -> Result<(), $crate::OutOfRange> {
                $crate::validate_table(self)
            }
        }

        impl $crate::Table for $name {
            fn knobs(&self) -> &'static [$crate::Knob] {
                Self::TABLE.knobs
            }

            fn read(&mut self, key: &str, raw: &$crate::Raw) -> Result<(), String> {
                match key {
                    $(stringify!($field) => {
                        let range = $crate::params!(@range $($range)?);
                        self.$field = $crate::params!(@read [$ty $($(, $wrap)?)?] $(or $unset)?)(raw, &range)?;
                        $(self.$other = Default::default();)?
                    })+
                    _ => return Err("unknown key".to_owned()),
                }
                Ok(())
            }

            fn write(&self, key: &str) -> Option<String> {
                match key {
                    $(stringify!($field) => {
                        let written = $crate::Field::to_toml(&self.$field);
                        $(let written = written.or_else(|| Some(format!("{:?}", $unset)));)?
                        written
                    })+
                    _ => None,
                }
            }

            fn check(&self, key: &str) -> Result<(), String> {
                match key {
                    $(stringify!($field) => {
                        let value = &self.$field;
                        $($(let value = &$wrap(*value);)?)?
                        $crate::Field::check(value, &$crate::params!(@range $($range)?))
                    })+
                    _ => Err("unknown key".to_owned()),
                }
            }
        }
    };
    (@range) => { () };
    (@range $range:expr) => { $range };
    (@field $call:ident, $ty:ty) => { <$ty as $crate::Field>::$call };
    (@field $call:ident, $ty:ty, $wrap:ident) => { <$wrap as $crate::Field>::$call };
    (@read [$ty:ty]) => { |raw: &$crate::Raw, range| <$ty as $crate::Field>::read(raw, range) };
    (@read [$ty:ty, $wrap:ident]) => {
        |raw: &$crate::Raw, range| <$wrap as $crate::Field>::read(raw, range).map(|value| value.0)
    };
    (@read [$($field:tt)+] or $unset:literal) => {
        |raw: &$crate::Raw, range| match raw {
            $crate::Raw::String(word) if word == $unset => Ok(Default::default()),
            _ => $crate::params!(@read [$($field)+])(raw, range).map_err(|_| {
                raw.unexpected(&format!("{:?} or {}", $unset, $crate::params!(@field expected, $($field)+)(range)))
            }),
        }
    };
}

/// Declares the contents of one file: a struct with a field for each table, and its [`Tables`](crate::Tables). The text
/// after `such as` is the example of `key=value` in messages. `elsewhere` names the function
/// [`Tables::unavailable_reason`](crate::Tables::unavailable_reason). A table may have one `#[cfg]`.
#[macro_export]
macro_rules! tables {
    (
        $(#[$meta:meta])*
        pub struct $name:ident, such as $example:literal $(, elsewhere $elsewhere:path)? {
            $($(#[doc = $doc:literal])+ $(#[cfg($cfg:meta)])? $table:ident: $ty:ty,)+
        }
    ) => {
        $(#[$meta])*
        #[derive(Clone, Debug, Default, PartialEq)]
        pub struct $name { $($(#[doc = $doc])+ $(#[cfg($cfg)])? pub $table: $ty,)+ }

        $(
            $(#[cfg($cfg)])?
            const _: () = assert!(
                $crate::str_eq(<$ty>::TABLE.name, stringify!($table)),
                "a table must have the name of its field"
            );
        )+

        impl $crate::Tables for $name {
            const TABLES: &'static [$crate::TableInfo] = &[$($(#[cfg($cfg)])? <$ty>::TABLE),+];
            const EXAMPLE: &'static str = $example;

            fn tables(&self) -> Vec<&dyn $crate::Table> {
                [$($(#[cfg($cfg)])? (&self.$table as &dyn $crate::Table)),+].into()
            }

            fn tables_mut(&mut self) -> Vec<&mut dyn $crate::Table> {
                [$($(#[cfg($cfg)])? (&mut self.$table as &mut dyn $crate::Table)),+].into()
            }
            $(
                fn unavailable_reason(name: &str) -> Option<String> {
                    $elsewhere(name)
                }
            )?
        }
    };
}
