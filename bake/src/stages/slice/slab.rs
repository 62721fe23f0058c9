//! Fin textures: the strands of the tile seen from the side (Lengyel et al. 2001, "fin texture").
//!
//! A fin slice is a vertical slice of the tile, whose strands are projected onto the plane of the cut. Hair leans in
//! the tile. A slice along the lean shows the hair bent over; a slice across the lean does not. There are
//! [`FIN_SLICES`] fin slices, along directions in which a line through the periodic tile closes. A fin uses the slice
//! most parallel to its edge.
//!
//! Whole strands are drawn, chosen by their roots, so that no hair is cut at the faces of a slice. Each texel is the
//! average of [`SUPERSAMPLES`]² finer ones. So a coarse texel keeps the share that its hairs cover; the opacity of
//! their mean density would be higher. Further mips are plain means of premultiplied texels, so the covered share is
//! the same in all of them.

use super::direction;
use super::encode::{AlphaMode, RawLevel, TextureEncoder};
use super::layer::{LevelBytes, fill_empty};
use super::shells::ShellTextures;
use super::splat::{SPACING, extinction, weights};
use crate::recipe::{FinParams, PackParams, SliceParams};
use crate::stages::simulate::Strands;
use glam::{Vec2, Vec3};
use pelage_formats::TextureFormat;
use pelage_formats::meaning::linear_to_srgb;
use pelage_import::BakeError;
use rayon::prelude::*;

/// Direction of a fin slice through the tile: `(p, q)`, numbers of tiles along u and v after which a line returns to
/// its start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FinSlice {
    step: [i8; 2],
    /// Offset (m, n) to the neighbouring tile that is one period away across the slice: −q·m + p·n = 1.
    neighbour: [i8; 2],
}

/// Slices of a fin texture, in the order of its array layers. Their directions are 45° apart.
pub const FIN_SLICES: [FinSlice; 4] = [
    FinSlice { step: [1, 0], neighbour: [0, 1] },
    FinSlice { step: [1, 1], neighbour: [0, 1] },
    FinSlice { step: [0, 1], neighbour: [-1, 0] },
    FinSlice { step: [-1, 1], neighbour: [0, -1] },
];

/// Number of fine texels per texel of the fin texture, along each axis. The number is reduced if the fine texture would
/// exceed [`MAX_FINE`] texels per side.
const SUPERSAMPLES: u32 = 4;
const MAX_FINE: u32 = 1024;
/// Texels of a fin texture per texel of the shells. Hair in fins is seen from the side, outlined against its
/// background, so it needs a finer resolution. The whole texture is still smaller than one layer of the shells.
const TEXELS_PER_SHELL_TEXEL: u32 = 2;

impl FinSlice {
    /// Returns the length of one period of the slice, tile widths.
    pub fn period(self) -> f32 {
        let [p, q] = self.step.map(f32::from);
        (p * p + q * q).sqrt()
    }

    /// Returns the unit direction of the slice in the tile.
    pub fn direction(self) -> Vec2 {
        Vec2::from(self.step.map(f32::from)) / self.period()
    }
}

/// Returns the index of the fin slice most parallel to `direction`, which may have any length. Also returns whether
/// slice and `direction` point in opposite directions.
pub fn fin_slice_along(direction: Vec2) -> (usize, bool) {
    let mut best = (0, 0.0f32);
    for (index, slab) in FIN_SLICES.iter().enumerate() {
        let along = slab.direction().dot(direction);
        if along.abs() > best.1.abs() {
            best = (index, along);
        }
    }
    (best.0, best.1 < 0.0)
}

/// Fin textures of all slices.
#[derive(Clone, Debug, PartialEq)]
pub struct FinTextures {
    /// Complete .ktx2 files; one array layer per slice.
    pub textures: ShellTextures,
    /// Width, texels. It spans one period of the slice.
    pub width: u32,
    /// Height, texels. It spans the height from 0 to [`Strands::height`].
    pub height: u32,
}

/// Sums per texel: optical depth, depth times linear RGB, depth times direction, and padding. After
/// [`Raster::resolve`], opacity replaces depth.
type Sums = [f32; 8];

