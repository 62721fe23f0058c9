//! The way through bake, top to bottom; no mathematics in here.

use crate::BakeError;
use crate::mesh::{Image, Model, RestPose};
use crate::recipe::{PackParams, Recipe, Style, SurfaceSource};
use crate::stages::detail;
use crate::stages::fins;
use crate::stages::groom::{self, Atlas, Lay, Lengths, MapImages, Maps, Pattern};
use crate::stages::hair::TileHair;
use crate::stages::ink::{self, Canvas, Ink};
use crate::stages::pack::{self, Pieces};
use crate::stages::surface::{self, Comb, Measures, Surface, SurfaceParams};
use crate::stages::textures;
use pelage_formats::{Bounds, FurInfo, Shading};

/// The stages after `import`, in order; what a progress display counts.
pub const STAGES: [&str; 8] = ["surface", "simulate", "slice", "groom", "fins", "ink", "textures", "pack"];

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

/// What the `surface` stage leaves behind.
#[derive(Clone, Debug)]
pub struct Laid<'a> {
    /// The mesh with its hair-tile coordinates.
    pub surface: Surface,
    /// Box and sphere about the skin at rest.
    pub bounds: Bounds,
    /// One per material: whether hair grows on it.
    pub furred: Vec<bool>,
    /// Lengths that the recipe may leave open.
    pub lengths: Lengths,
    /// The recipe's groom maps.
    pub maps: Maps<'a>,
}

/// The first stage alone: lays the hair's tile on a model. Arguments as for [`bake`].
///
/// # Errors
///
/// As [`bake`], as far as this stage goes.
pub fn lay<'a>(
    file: &str,
    model: &Model,
    recipe: &'a Recipe,
    images: &'a MapImages,
    warnings: &mut Vec<String>,
) -> Result<Laid<'a>, BakeError> {
    let rest = RestPose::of(&model.mesh, model.animation.as_ref());
    let bounds = groom::bounds(&rest);
    let furred = groom::furred_materials(&model.materials, &recipe.model.bare, warnings);
    let maps = Maps::new(&model.mesh, &model.materials, &furred, &recipe.groom, images, warnings);
    let lengths = Lengths::resolve(recipe.hair.length_m, recipe.surface.tile_size_m, &bounds);
    let params = SurfaceParams::from_recipe(&recipe.surface, lengths.tile_size_m, furred.clone());
    let lay = maps.lay(&model.mesh, &rest, params.comb.everywhere())?;
    if lay != Lay::default() && recipe.surface.source == SurfaceSource::Model {
        warnings.push("groom.density and groom.comb have no effect beside surface.source = \"model\"".into());
    }
    let comb = lay.comb.map_or(params.comb, Comb::PerVertex);
    let params = SurfaceParams { comb, density: lay.density, ..params };
    let surface = surface::parameterize(file, model, &params)?;
    warnings.extend(surface.warnings.iter().cloned());
    Ok(Laid { surface, bounds, furred, lengths, maps })
}

