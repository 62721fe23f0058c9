//! Stroke of the sphere map: a ring of ink along the rim of a disc. Outlines of all models are looked up there (Fang
//! 2006, §2; Kang 2003).
//!
//! Texture coordinates (u, v) are half the view-space components of the unit normal, plus one half. The middle of the
//! disc faces the eye; its rim, at distance one half, is the outline. The width of the line is the distance that the
//! ink extends inwards. It varies along the rim, like a line drawn with a soft brush.

use super::noise::{Gradient, Octaves};
use super::plane::Plane;
use crate::noise::{hash, smooth_step};
use crate::recipe::InkParams;
use glam::{UVec2, Vec2};
use std::f32::consts::TAU;

/// Position along the rim, in turns, where the brush is pressed most. It is at the lower right, for a hand that comes
/// from the upper left.
const BELLY: f32 = 0.11;

/// Returns polar coordinates on the disc. The angle is in turns. The distance inwards from the rim is a share of the
/// radius, 0..=1, and 0 outside the rim.
fn polar(uv: Vec2) -> Vec2 {
    let p = uv - 0.5;
    let turns = libm::atan2f(p.y, p.x) / TAU;
    Vec2::new(turns - turns.floor(), (1.0 - 2.0 * p.length()).max(0.0))
}

/// Ring of ink with the varying width of a brush stroke.
struct Ring<'a> {
    /// Noise along the rim and inwards: its cells are those per turn and per radius.
    swell: Octaves,
    fray: [Octaves; 2],
    bristles: [Gradient; 2],
    load: Octaves,
    width: f32,
    variation: f32,
    dryness: f32,
    scanned: Option<&'a Plane>,
}

impl Ring<'_> {
    /// Returns the brush pressure, about 1.
    fn pressure(&self, turns: f32) -> f32 {
        let swell = 0.55 * libm::cosf(TAU * (turns - BELLY)) + 0.6 * self.swell.at(Vec2::new(turns, 0.5));
        (1.0 + self.variation * swell).max(0.25)
    }

    /// Returns the ink of the wet stroke and of the dry stroke, from 0 (none) to 1 (black).
    fn ink(&self, at: Vec2) -> [f32; 2] {
        let pressure = self.pressure(at.x);
        // Position within the stroke: 0..=1 from the rim to its frayed edge.
        let fray = 0.24 * self.fray[0].at(at) + 0.1 * self.fray[1].at(at);
        let across = at.y / (self.width * pressure) + fray * self.variation.min(1.0);
        let body = 1.0 - smooth_step(0.72, 1.12, across);
        // Ink bleeds into the paper and fades outwards. It pools a little where it stops.
        let bleed = 0.22 * libm::expf(-3.0 * (across - 1.0).max(0.0)) * smooth_step(0.7, 1.0, across);
        let pool = 1.0 - 0.10 * smooth_step(0.15, 0.6, across) * (1.0 - smooth_step(0.6, 0.85, across));
        let wet = match self.scanned {
            // The edges of the stroke are sampled at the centres of the first and last texel rows; beyond them, the
            // tile would repeat.
            Some(band) if across < 1.0 => {
                let half = 0.5 / band.side as f32;
                1.0 - band.sample(Vec2::new(at.x, across.clamp(half, 1.0 - half)))
            }
            Some(_) => 0.0,
            None => (body * pool).max(bleed),
        };
        // Bristles run along the rim. The drier the brush, the more bristles leave no ink, beginning on the side with
        // less pressure.
        let bristles = self.bristles[0].at(at) + 0.6 * self.bristles[1].at(at);
        let load = self.load.at(Vec2::new(at.x, 0.25));
        let lift = 1.1 * across.min(1.0) - 1.45 + 1.6 * self.dryness + 0.55 * load - 0.5 * (pressure - 1.0);
        let gap = smooth_step(-0.12, 0.28, 0.75 * bristles + lift);
        [wet, wet * (1.0 - 0.94 * gap)]
    }
}

/// Makes the channels of the stroke:
///
/// * red: grey of the stroke, from 0 (black) at the rim to 1 (white) inside
/// * green: the same for a dry brush
/// * blue: variation of the line's width, 0.5 on average
/// * alpha: 1
///
/// `scanned` replaces the painted stroke. It runs along u, and along v from the outer to the inner edge, as returned by
/// [`stroke_band`](super::stroke_band). The dry stroke is then the scan without the ink of some bristles.
pub fn stroke(params: &InkParams, scanned: Option<&Plane>) -> [Plane; 4] {
    let side = params.stroke_texels as usize;
    let seed = hash(params.seed, 0x5701);
    let noise = |kind, cells: (u32, u32), count| Octaves::new(hash(seed, kind), cells.into(), count, 0.55);
    let ring = Ring {
        swell: noise(1, (4, 4), 3),
        fray: [noise(2, (40, 24), 3), noise(3, (150, 60), 2)],
        bristles: [(4, UVec2::new(9, 88)), (5, UVec2::new(23, 150))]
            .map(|(k, cells)| Gradient::new(hash(seed, k), cells)),
        load: noise(6, (6, 3), 2),
        width: params.stroke_width,
        variation: params.stroke_variation,
        dryness: params.stroke_dryness,
        scanned,
    };
    let [wet, dry] = Plane::pair_from_fn(side, |uv| ring.ink(polar(uv)).map(|ink| 1.0 - ink));
    [wet, dry, width_noise(side, params), Plane::from_fn(side, |_| 1.0)]
}

/// Makes the blue channel: noise along the rim that changes slowly inwards.
fn width_noise(side: usize, params: &InkParams) -> Plane {
    let seed = hash(params.seed, 0x5702);
    let noise = Octaves::new(seed, UVec2::new(7, 3), 4, 0.6);
    Plane::from_fn(side, |uv| noise.at(polar(uv))).balanced(0.18)
}
