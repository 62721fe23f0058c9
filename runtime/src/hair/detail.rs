//! Levels of detail: how much of a model's fur is drawn where it is small on screen.
//!
//! A package brings the chain (`FORMAT.md`, "Levels of detail"): fewer and fewer layers, each standing for more of them, and last the skin
//! with the far coat on it. No level is drawn twice: between two, layers go one after
//! another, and give their opacity to those that stay.

use crate::bounds::Hull;
use crate::instance::Instance;
use crate::model::Model;
use crate::params::{Detail, FrameParams, FurParams};
use crate::report::InstanceDetail;
use crate::shared::detail::{detail_count, detail_pairs};
use glam::{Mat3, Mat4};
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
    /// Layers of the shadow maps that suit it, skin counted; 1 where it draws none.
    pub(crate) map_layers: u32,
}

impl Drawing {
    /// What `params` draws of an instance; `hull`: of it as it is posed, in world space.
    pub(crate) fn of(instance: &Instance, hull: &Hull, params: &FrameParams, clip_from_view: Mat4) -> Self {
        let manifest = instance.model.manifest();
        let px_per_m = px_per_m(instance, hull, params, clip_from_view);
        let high_px = if px_per_m.is_finite() { manifest.fur.height_m * px_per_m } else { f32::INFINITY };
        let texel_level = texel_level(&manifest.fur, high_px);
        let fur = params.style.fur().filter(|_| crate::study::only_layer(params).is_none());
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
                fur_px: None,
            },
            layers,
            step: 1,
            gone: 0.0,
            weights: [1.0, 0.0],
            texel_level: 0.0,
            list: 0,
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
                fur_px: None,
            },
            layers: baked,
            step: this.step,
            gone,
            weights,
            texel_level: 0.0,
            list: 0,
            // Maps are not made anew for every number of layers.
            map_layers: of_level + 1,
        }
    }

    /// Whether layers are left out, or fade.
    pub(crate) fn is_reduced(&self) -> bool {
        self.detail.level > 0 || self.detail.fade > 0.0
    }

    /// Whether it draws layers above the skin.
    pub(crate) fn has_shells(&self) -> bool {
        self.detail.layers > 0
    }

    /// Instances of the draw of the shells: layers, or where it is reduced the indices of `detail_layer`.
    pub(crate) fn shell_instances(&self) -> Range<u32> {
        if self.is_reduced() { 0..self.detail.layers } else { 1..self.layers }
    }
}

/// Level of the hair's textures whose texels are as large as pixels, where fur is `px` pixels high.
fn texel_level(fur: &FurInfo, px: f32) -> f32 {
    let texel_px = px * fur.tile_size_m / (fur.height_m * fur.tile_texels.max(1) as f32);
    let level = -texel_px.log2();
    if level.is_finite() { level.ceil().clamp(0.0, fur.tile_texels.max(1).ilog2() as f32) } else { 0.0 }
}

/// Pixels on screen that a metre of the model at rest has, seen from the side, at the nearest point of the model; infinite where the eye is
/// within its bounds.
fn px_per_m(instance: &Instance, hull: &Hull, params: &FrameParams, clip_from_view: Mat4) -> f32 {
    let w = (clip_from_view * params.camera.view_from_world).row(3);
    // Of clip space's w, which is the depth of a perspective view and 1 of a parallel one.
    let reach = w.truncate().length();
    let nearest = hull.0.iter().map(|(p, margin)| w.dot(p.extend(1.0)) - reach * margin).fold(f32::INFINITY, f32::min);
    let scale = Mat3::from_mat4(instance.transform).determinant().abs().cbrt();
    let px_per_m = scale * 0.5 * params.viewport[1] as f32 * clip_from_view.y_axis.y.abs() / nearest;
    if nearest > 0.0 { px_per_m } else { f32::INFINITY }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
#[path = "detail_tests.rs"]
mod tests;
