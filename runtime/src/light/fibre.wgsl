// The optics of one hair: Kajiya-Kay, Yang 2006, eq. (1).

// pd is 2: the power of sin^2 is itself.
override SQUARED_DIFFUSE: bool = false;
// ks is not zero.
override SPECULAR: bool = false;

// The light's direction mirrored at H: the eye's. Between vertices that look different ways H is short, and taken for one of length 1 it would put
// the eye opposite the light.
fn mirrored(light: vec3<f32>, half: vec3<f32>) -> vec3<f32> {
    let eye = 2.0 * dot(half, light) / max(dot(half, half), 1e-12) * half - light;
    return eye * inverseSqrt(max(dot(eye, eye), 1e-30));
}

// Strength of the highlight over that of dry hair, and ps / 2.
fn highlight(wetness: f32) -> vec2<f32> {
    var lobe = vec2(1.0, instance.specular_half_exponent);
    if WET {
        lobe = mix(lobe, vec2(instance.wet_specular, instance.wet_specular_half_exponent), wetness);
    }
    return lobe;
}

// What a hair sends to the eye of light from one direction: `x` takes the hair's colour, sin^pd; `y` does not, sin^ps as strong as wet and
// dry hair have it together. All in the tile frame; `half` is H of light and eye.
fn fibre(direction: vec3<f32>, light: vec3<f32>, half: vec3<f32>, wetness: f32) -> vec2<f32> {
    var diffuse = sin_squared(direction, light);
    if !SQUARED_DIFFUSE {
        diffuse = sin_power(diffuse, instance.diffuse_half_exponent);
    }
    if !SPECULAR {
        return vec2(diffuse, 0.0);
    }
    let lobe = highlight(wetness);
    return vec2(diffuse, lobe.x * sin_power(sin_squared(direction, half), lobe.y));
}