/// Bakes an imported model.
///
/// * `file`: the model as the user named it, for messages
/// * `name`: its name in the package
/// * `images`: the images that the recipe names
/// * `on_stage`: called with the name of each of [`STAGES`] as it begins
pub fn bake(
    file: &str,
    name: &str,
    model: &Model,
    recipe: &Recipe,
    images: &MapImages,
    on_stage: &mut dyn FnMut(&'static str),
) -> Result<Baked, BakeError> {
    recipe.validate()?;
    let mut warnings = model.warnings.clone();

    on_stage("surface");
    let Laid { mut surface, bounds, furred, lengths, maps } = lay(file, model, recipe, images, &mut warnings)?;

    on_stage("simulate");
    let TileHair { strands, wet: wet_strands, style } = TileHair::grow(recipe, lengths, maps.water())?;

    on_stage("slice");
    let with_coat = detail::has_coat(recipe);
    let slice = |strands| textures::shell_textures(strands, &recipe.slice, &recipe.pack, with_coat);
    let shells = slice(&strands)?;
    let wet_shells = wet_strands.as_ref().map(slice).transpose()?;

    on_stage("groom");
    let pattern = Pattern::new(&recipe.color, images, &bounds)?;
    let atlas = pattern.is_some().then(|| Atlas::new(&mut surface, recipe.color.pattern_texels)).transpose()?;
    warnings.extend(atlas.as_ref().and_then(Atlas::warning));
    let coat = maps.coat(&surface.mesh)?;
    let mut colors = groom::colors(model, &surface.mesh, &maps, &furred, recipe.color.base_color)?;
    let mut grooms = maps.textures()?;
    if let (Some(pattern), Some(atlas)) = (&pattern, &atlas) {
        pattern.paint(atlas, &furred, &mut surface, &mut colors, &mut grooms);
    }

    on_stage("fins");
    let height_m = strands.height * lengths.tile_size_m;
    let fins = fins::fins(&surface, &furred, &coat, height_m, lengths.tile_size_m);
    let depth = recipe.fins.depth.unwrap_or(fins.depth);
    let fin_textures = if recipe.fins.enabled && !fins.fins.is_empty() {
        Some(textures::fin_textures(&strands, depth, &recipe.slice, &recipe.pack)?)
    } else {
        None
    };

    on_stage("ink");
    let ink = if recipe.ink.enabled {
        let (mesh, rest, radius) = (&surface.mesh, &surface.rest, bounds.radius);
        let canvas = Canvas { mesh, rest, radius, materials: &model.materials, images };
        let coated = furred.contains(&true).then_some(&strands);
        Some(ink::ink(&recipe.ink, &recipe.pack, &canvas, coated, &mut warnings)?)
    } else {
        None
    };

    on_stage("textures");
    let encode = |images: &[Image], encode: fn(&Image, &PackParams) -> Result<Vec<u8>, BakeError>| {
        images.iter().map(|image| encode(image, &recipe.pack)).collect::<Result<Vec<_>, _>>()
    };
    let base_colors = encode(&colors.images, textures::encode_base_color)?;
    let groom_textures = encode(&grooms.images, textures::encode_groom)?;

    on_stage("pack");
    let shading = Shading::from(&recipe.shading);
    let package = pack::pack(&Pieces {
        name,
        model,
        inputs: &[&model.inputs[..], &images.inputs[..]].concat(),
        surface: &surface,
        furred: &furred,
        coat: &coat,
        colors: &colors,
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
        shading: if style == Style::Wet { shading.wet() } else { shading },
        recipe: &resolved(recipe, lengths, depth, pattern.as_ref().map(Pattern::width_m), ink.as_ref()),
        shells: &shells,
        wet_shells: wet_shells.as_ref(),
        fins: fin_textures.as_ref().map(|textures| (&fins, textures)),
        base_colors: &base_colors,
        groom_textures: &groom_textures,
        groom_of_material: &grooms.of_material,
        ink: ink.as_ref(),
        detail: &detail::levels(&recipe.detail, recipe.slice.layers, shells.coat.as_ref()),
        warnings: &warnings,
    })?;
    Ok(Baked { package, measures: surface.measures, warnings })
}

/// The recipe with everything that was left open filled in.
fn resolved(
    recipe: &Recipe,
    lengths: Lengths,
    fin_depth: f32,
    pattern_size_m: Option<f32>,
    ink: Option<&Ink>,
) -> String {
    let mut recipe = recipe.clone();
    recipe.hair.length_m = Some(lengths.length_m);
    recipe.surface.tile_size_m = Some(lengths.tile_size_m);
    recipe.fins.depth = Some(fin_depth);
    recipe.color.pattern_size_m = pattern_size_m.or(recipe.color.pattern_size_m);
    if let Some(ink) = ink {
        recipe.ink.center = Some(ink.vertices.center.into());
        recipe.ink.grain_size_m = Some(ink.grain_size_m);
    }
    recipe.to_toml()
}
