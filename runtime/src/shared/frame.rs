use crate::shared::shader_struct::shader_struct;
use bytemuck::{Pod, Zeroable};
use glam::{Vec3, Vec4};

/// WGSL source of this topic.
pub const WGSL: &str = include_str!("frame.wgsl");

shader_struct! {
    /// Uniform block, one per frame.
    pub(crate) struct Frame {
        pub clip_from_world: [[f32; 4]; 4],
        pub eye_ws: [f32; 4],
        pub light_ws: [f32; 4],
        pub map_from_world: [[f32; 4]; 4],
        pub soft_shadow: [f32; 4],
        pub last_map_layer: f32,
        pub fill_lights: u32,
        pub hair_density: f32,
        pub environment_most: f32,
        pub environment_even: [f32; 3],
        pub environment_lobes: u32,
    }
}

/// Fill light, which casts no shadow, in shader layout.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct FillLight {
    pub light_ws: [f32; 4],
    pub color: [f32; 4],
}

shader_struct! {
    /// Uniform block, one per drawn instance and frame. The WGSL file describes the fields.
    pub(crate) struct Instance {
        pub world_from_model: [[f32; 4]; 4],
        pub normal_x: [f32; 4],
        pub normal_y: [f32; 4],
        pub normal_z: [f32; 4],
        pub ambient: [f32; 3],
        pub diffuse_half_exponent: f32,
        pub diffuse: [f32; 3],
        pub specular_half_exponent: f32,
        pub specular: [f32; 3],
        pub back_light_range: f32,
        pub ambient_floor: f32,
        pub scale: f32,
        pub handedness: f32,
        pub layer_share: f32,
        pub baked_layers: u32,
        pub drawn_layers: u32,
        pub wet_specular: f32,
        pub wet_specular_half_exponent: f32,
        pub diffuse_constant: [f32; 3],
        pub map_level: f32,
        pub specular_constant: [f32; 3],
        pub detail_here: f32,
        pub layer_step: u32,
        pub layers_gone: f32,
        pub detail_next: f32,
        pub fin_share: f32,
        pub coat_height: f32,
        pub coat_ambient_height: f32,
        pub coat_light_base: f32,
        pub coat_light_slope: f32,
    }
}

/// Returns the unit vector from `position_ws` towards a light or eye. `target_ws` is in homogeneous coordinates: w is 1
/// for a position, 0 for a direction.
pub fn direction_to(target_ws: Vec4, position_ws: Vec3) -> Vec3 {
    let d = target_ws.truncate() - position_ws * target_ws.w;
    d * d.dot(d).max(1e-30).sqrt().recip()
}

/// Returns H of Yang 2006, eq. (1): the unit half vector between two unit vectors; zero if they are opposite.
pub fn half_vector(l: Vec3, v: Vec3) -> Vec3 {
    let h = l + v;
    h * h.dot(h).max(1e-12).sqrt().recip()
}
