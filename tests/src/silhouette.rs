//! Models whose silhouettes are measured ([`pelage_bake::stability::silhouette`]), and the pictures that it asks for.

use crate::binary::{data, workspace};
use crate::pictures::draw_passes;
use crate::support::headless::Gpu;
use pelage_bake::import::ImportOptions;
use pelage_bake::io;
use pelage_bake::recipe::Recipe;
use pelage_bake::stability::Drawing;
use pelage_bake::stability::silhouette::{self, Measured, Packages};
use pelage_runtime::{Instance, Model, Renderer, RendererOptions, wgpu};
use std::path::PathBuf;

/// IEEE 754 binary16, little-endian; normal numbers and zero.
pub fn half_to_f32(bytes: [u8; 2]) -> f32 {
    let bits = u32::from(u16::from_le_bytes(bytes));
    if bits & 0x7fff == 0 {
        return 0.0;
    }
    f32::from_bits(((bits & 0x8000) << 16) | (((bits & 0x7fff) << 13) + (112 << 23)))
}

/// Opacity of every pixel of a drawing, in 16-bit floats: 8 bits lose what thin layers add.
pub fn opacities(gpu: &Gpu, drawing: &Drawing<'_>) -> Vec<f32> {
    let options = RendererOptions { color_format: wgpu::TextureFormat::Rgba16Float, ..RendererOptions::default() };
    let mut renderer = Renderer::new(&gpu.device, &gpu.queue, &options).expect("the options are valid");
    let model: Model = renderer.load_bytes(&gpu.device, &gpu.queue, drawing.package).expect("the package loads");
    let mut instance = Instance::new(&model);
    let Drawing { params, size, passes, .. } = *drawing;
    let texels = draw_passes(gpu, &mut renderer, size, params, &mut [&mut instance], passes);
    texels.chunks_exact(8).map(|texel| half_to_f32([texel[6], texel[7]])).collect()
}

/// A model to be measured.
#[derive(Clone, Debug)]
pub struct Case {
    /// For messages.
    pub name: &'static str,
    /// The model.
    pub model: PathBuf,
    /// Path of its recipe from the workspace's root; `None` for the default.
    pub recipe: Option<&'static str>,
    /// Size of the picture, pixels.
    pub size: (u32, u32),
}

/// The project's own models, and the bunny where the test data are there.
pub fn cases() -> Vec<Case> {
    let own = |name: &'static str, recipe, size| {
        let model = workspace().join(format!("assets/models/{name}.glb"));
        Case { name, model, recipe: Some(recipe), size }
    };
    let mut cases = vec![
        own("hare", "assets/recipes/hare.toml", (834, 424)),
        own("torus", "assets/recipes/torus.toml", (200, 200)),
        own("knot", "assets/recipes/knot.toml", (200, 200)),
    ];
    if let Some(data) = data() {
        let model = data.join("meshes/static/bunny.obj");
        cases.push(Case { name: "bunny", model, recipe: None, size: (400, 400) });
    }
    cases
}

/// Measures a model from its front left.
pub fn measure(gpu: &Gpu, case: &Case) -> Measured {
    let mut recipe = Recipe::default();
    if let Some(path) = case.recipe {
        let text = std::fs::read_to_string(workspace().join(path)).expect("the recipe is there");
        recipe = Recipe::parse(path, &text).expect("the recipe reads");
    }
    let model = io::read_model(&case.model, &ImportOptions { unit_m: recipe.model.unit_m }).expect("the model reads");
    let packages = Packages::bake(&case.model.display().to_string(), &model, &recipe).expect("the model bakes");
    let mut draw = |drawing: &Drawing<'_>| Ok(opacities(gpu, drawing));
    silhouette::measure(&packages, case.size, &mut draw).expect("every picture can be drawn")
}
