//! Detection of bare parts that no material name reveals. Noses, eye rims and claws are detected by position, size and
//! colour. Other parts are named by nodes and meshes, and share their material with furred ones.
//!
//! Materials are split along these parts on import, so that everything that works by material handles them. Each rule
//! needs several cues, and doubtful parts keep their material: a bald body is worse than a furred claw.

use super::bare::{combined_meaning, is_named, part_area_shares, without_common_words};
use super::components::bare_components;
use super::names::{NameMeaning, are_names_of_eyes, are_names_of_snout, meaning_of_words, words};
use super::pairs::{WeldedFaces, triangle_range, weld};
use super::patches::{FaceMesh, Patch};
use glam::DVec3;
use pelage_import::mesh::{Feature, Material, MeshPart, Model, RestPose};
use pelage_params::glob;
use std::collections::BTreeMap;

/// Maximum area as a share of the mesh's area. `SMALL`: dark material; `NOSE`: nose; `RIM`: piece of an eye rim;
/// `CLAW`: claw; `EYE`: eye without a name; `PAINTED_EYE`: eye that shares the material of the body.
const SMALL: f64 = 0.03;
const NOSE: f64 = 0.01;
const RIM: f64 = 0.005;
const CLAW: f64 = 0.003;
const EYE: f64 = 0.0015;
const PAINTED_EYE: f64 = 0.004;
/// Maximum number of dark patches in the upper half of a body, or of balls, if some are eyes in its own material.
const MOST_SPOTS: usize = 6;
/// Maximum linear luminance of a dark patch. `DARK_BESIDE`: its maximum ratio to the luminance of the neighbours.
const DARK: f64 = 0.06;
const DARK_BESIDE: f64 = 0.45;
/// Minimum number of claws. If there are fewer dark patches, they may be dark paws.
const LEAST_CLAWS: usize = 6;
/// Maximum relative difference in area between two claws or eyes that count as equally large.
const ALIKE: f64 = 0.05;
/// The same for dark patches of a texture, whose triangles seldom follow the outline exactly.
const ALIKE_PAINTED: f64 = 0.3;
/// Height of the zone near the ground, as a share of the body's height.
const GROUND: f64 = 0.1;

/// Gives each detected bare part a separate material that looks like its previous one.
pub fn split_features(model: &mut Model) {
    let rest = RestPose::of(&model.mesh, model.animation.as_ref());
    // If several rules detect a triangle, the last rule wins.
    let mut found: BTreeMap<usize, Feature> = named_triangles(model, &rest);
    found.extend(shaped_triangles(model, &rest));
    found.extend(bare_components(model, &rest));
    if model.mesh.skin.is_empty() && model.materials.len() == 1 {
        found.extend(eyes_in_atlas(model, &rest).into_iter().map(|triangle| (triangle, Feature::Eyes)));
    }
    if !found.is_empty() {
        assign_materials(model, &found);
    }
}

/// Returns a copy of the model in which the surfaces of the nodes, meshes and joints that `model.bare` lists have
/// materials of their own; `None` if the list names materials only.
///
/// A joint's surface includes that of the joints below it, and consists of the triangles that follow them by more than
/// half.
pub fn split_listed(model: &Model, bare: &[String]) -> Option<Model> {
    let is_listed = |name: &str| bare.iter().any(|pattern| glob(pattern, name));
    let is_open = |part: &&MeshPart| {
        let material = model.materials.get(part.material);
        material.is_some_and(|material| !bare.iter().any(|pattern| is_named(pattern, material)))
    };
    let joints = listed_joints(model, is_listed);
    let mut found = BTreeMap::new();
    for part in model.mesh.parts.iter().filter(is_open) {
        let node = part.names.iter().find(|name| is_listed(name));
        for triangle in triangle_range(part) {
            let joint = || joint_of_triangle(model, &joints, triangle).cloned().map(Feature::Joint);
            let feature = node.map_or_else(joint, |name| Some(Feature::Named(name.clone())));
            found.extend(feature.map(|feature| (triangle, feature)));
        }
    }
    (!found.is_empty()).then(|| {
        let mut split = model.clone();
        assign_materials(&mut split, &found);
        split
    })
}

