//! Comparison of two pictures: FLIP, RMSE, PSNR and the difference of coverage.
//!
//! FLIP estimates the difference that a person sees who alternates between the two pictures: P. Andersson, J. Nilsson,
//! T. Akenine-Möller, M. Oskarsson, K. Åström, M. Fairchild, *FLIP: A Difference Evaluator for Alternating Images*, HPG
//! 2020. The authors' own code computes it. FLIP compares opaque 8-bit pictures, so both are composited over a
//! background first. The other figures compare the pictures as they are, in linear light.

use image::{Rgb, RgbImage, RgbaImage};
use nv_flip::FlipImageRgb8;
use pelage_bake::picture::{Picture, encode_png};
use pelage_import::BakeError;
use serde::Serialize;

/// Viewing conditions of a comparison.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CompareParams {
    /// Background on which transparent pictures are composited for FLIP, sRGB-encoded (default middle grey 128, 128,
    /// 128). The more it differs from the fur in brightness, the more errors of the outline count.
    pub over: [u8; 3],
    /// Pixels per degree of the viewer's field of view, above 0 (default 67: a 4K screen 0.7 m wide, seen from 0.7 m).
    /// A smaller number means coarser pixels, whose errors are more visible.
    pub pixels_per_degree: f32,
}

impl Default for CompareParams {
    fn default() -> Self {
        Self { over: [128; 3], pixels_per_degree: nv_flip::DEFAULT_PIXELS_PER_DEGREE }
    }
}

/// Statistics of FLIP over all pixels. Each is 0 (equal) to 1 (black against white).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct FlipFigures {
    /// Mean over the picture, the figure that FLIP's authors recommend.
    pub mean: f64,
    /// Mean over the pixels that at least one of the pictures covers; independent of the empty background. 0 if there
    /// are none.
    pub covered: f64,
    /// Weighted median: pixels with a larger error than this contribute half of the sum of all errors.
    pub weighted_median: f64,
    /// Maximum over all pixels.
    pub max: f64,
}

/// Difference of two pictures.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Comparison {
    /// FLIP: the perceived difference.
    pub flip: FlipFigures,
    /// Root mean square difference of premultiplied linear red, green and blue over all pixels; 1 for black against
    /// white.
    pub rmse: f64,
    /// Peak signal-to-noise ratio, decibels: −20 log10 of `rmse`. Infinite for equal pictures, which JSON stores as
    /// null.
    #[cfg_attr(feature = "schema", schemars(with = "Option<f64>"))]
    pub psnr_db: f64,
    /// Mean absolute difference of alpha, 0..=1.
    pub coverage: f64,
}

/// FLIP value of each pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct FlipMap {
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// FLIP values, `width * height` numbers of 0..=1, row-major from the top.
    pub values: Vec<f32>,
}

impl FlipMap {
    /// Returns the map in *magma* colours, from black for 0 to a pale yellow for 1.
    pub fn magma(&self) -> RgbImage {
        let table = nv_flip::magma_lut().to_vec();
        RgbImage::from_fn(self.width, self.height, |x, y| {
            let value = self.values[(y * self.width + x) as usize];
            let i = 3 * (value.clamp(0.0, 1.0) * 255.0).round() as usize;
            Rgb([table[i], table[i + 1], table[i + 2]])
        })
    }

    /// Encodes [`Self::magma`] as PNG.
    ///
    /// Fails with [`BakeError::Internal`] if the encoder fails.
    pub fn png(&self) -> Result<Vec<u8>, BakeError> {
        encode_png(&self.magma())
    }
}

/// Compares two pictures of sRGB-encoded bytes with straight alpha, as stored in PNG, at the default pixels per degree.
/// If the arguments are swapped, the figures change only by rounding.
///
/// Fails with [`BakeError::Params`] if the sizes differ.
pub fn compare(a: &RgbaImage, b: &RgbaImage, over: [u8; 3]) -> Result<(Comparison, FlipMap), BakeError> {
    compare_pictures(&a.into(), &b.into(), &CompareParams { over, ..CompareParams::default() })
}

/// Compares two pictures of linear light.
///
/// Fails with [`BakeError::Params`] if the sizes differ, or if the pictures have no pixels.
pub fn compare_pictures(a: &Picture, b: &Picture, params: &CompareParams) -> Result<(Comparison, FlipMap), BakeError> {
    if (a.width, a.height) != (b.width, b.height) || a.pixels.len() != b.pixels.len() || a.pixels.is_empty() {
        let size = |p: &Picture| format!("{}x{}", p.width, p.height);
        let reason = format!("found {} and {} pixels, expected the same size for both", size(a), size(b));
        return Err(BakeError::Params { what: "pictures", reason });
    }
    let (mut squares, mut alphas) = (0.0, 0.0);
    for (p, q) in a.pixels.iter().zip(&b.pixels) {
        let apart = |i: usize| f64::from(p[i]) - f64::from(q[i]);
        squares += [0, 1, 2].map(|i| apart(i).powi(2)).iter().sum::<f64>();
        alphas += apart(3).abs();
    }
    let count = a.pixels.len() as f64;
    let rmse = (squares / (3.0 * count)).sqrt();
    let map = flip(a, b, params);
    let comparison = Comparison {
        flip: figures(&map, |i| a.pixels[i][3] > 0.0 || b.pixels[i][3] > 0.0),
        rmse,
        psnr_db: if rmse > 0.0 { -20.0 * libm::log10(rmse) } else { f64::INFINITY },
        coverage: alphas / count,
    };
    Ok((comparison, map))
}

fn flip(a: &Picture, b: &Picture, params: &CompareParams) -> FlipMap {
    let (width, height) = (a.width, a.height);
    let image = |p: &Picture| FlipImageRgb8::with_data(width, height, &p.composite_over(params.over));
    let map = nv_flip::flip(image(a), image(b), params.pixels_per_degree);
    FlipMap { width, height, values: map.to_vec() }
}

/// Computes the figures of a map. Sums in f64, because the f32 sums of the library lose digits over a large picture.
fn figures(map: &FlipMap, covered: impl Fn(usize) -> bool) -> FlipFigures {
    let values = || map.values.iter().map(|v| f64::from(*v));
    let mean = |sum: f64, count: usize| sum / count.max(1) as f64;
    let total: f64 = values().sum();
    let (sum, count) =
        values().enumerate().filter(|(i, _)| covered(*i)).fold((0.0, 0), |(s, n), (_, v)| (s + v, n + 1));
    let mut sorted: Vec<f64> = values().collect();
    sorted.sort_by(f64::total_cmp);
    let mut below = 0.0;
    let median = sorted.iter().find(|v| {
        below += **v;
        below >= 0.5 * total
    });
    FlipFigures {
        mean: mean(total, map.values.len()),
        covered: mean(sum, count),
        weighted_median: median.copied().unwrap_or_default(),
        max: sorted.last().copied().unwrap_or_default(),
    }
}

#[cfg(test)]
#[path = "compare_tests.rs"]
mod tests;
