//! How far hair lies aside of its root: what a renderer needs to look for the root of the hair that a texel shows.
//!
//! A texel of a layer holds no strand's name, but the direction of its hair, and hair that points far aside has come far. So for each of a few
//! heights a line is fitted through what the texels show: how far their hair lies aside of its root, by how far it points aside. It
//! leaves a seventh of the way unexplained in a combed coat, which is less than the width of a lock.

use super::Strands;
use glam::{DVec2, DVec3, Vec2, Vec3};
use pelage_formats::{Aside, ROOT_HEIGHTS};

/// Texels of a tile each way.
const TEXELS: usize = 128;
/// Pieces of a segment that are told apart.
const PIECES: usize = 2;
/// Variance of directions below which they all are one.
const ONE_DIRECTION: f64 = 1e-6;

/// How far hair lies aside of its root, widths of the tile.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Asides {
    /// At each of the heights, evenly from the skin to the outermost layer.
    pub at: [Aside; ROOT_HEIGHTS],
    /// The mean of all hair at each height.
    pub mean: [Vec2; ROOT_HEIGHTS],
}

impl Asides {
    /// Of the strands of a tile.
    pub fn of(strands: &Strands) -> Self {
        let texels = texels(strands);
        let mut out = Self::default();
        // On the skin hair is at its root.
        for (k, texels) in texels.iter().enumerate().skip(1) {
            (out.at[k], out.mean[k]) = fit(texels).unwrap_or((out.at[k - 1], out.mean[k - 1]));
        }
        out
    }

    /// The farthest that a root is looked for.
    pub fn reach(&self) -> f32 {
        self.at.iter().map(|aside| Vec2::from(aside.mean).length() + aside.along.abs()).fold(0.0, f32::max)
    }
}

/// The hair of a texel: weight, and times that its direction and how far it lies aside of its root.
#[derive(Clone, Copy, Default)]
struct Texel {
    weight: f64,
    direction: DVec3,
    aside: DVec2,
}

/// The texels at each height.
fn texels(strands: &Strands) -> Vec<Vec<Texel>> {
    let mut texels = vec![vec![Texel::default(); TEXELS * TEXELS]; ROOT_HEIGHTS];
    for strand in 0..strands.len() {
        let range = strands.range(strand);
        let Some(root) = strands.points.get(range.start) else { continue };
        for i in range.start..range.end.saturating_sub(1) {
            let (from, to) = (strands.points[i], strands.points[i + 1]);
            let Some(tangent) = (to - from).try_normalize() else { continue };
            // Which of its two ends is up, no texel knows.
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

/// The line through the texels of a height with the least squares, and the mean; `None` where there is no hair.
fn fit(texels: &[Texel]) -> Option<(Aside, Vec2)> {
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
    Some((Aside { mean: straight.to_array(), along: along as f32 }, mean.as_vec2()))
}

#[cfg(test)]
#[path = "asides_tests.rs"]
mod tests;