/// Returns for each joint the name by which it is listed: its own, or that of the nearest listed node above it.
fn listed_joints(model: &Model, is_listed: impl Fn(&str) -> bool) -> Vec<Option<String>> {
    let Some(animation) = &model.animation else { return Vec::new() };
    let mut nodes: Vec<Option<String>> = Vec::with_capacity(animation.nodes.len());
    for node in &animation.nodes {
        // Parents precede their children.
        let above = || node.parent.and_then(|parent| nodes.get(parent as usize)).cloned().flatten();
        let own = (!node.name.is_empty() && is_listed(&node.name)).then(|| node.name.clone());
        nodes.push(own.or_else(above));
    }
    animation.joints.iter().map(|joint| nodes.get(joint.node as usize).cloned().flatten()).collect()
}

/// Returns the listed name of the joints that a triangle follows by more than half.
fn joint_of_triangle<'n>(model: &Model, joints: &'n [Option<String>], triangle: usize) -> Option<&'n String> {
    let mut shares: BTreeMap<&String, f32> = BTreeMap::new();
    for skin in model.mesh.triangles.get(triangle)?.iter().filter_map(|v| model.mesh.skin.get(*v as usize)) {
        for (joint, weight) in skin.joints.iter().zip(skin.weights) {
            if let Some(Some(name)) = joints.get(usize::from(*joint)) {
                *shares.entry(name).or_default() += weight / 3.0;
            }
        }
    }
    let all: f32 = shares.values().sum();
    shares.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)).filter(|_| all > 0.5).map(|(name, _)| name)
}

/// Returns the triangles that nodes or meshes name as bare and whose material other parts use as well.
fn named_triangles(model: &Model, rest: &RestPose) -> BTreeMap<usize, Feature> {
    let parts = &model.mesh.parts;
    let names = without_common_words(parts.iter().map(|p| p.names.iter().map(|n| words(n)).collect()).collect());
    let says_nothing = |m: &Material| meaning_of_words(&words(&m.name)) == NameMeaning::Nothing;
    let shares = part_area_shares(&model.mesh, rest);
    let is_bare =
        |i: usize| matches!(combined_meaning(&names[i]), NameMeaning::Bare { most } if shares[i] <= f64::from(most));
    let mut found = BTreeMap::new();
    for (i, part) in parts.iter().enumerate() {
        let of_material = || (0..parts.len()).filter(|j| parts[*j].material == part.material);
        let silent = model.materials.get(part.material).is_some_and(says_nothing);
        if silent && is_bare(i) && !of_material().all(is_bare) {
            let tells = |name: &&String| matches!(meaning_of_words(&words(name)), NameMeaning::Bare { .. });
            let name = part.names.iter().find(tells).or(part.names.first()).cloned().unwrap_or_default();
            found.extend(triangle_range(part).map(|triangle| (triangle, Feature::Named(name.clone()))));
        }
    }
    found
}

