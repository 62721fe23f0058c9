//! `layer_shadow`: the transmittance of the hair above each layer, seen from the key light, into an array texture (Yang 2006, §3.1).
//!
//! From the outermost layer inwards; each map is made from the one above, straight into its slice, in format R16Float. When it runs
//! and how many maps there are stands in [`crate::ShadowParams`].
//!
//! The paper clears each map to white, draws the nearest surface of a layer and reads the map above. Here a map starts as a copy of the
//! one above, and is multiplied with every surface of the layer that lies before the nearest skin: so the fringe of fur beside a
//! thing's skin shades what is behind it, and no layer needs a depth buffer of its own, which was a fifth of the cost on a software
//! rasteriser.

use super::{MapTarget, begin_maps, draw_part};
use crate::frame::Drawn;
use crate::model::Model;
use crate::passes::key::{Look, SurfaceShader, plan_parts};
use crate::passes::surface::surface_wgsl;
use crate::renderer::Pipelines;
use crate::shadow::ShadowMaps;

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

/// Records all maps. `frame`: group 0 with the light's view; the instances' blocks have the maps' layers; `nearest` is drawn.
pub(crate) fn record(
    encoder: &mut wgpu::CommandEncoder,
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
    let place = |layer| wgpu::TexelCopyTextureInfo {
        origin: wgpu::Origin3d { x: 0, y: 0, z: layer },
        ..texture.as_image_copy()
    };
    let texels = wgpu::Extent3d { depth_or_array_layers: 1, ..texture.size() };
    let depth = maps.nearest.create_view(&wgpu::TextureViewDescriptor::default());
    let outermost = maps.key.map_layers - 1;
    // Nothing is above the outermost layer.
    drop(begin_maps(encoder, "pelage layer shadow", MapTarget::Light(&slice(outermost))));
    for layer in (1..=outermost).rev() {
        // What the layers above left, also where this one is not: its neighbours may be seen through there.
        encoder.copy_texture_to_texture(place(layer), place(layer - 1), texels);
        let target = slice(layer - 1);
        let mut pass =
            begin_maps(encoder, "pelage layer shadow", MapTarget::LightBefore { light: &target, nearest: &depth });
        for instance in instances.iter().filter(|i| !i.layer_shadow.is_empty()) {
            instance.bind(&mut pass, frame);
            for (part, pipeline) in &instance.layer_shadow {
                draw_part(&mut pass, &instance.model.parts()[*part], pipeline, layer..layer + 1);
            }
        }
    }
}
