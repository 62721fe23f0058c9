//! `layer_shadow`: the transmittance of the hair above each layer, seen from the key light, into an array texture (Yang 2006, §3.1).
//!
//! From the outermost layer inwards; each map is made from the one above, straight into its slice, in format R16Float. When it runs
//! and how many maps there are stands in [`crate::ShadowParams`].

use super::begin_maps;
use crate::frame::Drawn;
use crate::model::Model;
use crate::passes::surface::{Look, SurfaceShader, plan_parts, surface_wgsl};
use crate::renderer::Pipelines;
use crate::shadow::{CasterPass, ShadowMaps};

/// The shader.
pub(crate) const WGSL: &str = surface_wgsl!("layer_shadow.wgsl");

/// Numbers and pipelines of the furred parts.
pub(crate) fn plan(
    device: &wgpu::Device,
    pipelines: &mut Pipelines,
    model: &Model,
    look: &Look,
) -> Vec<(usize, wgpu::RenderPipeline)> {
    plan_parts(device, pipelines, model, look, SurfaceShader::LayerShadow, |part| part.furred)
}

/// Records all maps. `frame`: group 0 with the light's view; the instances' blocks have the maps' layers.
pub(crate) fn record(
    device: &wgpu::Device,
    encoder: &mut wgpu::CommandEncoder,
    pipelines: &Pipelines,
    maps: &ShadowMaps,
    frame: &wgpu::BindGroup,
    instances: &[Drawn],
) {
    let Some(texture) = maps.layers() else { return };
    let slice = |layer| {
        texture.create_view(&wgpu::TextureViewDescriptor {
            label: Some("pelage layer shadow"),
            dimension: Some(wgpu::TextureViewDimension::D2),
            base_array_layer: layer,
            array_layer_count: Some(1),
            ..Default::default()
        })
    };
    let depth = depth_buffer(device, maps.key.params.map_size);
    let mut above = slice(maps.key.map_layers - 1);
    // Nothing is above the outermost layer.
    drop(begin_maps(encoder, "pelage layer shadow", Some(&above), None));
    for layer in (1..maps.key.map_layers).rev() {
        let target = slice(layer - 1);
        let above_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("pelage layer above"),
            layout: &pipelines.layouts.layer_above,
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(&above) }],
        });
        let mut pass = begin_maps(encoder, "pelage layer shadow", Some(&target), Some((&depth, CasterPass::Nearest)));
        for instance in instances.iter().filter(|i| !i.layer_shadow.is_empty()) {
            instance.bind(&mut pass, frame);
            pass.set_bind_group(3, &above_group, &[]);
            for (part, pipeline) in &instance.layer_shadow {
                let part = &instance.model.parts()[*part];
                pass.set_pipeline(pipeline);
                pass.set_bind_group(1, &part.material, &[]);
                pass.draw_indexed(part.indices.clone(), 0, layer..layer + 1);
            }
        }
        drop(pass);
        above = target;
    }
}

/// Among surfaces of one layer the nearest to the light counts.
fn depth_buffer(device: &wgpu::Device, size: u32) -> wgpu::TextureView {
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("pelage layer shadow depth"),
        size: wgpu::Extent3d { width: size, height: size, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: ShadowMaps::DEPTH_FORMAT,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    });
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}
