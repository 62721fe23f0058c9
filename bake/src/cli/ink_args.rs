//! Options of the ink style, which `render` and `bench` share.

use super::compare::Rgb;
use super::words::{Background, Switch};
use clap::ValueEnum;
use glam::Vec3;
use pelage_formats::meaning::srgb_to_linear;
use pelage_runtime::{Anchoring, FeatureRule, InkBackground, InkParams, InkShow, LineWidth, SphereMapForm, Study};
use std::str::FromStr;

/// Options of `--style ink`.
#[derive(Clone, Debug, Default, PartialEq, clap::Args)]
#[command(next_help_heading = "Ink style")]
pub struct InkArgs {
    /// T1 of Fang 2006, 0.15 to 1: where neighbouring normals' dot is lower, there is a line [default: 0.64, 50 degrees]
    #[arg(long, value_name = "T1", value_parser = |text: &str| number(text, 0.15, 1.0))]
    pub ink_threshold: Option<f32>,
    /// T1 - T2: lines between the two are thinner and paler [default: 0.15]
    #[arg(long, value_name = "D", value_parser = |text: &str| number(text, 0.0, 1.0))]
    pub ink_weak: Option<f32>,
    /// Widest line: pixels such as 7px, or metres such as 0.01m, which then is thinner with distance [default: 9px at 424 rows]
    #[arg(long, value_name = "W")]
    pub ink_width: Option<WidthArg>,
    /// Relative step of depth that is a line as well; 0 looks at normals alone [default: 0.01]
    #[arg(long, value_name = "S", value_parser = |text: &str| number(text, 0.0, 1e6))]
    pub ink_depth_step: Option<f32>,
    /// k of the lines' tone k (0.5 cos + 0.5), 0 to 1: lighter with k [default: 0.35]
    #[arg(long, value_name = "K", value_parser = |text: &str| number(text, 0.0, 1.0))]
    pub ink_tone: Option<f32>,
    /// How far weak lines are lightened, 0 to 1 [default: 0.35]
    #[arg(long, value_name = "L", value_parser = |text: &str| number(text, 0.0, 1.0))]
    pub ink_lightness: Option<f32>,
    /// How much the sphere map swells lines, 0 to 4 [default: 1.5]
    #[arg(long, value_name = "F", value_parser = |text: &str| number(text, 0.0, 4.0))]
    pub ink_swell: Option<f32>,
    /// How unevenly the hand presses, 0 to 1 [default: 1]
    #[arg(long, value_name = "P", value_parser = |text: &str| number(text, 0.0, 1.0))]
    pub ink_pressure: Option<f32>,
    /// How far lines run dry, 0 to 1 [default: 0.4]
    #[arg(long, value_name = "D", value_parser = |text: &str| number(text, 0.0, 1.0))]
    pub ink_dryness: Option<f32>,
    /// How far the paper moves the edge of lines, pixels, 0 to 8 [default: 1.2]
    #[arg(long, value_name = "PX", value_parser = |text: &str| number(text, 0.0, 8.0))]
    pub ink_roughness: Option<f32>,
    /// Colour of the ink, sRGB red,green,blue of 0..=255
    #[arg(long, value_name = "R,G,B")]
    pub ink_color: Option<Rgb>,
    /// How much of the paper's relief shows, 0 to 1 [default: 1]
    #[arg(long, value_name = "G", value_parser = |text: &str| number(text, 0.0, 1.0))]
    pub ink_paper_grain: Option<f32>,
    /// Distances in metres where mist begins and where only it is left
    #[arg(long, value_name = "FROM,TO", value_parser = range)]
    pub ink_mist: Option<[f32; 2]>,
    /// Which neighbours of a pixel must differ for a line: any, or all as printed
    #[arg(long, value_enum)]
    pub ink_rule: Option<RuleArg>,
    /// How the sphere map is looked up
    #[arg(long, value_enum)]
    pub ink_sphere_map: Option<SphereMapArg>,
    /// Lines keep to their width; without, the sphere map alone decides
    #[arg(long, value_enum, value_name = "on|off")]
    pub ink_template: Option<Switch>,
    /// Lines as the printed algorithm draws them, pixels that are ink or not
    #[arg(long, value_enum, value_name = "on|off")]
    pub ink_printed_lines: Option<Switch>,
    /// What varies is tied to the surface, or to the picture
    #[arg(long, value_enum)]
    pub ink_anchoring: Option<AnchoringArg>,
    /// What is shown: the painting, its lines or features black on white, or the wash
    #[arg(long, value_enum)]
    pub ink_show: Option<ShowArg>,
}

fn number(text: &str, least: f32, most: f32) -> Result<f32, String> {
    let number = text.trim().parse().ok().filter(|x| (least..=most).contains(x));
    number.ok_or_else(|| format!("expected a number from {least} to {most}"))
}

