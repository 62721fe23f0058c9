use super::{layer_shadow, soft_shadow};
use bytemuck::{Pod, Zeroable};
use glam::{Mat4, Vec3, Vec4};

/// WGSL source. In contrast to other topics, it includes its dependencies, [`layer_shadow::WGSL`] and
/// [`soft_shadow::WGSL`]: do not join those as well.
///
/// Besides the counterparts of this module's functions, it declares a function for the application's fragment shader.
/// The function returns 0 for dark and 1 for lit:
///
/// ```wgsl
/// fn light_received(
///     width_map: texture_2d<f32>, // Frame::shadow_map
///     map_sampler: sampler,       // linear
///     position_ws: vec3<f32>,
///     n_dot_l: f32,               // cosine between the normal there and the direction towards the light
///     receiver: ShadowReceiver,   // Frame::shadow_receiver, from a uniform buffer
/// ) -> f32
/// ```
pub const WGSL: &str =
    concat!(include_str!("layer_shadow.wgsl"), include_str!("soft_shadow.wgsl"), include_str!("receiver.wgsl"));

/// Uniform block for `light_received`: transform to the shadow maps, and scales of their values. 96 bytes, in the
/// layout of the WGSL structure of the same name.
///
/// [`crate::Frame::shadow_receiver`] fills it. The default, all zero, casts no shadow.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct ShadowReceiver {
    /// Transform from world space to the shadow maps, [`crate::LightView::map_from_world`].
    pub map_from_world: Mat4,
    /// Scales of the shadow-width map.
    pub soft_shadow: soft_shadow::SoftShadow,
    /// 1 if the penumbra extends to both sides of the hard edge, 0 if only inwards.
    pub centred: u32,
    /// Padding, zero.
    pub reserved: [u32; 3],
}

impl Default for ShadowReceiver {
    fn default() -> Self {
        Self::zeroed()
    }
}

impl ShadowReceiver {
    /// Returns the map coordinates of a world-space point in the form that [`light_at_place`] expects: (u·w, v·w,
    /// depth, w).
    pub fn map_coordinates(&self, position_ws: Vec3) -> Vec4 {
        self.map_from_world * position_ws.extend(1.0)
    }
}

/// Returns the share of the key light that arrives at a point past occluders and through the hair above, 0..=1. The
/// result is 1 outside the maps, sideways and in depth.
///
/// * `texel` - texel of the shadow-width map at `place.xy / place.w`
/// * `place` - [`ShadowReceiver::map_coordinates`] of the point
/// * `n_dot_l` - cosine between the normal at the point and the direction towards the light
pub fn light_at_place(texel: Vec4, place: Vec4, n_dot_l: f32, receiver: &ShadowReceiver) -> f32 {
    let inside = place.w > 0.0 && place.min_element() >= 0.0 && place.x.max(place.y) <= place.w && place.z <= 1.0;
    if !inside {
        return 1.0;
    }
    let path = layer_shadow::slanted_path(n_dot_l);
    let past = soft_shadow::soft_shadow(texel, place.z, place.w, path, &receiver.soft_shadow, receiver.centred != 0);
    past * texel.w
}