/// Returns the triangles that are bare by shape, position and colour.
fn shaped_triangles(model: &Model, rest: &RestPose) -> BTreeMap<usize, Feature> {
    let mut found = BTreeMap::new();
    let names: Vec<Vec<String>> = model.materials.iter().map(|m| words(&m.name)).collect();
    let mut shares = vec![0.0; model.materials.len()];
    for (part, share) in model.mesh.parts.iter().zip(part_area_shares(&model.mesh, rest)) {
        shares[part.material] += share;
    }
    let is_open = |m: &usize| {
        let (material, name) = (&model.materials[*m], &names[*m]);
        let silent = meaning_of_words(name) == NameMeaning::Nothing && !are_names_of_snout(name);
        silent && material.base_color_image.is_none() && shares[*m] > 0.0 && shares[*m] <= SMALL
    };
    let open: Vec<usize> = (0..model.materials.len()).filter(is_open).collect();
    if open.is_empty() {
        return found;
    }
    let places = weld(&rest.positions);
    let faces = WeldedFaces::new(&model.mesh, &rest.positions, &places, model.materials.len());
    let is_eye = |m: usize| shares[m] <= SMALL && (are_names_of_eyes(&names[m]) || faces.are_round_pairs(m));
    let mut eyes: Vec<bool> = (0..model.materials.len()).map(is_eye).collect();
    let mut skin = FaceMesh::new(model, rest, &places, &eyes);
    if !eyes.contains(&true) {
        for material in unnamed_eyes(&mut skin, &open) {
            eyes[material] = true;
            let triangles = skin.faces.iter().enumerate().filter(|(_, face)| face.material == material);
            found.extend(triangles.map(|(triangle, _)| (triangle, Feature::Eyes)));
        }
    }
    let face = Face::of(&skin, &eyes);
    for material in open.into_iter().filter(|m| !eyes[*m]) {
        let patches = skin.patches(material);
        let claws = are_claws(&skin, &patches);
        for patch in patches.iter().filter(|patch| is_dark(patch)) {
            let feature = if patch.touches_eyes && patch.share <= RIM {
                Feature::EyeRims
            } else if face.as_ref().is_some_and(|face| face.is_nose(&skin, patch)) {
                Feature::Nose
            } else if claws {
                Feature::Claws
            } else {
                continue;
            };
            found.extend(patch.triangles.iter().map(|triangle| (*triangle, feature.clone())));
        }
    }
    found
}

/// Returns the materials of eyes that neither names nor round shapes reveal: pairs of small dark patches in the face,
/// and materials that only surround or highlight these.
///
/// * `open`: materials that may be eyes
fn unnamed_eyes(skin: &mut FaceMesh, open: &[usize]) -> Vec<usize> {
    let dark = DARK.min(DARK_BESIDE * skin.mean_luminance());
    let is_pair = |m: &usize| {
        let patches = skin.patches(*m);
        patches.iter().all(|patch| patch.luminance <= dark) && are_paired_in_face(skin, &patches)
    };
    let mut found: Vec<usize> = open.iter().copied().filter(is_pair).collect();
    found.iter().for_each(|m| skin.add_eyes(*m));
    let is_highlight = |m: &usize| {
        let patches = skin.patches(*m);
        let share: f64 = patches.iter().map(|patch| patch.share).sum();
        share <= EYE && patches.iter().all(|patch| patch.touches_eyes && patch.luminance > dark)
    };
    let highlights: Vec<usize> = open.iter().copied().filter(|m| !found.contains(m) && is_highlight(m)).collect();
    highlights.iter().for_each(|m| skin.add_eyes(*m));
    found.extend(highlights);
    found
}

/// Returns the triangles of eyes that share the only material of a model: pairs of balls, or else of dark patches. All
/// such patches must be few, so that the spots of a coat stay furred.
fn eyes_in_atlas(model: &Model, rest: &RestPose) -> Vec<usize> {
    let mut skin = FaceMesh::new(model, rest, &weld(&rest.positions), &[false]);
    let of_pairs = |skin: &FaceMesh, mut patches: Vec<Patch>, alike: f64| -> Vec<usize> {
        if patches.len() > MOST_SPOTS {
            return Vec::new();
        }
        patches.retain(|patch| can_be_eye(skin, patch, PAINTED_EYE));
        let paired: Vec<&Patch> = patches.iter().filter(|patch| partners(skin, patch, &patches, alike) == 1).collect();
        let are_eyes = matches!(paired.len(), 2 | 4);
        paired.into_iter().filter(|_| are_eyes).flat_map(|patch| patch.triangles.clone()).collect()
    };
    let balls = skin.patches(0).into_iter().filter(Patch::is_ball).collect();
    let eyes = of_pairs(&skin, balls, ALIKE);
    if !eyes.is_empty() {
        return eyes;
    }
    let number = skin.separate_dark(model, 0, [DARK, DARK_BESIDE]);
    let is_spot = |patch: &Patch| is_dark(patch) && can_be_eye(&skin, patch, 1.0);
    let spots = skin.patches(number).into_iter().filter(is_spot).collect();
    of_pairs(&skin, spots, ALIKE_PAINTED)
}

