//! Measures of a painting: its strokes, and the picture that they give.
//!
//! Densities are optical: the negative natural logarithm of the picture's luminance over that of the paper. Lengths are
//! compared with the diagonal of the animal's bounding box in the picture.

use crate::mask::Mask;
use glam::DVec2;
use image::RgbaImage;
use pelage_import::BakeError;
use pelage_runtime::{PictureStroke, StrokeLayer, StrokeMark};
use pelage_truth::{SurfaceVisibility, TrueCamera};
use std::collections::BTreeSet;

/// Density from which paper counts as painted.
pub const PAINTED: f32 = 0.12;
/// Excess over the blurred picture, and density, from which a pixel belongs to a dark mark.
const DARK_MARK: [f32; 2] = [0.18, 0.35];
/// Standard deviations of the blur around dark marks, and of their spread, pixels in a picture of 700 rows.
const AROUND: [f32; 2] = [9.0, 1.2];
/// Spread share from which the outline counts as dark.
const IS_DARK: f32 = 0.25;
/// Depth of the outline, pixels in a picture of 700 rows.
const OUTLINE: f64 = 2.5;
/// Rows of the pictures for which the figures above were chosen.
const ROWS: f32 = 700.0;
/// Share of the diagonal from which a stroke is long, and within which ink is near.
const LONG: f64 = 0.08;
const NEAR: f64 = 0.02;
/// Narrowest over widest part of a stroke up to which it lifts.
const LIFTS: f32 = 0.4;
/// Density up to which a point of a stroke has no ink.
const FAINT: f32 = 0.02;
/// Dryness from which a brush leaves white, the share of the width that is looked at, and the share of the stroke's
/// density below which a pixel is white.
const DRY: f32 = 0.35;
const MIDDLE: f32 = 0.6;
const WHITE: f32 = 0.25;

/// Measures of a painting.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PaintingMeasures {
    /// Number of strokes except tufts of fur and the ground.
    pub strokes: usize,
    /// Number of tufts.
    pub tufts: usize,
    /// Share of the ink in strokes longer than 8 % of the diagonal.
    pub in_long: f64,
    /// Mean over strokes of the standard deviation of the width over its mean.
    pub width_variation: f64,
    /// Mean over strokes of the fall of the density, relative to its maximum.
    pub tone_fall: f64,
    /// Share of the animal that is paper.
    pub unpainted: f64,
    /// Share of the animal's outline with a dark edge.
    pub dark_outline: f64,
    /// Share of strokes whose narrowest part has at most 40 % of the greatest width, without dabs: spots and eyes.
    pub lifted: f64,
    /// Share of the outline with ink within 2 % of the diagonal.
    pub marked_outline: f64,
    /// Longest part of the outline without ink that near, as a share of the outline.
    pub longest_gap: f64,
}

/// Optical densities of a picture.
#[derive(Clone, Debug)]
pub struct Densities {
    /// Width and height, pixels.
    pub size: (u32, u32),
    /// Density of each pixel, row-major from the top, 0..=3.
    pub values: Vec<f32>,
}

impl Densities {
    /// Returns the densities relative to the paper, whose luminance is the 92nd percentile of the picture.
    pub fn of(picture: &RgbaImage) -> Self {
        let light: Vec<f32> = picture
            .pixels()
            .map(|p| (0.3 * f32::from(p.0[0]) + 0.59 * f32::from(p.0[1]) + 0.11 * f32::from(p.0[2])) / 255.0)
            .collect();
        let mut sorted = light.clone();
        sorted.sort_unstable_by(f32::total_cmp);
        let paper = sorted.get(sorted.len() * 92 / 100).copied().unwrap_or(1.0).max(0.01);
        let density = |l: f32| (-libm::logf(l.max(0.01) / paper)).clamp(0.0, 3.0);
        Self { size: picture.dimensions(), values: light.into_iter().map(density).collect() }
    }

    /// Returns the pixels from a density on.
    pub fn from(&self, density: f32) -> Mask {
        let width = self.size.0;
        Mask::from_fn(width, self.size.1, |x, y| self.values[(y * width + x) as usize] >= density)
    }

    fn blurred(&self, sigma: f32) -> Vec<f32> {
        let once = blur(&self.values, self.size, sigma, 1);
        blur(&once, self.size, sigma, self.size.0 as usize)
    }

