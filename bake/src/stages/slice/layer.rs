//! Conversion of one layer's sums to the texels of all its mip levels.
//!
//! Averaging the opacities of each layer makes distant fur too opaque, because the parts of one hair in different
//! layers are above one another (measured in formulas 3.2: a mean transmittance of 0.84 becomes 0.51). From far away,
//! the eye sees the mean of the product of transmittances. So the *cumulative* transmittance is averaged. Let P be the
//! transmittance of all layers outside of this one. A coarse texel gets α = ⟨Pα⟩/⟨P⟩ and the colour ⟨PαC⟩/⟨P⟩. The
//! product over the layers is then exactly the mean of the products. Directions are averaged with the same weights.
//!
//! Opacity bytes are rounded so that the error of one layer is compensated in the next. The product of the stored
//! transmittances thus follows the true product at any number of layers. Plain rounding would completely lose the faint
//! hair of a stack of many layers.

use super::direction;
use super::far_fur::{FarFurStats, FarFurSums};
use super::splat::Sums;
use crate::stages::visibility::encode_visibility;
use glam::{Vec3, Vec4};
use pelage_formats::TextureFormat;
use pelage_formats::meaning::linear_to_srgb;
use rayon::prelude::*;

/// Offset added to the averaging weights, so that a layer keeps its own opacity where it is hidden from above.
const HIDDEN: f32 = 1e-4;

/// Transmittance from outside down to the current layer, for all levels.
pub(super) struct Transmittance {
    direction_format: TextureFormat,
    /// Transmittance at the resolution that strands are rasterised to.
    drawn: Vec<f32>,
    /// Number of halvings from the resolution of `drawn` to the finest stored level.
    halvings: u32,
    /// Variance of the additional blur, in stored texels²; 0 for none.
    blur: f32,
    levels: Vec<LevelTransmittance>,
    /// Accumulated appearance of the layers so far.
    coat: FarFurSums,
}

struct LevelTransmittance {
    exact: Vec<f32>,
    /// Transmittance given by the product of the stored opacities.
    stored: Vec<f32>,
}

/// Bytes of one level, `texels * texels * 4` each.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct LevelBytes {
    pub(super) color: Vec<u8>,
    pub(super) direction: Vec<u8>,
    /// Coefficients as encoded by [`encode_visibility`].
    pub(super) visibility: Vec<u8>,
}

impl Transmittance {
    /// Creates the state before any layer. Layers have `texels << halvings` texels per side on input, and `texels` when
    /// stored.
    pub(super) fn new(texels: u32, halvings: u32, blur: f32, direction_format: TextureFormat) -> Self {
        let drawn = vec![1.0; 1 << (2 * (texels.ilog2() + halvings))];
        let sizes = (0..=texels.ilog2()).map(|level| (texels >> level) as usize);
        let levels = sizes.map(|n| LevelTransmittance { exact: vec![1.0; n * n], stored: vec![1.0; n * n] }).collect();
        Self { direction_format, drawn, halvings, blur, levels, coat: FarFurSums::new(texels) }
    }

    /// Merges all layers so far into one layer, which shows their hair as seen from above. The mips are plain means,
    /// with colours and directions weighted by visible opacity.
    pub(super) fn coat(&self, texels: u32) -> (Vec<LevelBytes>, FarFurStats) {
        let mut alone = Self::new(texels, 0, 0.0, self.direction_format);
        let mut sums = self.coat.sums.clone();
        (alone.levels(&mut sums, texels), self.coat.finish())
    }

    /// Converts the `sums` of the next layer inwards to texels of all levels. If `skin` is given, the layer is opaque
    /// and has that colour. Its directions are those of the hair in `sums`, or their mean in texels without hair.
    pub(super) fn layer(&mut self, sums: &mut Vec<Sums>, texels: u32, skin: Option<Vec3>) -> Vec<LevelBytes> {
        to_weighted_opacity(sums, &mut self.drawn);
        let above = self.levels.last().map_or(1.0, |level| level.exact[0]);
        if skin.is_some() {
            fill_surface_directions(sums);
        }
        for halving in (0..self.halvings).rev() {
            *sums = halve(sums, (texels << halving) as usize);
        }
        if self.blur > 0.0 {
            *sums = blurred(sums, texels as usize, self.blur);
        }
        if skin.is_none() {
            self.coat.gather(sums);
        }
        let mut levels = self.levels(sums, texels);
        if let Some(skin) = skin {
            let [r, g, b] = skin.to_array().map(linear_to_srgb);
            let texels = levels.iter_mut().flat_map(|level| level.color.chunks_exact_mut(4));
            texels.for_each(|texel| texel.copy_from_slice(&[r, g, b, 255]));
        } else {
            self.coat.close(above, self.levels.last().map_or(1.0, |level| level.exact[0]));
        }
        levels
    }

