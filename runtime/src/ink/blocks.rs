//! Uniform blocks of the ink passes.

use crate::bounds::Hull;
use crate::model::ModelInk;
use crate::params::InkParams;
use crate::shared::shader_struct::shader_struct;
use crate::shared::srgb::encoded;
use glam::{Mat3, Mat4};

shader_struct! {
    /// Uniform block for a frame, in shader layout.
    pub(crate) struct InkFrame {
        pub(crate) ink: [f32; 3],
        pub(crate) roughness: f32,
        pub(crate) paper: [f32; 3],
        pub(crate) paper_grain: f32,
        pub(crate) size: [f32; 2],
        pub(crate) t1: f32,
        pub(crate) t2: f32,
        pub(crate) step: i32,
        pub(crate) reach: i32,
        pub(crate) half_width: f32,
        pub(crate) half_width_scaled: f32,
        pub(crate) tone: f32,
        pub(crate) lightness: f32,
        pub(crate) dryness: f32,
        pub(crate) paper_period: f32,
        pub(crate) mist_from: f32,
        pub(crate) mist_to: f32,
        pub(crate) depth_step: f32,
        pub(crate) far_depth: f32,
    }
}

shader_struct! {
    /// Uniform block for an instance, in shader layout.
    pub(crate) struct InkModel {
        pub(crate) right_ws: [f32; 3],
        pub(crate) wash_speed: f32,
        pub(crate) up_ws: [f32; 3],
        pub(crate) wash_range: f32,
        pub(crate) periods: f32,
        pub(crate) normalised: f32,
        pub(crate) grain: f32,
        pub(crate) tone: f32,
        pub(crate) fur: f32,
        pub(crate) line: f32,
        pub(crate) pressure: f32,
        pub(crate) swell: f32,
        pub(crate) ink: [f32; 3],
        pub(crate) paper_period: f32,
        pub(crate) stroke_px: f32,
        pub(crate) px_per_unit: f32,
        pub(crate) reserved: [f32; 2],
    }
}

impl InkFrame {
    pub(crate) fn new(params: &InkParams, viewport: [u32; 2], clip_from_view: Mat4, reversed_depth: bool) -> Self {
        let [width, height] = viewport.map(|n| n as f32);
        let [half_width, half_width_m] = params.half_width(viewport[1]);
        let [mist_from, mist_to] = params.mist_m.unwrap_or_default();
        Self {
            ink: encoded(params.ink).to_array(),
            roughness: params.roughness_px,
            paper: encoded(params.paper).to_array(),
            paper_grain: params.paper_grain,
            size: [width, height],
            t1: params.threshold,
            t2: params.threshold - params.weak_difference,
            step: params.step_px as i32,
            reach: params.reach_px(viewport[1]) as i32,
            half_width,
            half_width_scaled: half_width_m * px_per_unit(clip_from_view, viewport),
            tone: params.tone,
            lightness: params.weak_lightness,
            dryness: params.dryness,
            paper_period: params.paper_period_px,
            mist_from,
            mist_to,
            depth_step: params.depth_step,
            far_depth: if reversed_depth { 0.0 } else { 1.0 },
        }
    }
}

impl InkModel {
    pub(crate) fn new(
        ink: &ModelInk,
        params: &InkParams,
        viewport: [u32; 2],
        view_from_world: Mat4,
        clip_from_view: Mat4,
    ) -> Self {
        let shading = params.shading.unwrap_or(ink.info.shading);
        let rotation = Mat3::from_mat4(view_from_world);
        Self {
            right_ws: rotation.row(0).to_array(),
            wash_speed: shading.wash_speed,
            up_ws: rotation.row(1).to_array(),
            wash_range: shading.wash_range,
            periods: ink.periods,
            normalised: f32::from(u8::from(shading.normalised)),
            grain: shading.grain,
            tone: shading.tone,
            fur: shading.fur,
            line: shading.line,
            pressure: params.pressure,
            swell: params.swell,
            ink: encoded(params.ink).to_array(),
            paper_period: params.paper_period_px,
            stroke_px: (0.17 * InkParams::default_width_px(viewport[1])).max(1.2),
            px_per_unit: px_per_unit(clip_from_view, viewport),
            reserved: [0.0; 2],
        }
    }
}

/// Returns the height in pixels of 1 m at clip-space w = 1.
fn px_per_unit(clip_from_view: Mat4, viewport: [u32; 2]) -> f32 {
    clip_from_view.y_axis.y.abs() * 0.5 * viewport[1] as f32
}

/// Returns the rectangle of the target that lines can reach: left, top, width and height, pixels. Screen passes skip
/// all other pixels.
pub(crate) fn painted_rect(hull: &Hull, clip_from_world: Mat4, params: &InkParams, viewport: [u32; 2]) -> [u32; 4] {
    // Lines extend beyond their features, and features can lie beside the drawn geometry.
    let margin = (params.reach_px(viewport[1]) + params.step_px + 1) as f32;
    let [left, top, right, bottom] = hull.screen_rect(clip_from_world, viewport, margin);
    [left, top, right - left, bottom - top]
}
