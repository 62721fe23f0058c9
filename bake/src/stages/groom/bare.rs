//! Selection of furred materials: all except those that `model.bare` matches. If a recipe leaves `model.bare` out, bare
//! materials are detected. The cues are the names of materials, nodes and meshes; small materials are also detected by
//! gloss or by the shape of eyes. Noses, claws and eye rims that share a material were split off on import
//! ([`super::features`]), and are bare too.
//!
//! A bald body is worse than a furred claw, so doubtful materials stay furred.

use super::names::{NameMeaning, meaning_of_words, words};
use super::pairs::{WeldedFaces, weld};
use crate::decision::Decision;
use pelage_import::mesh::{Feature, Material, Mesh, MeshPart, Model, RestPose};
use pelage_params::{Field, glob};
use std::collections::BTreeSet;

/// Maximum share of the mesh's area for detection by gloss or shape. Eyes, claws and nose together cover less of most
/// animals.
const SMALL: f64 = 0.03;
/// Maximum roughness of a glossy material, and maximum ratio of its roughness to the mean roughness of the furred
/// materials.
const GLOSSY: f32 = 0.35;
const GLOSSY_BESIDE: f32 = 0.6;
/// Minimum metalness of a metallic material, and maximum mean metalness of the furred materials beside it.
const METAL: f32 = 0.9;
const METAL_BESIDE: f32 = 0.3;

/// Furred and bare materials.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FurredMaterials {
    /// Whether hair grows on each material.
    pub furred: Vec<bool>,
    /// Equivalent value of `model.bare`: the recipe's own list, if there is one.
    pub bare: Vec<String>,
    /// Choice that was made if the recipe leaves `model.bare` out.
    pub decision: Option<Decision>,
}

/// Reason for a material to be bare.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum BareReason {
    Name,
    PartName,
    JointName,
    Gloss,
    Shape,
    Feature(&'static str),
}

impl BareReason {
    fn of(feature: &Feature) -> Self {
        match feature {
            Feature::Nose => Self::Feature("small, dark and foremost"),
            Feature::EyeRims => Self::Feature("small, dark and joined to eyes"),
            Feature::Claws => Self::Feature("small dark tips in pairs"),
            Feature::Eyes => Self::Feature("small pairs in the face"),
            Feature::InHead => Self::Feature("small and inside the head"),
            Feature::Named(_) => Self::PartName,
            Feature::Joint(_) => Self::JointName,
        }
    }

    fn words(self) -> &'static str {
        match self {
            Self::Name => "by name",
            Self::PartName => "by its mesh's name",
            Self::JointName => "by its joint's name",
            Self::Gloss => "small and glossy",
            Self::Shape => "small round pairs",
            Self::Feature(why) => why,
        }
    }
}

/// Determines for each material whether hair grows on it.
///
/// * `rest`: rest pose of the model's mesh
/// * `bare`: patterns, in which `*` matches any characters and `?` one, ignoring case. With `None`, bare materials are
///   detected and reported in [`FurredMaterials::decision`]. All materials stay furred if there is only one, or if none
///   would be left.
///
/// Patterns without a matching material, and models whose materials all look bare, are reported in `warnings`.
pub fn find_furred_materials(
    model: &Model,
    rest: &RestPose,
    bare: Option<&[String]>,
    warnings: &mut Vec<String>,
) -> FurredMaterials {
    let materials = &model.materials;
    if let Some(bare) = bare {
        let furred = furred_materials(model, bare, warnings);
        return FurredMaterials { furred, bare: bare.to_vec(), decision: None };
    }
    let mut why = bare_reasons(model, rest);
    if why.len() > 1 && why.iter().all(Option::is_some) {
        warnings.push(format!(
            "all {} materials look bare, such as {} ({}), so all are furred; set model.bare to say which are not",
            why.len(),
            readable_name(&materials[0].name),
            why[0].map_or("", BareReason::words)
        ));
        why.fill(None);
    }
    let alike = unmark_ambiguous(materials, &mut why);
    let mut names: Vec<String> = Vec::new();
    for (material, _) in materials.iter().zip(&why).filter(|(_, why)| why.is_some()) {
        let name = material.full_name();
        if !names.contains(&name) {
            names.push(name);
        }
    }
    let decision = (!materials.is_empty()).then(|| Decision {
        what: "where hair grows",
        chosen: describe_choice(materials, &why, &alike),
        line: format!("model.bare = {}", names.to_toml().unwrap_or_default()),
    });
    FurredMaterials { furred: why.iter().map(Option::is_none).collect(), bare: names, decision }
}

/// Returns for each material whether hair grows on it according to a recipe's list, as in [`find_furred_materials`].
fn furred_materials(model: &Model, bare: &[String], warnings: &mut Vec<String>) -> Vec<bool> {
    let materials = &model.materials;
    for pattern in bare.iter().filter(|p| !materials.iter().any(|m| is_named(p, m))) {
        let names: Vec<_> = materials.iter().map(Material::full_name).collect();
        let mut text = format!("model.bare: {pattern:?} matches no material; the model has {names:?}");
        for (kind, names) in [("nodes", names_of_parts(model)), ("joints", names_of_joints(model))] {
            if !names.is_empty() {
                text += &format!(", the {kind} {names:?}");
            }
        }
        warnings.push(text);
    }
    materials.iter().map(|m| !bare.iter().any(|p| is_named(p, m))).collect()
}

