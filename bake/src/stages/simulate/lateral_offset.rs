//! Lateral offset of hair from its root. Renderers use it to find the root of the hair in a texel.
//!
//! A texel of a layer does not store its strand, only the direction of its hair. Hair that points farther sideways is
//! usually farther from its root. So at each of a few heights, a line is fitted through the texels: lateral offset as a
//! function of lateral direction. In combed fur, the line leaves a seventh of the offset unexplained, which is less
//! than the width of a lock.

use super::Strands;
use glam::{DVec2, DVec3, Vec2, Vec3};
use pelage_formats::{ROOT_HEIGHTS, RootOffset};

/// Resolution of the tile, texels along u and v.
const TEXELS: usize = 128;
/// Samples per segment.
const PIECES: usize = 2;
/// Variance of directions below which all directions are treated as equal.
const ONE_DIRECTION: f64 = 1e-6;

/// Lateral offset of hair from its root, in tile widths.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LateralOffsets {
    /// Fitted line at each height. Heights are evenly spaced from the mesh surface to the outermost layer.
    pub at: [RootOffset; ROOT_HEIGHTS],
    /// Mean offset of all hair at each height.
    pub mean: [Vec2; ROOT_HEIGHTS],
}

impl LateralOffsets {
    /// Fits the offsets of a tile's strands.
    pub fn from_strands(strands: &Strands) -> Self {
        let texels = texels(strands);
        let mut out = Self::default();
        // The offset is 0 on the mesh surface, because hair is at its root there.
        for (k, texels) in texels.iter().enumerate().skip(1) {
            (out.at[k], out.mean[k]) = fit(texels).unwrap_or((out.at[k - 1], out.mean[k - 1]));
        }
        out
    }

    /// Returns the search radius for roots, in tile widths.
    pub fn reach(&self) -> f32 {
        self.at.iter().map(|aside| Vec2::from(aside.mean).length() + aside.along.abs()).fold(0.0, f32::max)
    }
}

/// Hair in a texel: total weight, and the weighted sums of directions and lateral offsets.
#[derive(Clone, Copy, Default)]
struct Texel {
    weight: f64,
    direction: DVec3,
    aside: DVec2,
}

/// Accumulates the hair of all strands in texels, per height.
fn texels(strands: &Strands) -> Vec<Vec<Texel>> {
    let mut texels = vec![vec![Texel::default(); TEXELS * TEXELS]; ROOT_HEIGHTS];
    for strand in 0..strands.len() {
        let range = strands.range(strand);
        let Some(root) = strands.points.get(range.start) else { continue };
        for i in range.start..range.end.saturating_sub(1) {
            let (from, to) = (strands.points[i], strands.points[i + 1]);
            let Some(tangent) = (to - from).try_normalize() else { continue };
            // A texel does not distinguish the two ends of a hair, so the direction is turned upwards.
            let direction: Vec3 = if tangent.z < 0.0 { -tangent } else { tangent };
            let weight = f64::from((to - from).length() * strands.radii[i].max(strands.radii[i + 1]));
            for piece in 0..PIECES {
                let at = from.lerp(to, (piece as f32 + 0.5) / PIECES as f32);
                let height = (at.z / strands.height * (ROOT_HEIGHTS - 1) as f32 + 0.5) as usize;
                let index = |x: f32| (((x - x.floor()) * TEXELS as f32) as usize).min(TEXELS - 1);
                let texel = &mut texels[height.min(ROOT_HEIGHTS - 1)][index(at.y) * TEXELS + index(at.x)];
                texel.weight += weight;
                texel.direction += direction.as_dvec3() * weight;
                texel.aside += (at - *root).truncate().as_dvec2() * weight;
            }
        }
    }
    texels
}

/// Fits a least-squares line through the texels of a height, and returns it with the mean; `None` without hair.
fn fit(texels: &[Texel]) -> Option<(RootOffset, Vec2)> {
    let hair = || texels.iter().filter(|texel| texel.weight > 0.0);
    let points = |texel: &Texel| texel.direction.normalize_or(DVec3::Z).truncate();
    let weight: f64 = hair().map(|texel| texel.weight).sum();
    if weight <= 0.0 {
        return None;
    }
    let mean = hair().map(|texel| texel.aside).sum::<DVec2>() / weight;
    let direction = hair().map(|texel| points(texel) * texel.weight).sum::<DVec2>() / weight;
    let (mut with, mut own) = (0.0, 0.0);
    for texel in hair() {
        let turned = points(texel) - direction;
        with += turned.dot(texel.aside - mean * texel.weight);
        own += turned.length_squared() * texel.weight;
    }
    let along = if own > ONE_DIRECTION * weight { with / own } else { 0.0 };
    let straight = (mean - direction * along).as_vec2();
    Some((RootOffset { mean: straight.to_array(), along: along as f32 }, mean.as_vec2()))
}

#[cfg(test)]
#[path = "asides_tests.rs"]
mod tests;
