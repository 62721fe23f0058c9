//! Stage `surface`: lays out the hair tile on a model according to the recipe, the shape of the body and the comb lines
//! in the model. It records the values that it chooses because the recipe leaves them open.

use super::input::BakeInput;
use crate::decision::Decision;
use crate::recipe::{self, ColorParams, CombSource, GroomCoordinates, HairColors, Recipe, SrgbColor, SurfaceSource};
use crate::stages::groom::{
    self, Body, BodyGroom, BodyHead, FurredMaterials, HeadShape, ImageCoordinates, JointValues, LayoutMaps, Lengths,
    Maps, MarkValues, ModelAtlas,
};
use crate::stages::metric::{self, TileRecipe};
use crate::stages::rounding::rounded;
use crate::stages::size;
use crate::stages::surface::{self, Comb, Surface, SurfaceParams};
use glam::Vec3;
use pelage_formats::Bounds;
use pelage_import::BakeError;
use pelage_import::mesh::{CombLine, Model, RestPose};
use std::collections::BTreeSet;
use std::sync::Arc;

/// Output of the `surface` stage.
#[derive(Clone, Debug)]
pub struct Layout<'a> {
    /// Model with the materials that `model.bare` splits along nodes and joints, and with coarse furred surface
    /// rounded; `None` if neither changes the imported model.
    changed: Option<Arc<Model>>,
    /// Mesh with hair-tile coordinates.
    pub surface: Surface,
    /// Box and sphere around the mesh at rest.
    pub bounds: Bounds,
    /// Whether hair grows on each material.
    pub furred: Vec<bool>,
    /// Effective value of `model.bare`: the recipe's or the chosen one.
    pub bare: Vec<String>,
    /// Lengths from the recipe. Those that it leaves open have the chosen values.
    pub lengths: Lengths,
    /// Recipe with hair density and radii converted to tile units.
    pub filled: Recipe,
    /// Hair colours from the recipe. Those that it leaves open have the chosen values.
    pub hair_colors: HairColors,
    /// Groom maps of the recipe.
    pub maps: Maps<'a>,
    /// Density and comb direction from the groom maps, at the model's vertices.
    pub lay: LayoutMaps,
    /// Head with a snout; `None` if none is known.
    pub head: Option<HeadShape>,
    /// Values that the recipe left open and the bake chose.
    pub decisions: Vec<Decision>,
    /// Warnings of `import` and of this stage.
    pub warnings: Vec<String>,
}

impl Layout<'_> {
    /// Returns the model that was laid out. `imported`: the model that the layout was made from.
    pub fn model<'m>(&'m self, imported: &'m Model) -> &'m Model {
        self.changed.as_deref().unwrap_or(imported)
    }
}

