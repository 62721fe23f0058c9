//! `skin`: the opaque base mesh, bare parts included, into the application's colour target with depth written.

use crate::Style;
use crate::instance::Instance;
use crate::passes::surface::{SurfaceKey, SurfaceShader, surface_wgsl};
use crate::renderer::Pipelines;

/// The shader.
pub(crate) const WGSL: &str = surface_wgsl!("skin.wgsl");

/// Pipelines of the model's parts, in their order.
pub(crate) fn plan(
    device: &wgpu::Device,
    pipelines: &mut Pipelines,
    instance: &Instance,
    mirrored: bool,
    style: Style,
) -> Vec<wgpu::RenderPipeline> {
    let model = instance.model();
    let mut plan = Vec::new();
    for part in model.parts() {
        let furred = part.furred && style == Style::Fur;
        plan.push(pipelines.surface(
            device,
            SurfaceKey {
                shader: if furred { SurfaceShader::SkinFurred } else { SurfaceShader::SkinBare },
                base_color_texture: part.has_texture,
                planar_directions: model.planar_directions(),
                double_sided: part.double_sided,
                mirrored,
            },
        ));
    }
    plan
}

/// Records the draws of one instance; group 0 and the vertex buffers are set.
pub(crate) fn record(pass: &mut wgpu::RenderPass<'_>, instance: &crate::frame::Drawn) {
    for (part, pipeline) in instance.model.parts().iter().zip(&instance.skin) {
        pass.set_pipeline(pipeline);
        pass.set_bind_group(1, &part.material, &[]);
        pass.draw_indexed(part.indices.clone(), 0, 0..1);
    }
}
