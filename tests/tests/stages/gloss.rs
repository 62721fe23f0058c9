#![allow(missing_docs, clippy::unwrap_used, reason = "a test fails by panicking")]
//! Gloss of bare surface, found from the model and set by the recipe.

use super::pipeline::{StageLog, import_built_in};
use glam::Vec3;
use pelage_bake::pipeline::{self, BakeInput, Outputs};
use pelage_bake::recipe::Recipe;
use pelage_bake::stages::groom::{MapImages, cornea_normals, gloss};
use pelage_formats::{Gloss, Limits, Package};
use pelage_import::mesh::{Feature, Material, Mesh, MeshPart, Model};
use std::f32::consts::TAU;

fn material(name: &str, roughness: Option<f32>, feature: Option<Feature>) -> Material {
    Material { name: name.into(), roughness, metallic: Some(1.0), feature, ..Material::default() }
}

/// Returns a body and bare materials, all with the same metalness.
fn model() -> Model {
    let materials = vec![
        material("Body", Some(0.3), None),
        material("Eye_L", Some(0.9), None),
        material("Black", Some(0.9), Some(Feature::Nose)),
        material("Muzzle", None, None),
        material("Horn", Some(0.5), None),
        material("Hoof", Some(1.0), None),
        material("EyeLash", None, None),
    ];
    Model { materials, ..Model::default() }
}

const FURRED: [bool; 7] = [true, false, false, false, false, false, false];

/// Returns the roughness of each material under a recipe, and the warnings.
fn roughness(model: &Model, recipe: &str) -> (Vec<Option<f32>>, Vec<String>) {
    let shading = Recipe::parse("recipe.toml", recipe).unwrap().shading;
    let mut warnings = Vec::new();
    let found = gloss(model, &FURRED, &shading, &mut warnings);
    (found.iter().map(|of| of.map(|of| of.roughness)).collect(), warnings)
}

#[test]
fn eyes_noses_and_files_give_gloss() {
    let found = gloss(&model(), &FURRED, &Recipe::default().shading, &mut Vec::new());
    let cornea = Gloss { roughness: 0.06, reflectance: 0.025, metalness: 0.0, wet: true };
    let moist = Gloss { roughness: 0.4, reflectance: 0.035, metalness: 0.0, wet: false };
    // All materials have the default metalness of glTF, which no author means.
    let horn = Gloss { roughness: 0.5, reflectance: 0.04, metalness: 0.0, wet: false };
    assert_eq!(found, [None, Some(cornea), Some(moist), Some(moist), Some(horn), None, None]);
    let mut metal = model();
    metal.materials[0].metallic = Some(0.0);
    let found = gloss(&metal, &FURRED, &Recipe::default().shading, &mut Vec::new());
    assert_eq!(found[4], Some(Gloss { metalness: 1.0, ..horn }));
    let (none, _) = roughness(&Model { materials: metal.materials[..1].to_vec(), ..Model::default() }, "");
    assert!(none.is_empty());
}

#[test]
fn recipes_change_gloss() {
    let table = "[[shading.material]]\nname = \"H*\"\nroughness = 0.2\n\
                 [[shading.material]]\nname = \"Body\"\nreflectance = 0.08\n\
                 [[shading.material]]\nname = \"Black/nose\"\nreflectance = 0.0\n\
                 [[shading.material]]\nname = \"Beak\"\nroughness = 0.2\n";
    let (found, warnings) = roughness(&model(), table);
    assert_eq!(found, [Some(0.5), Some(0.06), None, Some(0.4), Some(0.2), Some(0.2), None]);
    assert!(warnings.len() == 1 && warnings[0].starts_with("shading.material: \"Beak\" matches no material"));
    assert!(roughness(&model(), "[shading]\ngloss = false\n").0.is_empty());
    let error = Recipe::parse("r.toml", "[[shading.material]]\nname = \"x\"\nroughness = 0.01\n").unwrap_err();
    assert!(error.to_string().contains("roughness"), "{error}");
}

/// Checks that a flat eye is lit like the cap of a sphere, with its pupil in front, and that a pyramid keeps its
/// normals.
#[test]
fn flat_eyes_have_corneas() {
    let disc = |radius: f32, z: f32, tip: f32| {
        let rim = (0..8).map(move |i| (i as f32 * TAU / 8.0).sin_cos());
        let points = rim.map(move |(y, x)| Vec3::new(radius * x, radius * y, z));
        std::iter::once(Vec3::new(0.0, 0.0, z + tip)).chain(points)
    };
    let mesh = |tip: f32| {
        let positions: Vec<Vec3> = disc(1.0, 0.0, tip).chain(disc(0.4, 0.01, 0.4 * tip)).collect();
        let fan = |first: u32| (0..8).map(move |i| [first, first + 1 + i, first + 1 + (i + 1) % 8]);
        let part =
            |material, first_triangle| MeshPart { material, first_triangle, triangle_count: 8, ..MeshPart::default() };
        Mesh {
            normals: vec![Vec3::Z; positions.len()],
            positions,
            triangles: fan(0).chain(fan(9)).collect(),
            parts: vec![part(0, 0), part(1, 8)],
            ..Mesh::default()
        }
    };
    let wet = Some(Gloss { roughness: 0.06, reflectance: 0.025, metalness: 0.0, wet: true });
    let normals = cornea_normals(&mesh(0.0), &[wet, wet]).unwrap();
    for (position, normal) in mesh(0.0).positions.iter().zip(&normals) {
        let expected = 0.7 * position.truncate();
        assert!(normal.is_normalized() && normal.truncate().distance(expected) < 0.01, "{position}: {normal}");
    }
    assert_eq!(cornea_normals(&mesh(1.5), &[wet, wet]), None);
    let dry = wet.map(|of| Gloss { wet: false, ..of });
    assert_eq!(cornea_normals(&mesh(0.0), &[dry, None]), None);
}

/// Bakes the hare, and bakes it again with other gloss, which repeats only the last stages.
#[test]
fn packages_contain_gloss() {
    let mut recipe = Recipe::default();
    for set in ["slice.layers=4", "slice.tile_texels=64", "fins.enabled=false", "hair.density=50", "ink.enabled=false"]
    {
        recipe.set(set).unwrap();
    }
    let mut duller = recipe.clone();
    duller.set("shading.material=[{ name = \"Nose\", roughness = 0.8 }]").unwrap();
    let (model, images) = (import_built_in("hare", &recipe), MapImages::default());
    let mut outputs = Outputs::of_model(&model);
    for (recipe, nose) in [(&recipe, 0.4), (&duller, 0.8)] {
        let mut log = StageLog::default();
        let input = BakeInput::new("hare", "hare", recipe, &images);
        pipeline::run(&input, &mut outputs, &mut |event| log.on_event(event)).unwrap();
        let bytes = &outputs.package.get().unwrap().bytes;
        assert_eq!(Package::validate(bytes, &Limits::default()), []);
        let package = Package::open(bytes, &Limits::default()).unwrap();
        let roughness = |name: &str| {
            let index = package.manifest().materials.iter().position(|material| material.name == name).unwrap();
            package.gloss().unwrap()[index].map(|of| of.roughness)
        };
        assert_eq!(["Coat", "Eye", "Nose"].map(roughness), [None, Some(0.06), Some(nose)]);
        assert_eq!(log.stages().contains(&"slice"), nose == 0.4, "{:?}", log.stages());
        outputs.invalidate_changes(recipe, &duller);
    }
}
