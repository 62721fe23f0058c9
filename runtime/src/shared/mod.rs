//! Shader functions used by several passes, each as `<topic>.wgsl` with a Rust twin `<topic>.rs` beside it: same
//! function names, same argument order. The twins serve tests, tools and applications that need the same numbers on the
//! CPU. Formula numbers refer to `formats/docs/formulas.md`.
//!
//! Each topic's `WGSL` is plain source without entry points or bindings; join it before your own shader.

/// Deep opacity maps: amount of a texel's hair in front of a point in the light (formulas 4.10).
pub mod deep_opacity;
/// Levels of detail: which layers of hair a level draws, and how many layers each stands for (formulas 4.7, 4.8).
pub mod detail;
/// Light spread about a direction, as from skies (formulas 4.14, 4.15).
pub mod environment;
/// Visibility of fins by viewing angle (formulas 4.6).
pub mod fins;
/// Uniform blocks of every pass: camera, light and drawn instance.
pub mod frame;
/// Ink-wash style: sphere map, features, lines, wash (Fang 2006; formulas 5.1, 5.2, 5.3).
pub mod ink;
/// Kajiya-Kay shading, Yang 2006, eq. (1), and the attenuations of eqs. (2) and (3) that need no map (formulas 4.1).
pub mod kajiya_kay;
/// Layer-wise shadow maps: transmittance of a hair layer (formulas 4.2).
pub mod layer_shadow;
/// Opacity of a layer if more or fewer layers are drawn than were baked, and along a slanted view direction (formulas
/// 3.2, 4.5).
pub mod opacity;
/// Shadows of the key light on the application's own geometry.
pub mod receiver;
/// Light scattering by fibres, and between fibres (formulas 4.12, 4.13).
pub mod scattering;
/// Linear blend skinning: blended matrix, normals, tangents (formulas 2.2, 2.3).
pub mod skinning;
/// Soft shadows from a shadow-width map (formulas 4.4).
pub mod soft_shadow;
/// sRGB encoding of colours (formulas 1.2).
pub mod srgb;
/// Frame of the hair tile on the mesh surface, and directions in it (formulas 2.4, 2.5).
pub mod tile_frame;
/// Baked visibility: share of light that reaches hair past other strands (formulas 4.9).
pub mod visibility;
