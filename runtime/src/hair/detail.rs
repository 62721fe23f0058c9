//! Levels of detail: how much of a model's fur is drawn when it is small on screen.
//!
//! A package stores the chain of levels (`FORMAT.md`, "Levels of detail"). Each level has fewer layers, and each layer
//! represents more of the baked ones; the last level is the mesh surface with the far fur layer. Only one level is
//! drawn at a time: between two levels, layers disappear one after another and transfer their opacity to those that
//! remain.

use super::strand_lod::{drawn_share, effective_samples, point_step, strand_transition, transition_shares};
use crate::bounds::Hull;
use crate::gpu::largest_buffer;
use crate::instance::Instance;
use crate::model::{Model, StrandSet};
use crate::params::{Detail, FrameParams, FurParams, HairGeometry, Style};
use crate::report::InstanceDetail;
use crate::shared::detail::{detail_count, detail_exponent, detail_layer, detail_pairs};
use glam::Mat4;
use pelage_formats::meaning::{detail_position, simplest_list};
use pelage_formats::{FurInfo, Manifest};
use std::ops::Range;

/// Sum of the mean opacities of the outermost layers that levels of detail leave out. It is one step of an 8-bit texel.
const LEAST_OPACITY: f32 = 1.0 / 255.0;

/// Drawing state of an instance in a frame, for pipelines and shaders.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct InstanceDrawing {
    pub(crate) detail: InstanceDetail,
    /// Layer count used by the shaders, skin included; 1 if no fur is visible.
    pub(crate) layers: u32,
    /// Stride between the layers that are drawn.
    pub(crate) step: u32,
    /// Number of layers that have already changed to the next level, as in
    /// [`detail_fade`](crate::shared::detail::detail_fade).
    pub(crate) gone: f32,
    /// Density of the current and of the next level. If the next level is the far fur layer: remaining density of the
    /// current level, and share of the far layer.
    pub(crate) weights: [f32; 2],
    /// Mip level, a whole number, at which hair texels are as large as pixels at the nearest point of the model. Used
    /// where only one mip level is sampled.
    pub(crate) texel_level: f32,
    /// Index list to draw: 0 for the mesh's own, otherwise one of the simplified ones.
    pub(crate) list: usize,
    /// Share of the layers' opacity that remains while single strands are also drawn.
    pub(crate) layer_share: f32,
    /// Stride between the points of single strands that are drawn.
    pub(crate) point_step: u32,
    /// Maximum number of segments per strand, if a study sets it.
    most_pieces: Option<u32>,
    /// Pixels per metre of the instance on screen, times the application's bias.
    px_per_m: f32,
    /// Layer count for the shadow maps, skin included. It is constant within a level of detail; 1 if no layers are
    /// drawn.
    pub(crate) map_layers: u32,
}

/// Drawing state of one of the model's strand sets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct StrandSetDrawing {
    /// Index of the model's strand set.
    pub(crate) set: usize,
    /// Share of the strands that are drawn.
    pub(crate) share: f32,
    /// Factor on the natural width of the strands.
    pub(crate) widened: f32,
    /// Stride between the points that are drawn.
    pub(crate) step: u32,
}

impl StrandSetDrawing {
    /// Returns the set with all points of all strands, at their natural width.
    pub(crate) fn full_detail(&self) -> Self {
        Self { share: 1.0, widened: 1.0, step: 1, ..*self }
    }
}

impl InstanceDrawing {
    /// Returns the state in which an instance is drawn. `hull`: bounds of the posed instance in world space; `samples`:
    /// number of samples per pixel.
    pub(crate) fn for_instance(
        instance: &Instance,
        hull: &Hull,
        params: &FrameParams,
        samples: u32,
        clip_from_view: Mat4,
    ) -> Self {
        let clip_from_world = clip_from_view * params.camera.view_from_world;
        let px_per_m = instance.scale() * hull.px_per_m(clip_from_view, clip_from_world, params.viewport[1]);
        let detail = params.style.fur().map_or(1.0, |fur| detail_bias(fur.detail));
        let most_pieces = crate::study::strand_pieces(params);
        let drawing =
            Self { px_per_m: px_per_m * detail, most_pieces, ..Self::from_layers(instance, px_per_m, params) };
        let Some(fur) = params.style.fur().filter(|_| params.debug.only_layer.is_none()) else {
            return drawing;
        };
        let Some(strands) = instance.model.fur_strands().filter(|_| drawing.has_shells()) else { return drawing };
        let way = match fur.hair {
            HairGeometry::Shells => 0.0,
            HairGeometry::Strands => 1.0,
            // Layers that the caller requests explicitly must be visible.
            HairGeometry::Auto if fur.layers.is_some() || matches!(fur.detail, Detail::Level(_)) => 0.0,
            HairGeometry::Auto => {
                strand_transition(fur, px_per_m * strands.mean_width_m * detail_bias(fur.detail), samples)
            }
        };
        Self {
            point_step: point_step(strands, px_per_m, effective_samples(fur, samples), most_pieces),
            ..drawing.with_strands(way)
        }
    }

