use glam::{Vec2, Vec3};

/// The shader source; needs nothing else.
pub const WGSL: &str = include_str!("environment.wgsl");

/// Place of a direction in a square of all directions, −1..=1 each: an octahedron unfolded, its upper half in the middle. Of a direction of any length.
pub fn octahedral(way: Vec3) -> Vec2 {
    let flat = Vec2::new(way.x, way.z) / way.abs().element_sum().max(1e-12);
    if way.y >= 0.0 {
        return flat;
    }
    let sign = |x: f32| if x >= 0.0 { 1.0 } else { -1.0 };
    Vec2::new((1.0 - flat.y.abs()) * sign(flat.x), (1.0 - flat.x.abs()) * sign(flat.y))
}

/// The direction of such a place, of length 1.
pub fn from_octahedral(place: Vec2) -> Vec3 {
    let y = 1.0 - place.x.abs() - place.y.abs();
    let sign = |x: f32| if x >= 0.0 { 1.0 } else { -1.0 };
    let flat = match y >= 0.0 {
        true => place,
        false => Vec2::new((1.0 - place.y.abs()) * sign(place.x), (1.0 - place.x.abs()) * sign(place.y)),
    };
    Vec3::new(flat.x, y, flat.y).normalize_or(Vec3::Y)
}

/// Mean of the squared cosine between a direction and light of that mean cosine about another, which lies at that cosine from it.
pub fn mean_square(mean: f32, cosine: f32) -> f32 {
    let across = (1.0 - mean * mean) / (3.0 - mean * mean);
    across + (1.0 - 3.0 * across) * cosine * cosine
}

/// Where light of that mean cosine is on its axis of the tables of broad light, 0..=1 ([`pelage_formats::meaning::scattering::broad`]).
pub fn broad_place(mean: f32) -> f32 {
    ((1.0 - (1.0 - mean.clamp(0.0, 1.0)).sqrt()) / 0.8).clamp(0.0, 1.0)
}

/// Variance of the angle of light of that mean cosine, radians²: 1 / κ of a spherical Gaussian (after Banerjee 2005).
pub fn broad_variance(mean: f32) -> f32 {
    let m = mean.clamp(1e-3, 0.9999);
    (1.0 - m * m) / (m * (3.0 - m * m))
}
