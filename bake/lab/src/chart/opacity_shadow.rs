//! Topic `opacity-shadow`: accuracy and cost of deep and opacity shadow maps for shadows between single strands. Both
//! kinds divide the depth along the light into ranges, called slabs.
//!
//! The maps are the runtime's own, rendered by the adapter and read back. The truth is the light of the traced scene
//! ([`TrueScene::light_on_strand`]) at strand points visible to the eye, and the traced picture. The error of slabs
//! alone is measured in a homogeneous ball of hair ([`Ball`]).

use super::errors::Errors;
use super::{Cell, Panel};
use glam::Vec3;
use pelage_runtime::shared::deep_opacity::{DeepOpacity, OPACITY_STEP, slab_of, slab_share};
use pelage_runtime::{LightView, OpacityForm, ShadowParams, Study};
use pelage_truth::{TrueLight, TrueScene, VisibleStrand};
use rayon::prelude::*;

/// Number of rays from a strand point to a light.
pub const RAYS: u32 = 16;
/// Spacing of the pixels at which strand points are sampled, pixels.
pub const STEP_PX: u32 = 3;
/// Samples per pixel with which strands are drawn.
pub const SAMPLES: u32 = 4;
/// Number of planes of the opacity shadow map, as in Nguyen and Donnelly 2005.
pub const PLANES: u32 = 16;

/// Columns of the chart.
///
/// * `form`: `deep`, slabs behind the first hair of each texel; `whole`, planes over the whole depth of the hair;
///   `printed`, such planes with the published spacing. `axis`: 1 if the light is looked up on the axis of strands, 0
///   if on the side towards the eye.
/// * `slabs`, `map_size`: as requested. `texel_widths`: width of a texel divided by the mean width of strands.
/// * `rmse`, `mean_error`, `off_by_0.1`: errors of the transmittance t, at strand points that are visible to the eye
///   and that the mesh surface does not hide from the light. `places`: number of these points under three lights
///   together.
/// * `flip`, `flip_covered`, `image_rmse`: errors of the picture with four samples per pixel, under the first light,
///   compared with the reference image of `samples` rays per pixel.
/// * `largest_step`: largest step of t between the ends of neighbouring slabs, along rays of light through a
///   homogeneous ball of hair. `largest_error`: largest error of t there; see [`Ball`].
/// * `milliseconds`: time to render the map; `timing`: clock used. `bytes`: size of the map.
pub const COLUMNS: [&str; 18] = [
    "form",
    "axis",
    "slabs",
    "map_size",
    "texel_widths",
    "rmse",
    "mean_error",
    "off_by_0.1",
    "flip",
    "flip_covered",
    "image_rmse",
    "largest_step",
    "largest_error",
    "milliseconds",
    "bytes",
    "timing",
    "places",
    "samples",
];

/// Panels of the chart.
pub const PANELS: [Panel; 4] = [
    panel("milliseconds", "drawing the map, milliseconds", "rmse", "RMSE of t on strands against rays"),
    panel("milliseconds", "drawing the map, milliseconds", "flip", "mean FLIP against the reference image"),
    panel("bytes", "map, bytes", "rmse", "RMSE of t on strands against rays"),
    panel(
        "milliseconds",
        "drawing the map, milliseconds",
        "largest_step",
        "ball of hair: largest step of t between slabs",
    ),
];

const fn panel(cost: &'static str, cost_label: &'static str, error: &'static str, error_label: &'static str) -> Panel {
    Panel { cost, cost_label, error, error_label, only: None }
}

/// Map to measure.
#[derive(Clone, Debug, PartialEq)]
pub struct OpacityShadowConfiguration {
    /// Name of the varied setting.
    pub series: &'static str,
    /// Value of the varied setting, shown beside its mark in the plot.
    pub label: String,
    /// Number of slabs and map size.
    pub shadows: ShadowParams,
    /// Layout of the slabs, and position of the light lookup.
    pub study: Study,
    /// Whether this is the default configuration.
    pub default: bool,
}

