//! uses hair/hair, light/fibre, shared/tile_frame
// Lighting functions in pelage's own form and in the papers' published forms, selected by override constants. Replaces
// light/forms.wgsl in studies.

// Whether slanted paths through a layer are more opaque for view rays.
override LOOK_SLANTED: bool = true;
// Whether slanted paths through a layer are more opaque for light.
override LIGHT_SLANTED: bool = true;
// Whether the penumbra extends to both sides of the hard edge.
override CENTRED: bool = true;
// Whether the key light's factors of eq. (1) are computed per vertex.
override VERTEX_LIGHTING: bool = false;

// Returns the half vector H, or with VERTEX_LIGHTING the key light's factors themselves. At a vertex, only three
// properties of the hair are known: its length, its lean, and the mean direction of its layer. That direction is the
// last mip level of the direction texture.
fn half_or_factors(layer: u32, share: f32, slope: f32, light: vec3<f32>, half: vec3<f32>, wetness: f32) -> vec3<f32> {
    if !VERTEX_LIGHTING {
        return half;
    }
    let last = textureNumLevels(shell_directions) - 1u;
    var direction = decode_direction(textureLoad(shell_directions, vec2(0), layer, last), PLANAR_DIRECTIONS);
    if WET {
        let last_wet = textureNumLevels(wet_directions) - 1u;
        let wet = decode_direction(textureLoad(wet_directions, vec2(0), layer, last_wet), PLANAR_DIRECTIONS);
        direction = mix(direction, wet, wetness);
    }
    // H gets short where it is interpolated between vertices with different directions. Treating it as a unit vector
    // would place the eye opposite the light.
    let eye = 2.0 * dot(half, light) / max(dot(half, half), 1e-12) * half - light;
    return vec3(fibre(grown(direction, share, slope), light, half, wetness), atan2(eye.y, eye.x));
}

fn key_fibre(direction: vec3<f32>, light: vec3<f32>, half_or_factors: vec3<f32>, wetness: f32) -> vec2<f32> {
    if VERTEX_LIGHTING {
        return half_or_factors.xy;
    }
    return fibre(direction, light, half_or_factors, wetness);
}

// Returns the direction towards the eye. If the factors are computed per vertex, `half.z` is the azimuth of this
// direction around the normal.
fn eye_of(light: vec3<f32>, half: vec3<f32>, n_dot_e: f32) -> vec3<f32> {
    if VERTEX_LIGHTING {
        let across = sqrt(max(1.0 - n_dot_e * n_dot_e, 0.0));
        return vec3(across * cos(half.z), across * sin(half.z), n_dot_e);
    }
    return mirrored(light, half);
}
