//! `layer_shadow`: transmittance of the hair above each layer, seen from the key light, in an array texture (Yang 2006,
//! §3.1).
//!
//! Layers are drawn from the outermost inwards. Each map is made from the one above, directly in its array layer, in
//! format R16Float. [`crate::ShadowParams`] describes when the pass runs, and the number of maps.
//!
//! The paper clears each map to white, draws the nearest surface of a layer and reads the map above. Here, a map starts
//! as a copy of the one above. Each surface of the layer in front of the nearest opaque surface is multiplied into it.
//! The fringe of fur beside a body therefore shades objects behind it, and no layer needs a depth buffer of its own. On
//! a software rasteriser, such buffers took a fifth of the time.

use super::{Outcome, Pass, PassId, PassStage, any_reduced};
use crate::gpu::{BindingResource, Draw, RenderSpec, Shader, depth_state, flag, record, storage, uniform};
use crate::hair::{cutout_constants, groom_constants, hair_wgsl};
use crate::light::{CasterPass, HairMapKind, ShadowMaps};
use crate::model::Part;
use crate::params::StyleKind;
use crate::scene::{DEPTH, MapTarget, Recording, VisibleInstance, begin_maps, light_inside_remark, record_depth};
use crate::shared::deep_opacity::DeepOpacity;
use glam::Vec3;

pub(crate) const SHADER: Shader =
    Shader { name: "pelage layer shadow", parts: hair_wgsl!(include_str!("layer_shadow.wgsl")) };

/// Shader for the transmittance of guided hair.
pub(crate) const GUIDED: Shader = Shader {
    name: "pelage hair light",
    parts: &[include_str!("../../shared/deep_opacity.wgsl"), include_str!("guided.wgsl")],
};

impl PassId {
    /// Transmittance of the hair above each layer, seen from the key light.
    pub const LAYER_SHADOW: Self = Self(&PASS);
}

pub(crate) const PASS: Pass = Pass {
    name: "layer_shadow",
    place: PassStage::Before,
    styles: &[StyleKind::Fur],
    lines: None,
    does: "writes the transmittance of the hair above each layer, seen from the key light, into an array of R16Float \
         maps (Yang 2006, §3). Where packages store how hair shadows hair, writes one map for all hair instead",
    runs_when: "self-shadow is on, fur is drawn, and light, pose or model changed",
    shaders: &[DEPTH, SHADER, GUIDED],
    targets: &[],
    run,
};

/// Blend state that multiplies the target by the source.
const MULTIPLIED: wgpu::BlendState = {
    let times = wgpu::BlendComponent {
        src_factor: wgpu::BlendFactor::Zero,
        dst_factor: wgpu::BlendFactor::Src,
        operation: wgpu::BlendOperation::Add,
    };
    wgpu::BlendState { color: times, alpha: wgpu::BlendComponent { dst_factor: wgpu::BlendFactor::SrcAlpha, ..times } }
};

fn spec(frame: &Recording<'_>, seen: &VisibleInstance, part: &Part) -> RenderSpec {
    let varies = seen.model.varies().groom || part.has_groom_texture || seen.model.manifest().fur.wet.is_some();
    let mapped = part.cutout || varies;
    let entries = if mapped { ["vs_layer_mapped", "fs_layer_mapped"] } else { ["vs_layer", "fs_layer"] };
    let mut constants = cutout_constants(part);
    constants.extend(groom_constants(&seen.model, part));
    constants.extend([flag("LEAN", seen.model.varies().lean), flag("RESAMPLED", seen.look.maps_resampled)]);
    RenderSpec {
        colors: vec![wgpu::ColorTargetState {
            format: ShadowMaps::LAYER_FORMAT,
            blend: Some(MULTIPLIED),
            write_mask: wgpu::ColorWrites::ALL,
        }],
        // Layers that coincide with the mesh surface absorb no light.
        depth: Some(depth_state(ShadowMaps::DEPTH_FORMAT, false, wgpu::CompareFunction::Less)),
        samples: 1,
        ..frame.picture_spec(SHADER, entries, constants, [seen.look.mirrored, part.double_sided], true)
    }
}

/// Returns the draws of all furred parts, without the layer range.
fn draws(frame: &mut Recording<'_>) -> Vec<Draw> {
    let mut draws = Vec::new();
    for seen in frame.instances.clone().iter().filter(|seen| seen.drawing.has_shells()) {
        let groups = [frame.light_group(seen), seen.fur()];
        draws.extend(frame.part_draws(seen, |part| part.furred, groups, 0..1, |frame, part| spec(frame, seen, part)));
    }
    draws
}

