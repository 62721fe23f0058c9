//! Shader functions that several passes use, each as `<topic>.wgsl` with a Rust twin `<topic>.rs` beside it: same function
//! names, same argument order. The twins serve tests, tools and applications that want the same numbers on the CPU.
//!
//! Each topic's `WGSL` is plain source without entry points or bindings; join it before your own shader.

/// Levels of detail: which layers of hair a level draws, and how many layers each stands for.
pub mod detail;
/// How much of a fin shows, and of the shells beside it.
pub mod fins;
/// Where camera, light and the drawn copy stand: the uniform blocks of every pass.
pub mod frame;
/// The ink-wash style: sphere map, features, lines, wash (Fang 2006).
pub mod ink;
/// Yang 2006, eq. (1), and the attenuations of eqs. (2) and (3) that need no map.
pub mod kajiya_kay;
/// Layer-wise shadow maps: what a layer of hair leaves of the light.
pub mod layer_shadow;
/// Opacity of a layer when more or fewer layers are drawn than were baked.
pub mod opacity;
/// The key light's shadows on the application's own geometry.
pub mod receiver;
/// Linear blend skinning: blended matrix, normals, tangents.
pub mod skinning;
/// Soft shadows from a shadow-width map.
pub mod soft_shadow;
/// Colours as displays encode them.
pub mod srgb;
/// The hair tile's frame on the skin, and directions in it.
pub mod tile_frame;
