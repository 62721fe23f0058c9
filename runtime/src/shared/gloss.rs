use glam::Vec3;

/// WGSL source; does not depend on other topics.
pub const WGSL: &str = include_str!("gloss.wgsl");

/// Returns the reflectance of a smooth surface at this cosine between the light and the normal. `f0`: at normal
/// incidence.
pub fn gloss_fresnel(f0: Vec3, cosine: f32) -> Vec3 {
    let rest = (1.0 - cosine).clamp(0.0, 1.0);
    let squared = rest * rest;
    f0 + (Vec3::ONE - f0) * (squared * squared * rest)
}

/// Returns the light that a mirror-like surface without Fresnel loss sends to the eye, from a light of colour 1.
/// `alpha_squared`: squared width of the distribution; cosines between normal and half vector, light and eye.
pub fn gloss_lobe(alpha_squared: f32, n_dot_h: f32, n_dot_l: f32, n_dot_e: f32) -> f32 {
    let (l, e) = (n_dot_l.max(0.0), n_dot_e.max(1e-3));
    let spread = 1.0 - n_dot_h * n_dot_h * (1.0 - alpha_squared);
    let shadow = l * (e * e * (1.0 - alpha_squared) + alpha_squared).sqrt()
        + e * (l * l * (1.0 - alpha_squared) + alpha_squared).sqrt();
    0.5 * l * alpha_squared / (spread * spread * shadow).max(1e-9)
}

/// Returns the share of uniform light that the surface reflects to the eye.
pub fn gloss_albedo(f0: Vec3, roughness: f32, n_dot_e: f32) -> Vec3 {
    let e = n_dot_e.clamp(0.0, 1.0);
    let rest = 1.0 - e;
    let cubed = rest * rest * rest;
    let lost = roughness * roughness * (0.72 + e * (0.05 - e * 0.587) + roughness * (1.14 * e - 0.605));
    let risen = rest * rest * cubed / (1.0 + 37.0 * roughness * roughness * roughness * cubed);
    f0 * (1.0 - lost - risen) + Vec3::splat(risen)
}

/// Returns the mean of a spherical Gaussian light with peak 1 and this sharpness over the reflected lobe, which is
/// another spherical Gaussian. `cosine`: between the light's axis and the mirrored direction of the eye.
pub fn gloss_of_gaussian(alpha_squared: f32, n_dot_e: f32, sharpness: f32, cosine: f32) -> f32 {
    // Half the sharpness of the peak, because the tails of GGX are long.
    let own = 0.25 / (alpha_squared * n_dot_e.max(0.1));
    let both = (own * own + sharpness * sharpness + 2.0 * own * sharpness * cosine).max(1e-12).sqrt();
    let near = -2.0 * own * sharpness * (1.0 - cosine) / (both + own + sharpness);
    let far = -both - own - sharpness;
    own * (near.exp() - far.exp()) / (both * (1.0 - (-2.0 * own).exp()))
}