/// Whether a patch is small, flat or bulging, and in the upper half of the body.
///
/// * `most`: maximum area as a share of the mesh's area
fn can_be_eye(skin: &FaceMesh, patch: &Patch, most: f64) -> bool {
    let (low, high) = skin.heights();
    patch.share <= most && patch.center.y > (low + high) / 2.0 && !patch.is_tip()
}

/// Whether patches are one or two pairs of eyes: small and flat or bulging, of equal size, side by side in the upper
/// half, and at one end of the body.
fn are_paired_in_face(skin: &FaceMesh, patches: &[Patch]) -> bool {
    let is_eye = |patch: &Patch| can_be_eye(skin, patch, EYE) && partners(skin, patch, patches, ALIKE) >= 1;
    matches!(patches.len(), 2 | 4) && patches.iter().all(is_eye)
}

/// Returns the number of patches that can be the other eye of a face: equally large, beside `patch`, and at the same
/// end of the body.
///
/// * `alike`: maximum relative difference in area
fn partners(skin: &FaceMesh, patch: &Patch, patches: &[Patch], alike: f64) -> usize {
    let flat = |v: DVec3| v * DVec3::new(1.0, 0.0, 1.0);
    let is_pair = |a: &Patch, b: &Patch| {
        let apart = b.center - a.center;
        let away = flat((a.center + b.center) / 2.0 - skin.middle());
        // The eyes are on both sides of the line from the body's centre to the face.
        let aside = away.dot(apart.normalize_or_zero()).abs();
        apart != DVec3::ZERO
            && (a.share - b.share).abs() <= alike * a.share.max(b.share)
            && apart.y.abs() <= 0.3 * apart.length()
            && apart.length() <= 0.5 * skin.radius()
            && away.length() >= 0.05 * skin.radius()
            && aside <= 0.5 * away.length().max(apart.length())
    };
    patches.iter().filter(|other| is_pair(patch, other)).count()
}

/// Whether a patch is dark, both absolutely and relative to its neighbours.
fn is_dark(patch: &Patch) -> bool {
    patch.luminance <= DARK && patch.beside.is_some_and(|beside| patch.luminance <= DARK_BESIDE * beside)
}

/// Whether all patches of a material are claws: many dark tips, smaller than a paw, each with another of its size, and
/// some near the ground. Symmetry between left and right is not tested, because models may stand with one foot ahead.
fn are_claws(skin: &FaceMesh, patches: &[Patch]) -> bool {
    let is_claw = |patch: &Patch| is_dark(patch) && patch.share <= CLAW && patch.is_tip();
    let (low, high) = skin.heights();
    let on_ground = patches.iter().filter(|patch| patch.lowest <= low + GROUND * (high - low)).count();
    let is_paired = |patch: &Patch| {
        let of_size = patches.iter().filter(|other| (other.share - patch.share).abs() <= ALIKE * patch.share);
        of_size.count() >= 2
    };
    patches.len() >= LEAST_CLAWS && 4 * on_ground >= patches.len() && patches.iter().all(|p| is_claw(p) && is_paired(p))
}

/// Position and orientation of a face, derived from its eyes.
struct Face {
    /// Midpoint between the eyes.
    eyes: DVec3,
    /// Forward direction, horizontal, unit length.
    forward: DVec3,
    /// Half the distance between the eyes, metres.
    half: f64,
}

impl Face {
    /// Derives the face from the eyes. Returns `None` if there are no eyes, or if they do not indicate the front.
    fn of(skin: &FaceMesh, eyes: &[bool]) -> Option<Self> {
        let (mut sum, mut area) = (DVec3::ZERO, 0.0);
        let faces = || skin.faces.iter().filter(|face| eyes[face.material]);
        for face in faces() {
            sum += face.center * face.area;
            area += face.area;
        }
        let eyes = (area > 0.0).then(|| sum / area)?;
        let away = (eyes - skin.middle()) * DVec3::new(1.0, 0.0, 1.0);
        let forward = (away.length() >= 0.05 * skin.radius()).then(|| away.normalize())?;
        let aside = forward.cross(DVec3::Y);
        let half = faces().map(|face| face.area * (face.center - eyes).dot(aside).abs()).sum::<f64>() / area;
        (half > 0.0).then_some(Self { eyes, forward, half })
    }

