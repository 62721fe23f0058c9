//! Parameters of the ink-wash style: brush strokes, or lines found in pixels (Fang 2006).

use super::brush::BrushParams;
use super::seal::Seal;
use crate::error::RuntimeError;
use glam::Vec3;
use pelage_formats::InkShading;

/// Parameters of a frame in [`crate::Style::Ink`]. Greys range from 0 for black to 1 for white, in display encoding.
///
/// [`InkLines::Strokes`] ignores `threshold`, `weak_difference`, `depth_step`, `step_px`, `width`, `fins`, `swell`,
/// `tone`, `weak_lightness`, `dryness`, `roughness_px` and `shading`. [`InkLines::Pixels`] ignores `brush`.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct InkParams {
    /// Form of the lines and washes (default [`InkLines::Strokes`]).
    pub lines: InkLines,
    /// Parameters of [`InkLines::Strokes`].
    pub brush: BrushParams,
    /// Threshold T1 of Fang 2006, §2, 0.15..=1 (default 0.64, the cosine of 50°). A line is drawn where the dot product
    /// of neighbouring normals is below T1. Higher values draw more lines.
    pub threshold: f32,
    /// Difference T1 − T2, 0..=1 (default 0.15). Lines between the two thresholds are weak: thinner and paler.
    pub weak_difference: f32,
    /// Relative depth step between neighbouring pixels that also makes a line, at least 0 (default 0.01). Lines are
    /// weak for steps up to four times that value. With 0, only normals make lines, as published.
    pub depth_step: f32,
    /// Distance between the pixels whose normals are compared, pixels, 1..=8 (default 1).
    pub step_px: u32,
    /// Width of the widest line (default [`LineWidth::Auto`]).
    pub width: LineWidth,
    /// Whether fur strokes are drawn on fins, if the package has them (default true).
    pub fins: bool,
    /// Factor on the width of the sphere map's rim, 0..=4 (default 1.5).
    pub swell: f32,
    /// Lightness of lines, 0..=1 (default 0.35): factor k of D = k (0.5 cos + 0.5).
    pub tone: f32,
    /// Lightness that is added to weak lines, levelColor, 0..=1 (default 0.35).
    pub weak_lightness: f32,
    /// Variation of the brush pressure, 0..=1 (default 1).
    pub pressure: f32,
    /// Dryness of lines, 0..=1 (default 0.4).
    pub dryness: f32,
    /// Displacement of line edges by the paper's relief, pixels, 0..=8 (default 1.2).
    pub roughness_px: f32,
    /// Colour of the ink, linear RGB, 0..=1 each.
    pub ink: Vec3,
    /// Colour of the paper, linear RGB, 0..=1 each.
    pub paper: Vec3,
    /// Visibility of the paper's relief and flecks, 0..=1 (default 1).
    pub paper_grain: f32,
    /// Period of the paper tile, pixels, 1..=65536 (default 768).
    pub paper_period_px: f32,
    /// Background around the painting (default [`InkBackground::Paper`]).
    pub background: InkBackground,
    /// Distances at which mist begins and beyond which only mist is visible, metres along the view direction,
    /// ascending. `None` (default) for clear air.
    pub mist_m: Option<[f32; 2]>,
    /// Constants of the models' wash, fur and lines that replace those of their packages (default `None`).
    pub shading: Option<InkShading>,
    /// Seal on the painting (default `None`).
    pub seal: Option<Seal>,
}

/// Form of the lines and washes of an ink painting.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum InkLines {
    /// Lines found in the pixels of the picture, and a wash of even tone (Fang 2006).
    Pixels,
    /// Brush strokes, attached to the surface. Frames fall back to [`Self::Pixels`] if a package has neither strokes
    /// nor a contour mesh, or if the device has no storage buffers in vertex shaders.
    #[default]
    Strokes,
}

/// Width of the widest line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LineWidth {
    /// Default width for the picture's height, [`InkParams::default_width_px`].
    Auto,
    /// Width in pixels, above 0 and at most 32, independent of distance.
    Pixels(f32),
    /// Width in metres, above 0. Lines get thinner with distance, and are at most 32 pixels wide.
    Metres(f32),
}

/// Background around the painting.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum InkBackground {
    /// Paper over the whole target, except where geometry nearer than the far plane was drawn before.
    #[default]
    Paper,
    /// Picture that the application drew before.
    Picture,
}

/// Maximum line width that the passes can draw, pixels.
const WIDEST_PX: f32 = 32.0;

