//! The pictures that `pelage_lab::stability` asks for. Here and not in the library of this package, because bake has them with the feature
//! `preview` only.

use pelage_lab::stability::Drawing;
use pelage_runtime::{Instance, Model, Renderer, RendererOptions, wgpu};
use pelage_stage::Gpu;
use pelage_tests::pictures::draw_passes;
use pelage_tests::silhouette::half_to_f32;

/// Every pixel of a drawing, in 16-bit floats: 8 bits lose what thin layers add.
pub fn texels(gpu: &Gpu, drawing: &Drawing<'_>) -> Vec<[f32; 4]> {
    let options = RendererOptions { color_format: wgpu::TextureFormat::Rgba16Float, ..RendererOptions::default() };
    let mut renderer = Renderer::new(&gpu.device, &gpu.queue, &options).expect("the options are valid");
    let model: Model = renderer.load_bytes(drawing.package).expect("the package loads");
    let params = drawing.params.clone().with(|p| p.viewport = drawing.size.into());
    let texels = draw_passes(gpu, &mut renderer, &params, &[&Instance::new(0, &model)], drawing.passes);
    let texel = |t: &[u8]| [0, 2, 4, 6].map(|i| half_to_f32([t[i], t[i + 1]]));
    texels.chunks_exact(8).map(texel).collect()
}
