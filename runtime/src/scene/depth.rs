//! Depth passes of the opaque mesh, seen from the key light, and render passes into the light's maps.

use super::recording::Recording;
use super::visible_instance::VisibleInstance;
use crate::camera::Light;
use crate::gpu::{Draw, RenderSpec, Shader, depth_state, primitive_state, record};
use crate::hair::cutout_constants;
use crate::light::{CasterPass, ShadowMaps};
use crate::model::Part;
use crate::surface::STREAMS;

pub(crate) const DEPTH: Shader = Shader {
    name: "pelage casters",
    parts: &[
        include_str!("../shared/frame.wgsl"),
        include_str!("../shared/skinning.wgsl"),
        include_str!("../shared/tile_frame.wgsl"),
        include_str!("../surface/place.wgsl"),
        include_str!("../light/casters.wgsl"),
    ],
};

/// Target of a render pass into the key light's maps.
pub(crate) enum MapTarget<'a> {
    /// Colour target, cleared to full light (white).
    Light(&'a wgpu::TextureView),
    /// Colour target with its contents kept, and a read-only depth map: only fragments in front of it are drawn.
    LightBefore { light: &'a wgpu::TextureView, nearest: &'a wgpu::TextureView },
    /// Depth target, cleared to the initial value for the caster pass.
    Depth(&'a wgpu::TextureView, CasterPass),
}

/// Begins a render pass into the key light's maps.
pub(crate) fn begin_maps<'e>(
    encoder: &'e mut wgpu::CommandEncoder,
    label: &str,
    target: MapTarget<'_>,
) -> wgpu::RenderPass<'e> {
    let texels = |view, load| {
        let ops = wgpu::Operations { load, store: wgpu::StoreOp::Store };
        [Some(wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target: None, ops })]
    };
    // Without operations, wgpu treats a depth buffer as read-only.
    let depth = |view, depth_ops| wgpu::RenderPassDepthStencilAttachment { view, depth_ops, stencil_ops: None };
    let white = wgpu::LoadOp::Clear(wgpu::Color::WHITE);
    let (colors, depth) = match target {
        MapTarget::Light(view) => (Some(texels(view, white)), None),
        MapTarget::LightBefore { light, nearest } => {
            (Some(texels(light, wgpu::LoadOp::Load)), Some(depth(nearest, None)))
        }
        MapTarget::Depth(view, pass) => {
            let ops = wgpu::Operations { load: wgpu::LoadOp::Clear(pass.clear()), store: wgpu::StoreOp::Store };
            (None, Some(depth(view, Some(ops))))
        }
    };
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some(label),
        color_attachments: colors.as_ref().map_or(&[], |c| &c[..]),
        depth_stencil_attachment: depth,
        ..Default::default()
    })
}

fn depth_draws(frame: &mut Recording<'_>, seen: &VisibleInstance, kind: CasterPass) -> Vec<Draw> {
    // Back faces also cast shadows.
    let both = kind == CasterPass::Nearest;
    let spec = |frame: &Recording<'_>, part: &Part| RenderSpec {
        shader: DEPTH,
        vertex: "vs_caster",
        // A depth-only pass needs no fragment shader, unless the material has cutouts.
        fragment: part.cutout.then_some("fs_caster"),
        groups: vec![frame.surfaces.frame.clone(), frame.surfaces.material.clone()],
        streams: STREAMS.to_vec(),
        constants: cutout_constants(part),
        primitive: primitive_state(seen.look.mirrored && !both, part.double_sided || both),
        colors: Vec::new(),
        depth: Some(depth_state(ShadowMaps::DEPTH_FORMAT, true, kind.compare())),
        samples: 1,
    };
    frame.part_draws(seen, |_| true, [frame.light_group(seen), None], 0..1, spec)
}

/// Records one of the depth maps, including the application's casters.
pub(crate) fn record_depth(frame: &mut Recording<'_>, maps: &ShadowMaps, kind: CasterPass) {
    let depth = match (kind, &maps.width) {
        (CasterPass::Nearest, _) => &maps.nearest.view,
        (CasterPass::Farthest, Some(width)) => &width.farthest.view,
        (CasterPass::Farthest, None) => return,
    };
    let mut draws = Vec::new();
    for seen in frame.instances.clone().iter() {
        draws.extend(depth_draws(frame, seen, kind));
    }
    let mut pass = begin_maps(frame.encoder, "pelage casters", MapTarget::Depth(depth, kind));
    record(&mut pass, &draws);
    if let Some(casters) = &mut frame.casters {
        (casters.draw)(&mut pass, maps.view(), kind);
    }
}

/// Returns a remark for the report if the light is inside the scene, where its maps cannot cover all of it.
pub(crate) fn light_inside_remark(maps: &ShadowMaps) -> &'static str {
    let sphere = maps.view().sphere;
    match maps.key.light {
        Light::Point { position, .. } if position.distance(sphere.center) < sphere.radius => {
            "; the light is inside the scene, so the maps cover only the side towards its centre"
        }
        _ => "",
    }
}
