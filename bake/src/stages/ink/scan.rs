//! Scanned washes and strokes: conversion of a painting, or of a detail of one, to a grey tile.
//!
//! First, the background is removed: silk and old paper are dark themselves, and unevenly so. Then the image is blended
//! with a copy shifted by half its size, where each copy fades at its own borders. A plain mean of the two would have
//! less contrast than either. So both are first mapped to a normal distribution. The sum is restored to the variance of
//! that distribution, and mapped back to the image's own histogram (Heitz and Neyret 2018).

use super::plane::Plane;
use crate::noise::smooth_step;
use glam::Vec2;
use pelage_import::BakeError;
use pelage_import::mesh::Image;

/// Minimum side of a scan, texels; smaller scans show no brushwork.
const LEAST_SIDE: u32 = 48;
/// Maximum side after downsampling, texels; equals the side of the largest texture made from a scan. Time and memory
/// grow with its square.
const MOST_SIDE: usize = 2048;
/// Maximum side for estimating the background, texels; the background is smooth and has no details.
const GROUND_SIDE: usize = 256;
/// Minimum difference in grey, 0..=1, between the darkest 1 % and the lightest 1 % of the texels.
const LEAST_CONTRAST: f32 = 0.02;
/// Blur width for estimating the background, as a share of the side.
const GROUND: f32 = 0.16;

/// Grey image of any aspect ratio.
struct Grey {
    width: usize,
    height: usize,
    values: Vec<f32>,
}

/// Converts an image to display luma, because ink is judged as displayed. Downsamples it by averaging to at most
/// `width` by `height` texels.
fn grey(image: &Image, width: usize, height: usize) -> Grey {
    let (columns, rows) = (image.width as usize, image.height as usize);
    let (width, height) = (width.min(columns), height.min(rows));
    let luma = |x: usize, y: usize| {
        let t = &image.rgba[4 * (y * columns + x)..][..4];
        let share = |i: usize| f32::from(t[i]) / 255.0;
        // Transparent texels count as paper.
        let ink = 0.2126 * share(0) + 0.7152 * share(1) + 0.0722 * share(2);
        1.0 - (1.0 - ink) * share(3)
    };
    let values = mean_texels((columns, rows), (width, height), luma);
    Grey { width, height, values }
}

/// Downsamples `value` from `from` to `to` texels (columns, rows) by averaging. Equal sizes leave the values unchanged.
fn mean_texels(from: (usize, usize), to: (usize, usize), value: impl Fn(usize, usize) -> f32) -> Vec<f32> {
    let part = |i: usize, to: usize, from: usize| i * from / to..(i + 1) * from / to;
    let mean = |i: usize| {
        let (columns, rows) = (part(i % to.0, to.0, from.0), part(i / to.0, to.1, from.1));
        let count = columns.len() * rows.len();
        let sum: f64 =
            rows.flat_map(|y| columns.clone().map(move |x| (x, y))).map(|(x, y)| f64::from(value(x, y))).sum();
        (sum / count as f64) as f32
    };
    (0..to.0 * to.1).map(mean).collect()
}

/// Checks that a scan can be used; `key` and `path` are from the recipe.
fn check(key: &str, path: &str, image: &Image, grey: &Grey) -> Result<(), BakeError> {
    let fail = |reason: String| Err(BakeError::Input { file: path.to_owned(), place: key.to_owned(), reason });
    if image.width.min(image.height) < LEAST_SIDE {
        let (w, h) = (image.width, image.height);
        return fail(format!("it has {w} x {h} texels, expected at least {LEAST_SIDE} x {LEAST_SIDE}"));
    }
    let (dark, light) = grey_range(&grey.values);
    if light - dark < LEAST_CONTRAST {
        return fail(format!("its greys range from {dark:.3} to {light:.3}, expected more contrast"));
    }
    Ok(())
}

/// Returns the 1st and the 99th percentile of the greys.
fn grey_range(values: &[f32]) -> (f32, f32) {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f32::total_cmp);
    let at = |share: f32| sorted.get((share * (sorted.len().max(1) - 1) as f32) as usize).copied().unwrap_or(0.0);
    (at(0.01), at(0.99))
}

/// Returns the largest centred square as a plane.
fn square(grey: &Grey) -> Plane {
    let side = grey.width.min(grey.height);
    let (x0, y0) = ((grey.width - side) / 2, (grey.height - side) / 2);
    let values = (0..side * side).map(|i| grey.values[(y0 + i / side) * grey.width + x0 + i % side]).collect();
    Plane { side, values }
}

/// Removes the background: the brightest parts around each texel become white.
fn remove_background(plane: &Plane) -> Plane {
    // Soft maximum: bright parts have far more weight than dark ones.
    let sharp = 24.0;
    let n = plane.side;
    let side = n.min(GROUND_SIDE);
    let small = Plane { side, values: mean_texels((n, n), (side, side), |x, y| plane.values[y * n + x]) };
    let sigma = GROUND * side as f32;
    let mirrored = Plane::from_fn(2 * side, |uv| {
        // The background is mirrored at the borders. The tile of four mirrored copies therefore has no seams.
        let p = (uv * 2.0 - 1.0).abs();
        small.sample(p.min(Vec2::splat(1.0 - 0.5 / side as f32)))
    });
    let weights = mirrored.map(|v| libm::expf(sharp * (v - 1.0)));
    let sums = weights.with(&mirrored, |w, v| w * v).blurred(sigma);
    let ground = sums.with(&weights.blurred(sigma), |sum, w| sum / w.max(1e-12));
    let values = (0..n * n).map(|i| {
        let (x, y) = (i % n, i / n);
        let ground = if side == n {
            ground.at((n + x) as i64, (n + y) as i64)
        } else {
            ground.sample((Vec2::new(x as f32, y as f32) + 0.5) / (2 * n) as f32 + 0.5)
        };
        (plane.values[i] / ground.max(1e-3)).min(1.0)
    });
    Plane { side: n, values: values.collect() }
}