/// Draws and encodes the fin slices; each is `depth` tile widths deep.
///
/// Fails with [`BakeError::Params`] for a value outside its range, [`BakeError::Internal`] for inconsistent strands or
/// if the encoder fails.
pub fn fin_textures(
    strands: &Strands,
    depth: f32,
    slice: &SliceParams,
    pack: &PackParams,
) -> Result<FinTextures, BakeError> {
    slice.validate()?;
    pack.validate()?;
    strands.validate()?;
    FinParams { depth: Some(depth), ..FinParams::default() }.validate()?;
    let (width, height) = size(strands, slice);
    let direction_format = TextureFormat::from(pack.direction_format);
    let slabs: Vec<_> = FIN_SLICES
        .par_iter()
        .map(|slab| {
            levels(draw(strands, *slab, depth, (width, height), slice.filter_width), (width, height), direction_format)
        })
        .collect();
    let mut color = TextureEncoder::new(pack.shell_format.into(), AlphaMode::Premultiplied, pack.bc_quality);
    let mut direction = TextureEncoder::new(direction_format, AlphaMode::Straight, pack.bc_quality);
    for levels in &slabs {
        let raw = |texels: &[(u32, u32, Vec<u8>)], encoder: &mut TextureEncoder| {
            let raw = texels.iter().map(|(width, height, texels)| RawLevel { width: *width, height: *height, texels });
            encoder.push_layer(&raw.collect::<Vec<_>>())
        };
        raw(&levels.0, &mut color)?;
        raw(&levels.1, &mut direction)?;
    }
    let textures =
        ShellTextures { color: color.finish()?, direction: direction.finish()?, visibility: None, coat: None };
    Ok(FinTextures { textures, width, height })
}

/// Returns width and height of the textures. Both are powers of two, so that each mip level halves the one before, and
/// multiples of the encoders' block size.
fn size(strands: &Strands, slice: &SliceParams) -> (u32, u32) {
    let width = (TEXELS_PER_SHELL_TEXEL * slice.tile_texels).min(MAX_FINE);
    let height = (strands.height * width as f32).ceil().clamp(8.0, MAX_FINE as f32) as u32;
    (width, height.next_power_of_two().min(MAX_FINE))
}

/// Draws one fin slice at the texture's size. Returns sums of opacity, opacity times colour, and opacity times
/// direction.
fn draw(strands: &Strands, slab: FinSlice, depth: f32, (width, height): (u32, u32), filter_width: f32) -> Vec<Sums> {
    let samples = (MAX_FINE / width.max(height)).clamp(1, SUPERSAMPLES);
    let (w, h) = ((width * samples) as usize, (height * samples) as usize);
    let mut raster = Raster { width: w, height: h, sums: vec![[0.0; 8]; w * h], weights: Default::default() };
    // Number of fine texels per tile width.
    let scale = Vec2::new(w as f32 / slab.period(), h as f32 / strands.height);
    let [p, q] = slab.step.map(f32::from);
    let [m, n] = slab.neighbour.map(f32::from);
    for strand in 0..strands.len() {
        let range = strands.range(strand);
        let Some(root) = strands.points.get(range.start) else { continue };
        // Position across the slice, in periods. It is 0..1 in the tile itself, and increases by 1 with each
        // neighbouring tile.
        let across = p * root.y - q * root.x;
        let mut image = -across.floor();
        while across + image < depth * slab.period() {
            let shift = Vec2::new(m, n) * image;
            for i in range.start..range.end.saturating_sub(1) {
                let along = |point: Vec3| {
                    let at = point.truncate() + shift;
                    Vec2::new((p * at.x + q * at.y) / slab.period(), point.z)
                };
                let (a, b) = (strands.points[i], strands.points[i + 1]);
                let Some(tangent) = (b - a).try_normalize() else { continue };
                let radius = 0.5 * (strands.radii[i] + strands.radii[i + 1]);
                let variance = scale * scale * (0.5 * radius * radius) + filter_width * filter_width;
                // The total optical depth equals that seen from above: density times the volume of the cylinder.
                let sharpness = radius * (scale.x * scale.y / (variance.x * variance.y).sqrt()).sqrt();
                let density = extinction(sharpness);
                let volume = density * std::f32::consts::PI * radius * (b - a).length() * scale.x * scale.y;
                let color = 0.5 * (strands.colors[i] + strands.colors[i + 1]);
                let direction = direction::upward(tangent);
                let values =
                    [1.0, color.x, color.y, color.z, direction.x, direction.y, direction.z, 0.0].map(|v| v * volume);
                raster.streak(along(a) * scale, along(b) * scale, variance, values);
            }
            image += 1.0;
        }
    }
    raster.resolve(samples as usize)
}

/// Sums over the strands of a fin slice, per fine texel.
struct Raster {
    width: usize,
    height: usize,
    sums: Vec<Sums>,
    weights: [Vec<f32>; 2],
}

