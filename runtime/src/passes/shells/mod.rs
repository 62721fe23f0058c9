//! `shells`: layers 1.. of the hair, inside to outside, blended into the application's colour target with depth tested and
//! written (Lengyel 2001; Yang 2006, §2).

use super::draw_part;
use crate::model::Model;
use crate::passes::key::{Look, SurfaceShader, plan_parts};
use crate::passes::surface::surface_wgsl;
use crate::renderer::Pipelines;

/// The shader.
pub(crate) const WGSL: &str = surface_wgsl!("shells.wgsl");

/// Numbers and pipelines of the furred parts.
pub(crate) fn plan(
    device: &wgpu::Device,
    pipelines: &mut Pipelines,
    model: &Model,
    look: &Look,
) -> Vec<(usize, wgpu::RenderPipeline)> {
    let shader = if look.yardstick { SurfaceShader::Yardstick } else { SurfaceShader::Shells };
    plan_parts(device, pipelines, model, look, shader, |part| part.furred)
}

/// Records the draws of one instance; group 0 and the vertex buffers are set.
pub(crate) fn record(pass: &mut wgpu::RenderPass<'_>, instance: &crate::frame::Drawn) {
    let parts = instance.model.parts();
    if let [(part, pipeline)] = &instance.shells[..] {
        // Instances of one draw are drawn in order: all layers at once.
        draw_part(pass, &parts[*part], pipeline, instance.shell_instances.clone());
        return;
    }
    // Several parts may overlap where they meet: layer by layer, so that an outer layer of one never hides an inner of another.
    for index in instance.shell_instances.clone() {
        for (part, pipeline) in &instance.shells {
            draw_part(pass, &parts[*part], pipeline, index..index + 1);
        }
    }
}