    /// Returns the mean density of a mask.
    pub fn mean(&self, mask: &Mask) -> f64 {
        let of: Vec<f64> =
            self.values.iter().zip(&mask.pixels).filter(|(_, m)| **m).map(|(d, _)| f64::from(*d)).collect();
        of.iter().sum::<f64>() / of.len().max(1) as f64
    }
}

/// Blurs along rows (`step` 1) or columns (`step` the width). Values beyond the edge are those of the edge.
fn blur(values: &[f32], (width, height): (u32, u32), sigma: f32, step: usize) -> Vec<f32> {
    let reach = (3.0 * sigma).ceil() as i64;
    let weights: Vec<f32> = (-reach..=reach).map(|k| libm::expf(-0.5 * (k as f32 / sigma).powi(2))).collect();
    let all: f32 = weights.iter().sum();
    let (width, height) = (width as usize, height as usize);
    let at = |i: usize| {
        let (place, last) = if step == 1 { (i % width, width - 1) } else { (i / width, height - 1) };
        let value = |k: i64| values[i + step * (place as i64 + k).clamp(0, last as i64) as usize - step * place];
        (-reach..=reach).zip(&weights).map(|(k, w)| w * value(k)).sum::<f32>() / all
    };
    (0..values.len()).map(at).collect()
}

fn steps(stroke: &PictureStroke) -> impl Iterator<Item = (f64, f32, f32)> + '_ {
    stroke.marks.windows(2).map(|pair| {
        let [x, y] = [0, 1].map(|k| f64::from(pair[1].position[k] - pair[0].position[k]));
        let half = |of: fn(&StrokeMark) -> f32| 0.5 * (of(&pair[0]) + of(&pair[1]));
        (x.hypot(y), half(|m| m.half_width), half(|m| m.density))
    })
}

/// Returns the length of a stroke, pixels.
pub fn stroke_length(stroke: &PictureStroke) -> f64 {
    steps(stroke).map(|(long, ..)| long).sum()
}

/// Returns the ink of a stroke: its area times its density.
pub fn stroke_ink(stroke: &PictureStroke) -> f64 {
    steps(stroke).map(|(long, half, density)| long * f64::from(2.0 * half * density)).sum()
}

/// Whether a stroke belongs to the body: not a tuft, and not the ground.
pub fn is_of_body(stroke: &PictureStroke) -> bool {
    !matches!(stroke.layer, StrokeLayer::Tuft | StrokeLayer::Lock | StrokeLayer::Ground)
}

/// Returns the diagonal of the bounding box of a mask, pixels.
pub fn diagonal(mask: &Mask) -> f64 {
    let range = |of: &dyn Fn(usize) -> usize| {
        let all = mask.pixels.iter().enumerate().filter(|(_, m)| **m).map(|(i, _)| of(i));
        let [low, high] = all.fold([usize::MAX, 0], |[low, high], x| [low.min(x), high.max(x)]);
        high.saturating_sub(low) as f64
    };
    let width = mask.width as usize;
    range(&|i| i % width).hypot(range(&|i| i / width))
}

/// Returns the pixels of a posed mesh.
pub fn body(sight: &SurfaceVisibility, camera: &TrueCamera, size: (u32, u32)) -> Mask {
    let view = sight.view(camera, size);
    Mask::from_fn(size.0, size.1, |x, y| view.at(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)).is_some())
}

/// Returns the pixels at the border of a mask, within it.
fn border(mask: &Mask) -> Mask {
    Mask::from_fn(mask.width, mask.height, |x, y| {
        let (x, y) = (i64::from(x), i64::from(y));
        mask.contains(x, y) && [(1, 0), (-1, 0), (0, 1), (0, -1)].iter().any(|(dx, dy)| !mask.contains(x + dx, y + dy))
    })
}

fn inverse(mask: &Mask) -> Mask {
    Mask { pixels: mask.pixels.iter().map(|p| !p).collect(), ..*mask }
}