    /// Whether a patch is a nose. A nose is in front of the midpoint between the eyes and foremost in the face. It is
    /// not much higher than the eyes, and not wider than the distance between them.
    fn is_nose(&self, skin: &FaceMesh, patch: &Patch) -> bool {
        let away = patch.center - self.eyes;
        let aside = self.forward.cross(DVec3::Y);
        let (ahead, off) = (away.dot(self.forward), away.dot(aside).abs());
        let half_width = patch.reach(aside, self.eyes).max(patch.reach(-aside, self.eyes));
        let in_place = ahead > 0.0 && off <= 0.25 * self.half && half_width <= self.half && away.y <= self.half;
        let foremost = || {
            let about = skin.faces.iter().filter(|face| face.center.distance(self.eyes) <= 3.0 * away.length());
            let reach = about.map(|face| (face.center - self.eyes).dot(self.forward)).fold(0.0, f64::max);
            patch.reach(self.forward, self.eyes) >= reach - 0.05 * away.length()
        };
        patch.share <= NOSE && in_place && foremost()
    }
}

/// Assigns the new materials. Parts are split into runs of one material each; unchanged triangles come first.
fn assign_materials(model: &mut Model, found: &BTreeMap<usize, Feature>) {
    let old = std::mem::take(&mut model.mesh.parts);
    let numbers = materials_of(&mut model.materials, &old, found);
    let mut triangles = Vec::with_capacity(model.mesh.triangles.len());
    for part in &old {
        let material = |triangle: &usize| {
            let feature = found.get(triangle);
            let known = numbers.iter().find(|(of, known, _)| *of == part.material && Some(known) == feature);
            known.map_or(part.material, |(.., number)| *number)
        };
        let mut run: Vec<usize> = triangle_range(part).collect();
        run.sort_by_key(|triangle| (found.contains_key(triangle), material(triangle)));
        for run in run.chunk_by(|a, b| material(a) == material(b)) {
            let (first_triangle, triangle_count) = (triangles.len(), run.len());
            let material = run.first().map_or(part.material, material);
            model.mesh.parts.push(MeshPart { material, first_triangle, triangle_count, ..part.clone() });
            triangles.extend(run.iter().filter_map(|triangle| model.mesh.triangles.get(*triangle)));
        }
    }
    model.mesh.triangles = triangles;
}

/// Creates one material for each original material and feature. Returns original material, feature and index of the new
/// one. If a material consists of features only, the first new one replaces it and keeps its index.
fn materials_of(
    materials: &mut Vec<Material>,
    parts: &[MeshPart],
    found: &BTreeMap<usize, Feature>,
) -> Vec<(usize, Feature, usize)> {
    let mut numbers: Vec<(usize, Feature, usize)> = Vec::new();
    for part in parts {
        for feature in triangle_range(part).filter_map(|triangle| found.get(&triangle)) {
            if numbers.iter().any(|(of, known, _)| *of == part.material && known == feature) {
                continue;
            }
            let Some(material) = materials.get(part.material).cloned() else { continue };
            let mut of_it = parts.iter().filter(|p| p.material == part.material).flat_map(triangle_range);
            let is_first = numbers.iter().all(|(of, ..)| *of != part.material);
            let number = if is_first && of_it.all(|triangle| found.contains_key(&triangle)) {
                part.material
            } else {
                materials.push(material.clone());
                materials.len() - 1
            };
            materials[number] = Material { feature: Some(feature.clone()), ..material };
            numbers.push((part.material, feature.clone(), number));
        }
    }
    numbers
}

#[cfg(test)]
#[path = "features_tests.rs"]
mod tests;
