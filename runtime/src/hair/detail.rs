//! Levels of detail: how much of a model's fur is drawn where it is small on screen.
//!
//! A package brings the chain (`FORMAT.md`, "Levels of detail"): fewer and fewer layers, each standing for more of them, and last the skin
//! with the far coat on it. No level is drawn twice: between two, layers go one after
//! another, and give their opacity to those that stay.

use super::thin::{found_as, point_step, share_of_hairs, shares_on_the_way, way_to_strands};
use crate::bounds::Hull;
use crate::gpu::largest_buffer;
use crate::instance::Instance;
use crate::model::{Model, Strands};
use crate::params::{Detail, FrameParams, FurParams, Hair, Style};
use crate::report::InstanceDetail;
use crate::shared::detail::{detail_count, detail_pairs};
use glam::Mat4;
use pelage_formats::meaning::{detail_place, simplest_list};
use pelage_formats::{FurInfo, Manifest};
use std::ops::Range;

/// What an instance draws in a frame, as pipelines and shaders need it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Drawing {
    pub(crate) detail: InstanceDetail,
    /// Layers that the shaders count with, skin counted; 1 where no fur shows.
    pub(crate) layers: u32,
    /// Every how many layers is drawn.
    pub(crate) step: u32,
    /// How many of them have gone over to the next level, [`detail_fade`](crate::shared::detail::detail_fade).
    pub(crate) gone: f32,
    /// Density of the level and of the next; where that is the far coat, its share, and what it leaves of the former.
    pub(crate) weights: [f32; 2],
    /// Mip level of the hair whose texels are as large as pixels at the nearest point of the model, whole: for what is read of one level.
    pub(crate) texel_level: f32,
    /// Which index list is drawn: the mesh's own, 0, or one of those that are simplified.
    pub(crate) list: usize,
    /// Share of the layers' opacity that single strands leave.
    pub(crate) layer_share: f32,
    /// Every how many points of single strands are drawn.
    pub(crate) point_step: u32,
    /// Most pieces of a strand, where a study says so.
    most_pieces: Option<u32>,
    /// Pixels that a metre of it has on screen, times the application's bias.
    px_per_m: f32,
    /// Layers of the shadow maps that suit it, skin counted; 1 where it draws none.
    pub(crate) map_layers: u32,
}

/// How an instance draws one of its model's sets of strands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DrawnSet {
    /// Index into the model's.
    pub(crate) set: usize,
    /// Share of the strands.
    pub(crate) share: f32,
    /// How much wider they are than they grow.
    pub(crate) widened: f32,
    /// Every how many points is drawn.
    pub(crate) step: u32,
}

impl DrawnSet {
    /// All points of all of them, as wide as they grow.
    pub(crate) fn whole(&self) -> Self {
        Self { share: 1.0, widened: 1.0, step: 1, ..*self }
    }
}

impl Drawing {
    /// What `params` draws of an instance, with so many samples a pixel; `hull`: of it as it is posed, in world space.
    pub(crate) fn of(
        instance: &Instance,
        hull: &Hull,
        params: &FrameParams,
        samples: u32,
        clip_from_view: Mat4,
    ) -> Self {
        let clip_from_world = clip_from_view * params.camera.view_from_world;
        let px_per_m = instance.scale() * hull.px_per_m(clip_from_view, clip_from_world, params.viewport[1]);
        let detail = params.style.fur().map_or(1.0, |fur| bias(fur.detail));
        let most_pieces = crate::study::strand_pieces(params);
        let drawing = Self { px_per_m: px_per_m * detail, most_pieces, ..Self::layered(instance, px_per_m, params) };
        let Some(fur) = params.style.fur().filter(|_| params.debug.only_layer.is_none()) else {
            return drawing;
        };
        let Some(strands) = instance.model.coat_strands().filter(|_| drawing.has_shells()) else { return drawing };
        let way = match fur.hair {
            Hair::Shells => 0.0,
            Hair::Strands => 1.0,
            // Who names layers wants to see them.
            Hair::Auto if fur.layers.is_some() || matches!(fur.detail, Detail::Level(_)) => 0.0,
            Hair::Auto => way_to_strands(fur, px_per_m * strands.mean_width_m * bias(fur.detail), samples),
        };
        Self {
            point_step: point_step(strands, px_per_m, found_as(fur, samples), most_pieces),
            ..drawing.with_strands(way)
        }
    }

    /// On the [way](way_to_strands) from layers to single strands. The far coat is in both.
    fn with_strands(mut self, way: f32) -> Self {
        let [strands, layers] = shares_on_the_way(way);
        self.detail.strands = strands * (1.0 - self.detail.coat);
        self.layer_share = layers;
        self.detail.fins *= self.layer_share;
        self
    }

    /// The same on a device of these limits: with fewer points where its buffers do not hold all.
    pub(crate) fn within(self, limits: &wgpu::Limits, model: &Model) -> Self {
        let Some(strands) = model.coat_strands().filter(|_| self.has_strands()) else { return self };
        let fits = |step: &u32| *step >= self.point_step && strands.ribbon_bytes(*step) <= largest_buffer(limits);
        let point_step = strands.steps().find(fits).unwrap_or(strands.points - 1);
        let detail = InstanceDetail { strand_pieces: strands.pieces(point_step), ..self.detail };
        Self { point_step, detail, ..self }
    }

