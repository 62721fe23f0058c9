//! The way through bake, top to bottom; no mathematics in here.

use crate::BakeError;
use crate::groom::{self, Lengths};
use crate::hair::{self, VolumeParams};
use crate::mesh::{Model, RestPose};
use crate::pack::{self, Pieces};
use crate::recipe::{Recipe, Style};
use crate::surface::{self, Measures, SurfaceParams};
use crate::textures;
use pelage_formats::{FurInfo, Shading};

/// The stages after `import`, in order; what a progress display counts.
pub const STAGES: [&str; 6] = ["surface", "simulate", "slice", "groom", "textures", "pack"];

/// A finished bake.
#[derive(Clone, Debug)]
pub struct Baked {
    /// The package.
    pub package: Vec<u8>,
    /// Quality of the parameterization.
    pub measures: Measures,
    /// What was repaired, left out or guessed.
    pub warnings: Vec<String>,
}

/// Bakes an imported model.
///
/// * `file`: the model as the user named it, for messages
/// * `name`: its name in the package
/// * `on_stage`: called with the name of each of [`STAGES`] as it begins
pub fn bake(
    file: &str,
    name: &str,
    model: &Model,
    recipe: &Recipe,
    on_stage: &mut dyn FnMut(&'static str),
) -> Result<Baked, BakeError> {
    recipe.validate()?;
    let mut warnings = model.warnings.clone();

    on_stage("surface");
    let rest = RestPose::of(&model.mesh, model.animation.as_ref());
    let bounds = groom::bounds(&rest);
    let furred = groom::furred_materials(&model.materials, &recipe.model.bare, &mut warnings);
    let lengths = Lengths::resolve(recipe.hair.length_m, recipe.surface.tile_size_m, &bounds);
    let surface_params = SurfaceParams::from_recipe(&recipe.surface, lengths.tile_size_m, furred.clone());
    let surface = surface::parameterize(file, model, &surface_params)?;
    warnings.extend(surface.warnings.iter().cloned());

    on_stage("simulate");
    let volume = VolumeParams { height: lengths.length_m / lengths.tile_size_m };
    let strands = hair::simulate(&recipe.hair, &recipe.color, &volume)?;

    on_stage("slice");
    let shells = textures::shell_textures(&strands, &recipe.slice, &recipe.pack)?;

    on_stage("groom");
    let height_m = strands.height * lengths.tile_size_m;
    let fur_heights = groom::fur_heights(&surface.mesh, &furred, height_m);

    on_stage("textures");
    let base_colors =
        model.images.iter().map(|i| textures::encode_base_color(i, &recipe.pack)).collect::<Result<Vec<_>, _>>()?;

    on_stage("pack");
    let shading = Shading::from(&recipe.shading);
    let package = pack::pack(&Pieces {
        name,
        model,
        surface: &surface,
        furred: &furred,
        fur_heights: &fur_heights,
        bounds,
        fur: FurInfo {
            layers: recipe.slice.layers,
            tile_texels: recipe.slice.tile_texels,
            tile_size_m: lengths.tile_size_m,
            height_m,
            strands: recipe.hair.density,
            patches: surface.measures.patches,
            ..FurInfo::default()
        },
        shading: if recipe.hair.style == Style::Wet { shading.wet() } else { shading },
        base_color: recipe.color.base_color,
        recipe: &resolved(recipe, lengths),
        shell_color: &shells.color,
        shell_direction: &shells.direction,
        base_colors: &base_colors,
        warnings: &warnings,
    })?;
    Ok(Baked { package, measures: surface.measures, warnings })
}

/// The recipe with everything that was left open filled in.
fn resolved(recipe: &Recipe, lengths: Lengths) -> String {
    let mut recipe = recipe.clone();
    recipe.hair.length_m = Some(lengths.length_m);
    recipe.surface.tile_size_m = Some(lengths.tile_size_m);
    recipe.to_toml()
}