/// Runs the first stage alone: lays out the hair tile on a model.
///
/// Fails with the errors of [`bake`](super::bake()) that this stage can raise.
pub fn lay_out_model<'a>(input: &BakeInput<'a>, model: &Model) -> Result<Layout<'a>, BakeError> {
    let BakeInput { file, recipe, images, progress, .. } = *input;
    let split = recipe.model.bare.as_deref().and_then(|bare| groom::split_listed(model, bare)).map(Arc::new);
    let model = split.as_deref().unwrap_or(model);
    let mut warnings = [&model.warnings[..], &images.warnings].concat();
    let rest = RestPose::of(&model.mesh, model.animation.as_ref());
    let FurredMaterials { furred, bare, decision } =
        groom::find_furred_materials(model, &rest, recipe.model.bare.as_deref(), &mut warnings);
    let rounded = recipe
        .surface
        .rounded
        .then(|| rounded(model, &furred, &rest, groom::bounds(&rest).radius))
        .flatten()
        .map(Arc::new);
    let of_rounding = rounded.as_deref().map(|finer| rounding_decision(model, finer));
    let model = rounded.as_deref().unwrap_or(model);
    let rest = if rounded.is_some() { RestPose::of(&model.mesh, model.animation.as_ref()) } else { rest };
    let bounds = groom::bounds(&rest);
    let animation = model.animation.as_ref();
    let body = Body { mesh: &model.mesh, rest: &rest, animation, furred: &furred, bounds: &bounds };
    let mut by_body = BodyGroom::of(&body, recipe.groom.by_body, Lengths::resolve(recipe, &bounds).length_m);
    if recipe.surface.source == SurfaceSource::Model {
        // With the model's own texture coordinates, the density follows from them and cannot be chosen.
        by_body.iter_mut().for_each(|body| body.density = None);
    }
    let maps = Maps::new(&model.mesh, &model.materials, &furred, &recipe.groom, images, &mut warnings)
        .with_joints(JointValues::new(&recipe.groom.joint, animation, &mut warnings))
        .with_body(by_body)
        .with_marks(MarkValues::new(&recipe.surface.comb_marks, &model.combs, &body, &mut warnings));
    let maps = match (recipe.groom.coordinates, recipe.groom.coordinates.projection()) {
        (_, Some(along)) => maps.over(ImageCoordinates::Space { along, bounds }),
        (GroomCoordinates::Atlas, None) if maps.has_images() => {
            maps.over(ImageCoordinates::Atlas(Box::new(ModelAtlas::new(file, model)?)))
        }
        _ => maps,
    };
    let TileRecipe { recipe: filled, decisions: of_tile, warnings: of_hair } = metric::to_tile_units(recipe, &bounds)?;
    warnings.extend(of_hair);
    let lengths = Lengths::resolve(&filled, &bounds);
    let colored = groom::is_colored(model, &maps, &furred, &recipe.color);
    // Without any colour source, hair gets a brown root and tip colour, which would tint the colours of comb marks. If
    // comb marks have colours, brown becomes the base colour instead.
    let plain = maps.marks().has_color() && !colored && recipe.color.root.is_none() && recipe.color.tip.is_none();
    let (maps, colored) = if plain { (maps.with_plain_color(HairColors::PLAIN), true) } else { (maps, colored) };
    let mut decisions: Vec<Decision> =
        decision.into_iter().chain(of_rounding).chain(lengths.decisions(&filled)).chain(of_tile).collect();
    if plain {
        decisions.push(Decision {
            what: "colour of hair without comb marks",
            chosen: "brown, because the model has no colours".into(),
            line: format!("groom.color = {}", in_toml(HairColors::PLAIN)),
        });
    }
    let open = match (colored, recipe.shading.scatters()) {
        (true, false) => HairColors::NEUTRAL,
        (true, true) => HairColors::SCATTERING,
        (false, _) => HairColors::BROWN,
    };
    let pigmented = recipe.fibre.pigmented();
    let hair_colors = recipe.color.hair(pigmented.unwrap_or(open));
    decisions.extend(maps.decision(recipe.groom.by_body, lengths.length_m));
    let why = match (plain, colored) {
        _ if pigmented.is_some() => "from the pigments fibre.eumelanin and fibre.pheomelanin",
        (true, _) => "neutral, because comb marks colour the hair",
        (_, true) => "neutral, because the model's own colours show",
        _ => "brown, because the model has no colours",
    };
    decisions.extend(hair_color_decisions(&recipe.color, hair_colors, why));
    size::check(file, recipe, &bounds, &lengths)?;
    if furred.contains(&true) {
        size::check_hair(recipe, &bounds, &lengths)?;
    }
    let params = SurfaceParams::from_recipe(&filled.surface, lengths.tile_size_m, furred.clone());
    let lay = maps.layout_maps(&model.mesh, &rest, params.comb.global_direction())?;
    if lay != LayoutMaps::default() && recipe.surface.source == SurfaceSource::Model {
        warnings.push("groom.density and groom.comb have no effect with surface.source = \"model\"".into());
    }
    let comb = match lay.comb.clone() {
        Some(wishes) => Comb::PerVertex(wishes),
        None => Comb::of_recipe(&recipe.surface, &model.combs, bounds.radius),
    };
    decisions.extend(comb_decision(&recipe.surface, &comb, &model.combs));
    let head = BodyHead::find(&body);
    let of_head = head.as_ref().filter(|_| is_comb_open(&recipe.surface, &comb));
    let of_head = of_head.map(|head| head.comb(comb.global_direction(), params.comb_smoothing * params.tile_size_m));
    let back = comb.global_direction();
    decisions.extend(of_head.as_ref().map(|(_, elsewhere)| head_decision(Some(*elsewhere).filter(|e| *e != back))));
    let comb = of_head.map_or(comb, |(wishes, _)| Comb::Weighted(wishes));
    let params = SurfaceParams { comb, density: lay.density.clone(), ..params };
    let surface = surface::parameterize_with_progress(file, model, &params, progress)?;
    warnings.extend(size::warnings(recipe, &bounds, &surface.rest.positions, &surface.mesh.triangles));
    warnings.extend(surface.warnings.iter().cloned());
    let head = head.as_ref().map(BodyHead::shape);
    let changed = rounded.or(split);
    Ok(Layout {
        changed,
        head,
        surface,
        bounds,
        furred,
        bare,
        lengths,
        filled,
        hair_colors,
        maps,
        lay,
        decisions,
        warnings,
    })
}

