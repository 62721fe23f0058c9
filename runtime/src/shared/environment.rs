use glam::{Vec2, Vec3};
use pelage_formats::meaning::openness::Openness;
use pelage_formats::meaning::scattering::broad;

/// WGSL source; does not depend on other topics.
pub const WGSL: &str = include_str!("environment.wgsl");

/// Returns the octahedral map coordinates of a direction of any length, −1..=1 each. The upper half is at the centre of
/// the map.
pub fn octahedral(way: Vec3) -> Vec2 {
    let flat = Vec2::new(way.x, way.z) / way.abs().element_sum().max(1e-12);
    if way.y >= 0.0 {
        return flat;
    }
    let sign = |x: f32| if x >= 0.0 { 1.0 } else { -1.0 };
    Vec2::new((1.0 - flat.y.abs()) * sign(flat.x), (1.0 - flat.x.abs()) * sign(flat.y))
}

/// Returns the unit direction at octahedral map coordinates.
pub fn from_octahedral(place: Vec2) -> Vec3 {
    let y = 1.0 - place.x.abs() - place.y.abs();
    let sign = |x: f32| if x >= 0.0 { 1.0 } else { -1.0 };
    let flat = match y >= 0.0 {
        true => place,
        false => Vec2::new((1.0 - place.y.abs()) * sign(place.x), (1.0 - place.x.abs()) * sign(place.y)),
    };
    Vec3::new(flat.x, y, flat.y).normalize_or(Vec3::Y)
}

/// Returns the mean squared cosine between a direction and light that is spread about an axis. `mean`: mean cosine
/// between the light and its axis; `cosine`: cosine between the direction and the axis.
pub fn mean_square(mean: f32, cosine: f32) -> f32 {
    let across = (1.0 - mean) * ((1.0 + 2.0 * mean) / 3.0 - (mean - LEAST_MEAN) * (0.525 - 0.501 * mean));
    across + (1.0 - 3.0 * across) * cosine * cosine
}

const LEAST_MEAN: f32 = broad::LEAST_MEAN as f32;

/// Returns the coordinate 0..=1 in the broad-light tables of light with this mean cosine
/// ([`pelage_formats::meaning::scattering::broad`]).
pub fn broad_coordinate(mean: f32) -> f32 {
    let rest = (1.0 - mean.clamp(LEAST_MEAN, 1.0)) / (1.0 - LEAST_MEAN);
    ((1.0 - rest.sqrt()) / 0.83).clamp(0.0, 1.0)
}

/// Returns the angular variance of light with this mean cosine, radians²: 1 / κ of a narrow spherical Gaussian.
pub fn broad_variance(mean: f32) -> f32 {
    let m = mean.clamp(LEAST_MEAN, 1.0);
    (1.0 - m) / m
}

/// Returns the mean cosine of a von Mises distribution with this concentration, I1 / I0, with an error below 4 %.
pub fn mean_cosine_around(concentration: f32) -> f32 {
    concentration / (0.5 + (concentration * concentration + 2.25).sqrt())
}

/// Share of all directions that are open to the hair tips of most bodies: all except those farther below the horizon
/// than [`broad::HORIZON_SINE`].
pub const USUALLY_OPEN: f32 = 0.725;

/// Packs the openness of a vertex into two bytes. The first byte is the open share of all directions, 1..=255. The
/// second byte holds the components along u and v of the tile, in four bits each, with an error of at most 1/14. Both
/// bytes are 0 if the openness is unknown.
pub fn pack_openness(of: Openness) -> [u8; 2] {
    let [u, v] = of.tangential.map(|x| (7.0 * x.clamp(-1.0, 1.0)).round() as i8 + 7);
    [((of.share.clamp(0.0, 1.0) * 255.0).round() as u8).max(1), 16 * u as u8 + v as u8]
}

/// Unpacks the openness of a vertex from its bytes, given as numbers 0..=1. Returns a vector in the tile frame towards
/// the middle of the open directions. Its length is the open share, relative to that of most bodies.
pub fn unpack_openness(packed: Vec2) -> Vec3 {
    if packed.x <= 0.0 {
        return Vec3::Z;
    }
    let byte = (packed.y * 255.0 + 0.5).floor();
    let u = (byte / 16.0).floor();
    let aside = (Vec2::new(u, byte - 16.0 * u) - 7.0) / 7.0;
    let middle = aside.extend((1.0 - aside.length_squared()).max(0.0).sqrt());
    middle * (packed.x / USUALLY_OPEN / middle.length_squared().max(1.0).sqrt())
}

/// Returns the share of environment light that reaches a point on a body of that colour. `hidden`: share of this light
/// that the body hides from the point. The hiding surface is assumed to be as bright as the point, and lights it.
pub fn environment_share(color: Vec3, hidden: f32) -> Vec3 {
    Vec3::splat(1.0 - hidden) / (1.0 - color.clamp(Vec3::ZERO, Vec3::splat(0.98)) * hidden)
}
