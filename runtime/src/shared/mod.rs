//! Shader functions used by several passes. Each topic is a file `<topic>.wgsl` with a Rust counterpart `<topic>.rs`:
//! same function names, same argument order. The Rust functions serve tests, tools and applications that need the same
//! numbers on the CPU. Formula numbers refer to `formats/docs/formulas.md`.
//!
//! The constant `WGSL` of a topic is plain source without entry points or bindings; join it before your own shader.

/// Deep opacity maps: optical depth of the hair between the light and a point (formulas 4.10).
pub mod deep_opacity;
/// Levels of detail: which hair layers a level draws, and how many layers each of them represents (formulas 4.7, 4.8).
pub mod detail;
/// Light that is spread about a direction, such as sky light (formulas 4.14, 4.15).
pub mod environment;
/// Visibility of fins by viewing angle (formulas 4.6).
pub mod fins;
/// Uniform blocks that all passes use: camera, light and drawn instance.
pub mod frame;
/// Gloss of bare surface: highlights and mirrored light (formulas 4.16).
pub mod gloss;
/// Ink-wash style: sphere map, features, lines, wash (Fang 2006; formulas 5.1, 5.2, 5.3).
pub mod ink;
/// Kajiya-Kay shading, Yang 2006, eq. (1), and the attenuations of eqs. (2) and (3) that need no map (formulas 4.1).
pub mod kajiya_kay;
/// Layer-wise shadow maps: transmittance of a hair layer (formulas 4.2).
pub mod layer_shadow;
/// Opacity of a layer if the number of drawn layers differs from that of baked layers, and along an inclined view
/// direction (formulas 3.2, 4.5).
pub mod opacity;
/// Shadows that the application's own geometry receives from the key light.
pub mod receiver;
/// Light scattering by fibres, and between fibres (formulas 4.12, 4.13).
pub mod scattering;
/// Declaration of structs in shader layout.
pub(crate) mod shader_struct;
/// Linear blend skinning: blended matrix, normals, tangents (formulas 2.2, 2.3).
pub mod skinning;
/// Soft shadows from a shadow-width map (formulas 4.4).
pub mod soft_shadow;
/// Decoding and encoding of sRGB colours (formulas 1.2).
pub mod srgb;
/// Frame of the hair tile on the mesh surface, and directions in it (formulas 2.4, 2.5).
pub mod tile_frame;
/// Tone mapping of bright colours (formulas 1.4).
pub mod tone;
/// Baked visibility: share of light that other strands let through to hair (formulas 4.9).
pub mod visibility;
