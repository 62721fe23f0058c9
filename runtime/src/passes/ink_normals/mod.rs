//! `ink_normals`: the model's surface into three textures of the picture's size: normals perpendicular to the view with 1 / clip w, what the surface
//! says of wash and lines, and depth. All that the ink style knows of geometry is in them, so that the passes behind it cost the same for any mesh.

use super::draw_part;
use super::ink::{Recording, ink_surface_wgsl};

/// The shader.
pub(crate) const WGSL: &str = ink_surface_wgsl!("ink_normals.wgsl");

/// What it draws to.
pub(crate) struct Targets<'a> {
    pub(crate) normals: &'a wgpu::TextureView,
    pub(crate) surfaces: &'a wgpu::TextureView,
    pub(crate) depth: &'a wgpu::TextureView,
}

/// White, without stroke and without lines.
const NOTHING: wgpu::Color = wgpu::Color { r: 1.0, g: 1.0, b: 0.0, a: 0.0 };

/// Records the draws of all instances.
pub(crate) fn record(
    encoder: &mut wgpu::CommandEncoder,
    targets: &Targets<'_>,
    recording: &Recording<'_>,
    reversed_depth: bool,
) {
    let cleared = |view, color| {
        let ops = wgpu::Operations { load: wgpu::LoadOp::Clear(color), store: wgpu::StoreOp::Store };
        Some(wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target: None, ops })
    };
    let far = if reversed_depth { 0.0 } else { 1.0 };
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("pelage ink normals"),
        color_attachments: &[cleared(targets.normals, wgpu::Color::TRANSPARENT), cleared(targets.surfaces, NOTHING)],
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: targets.depth,
            depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(far), store: wgpu::StoreOp::Store }),
            stencil_ops: None,
        }),
        ..Default::default()
    });
    for instance in recording.instances {
        let (Some(draws), Some(ink)) = (&instance.ink, instance.model.ink()) else { continue };
        instance.bind(&mut pass, recording.frame);
        pass.set_bind_group(2, draws.group(), &[]);
        pass.set_vertex_buffer(2, instance.model.geometry().slice(..));
        pass.set_vertex_buffer(3, ink.vertices.slice(..));
        for (part, pipeline) in draws.normals() {
            draw_part(&mut pass, &instance.model.parts()[*part], pipeline, 0..1);
        }
    }
}
