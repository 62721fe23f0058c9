//! What stored numbers mean: written once, for the tool, the runtime, the truths and the tests.

mod skinning;
mod srgb;
mod view;

pub use skinning::{skin_matrix, transform_normal};
pub use srgb::{linear_to_srgb, srgb_to_linear, srgb_value_to_linear};
pub use view::{up_of_view, view_from_world};
