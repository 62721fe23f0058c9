// Gloss of bare surface: the GGX distribution with Smith's shadowing and Schlick's Fresnel term (formulas 4.16).

// Squared width of a highlight that stands for the size of lights without one: a radius of 8 degrees.
const GLOSS_OF_LIGHTS: f32 = 0.005;
// Maximum by which curvature widens the highlights of dry and of wet surface, as a squared width.
const GLOSS_FILTER: vec2<f32> = vec2(0.18, 0.004);
// Fit of the directional albedo: loss of a mirror by roughness squared and cubed, and decrease of the Fresnel term.
const GLOSS_LOSS_2: vec3<f32> = vec3(0.72, 0.05, -0.587);
const GLOSS_LOSS_3: vec2<f32> = vec2(-0.605, 1.14);
const GLOSS_FRESNEL_FALL: f32 = 37.0;

// Returns the reflectance of a smooth surface at this cosine between the light and the normal. `f0`: at normal
// incidence.
fn gloss_fresnel(f0: vec3<f32>, cosine: f32) -> vec3<f32> {
    let rest = clamp(1.0 - cosine, 0.0, 1.0);
    let squared = rest * rest;
    return f0 + (1.0 - f0) * (squared * squared * rest);
}

// Returns the light that a mirror-like surface without Fresnel loss sends to the eye, from a light of colour 1.
// `alpha_squared`: squared width of the distribution; cosines between normal and half vector, light and eye.
fn gloss_lobe(alpha_squared: f32, n_dot_h: f32, n_dot_l: f32, n_dot_e: f32) -> f32 {
    let l = max(n_dot_l, 0.0);
    let e = max(n_dot_e, 1e-3);
    let spread = 1.0 - n_dot_h * n_dot_h * (1.0 - alpha_squared);
    let shadow = l * sqrt(e * e * (1.0 - alpha_squared) + alpha_squared)
        + e * sqrt(l * l * (1.0 - alpha_squared) + alpha_squared);
    return 0.5 * l * alpha_squared / max(spread * spread * shadow, 1e-9);
}

// Returns the share of uniform light that the surface reflects to the eye.
fn gloss_albedo(f0: vec3<f32>, roughness: f32, n_dot_e: f32) -> vec3<f32> {
    let e = clamp(n_dot_e, 0.0, 1.0);
    let rest = 1.0 - e;
    let cubed = rest * rest * rest;
    let by_2 = GLOSS_LOSS_2.x + e * (GLOSS_LOSS_2.y + e * GLOSS_LOSS_2.z);
    let lost = roughness * roughness * (by_2 + roughness * (GLOSS_LOSS_3.x + GLOSS_LOSS_3.y * e));
    let risen = rest * rest * cubed / (1.0 + GLOSS_FRESNEL_FALL * roughness * roughness * roughness * cubed);
    return f0 * (1.0 - lost - risen) + risen;
}

// Returns the mean of a spherical Gaussian light with peak 1 and this sharpness over the reflected lobe, which is
// another spherical Gaussian. `cosine`: between the light's axis and the mirrored direction of the eye.
fn gloss_of_gaussian(alpha_squared: f32, n_dot_e: f32, sharpness: f32, cosine: f32) -> f32 {
    // Half the sharpness of the peak, because the tails of GGX are long.
    let own = 0.25 / (alpha_squared * max(n_dot_e, 0.1));
    let both = sqrt(max(own * own + sharpness * sharpness + 2.0 * own * sharpness * cosine, 1e-12));
    let near = -2.0 * own * sharpness * (1.0 - cosine) / (both + own + sharpness);
    let far = -both - own - sharpness;
    return own * (exp(near) - exp(far)) / (both * (1.0 - exp(-2.0 * own)));
}
