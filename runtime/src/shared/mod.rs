//! Shader functions that several passes use, each as `<topic>.wgsl` with a Rust twin `<topic>.rs` beside it: same function
//! names, same argument order. The twins serve tests, tools and applications that want the same numbers on the CPU. The numbers of
//! formulas are those of `formats/docs/formulas.md`.
//!
//! Each topic's `WGSL` is plain source without entry points or bindings; join it before your own shader.

/// Deep opacity maps: how much hair of a texel lies before a place in the light (formulas 4.10).
pub mod deep_opacity;
/// Levels of detail: which layers of hair a level draws, and how many layers each stands for (formulas 4.7, 4.8).
pub mod detail;
/// Light that is spread about a direction, as skies are (formulas 4.14, 4.15).
pub mod environment;
/// How much of a fin shows, and of the shells beside it (formulas 4.6).
pub mod fins;
/// Where camera, light and the drawn copy stand: the uniform blocks of every pass.
pub mod frame;
/// The ink-wash style: sphere map, features, lines, wash (Fang 2006; formulas 5.1, 5.2, 5.3).
pub mod ink;
/// Yang 2006, eq. (1), and the attenuations of eqs. (2) and (3) that need no map (formulas 4.1).
pub mod kajiya_kay;
/// Layer-wise shadow maps: what a layer of hair leaves of the light (formulas 4.2).
pub mod layer_shadow;
/// Opacity of a layer when more or fewer layers are drawn than were baked, and of a slanted look (formulas 3.2, 4.5).
pub mod opacity;
/// The key light's shadows on the application's own geometry.
pub mod receiver;
/// Fibres that scatter light, and light that goes from fibre to fibre (formulas 4.12, 4.13).
pub mod scattering;
/// Linear blend skinning: blended matrix, normals, tangents (formulas 2.2, 2.3).
pub mod skinning;
/// Soft shadows from a shadow-width map (formulas 4.4).
pub mod soft_shadow;
/// Colours as displays encode them (formulas 1.2).
pub mod srgb;
/// The hair tile's frame on the skin, and directions in it (formulas 2.4, 2.5).
pub mod tile_frame;
/// How much light reaches hair past other strands, as packages know it (formulas 4.9).
pub mod visibility;
