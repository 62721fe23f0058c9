//! Meaning of the numbers in a package, defined once for all readers: posed vertices, points of hair, layers per level
//! of detail, opacity of fins, colour encoding and camera orientation.
//!
//! The runtime's shaders implement the same in WGSL. Its tests compare the shader, the function and an f64 reference.
//! The functions for points of hair accept f32 and f64, because single hairs seen from afar can only be traced in f64.

mod bare_normal;
mod direction;
pub mod environment;
mod far_layer;
mod fins;
pub mod fur_motion;
mod groom;
pub mod hair_groups;
pub mod hair_motion;
mod hair_point;
mod layers;
mod measured;
pub mod openness;
pub mod planting;
mod root;
pub mod scattering;
pub mod seal;
mod skinning;
mod srgb;
mod tile_frame;
pub mod tone;
mod view;
mod visibility;

pub use bare_normal::{decode_bare_normal, encode_bare_normal};
pub use direction::{decode_direction, encode_direction};
pub use far_layer::{far_layer_light, far_layer_light_coefficients};
pub use fins::{FIN_CORNERS, LEANING_ROWS, fin_face, fin_opacity, fin_rows, row_heights};
pub use groom::{groom_bytes, groom_of_vertex, groom_with_texel};
pub use hair_point::{grown_tangent, hair_direction, hair_offset, lean_offset, lean_slope};
pub use layers::{
    MOST_DEVIATION_PX, TOTAL_MAP_LAYERS, detail_count, detail_fade, detail_layer, detail_pairs, detail_position,
    layer_height, represented_layers, simplest_list,
};
pub use measured::{
    hidden_scales, key_values, largest_shifts, measured_pose, measured_vertices, shown, shown_vertices,
};
pub use root::{RootOffset, root_offset};
pub use skinning::{
    HIDDEN_SIZE, blend, handedness_of, morphed, normalize_or, posed, posed_vertices, skin_matrix, transform_normal,
    weighted,
};
pub use srgb::{linear_to_srgb, luminance, srgb_to_linear, srgb_value_to_linear};
pub use tile_frame::{TileFrame, any_perpendicular, orthonormal_tangent, tile_axes_f64, tile_frame, to_tile};
pub use view::{up_of_view, view_axes, view_from_world};
pub use visibility::{VISIBILITY_MEAN_Z, above_horizon, encode_visibility, light_in_tile, visibility_towards};
