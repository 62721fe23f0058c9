//! `slice`: strands → shell, fin and direction texture arrays with mips. Also encodes all textures as .ktx2 files.
//!
//! [`slice()`] outputs one layer at a time, outermost first, so that a volume larger than memory can be written.
//! [`shell_textures`] combines it with the encoder and is called by a bake. [`fin_textures`] shows the same strands
//! from the side.

mod decode;
pub mod direction;
mod encode;
mod far_fur;
mod layer;
mod shells;
mod slab;
mod splat;
mod volume;

pub use decode::decode_texture;
pub use encode::{AlphaMode, RawLevel, TextureEncoder, encode_base_color, encode_groom};
pub use far_fur::FarFurStats;
pub use shells::{ShellTextures, VisibilityTexture, shell_bytes, shell_textures};
pub use slab::{FIN_SLICES, FinSlice, FinTextures, fin_slice_along, fin_textures};
pub use splat::extinction;
pub(crate) use splat::weights as gaussian_weights;
pub use volume::{Layer, ShellSet, collect_layers, slice, slice_for_package};
