//! uses hair/hair, shared/kajiya_kay, surface/place
// Optics of a single hair: Kajiya-Kay, Yang 2006, eq. (1) (formulas 4.1).

// pd is 2, so sin^2 needs no power.
override SQUARED_DIFFUSE: bool = false;
// ks is not zero.
override SPECULAR: bool = false;

// Returns the eye direction, which is the light's direction mirrored at H. Interpolated between vertices with different
// directions, H is short; if treated as unit length, it would place the eye opposite the light.
fn mirrored(light: vec3<f32>, half: vec3<f32>) -> vec3<f32> {
    let eye = 2.0 * dot(half, light) / max(dot(half, half), 1e-12) * half - light;
    return eye * inverseSqrt(max(dot(eye, eye), 1e-30));
}

// Returns the strength of the highlight relative to dry hair, and ps / 2.
fn highlight(wetness: f32) -> vec2<f32> {
    var lobe = vec2(1.0, instance.specular_half_exponent);
    if WET {
        lobe = mix(lobe, vec2(instance.wet_specular, instance.wet_specular_half_exponent), wetness);
    }
    return lobe;
}

// Returns the light that a hair sends to the eye from one direction (formulas 4.1). `x`: sin^pd, to be tinted by the
// hair's colour. `y`: sin^ps, untinted, with the strength of the mixed wet and dry hair. All in the tile frame; `half`
// is H of light and eye.
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
