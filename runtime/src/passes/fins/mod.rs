//! `fins`: quads of hair on the edges of the skin, faded by the angle they are seen at (Lengyel 2001), blended into the
//! application's colour target with depth tested and not written. Between `skin` and `shells`.

use crate::Instance;
use crate::model::Model;
use crate::passes::key::{Look, SurfaceShader, plan_parts};
use crate::passes::surface::{SurfaceLayouts, surface_wgsl};
use crate::renderer::Pipelines;

/// The shader.
pub(crate) const WGSL: &str = surface_wgsl!("../fins/fin_corner.wgsl", "fins.wgsl");

/// Vertices of a quad, as in the shader.
pub(crate) const CORNERS: u32 = 6;
/// Quads of a fin where hair leans, as in the shader; elsewhere one.
pub(crate) const LEANING_ROWS: u32 = 3;

/// What an instance draws: its vertices for the shader, and the parts that have fins with their pipelines.
#[derive(Debug)]
pub(crate) struct FinDraws {
    bind_group: wgpu::BindGroup,
    parts: Vec<(usize, wgpu::RenderPipeline)>,
}

/// Numbers and pipelines of the parts with fins.
pub(crate) fn plan(
    device: &wgpu::Device,
    pipelines: &mut Pipelines,
    model: &Model,
    look: &Look,
) -> Vec<(usize, wgpu::RenderPipeline)> {
    plan_parts(device, pipelines, model, look, SurfaceShader::Fins, |part| !part.fins.is_empty())
}

/// The draws of an instance whose posed vertices are there; `None` for a model without fins.
pub(crate) fn draws(
    device: &wgpu::Device,
    pipelines: &mut Pipelines,
    instance: &Instance,
    look: &Look,
) -> Option<FinDraws> {
    let model = instance.model();
    model.fins()?;
    let parts = plan(device, pipelines, model, look);
    bind(device, &pipelines.layouts, instance, parts)
}

/// Planned parts with the vertices that the shader reads; `None` for a model without fins.
pub(crate) fn bind(
    device: &wgpu::Device,
    layouts: &SurfaceLayouts,
    instance: &Instance,
    parts: Vec<(usize, wgpu::RenderPipeline)>,
) -> Option<FinDraws> {
    let model = instance.model();
    let fins = model.fins()?;
    let bind_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("pelage fins"),
        layout: layouts.fins.as_ref()?,
        entries: &[
            wgpu::BindGroupEntry { binding: 0, resource: instance.geometry().as_entire_binding() },
            wgpu::BindGroupEntry { binding: 1, resource: model.attributes().as_entire_binding() },
            wgpu::BindGroupEntry { binding: 2, resource: fins.buffer.as_entire_binding() },
        ],
    });
    Some(FinDraws { bind_group, parts })
}

/// Records the draws of one instance; group 0 is set.
pub(crate) fn record(pass: &mut wgpu::RenderPass<'_>, model: &Model, draws: &FinDraws) {
    record_with(pass, model, draws, model.fins().map(|fins| &fins.textures));
}

/// [`record`] with other textures in group 2.
pub(crate) fn record_with(
    pass: &mut wgpu::RenderPass<'_>,
    model: &Model,
    draws: &FinDraws,
    textures: Option<&wgpu::BindGroup>,
) {
    pass.set_bind_group(2, textures, &[]);
    pass.set_bind_group(3, &draws.bind_group, &[]);
    let vertices = if model.varies().lean { CORNERS * LEANING_ROWS } else { CORNERS };
    for (part, pipeline) in &draws.parts {
        let part = &model.parts()[*part];
        pass.set_pipeline(pipeline);
        pass.set_bind_group(1, &part.material, &[]);
        pass.draw(part.fins.start * vertices..part.fins.end * vertices, 0..1);
    }
}
