// The uniform blocks of every pass.

// Once per frame. 192 bytes.
struct Frame {
    clip_from_world: mat4x4<f32>,
    // Eye position and 1, or for an orthographic camera the direction towards it and 0.
    eye_ws: vec4<f32>,
    // Position of the key light and 1, or for a directional light the unit direction towards it and 0.
    light_ws: vec4<f32>,
    // World to the shadow maps: (u w, v w, depth, w).
    map_from_world: mat4x4<f32>,
    // Soft shadow: metres of depth, penumbra, blur, size of a texel.
    soft_shadow: vec4<f32>,
    // Index of the last of the layer-wise maps.
    last_map_layer: f32,
    // Number of lights without shadow.
    fill_lights: u32,
    // Share of the layers' optical depth that the key light meets.
    hair_density: f32,
    // Irradiance of the environment where it is most, over pi, in its strongest channel.
    environment_most: f32,
}

// A light without shadow. 32 bytes.
struct FillLight {
    // As Frame.light_ws.
    light_ws: vec4<f32>,
    // Linear RGB, 0.
    color: vec4<f32>,
}

// Once per drawn copy and frame: where it stands and how its fur is lit. 256 bytes.
struct Instance {
    world_from_model: mat4x4<f32>,
    // Columns of the matrix for normals: the signed cofactors of world_from_model; w is zero.
    normal_x: vec4<f32>,
    normal_y: vec4<f32>,
    normal_z: vec4<f32>,
    // ka, kd and ks times the key light's colours.
    ambient: vec3<f32>,
    // pd / 2
    diffuse_half_exponent: f32,
    diffuse: vec3<f32>,
    // ps / 2
    specular_half_exponent: f32,
    specular: vec3<f32>,
    // r of Attenu_Back
    back_light_range: f32,
    // epsilon of gamma
    ambient_floor: f32,
    // Scale of lengths, for the fur's height.
    scale: f32,
    // -1 for a mirrored copy, else 1.
    handedness: f32,
    // Share of the layers' opacity that single strands leave.
    layer_share: f32,
    baked_layers: u32,
    drawn_layers: u32,
    // Highlight of wet hair over that of dry hair.
    wet_specular: f32,
    // ps / 2 of wet hair
    wet_specular_half_exponent: f32,
    // kd and ks alone, for the other lights.
    diffuse_constant: vec3<f32>,
    // Mip level of the hair whose texels are as large as those of the target, pixels or texels of the shadow maps, whole.
    map_level: f32,
    specular_constant: vec3<f32>,
    // Levels of detail: density of the level, times what the far coat leaves of it; every how many layers is drawn, and how many of those have
    // gone over to the next level; density of that one, or share of the far coat where it is the next.
    detail_here: f32,
    layer_step: u32,
    layers_gone: f32,
    detail_next: f32,
    // Share of the fins' opacity.
    fin_share: f32,
    // Of the far coat: share of the fur's height where it lies, and whose ambient light it has; how the key light reaches it.
    coat_height: f32,
    coat_ambient_height: f32,
    coat_light_base: f32,
    coat_light_slope: f32,
}

// Unit vector from a point towards a light or eye given as homogeneous coordinates.
fn direction_to(target_ws: vec4<f32>, position_ws: vec3<f32>) -> vec3<f32> {
    let d = target_ws.xyz - position_ws * target_ws.w;
    return d * inverseSqrt(max(dot(d, d), 1e-30));
}

// Unit half vector between two unit vectors; zero where they are opposed.
fn half_vector(l: vec3<f32>, v: vec3<f32>) -> vec3<f32> {
    let h = l + v;
    return h * inverseSqrt(max(dot(h, h), 1e-12));
}
