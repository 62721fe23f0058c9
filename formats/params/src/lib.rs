//! Declarative configuration knobs.
//!
//! [`params!`] declares a table of knobs: a struct whose fields each have a meaning, a default and a range. [`tables!`]
//! combines such tables into the contents of one file: a recipe, a look.
//!
//! These declarations generate the struct and its defaults, TOML reading with errors that name line and key ([`read`],
//! [`read_table`]), and setting one value by `key=value` ([`set`], [`set_word`]). They also provide writing
//! ([`to_toml`], [`to_documented_toml`]), checking ([`validate`]), slider metadata ([`Knob::control`]) and a reference
//! page ([`reference_page`]), so that all of these agree. An unknown key is an error that names the nearest known key,
//! so a mistyped key is never silently ignored.
//!
//! ```
//! use pelage_params::{params, set, tables, words};
//! words! {
//!     /// Shape of a strand.
//!     Style {
//!         /// Straight line.
//!         #[default]
//!         Straight = "straight",
//!         /// Helix.
//!         Curly = "curly",
//!     }
//! }
//! params! {
//!     /// `[hair]`: the strands.
//!     HairParams in hair {
//!         /// Shape of the strands.
//!         style: Style = Style::Straight;
//!         /// Lean of the strands: 0 upright, 1 flat on the surface.
//!         lean: f32 = 0.4, in 0.0..=1.0;
//!         /// Length, metres. Left out, it is chosen from the model's size.
//!         length_m: Option<f32> = None, in 1e-6..=1e3;
//!     }
//! }
//! tables! {
//!     /// All settings.
//!     pub struct Recipe, such as "hair.lean=0.5" {
//!         /// The strands.
//!         hair: HairParams,
//!     }
//! }
//! let mut recipe = Recipe::default();
//! pelage_params::read(&mut recipe, "[hair]\nstyle = \"curly\"\nlean = 0.5\n")?;
//! set(&mut recipe, "hair.length_m=0.03")?;
//! assert_eq!((recipe.hair.style, recipe.hair.lean, recipe.hair.length_m), (Style::Curly, 0.5, Some(0.03)));
//! let error = pelage_params::read(&mut recipe, "[hair]\nlaen = 0.5\n").unwrap_err().to_string();
//! assert_eq!(error, "line 2, hair.laen: unknown key; did you mean hair.lean?");
//! # Ok::<(), pelage_params::ParamError>(())
//! ```

mod control;
mod error;
mod field;
mod glob;
mod knob;
mod list;
mod macros;
mod nearest;
mod page;
mod raw;
mod text;

pub use control::{Choice, Control, TableKey};
pub use error::{OutOfRange, ParamError};
pub use field::{Field, PowerOfTwo, Range, SrgbColor, hex};
pub use glob::glob;
pub use knob::{Knob, Table, TableInfo, Tables, knobs, str_eq, validate, validate_table};
pub use list::Item;
pub use nearest::{closest, nearest, unknown_key};
pub use page::{reference_page, wrap};
pub use raw::Raw;
pub use text::{read, read_table, set, set_word, to_documented_toml, to_noted_toml, to_toml};

#[cfg(test)]
mod tests;