/// Returns the names of the nodes and meshes of the model's parts.
fn names_of_parts(model: &Model) -> BTreeSet<&str> {
    model.mesh.parts.iter().flat_map(|part| &part.names).map(String::as_str).collect()
}

/// Returns the names of the model's joints.
fn names_of_joints(model: &Model) -> BTreeSet<&str> {
    let Some(animation) = &model.animation else { return BTreeSet::new() };
    let nodes = animation.joints.iter().filter_map(|joint| animation.nodes.get(joint.node as usize));
    nodes.map(|node| node.name.as_str()).filter(|name| !name.is_empty()).collect()
}

/// Whether a pattern matches a material's name, the name of the node, mesh or joint for which the material was split,
/// or both together.
pub(super) fn is_named(pattern: &str, material: &Material) -> bool {
    let part = match &material.feature {
        Some(Feature::Named(name) | Feature::Joint(name)) => glob(pattern, name),
        _ => false,
    };
    part || glob(pattern, &material.name) || (material.feature.is_some() && glob(pattern, &material.full_name()))
}

/// Returns for each material the reason why it is bare, or `None`.
fn bare_reasons(model: &Model, rest: &RestPose) -> Vec<Option<BareReason>> {
    let Model { mesh, materials, .. } = model;
    // A single material covers the animal, whatever its name.
    if materials.len() < 2 {
        return vec![None; materials.len()];
    }
    let shares = material_area_shares(model, rest);
    let share = |m: usize| shares.get(m).copied().unwrap_or(0.0);
    let names = without_common_words(materials.iter().map(|m| vec![words(&m.name)]).collect());
    let of_parts =
        without_common_words(mesh.parts.iter().map(|p| p.names.iter().map(|n| words(n)).collect()).collect());
    let mut never = vec![false; materials.len()];
    let mut why = vec![None; materials.len()];
    for m in 0..materials.len() {
        if let Some(feature) = &materials[m].feature {
            why[m] = Some(BareReason::of(feature));
            continue;
        }
        let fits = |most: f32| share(m) <= f64::from(most);
        match (combined_meaning(&names[m]), meaning_of_parts(model, &of_parts, m)) {
            (NameMeaning::Furred, _) => never[m] = true,
            (NameMeaning::Bare { most }, _) if fits(most) => why[m] = Some(BareReason::Name),
            (NameMeaning::Nothing, NameMeaning::Bare { most }) if fits(most) => why[m] = Some(BareReason::PartName),
            // A mesh name that denotes a furred part decides nothing: a mesh named as a body may contain eyes with
            // their own material.
            _ => {}
        }
    }
    let is_open = |m: &usize| why[*m].is_none() && !never[*m] && share(*m) > 0.0 && share(*m) <= SMALL;
    let open: Vec<usize> = (0..materials.len()).filter(is_open).collect();
    let furred: Vec<bool> = why.iter().map(Option::is_none).collect();
    if open.is_empty() {
        return why;
    }
    let faces = WeldedFaces::new(mesh, &rest.positions, &weld(&rest.positions), materials.len());
    for m in open {
        if is_glossy(materials, &shares, &furred, m) {
            why[m] = Some(BareReason::Gloss);
        } else if faces.are_round_pairs(m) {
            why[m] = Some(BareReason::Shape);
        }
    }
    why
}

/// Returns the share of the mesh's area at rest that each material covers.
fn material_area_shares(model: &Model, rest: &RestPose) -> Vec<f64> {
    let mut shares = vec![0.0; model.materials.len()];
    for (part, share) in model.mesh.parts.iter().zip(part_area_shares(&model.mesh, rest)) {
        shares[part.material] += share;
    }
    shares
}

/// Returns the share of the mesh's area at rest that each part covers.
pub(super) fn part_area_shares(mesh: &Mesh, rest: &RestPose) -> Vec<f64> {
    let of_part = |part: &MeshPart| {
        let triangles = mesh.triangles.iter().skip(part.first_triangle).take(part.triangle_count);
        let area = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|v| rest.positions[v as usize].as_dvec3());
            (b - a).cross(c - a).length() / 2.0
        };
        triangles.map(area).sum::<f64>()
    };
    let areas: Vec<f64> = mesh.parts.iter().map(of_part).collect();
    let whole: f64 = areas.iter().sum();
    areas.into_iter().map(|area| if whole > 0.0 { area / whole } else { 0.0 }).collect()
}

/// Removes the words that every one of `things` has in at least one of its names. Such a word names the animal, as in
/// `Bighorn_Body` and `Bighorn_Eye`.
///
/// * `things`: for each material or part, its names, each split into words
pub(super) fn without_common_words(things: Vec<Vec<Vec<String>>>) -> Vec<Vec<Vec<String>>> {
    let has = |thing: &Vec<Vec<String>>, word: &String| thing.iter().any(|name| name.contains(word));
    let first = things.first().into_iter().flatten().flatten();
    let common: Vec<String> = first.filter(|word| things.iter().all(|thing| has(thing, word))).cloned().collect();
    let keep = |name: Vec<String>| name.into_iter().filter(|word| !common.contains(word)).collect();
    things.into_iter().map(|thing| thing.into_iter().map(keep).collect()).collect()
}

