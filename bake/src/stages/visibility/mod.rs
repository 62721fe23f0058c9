//! Visibility: share of a distant light that reaches each point of a tile's hair past the other strands, for all
//! directions at once.
//!
//! Rays to the light start at points along every strand and on the mesh surface between the roots. A function of ω, the
//! direction towards the light, is fitted to their results: t = s(ω.z) clamp(c₀ + c · ω, 0, 1). Its four coefficients,
//! c₀ and c, are stored. More coefficients hardly improve the fit (nine spherical harmonics: 4 %), because a point is
//! shadowed by only a few strands. A strand does not shadow itself, as in the ray-traced reference. For a thin hair,
//! the sine in the lighting equation already accounts for the light on its round surface.

mod fit;
mod rays;

use crate::noise::{hash, uniform};
use crate::recipe::VisibilityParams;
use crate::stages::simulate::Strands;
use fit::Fit;
use glam::{Vec3, Vec4};
pub use pelage_formats::meaning::encode_visibility;
use pelage_import::BakeError;
use rayon::prelude::*;
use rays::StrandTree;

/// Maximum number of rays. With very many strands, each point uses fewer directions, and neighbouring points use
/// different ones.
const MOST_RAYS: usize = 1 << 24;
/// Minimum number of directions per point. Four would determine the coefficients; the others suppress noise.
const LEAST_DIRECTIONS: usize = 8;
/// Maximum number of points from which the horizon is chosen; [`HORIZON_DIRECTIONS`] is the number of directions.
const HORIZON_PLACES: usize = 1000;
const HORIZON_DIRECTIONS: u32 = 32;
/// Points per side of the grid of sample points on the mesh surface. Neighbouring points have nearly the same
/// visibility.
const SIDE: u32 = 64;

/// Coefficients (c₀, c) of t = s(ω.z) clamp(c₀ + c · ω, 0, 1). ω is the unit vector towards the light in the tile
/// frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Visibility {
    /// Reciprocal of the elevation at which a light begins to fade: k of [`pelage_formats::meaning::above_horizon`].
    pub horizon: f32,
    /// Coefficients at each point of the strands.
    pub points: Vec<Vec4>,
    /// Coefficients on the mesh surface: 64 * 64 points, row-major.
    pub skin: Vec<Vec4>,
}

impl Visibility {
    /// Returns the encoded coefficients of the mesh surface for each mip level of a texture of `texels * texels`,
    /// finest first.
    pub(crate) fn skin_levels(&self, texels: u32) -> Vec<Vec<u8>> {
        let mut levels = Vec::new();
        let (mut side, mut places) = (SIDE as usize, self.skin.clone());
        for level in 0..=texels.ilog2() {
            let n = (texels >> level) as usize;
            while n < side {
                let half = side / 2;
                let at = |x: usize, y: usize| places[y * side + x];
                let mean = |i: usize| {
                    let (x, y) = (2 * (i % half), 2 * (i / half));
                    0.25 * (at(x, y) + at(x + 1, y) + at(x, y + 1) + at(x + 1, y + 1))
                };
                (places, side) = ((0..half * half).map(mean).collect(), half);
            }
            let texel = |i: usize| encode_visibility(places[i / n * side / n * side + i % n * side / n]);
            levels.push((0..n * n).flat_map(texel).collect());
        }
        levels
    }
}

/// Computes the visibility for the strands of a tile.
///
/// * `horizon`: fixed horizon; if `None`, a suitable one is chosen
///
/// Fails with [`BakeError::Params`] for a value outside its range, [`BakeError::Internal`] for inconsistent strands.
pub fn visibility(strands: &Strands, params: &VisibilityParams, horizon: Option<f32>) -> Result<Visibility, BakeError> {
    params.validate()?;
    strands.validate()?;
    let rays = StrandTree::new(strands);
    let places = strands.points.len() + (SIDE * SIDE) as usize;
    let most = (MOST_RAYS / places.max(1)).max(LEAST_DIRECTIONS);
    let count = params.directions.min(most as u32);
    let turn = |place: usize| {
        let angle = std::f32::consts::TAU * uniform(hash(0x7669_7369, 0), place as u64);
        (libm::sinf(angle), libm::cosf(angle))
    };
    let on_skin = |i: usize| {
        let at = |i: usize| (i as f32 + 0.5) / SIDE as f32;
        Vec3::new(at(i % SIDE as usize), at(i / SIDE as usize), 0.0)
    };
    let owners: Vec<u32> = (0..strands.len()).flat_map(|s| strands.range(s).map(move |_| s as u32)).collect();
    let horizon = horizon.unwrap_or_else(|| {
        let places = strands.points.len().div_ceil(HORIZON_PLACES).max(1);
        let looked: Vec<usize> = (0..strands.points.len()).step_by(places).collect();
        let plain = Fit::new(HORIZON_DIRECTIONS, 1.0);
        let seen = |(n, z): (usize, f32)| {
            let lit = |i: &&usize| {
                let way = plain.rotated_directions(turn(**i)).nth(n).unwrap_or(Vec3::Z);
                rays.is_lit(strands.points[**i], way, Some(owners[**i]))
            };
            let hidden = looked.par_iter().filter(|i| !lit(i)).count();
            (z, 1.0 - hidden as f64 / looked.len().max(1) as f64)
        };
        let heights: Vec<f32> = plain.rotated_directions((0.0, 1.0)).map(|d| d.z).collect();
        fit::horizon(&heights.into_iter().enumerate().map(seen).collect::<Vec<_>>())
    });
    let fit = Fit::new(count, horizon);
    let points = owners.par_iter().zip(&strands.points).enumerate().with_min_len(64);
    let points =
        points.map(|(i, (own, p))| fit.coefficients(turn(i), |way| rays.is_lit(*p, way, Some(*own)))).collect();
    let skin = (0..(SIDE * SIDE) as usize).into_par_iter().with_min_len(64);
    let skin = skin.map(|i| fit.coefficients(turn(i), |way| rays.is_lit(on_skin(i), way, None))).collect();
    Ok(Visibility { horizon, points, skin })
}

#[cfg(test)]
mod tests;
