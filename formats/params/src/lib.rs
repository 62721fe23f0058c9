//! Knobs that are declared once.
//!
//! [`params!`] declares a table of knobs: a struct whose fields each have a meaning, a default and a range. [`tables!`] puts such
//! tables together to what a file says: a recipe, a look. From these declarations follow the struct and its defaults, reading TOML with
//! errors that name line and key ([`read`], [`read_table`]), setting one value by `key=value` ([`set`], [`set_word`]), writing
//! ([`to_toml`], [`to_documented_toml`]), checking ([`validate`]), what a slider needs ([`Knob::control`]) and a reference page
//! ([`reference_page`]); so none of these can disagree with another. A key that does not exist is an error that names the nearest one
//! that does: a mistyped key must never pass for a setting that has no effect.
//!
//! ```
//! use pelage_params::{params, set, tables, words};
//! words! {
//!     /// How a strand is bent.
//!     Style {
//!         /// Not at all.
//!         #[default]
//!         Straight = "straight",
//!         /// Into helices.
//!         Curly = "curly",
//!     }
//! }
//! params! {
//!     /// `[hair]`: the strands.
//!     HairParams in hair {
//!         /// How strands are bent.
//!         style: Style = Style::Straight;
//!         /// How far strands lean: 0 upright, 1 lying on the skin.
//!         lean: f32 = 0.4, in 0.0..=1.0;
//!         /// Length, metres. Left out, it is chosen from the model's size.
//!         length_m: Option<f32> = None, in 1e-6..=1e3;
//!     }
//! }
//! tables! {
//!     /// What steers everything.
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
pub use knob::{Knob, Table, TableInfo, Tables, knobs, same, validate, validate_table};
pub use list::Item;
pub use nearest::{closest, nearest, unknown_key};
pub use page::{reference_page, wrap};
pub use raw::Raw;
pub use text::{read, read_table, set, set_word, to_documented_toml, to_noted_toml, to_toml};

#[cfg(test)]
mod tests;
