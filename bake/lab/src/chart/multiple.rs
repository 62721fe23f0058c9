//! Topic `multiple`: fur whose fibres scatter light to each other, compared with path tracing. The models in [`FORMS`]
//! are compared: multiple scattering, single scattering alone or with constant ambient light, and Kajiya-Kay's lobes
//! with constant ambient light.
//!
//! Means over squares of pixels are compared, because the speckle of single hairs is not a lighting error.

use super::{Cell, Panel};
use glam::DVec3;
use pelage_formats::meaning::{luminance, srgb_to_linear};
use pelage_stage::LookScattering;

/// Fur colours: name and amount of eumelanin.
pub const COATS: [(&str, f32); 4] = [("black", 8.0), ("brown", 1.3), ("blond", 0.2), ("white", 0.0)];
/// Suns: name, and direction towards the sun. The camera is to the right of the model's front.
pub const LIGHTS: [(&str, [f32; 3]); 3] =
    [("front", [0.3, 0.5, 1.0]), ("side", [-1.0, 0.4, 0.2]), ("behind", [-0.5, 0.35, -0.9])];
/// Width and height of the pictures, pixels.
pub const SIZE: u32 = 480;
/// Width and height of the compared squares, pixels.
const BLOCK: u32 = 16;
/// Paths per pixel of the reference image.
pub const SAMPLES: u32 = 32;
/// Ambient light of the rows with constant ambient light.
pub const AMBIENT: f32 = 0.35;

/// Columns of the chart.
///
/// * `coat`: colour of the fur. `hair`: geometry as which the hair is drawn.
/// * `mean_percent`: luminance of the mostly covered squares divided by the truth's, minus 1, under all three lights
///   together; `mean_front` etc.: under one light. `rmse_percent`: RMS difference of the squares divided by their mean;
///   `rmse_front` etc.: under one light.
/// * `frame_ms`: milliseconds of a frame under the first light.
pub const COLUMNS: [&str; 11] = [
    "coat",
    "hair",
    "mean_percent",
    "mean_front",
    "mean_side",
    "mean_behind",
    "rmse_percent",
    "rmse_front",
    "rmse_side",
    "rmse_behind",
    "frame_ms",
];

/// Panels of the chart.
pub const PANELS: [Panel; 4] = [panel("black"), panel("brown"), panel("blond"), panel("white")];

const fn panel(coat: &'static str) -> Panel {
    Panel {
        cost: "frame_ms",
        cost_label: "ms per frame",
        error: "rmse_percent",
        error_label: "relative RMSE of pixel blocks, %",
        only: Some(("coat", coat)),
    }
}

/// Lighting model of the hair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightingModel {
    /// Name of the model.
    pub name: &'static str,
    /// Scattering mode.
    pub scattering: LookScattering,
    /// Whether constant ambient light is added.
    pub ambient: bool,
}

/// All lighting models; packages use the first.
pub const FORMS: [LightingModel; 4] = [
    LightingModel { name: "fibres, light of other fibres", scattering: LookScattering::Multiple, ambient: false },
    LightingModel { name: "fibres, single scattering", scattering: LookScattering::Single, ambient: false },
    LightingModel { name: "fibres, constant ambient light", scattering: LookScattering::Single, ambient: true },
    LightingModel { name: "Kajiya-Kay, constant ambient light", scattering: LookScattering::Off, ambient: true },
];

/// Parameters of one measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MultipleConfiguration {
    /// Index into [`COATS`].
    pub coat: usize,
    /// Whether hair is drawn as strands, not as layers.
    pub strands: bool,
    /// Lighting model.
    pub form: LightingModel,
}

/// Lists what to measure.
pub fn configurations() -> Vec<MultipleConfiguration> {
    let each = (0..COATS.len()).flat_map(|coat| [false, true].map(|strands| (coat, strands)));
    each.flat_map(|(coat, strands)| FORMS.map(|form| MultipleConfiguration { coat, strands, form })).collect()
}

/// Luminance of a picture's squares that hair mostly covers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Squares {
    /// Luminance of each square: in the truth, and as drawn.
    pairs: Vec<(f64, f64)>,
}