/// Reports that coarse surface was rounded.
fn rounding_decision(model: &Model, finer: &Model) -> Decision {
    let [before, after] = [model, finer].map(|of| of.mesh.triangles.len());
    Decision {
        what: "shape of coarse surface",
        chosen: format!("rounded along its normals, {after} triangles instead of {before}"),
        line: "surface.rounded = true".into(),
    }
}

/// Returns the decision to comb hair along the lines drawn in the model; `None` if the recipe decides, or if there are
/// no lines.
fn comb_decision(params: &recipe::SurfaceParams, comb: &Comb, drawn: &[CombLine]) -> Option<Decision> {
    if params.comb != CombSource::Auto || drawn.is_empty() || !matches!(comb, Comb::Marks { .. }) {
        return None;
    }
    let names: BTreeSet<&str> = drawn.iter().map(|line| line.name.as_str()).collect();
    let names: Vec<&str> = names.into_iter().collect();
    Some(Decision {
        what: "direction of combing",
        chosen: format!(
            "along the comb lines of the model ({}); surface.comb = \"direction\" ignores \
             them",
            names.join(", ")
        ),
        line: format!("surface.comb = \"{}\"", CombSource::Marks.word()),
    })
}

/// Whether neither recipe nor model says anything about the direction of combing.
fn is_comb_open(params: &recipe::SurfaceParams, comb: &Comb) -> bool {
    let untouched = params.comb_direction == recipe::SurfaceParams::default().comb_direction;
    let has_patches = params.source != SurfaceSource::Model;
    params.comb == CombSource::Auto && untouched && has_patches && matches!(comb, Comb::Direction(_))
}

/// Reports that the head is combed away from the tip of its nose.
///
/// * `turned`: comb direction of the rest of the body, if it differs from that of the recipe
fn head_decision(turned: Option<Vec3>) -> Decision {
    // Adding zero turns -0 into +0.
    let rounded = |v: f32| (100.0 * v).round() / 100.0 + 0.0;
    let [x, y, z] = turned.unwrap_or_default().to_array().map(rounded);
    let body = turned.map_or(String::new(), |_| format!(", and on the body along {x},{y},{z}"));
    let like = if turned.is_some() { "ignores the head" } else { "combs it like the body" };
    Decision {
        what: "direction of combing on the head",
        chosen: format!("from the tip of the nose to the neck{body}; surface.comb = \"direction\" {like}"),
        line: format!("surface.comb = \"{}\"", CombSource::Auto.word()),
    }
}

/// Formats a built-in colour for a recipe. Its components are multiples of 1/255.
fn in_toml(color: SrgbColor) -> String {
    let [r, g, b] = color.0.map(|c| (255.0 * c).round() as u8);
    format!("\"#{r:02x}{g:02x}{b:02x}\"")
}

/// Returns a decision for each hair colour that `color` leaves open. `why` is the reason for the choice.
fn hair_color_decisions(color: &ColorParams, hair: HairColors, why: &'static str) -> impl Iterator<Item = Decision> {
    let open = [
        (
            "lightness of hair",
            "gain",
            color.gain.is_none() && color.root.is_none() && color.tip.is_none(),
            hair.gain.to_string(),
        ),
        ("colour at the root", "root", color.root.is_none(), in_toml(hair.root)),
        ("colour at the tip", "tip", color.tip.is_none(), in_toml(hair.tip)),
    ];
    open.into_iter().filter(|(.., is_open, _)| *is_open).map(move |(what, key, _, value)| Decision {
        what,
        chosen: why.into(),
        line: format!("color.{key} = {value}"),
    })
}
