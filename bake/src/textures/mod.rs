//! Shell, direction and base-colour textures.

mod encode;
mod srgb;

pub use encode::{RawLevel, TextureEncoder, encode_base_color};
pub use srgb::{linear_to_srgb, srgb_to_linear};
