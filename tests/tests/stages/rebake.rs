#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
//! Checks that repeated bakes of a model with a changing recipe equal whole bakes, for every key.

use crate::stages::pipeline::{StageLog, asset, import_built_in};
use pelage_bake::pipeline::{self, BakeInput};
use pelage_bake::rebake::Rebake;
use pelage_bake::recipe::{self, Recipe};
use pelage_bake::stages::groom::MapImages;
use pelage_import::BakeError;
use pelage_params::{Control, Knob};
use rayon::prelude::*;

/// Returns a recipe for the smallest package with all optional sections.
fn small_recipe() -> Recipe {
    let mut recipe = Recipe::parse("torus", std::str::from_utf8(&asset("recipes/torus.toml")).unwrap()).unwrap();
    let small = [
        "fins.enabled=true",
        "slice.layers=4",
        "slice.tile_texels=32",
        "hair.density=60",
        "ink.stroke_texels=64",
        "ink.wash_texels=64",
        "ink.paper_texels=64",
        "ink.fur_texels=64",
        "pack.shell_format=rgba8",
        "pack.direction_format=rg8",
    ];
    small.iter().for_each(|set| recipe.set(set).unwrap());
    recipe
}

/// Returns the recipe with another value for the key. Returns `None` for keys for which this test cannot choose another
/// value: paths, lists, names.
fn changed(base: &Recipe, knob: &Knob) -> Option<Recipe> {
    let now = knob.value(base);
    let values: Vec<String> = match (knob.control)() {
        Control::Toggle => vec!["true".into(), "false".into()],
        Control::Choice(choices) => choices.iter().map(|choice| choice.word.to_owned()).collect(),
        Control::PowerOfTwo { least, most } => vec![(2 * least).min(most).to_string(), least.to_string()],
        Control::Color => vec!["#804020".into()],
        Control::Vector { len, .. } => vec![format!("[{}]", vec!["0.7"; len].join(", "))],
        Control::Number { least, most, whole, .. } => {
            let now: f64 = now.as_deref().and_then(|text| text.parse().ok()).unwrap_or(0.1);
            let near = [1.25 * now, 0.8 * now, now + 1.0, least, 0.5 * (least + most)];
            let in_range = near.into_iter().filter(|x| (least..=most).contains(x));
            in_range.map(|x| if whole { format!("{}", x.round()) } else { format!("{x:?}") }).collect()
        }
        Control::Text | Control::Tables(_) => return None,
    };
    values.into_iter().find_map(|value| {
        let mut other = base.clone();
        other.set(&format!("{}={value}", knob.name)).ok()?;
        (knob.value(&other) != now).then_some(other)
    })
}

#[test]
fn incremental_bake_equals_a_full_bake_for_every_key() {
    let model = import_built_in("torus", &Recipe::default());
    let (base, images) = (small_recipe(), MapImages::default());
    let input = |recipe| BakeInput::new("torus", "torus", recipe, &images);
    let others: Vec<(&str, Recipe)> =
        recipe::keys().filter_map(|knob| Some((knob.name, changed(&base, knob)?))).collect();
    assert!(others.len() > 100, "only {} keys are changed", others.len());
    let mut first = Rebake::new(&model);
    first.bake(&input(&base), &mut |_| ()).unwrap();
    let stale: Vec<&str> = others
        .par_iter()
        .filter(|(_, recipe)| {
            let text =
                |baked: Result<pipeline::Baked, BakeError>| baked.map(|b| b.package).map_err(|error| error.to_string());
            let went_on = text(first.clone().bake(&input(recipe), &mut |_| ()));
            went_on != text(pipeline::bake(&input(recipe), &model, &mut |_| ()))
        })
        .map(|(name, _)| *name)
        .collect();
    assert!(stale.is_empty(), "these keys change outputs that were reused: {stale:?}");
}

#[test]
fn changes_rerun_only_the_affected_stages() {
    let model = import_built_in("torus", &Recipe::default());
    let (base, images) = (small_recipe(), MapImages::default());
    let with = |set: &str| {
        let mut recipe = base.clone();
        recipe.set(set).unwrap();
        recipe
    };
    let (shading, ink, hair) = (with("shading.ambient=[0.3, 0.3, 0.3]"), with("ink.speed=1.5"), with("hair.lean=0.35"));
    let others = MapImages::default();
    let mut rebake = Rebake::new(&model);
    let mut stages_of = |recipe, images| {
        let mut log = StageLog::default();
        rebake.bake(&BakeInput::new("torus", "torus", recipe, images), &mut |event| log.on_event(event)).unwrap();
        log.stages()
    };
    assert_eq!(stages_of(&base, &images), pipeline::STAGES);
    assert_eq!(stages_of(&base, &images), [""; 0]);
    assert_eq!(stages_of(&shading, &images), ["pack"]);
    assert_eq!(
        stages_of(&ink, &images),
        ["ink", "contours", "pack"],
        "only ink, its contours and packing must run; the shading was restored"
    );
    assert_eq!(stages_of(&hair, &images), pipeline::STAGES);
    assert_eq!(stages_of(&hair, &others), pipeline::STAGES, "images may have changed on disk");
}