/// Lists what to measure:
///
/// * the runtime's default
/// * deep maps of 4, 8 and 16 slabs, and opacity shadow maps of [`PLANES`] in safe and published form, each with sizes
///   of 256², 512² and 1024²
/// * the runtime's default with the light looked up on the axis
pub fn configurations() -> Vec<OpacityShadowConfiguration> {
    let base = ShadowParams::default();
    let sized = |slabs, map_size| base.with(|s| (s.slabs, s.map_size) = (slabs, map_size));
    // Maps have exactly the listed sizes, whatever the width of strands.
    let of = |form| Study::default().with(|s| (s.opacity, s.thin_texels) = (form, true));
    let mut out = vec![OpacityShadowConfiguration {
        series: "as the runtime does",
        label: String::new(),
        shadows: base,
        study: Study::default(),
        default: true,
    }];
    let deep = [("deep, 4 slabs", 4), ("deep, 8 slabs", 8), ("deep, 16 slabs", 16)];
    let forms = deep.map(|(series, slabs)| (series, slabs, OpacityForm::Deep)).into_iter().chain([
        ("16 planes over the whole depth", PLANES, OpacityForm::WholeDepth),
        ("16 planes, spacing as published", PLANES, OpacityForm::Printed),
    ]);
    for (series, slabs, form) in forms {
        for map_size in [256, 512, 1024] {
            let (label, shadows) = (format!("{map_size}²"), sized(slabs, map_size));
            out.push(OpacityShadowConfiguration { series, label, shadows, study: of(form), default: false });
        }
    }
    out.push(OpacityShadowConfiguration {
        series: "light on the axis",
        label: String::new(),
        shadows: base,
        study: Study::default().with(|s| s.light_on_axis = true),
        default: false,
    });
    out
}

/// Deep or opacity shadow map, read back into memory.
#[derive(Clone, Debug)]
pub struct DeepMap {
    /// View from the light from which the map was rendered.
    pub view: LightView,
    /// Encoding of the map.
    pub opacity: DeepOpacity,
    /// Layout of the map's slabs.
    pub form: OpacityForm,
    /// For each texel, the nearness of its first hair, followed by the opacities of the slabs.
    pub texels: Vec<u32>,
}

impl DeepMap {
    /// Returns the transmittance t at a point in world space. Takes the same steps in the same order as the runtime's
    /// `strand_light.wgsl`.
    pub fn light_at(&self, position_ws: Vec3) -> f32 {
        let place = self.view.map_from_world * position_ws.extend(1.0);
        let at = place.truncate().truncate() / place.w * self.opacity.size as f32 - 0.5;
        let (corner, share) = (at.floor().as_ivec2(), at - at.floor());
        let t = |dx: i32, dy: i32| self.texel(corner.x + dx, corner.y + dy, place.z);
        let row = |dy: i32| t(0, dy) + (t(1, dy) - t(0, dy)) * share.x;
        row(0) + (row(1) - row(0)) * share.y
    }

    fn texel(&self, x: i32, y: i32, depth: f32) -> f32 {
        let DeepOpacity { size, slabs, .. } = self.opacity;
        let [x, y] = [x, y].map(|at| at.clamp(0, size as i32 - 1) as usize);
        let index = y * size as usize + x;
        let first = 1.0 - f32::from_bits(self.texels[index]);
        let from = size as usize * size as usize + index * slabs as usize;
        let of_slabs: Vec<f32> =
            self.texels[from..from + slabs as usize].iter().map(|n| *n as f32 * OPACITY_STEP).collect();
        light_in_column(self.form, &self.opacity, first, &of_slabs, depth)
    }

    /// Returns the width of a texel divided by a strand width in metres. For a point light, the texel is measured at
    /// the middle of the light's range.
    pub fn texel_widths(&self, width_m: f32) -> f64 {
        let view = &self.view;
        let distance = view.near_m.map_or(1.0, |near| near + 0.5 * view.range_m);
        f64::from(self.opacity.texel_m * distance / width_m)
    }
}

