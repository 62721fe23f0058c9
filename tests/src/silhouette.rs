//! Models whose silhouettes are measured.

use crate::binary::workspace;
use pelage_bake::io::{self, Reach};
use pelage_bake::pipeline::{self, Told};
use pelage_bake::recipe::{Coat, Recipe};
use pelage_bake::stages::groom::MapImages;
use pelage_import::ImportOptions;
use pelage_needs::data;
use std::path::{Path, PathBuf};

/// IEEE 754 binary16, little-endian.
pub fn half_to_f32(bytes: [u8; 2]) -> f32 {
    half::f16::from_le_bytes(bytes).to_f32()
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

/// The project's own models, and the bunny where the test data are there, for the test of that name.
pub fn cases(test: &str) -> Vec<Case> {
    let own = |name: &'static str, recipe, size| {
        let model = workspace().join(format!("assets/models/{name}.glb"));
        Case { name, model, recipe: Some(recipe), size }
    };
    let mut cases = vec![
        own("hare", "assets/recipes/hare.toml", (834, 424)),
        own("torus", "assets/recipes/torus.toml", (200, 200)),
        own("knot", "assets/recipes/knot.toml", (200, 200)),
    ];
    if let Some(data) = data(test) {
        let model = data.join("meshes/static/bunny.obj");
        cases.push(Case { name: "bunny", model, recipe: None, size: (400, 400) });
    }
    cases
}

/// Bakes a model in plain texels.
///
/// `recipe`: path from the workspace's root; `set`: assignments to its keys.
pub fn bake_plain(name: &str, model: &Path, recipe: Option<&str>, set: &[&str]) -> Vec<u8> {
    let mut parsed = Recipe::of_coat(Coat::Natural).expect("the coat is there");
    if let Some(path) = recipe {
        let text = std::fs::read_to_string(workspace().join(path)).expect("the recipe is there");
        parsed = Recipe::parse(path, &text).expect("the recipe reads");
    }
    // Plain texels, so that no error of blocks is counted.
    let plain = ["pack.shell_format=rgba8", "pack.direction_format=rg8", "pack.base_color_format=rgba8"];
    plain.iter().chain(set).for_each(|assignment| parsed.set(assignment).expect("the key exists"));
    let options = ImportOptions { unit_m: parsed.model.unit_m };
    let loaded = io::read_model(model, &options, Reach::OwnFolder).expect("the model reads");
    let file = model.display().to_string();
    pipeline::bake(&Told::new(&file, name, &parsed, &MapImages::default()), &loaded, &mut |_| ())
        .expect("the model bakes")
        .package
}