impl Raster {
    /// Adds `values`, spread along the line from `a` to `b` with a Gaussian around it. u wraps. Contributions below the
    /// surface or above the texture are discarded.
    fn streak(&mut self, a: Vec2, b: Vec2, variance: Vec2, values: Sums) {
        let spacing = SPACING * variance.min_element().sqrt();
        let pieces = ((b - a).length() / spacing).ceil().max(1.0);
        let values = values.map(|v| v / pieces);
        for i in 0..pieces as u32 {
            let center = a + (b - a) * ((i as f32 + 0.5) / pieces);
            let [columns, rows] = &mut self.weights;
            let x0 = weights(center.x, variance.x, columns);
            let y0 = weights(center.y, variance.y, rows);
            for (j, wy) in rows.iter().enumerate() {
                let Some(y) = usize::try_from(y0 + j as i64).ok().filter(|y| *y < self.height) else { continue };
                let row = &mut self.sums[y * self.width..(y + 1) * self.width];
                for (k, wx) in columns.iter().enumerate() {
                    let x = (x0 + k as i64).rem_euclid(row.len() as i64) as usize;
                    row[x].iter_mut().zip(values).for_each(|(sum, v)| *sum += v * wx * wy);
                }
            }
        }
    }

    /// Converts optical depth to opacity, multiplied by a factor that falls linearly from 1 at the surface to 0 at the
    /// top. Then averages each `samples` × `samples` fine texels into one texel.
    fn resolve(mut self, samples: usize) -> Vec<Sums> {
        for (y, row) in self.sums.chunks_exact_mut(self.width).enumerate() {
            let above = 1.0 - (y as f32 + 0.5) / self.height as f32;
            for s in row.iter_mut().filter(|s| s[0] > 0.0) {
                let opacity = -libm::expm1f(-s[0]) * above;
                let share = opacity / s[0];
                s[1..].iter_mut().for_each(|v| *v *= share);
                s[0] = opacity;
            }
        }
        shrink(&self.sums, self.width, (samples, samples))
    }
}

/// Averages rectangles of `x` by `y` texels of an image that is `width` texels wide.
fn shrink(fine: &[Sums], width: usize, (x, y): (usize, usize)) -> Vec<Sums> {
    let columns = width / x;
    let share = 1.0 / (x * y) as f32;
    let mut out = vec![[0.0; 8]; fine.len() / (x * y)];
    for (i, s) in fine.iter().enumerate() {
        let to = &mut out[i / width / y * columns + i % width / x];
        to.iter_mut().zip(s).for_each(|(sum, v)| *sum += v * share);
    }
    out
}

/// Levels of a texture, finest first: width, height and texels.
type Levels = Vec<(u32, u32, Vec<u8>)>;

/// Returns the bytes of all mip levels, of colour and of direction. Directions have as many components as `format`.
fn levels(sums: Vec<Sums>, (mut width, mut height): (u32, u32), format: TextureFormat) -> (Levels, Levels) {
    let mut sums = sums;
    let mut sizes = Vec::new();
    let mut bytes = Vec::new();
    loop {
        sizes.push((width, height));
        bytes.push(store(&sums, format));
        if width == 1 && height == 1 {
            break;
        }
        let step = (width.min(2) as usize, height.min(2) as usize);
        sums = shrink(&sums, width as usize, step);
        (width, height) = ((width / 2).max(1), (height / 2).max(1));
    }
    fill_empty(&mut bytes, |level| (sizes[level].0 as usize, sizes[level].1 as usize), format);
    let mut out = (Vec::new(), Vec::new());
    for ((width, height), (LevelBytes { color, mut direction, .. }, _)) in sizes.into_iter().zip(bytes) {
        if format.components() == 2 {
            direction = direction.chunks_exact(4).flat_map(|t| [t[0], t[1]]).collect();
        }
        out.0.push((width, height, color));
        out.1.push((width, height, direction));
    }
    out
}

/// Returns the bytes of one level, without visibility, and whether each texel has a direction of its own.
fn store(sums: &[Sums], format: TextureFormat) -> (LevelBytes, Vec<bool>) {
    let mut out = (LevelBytes::default(), Vec::new());
    for s in sums {
        let alpha = (255.0 * s[0] + 0.5).clamp(0.0, 255.0) as u8;
        // Colour is premultiplied by the stored opacity.
        let share = if s[0] > 0.0 { f32::from(alpha) / (255.0 * s[0]) } else { 0.0 };
        out.0.color.extend([s[1], s[2], s[3]].map(|v| linear_to_srgb(v * share)));
        out.0.color.push(alpha);
        let known = s[0] > 1e-12;
        let mean = if known { Vec3::new(s[4], s[5], s[6]) / s[0] } else { Vec3::ZERO };
        out.0.direction.extend(direction::encode_mean(mean, format));
        out.1.push(known);
    }
    out
}

#[cfg(test)]
#[path = "slab_tests.rs"]
mod tests;