/// Returns the distance from the beginning of a column of slabs to a depth, in slabs. `first` is the depth of the
/// column's first hair.
fn behind(form: OpacityForm, opacity: &DeepOpacity, first: f32, depth: f32) -> f32 {
    let begin = if form == OpacityForm::Deep { first } else { opacity.whole_from };
    (depth - begin) * opacity.slabs_per_depth
}

/// Returns the transmittance t at a depth in a column of slabs with the given optical depths.
///
/// * `first`: depth of the column's first hair
pub fn light_in_column(form: OpacityForm, opacity: &DeepOpacity, first: f32, slabs: &[f32], depth: f32) -> f32 {
    let behind = behind(form, opacity, first, depth);
    let sum: f32 = slabs.iter().zip(0..).map(|(opacity, slab)| opacity * slab_share(behind, slab)).sum();
    let past_last = (opacity.slabs as f32 + 1.0 - behind).clamp(0.0, 1.0);
    (-opacity.density * sum * if form == OpacityForm::Printed { past_last } else { 1.0 }).exp()
}

/// Returns the depth of a column's first hair, and the optical depths of its slabs. `hair` lists depth and coverage of
/// each hair, in any order.
pub fn column(
    form: OpacityForm,
    opacity: &DeepOpacity,
    hair: impl Iterator<Item = (f32, f32)> + Clone,
) -> (f32, Vec<f32>) {
    let first = hair.clone().map(|(depth, _)| depth).fold(1.0, f32::min);
    let mut slabs = vec![0.0; opacity.slabs as usize];
    for (depth, covered) in hair {
        let behind = behind(form, opacity, first, depth);
        if form != OpacityForm::Printed || behind < opacity.slabs as f32 {
            slabs[slab_of(behind, opacity.slabs) as usize] += covered;
        }
    }
    (first, slabs)
}

/// Returns the slab parameters of a map with the given settings. The scene is `depth_m` metres deep along the light,
/// and the fur is `fur_m` metres high.
pub fn columns_of(form: OpacityForm, shadows: &ShadowParams, depth_m: f32, fur_m: f32) -> DeepOpacity {
    let between = shadows.slabs.saturating_sub(1).max(1);
    let (slabs, slabs_per_depth) = match form {
        OpacityForm::Deep => (shadows.slabs, shadows.slabs as f32 * depth_m / (2.0 * fur_m)),
        OpacityForm::WholeDepth => (between, between as f32),
        OpacityForm::Printed => (between, (between + 1) as f32),
    };
    DeepOpacity { slabs, slabs_per_depth, density: 1.0, ..DeepOpacity::default() }
}

/// Homogeneous ball of hair, whose diameter is the depth of the scene along the light. At half the fur's height below
/// the ball's surface, 1/e of the light is left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// Diameter, metres.
    pub depth_m: f32,
    /// Height of the fur, metres.
    pub fur_m: f32,
}

/// Number of pieces of hair along a ray through the ball, so large that each slab has many.
const PIECES: u32 = 4096;

impl Ball {
    /// Returns the largest step of t between the ends of neighbouring slabs, and the largest error of t. The measured
    /// rays pass the ball's centre at distances from 0 to nearly its radius.
    pub fn measure(&self, form: OpacityForm, shadows: &ShadowParams) -> (f64, f64) {
        let opacity = columns_of(form, shadows, self.depth_m, self.fur_m);
        let per_depth = 2.0 * self.depth_m / self.fur_m;
        let (mut step, mut error) = (0.0f64, 0.0f64);
        for ray in 0..16 {
            // Half of the ray's length inside the ball, whose diameter is 1 in map depth.
            let half = 0.5 * (1.0 - (ray as f32 / 16.0).powi(2)).sqrt();
            let piece = 2.0 * half / PIECES as f32;
            let depth = |k: f32| 0.5 - half + piece * k;
            let hair = (0..PIECES).map(|k| (depth(k as f32 + 0.5), piece * per_depth));
            let (first, slabs) = column(form, &opacity, hair);
            let light = |depth: f32| f64::from(light_in_column(form, &opacity, first, &slabs, depth));
            let truth = |depth: f32| f64::from((-(depth - 0.5 + half) * per_depth).exp());
            for k in 0..PIECES {
                error = error.max((light(depth(k as f32)) - truth(depth(k as f32))).abs());
            }
            let begin = if form == OpacityForm::Deep { first } else { 0.0 };
            let ends = (0..=opacity.slabs + 1).map(|k| begin + k as f32 / opacity.slabs_per_depth);
            let inside: Vec<f64> = ends.filter(|at| (0.5 - half..=0.5 + half).contains(at)).map(light).collect();
            step = inside.windows(2).map(|ends| (ends[1] - ends[0]).abs()).fold(step, f64::max);
        }
        (step, error)
    }
}