impl Default for InkParams {
    fn default() -> Self {
        Self {
            lines: InkLines::default(),
            brush: BrushParams::default(),
            threshold: 0.64,
            weak_difference: 0.15,
            depth_step: 0.01,
            step_px: 1,
            width: LineWidth::Auto,
            fins: true,
            swell: 1.5,
            tone: 0.35,
            weak_lightness: 0.35,
            pressure: 1.0,
            dryness: 0.4,
            roughness_px: 1.2,
            ink: Vec3::new(0.008, 0.0085, 0.010),
            paper: Vec3::new(0.896, 0.863, 0.784),
            paper_grain: 1.0,
            paper_period_px: 768.0,
            background: InkBackground::Paper,
            mist_m: None,
            shading: None,
            seal: None,
        }
    }
}

impl InkParams {
    /// Returns the parameters with changes: `InkParams::default().with(|i| i.background = InkBackground::Picture)`.
    pub fn with(mut self, change: impl FnOnce(&mut Self)) -> Self {
        change(&mut self);
        self
    }

    /// Returns the default line width, pixels: 9 in a picture of 424 rows, and in proportion for other heights.
    /// Pictures in Fang 2006 have 424 rows, and their three dilations give lines 7 or 8 pixels wide.
    pub fn default_width_px(height: u32) -> f32 {
        (9.0 * height as f32 / PRINTED_HEIGHT).clamp(1.5, WIDEST_PX)
    }

    pub(crate) fn check(&self) -> Result<(), RuntimeError> {
        let fail = |field, found: String, expected: &str| {
            Err(RuntimeError::Params { field, found, expected: expected.into() })
        };
        // NaN is in no range.
        for (field, value, range) in [
            ("InkParams::threshold", self.threshold, 0.15..=1.0),
            ("InkParams::weak_difference", self.weak_difference, 0.0..=1.0),
            ("InkParams::swell", self.swell, 0.0..=4.0),
            ("InkParams::tone", self.tone, 0.0..=1.0),
            ("InkParams::weak_lightness", self.weak_lightness, 0.0..=1.0),
            ("InkParams::pressure", self.pressure, 0.0..=1.0),
            ("InkParams::dryness", self.dryness, 0.0..=1.0),
            ("InkParams::roughness_px", self.roughness_px, 0.0..=8.0),
            ("InkParams::paper_grain", self.paper_grain, 0.0..=1.0),
            ("InkParams::depth_step", self.depth_step, 0.0..=f32::MAX),
            ("InkParams::paper_period_px", self.paper_period_px, 1.0..=65536.0),
            ("InkParams::step_px", self.step_px as f32, 1.0..=8.0),
        ] {
            if !range.contains(&value) {
                return fail(field, value.to_string(), &format!("{}..={}", range.start(), range.end()));
            }
        }
        self.brush.check()?;
        self.seal.as_ref().map_or(Ok(()), Seal::check)?;
        match self.width {
            LineWidth::Pixels(px) if !(px > 0.0 && px <= WIDEST_PX) => {
                return fail("InkParams::width", format!("{px} pixels"), "above 0 and at most 32 pixels");
            }
            LineWidth::Metres(m) if !(m > 0.0 && m.is_finite()) => {
                return fail("InkParams::width", format!("{m} metres"), "a finite number above 0");
            }
            _ => {}
        }
        for (field, color) in [("InkParams::ink", self.ink), ("InkParams::paper", self.paper)] {
            if !color.to_array().iter().all(|c| (0.0..=1.0).contains(c)) {
                return fail(field, color.to_string(), "0..=1 each");
            }
        }
        if let Some(shading) = &self.shading {
            shading.check().or_else(|reason| fail("InkParams::shading", reason, "every number in its range"))?;
        }
        if let Some([from, to]) = self.mist_m
            && !(from.is_finite() && to.is_finite() && from < to)
        {
            return fail("InkParams::mist_m", format!("{from} to {to}"), "two finite numbers, the second greater");
        }
        Ok(())
    }

    /// Returns half the maximum line width in a picture of `height` pixels, as two parts that add up: pixels and
    /// metres.
    pub(crate) fn half_width(&self, height: u32) -> [f32; 2] {
        match self.width {
            LineWidth::Auto => [0.5 * Self::default_width_px(height), 0.0],
            LineWidth::Pixels(px) => [0.5 * px, 0.0],
            LineWidth::Metres(m) => [0.0, 0.5 * m],
        }
    }

    /// Returns the greatest distance of a line from its feature in a picture of `height` pixels, in whole pixels.
    pub(crate) fn reach_px(&self, height: u32) -> u32 {
        let [px, metres] = self.half_width(height);
        // The size of a metre in pixels is unknown here, so the maximum width is assumed.
        let half = if metres > 0.0 { WIDEST_PX } else { px };
        half.min(0.5 * WIDEST_PX).ceil() as u32 + 1
    }
}

/// Height in pixels of the pictures in Fang 2006.
const PRINTED_HEIGHT: f32 = 424.0;
