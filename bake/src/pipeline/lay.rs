//! The `surface` stage: how the recipe, the body and the model's own marks lay the hair's tile on a model, and what was chosen where the recipe is silent.

use crate::decision::Decision;
use crate::recipe::{
    self, ColorParams, CombSource, GroomCoordinates, HairColors, Recipe, ShadingModel, SrgbColor, SurfaceSource,
};
use crate::stages::groom::{
    self, Body, BodyGroom, Growth, JointValues, Lay, Lengths, MapImages, Maps, MarkValues, ModelAtlas, Over,
};
use crate::stages::metric::{self, InTile};
use crate::stages::size;
use crate::stages::surface::{self, Comb, Surface, SurfaceParams};
use pelage_formats::Bounds;
use pelage_import::BakeError;
use pelage_import::mesh::{DrawnComb, Model, RestPose};
use std::collections::BTreeSet;

/// What the `surface` stage leaves behind.
#[derive(Clone, Debug)]
pub struct Laid<'a> {
    /// The mesh with its hair-tile coordinates.
    pub surface: Surface,
    /// Box and sphere about the skin at rest.
    pub bounds: Bounds,
    /// One per material: whether hair grows on it.
    pub furred: Vec<bool>,
    /// What `model.bare` says, or would have to say for the same.
    pub bare: Vec<String>,
    /// Lengths that the recipe may leave open.
    pub lengths: Lengths,
    /// The recipe with hair and patches in the terms of the tile.
    pub filled: Recipe,
    /// Colours of the hair, which the recipe may leave open too.
    pub hair_colors: HairColors,
    /// The recipe's groom maps.
    pub maps: Maps<'a>,
    /// Density and comb as the maps say them, at the vertices of the model.
    pub lay: Lay,
    /// What the recipe left open and was chosen.
    pub decisions: Vec<Decision>,
    /// What `import` and this stage had to say.
    pub warnings: Vec<String>,
}

