//! `slice`: strands → shell and direction texture arrays with mips; and the encoding of all textures as .ktx2 files.
//!
//! [`slice()`] hands out layer after layer, outermost first, so that a volume larger than memory can be written;
//! [`shell_textures`] joins it to the encoder and is what a bake calls.

pub mod direction;
mod encode;
mod layer;
mod shells;
mod slice;
mod splat;
mod srgb;

pub use encode::{AlphaMode, RawLevel, TextureEncoder, encode_base_color, encode_groom};
pub use shells::{ShellTextures, shell_textures};
pub use slice::{Layer, ShellSet, collect_layers, slice};
pub use splat::EXTINCTION;
pub use srgb::{linear_to_srgb, srgb_to_linear, srgb_value_to_linear};
