// Uniform blocks of every pass.

// Uniform block, one per frame. 192 bytes.
struct Frame {
    clip_from_world: mat4x4<f32>,
    // Eye position and 1, or for an orthographic camera the direction towards it and 0.
    eye_ws: vec4<f32>,
    // Position of the key light and 1, or for a directional light the unit direction towards it and 0.
    light_ws: vec4<f32>,
    // Transform from world space to the shadow maps: (u w, v w, depth, w).
    map_from_world: mat4x4<f32>,
    // Soft shadow: metres of depth, penumbra, blur, texel size.
    soft_shadow: vec4<f32>,
    // Index of the last layer-wise map.
    last_map_layer: f32,
    // Number of lights without shadow.
    fill_lights: u32,
    // Factor on the layers' optical depth for the key light.
    hair_density: f32,
    // Peak irradiance of the environment over pi, in its strongest channel.
    environment_most: f32,
}

// Light without shadow. 32 bytes.
struct FillLight {
    // Position or direction, as Frame.light_ws.
    light_ws: vec4<f32>,
    // Linear RGB; w is 0.
    color: vec4<f32>,
}

// Uniform block, one per drawn instance and frame: transform, and constants of fur lighting. 256 bytes.
struct Instance {
    world_from_model: mat4x4<f32>,
    // Columns of the normal matrix: signed cofactors of world_from_model; w is zero.
    normal_x: vec4<f32>,
    normal_y: vec4<f32>,
    normal_z: vec4<f32>,
    // ka, kd and ks, each times the colour of its light.
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
    // Scale factor of lengths, for the fur height.
    scale: f32,
    // -1 for a mirrored instance, else 1.
    handedness: f32,
    // Share of the layers' opacity that remains beside single strands.
    layer_share: f32,
    baked_layers: u32,
    drawn_layers: u32,
    // Highlight of wet hair relative to that of dry hair.
    wet_specular: f32,
    // ps / 2 of wet hair
    wet_specular_half_exponent: f32,
    // kd and ks alone, for lights other than the key light.
    diffuse_constant: vec3<f32>,
    // Mip level of the hair, a whole number, at which its texels match those of the target in size: pixels, or texels
    // of the shadow maps.
    map_level: f32,
    specular_constant: vec3<f32>,
    // Levels of detail. detail_here: density of the level, times the share that the far fur layer leaves of it.
    // layer_step: step between drawn layers; layers_gone: number of those that have changed to the next level.
    // detail_next: density of the next level, or share of the far fur layer if that is next.
    detail_here: f32,
    layer_step: u32,
    layers_gone: f32,
    detail_next: f32,
    // Factor on the fins' opacity.
    fin_share: f32,
    // Far fur layer: its height, and the height of its ambient light, as shares of the fur height; arguments of
    // coat_light.
    coat_height: f32,
    coat_ambient_height: f32,
    coat_light_base: f32,
    coat_light_slope: f32,
}

// Returns the unit vector from a point towards a light or eye in homogeneous coordinates (formulas 1.1).
fn direction_to(target_ws: vec4<f32>, position_ws: vec3<f32>) -> vec3<f32> {
    let d = target_ws.xyz - position_ws * target_ws.w;
    return d * inverseSqrt(max(dot(d, d), 1e-30));
}

// Returns the unit half vector between two unit vectors; zero if they are opposed (formulas 1.1).
fn half_vector(l: vec3<f32>, v: vec3<f32>) -> vec3<f32> {
    let h = l + v;
    return h * inverseSqrt(max(dot(h, h), 1e-12));
}
