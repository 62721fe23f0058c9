//! `shadow_width`: two depth maps from the key light, and a filter that converts them to the shadow-width map (Yang
//! 2006, §4; Kirsch and Döllner 2003). The filter downsamples and upsamples the occlusion between them, so that its
//! grey measures the distance to a shadow edge.
//!
//! The paper draws the model a second time to compare it with the depth map. Here, the second draw is also depth-only:
//! the farthest light-facing surface. Where that is behind the nearest surface, it is in shadow. The comparison is then
//! one pass over texels, and the application can add geometry without a shader from pelage.
//!
//! With that comparison alone, a shadow that reaches the outline of its receiver would end there and fade towards it.
//! Therefore, a texel also counts if the shadowed surface is beside it, and empty texels have no weight. This reduces
//! the error (`pelage chart soft-shadow`: RMSE on the hare 0.092, otherwise 0.147).
//!
//! The fourth channel, the hair above the first surface, is for the application's own geometry and is blurred likewise.
//! It is not blurred across a step to a deeper surface. Hair there may be behind the nearer object, which would then
//! lose light at its edges.

use super::{Outcome, Pass, PassId, PassStage};
use crate::gpu::{BindingResource, Draw, RenderSpec, Shader, depth_texture, record, sampler, texture, uniform};
use crate::light::{CasterPass, HairMapKind, ShadowMaps};
use crate::params::StyleKind;
use crate::scene::{DEPTH, MapTarget, Recording, begin_maps, light_inside_remark, record_depth};
use crate::shared::shader_struct::shader_struct;

pub(crate) const FILTER: Shader = Shader { name: "pelage shadow width", parts: &[include_str!("filter.wgsl")] };

impl PassId {
    /// Depth maps from the key light, and the shadow-width map.
    pub const SHADOW_WIDTH: Self = Self(&PASS);
}

pub(crate) const PASS: Pass = Pass {
    name: "shadow_width",
    place: PassStage::Before,
    styles: &[StyleKind::Fur, StyleKind::Bare],
    lines: None,
    does: "draws two depth maps from the key light and derives a third map by shrinking and stretching: its grey is \
         the distance to the edge of a shadow (Yang 2006, §4)",
    runs_when: "soft shadow is on, and light, pose or model changed",
    shaders: &[DEPTH, FILTER],
    targets: &[],
    run,
};

shader_struct! {
    /// Uniform block of the filter.
    pub(crate) struct Filter {
        pub(crate) near: f32,
        pub(crate) far: f32,
        pub(crate) shrink: i32,
        pub(crate) least_gap: f32,
        pub(crate) clear_gap: f32,
        pub(crate) reserved0: f32,
        pub(crate) reserved1: f32,
        pub(crate) reserved2: f32,
    }
}

/// Maximum slope of a surface, relative to the plane perpendicular to the light. A steeper change of depth counts as a
/// step between two surfaces.
const STEEPEST: f32 = 2.5;

/// Step of the filter: fragment entry point, inputs in addition to the constants, and target.
struct Step<'a> {
    fragment: &'static str,
    layout: &'static str,
    depths: &'a [(u32, &'a wgpu::TextureView)],
    colors: &'a [(u32, &'a wgpu::TextureView)],
    linear: bool,
    target: &'a wgpu::TextureView,
}

