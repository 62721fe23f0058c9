//! uses hair/hair, shared/kajiya_kay, surface/place
// Optics of a single hair: Kajiya-Kay as in Yang 2006, eq. (1) (formulas 4.1).

// Whether the exponent pd is 2; then sin^2 needs no power function.
override SQUARED_DIFFUSE: bool = false;
// Whether the specular constant ks is not zero.
override SPECULAR: bool = false;

// Returns the direction to the eye: the light's direction mirrored at H. H gets short where it is interpolated between
// vertices with different directions. Treating it as a unit vector would place the eye opposite the light.
fn mirrored(light: vec3<f32>, half: vec3<f32>) -> vec3<f32> {
    let eye = 2.0 * dot(half, light) / max(dot(half, half), 1e-12) * half - light;
    return eye * inverseSqrt(max(dot(eye, eye), 1e-30));
}

// Returns the strength of the highlight relative to dry hair, and half the exponent, ps / 2.
fn highlight(wetness: f32) -> vec2<f32> {
    var lobe = vec2(1.0, instance.specular_half_exponent);
    if WET {
        lobe = mix(lobe, vec2(instance.wet_specular, instance.wet_specular_half_exponent), wetness);
    }
    return lobe;
}

// Returns the light that a hair sends to the eye from one direction (formulas 4.1). `x`: sin^pd, to be tinted by the
// hair's colour. `y`: sin^ps, untinted, weighted for the mix of wet and dry hair. Directions are in the tile frame;
// `half` is the half vector H of light and eye.
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
