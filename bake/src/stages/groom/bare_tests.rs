use super::*;
use crate::stages::fixtures::{self, part};
use glam::Vec3;
use pelage_import::mesh::{Mesh, MeshPart};

/// Appends a sphere as a separate part, without its lowest `missing` rings.
fn add_ball(mesh: &mut Mesh, material: usize, names: &[&str], center: Vec3, radius: f32, missing: u32) {
    let first = mesh.triangles.len();
    fixtures::add_ball(mesh, center, radius, missing);
    let names = names.iter().map(|name| (*name).to_owned()).collect();
    mesh.parts.push(MeshPart { names, ..part(material, first, mesh.triangles.len() - first) });
}

fn material(name: &str) -> Material {
    Material { name: name.into(), roughness: Some(0.9), metallic: Some(0.0), ..Material::default() }
}

/// Builds a body of radius 1 m, and a sphere of the given radius for each further name. Spheres and part names alone
/// are not detected as bare.
fn animal(names: &[(&str, f32)]) -> Model {
    let mut model = Model { materials: names.iter().map(|(name, _)| material(name)).collect(), ..Model::default() };
    for (m, (_, radius)) in names.iter().enumerate() {
        add_ball(&mut model.mesh, m, &["Mesh"], Vec3::X * 2.0 * m as f32, *radius, 0);
    }
    model
}

fn found(model: &Model) -> (FurredMaterials, Vec<String>) {
    let mut warnings = Vec::new();
    let rest = RestPose::of(&model.mesh, None);
    let growth = find_furred_materials(model, &rest, None, &mut warnings);
    // The reported recipe line gives the same result.
    let said = super::find_furred_materials(model, &rest, Some(&growth.bare), &mut Vec::new());
    assert_eq!(said.furred, growth.furred, "{:?}", growth.decision);
    assert_eq!(said.decision, None);
    (growth, warnings)
}

fn decided(model: &Model) -> (String, String) {
    let decision = found(model).0.decision.unwrap();
    assert_eq!(decision.what, "where hair grows");
    (decision.chosen, decision.line)
}

#[test]
fn bare_materials_are_found_by_name_and_recorded() {
    let wolf = animal(&[("Main", 1.0), ("Main_Light", 0.5), ("Eyes_Black", 0.1), ("Nose", 0.1)]);
    let expected = "2 of 4 materials furred, 2 bare: Eyes_Black (by name), Nose (by name)";
    assert_eq!(decided(&wolf), (expected.into(), "model.bare = [\"Eyes_Black\", \"Nose\"]".into()));
    let plain = animal(&[("Main", 1.0), ("Light", 0.5)]);
    assert_eq!(decided(&plain), ("all 2 materials furred".into(), "model.bare = []".into()));
    assert_eq!(found(&Model::default()).0, FurredMaterials::default());
}

#[test]
fn recipe_list_is_used_and_missed_bare_parts_are_reported() {
    let wolf = animal(&[("Main", 1.0), ("Eyes", 0.1)]);
    let (rest, mut warnings) = (RestPose::of(&wolf.mesh, None), Vec::new());
    let bare = ["main*".to_owned(), "Hoof".to_owned()];
    let told = find_furred_materials(&wolf, &rest, Some(&bare), &mut warnings);
    assert_eq!((told.furred, told.bare.as_slice(), told.decision), (vec![false, true], &bare[..], None));
    assert!(matches!(&warnings[..], [w] if w.contains("Hoof") && w.contains("Eyes")), "{warnings:?}");
    let none = find_furred_materials(&wolf, &rest, Some(&[]), &mut warnings);
    assert_eq!(none.furred, [true, true]);
}

#[test]
fn name_of_the_animal_is_not_a_part_name() {
    // A single material is the animal.
    assert_eq!(decided(&animal(&[("Horn", 1.0)])), ("the only material is furred".into(), "model.bare = []".into()));
    // A word that all names share is ignored.
    let bighorn = animal(&[("Big_Horn_Ram", 1.0), ("Big_Horn_Ram_Eye", 0.1)]);
    assert_eq!(found(&bighorn).0.bare, ["Big_Horn_Ram_Eye"]);
    // A material with a bare name stays furred if it covers too much, here three quarters of the area.
    let hornbill = animal(&[("Horn", 1.0), ("Wing", 0.5)]);
    assert_eq!(found(&hornbill).0.furred, [true, true]);
    let stag = animal(&[("Wing", 1.0), ("Horn", 0.5)]);
    assert_eq!(found(&stag).0.furred, [true, false]);
}

#[test]
fn at_least_one_material_is_furred() {
    let masks = animal(&[("Eyes", 0.5), ("Teeth", 0.5), ("Claw", 0.5), ("Nail", 0.5)]);
    let (growth, warnings) = found(&masks);
    assert_eq!((growth.furred, growth.bare.len()), (vec![true; 4], 0));
    assert!(warnings.iter().any(|w| w.contains("model.bare") && w.contains("Eyes")), "{warnings:?}");
}

