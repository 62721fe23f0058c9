//! The ink-wash style (Fang 2006): what a frame can say about it, and the textures that its passes hand on.

use crate::RuntimeError;
use crate::light_view::Hull;
use glam::{Mat4, Vec2, Vec3};
use pelage_formats::InkShading;

/// How a frame in [`crate::Style::Ink`] is painted. Greys are 0 for black and 1 for white, as a display shows them.
#[derive(Clone, Debug, PartialEq)]
pub struct InkParams {
    /// Width and height of the target that the frame is drawn to, pixels, at least 1 each.
    pub target_px: [u32; 2],
    /// T1 of Fang 2006, §2, 0.15..=1 (default 0.64, the cosine of 50°): where the dot of the normals of neighbouring pixels is lower, there is a line. Higher
    /// draws more lines.
    pub threshold: f32,
    /// T1 − T2, 0..=1 (default 0.15): lines between the two thresholds are weak, thinner and paler.
    pub weak_difference: f32,
    /// Which of the four neighbours must differ (default [`FeatureRule::AnyBelow`]).
    pub features: FeatureRule,
    /// Relative step of depth between neighbours that is a line as well, at least 0 (default 0.01), weak up to four times as much; 0 looks at normals
    /// alone, as printed.
    pub depth_step: f32,
    /// Distance of the neighbours that are compared, pixels, 1..=8 (default 1).
    pub step_px: u32,
    /// Width of the widest line (default [`InkParams::default_width_px`]).
    pub width: LineWidth,
    /// Whether lines keep to their width (default true). Without it the sphere map alone decides, which blackens what is seen edge on.
    pub template: bool,
    /// How the sphere map is looked up (default [`SphereMapForm::Perpendicular`]).
    pub sphere_map: SphereMapForm,
    /// Factor on the breadth of the sphere map's rim, 0..=4 (default 1.5).
    pub swell: f32,
    /// Whether lines are the pixels that the printed algorithm draws, ink or not, with squares for the dilation (default false).
    pub printed_lines: bool,
    /// k of D = k (0.5 cos + 0.5), 0..=1 (default 0.35): lightness of lines.
    pub tone: f32,
    /// levelColor, 0..=1 (default 0.35): what weak lines are lifted by.
    pub weak_lightness: f32,
    /// How unevenly the hand presses, 0..=1 (default 1).
    pub pressure: f32,
    /// How far lines run dry, 0..=1 (default 0.4).
    pub dryness: f32,
    /// How far the relief of the paper moves the edge of lines, pixels, 0..=8 (default 1.2).
    pub roughness_px: f32,
    /// What varies along lines and in the wash is tied to this (default [`Anchoring::Surface`]).
    pub anchoring: Anchoring,
    /// Colour of the ink, linear RGB, 0..=1 each.
    pub ink: Vec3,
    /// Colour of the paper, linear RGB, 0..=1 each.
    pub paper: Vec3,
    /// How much of the paper's relief and flecks shows, 0..=1 (default 1).
    pub paper_grain: f32,
    /// Period of the paper's tile, pixels, above 0 (default 768).
    pub paper_period_px: f32,
    /// What is there beside what is painted (default [`InkBackground::Paper`]).
    pub background: InkBackground,
    /// Distances where mist begins and where only it is left, metres along the view, rising; `None` (default) for clear air.
    pub mist_m: Option<[f32; 2]>,
    /// Constants of the models' wash, fur and lines instead of their packages' own (default `None`).
    pub shading: Option<InkShading>,
    /// What is shown (default [`InkShow::Painting`]).
    pub show: InkShow,
}

/// Which neighbours of a pixel must differ in their normal for a line to run through it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum FeatureRule {
    /// Any of the four.
    #[default]
    AnyBelow,
    /// All four, as Fang 2006 is printed: a straight edge always has two neighbours on its own side, so that hardly a line is found.
    AllBelow,
}

/// Width of the widest line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LineWidth {
    /// Pixels, above 0 and at most 32: the same at any distance.
    Pixels(f32),
    /// Metres, above 0: thinner with distance, and at most 32 pixels.
    Metres(f32),
}

/// How a normal finds its place in the stroke's texture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum SphereMapForm {
    /// In the frame perpendicular to the view: the outline is the rim of the disc whatever the perspective.
    #[default]
    Perpendicular,
    /// By reflection, R = 2 (N·E) N − E: what the printed equations mean, right at the middle of the picture alone.
    Reflection,
    /// As printed, R = (N·E)² E − E: one place for all normals.
    Printed,
}

