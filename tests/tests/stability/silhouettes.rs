//! Draws the pictures that `pelage_lab::stability` requests. This code is not in the library of this package, because
//! bake provides the pictures only with the feature `preview`.

use pelage_lab::stability::Drawing;
use pelage_runtime::{Instance, Model, Renderer, RendererOptions, wgpu};
use pelage_stage::Gpu;
use pelage_tests::pictures::draw_passes;
use pelage_tests::silhouette::half_to_f32;

/// Draws and returns all pixels in 16-bit floats; 8 bits would lose the contribution of thin layers.
pub fn texels(gpu: &Gpu, drawing: &Drawing<'_>) -> Vec<[f32; 4]> {
    let options = RendererOptions { color_format: wgpu::TextureFormat::Rgba16Float, ..RendererOptions::default() };
    let mut renderer = Renderer::new(&gpu.device, &gpu.queue, &options).expect("the options are valid");
    let model: Model = renderer.load_bytes(drawing.package).expect("the package loads");
    let params = drawing.params.clone().with(|p| p.viewport = drawing.size.into());
    let texels = draw_passes(gpu, &mut renderer, &params, &[&Instance::new(0, &model).at(drawing.at)], drawing.passes);
    let texel = |t: &[u8]| [0, 2, 4, 6].map(|i| half_to_f32([t[i], t[i + 1]]));
    texels.chunks_exact(8).map(texel).collect()
}