/// Returns the number of pixels in the largest connected part of a mask.
fn largest_part(mask: &Mask) -> usize {
    let mut left: BTreeSet<(i64, i64)> = (0..mask.pixels.len())
        .filter(|i| mask.pixels[*i])
        .map(|i| ((i % mask.width as usize) as i64, (i / mask.width as usize) as i64))
        .collect();
    let mut largest = 0;
    while let Some(first) = left.pop_first() {
        let (mut stack, mut count) = (vec![first], 0);
        while let Some((x, y)) = stack.pop() {
            count += 1;
            for (dx, dy) in (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| (dx, dy))) {
                if left.remove(&(x + dx, y + dy)) {
                    stack.push((x + dx, y + dy));
                }
            }
        }
        largest = largest.max(count);
    }
    largest
}

fn share(part: usize, whole: usize) -> f64 {
    part as f64 / whole.max(1) as f64
}

/// Measures a painting of one animal.
///
/// * `strokes`: of the frame
/// * `body`: pixels of the animal
///
/// # Errors
///
/// [`BakeError::Params`] if the sizes differ.
pub fn measure_painting(
    strokes: &[PictureStroke],
    picture: &RgbaImage,
    body: &Mask,
) -> Result<PaintingMeasures, BakeError> {
    let densities = Densities::of(picture);
    let painted = densities.from(PAINTED);
    painted.same_size(body)?;
    let diagonal = diagonal(body);
    let scale = body.height as f32 / ROWS;

    let body_strokes: Vec<_> = strokes.iter().filter(|s| is_of_body(s)).collect();
    // Strokes begin and end with points without ink.
    let inked = |s: &PictureStroke, value: fn(&StrokeMark) -> f32| {
        s.marks.iter().filter(|m| m.density > FAINT).map(value).collect::<Vec<_>>()
    };
    let of_body = |value: fn(&StrokeMark) -> f32, measure: &dyn Fn(&[f32]) -> f64| {
        let each = body_strokes.iter().map(|s| measure(&inked(s, value)));
        each.sum::<f64>() / body_strokes.len().max(1) as f64
    };
    let most = |v: &[f32]| v.iter().copied().fold(0.0, f32::max);
    let least = |v: &[f32]| v.iter().copied().fold(f32::INFINITY, f32::min);
    let variation = |v: &[f32]| {
        let mean = v.iter().sum::<f32>() / v.len() as f32;
        f64::from((v.iter().map(|x| (x - mean).powi(2)).sum::<f32>() / v.len() as f32).sqrt() / mean.max(1e-6))
    };
    let fall = |v: &[f32]| f64::from(1.0 - least(v) / most(v).max(1e-6));
    let is_dab = |s: &&&PictureStroke| matches!(s.layer, StrokeLayer::Spot | StrokeLayer::Eye);
    let drawn: Vec<_> = body_strokes.iter().filter(|s| !is_dab(s)).map(|s| inked(s, |m| m.half_width)).collect();
    let lifted = drawn.iter().filter(|v| least(v) <= LIFTS * most(v)).count();
    let inks: Vec<(f64, f64)> =
        strokes.iter().filter(|s| s.layer != StrokeLayer::Ground).map(|s| (stroke_length(s), stroke_ink(s))).collect();
    let in_long: f64 = inks.iter().filter(|(long, _)| *long > LONG * diagonal).map(|(_, ink)| ink).sum();
    let ink: f64 = inks.iter().map(|(_, ink)| ink).sum();

    let around = densities.blurred(AROUND[0] * scale);
    let dark: Vec<f32> = densities
        .values
        .iter()
        .zip(&around)
        .map(|(d, a)| f32::from(u8::from(d - a > DARK_MARK[0] && *d > DARK_MARK[1])))
        .collect();
    let spread = Densities { size: densities.size, values: dark }.blurred((AROUND[1] * scale).max(0.6));
    let depth = inverse(body).distances();
    let is_outline = |i: usize| body.pixels[i] && depth[i] <= (OUTLINE * f64::from(scale)).max(1.5);
    let outline: Vec<usize> = (0..body.pixels.len()).filter(|i| is_outline(*i)).collect();

    let border = border(body);
    let to_ink = painted.distances();
    let bare = Mask {
        pixels: (0..border.pixels.len()).map(|i| border.pixels[i] && to_ink[i] > NEAR * diagonal).collect(),
        ..border
    };
    let is_paper = |i: &usize| body.pixels[*i] && !painted.pixels[*i];
    Ok(PaintingMeasures {
        strokes: body_strokes.len(),
        tufts: strokes.iter().filter(|s| s.layer == StrokeLayer::Tuft).count(),
        in_long: in_long / ink.max(1e-9),
        width_variation: of_body(|m| m.half_width, &variation),
        tone_fall: of_body(|m| m.density, &fall),
        unpainted: share((0..body.pixels.len()).filter(is_paper).count(), body.count()),
        dark_outline: share(outline.iter().filter(|i| spread[**i] > IS_DARK).count(), outline.len()),
        lifted: share(lifted, drawn.len()),
        marked_outline: 1.0 - share(bare.count(), border.count()),
        longest_gap: share(largest_part(&bare), border.count()),
    })
}