    /// Makes the texels of every level from weighted sums.
    fn levels(&mut self, sums: &mut [Sums], texels: u32) -> Vec<LevelBytes> {
        let mut levels = Vec::with_capacity(self.levels.len());
        let mut coarse: Vec<Sums> = Vec::new();
        for (level, transmittance) in self.levels.iter_mut().enumerate() {
            let n = (texels >> level) as usize;
            if level > 0 {
                let fine = if level == 1 { &*sums } else { &coarse };
                coarse = halve(fine, n);
            }
            levels.push(store(if level == 0 { sums } else { &coarse }, transmittance, self.direction_format));
        }
        fill_empty(
            &mut levels,
            |level| ((texels >> level) as usize, (texels >> level) as usize),
            self.direction_format,
        );
        levels.into_iter().map(|(bytes, _)| bytes).collect()
    }
}

/// Replaces optical depth, depth times colour and depth times direction by Wα, WαC and WαT. W is the weight of the
/// texel, α its opacity, C its colour, T its direction. Stores W in the eighth component. All of these can be averaged
/// linearly.
fn to_weighted_opacity(sums: &mut [Sums], outside: &mut [f32]) {
    sums.par_iter_mut().zip(outside).with_min_len(1024).for_each(|(s, outside)| {
        let w = *outside + HIDDEN;
        let depth = s[0];
        s[7] = w;
        if depth <= 0.0 {
            return;
        }
        let opacity = -libm::expm1f(-depth);
        let scale = w * opacity / depth;
        for v in [1..7, 8..12].into_iter().flatten() {
            s[v] *= scale;
        }
        s[0] = w * opacity;
        *outside *= 1.0 - opacity;
    });
}

/// Fills the texels between the roots with the mean direction of the roots. If each root's direction were extended
/// instead, squares of equal direction would be visible under sparse hair.
fn fill_surface_directions(sums: &mut [Sums]) {
    let mut mean = [0.0f64; 4];
    for s in sums.iter() {
        for (sum, value) in mean.iter_mut().zip([s[0], s[4], s[5], s[6]]) {
            *sum += f64::from(value);
        }
    }
    if mean[0] <= 0.0 {
        return;
    }
    let mean = [mean[1], mean[2], mean[3]].map(|sum| (sum / mean[0]) as f32);
    sums.par_iter_mut().with_min_len(1024).for_each(|s| {
        let bare = s[7] - s[0];
        for (value, mean) in s[4..7].iter_mut().zip(mean) {
            *value += bare * mean;
        }
        s[0] = s[7];
    });
}

/// Applies a Gaussian of the given variance, texels², to a periodic image of `n * n` texels.
fn blurred(sums: &[Sums], n: usize, variance: f32) -> Vec<Sums> {
    let mut weights = Vec::new();
    let first = super::splat::weights(0.5, variance, &mut weights);
    let pass = |from: &[Sums], step: usize| {
        let mut to = vec![Sums::default(); n * n];
        to.par_iter_mut().with_min_len(1024).enumerate().for_each(|(i, sum)| {
            let at = i / step % n;
            for (k, w) in weights.iter().enumerate() {
                let other = (at as i64 + first + k as i64).rem_euclid(n as i64) as usize;
                let from = &from[i + other * step - at * step];
                sum.iter_mut().zip(from).for_each(|(s, v)| *s += v * w);
            }
        });
        to
    };
    pass(&pass(sums, 1), n)
}

fn halve(fine: &[Sums], n: usize) -> Vec<Sums> {
    let mut coarse = vec![Sums::default(); n * n];
    coarse.par_chunks_mut(n).with_min_len(16).enumerate().for_each(|(y, row)| {
        let above = &fine[4 * y * n..][..2 * n];
        let below = &fine[(4 * y + 2) * n..][..2 * n];
        for (x, sum) in row.iter_mut().enumerate() {
            for (c, s) in sum.iter_mut().enumerate() {
                *s = 0.25 * (above[2 * x][c] + above[2 * x + 1][c] + below[2 * x][c] + below[2 * x + 1][c]);
            }
        }
    });
    coarse
}