    /// Applies the [transition](strand_transition) from layers to single strands, whose progress is `way`, 0..=1. The
    /// far fur layer is drawn in addition to both.
    fn with_strands(mut self, way: f32) -> Self {
        let [strands, layers] = transition_shares(way);
        self.detail.strands = strands * (1.0 - self.detail.coat);
        self.layer_share = layers;
        self.detail.fins *= self.layer_share;
        self
    }

    /// Returns the state adapted to the device limits: strands with fewer points if the buffers cannot hold all.
    pub(crate) fn clamped_to(self, limits: &wgpu::Limits, model: &Model) -> Self {
        let Some(strands) = model.fur_strands().filter(|_| self.has_strands()) else { return self };
        let fits = |step: &u32| *step >= self.point_step && strands.ribbon_bytes(*step) <= largest_buffer(limits);
        let point_step = strands.steps().find(fits).unwrap_or(strands.points - 1);
        let detail = InstanceDetail { strand_pieces: strands.segments(point_step), ..self.detail };
        Self { point_step, detail, ..self }
    }

    /// Returns the strand sets of the model that are drawn, within the device limits. `samples`: number of samples per
    /// pixel.
    ///
    /// Hair groups are drawn as strands at any size. If strands are too thin for that number of samples, fewer and
    /// wider ones are drawn.
    pub(crate) fn sets(
        &self,
        model: &Model,
        style: &Style,
        samples: u32,
        limits: &wgpu::Limits,
    ) -> Vec<StrandSetDrawing> {
        let Some(fur) = style.fur() else { return Vec::new() };
        let found = effective_samples(fur, samples);
        let of = |(set, strands): (usize, &StrandSet)| {
            let guided = strands.guided().is_some();
            let fewer = drawn_share(fur, guided, self.px_per_m * strands.mean_width_m, samples);
            let widened = fewer.recip();
            if !guided {
                let (share, step) = (fewer * self.detail.strands, self.point_step);
                return self.has_strands().then_some(StrandSetDrawing { set, share, widened, step });
            }
            let fits = |step: &u32| strands.ribbon_bytes(*step) <= largest_buffer(limits);
            let wanted = point_step(strands, self.px_per_m, found, self.most_pieces);
            let step = strands.steps().find(|step| *step >= wanted && fits(step)).unwrap_or(strands.points - 1);
            Some(StrandSetDrawing { set, share: fewer, widened, step })
        };
        model.strands().iter().enumerate().filter_map(of).collect()
    }

    fn from_layers(instance: &Instance, px_per_m: f32, params: &FrameParams) -> Self {
        let manifest = instance.model.manifest();
        let high_px = if px_per_m.is_finite() { manifest.fur.height_m * px_per_m } else { f32::INFINITY };
        let level_of = |px| texel_level(&manifest.fur, px);
        let texel_level = level_of(high_px);
        let fur = params.style.fur().filter(|_| params.debug.only_layer.is_none());
        let Some(FurParams { layers: None, detail, .. }) = fur.filter(|_| !manifest.detail.is_empty()) else {
            return Self { texel_level, ..Self::at_level(manifest, params, 0, 0.0) }.with_list(&instance.model, 0);
        };
        let fur_px = matches!(detail, Detail::Auto { .. }).then_some(high_px);
        let (level, fade) = match *detail {
            Detail::Full => (0, 0.0),
            Detail::Auto { bias } => detail_position(&manifest.detail, fur_px.map_or(f32::INFINITY, |px| px * bias)),
            Detail::Level(level) => {
                let last = manifest.detail.len() - 1;
                let whole = (level as usize).min(last);
                (whole, if whole == last { 0.0 } else { level.fract() })
            }
        };
        let mut drawing = Self::at_level(manifest, params, level, fade);
        drawing.detail.fur_px = fur_px;
        drawing.texel_level = texel_level;
        let Detail::Auto { bias } = detail else { return drawing.with_list(&instance.model, 0) };
        let list = simplest_list(instance.model.deviations_m(), px_per_m * bias);
        // Where a texel is as large as a pixel, the tips of single hairs are visible.
        if level_of(high_px * bias) > 0.0 {
            drawing = drawing.without_empty_layers(instance.model.layer_opacities());
        }
        drawing.with_list(&instance.model, list)
    }

    /// Leaves out the outermost layers that together have at most an opacity of [`LEAST_OPACITY`]. `opacities`: mean
    /// opacity of each layer of the model, as it is baked.
    ///
    /// The outermost layers contain only the tips of the longest hairs, and cost as much as any others.
    fn without_empty_layers(self, opacities: &[f32]) -> Self {
        let (baked, [here, next]) = (self.layers, self.weights);
        let opacity_of = |index: u32| {
            let layer = detail_layer(index, baked, self.step, self.gone);
            let times = detail_exponent(layer, baked, self.step, self.gone, here, next);
            opacities.get(layer as usize).map_or(1.0, |opacity| times * opacity)
        };
        let mut layers = self.detail.layers;
        let mut left = LEAST_OPACITY;
        while layers > 1 {
            left -= opacity_of(layers - 1);
            if left < 0.0 {
                break;
            }
            layers -= 1;
        }
        Self { detail: InstanceDetail { layers, ..self.detail }, ..self }
    }