/// Combines the meanings of several names of one thing: furred if any name says so, otherwise bare with the smallest
/// maximum share.
pub(super) fn combined_meaning(names: &[Vec<String>]) -> NameMeaning {
    names.iter().map(|name| meaning_of_words(name)).fold(NameMeaning::Nothing, |all, said| match (all, said) {
        (NameMeaning::Furred, _) | (_, NameMeaning::Furred) => NameMeaning::Furred,
        (NameMeaning::Bare { most: a }, NameMeaning::Bare { most: b }) => NameMeaning::Bare { most: a.min(b) },
        (NameMeaning::Nothing, said) => said,
        (all, NameMeaning::Nothing) => all,
    })
}

/// Combines the meanings of the nodes and meshes that use a material: bare if all say so, furred if one does.
fn meaning_of_parts(model: &Model, names: &[Vec<Vec<String>>], material: usize) -> NameMeaning {
    let parts = model.mesh.parts.iter().zip(names).filter(|(part, _)| part.material == material);
    let said = parts.map(|(_, names)| combined_meaning(names)).reduce(|all, said| match (all, said) {
        (NameMeaning::Furred, _) | (_, NameMeaning::Furred) => NameMeaning::Furred,
        (NameMeaning::Bare { most: a }, NameMeaning::Bare { most: b }) => NameMeaning::Bare { most: a.min(b) },
        _ => NameMeaning::Nothing,
    });
    said.unwrap_or(NameMeaning::Nothing)
}

/// Whether a material is glossy or metallic, while the furred materials are known to be neither.
fn is_glossy(materials: &[Material], shares: &[f64], furred: &[bool], material: usize) -> bool {
    // Mean over the other furred materials. The value must be known for more than half of their area.
    let rest = |value: fn(&Material) -> Option<f32>| {
        let others = || (0..materials.len()).filter(|m| *m != material && furred[*m]);
        let known: Vec<(f64, f64)> =
            others().filter_map(|m| Some((shares[m], f64::from(value(&materials[m])?)))).collect();
        let (all, area) = (others().map(|m| shares[m]).sum::<f64>(), known.iter().map(|(share, _)| share).sum::<f64>());
        (area > 0.0 && area > all / 2.0).then(|| known.iter().map(|(share, v)| share * v).sum::<f64>() / area)
    };
    let Material { roughness, metallic, .. } = materials[material];
    let smooth = roughness
        .zip(rest(|m| m.roughness))
        .is_some_and(|(own, rest)| own <= GLOSSY && f64::from(own) <= f64::from(GLOSSY_BESIDE) * rest);
    let metal =
        metallic.zip(rest(|m| m.metallic)).is_some_and(|(own, rest)| own >= METAL && rest <= f64::from(METAL_BESIDE));
    smooth || metal
}

/// Makes a bare material furred again if listing its name in `model.bare` would also match a furred material, literally
/// or as a pattern. Returns the names of such materials.
fn unmark_ambiguous(materials: &[Material], why: &mut [Option<BareReason>]) -> Vec<String> {
    let mut alike = Vec::new();
    // Repeat, because a material that becomes furred may be matched by the name of another bare one.
    loop {
        let names_furred = |m: &usize| {
            why[*m].is_some()
                && (0..materials.len()).any(|o| why[o].is_none() && is_named(&materials[*m].full_name(), &materials[o]))
        };
        let Some(m) = (0..materials.len()).find(names_furred) else { return alike };
        why[m] = None;
        let name = materials[m].full_name();
        if !alike.contains(&name) {
            alike.push(name);
        }
    }
}

/// Describes the choice, such as `4 of 7 materials furred, 3 bare: Eyes (by name), Nose (small and glossy)`.
fn describe_choice(materials: &[Material], why: &[Option<BareReason>], alike: &[String]) -> String {
    let count = materials.len();
    let bare: Vec<String> = materials
        .iter()
        .zip(why)
        .filter_map(|(material, why)| Some(format!("{} ({})", readable_name(&material.full_name()), (*why)?.words())))
        .collect();
    let mut text = match (count, bare.len()) {
        (1, _) => "the only material is furred".to_owned(),
        (_, 0) => format!("all {count} materials furred"),
        (_, n) => format!("{} of {count} materials furred, {n} bare: {}", count - n, bare.join(", ")),
    };
    if !alike.is_empty() {
        let names: Vec<String> = alike.iter().map(|name| readable_name(name)).collect();
        text += &format!("; furred because other materials have the same name: {}", names.join(", "));
    }
    text
}

/// Formats a name for people.
fn readable_name(name: &str) -> String {
    if name.is_empty() { "a material without a name".to_owned() } else { name.escape_debug().to_string() }
}

#[cfg(test)]
#[path = "bare_tests.rs"]
mod tests;
