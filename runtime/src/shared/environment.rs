use glam::{Vec2, Vec3};
use pelage_formats::meaning::openness::Openness;
use pelage_formats::meaning::scattering::broad;

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
    let across = (1.0 - mean) * ((1.0 + 2.0 * mean) / 3.0 - (mean - LEAST_MEAN) * (0.525 - 0.501 * mean));
    across + (1.0 - 3.0 * across) * cosine * cosine
}

const LEAST_MEAN: f32 = broad::LEAST_MEAN as f32;

/// Where light of that mean cosine is on its axis of the tables of broad light, 0..=1 ([`pelage_formats::meaning::scattering::broad`]).
pub fn broad_place(mean: f32) -> f32 {
    let rest = (1.0 - mean.clamp(LEAST_MEAN, 1.0)) / (1.0 - LEAST_MEAN);
    ((1.0 - rest.sqrt()) / 0.83).clamp(0.0, 1.0)
}

/// Variance of the angle of light of that mean cosine, radians²: 1 / κ of a spherical Gaussian that is narrow.
pub fn broad_variance(mean: f32) -> f32 {
    let m = mean.clamp(LEAST_MEAN, 1.0);
    (1.0 - m) / m
}

/// Mean cosine of a von Mises distribution of that concentration, I1 / I0, within 4 %.
pub fn mean_cosine_around(concentration: f32) -> f32 {
    concentration / (0.5 + (concentration * concentration + 2.25).sqrt())
}

/// Share of all directions that most bodies leave open to the tips of their hair: all but what is farther below
/// the horizon than [`broad::BELOW`].
pub const USUALLY_OPEN: f32 = 0.725;

/// What the body leaves open to the hair at a vertex in the two bytes that vertices have for it: the share, 1 at least, and in four bits each what lies along u and
/// v of the tile, within 1/14. Where nothing is known both are 0.
pub fn pack_openness(of: Openness) -> [u8; 2] {
    let [u, v] = of.aside.map(|x| (7.0 * x.clamp(-1.0, 1.0)).round() as i8 + 7);
    [((of.share.clamp(0.0, 1.0) * 255.0).round() as u8).max(1), 16 * u as u8 + v as u8]
}

/// What such bytes say, as numbers 0..=1: a vector in the tile frame towards the middle of what is open, as long as its share is over what most bodies leave open.
pub fn open_to_hair(packed: Vec2) -> Vec3 {
    if packed.x <= 0.0 {
        return Vec3::Z;
    }
    let byte = (packed.y * 255.0 + 0.5).floor();
    let u = (byte / 16.0).floor();
    let aside = (Vec2::new(u, byte - 16.0 * u) - 7.0) / 7.0;
    let middle = aside.extend((1.0 - aside.length_squared()).max(0.0).sqrt());
    middle * (packed.x / USUALLY_OPEN / middle.length_squared().max(1.0).sqrt())
}

/// Of light from all around what reaches a place where a body of that colour hides that share of it: what hides it shines about as much as the place itself, and
/// lights it.
pub fn left_open(color: Vec3, hidden: f32) -> Vec3 {
    Vec3::splat(1.0 - hidden) / (1.0 - color.clamp(Vec3::ZERO, Vec3::splat(0.98)) * hidden)
}
