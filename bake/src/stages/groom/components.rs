//! Detection of bare connected components of rigged models: those that follow joints named as eyes, teeth, tongue or
//! lashes, and small ones inside the head. Avatars have one material for all of these and the skin.

use super::body::{WeldedMesh, are_joints_of_head};
use super::names::{NameMeaning, meaning_of_words, words};
use super::pairs::triangle_range;
use super::words::LASHES;
use crate::stages::triangle_tree::Occluders;
use glam::Vec3;
use obvhs::triangle::Triangle;
use pelage_formats::Animation;
use pelage_import::mesh::{Feature, Model, RestPose};
use std::collections::BTreeMap;

/// Maximum area of a component inside the head, as a share of the mesh's area.
const INSIDE: f32 = 0.01;
/// Minimum share of rays from a component that hit the head. It is half for a flat component on the head, three
/// quarters for a ball that is half embedded, and 1 for teeth in a closed mouth.
const ENCLOSED: f32 = 0.65;
/// Maximum number of triangles of a component from which rays start.
const STARTS: usize = 24;

/// Connected component of the mesh.
#[derive(Clone, Default)]
struct Component {
    faces: Vec<usize>,
    area: f32,
    /// Number of corners that follow joints of the head by more than half.
    in_head: usize,
    /// Number of corners that follow joints with bare names by more than half, and the name of one of these.
    named: usize,
    name: Option<String>,
    /// Maximum share of the mesh's area at which the names count.
    most: f32,
}

/// Returns the triangles of bare components whose material says nothing about hair.
pub(super) fn bare_components(model: &Model, rest: &RestPose) -> BTreeMap<usize, Feature> {
    let mut found = BTreeMap::new();
    let Some(animation) = model.animation.as_ref().filter(|_| !model.mesh.skin.is_empty()) else { return found };
    let bare = bare_joints(animation);
    let heads = are_joints_of_head(animation);
    if !heads.contains(&true) && bare.iter().all(Option::is_none) {
        return found;
    }
    let skin = WeldedMesh::new(&model.mesh, rest, Vec3::ZERO, 1.0);
    let components = components(model, &skin, &bare, &heads);
    let whole: f32 = components.iter().map(|c| c.area).sum();
    let head = components.iter().filter(|c| c.in_head > 0).max_by(|a, b| a.area.total_cmp(&b.area));
    let head = head.map(|head| (head.faces.first(), occluders(&skin, head)));
    let mut feature_of: BTreeMap<usize, Feature> = BTreeMap::new();
    for component in &components {
        let (corners, share) = (3 * component.faces.len(), component.area / whole.max(f32::MIN_POSITIVE));
        let named = component.name.as_ref().filter(|_| component.named == corners && share <= component.most);
        let is_inside = || {
            let rooted = component.in_head == corners && share > 0.0 && share <= INSIDE;
            let other = head.as_ref().filter(|(first, _)| *first != component.faces.first());
            rooted && other.is_some_and(|(_, head)| enclosure(head, &skin, component) >= ENCLOSED)
        };
        let feature = named.map(|name| Feature::Joint(name.clone())).or_else(|| is_inside().then_some(Feature::InHead));
        if let Some(feature) = feature {
            feature_of.extend(component.faces.iter().map(|face| (*face, feature.clone())));
        }
    }
    for part in &model.mesh.parts {
        let silent = |m: &pelage_import::mesh::Material| meaning_of_words(&words(&m.name)) == NameMeaning::Nothing;
        if model.materials.get(part.material).is_some_and(silent) {
            found.extend(triangle_range(part).filter_map(|t| Some((t, feature_of.remove(&t)?))));
        }
    }
    found
}

/// Returns for each joint whose name stands for something bare: name, and the maximum share of the mesh's area.
fn bare_joints(animation: &Animation) -> Vec<Option<(&str, f32)>> {
    let of_joint = |joint: &pelage_formats::Joint| {
        let name = animation.nodes.get(joint.node as usize)?.name.as_str();
        let words = words(name);
        let is_lash = words.iter().any(|word| LASHES.contains(&word.as_str()));
        match meaning_of_words(&words) {
            NameMeaning::Bare { most } => Some((name, most)),
            _ => is_lash.then_some((name, INSIDE)),
        }
    };
    animation.joints.iter().map(of_joint).collect()
}

fn components(model: &Model, skin: &WeldedMesh, bare: &[Option<(&str, f32)>], heads: &[bool]) -> Vec<Component> {
    let mut all: Vec<Component> = Vec::new();
    for (index, (face, triangle)) in skin.faces.iter().zip(&model.mesh.triangles).enumerate() {
        let piece = skin.pieces[face[0] as usize] as usize;
        if piece >= all.len() {
            all.resize(piece + 1, Component { most: 1.0, ..Component::default() });
        }
        let component = &mut all[piece];
        component.faces.push(index);
        let [a, b, c] = face.map(|place| skin.positions[place as usize]);
        component.area += (b - a).cross(c - a).length() / 2.0;
        for bound in triangle.iter().filter_map(|v| model.mesh.skin.get(*v as usize)) {
            let weights = || bound.joints.iter().map(|joint| usize::from(*joint)).zip(bound.weights);
            let of_head = weights().filter(|(joint, _)| heads.get(*joint) == Some(&true));
            component.in_head += usize::from(of_head.map(|(_, weight)| weight).sum::<f32>() > 0.5);
            let named = weights().filter_map(|(joint, weight)| Some((bare.get(joint).copied().flatten()?, weight)));
            let named: Vec<_> = named.filter(|(_, weight)| *weight > 0.0).collect();
            if named.iter().map(|(_, weight)| weight).sum::<f32>() > 0.5 {
                component.named += 1;
                component.most = named.iter().map(|((_, most), _)| *most).fold(component.most, f32::min);
                component.name =
                    component.name.take().or_else(|| named.first().map(|((name, _), _)| (*name).to_owned()));
            }
        }
    }
    all.retain(|component| !component.faces.is_empty());
    all
}

/// Returns the surface of the head, which blocks rays.
fn occluders(skin: &WeldedMesh, head: &Component) -> Occluders {
    let facet = |face: &usize| {
        let [v0, v1, v2] = skin.faces[*face].map(|place| skin.positions[place as usize].into());
        Triangle { v0, v1, v2 }
    };
    Occluders::new(&head.faces.iter().map(facet).collect::<Vec<_>>())
}

/// Returns the share of rays from a component, in all directions, that hit the head.
fn enclosure(head: &Occluders, skin: &WeldedMesh, component: &Component) -> f32 {
    let sides = [-1.0, 0.0, 1.0];
    let ways = || (0..27).filter(|i| *i != 13).map(|i| Vec3::new(sides[i / 9], sides[i / 3 % 3], sides[i % 3]));
    let step = component.faces.len().div_ceil(STARTS).max(1);
    let (mut blocked, mut all) = (0_u32, 0_u32);
    for face in component.faces.iter().step_by(step) {
        let from = skin.faces[*face].map(|place| skin.positions[place as usize]).into_iter().sum::<Vec3>() / 3.0;
        for way in ways() {
            (blocked, all) = (blocked + u32::from(!head.is_open(from, way.normalize())), all + 1);
        }
    }
    blocked as f32 / all.max(1) as f32
}

#[cfg(test)]
#[path = "components_tests.rs"]
mod tests;
