//! Wash texture: a tile of dried ink wash, and noise for lines and dry brushes on the surface.

use super::diffusion::{Paper, simulate_drying};
use super::noise::Octaves;
use super::plane::Plane;
use crate::noise::{hash, smooth_step, uniform};
use crate::recipe::InkParams;
use glam::{UVec2, Vec2};
use rayon::prelude::*;

/// Side of the ink simulation, texels. The blotches and marks are wider than one such texel.
const WET_SIDE: usize = 256;
/// Side at which soft noise is computed, texels. The noise has no finer details.
const SOFT_SIDE: usize = 256;
/// Number of wash layers; each is applied when the previous one is dry.
const LAYERS: u64 = 3;
/// Number of puddles per layer.
const PUDDLES: u64 = 4;

/// Standard deviation of the grain. Like [`BLOTCHES`] and [`PRESSURE`], it is large enough to be visible at half
/// strength, but too small to cause spots.
const GRAIN: f32 = 0.13;
const BLOTCHES: f32 = 0.15;
const PRESSURE: f32 = 0.17;

/// Makes the channels of the wash. The first three are greys with a mean of 0.5: low is more ink, high is more paper.
///
/// * red: grain of the wash
/// * green: blotches and tide marks, which are coarser
/// * blue: brush pressure along lines
/// * alpha: threshold of a dry brush, with all values equally frequent; low where ink takes first
///
/// `scanned`: tile of grey that replaces the painted wash.
pub fn wash(params: &InkParams, scanned: Option<&Plane>) -> [Plane; 4] {
    let side = params.wash_texels as usize;
    let seed = hash(params.seed, 0x3a51);
    let noise = |kind: u64, cells: u32, count: u32| Octaves::new(hash(seed, kind), UVec2::splat(cells), count, 0.6);
    // Soot particles settle on fibres and sizing.
    let tooth = noise(1, 40, 4).plane(side);
    let soft = |noise: Octaves| noise.plane(side.min(SOFT_SIDE)).resized(side);
    let cloud = soft(noise(2, 5, 5));
    let (grain, blotches) = match scanned {
        Some(tile) => {
            let tile = tile.resized(side);
            let coarse = tile.blurred(side as f32 / 96.0);
            let fine = tile.with(&coarse, |all, coarse| all - coarse).balanced(GRAIN);
            (fine.with(&tooth, |fine, tooth| fine + 0.05 * tooth), coarse)
        }
        None => {
            let stain = stain(seed, params.wash_edges).resized(side);
            let fine = stain.with(&stain.blurred(side as f32 / 48.0), |all, coarse| all - coarse);
            let grain = tooth.with(&cloud, |tooth, cloud| tooth + 0.55 * cloud);
            (
                grain.with(&fine, |grain, fine| grain - 3.0 * fine),
                stain.with(&cloud, |stain, cloud| -stain + 0.07 * cloud),
            )
        }
    };
    // The frequency is lower than that of line widths: a change within a line's width would turn the line into beads.
    let pressure = soft(noise(3, 6, 2));
    let speckle = noise(4, (params.wash_texels / 8).max(4), 3).plane(side);
    let dry_brush = speckle.with(&tooth, |speckle, tooth| speckle + 0.5 * tooth).with(&pressure, |v, p| v - 0.15 * p);
    [grain.balanced(GRAIN), blotches.balanced(BLOTCHES), pressure.balanced(PRESSURE), dry_brush.equalised()]
}

/// Simulates the ink of all layers together, about 0..1.
fn stain(seed: u64, edges: f32) -> Plane {
    let noise = |kind: u64, cells: u32, count: u32| Octaves::new(hash(seed, kind), UVec2::splat(cells), count, 0.6);
    let permeability = noise(11, 24, 3).plane(WET_SIDE).map(|v| (0.62 + 0.3 * v).clamp(0.08, 1.0));
    let threshold = noise(12, 36, 2).plane(WET_SIDE).map(|v| (0.26 + 0.2 * v).clamp(0.03, 0.9));
    let paper = Paper { permeability: &permeability, threshold: &threshold };
    let dried = |layer: u64| {
        let seed = hash(seed, 0x100 + layer);
        let bends = [1, 2].map(|kind| Octaves::new(hash(seed, kind), UVec2::splat(4), 4, 0.55));
        let puddle = |uv: Vec2| {
            let at = uv + Vec2::new(bends[0].at(uv), bends[1].at(uv)) * 0.075;
            let mut depth = 0.0f32;
            for k in 0..PUDDLES {
                let random = |n: u64| uniform(seed, k << 8 | n);
                let away = at - Vec2::new(random(1), random(2));
                let radius = 0.1 + 0.2 * random(3);
                // Puddles on dry paper have hard edges, those on damp paper soft ones.
                let soft = 0.02 + 0.6 * radius * random(4) * random(4);
                depth =
                    depth.max(1.0 - smooth_step(radius - soft, radius + 0.4 * soft, (away - away.round()).length()));
            }
            depth
        };
        let depth = noise(13 + layer, 6, 2);
        let water = Plane::from_fn(WET_SIDE, |uv| puddle(uv) * (0.8 + 0.2 * depth.at(uv)).clamp(0.3, 1.0));
        let strength = noise(21 + layer, 4, 4).plane(WET_SIDE).map(|v| (0.55 + 0.5 * v).clamp(0.06, 1.3));
        simulate_drying(paper, &water, &strength, edges)
    };
    let layers: Vec<Plane> = (0..LAYERS).into_par_iter().map(dried).collect();
    let sum = layers.iter().fold(Plane::empty(WET_SIDE), |sum, layer| sum.with(layer, |sum, ink| sum + ink));
    // Rims are sharp outside and soft inside. The paper softens both slightly.
    sum.blurred(0.7).map(|ink| 1.0 - libm::expf(-1.1 * ink))
}