/// Returns the share of the painted pixels that are farther than 2 % of the diagonal from the animal. The painting must
/// have no tufts and no ground.
pub fn outside(picture: &RgbaImage, body: &Mask) -> f64 {
    let painted = Densities::of(picture).from(PAINTED);
    let (far, most) = (body.distances(), NEAR * diagonal(body));
    share((0..painted.pixels.len()).filter(|i| painted.pixels[*i] && far[*i] > most).count(), painted.count())
}

/// Returns the share of dry strokes' middles that the brush leaves white; `None` without dry strokes. The painting must
/// have no washes, so that white is paper.
pub fn flying_white(strokes: &[PictureStroke], picture: &RgbaImage) -> Option<f64> {
    let densities = Densities::of(picture);
    let (width, height) = densities.size;
    let (mut white, mut all) = (0, 0);
    for mark in strokes.iter().filter(|s| is_of_body(s)).flat_map(|s| &s.marks) {
        let reach = MIDDLE * mark.half_width;
        if mark.dryness < DRY || mark.density < FAINT || reach < 0.5 {
            continue;
        }
        let [x, y] = mark.position;
        let rows = (y - reach).floor().max(0.0) as u32..((y + reach).ceil() as u32).min(height);
        for (px, py) in rows.flat_map(|py| {
            ((x - reach).floor().max(0.0) as u32..((x + reach).ceil() as u32).min(width)).map(move |px| (px, py))
        }) {
            if (px as f32 + 0.5 - x).hypot(py as f32 + 0.5 - y) <= reach {
                all += 1;
                white += usize::from(densities.values[(py * width + px) as usize] < WHITE * mark.density);
            }
        }
    }
    (all > 0).then(|| share(white, all))
}

/// Returns the pixels near the contour lines of a painting, within `near_px` of their middle.
pub fn drawn_lines(strokes: &[PictureStroke], (width, height): (u32, u32), near_px: f64) -> Mask {
    let mut middles = Mask::empty(width, height);
    for stroke in strokes.iter().filter(|s| s.layer == StrokeLayer::Line) {
        for pair in stroke.marks.windows(2) {
            let [a, b] = [0, 1].map(|k| pair[k].position);
            let parts = (b[0] - a[0]).hypot(b[1] - a[1]).ceil().max(1.0);
            for k in 0..=parts as u32 {
                let t = k as f32 / parts;
                let at = [0, 1].map(|c| (a[c] + (b[c] - a[c]) * t).floor() as i64);
                middles.insert(at[0], at[1]);
            }
        }
    }
    let far = middles.distances();
    Mask { pixels: far.into_iter().map(|d| d <= near_px).collect(), ..middles }
}

/// Returns the share of the lines of a frame that continue one of the frame before: at least half of their points are
/// within `near_px` of the same earlier line. `None` without lines.
pub fn continued_lines(before: &[PictureStroke], after: &[PictureStroke], near_px: f32) -> Option<f64> {
    let is_line = |s: &&PictureStroke| s.layer == StrokeLayer::Line;
    let earlier: Vec<_> = before.iter().filter(is_line).collect();
    let lines: Vec<_> = after.iter().filter(is_line).collect();
    let continues = |line: &&&PictureStroke| {
        earlier.iter().any(|old| {
            let is_near = |mark: &&StrokeMark| {
                let apart = |m: &StrokeMark| (m.position[0] - mark.position[0]).hypot(m.position[1] - mark.position[1]);
                old.marks.iter().any(|m| apart(m) <= near_px)
            };
            2 * line.marks.iter().filter(is_near).count() >= line.marks.len()
        })
    };
    (!lines.is_empty()).then(|| share(lines.iter().filter(continues).count(), lines.len()))
}