fn record_step(frame: &mut Recording<'_>, step: &Step<'_>, constants: &BindingResource) {
    let d2 = wgpu::TextureViewDimension::D2;
    let layout = frame.cache.layouts.get(frame.gpu, step.layout, || {
        let mut entries = vec![uniform::<Filter>(0, false)];
        entries.extend(step.depths.iter().map(|(number, _)| depth_texture(*number, d2)));
        entries.extend(step.colors.iter().map(|(number, _)| texture(*number, d2)));
        entries.extend(step.linear.then(|| sampler(5)));
        entries
    });
    let mut entries = vec![(0, constants.clone())];
    entries.extend(step.depths.iter().chain(step.colors).map(|(n, view)| (*n, BindingResource::View((*view).clone()))));
    entries.extend(step.linear.then(|| (5, BindingResource::Sampler(frame.surfaces.map_sampler.clone()))));
    let group = frame.cache.bind_groups.get(frame.gpu, step.layout, &layout, entries);
    let spec = RenderSpec::screen(FILTER, ["vs_filter", step.fragment], layout, ShadowMaps::WIDTH_FORMAT);
    let draw = Draw::screen(frame.pipeline(spec), &group);
    record(&mut begin_maps(frame.encoder, FILTER.name, MapTarget::Light(step.target)), [&draw]);
}

/// Records the shadow-width map from the depth maps and layer-wise maps, which are already recorded.
fn record_filter(frame: &mut Recording<'_>, maps: &ShadowMaps) {
    let Some(textures) = &maps.width else { return };
    let light = maps.view();
    let near = light.near_m.unwrap_or(0.0);
    let constants = Filter {
        near,
        far: near + light.range_m,
        shrink: maps.key.params.shrink as i32,
        // The gap tolerates rounding between surfaces that touch.
        least_gap: 1e-3,
        // The depth that the steepest surface gains from a texel to the far side of the next block, a distance of two
        // blocks.
        clear_gap: STEEPEST * 2.0 * maps.key.params.shrink as f32 * maps.texel_m() / light.range_m,
        reserved0: 0.0,
        reserved1: 0.0,
        reserved2: 0.0,
    };
    let place = frame.uniforms.put(frame.gpu, &[constants]);
    let constants = BindingResource::block::<Filter>(&place.buffer, place.offset);
    let white = frame.surfaces.white.clone();
    let hair = maps.layers.as_ref().and_then(|layers| layers.slices.first()).unwrap_or(&white);
    let (nearest, farthest) = ((1, &maps.nearest.view), (2, &textures.farthest.view));
    let (deepest, shrunk) = (&textures.deepest.view, &textures.shrunk.view);
    let steps = [
        Step {
            fragment: "fs_deepest",
            layout: "pelage deepest",
            depths: &[nearest, farthest],
            colors: &[],
            linear: false,
            target: deepest,
        },
        Step {
            fragment: "fs_shrink",
            layout: "pelage shrink",
            depths: &[nearest, farthest],
            colors: &[(3, hair), (4, deepest)],
            linear: false,
            target: shrunk,
        },
        Step {
            fragment: "fs_stretch",
            layout: "pelage stretch",
            depths: &[nearest],
            colors: &[(3, hair), (4, shrunk), (6, deepest)],
            linear: true,
            target: &textures.width.view,
        },
    ];
    steps.iter().for_each(|step| record_step(frame, step, &constants));
}

fn run(frame: &mut Recording<'_>) -> Outcome {
    let maps = frame.maps.clone();
    match maps.as_deref().filter(|maps| maps.key.soft_shadow) {
        Some(maps) if frame.redraws_maps() => {
            // If hair casts shadows on hair, the depth map has already been recorded.
            if maps.key.hair == HairMapKind::None && maps.deep.is_none() {
                record_depth(frame, maps, CasterPass::Nearest);
            }
            record_depth(frame, maps, CasterPass::Farthest);
            record_filter(frame, maps);
            let (size, shrink) = (maps.key.params.map_size, maps.key.params.shrink);
            Outcome::recorded(format!("{size} x {size}, shrunk {shrink} times{}", light_inside_remark(maps)))
        }
        Some(_) => Outcome::Skipped("light, poses and models are unchanged"),
        None if frame.instances.is_empty() => Outcome::Skipped("no instances"),
        None if !frame.params.soft_shadow => Outcome::Skipped("switched off"),
        None => Outcome::Skipped("the key light is dark"),
    }
}