/// The first stage alone: lays the hair's tile on a model. Arguments as in [`Told`](super::Told).
///
/// # Errors
///
/// As [`bake`](super::bake()), as far as this stage goes.
pub fn lay<'a>(file: &str, model: &Model, recipe: &'a Recipe, images: &'a MapImages) -> Result<Laid<'a>, BakeError> {
    let mut warnings = model.warnings.clone();
    let rest = RestPose::of(&model.mesh, model.animation.as_ref());
    let bounds = groom::bounds(&rest);
    let Growth { furred, bare, decision } = groom::growth(model, &rest, recipe.model.bare.as_deref(), &mut warnings);
    let animation = model.animation.as_ref();
    let body = Body { mesh: &model.mesh, rest: &rest, animation, furred: &furred, bounds: &bounds };
    let mut by_body = BodyGroom::of(&body, recipe.groom.by_body);
    if recipe.surface.source == SurfaceSource::Model {
        // The model's own coordinates say how dense hair is.
        by_body.iter_mut().for_each(|body| body.density = None);
    }
    let maps = Maps::new(&model.mesh, &model.materials, &furred, &recipe.groom, images, &mut warnings)
        .with_joints(JointValues::new(&recipe.groom.joint, animation, &mut warnings))
        .with_body(by_body)
        .with_marks(MarkValues::new(&recipe.surface.comb_marks, &model.combs, &body, &mut warnings));
    let maps = match (recipe.groom.coordinates, recipe.groom.coordinates.projection()) {
        (_, Some(along)) => maps.over(Over::Space { along, bounds }),
        (GroomCoordinates::Atlas, None) if maps.has_images() => {
            maps.over(Over::Atlas(Box::new(ModelAtlas::new(file, model)?)))
        }
        _ => maps,
    };
    let InTile { recipe: filled, decisions: of_tile, warnings: of_hair } = metric::in_tile(recipe, &bounds)?;
    warnings.extend(of_hair);
    let lengths = Lengths::resolve(&filled, &bounds);
    let colored = groom::is_colored(model, &maps, &furred, &recipe.color);
    // Hair that nothing colours is brown by its own colours, which would brown what marks colour; so the brown goes below.
    let plain = maps.marks().has_color() && !colored && recipe.color.root.is_none() && recipe.color.tip.is_none();
    let (maps, colored) = if plain { (maps.with_plain_color(HairColors::PLAIN), true) } else { (maps, colored) };
    let mut decisions: Vec<Decision> = decision.into_iter().chain(lengths.decisions(&filled)).chain(of_tile).collect();
    if plain {
        decisions.push(Decision {
            what: "colour of the coat beside marks",
            chosen: "brown, the model brings no colour".into(),
            line: format!("groom.color = {}", in_toml(HairColors::PLAIN)),
        });
    }
    let open = match (colored, recipe.shading.model) {
        (true, ShadingModel::KajiyaKay) => HairColors::NEUTRAL,
        (true, ShadingModel::Marschner) => HairColors::SCATTERING,
        (false, _) => HairColors::BROWN,
    };
    let pigmented = recipe.fibre.pigmented();
    let hair_colors = recipe.color.hair(pigmented.unwrap_or(open));
    decisions.extend(maps.decision(recipe.groom.by_body, lengths.length_m));
    let why = match (plain, colored) {
        _ if pigmented.is_some() => "of the pigments of fibre.eumelanin and fibre.pheomelanin",
        (true, _) => "neutral, marks colour the coat",
        (_, true) => "neutral, the model's own colours show",
        _ => "brown, the model brings no colour",
    };
    decisions.extend(hair_color_decisions(&recipe.color, hair_colors, why));
    size::check(file, recipe, &bounds, &lengths)?;
    let params = SurfaceParams::from_recipe(&filled.surface, lengths.tile_size_m, furred.clone());
    let lay = maps.lay(&model.mesh, &rest, params.comb.everywhere())?;
    if lay != Lay::default() && recipe.surface.source == SurfaceSource::Model {
        warnings.push("groom.density and groom.comb have no effect beside surface.source = \"model\"".into());
    }
    let comb = match lay.comb.clone() {
        Some(wishes) => Comb::PerVertex(wishes),
        None => Comb::of_recipe(&recipe.surface, &model.combs, bounds.radius),
    };
    decisions.extend(comb_decision(&recipe.surface, &comb, &model.combs));
    let params = SurfaceParams { comb, density: lay.density.clone(), ..params };
    let surface = surface::parameterize(file, model, &params)?;
    warnings.extend(size::remarks(recipe, &bounds, &surface.rest.positions, &surface.mesh.triangles));
    warnings.extend(surface.warnings.iter().cloned());
    Ok(Laid { surface, bounds, furred, bare, lengths, filled, hair_colors, maps, lay, decisions, warnings })
}

/// That what is drawn in the model combs it, where the recipe leaves open what does.
fn comb_decision(params: &recipe::SurfaceParams, comb: &Comb, drawn: &[DrawnComb]) -> Option<Decision> {
    if params.comb != CombSource::Auto || drawn.is_empty() || !matches!(comb, Comb::Marks { .. }) {
        return None;
    }
    let names: BTreeSet<&str> = drawn.iter().map(|line| line.name.as_str()).collect();
    let names: Vec<&str> = names.into_iter().collect();
    Some(Decision {
        what: "where hair is combed to",
        chosen: format!("along what is drawn in the model: {}; \"direction\" leaves that out", names.join(", ")),
        line: format!("surface.comb = \"{}\"", CombSource::Marks.word()),
    })
}

/// A colour of our own, which has whole bytes, in a recipe.
fn in_toml(color: SrgbColor) -> String {
    let [r, g, b] = color.0.map(|c| (255.0 * c).round() as u8);
    format!("\"#{r:02x}{g:02x}{b:02x}\"")
}

/// What `color` leaves open of the colours of hair, and why it was chosen so.
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