#[test]
fn node_and_mesh_names_decide_for_neutral_material_names() {
    let mut model = animal(&[("Main", 1.0), ("Black", 0.2)]);
    model.mesh.parts[0].names = vec!["Wolf".into()];
    model.mesh.parts[1].names = vec!["Claws.001".into(), "Cone".into()];
    assert_eq!(decided(&model).0, "1 of 2 materials furred, 1 bare: Black (by its mesh's name)");
    // The material is also used by another part, which would become bald.
    add_ball(&mut model.mesh, 1, &["Stripes"], Vec3::Y * 3.0, 0.2, 0);
    assert_eq!(found(&model).0.furred, [true, true]);
    // The material's name takes precedence.
    model.mesh.parts.pop();
    model.materials[1].name = "BlackFur".into();
    assert_eq!(found(&model).0.furred, [true, true]);
}

#[test]
fn small_glossy_materials_are_bare() {
    let mut model = animal(&[("Main", 1.0), ("Black", 0.1)]);
    let of = |model: &Model| found(model).0.furred[1];
    assert!(of(&model));
    model.materials[1].roughness = Some(0.2);
    assert_eq!(decided(&model).0, "1 of 2 materials furred, 1 bare: Black (small and glossy)");
    model.materials[0].roughness = Some(0.25);
    assert!(of(&model), "no smoother than the rest");
    model.materials[0].roughness = None;
    assert!(of(&model), "nothing is known of the rest");
    model.materials[1].metallic = Some(1.0);
    assert!(!of(&model), "metal");
    model.materials[0].metallic = Some(1.0);
    assert!(of(&model), "an exporter wrote so of all");
    let mut large = animal(&[("Main", 1.0), ("Black", 0.3)]);
    large.materials[1].roughness = Some(0.2);
    assert!(of(&large), "a saddle of dark fur may be drawn smooth");
    let mut ear = animal(&[("Main", 1.0), ("EarSkin", 0.1)]);
    ear.materials[1].roughness = Some(0.2);
    assert!(of(&ear), "its name says otherwise");
}

#[test]
fn small_round_pairs_above_the_middle_are_eyes() {
    let with = |balls: &[(Vec3, f32, u32)]| {
        let mut model = animal(&[("Main", 1.0)]);
        model.materials.push(material("Black"));
        for (center, radius, missing) in balls {
            add_ball(&mut model.mesh, 1, &["Mesh"], *center, *radius, *missing);
        }
        model
    };
    let (left, right) = (Vec3::new(-0.3, 0.7, 0.7), Vec3::new(0.3, 0.7, 0.7));
    assert_eq!(
        decided(&with(&[(left, 0.1, 0), (right, 0.1, 0)])).0,
        "1 of 2 materials furred, 1 bare: Black (small round pairs)"
    );
    let furred = |balls: &[(Vec3, f32, u32)]| found(&with(balls)).0.furred[1];
    assert!(!furred(&[(left, 0.1, 6), (right, 0.1, 6)]), "half a ball is an eye without its back");
    assert!(furred(&[(left, 0.1, 11), (right, 0.1, 11)]), "a flat cap is a spot");
    assert!(furred(&[(left, 0.1, 0)]), "one alone is the tip of a tail");
    assert!(furred(&[(left, 0.1, 0), (right, 0.07, 0)]), "of two sizes");
    assert!(furred(&[(left, 0.1, 0), (left, 0.1, 0)]), "one about the other");
    assert!(furred(&[(left - Vec3::Y, 0.1, 0), (right - Vec3::Y, 0.1, 0)]), "feet");
    assert!(furred(&[(left, 0.2, 0), (right, 0.2, 0)]), "too large");
    // Both spheres are round, but their surface continues in the body's material.
    let mut grown = with(&[(left, 0.1, 6), (right, 0.1, 6)]);
    let rim = grown.mesh.triangles[grown.mesh.parts[1].first_triangle + grown.mesh.parts[1].triangle_count - 1];
    grown.mesh.triangles.push([rim[1], rim[2], 0]);
    let first_triangle = grown.mesh.triangles.len() - 1;
    grown.mesh.parts.push(MeshPart { first_triangle, triangle_count: 1, ..MeshPart::default() });
    assert_eq!(found(&grown).0.furred, [true, true]);
}

#[test]
fn materials_with_ambiguous_names_stay_furred() {
    // Two materials have the same name, and one of them covers too much.
    let twins = animal(&[("Body", 1.0), ("Nose", 0.1), ("nose", 0.7), ("Eye", 0.1)]);
    let (growth, _) = found(&twins);
    assert_eq!((growth.furred, growth.bare), (vec![true, true, true, false], vec!["Eye".to_owned()]));
    assert!(decided(&twins).0.ends_with("other materials have the same name: Nose"), "{}", decided(&twins).0);
    // The name of a material is a pattern that matches another one.
    let star = animal(&[("Eye*", 0.1), ("Eyebrow", 0.1), ("Main", 1.0)]);
    assert_eq!(found(&star).0.furred, [true; 3]);
    // The small material has no name.
    let mut nameless = animal(&[("Main", 1.0), ("", 0.1)]);
    nameless.mesh.parts[1].names = vec!["Eyes".into()];
    let (chosen, line) = decided(&nameless);
    assert_eq!(line, "model.bare = [\"\"]");
    assert_eq!(chosen, "1 of 2 materials furred, 1 bare: a material without a name (by its mesh's name)");
}
