//! Models for measurements of silhouettes.

use crate::binary::{Sandbox, workspace};
use pelage_needs::data;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// Converts an IEEE 754 binary16 number, little-endian.
pub fn half_to_f32(bytes: [u8; 2]) -> f32 {
    half::f16::from_le_bytes(bytes).to_f32()
}

/// Model to be measured.
#[derive(Clone, Debug)]
pub struct SilhouetteModel {
    /// Name of the model, for messages.
    pub name: &'static str,
    /// Path of the model.
    pub model: PathBuf,
    /// Path of the recipe, relative to the workspace root; `None` uses default settings.
    pub recipe: Option<&'static str>,
    /// Size of the picture, pixels.
    pub size: (u32, u32),
}

/// Returns the project's own models. If the test data is available to the named test, the bunny is included.
pub fn silhouette_models(test: &str) -> Vec<SilhouetteModel> {
    let own = |name: &'static str, recipe, size| {
        let model = workspace().join(format!("assets/models/{name}.glb"));
        SilhouetteModel { name, model, recipe: Some(recipe), size }
    };
    let mut cases = vec![
        own("hare", "assets/recipes/hare.toml", (834, 424)),
        own("torus", "assets/recipes/torus.toml", (200, 200)),
        own("knot", "assets/recipes/knot.toml", (200, 200)),
    ];
    if let Some(data) = data(test) {
        let model = data.join("meshes/static/bunny.obj");
        cases.push(SilhouetteModel { name: "bunny", model, recipe: None, size: (400, 400) });
    }
    cases
}

/// Bakes a package with uncompressed texels.
///
/// `recipe`: path relative to the workspace root; `set`: assignments to recipe keys.
pub fn bake_plain(model: &Path, recipe: Option<&str>, set: &[&str]) -> Vec<u8> {
    let sandbox = Sandbox::new();
    let mut args: Vec<OsString> =
        [model.as_os_str(), "-q".as_ref(), "-o".as_ref(), "a.pelage".as_ref()].map(Into::into).into();
    if let Some(path) = recipe {
        args.extend(["--recipe".into(), workspace().join(path).into()]);
    }
    // Uncompressed texels exclude compression errors from the measurement.
    let plain = ["pack.shell_format=rgba8", "pack.direction_format=rg8", "pack.base_color_format=rgba8"];
    args.extend(plain.iter().chain(set).flat_map(|set| ["--set".into(), set.into()]));
    sandbox.fixture(&args);
    sandbox.read("a.pelage")
}