fn range(text: &str) -> Result<[f32; 2], String> {
    let pair = text.split_once(',').and_then(|(a, b)| Some([a.trim().parse().ok()?, b.trim().parse().ok()?]));
    pair.filter(|[from, to]: &[f32; 2]| from.is_finite() && to.is_finite() && from < to)
        .ok_or("expected two distances in metres, the second greater, such as 10,60".into())
}

/// `--ink-width`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WidthArg(pub LineWidth);

impl FromStr for WidthArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || "expected pixels such as 7px, at most 32px, or metres such as 0.01m".to_owned();
        let positive = |n: &str| n.trim().parse().ok().filter(|n: &f32| *n > 0.0 && n.is_finite());
        if let Some(px) = text.strip_suffix("px") {
            return positive(px).filter(|px| *px <= 32.0).map(|px| Self(LineWidth::Pixels(px))).ok_or_else(expected);
        }
        let metres = text.strip_suffix('m').and_then(positive);
        metres.map(|m| Self(LineWidth::Metres(m))).ok_or_else(expected)
    }
}

/// `--ink-rule`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum RuleArg {
    /// Any of the four
    Any,
    /// All four, as printed
    All,
}

/// `--ink-sphere-map`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SphereMapArg {
    /// In the frame perpendicular to the view
    Perpendicular,
    /// By reflection of the eye
    Reflection,
    /// As printed: one place for all normals
    Printed,
}

/// `--ink-anchoring`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum AnchoringArg {
    /// Strokes and wash move with the surface
    Surface,
    /// They stay where they are in the picture
    Screen,
}

/// `--ink-show`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ShowArg {
    /// All of it
    Painting,
    /// Lines, black on white
    Lines,
    /// The pixels that lines run through, black on white
    Features,
    /// The wash
    Wash,
}

/// How the ink style is drawn: its options, and what is behind.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InkView {
    /// Options; what is not given has its default for the picture's size.
    pub args: InkArgs,
    /// Transparent: nothing beside what is painted. A colour: that of the paper. `None`: the runtime's paper.
    pub background: Option<Background>,
}

impl InkView {
    /// What the runtime is told of the style.
    pub fn params(&self) -> InkParams {
        let a = &self.args;
        let linear = |rgb: [u8; 3]| Vec3::from(rgb.map(srgb_to_linear));
        InkParams::default().with(|ink| {
            ink.threshold = a.ink_threshold.unwrap_or(ink.threshold);
            ink.weak_difference = a.ink_weak.unwrap_or(ink.weak_difference);
            ink.width = a.ink_width.map_or(ink.width, |w| w.0);
            ink.depth_step = a.ink_depth_step.unwrap_or(ink.depth_step);
            ink.tone = a.ink_tone.unwrap_or(ink.tone);
            ink.weak_lightness = a.ink_lightness.unwrap_or(ink.weak_lightness);
            ink.swell = a.ink_swell.unwrap_or(ink.swell);
            ink.pressure = a.ink_pressure.unwrap_or(ink.pressure);
            ink.dryness = a.ink_dryness.unwrap_or(ink.dryness);
            ink.roughness_px = a.ink_roughness.unwrap_or(ink.roughness_px);
            ink.ink = a.ink_color.as_ref().map_or(ink.ink, |rgb| linear(rgb.0));
            ink.paper = self.background.and_then(Background::color).map_or(ink.paper, linear);
            ink.paper_grain = a.ink_paper_grain.unwrap_or(ink.paper_grain);
            ink.mist_m = a.ink_mist;
            ink.background = match self.background {
                Some(Background::Transparent) => InkBackground::Picture,
                Some(Background::Color(_)) | None => InkBackground::Paper,
            };
        })
    }

    /// Which forms of the style are studied.
    pub fn study(&self, study: &mut Study) {
        let a = &self.args;
        study.features = match a.ink_rule {
            Some(RuleArg::All) => FeatureRule::AllBelow,
            Some(RuleArg::Any) | None => FeatureRule::AnyBelow,
        };
        study.sphere_map = match a.ink_sphere_map {
            Some(SphereMapArg::Reflection) => SphereMapForm::Reflection,
            Some(SphereMapArg::Printed) => SphereMapForm::Printed,
            Some(SphereMapArg::Perpendicular) | None => SphereMapForm::Perpendicular,
        };
        study.template = a.ink_template != Some(Switch::Off);
        study.printed_lines = a.ink_printed_lines == Some(Switch::On);
        study.anchoring = match a.ink_anchoring {
            Some(AnchoringArg::Screen) => Anchoring::Screen,
            Some(AnchoringArg::Surface) | None => Anchoring::Surface,
        };
        study.show = match a.ink_show {
            Some(ShowArg::Lines) => InkShow::Lines,
            Some(ShowArg::Features) => InkShow::Features,
            Some(ShowArg::Wash) => InkShow::Wash,
            Some(ShowArg::Painting) | None => InkShow::Painting,
        };
    }
}