impl Squares {
    /// Compares a path-traced picture (linear, premultiplied) with a drawn one (sRGB bytes, straight alpha). Both are
    /// `width` pixels wide and row-major. Pixels beyond the last whole square are ignored.
    pub fn new(truth: &[[f32; 4]], drawn: &[u8], width: u32) -> Self {
        let (per_row, height) = (width / BLOCK, truth.len() as u32 / width);
        let mut pairs = Vec::new();
        for block in 0..per_row * (height / BLOCK) {
            let (mut sums, mut covered) = ((0.0, 0.0), 0.0);
            for pixel in 0..BLOCK * BLOCK {
                let x = block % per_row * BLOCK + pixel % BLOCK;
                let y = block / per_row * BLOCK + pixel / BLOCK;
                let at = (y * width + x) as usize;
                let [r, g, b, alpha] = truth[at].map(f64::from);
                covered += alpha;
                sums.0 += luminance(DVec3::new(r, g, b));
                let byte = |i: usize| f64::from(srgb_to_linear(drawn[4 * at + i]));
                sums.1 += luminance(DVec3::new(byte(0), byte(1), byte(2))) * f64::from(drawn[4 * at + 3]) / 255.0;
            }
            let pixels = f64::from(BLOCK * BLOCK);
            if covered > 0.5 * pixels {
                pairs.push((sums.0 / pixels, sums.1 / pixels));
            }
        }
        Self { pairs }
    }

    fn mean_true(&self) -> f64 {
        self.pairs.iter().map(|(truth, _)| truth).sum::<f64>() / self.pairs.len().max(1) as f64
    }

    /// Returns the mean luminance divided by the truth's, minus 1.
    pub fn mean(&self) -> f64 {
        let sum: f64 = self.pairs.iter().map(|(_, drawn)| drawn).sum();
        sum / self.pairs.len().max(1) as f64 / self.mean_true() - 1.0
    }

    /// Returns the root mean square difference divided by the mean of the truth.
    pub fn rmse(&self) -> f64 {
        let squares: f64 = self.pairs.iter().map(|(truth, drawn)| (drawn - truth).powi(2)).sum();
        (squares / self.pairs.len().max(1) as f64).sqrt() / self.mean_true()
    }
}

/// Returns the cells of a row, in the order of [`COLUMNS`]. `squares` has one entry for each of [`LIGHTS`].
pub fn cells(configuration: &MultipleConfiguration, squares: &[Squares; 3], frame_ms: f64) -> Vec<Cell> {
    let all = Squares { pairs: squares.iter().flat_map(|of| of.pairs.iter().copied()).collect() };
    let percent = |x: f64| Cell::Number(100.0 * x);
    let mut cells = vec![
        Cell::Text(COATS[configuration.coat].0.into()),
        Cell::Text(if configuration.strands { "strands" } else { "layers" }.into()),
        percent(all.mean()),
    ];
    cells.extend(squares.iter().map(|of| percent(of.mean())));
    cells.push(percent(all.rmse()));
    cells.extend(squares.iter().map(|of| percent(of.rmse())));
    cells.push(Cell::Number(frame_ms));
    cells
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_squares_covered_by_hair_are_compared() {
        let count = (SIZE * SIZE) as usize;
        let mut truth = vec![[0.0f32; 4]; count];
        let mut drawn = vec![0u8; 4 * count];
        // Covers the upper half of both pictures: linear value 0.2 in the truth, sRGB byte 128 as drawn.
        for at in 0..count / 2 {
            truth[at] = [0.2, 0.2, 0.2, 1.0];
            drawn[4 * at..4 * at + 4].copy_from_slice(&[128, 128, 128, 255]);
        }
        let squares = Squares::new(&truth, &drawn, SIZE);
        let expected = f64::from(srgb_to_linear(128)) / 0.2 - 1.0;
        assert_eq!(squares.pairs.len() as u32, SIZE / BLOCK * SIZE / BLOCK / 2);
        assert!((squares.mean() - expected).abs() < 1e-6 && (squares.rmse() - expected).abs() < 1e-6);
        assert_eq!(configurations().len(), 32);
    }
}
