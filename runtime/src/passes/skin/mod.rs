//! `skin`: the opaque base mesh, bare parts included, into the application's colour target with depth written.

use super::draw_part;
use crate::Style;
use crate::model::{Model, Part};
use crate::passes::key::{Look, SurfaceShader};
use crate::passes::surface::surface_wgsl;
use crate::renderer::Pipelines;

/// The shader.
pub(crate) const WGSL: &str = surface_wgsl!("skin.wgsl");

/// Pipelines of the model's parts, in their order.
pub(crate) fn plan(
    device: &wgpu::Device,
    pipelines: &mut Pipelines,
    model: &Model,
    look: &Look,
) -> Vec<wgpu::RenderPipeline> {
    let shader = |furred| if furred { SurfaceShader::SkinFurred } else { SurfaceShader::SkinBare };
    let key = |part: &Part| look.key(shader(part.furred && look.style == Style::Fur), model, part);
    model.parts().iter().map(|part| pipelines.surface(device, key(part))).collect()
}

/// Records the draws of one instance; group 0 and the vertex buffers are set.
pub(crate) fn record(pass: &mut wgpu::RenderPass<'_>, instance: &crate::frame::Drawn) {
    for (part, pipeline) in instance.model.parts().iter().zip(&instance.skin) {
        draw_part(pass, part, pipeline, 0..1);
    }
}