/// What varies is tied to the surface or to the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Anchoring {
    /// To the surface: strokes and wash move with the character.
    #[default]
    Surface,
    /// To the picture, through which the character then seems to swim: for measuring what the other saves.
    Screen,
}

/// What is there beside what is painted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum InkBackground {
    /// Paper over the whole target, except where something nearer than the far plane was drawn before.
    #[default]
    Paper,
    /// What the application drew before.
    Picture,
}

/// What an ink frame shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum InkShow {
    /// The painting.
    #[default]
    Painting,
    /// Its lines, black on white.
    Lines,
    /// The pixels that lines run through, black on white.
    Features,
    /// The wash alone.
    Wash,
}

/// Widest line that the passes can draw, pixels.
const WIDEST_PX: f32 = 32.0;

impl InkParams {
    /// Everything at its default for a target of `width` by `height` pixels.
    pub fn new(width: u32, height: u32) -> Self {
        Self {
            target_px: [width, height],
            threshold: 0.64,
            weak_difference: 0.15,
            features: FeatureRule::AnyBelow,
            depth_step: 0.01,
            step_px: 1,
            width: LineWidth::Pixels(Self::default_width_px(height)),
            template: true,
            sphere_map: SphereMapForm::Perpendicular,
            swell: 1.5,
            printed_lines: false,
            tone: 0.35,
            weak_lightness: 0.35,
            pressure: 1.0,
            dryness: 0.4,
            roughness_px: 1.2,
            anchoring: Anchoring::Surface,
            ink: Vec3::new(0.008, 0.0085, 0.010),
            paper: Vec3::new(0.896, 0.863, 0.784),
            paper_grain: 1.0,
            paper_period_px: 768.0,
            background: InkBackground::Paper,
            mist_m: None,
            shading: None,
            show: InkShow::Painting,
        }
    }

    /// Nine pixels in a picture of 424 rows, the size in Fang 2006, whose three dilations come to seven or eight; in proportion in others.
    pub fn default_width_px(height: u32) -> f32 {
        (9.0 * height as f32 / PRINTED_HEIGHT).clamp(1.5, WIDEST_PX)
    }

    /// Bytes on the GPU of the textures that the passes of a frame hand on; the renderer keeps them for the next of the same size.
    pub fn gpu_bytes(&self) -> u64 {
        crate::passes::ink::bytes_of(self.target_px)
    }

    pub(crate) fn check(&self, limits: &wgpu::Limits) -> Result<(), RuntimeError> {
        let fail = |field, found: String, expected: &str| {
            Err(RuntimeError::Params { field, found, expected: expected.into() })
        };
        let [width, height] = self.target_px;
        let most = limits.max_texture_dimension_2d;
        if !(1..=most).contains(&width) || !(1..=most).contains(&height) {
            let expected = format!("1..={most} pixels a side");
            return fail("InkParams::target_px", format!("{width}x{height}"), &expected);
        }
        // Not a number is in no range.
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

    /// Farthest that a line reaches from its feature, whole pixels.
    pub(crate) fn reach_px(&self) -> u32 {
        let half = match self.width {
            LineWidth::Pixels(px) => 0.5 * px,
            LineWidth::Metres(_) => 0.5 * WIDEST_PX,
        };
        half.min(0.5 * WIDEST_PX).ceil() as u32 + 1
    }
}

/// The part of the target that a frame's lines can reach: left, top, width and height, pixels. Passes over the picture leave out the rest.
pub(crate) fn painted_rect(hull: &Hull, clip_from_world: Mat4, params: &InkParams) -> [u32; 4] {
    let size = Vec2::from(params.target_px.map(|n| n as f32));
    let (mut least, mut most) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
    for (point, _) in &hull.0 {
        let clip = clip_from_world * point.extend(1.0);
        // Beside or behind the eye there is no place in the picture.
        if clip.w <= 1e-6 {
            return [0, 0, params.target_px[0], params.target_px[1]];
        }
        let place = (Vec2::new(clip.x, -clip.y) / clip.w * 0.5 + 0.5) * size;
        (least, most) = (least.min(place), most.max(place));
    }
    // Lines reach beyond their features, and those are found beside what is drawn.
    let margin = (params.reach_px() + params.step_px + 1) as f32;
    let clamped = |v: Vec2| v.clamp(Vec2::ZERO, size);
    let (least, most) = (clamped((least - margin).floor()), clamped((most + margin).ceil()));
    let extent = (most - least).max(Vec2::ZERO);
    [least.x, least.y, extent.x, extent.y].map(|n| if n.is_finite() { n as u32 } else { 0 })
}

/// Rows of the pictures in Fang 2006.
const PRINTED_HEIGHT: f32 = 424.0;