/// Records the transmittance of guided hair, from the deep opacity map; 1 without guided hair.
fn record_guided(frame: &mut Recording<'_>, maps: &ShadowMaps, target: &wgpu::TextureView) {
    let Some(deep) = maps.deep.as_ref().filter(|_| maps.key.guided()) else {
        drop(begin_maps(frame.encoder, SHADER.name, MapTarget::Light(target)));
        return;
    };
    let layout = frame.cache.layouts.get(frame.gpu, GUIDED.name, || {
        vec![storage::<u32>(0, wgpu::ShaderStages::FRAGMENT), uniform::<DeepOpacity>(1, false)]
    });
    let place = frame.uniforms.put(frame.gpu, &[maps.deep_opacity()]);
    let block = BindingResource::block::<DeepOpacity>(&place.buffer, place.offset);
    let group =
        frame.cache.bind_groups.get(frame.gpu, GUIDED.name, &layout, vec![(0, BindingResource::all(deep)), (1, block)]);
    let spec = RenderSpec::screen(GUIDED, ["vs_guided", "fs_guided"], layout, ShadowMaps::LAYER_FORMAT);
    let spec = RenderSpec { constants: vec![("MAP_SIZE", maps.key.params.map_size)], ..spec };
    let draw = Draw::screen(frame.pipeline(spec), &group);
    record(&mut begin_maps(frame.encoder, GUIDED.name, MapTarget::Light(target)), [&draw]);
}

/// Records all layer-wise maps in front of the nearest opaque surface.
fn record_layers(frame: &mut Recording<'_>, maps: &ShadowMaps) {
    let Some(layers) = &maps.layers else { return };
    let mut draws = draws(frame);
    let texture = &layers.map.texture;
    let place = |layer| wgpu::TexelCopyTextureInfo {
        origin: wgpu::Origin3d { x: 0, y: 0, z: layer },
        ..texture.as_image_copy()
    };
    let texels = wgpu::Extent3d { depth_or_array_layers: 1, ..texture.size() };
    let Some((outermost, below)) = layers.slices.split_last() else { return };
    // Only guided hair can be above the outermost layer, at any height.
    record_guided(frame, maps, outermost);
    if maps.key.hair == HairMapKind::Total {
        let all = below.first().unwrap_or(outermost);
        if !below.is_empty() {
            frame.encoder.copy_texture_to_texture(place(1), place(0), texels);
        }
        draws.iter_mut().for_each(|draw| draw.instances = 1..maps.key.map_layers);
        let target = MapTarget::LightBefore { light: all, nearest: &maps.nearest.view };
        record(&mut begin_maps(frame.encoder, SHADER.name, target), &draws);
        return;
    }
    for (layer, target) in (1..below.len() as u32 + 1).zip(below).rev() {
        // The map starts as a copy of the one above, also where this layer is absent, because adjacent texels may be
        // visible through the gap.
        frame.encoder.copy_texture_to_texture(place(layer), place(layer - 1), texels);
        let target = MapTarget::LightBefore { light: target, nearest: &maps.nearest.view };
        draws.iter_mut().for_each(|draw| draw.instances = layer..layer + 1);
        record(&mut begin_maps(frame.encoder, SHADER.name, target), &draws);
    }
}

fn run(frame: &mut Recording<'_>) -> Outcome {
    let maps = frame.maps.clone();
    if let Some(maps) = maps.as_deref().filter(|maps| frame.redraws_maps() && maps.key.hair != HairMapKind::None) {
        // With single strands, the depth map has already been recorded.
        if maps.deep.is_none() {
            record_depth(frame, maps, CasterPass::Nearest);
        }
        record_layers(frame, maps);
    }
    match maps.filter(|maps| maps.key.hair != HairMapKind::None) {
        Some(maps) if frame.redraws_maps() && maps.key.hair == HairMapKind::Total => {
            let (size, layers) = (maps.key.params.map_size, maps.key.map_layers - 1);
            Outcome::recorded(format!("one map of {layers} layers, {size} x {size}{}", light_inside_remark(&maps)))
        }
        Some(maps) if frame.redraws_maps() => {
            let (size, layers) = (maps.key.params.map_size, maps.key.map_layers - 1);
            Outcome::recorded(format!("{layers} maps of {size} x {size}{}", light_inside_remark(&maps)))
        }
        Some(_) => Outcome::Skipped("light, poses and models are unchanged"),
        None if frame.instances.is_empty() => Outcome::Skipped("no instances"),
        None if frame.params.self_shadow() && !frame.params.soft_shadow => {
            Outcome::Skipped("packages store how hair shadows hair")
        }
        None if !frame.params.self_shadow() => Outcome::Skipped("switched off"),
        None if frame.params.light.color() == Vec3::ZERO => Outcome::Skipped("the key light is dark"),
        None if any_reduced(frame) => Outcome::Skipped("only far fur layers are drawn, lit from the package"),
        None => Outcome::Skipped("no fur is drawn"),
    }
}