    fn with_list(mut self, model: &Model, list: usize) -> Self {
        (self.list, self.detail.triangles) = (list, model.triangles(list));
        self
    }

    fn at_level(manifest: &Manifest, params: &FrameParams, level: usize, fade: f32) -> Self {
        let baked = manifest.fur.layers;
        let fur = params.style.fur().filter(|_| baked > 1);
        let layers = fur.map_or(1, |fur| fur.layers.unwrap_or(baked));
        let of_layers = baked.saturating_sub(1);
        let plain = Self {
            detail: InstanceDetail {
                in_picture: true,
                level: 0,
                fade: 0.0,
                layers: layers - 1,
                of_layers,
                triangles: 0,
                fins: if layers > 1 { 1.0 } else { 0.0 },
                coat: 0.0,
                strands: 0.0,
                strand_pieces: 0,
                fur_px: None,
            },
            layers,
            step: 1,
            gone: 0.0,
            weights: [1.0, 0.0],
            texel_level: 0.0,
            list: 0,
            layer_share: 1.0,
            point_step: 1,
            most_pieces: None,
            px_per_m: f32::INFINITY,
            map_layers: layers,
        };
        let Some(this) = manifest.detail.get(level).filter(|_| fur.is_some_and(|f| f.layers.is_none())) else {
            return plain;
        };
        let next = manifest.detail.get(level + 1);
        let fade = if next.is_some() { fade } else { 0.0 };
        if level == 0 && fade == 0.0 {
            return plain;
        }
        let next = next.unwrap_or(this);
        let coat = match (this.step, next.step) {
            (0, _) => 1.0,
            (_, 0) => fade,
            _ => 0.0,
        };
        let of_level = detail_count(baked, this.step);
        let (gone, weights) = match (this.step, next.step) {
            // The far fur layer is the last level.
            (0, _) => (0.0, [0.0, 1.0]),
            (_, 0) => (0.0, [(1.0 - fade) * this.density, fade]),
            _ => (fade * detail_pairs(baked, this.step) as f32, [this.density, next.density]),
        };
        let drawn = of_level - gone as u32;
        Self {
            detail: InstanceDetail {
                in_picture: true,
                level: level as u32,
                fade,
                layers: drawn,
                of_layers,
                triangles: 0,
                fins: this.fins + (next.fins - this.fins) * fade,
                coat,
                strands: 0.0,
                strand_pieces: 0,
                fur_px: None,
            },
            layers: baked,
            step: this.step,
            gone,
            weights,
            texel_level: 0.0,
            list: 0,
            layer_share: 1.0,
            point_step: 1,
            most_pieces: None,
            px_per_m: f32::INFINITY,
            // The shadow maps use one layer count per level of detail. Otherwise, they would be redrawn whenever the
            // number of drawn layers changes.
            map_layers: of_level + 1,
        }
    }

    /// Whether some layers are skipped or fading.
    pub(crate) fn is_reduced(&self) -> bool {
        self.detail.level > 0 || self.detail.fade > 0.0 || self.has_strands()
    }

    /// Whether there are layers above the mesh surface, drawn or not.
    pub(crate) fn has_shells(&self) -> bool {
        self.detail.layers > 0
    }

    /// Whether the layers above the mesh surface are drawn.
    pub(crate) fn draws_shells(&self) -> bool {
        self.has_shells() && self.layer_share > 0.0
    }

    /// Whether single strands are drawn.
    pub(crate) fn has_strands(&self) -> bool {
        self.detail.strands > 0.0
    }

    /// Returns the level of detail as reported to the application.
    pub(crate) fn reported(&self) -> InstanceDetail {
        InstanceDetail { layers: if self.draws_shells() { self.detail.layers } else { 0 }, ..self.detail }
    }

    /// Returns the instance range of the shell draw: layers, or for reduced detail the indices of `detail_layer`.
    pub(crate) fn shell_instances(&self) -> Range<u32> {
        if self.is_reduced() { 0..self.detail.layers } else { 1..self.detail.layers + 1 }
    }
}

/// Returns the factor by which `detail` multiplies the size of fur on screen.
fn detail_bias(detail: Detail) -> f32 {
    if let Detail::Auto { bias } = detail { bias } else { 1.0 }
}

/// Returns the mip level of the hair textures at which texels are as large as pixels, for fur `px` pixels high.
fn texel_level(fur: &FurInfo, px: f32) -> f32 {
    let texel_px = px * fur.tile_size_m / (fur.height_m * fur.tile_texels.max(1) as f32);
    let level = -texel_px.log2();
    if level.is_finite() { level.ceil().clamp(0.0, fur.tile_texels.max(1).ilog2() as f32) } else { 0.0 }
}

#[cfg(test)]
#[path = "detail_tests.rs"]
mod tests;
