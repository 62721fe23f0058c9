//! Levels of detail: how much of a model's fur is drawn where it is small on screen.
//!
//! A package brings the chain (`FORMAT.md`, "Levels of detail"): fewer and fewer layers, each standing for more of them, and last the skin
//! with the far coat on it. No level is drawn twice: between two, layers that vanish lose their opacity to those that stay.

use crate::light_view::Hull;
use crate::shared::detail::detail_count;
use crate::{FrameParams, Instance, RuntimeError, Style};
use glam::{Mat3, Mat4};
use pelage_formats::{DetailLevel, Manifest};
use std::ops::Range;

/// How much of each model's fur is drawn. [`FrameParams::layers`] goes before it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Detail {
    /// All of it, whatever its size on screen (default: only the application knows how large its target is).
    #[default]
    Full,
    /// The package's levels of detail, by the size that each instance has on screen.
    Auto {
        /// Height of the render target, or of the viewport in it, pixels, above 0.
        target_height_px: f32,
        /// Factor on the size, above 0: 2 draws as much as if everything were twice as large, 0.5 saves more (1 as the package says).
        bias: f32,
    },
    /// This level of every package, and between two levels by the fraction: 0 all layers; beyond the last, the last. For measuring.
    Level(
        /// At least 0.
        f32,
    ),
}

/// What is drawn of an instance's fur.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InstanceDetail {
    /// Index into the package's levels of detail.
    pub level: u32,
    /// How far it has faded to the next level, 0..1.
    pub fade: f32,
    /// Layers that are drawn, the skin not counted.
    pub layers: u32,
    /// Layers that the package has, the skin not counted.
    pub of_layers: u32,
    /// Share of the fins' opacity, 0..=1.
    pub fins: f32,
    /// How far the far coat has taken over, 0..=1.
    pub coat: f32,
    /// Height of the fur on screen, pixels, at the nearest point of the model; `None` where nothing depends on it. Infinite where the eye is
    /// within the model's bounds.
    pub fur_px: Option<f32>,
}

/// What an instance draws in a frame, as pipelines and shaders need it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Drawing {
    pub(crate) detail: InstanceDetail,
    /// Layers that the shaders count with, skin counted; 1 where no fur shows.
    pub(crate) layers: u32,
    /// Every how many layers is drawn, and in the next level.
    pub(crate) step: u32,
    pub(crate) next_step: u32,
    /// Share of the level and of the next, each times its density.
    pub(crate) weights: [f32; 2],
    /// Layers of the shadow maps that suit it, skin counted; 1 where it draws none.
    pub(crate) map_layers: u32,
}

impl Detail {
    pub(crate) fn check(&self) -> Result<(), RuntimeError> {
        let good = |x: f32| x.is_finite() && x > 0.0;
        let fail = |found: String, expected: &str| {
            Err(RuntimeError::Params { field: "FrameParams::detail", found, expected: expected.into() })
        };
        match *self {
            Self::Auto { target_height_px, bias } if !(good(target_height_px) && good(bias)) => {
                fail(format!("{self:?}"), "a height and a bias above 0")
            }
            Self::Level(level) if !(level.is_finite() && level >= 0.0) => fail(level.to_string(), "at least 0"),
            _ => Ok(()),
        }
    }
}

impl Drawing {
    /// What `params` draws of an instance at its place; its pose is that of the last frame prepared.
    pub(crate) fn of(instance: &Instance, params: &FrameParams, clip_from_view: Mat4) -> Self {
        let manifest = instance.model().manifest();
        let fur_px = match params.detail {
            Detail::Auto { target_height_px, .. } if has_levels(manifest, params) => {
                Some(fur_px(instance, params, clip_from_view, target_height_px))
            }
            _ => None,
        };
        let (level, fade) = match params.detail {
            _ if !has_levels(manifest, params) => (0, 0.0),
            Detail::Full => (0, 0.0),
            Detail::Auto { bias, .. } => place_in(&manifest.detail, fur_px.map_or(f32::INFINITY, |px| px * bias)),
            Detail::Level(level) => {
                let last = manifest.detail.len() - 1;
                let whole = (level as usize).min(last);
                (whole, if whole == last { 0.0 } else { level.fract() })
            }
        };
        let mut drawing = Self::at(manifest, params, level, fade);
        drawing.detail.fur_px = fur_px;
        drawing
    }