/// Returns the bytes of one level, and whether each texel has a direction and a visibility of its own.
fn store(sums: &[Sums], transmittance: &mut LevelTransmittance, format: TextureFormat) -> (LevelBytes, Vec<bool>) {
    let mut color = vec![0; 4 * sums.len()];
    let mut directions = vec![0; 4 * sums.len()];
    let mut visibility = vec![0; 4 * sums.len()];
    let mut has_direction = vec![false; sums.len()];
    let inputs = (sums, transmittance.exact.par_iter_mut(), transmittance.stored.par_iter_mut());
    let outputs = (
        color.par_chunks_mut(4),
        directions.par_chunks_mut(4),
        visibility.par_chunks_mut(4),
        has_direction.par_iter_mut(),
    );
    (inputs, outputs).into_par_iter().with_min_len(1024).for_each(
        |((s, exact, stored), (color, direction, visibility, has_direction))| {
            if s[0] <= 0.0 {
                return;
            }
            let opacity = (s[0] / s[7]).clamp(0.0, 1.0);
            *exact *= 1.0 - opacity;
            let alpha = round_opacity(opacity, *exact, *stored);
            *stored *= 1.0 - f32::from(alpha) / 255.0;
            if alpha > 0 {
                let scale = f32::from(alpha) / (255.0 * s[0]);
                for (byte, value) in color.iter_mut().zip(&s[1..4]) {
                    *byte = linear_to_srgb(value * scale);
                }
                color[3] = alpha;
            }
            // The sums in the far tail of a splat are too small to divide by.
            if s[0] > 1e-12 {
                let mean = Vec3::new(s[4], s[5], s[6]) / s[0];
                *has_direction = true;
                direction.copy_from_slice(&direction::encode_mean(mean, format));
                let mean = Vec4::new(s[8], s[9], s[10], s[11]) / s[0];
                visibility.copy_from_slice(&encode_visibility(mean));
            }
        },
    );
    (LevelBytes { color, direction: directions, visibility }, has_direction)
}

/// Returns the byte for `opacity` that brings the stored product nearest to `exact`, the true transmittance down
/// through this layer. The byte differs from plain rounding by at most one step; it is 0 without hair.
fn round_opacity(opacity: f32, exact: f32, stored_outside: f32) -> u8 {
    let own = 255.0 * opacity;
    if own < 1e-3 {
        return 0;
    }
    let wanted = if stored_outside > 1e-3 { 255.0 * (1.0 - exact / stored_outside) } else { own };
    (wanted.clamp(own - 1.0, own + 1.0).clamp(0.0, 255.0) + 0.5) as u8
}

/// Fills texels without hair with the direction and visibility of the next coarser level, so that bilinear filtering at
/// a hair's edge mixes in nothing unrelated.
///
/// `size`: width and height of a level. Both are powers of two, and each is half of the previous one, down to 1.
pub(super) fn fill_empty(
    levels: &mut [(LevelBytes, Vec<bool>)],
    size: impl Fn(usize) -> (usize, usize),
    format: TextureFormat,
) {
    if let Some((bytes, has)) = levels.last_mut()
        && !has[0]
    {
        bytes.direction.copy_from_slice(&direction::encode_mean(Vec3::ZERO, format));
        // The level has a single texel. Textures without visibility have nothing to write.
        bytes.visibility.iter_mut().zip(encode_visibility(Vec4::ZERO)).for_each(|(byte, none)| *byte = none);
    }
    for level in (0..levels.len().saturating_sub(1)).rev() {
        let ((n, _), (columns, rows)) = (size(level), size(level + 1));
        let (fine, coarse) = levels.split_at_mut(level + 1);
        let (Some((fine, has)), Some((coarse, _))) = (fine.last_mut(), coarse.first()) else { return };
        let fill = |texels: &mut [u8], parents: &[u8]| {
            texels.par_chunks_mut(4 * n).zip(has.par_chunks(n)).with_min_len(16).enumerate().for_each(
                |(y, (row, has))| {
                    for (x, texel) in row.chunks_exact_mut(4).enumerate().filter(|(x, _)| !has[*x]) {
                        let parent = 4 * ((y / 2).min(rows - 1) * columns + (x / 2).min(columns - 1));
                        texel.copy_from_slice(&parents[parent..parent + 4]);
                    }
                },
            );
        };
        fill(&mut fine.direction, &coarse.direction);
        fill(&mut fine.visibility, &coarse.visibility);
    }
}
