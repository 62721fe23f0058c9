//! Tufts of fur: short strokes of a split brush along the combing direction, in groups, mostly where the tone of the
//! coat turns.

use super::canvas::{Canvas, Place};
use super::trace::{follow, length};
use super::washes::spread_places;
use crate::noise::{noise_1d, smooth_step, uniform};
use glam::Vec3;

/// Number of roots that are considered, and of tufts that are kept.
const ROOTS: usize = 1200;
const MOST: usize = 360;
/// Minimum distance between two tufts, in units of the model's size.
const APART: f32 = 0.018;
/// Minimum length of the hair, in units of the model's size.
const LEAST_HAIR: f32 = 0.0065;
/// Length of a tuft over that of the hair.
const LENGTH: [f32; 2] = [2.0, 3.6];
/// Range of the length of a tuft, in units of the model's size.
const RANGE: [f32; 2] = [0.02, 0.07];

/// Share of its length that a tuft must reach before the surface ends.
const LEAST_SHARE: f32 = 0.6;

/// Tuft of fur.
pub(super) struct Tuft {
    pub(super) places: Vec<Place>,
    pub(super) half_width: f32,
}

/// Returns tufts for hair of the given length at each welded vertex, in units of the model's size.
pub(super) fn tufts(canvas: &Canvas, hair: &[f32], is_covered: &[bool], seed: u64) -> Vec<Tuft> {
    let covered: Vec<f32> = is_covered.iter().map(|c| f32::from(u8::from(*c))).collect();
    let furred: Vec<f32> = canvas.furred.iter().map(|f| f32::from(u8::from(*f))).collect();
    let smooth = canvas.skin.spread(&canvas.darkness, 0.03 / canvas.unit);
    let turn: Vec<f32> = canvas.darkness.iter().zip(&smooth).map(|(a, b)| (a - b).abs()).collect();
    let turn = canvas.skin.spread(&turn, 0.02 / canvas.unit);
    let mut found: Vec<(f32, usize, Place)> = spread_places(canvas, ROOTS, seed ^ 0x7f75)
        .into_iter()
        .enumerate()
        .filter(|(_, p)| canvas.at(hair, p) > LEAST_HAIR && canvas.at(&furred, p) > 0.9 && canvas.at(&covered, p) < 0.3)
        .map(|(k, place)| {
            // Groups: smooth noise over the surface.
            let p = place.position * 9.0;
            let grouped = noise_1d(seed, p.x + 31.7).x + noise_1d(seed, p.y + 7.3).y + noise_1d(seed, p.z - 11.1).z;
            let merit = smooth_step(-0.6, 1.0, grouped)
                * (0.25 + smooth_step(0.02, 0.15, canvas.at(&turn, &place)))
                * (0.5 + canvas.at(&canvas.darkness, &place))
                * (0.7 + 0.6 * uniform(seed, k as u64));
            (merit, k, place)
        })
        .collect();
    found.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let mut tufts: Vec<Tuft> = Vec::new();
    for (_, k, place) in found {
        if tufts.len() >= MOST {
            break;
        }
        if tufts.iter().any(|t| t.places[0].position.distance(place.position) < APART) {
            continue;
        }
        let grown = canvas.at(hair, &place);
        let factor = LENGTH[0] + (LENGTH[1] - LENGTH[0]) * uniform(seed, 5000 + k as u64);
        let long = (grown * factor).clamp(RANGE[0], RANGE[1]);
        let places = follow(canvas, place, false, long, |_| true);
        let positions: Vec<Vec3> = places.iter().map(|p| p.position).collect();
        if length(&positions) > LEAST_SHARE * long {
            tufts.push(Tuft { places, half_width: 0.16 * long });
        }
    }
    tufts
}