    /// Every look that `params` may give a model: what pipelines are compiled for.
    pub(crate) fn all(manifest: &Manifest, params: &FrameParams) -> Vec<Self> {
        let count = match params.detail {
            Detail::Full => 1,
            _ if !has_levels(manifest, params) => 1,
            _ => manifest.detail.len(),
        };
        (0..count).flat_map(|level| [0.0, 0.5].map(|fade| Self::at(manifest, params, level, fade))).collect()
    }

    fn at(manifest: &Manifest, params: &FrameParams, level: usize, fade: f32) -> Self {
        let baked = manifest.fur.layers;
        let furry = baked > 1 && params.style == Style::Fur;
        let layers = if furry { params.layers.unwrap_or(baked) } else { 1 };
        let of_layers = baked.saturating_sub(1);
        let plain = Self {
            detail: InstanceDetail {
                level: 0,
                fade: 0.0,
                layers: layers - 1,
                of_layers,
                fins: if layers > 1 { 1.0 } else { 0.0 },
                coat: 0.0,
                fur_px: None,
            },
            layers,
            step: 1,
            next_step: 1,
            weights: [1.0, 0.0],
            map_layers: layers,
        };
        let Some(this) = manifest.detail.get(level).filter(|_| furry && params.layers.is_none()) else { return plain };
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
        let drawn = detail_count(baked, this.step);
        Self {
            detail: InstanceDetail {
                level: level as u32,
                fade,
                layers: drawn,
                of_layers,
                fins: this.fins + (next.fins - this.fins) * fade,
                coat,
                fur_px: None,
            },
            layers: baked,
            step: this.step,
            next_step: next.step,
            // The coat alone is the next of nothing.
            weights: if this.step == 0 { [0.0, 1.0] } else { [(1.0 - fade) * this.density, fade * next.density] },
            map_layers: drawn + 1,
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

/// Whether there are levels to choose from.
fn has_levels(manifest: &Manifest, params: &FrameParams) -> bool {
    !manifest.detail.is_empty() && params.layers.is_none() && params.only_layer.is_none() && params.style == Style::Fur
}

/// Level and fade of fur that is `px` pixels high.
fn place_in(levels: &[DetailLevel], px: f32) -> (usize, f32) {
    let last = levels.len().saturating_sub(1);
    let level = levels.iter().position(|level| px > level.gone_px).unwrap_or(last);
    let Some(found) = levels.get(level).filter(|found| level < last && px < found.full_px) else { return (level, 0.0) };
    let fade = (found.full_px / px).ln() / (found.full_px / found.gone_px).ln();
    // A level that is never gone does not fade.
    (level, if fade.is_finite() { fade.clamp(0.0, 1.0) } else { 0.0 })
}

/// Height of the fur on screen, pixels, at the nearest point of the model.
fn fur_px(instance: &Instance, params: &FrameParams, clip_from_view: Mat4, target_height_px: f32) -> f32 {
    let mut hull = Hull::default();
    instance.add_to(&mut hull);
    let w = (clip_from_view * params.camera.view_from_world).row(3);
    // Of clip space's w, which is the depth of a perspective view and 1 of a parallel one.
    let reach = w.truncate().length();
    let nearest = hull.0.iter().map(|(p, margin)| w.dot(p.extend(1.0)) - reach * margin).fold(f32::INFINITY, f32::min);
    let scale = Mat3::from_mat4(instance.transform).determinant().abs().cbrt();
    let fur_m = instance.model().manifest().fur.height_m * scale;
    let px_per_m = 0.5 * target_height_px * clip_from_view.y_axis.y.abs() / nearest;
    if nearest > 0.0 { fur_m * px_per_m } else { f32::INFINITY }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
#[path = "detail_tests.rs"]
mod tests;
