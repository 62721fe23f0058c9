// Uniform blocks that all passes use.

// Uniform block, one per frame. Size: 208 bytes.
struct Frame {
    clip_from_world: mat4x4<f32>,
    // Eye position with w = 1; for an orthographic camera, the direction towards the eye with w = 0.
    eye_ws: vec4<f32>,
    // Position of the key light with w = 1; for a directional light, the unit direction towards it with w = 0.
    light_ws: vec4<f32>,
    // Transform from world space to the shadow maps: (u w, v w, depth, w).
    map_from_world: mat4x4<f32>,
    // Constants of soft shadows: distance between depth 0 and depth 1, metres; penumbra; blur; texel size.
    soft_shadow: vec4<f32>,
    // Index of the last layer-wise map.
    last_map_layer: f32,
    // Number of fill lights.
    fill_lights: u32,
    // Factor on the layers' optical depth for the key light.
    hair_density: f32,
    // Peak irradiance of the environment divided by pi, in its strongest channel.
    environment_most: f32,
    // Uniform radiance of the environment.
    environment_even: vec3<f32>,
    // Number of lobes of the environment, which follow the fill lights.
    environment_lobes: u32,
}

// Fill light, which casts no shadow, or a lobe of the environment. Size: 32 bytes.
struct FillLight {
    // Position or direction, in the form of Frame.light_ws. For a lobe, its axis, with the sharpness in w.
    light_ws: vec4<f32>,
    // Linear RGB, for a lobe the radiance at its centre; w is 0.
    color: vec4<f32>,
}

// Uniform block, one per drawn instance and frame: transform, and constants of fur lighting. Size: 256 bytes.
struct Instance {
    world_from_model: mat4x4<f32>,
    // Columns of the normal matrix: signed cofactors of world_from_model; w is zero.
    normal_x: vec4<f32>,
    normal_y: vec4<f32>,
    normal_z: vec4<f32>,
    // Coefficient ka times the ambient light.
    ambient: vec3<f32>,
    // Half the diffuse exponent, pd / 2.
    diffuse_half_exponent: f32,
    // Coefficient kd times the colour of the key light.
    diffuse: vec3<f32>,
    // Half the specular exponent, ps / 2.
    specular_half_exponent: f32,
    // Coefficient ks times the colour of the key light.
    specular: vec3<f32>,
    // Range r of Attenu_Back.
    back_light_range: f32,
    // Constant epsilon of gamma: share of the ambient light at the mesh surface.
    ambient_floor: f32,
    // Length scale of the instance, for the fur height.
    scale: f32,
    // -1 for a mirrored instance, else 1.
    handedness: f32,
    // Share of the layers' opacity that remains while single strands are also drawn.
    layer_share: f32,
    baked_layers: u32,
    drawn_layers: u32,
    // Highlight of wet hair, relative to that of dry hair.
    wet_specular: f32,
    // Half the specular exponent of wet hair, ps / 2.
    wet_specular_half_exponent: f32,
    // Coefficient kd without the colour of the key light, for other lights.
    diffuse_constant: vec3<f32>,
    // Mip level, a whole number, at which hair texels are as large as those of the target. The target is the picture or
    // the shadow maps.
    map_level: f32,
    // Coefficient ks without the colour of the key light, for other lights.
    specular_constant: vec3<f32>,
    // Density of the level of detail, times the share that the far fur layer leaves of it.
    detail_here: f32,
    // Stride between drawn layers.
    layer_step: u32,
    // Number of layers that have changed to the next level.
    layers_gone: f32,
    // Density of the next level, or share of the far fur layer if that is next.
    detail_next: f32,
    // Factor on the opacity of fins.
    fin_share: f32,
    // Height of the far fur layer, relative to the fur height.
    coat_height: f32,
    // Height at which the ambient light of the far fur layer is evaluated, relative to the fur height.
    coat_ambient_height: f32,
    // Arguments `base` and `slope` of coat_light.
    coat_light_base: f32,
    coat_light_slope: f32,
}

// Returns the unit vector from a point towards a light or eye that is given in homogeneous coordinates (formulas 1.1).
fn direction_to(target_ws: vec4<f32>, position_ws: vec3<f32>) -> vec3<f32> {
    let d = target_ws.xyz - position_ws * target_ws.w;
    return d * inverseSqrt(max(dot(d, d), 1e-30));
}

// Returns the unit half vector between two unit vectors; zero if they are opposite (formulas 1.1).
fn half_vector(l: vec3<f32>, v: vec3<f32>) -> vec3<f32> {
    let h = l + v;
    return h * inverseSqrt(max(dot(h, h), 1e-12));
}