    /// Which of the model's sets of strands it draws, with so many samples a pixel, on a device of these limits. Groups of hair are drawn as strands at
    /// any size: where they are thinner than samples find them, fewer and wider ones.
    pub(crate) fn sets(&self, model: &Model, style: &Style, samples: u32, limits: &wgpu::Limits) -> Vec<DrawnSet> {
        let Some(fur) = style.fur() else { return Vec::new() };
        let found = found_as(fur, samples);
        let of = |(set, strands): (usize, &Strands)| {
            let guided = strands.guided().is_some();
            let fewer = share_of_hairs(fur, guided, self.px_per_m * strands.mean_width_m, samples);
            let widened = fewer.recip();
            if !guided {
                let (share, step) = (fewer * self.detail.strands, self.point_step);
                return self.has_strands().then_some(DrawnSet { set, share, widened, step });
            }
            let fits = |step: &u32| strands.ribbon_bytes(*step) <= largest_buffer(limits);
            let wanted = point_step(strands, self.px_per_m, found, self.most_pieces);
            let step = strands.steps().find(|step| *step >= wanted && fits(step)).unwrap_or(strands.points - 1);
            Some(DrawnSet { set, share: fewer, widened, step })
        };
        model.strands().iter().enumerate().filter_map(of).collect()
    }

    fn layered(instance: &Instance, px_per_m: f32, params: &FrameParams) -> Self {
        let manifest = instance.model.manifest();
        let high_px = if px_per_m.is_finite() { manifest.fur.height_m * px_per_m } else { f32::INFINITY };
        let texel_level = texel_level(&manifest.fur, high_px);
        let fur = params.style.fur().filter(|_| params.debug.only_layer.is_none());
        let Some(FurParams { layers: None, detail, .. }) = fur.filter(|_| !manifest.detail.is_empty()) else {
            return Self { texel_level, ..Self::at(manifest, params, 0, 0.0) }.with_list(&instance.model, 0);
        };
        let fur_px = matches!(detail, Detail::Auto { .. }).then_some(high_px);
        let (level, fade) = match *detail {
            Detail::Full => (0, 0.0),
            Detail::Auto { bias } => detail_place(&manifest.detail, fur_px.map_or(f32::INFINITY, |px| px * bias)),
            Detail::Level(level) => {
                let last = manifest.detail.len() - 1;
                let whole = (level as usize).min(last);
                (whole, if whole == last { 0.0 } else { level.fract() })
            }
        };
        let mut drawing = Self::at(manifest, params, level, fade);
        drawing.detail.fur_px = fur_px;
        drawing.texel_level = texel_level;
        let list = match detail {
            Detail::Auto { bias } => simplest_list(instance.model.deviations_m(), px_per_m * bias),
            Detail::Full | Detail::Level(_) => 0,
        };
        drawing.with_list(&instance.model, list)
    }

    fn with_list(mut self, model: &Model, list: usize) -> Self {
        (self.list, self.detail.triangles) = (list, model.triangles(list));
        self
    }

    fn at(manifest: &Manifest, params: &FrameParams, level: usize, fade: f32) -> Self {
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
            // The coat alone is the next of nothing.
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
            // Maps are not made anew for every number of layers.
            map_layers: of_level + 1,
        }
    }

    /// Whether layers are left out, or fade.
    pub(crate) fn is_reduced(&self) -> bool {
        self.detail.level > 0 || self.detail.fade > 0.0 || self.has_strands()
    }

    /// Whether it has layers above the skin, drawn or not.
    pub(crate) fn has_shells(&self) -> bool {
        self.detail.layers > 0
    }

    /// Whether it draws them.
    pub(crate) fn draws_shells(&self) -> bool {
        self.has_shells() && self.layer_share > 0.0
    }

    /// Whether it draws single strands.
    pub(crate) fn has_strands(&self) -> bool {
        self.detail.strands > 0.0
    }

    /// As reports say it.
    pub(crate) fn reported(&self) -> InstanceDetail {
        InstanceDetail { layers: if self.draws_shells() { self.detail.layers } else { 0 }, ..self.detail }
    }

    /// Instances of the draw of the shells: layers, or where it is reduced the indices of `detail_layer`.
    pub(crate) fn shell_instances(&self) -> Range<u32> {
        if self.is_reduced() { 0..self.detail.layers } else { 1..self.layers }
    }
}

/// Factor on the size on screen.
fn bias(detail: Detail) -> f32 {
    if let Detail::Auto { bias } = detail { bias } else { 1.0 }
}

/// Level of the hair's textures whose texels are as large as pixels, where fur is `px` pixels high.
fn texel_level(fur: &FurInfo, px: f32) -> f32 {
    let texel_px = px * fur.tile_size_m / (fur.height_m * fur.tile_texels.max(1) as f32);
    let level = -texel_px.log2();
    if level.is_finite() { level.ceil().clamp(0.0, fur.tile_texels.max(1).ilog2() as f32) } else { 0.0 }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
#[path = "detail_tests.rs"]
mod tests;
