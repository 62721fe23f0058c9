//! Tufts: a few thick hairs at a place, each a guide of its own.

use super::body::Body;
use crate::noise::uniform;
use crate::recipe::TuftParams;
use glam::Vec3;
use pelage_formats::OnTriangle;

/// Points of each hair as it is stored: enough for one that only bends.
const POINTS: usize = 4;

/// The hairs of a tuft about a place, the nearest to which on the skin is its middle: of each its root, and its points. `side` −1 for the mirrored one.
pub(super) fn hairs(
    params: &TuftParams,
    body: &Body<'_>,
    middle: Vec3,
    reach_m: f32,
    side: f32,
) -> Vec<(OnTriangle, Vec<Vec3>)> {
    let Some(skin) = body.nearest(middle, reach_m, |_| true) else { return Vec::new() };
    let length_m = params.length_m.unwrap_or(0.05);
    let spread_m = params.spread_m.unwrap_or(0.005);
    let direction = Vec3::from(params.direction.unwrap_or_default()) * Vec3::new(side, 1.0, 1.0);
    let (fan, bend) = (params.fan.unwrap_or(0.3), params.bend.unwrap_or(0.15));
    let count = params.hairs.unwrap_or(12);
    let across = skin.normal.any_orthonormal_vector();
    let seed = u64::from(params.seed.unwrap_or(1));
    let hair = |number: u32| {
        // Spread over a disc as evenly as a sunflower's seeds (Vogel 1979); mirrored tufts are images of each other.
        let radius = libm::sqrtf((number as f32 + 0.5) / count as f32);
        let turn = 2.399_963_2 * number as f32 * side;
        let aside = across * libm::cosf(turn) + skin.normal.cross(across) * libm::sinf(turn);
        let at = body.nearest(skin.place + aside * (radius * spread_m), spread_m.max(reach_m), |_| true)?;
        let way = skin.normal + direction + aside * (fan * radius);
        let way = way.try_normalize().unwrap_or(skin.normal);
        let shorter = params.length_variation.unwrap_or(0.4) * uniform(seed, u64::from(number));
        let length_m = length_m * (1.0 - shorter);
        let point = |k: usize| {
            let share = k as f32 / (POINTS - 1) as f32;
            at.place + way * (length_m * share) - Vec3::Y * (bend * length_m * share * share)
        };
        Some((at.at, (0..POINTS).map(point).collect()))
    };
    (0..count).filter_map(hair).collect()
}