/// Makes a repeating tile from a scanned wash. The side is the image's shorter side, at most 2048 texels; the mean grey
/// is 0.5.
///
/// Fails with [`BakeError::Input`], naming file, key, what was found and what was expected, for an image that is too
/// small or has no contrast.
pub fn wash_tile(path: &str, image: &Image) -> Result<Plane, BakeError> {
    let (width, height) = (image.width as usize, image.height as usize);
    let shorter = width.min(height).max(1);
    let most = shorter.min(MOST_SIDE);
    let grey = grey(image, width * most / shorter, height * most / shorter);
    check("ink.wash_image", path, image, &grey)?;
    let level = remove_background(&square(&grey));
    Ok(tile(&level, [true, true]).balanced(0.15))
}

/// Makes a plane from a scanned stroke, with greys from 0 (ink) to 1 (paper). u runs along the stroke and repeats; v
/// runs across it, from 0 at the outer edge to 1 at the inner edge. The plane has at most 2048 texels along each axis.
///
/// Fails like [`wash_tile`].
pub fn stroke_band(path: &str, image: &Image) -> Result<Plane, BakeError> {
    let grey = grey(image, MOST_SIDE, MOST_SIDE);
    check("ink.stroke_image", path, image, &grey)?;
    // Find the rows that the stroke covers.
    let (dark, light) = grey_range(&grey.values);
    let white = |v: f32| ((v - dark) / (light - dark)).clamp(0.0, 1.0);
    let rows: Vec<f32> = grey
        .values
        .chunks_exact(grey.width)
        .map(|row| row.iter().map(|v| 1.0 - white(*v)).sum::<f32>() / grey.width as f32)
        .collect();
    let most = rows.iter().copied().fold(0.0, f32::max);
    // The outer edge is the outline, with full ink, while the inner edge may fade.
    let first = rows.iter().position(|ink| *ink > 0.5 * most).unwrap_or(0);
    let last = rows.iter().rposition(|ink| *ink > 0.1 * most).unwrap_or(grey.height - 1);
    let side = grey.width.max(last + 1 - first);
    let at = |x: f32, y: f32| {
        let (x, y) = (x.clamp(0.0, (grey.width - 1) as f32), y.clamp(0.0, (grey.height - 1) as f32));
        let (x0, y0) = (x as usize, y as usize);
        let value = |dx: usize, dy: usize| {
            grey.values[(y0 + dy).min(grey.height - 1) * grey.width + (x0 + dx).min(grey.width - 1)]
        };
        let row = |dy: usize| value(0, dy) + (value(1, dy) - value(0, dy)) * x.fract();
        row(0) + (row(1) - row(0)) * y.fract()
    };
    let height = (last + 1 - first) as f32;
    let band = Plane::from_fn(side, |uv| white(at(uv.x * grey.width as f32 - 0.5, first as f32 + uv.y * height - 0.5)));
    Ok(tile(&band, [true, false]))
}

/// Blends an image with shifted copies and keeps its histogram. `wanted` selects the axes (u, v) along which the result
/// repeats.
fn tile(plane: &Plane, wanted: [bool; 2]) -> Plane {
    let n = plane.side;
    let normal = plane.equalised().map(normal_quantile);
    // Weight of the unshifted copy: 0 at the borders, 1 from a quarter of the side on.
    let weight = |i: usize, wanted: bool| {
        let from_border = (i as f32 + 0.5).min(n as f32 - i as f32 - 0.5) / n as f32;
        if wanted { smooth_step(0.0, 0.25, from_border) } else { 1.0 }
    };
    let half = (n / 2) as i64;
    let mixed = (0..n * n).map(|i| {
        let (x, y) = (i % n, i / n);
        let (wx, wy) = (weight(x, wanted[0]), weight(y, wanted[1]));
        let (mut sum, mut power) = (0.0, 0.0f32);
        for (dx, wx) in [(0, wx), (half, 1.0 - wx)] {
            for (dy, wy) in [(0, wy), (half, 1.0 - wy)] {
                if wx * wy > 0.0 {
                    sum += wx * wy * normal.at(x as i64 + dx, y as i64 + dy);
                    power += wx * wy * (wx * wy);
                }
            }
        }
        sum / power.sqrt().max(1e-6)
    });
    let ranks = Plane { side: n, values: mixed.collect() }.equalised();
    let mut sorted = plane.values.clone();
    sorted.sort_unstable_by(f32::total_cmp);
    ranks.map(|rank| sorted[((rank * (n * n) as f32) as usize).min(n * n - 1)])
}

/// Returns the quantile of the standard normal distribution at `rank`, 0..1 (Abramowitz and Stegun 26.2.23; error below
/// 5e-4).
fn normal_quantile(rank: f32) -> f32 {
    let p = rank.min(1.0 - rank).max(1e-7);
    let t = (-2.0 * libm::logf(p)).sqrt();
    let value =
        t - (2.515_517 + t * (0.802_853 + t * 0.010_328)) / (1.0 + t * (1.432_788 + t * (0.189_269 + t * 0.001_308)));
    if rank < 0.5 { -value } else { value }
}

#[cfg(test)]
#[path = "scan_tests.rs"]
mod tests;