/// True light at strand points.
#[derive(Clone, Debug, Default)]
pub struct StrandLightTruth(Vec<(VisibleStrand, f64)>);

impl StrandLightTruth {
    /// Computes the truth at those points that the mesh surface does not hide from the light.
    pub fn new(scene: &TrueScene, places: &[VisibleStrand], light: &TrueLight) -> Self {
        let lit = |at: &VisibleStrand| Some((*at, scene.light_on_strand(at, light, RAYS)?));
        Self(places.par_iter().filter_map(lit).collect())
    }

    /// Returns the number of points.
    pub fn point_count(&self) -> usize {
        self.0.len()
    }

    /// Returns the errors of a map. If `on_axis`, light is looked up on the axis of strands.
    pub fn errors(&self, map: &DeepMap, on_axis: bool) -> Errors {
        let found = |(at, truth): &(VisibleStrand, f64)| {
            let aside = if on_axis { 0.0 } else { at.radius_m };
            (f64::from(map.light_at((at.axis_ws + at.to_eye * aside).as_vec3())), *truth)
        };
        Errors::of(self.0.par_iter().map(found).collect::<Vec<_>>())
    }
}

/// Results of a configuration.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OpacityShadowMeasures {
    /// Errors of the transmittance t.
    pub errors: Errors,
    /// Number of points at which t was compared, under all lights.
    pub places: usize,
    /// Mean FLIP of the picture.
    pub flip: f64,
    /// Mean FLIP of the pixels that either picture covers.
    pub flip_covered: f64,
    /// RMSE of premultiplied linear colour.
    pub image_rmse: f64,
    /// Largest step and largest error of t in the ball.
    pub ball: (f64, f64),
    /// Result of [`DeepMap::texel_widths`].
    pub texel_widths: f64,
    /// Milliseconds to draw the map.
    pub milliseconds: f64,
    /// Bytes of the map.
    pub bytes: u64,
    /// Rays per pixel of the reference image.
    pub samples: u32,
}

/// Returns the cells of a row, in the order of [`COLUMNS`]. `timing` is the source of the milliseconds.
pub fn cells(configuration: &OpacityShadowConfiguration, m: &OpacityShadowMeasures, timing: &str) -> Vec<Cell> {
    let number = |x: Option<f64>| x.map_or(Cell::Empty, Cell::Number);
    let study = &configuration.study;
    let form = match study.opacity {
        OpacityForm::Deep => "deep",
        OpacityForm::WholeDepth => "whole",
        OpacityForm::Printed => "printed",
    };
    vec![
        Cell::Text(form.into()),
        Cell::Number(f64::from(u8::from(study.light_on_axis))),
        Cell::Number(configuration.shadows.slabs.into()),
        Cell::Number(configuration.shadows.map_size.into()),
        Cell::Number(m.texel_widths),
        number(m.errors.rmse()),
        number(m.errors.mean()),
        number(m.errors.large_error_fraction()),
        Cell::Number(m.flip),
        Cell::Number(m.flip_covered),
        Cell::Number(m.image_rmse),
        Cell::Number(m.ball.0),
        Cell::Number(m.ball.1),
        Cell::Number(m.milliseconds),
        Cell::Number(m.bytes as f64),
        Cell::Text(timing.into()),
        Cell::Number(m.places as f64),
        Cell::Number(m.samples.into()),
    ]
}

#[cfg(test)]
#[path = "opacity_shadow_tests.rs"]
mod tests;
