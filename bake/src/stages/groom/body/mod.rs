//! Automatic groom: length, lean and density of hair, derived from the shape of the body where a recipe sets nothing.
//! Hair is short and flat on legs, ears and muzzle and around eyes, and long on neck, belly and tail.
//!
//! * `parts`, `words`, `regions`: the body part that each joint moves, from its name and its ancestors
//! * `thickness`: thickness of the body at each welded vertex, the only cue for limbs and trunk without names
//! * `bare`: distance from eyes, nose and mouth
//! * `head`: comb direction of the head, away from the tip of the nose
//! * `shape`, `tips`: head of a body without joints, by its ears, nose and symmetry
//! * `welded_mesh`: welded vertices, neighbours, distances along the surface, and smoothing
//!
//! The result is approximate, because photographs of animals agree in little more than the order of lengths. The groom
//! must not have jumps, must be even on shapes without limbs, and must not change the length of the longest hair.

mod bare;
mod head;
mod input;
mod parts;
mod regions;
mod shape;
mod thickness;
mod tips;
mod welded_mesh;
mod words;

use crate::decision::{Decision, metres_in_words};
use crate::noise::smooth_step;
pub(super) use bare::furred_faces;
use glam::Vec3;
pub(crate) use head::BodyHead;
pub use head::HeadShape;
pub use input::Body;
use parts::{PartGroom, Region};
use pelage_formats::Animation;
use pelage_import::mesh::RestPose;
pub(crate) use thickness::thickness;
pub(crate) use welded_mesh::WeldedMesh;

/// Width of the smoothing over the surface, in body radii.
const SPREAD: f32 = 0.05;
/// Range of thickness over which the hair length rises from its minimum to its maximum. Thick parts have thickness 1.
const THIN: [f32; 2] = [0.15, 0.65];
/// Hair length on the thinnest parts relative to the thickest.
const SHORTEST: f32 = 0.25;
/// Lean and density on the thinnest parts.
const THIN_LEAN: f32 = 0.5;
const THIN_DENSITY: f32 = 1.7;
/// Groom beside bare parts. The length is relative to that of hair far from bare parts.
const BARE: PartGroom = PartGroom { length: 0.15, lean: 0.5, density: 1.8, by_thickness: 0.0 };
/// Hair length on the underside of a trunk relative to its back.
const UNDERSIDE: f32 = 1.1;
/// Minimum relative difference between the longest and the shortest hair. Bodies that vary less have no distinct parts.
const LEAST_SPREAD: f32 = 0.1;
/// Overhang of hair at the sole of a limb, relative to the limb's thickness: a quarter of its radius.
const OVERHANG: f32 = 0.125;
/// Maximum vertical component of the normals of a sole's triangles.
const SOLE_NORMAL: f32 = -0.6;
/// Maximum height above the body's lowest point of soles without names, in body radii.
const SOLE_HEIGHT: f32 = 0.03;
/// Minimum relative thickness of parts that are reported as thick, and maximum for thin ones. Reports use them for
/// bodies without named parts.
const REPORTED_THICKNESS: [f32; 2] = [0.9, 0.45];
/// Minimum share of the body's area for a part to be reported.
const MIN_REPORTED_SHARE: f64 = 0.002;
/// Number of body parts.
const PARTS: usize = Region::Unknown as usize + 1;

/// Groom derived from a body, one value per vertex of its mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BodyGroom {
    /// Length relative to the longest hair, 0..=1; the maximum is 1.
    pub length: Vec<f32>,
    /// Extra lean, 0..=1.
    pub lean: Vec<f32>,
    /// Hairs per area relative to the back, 0.25..=4; `None` if the density must not vary.
    pub density: Option<Vec<f32>>,
    /// Names of the body parts found, with the mean of `length` on each.
    pub parts: Vec<(&'static str, f32)>,
}

impl BodyGroom {
    /// Derives a groom from a body.
    ///
    /// * `share`: weight of the automatic groom, 0..=1
    /// * `length_m`: length of the longest hair, metres
    ///
    /// Returns `None` if no hair grows on the body, or if its parts do not differ.
    pub fn of(body: &Body<'_>, share: f32, length_m: f32) -> Option<Self> {
        let radius_m = body.bounds.radius;
        if share <= 0.0 || !(radius_m > 0.0 && radius_m.is_finite()) {
            return None;
        }
        let center = Vec3::from(body.bounds.center);
        let skin = WeldedMesh::new(body.mesh, body.rest, center, radius_m);
        let furred = bare::furred_places(body, &skin);
        if !furred.contains(&true) {
            return None;
        }
        let thickness = thickness(&skin);
        let thick = relative_thickness(&skin, &furred, &thickness);
        let parts = parts_of_places(body, &skin, |p| (p - center) / radius_m);
        let bare = bare::proximity(body, &skin);

        let grown: Vec<PartGroom> = thick.iter().zip(&parts).map(|(thick, parts)| mixed_groom(*thick, parts)).collect();
        let channel = |value: fn(&PartGroom) -> f32| skin.spread(&grown.iter().map(value).collect::<Vec<_>>(), SPREAD);
        let (mut length, mut lean, mut density) = (channel(|g| g.length), channel(|g| g.lean), channel(|g| g.density));
        let near = |value: &mut [f32], bare_value: &dyn Fn(f32) -> f32| {
            value.iter_mut().zip(&bare).for_each(|(v, near)| *v += near * (bare_value(*v) - *v));
        };
        near(&mut length, &|v| v.min(BARE.length));
        near(&mut lean, &|v| v.max(BARE.lean));
        near(&mut density, &|v| v.max(BARE.density));

        let of_furred = |values: &[f32]| -> (f32, f32) {
            let there = values.iter().zip(&furred).filter(|(_, furred)| **furred).map(|(v, _)| *v);
            there.fold((f32::INFINITY, 0.0), |(low, high), v| (low.min(v), high.max(v)))
        };
        let (low, high) = of_furred(&length);
        if high - low < LEAST_SPREAD * high {
            return None;
        }
        // The underside is lengthened only after the test above, because even a sphere has an underside. The factor
        // needs no smoothing, because normals are smooth.
        let has_names = has_specific_parts(&parts);
        for (place, length) in length.iter_mut().enumerate() {
            let trunk = if has_names { trunk_weight(&parts[place]) } else { thick[place] };
            *length *= 1.0 + (UNDERSIDE - 1.0) * trunk * (1.0 - bare[place]) * underside_weight(skin.normals[place]);
        }
        let (_, longest) = of_furred(&length);
        let soles = sole_distances(&skin, &parts, &thick, &thickness, length_m / radius_m);
        for (length, sole) in length.iter_mut().zip(soles) {
            *length = 1.0 + share * ((*length / longest).min(1.0).min(sole * radius_m / length_m) - 1.0);
        }
        lean.iter_mut().for_each(|v| *v *= share);
        density.iter_mut().for_each(|v| *v = (1.0 + share * (*v - 1.0)).clamp(0.25, 4.0));

        let spoken = reported_parts(&skin, &furred, &parts, &thick, &bare, &length);
        let of_vertices = |values: &[f32]| skin.place_of.iter().map(|place| values[*place as usize]).collect();
        Some(Self {
            length: of_vertices(&length),
            lean: of_vertices(&lean),
            density: Some(of_vertices(&density)),
            parts: spoken,
        })
    }

    /// Describes the chosen lengths for a longest hair of length `length_m`, metres.
    pub fn decision(&self, share: f32, length_m: f32) -> Decision {
        let parts: Vec<String> =
            self.parts.iter().map(|(part, length)| format!("{part} {}", metres_in_words(length * length_m))).collect();
        Decision {
            what: "length of hair by part of the body",
            chosen: format!("at most {}: {}", metres_in_words(length_m), parts.join(", ")),
            line: format!("groom.by_body = {share}"),
        }
    }
}

/// Returns the relative thickness of the body at each welded vertex: 0 for legs, 1 for the trunk.
fn relative_thickness(skin: &WeldedMesh, furred: &[bool], thickness: &[Option<f32>]) -> Vec<f32> {
    let on_fur: Vec<Option<f32>> = thickness.iter().zip(furred).map(|(t, furred)| t.filter(|_| *furred)).collect();
    // Use a quantile instead of the maximum, because a few rays along the trunk are very long.
    let Some(thickest) = skin.quantile(&on_fur, 0.9).filter(|t| *t > 0.0) else { return vec![1.0; skin.len()] };
    // Interpolate logarithmically: the ratio of leg to trunk is about that of ear to leg.
    let place = |t: f32| libm::logf((t / thickest).max(1e-6));
    let [low, high] = THIN.map(libm::logf);
    thickness.iter().map(|t| t.map_or(1.0, |t| smooth_step(low, high, place(t)))).collect()
}

/// Returns the maximum hair length at each welded vertex, in body radii, so that hair that lies flat along a limb does
/// not stick out beyond its sole: the distance from the nearest sole along the surface, plus [`OVERHANG`] there. It is
/// infinite from `longest` on.
///
/// Soles are undersides of feet. On bodies without named parts, they are undersides of thin parts at the lowest points.
fn sole_distances(
    skin: &WeldedMesh,
    parts: &[[f32; PARTS]],
    thick: &[f32],
    thickness: &[Option<f32>],
    longest: f32,
) -> Vec<f32> {
    let lowest = skin.positions.iter().map(|p| p.y).fold(f32::INFINITY, f32::min);
    let has_names = has_specific_parts(parts);
    let is_end = |place: usize| match has_names {
        true => parts[place][Region::Foot as usize] > 0.5,
        false => thick[place] < 0.5 && skin.positions[place].y < lowest + SOLE_HEIGHT,
    };
    // The heel of a coarse foot often follows the leg alone, so one corner in the foot suffices.
    let is_sole = |face: &&[u32; 3]| {
        let [a, b, c] = face.map(|place| skin.positions[place as usize]);
        let is_underside = (b - a).cross(c - a).normalize_or_zero().y < SOLE_NORMAL;
        is_underside && face.iter().any(|place| is_end(*place as usize))
    };
    let of_sole = skin.faces.iter().filter(is_sole).flatten();
    skin.distances(of_sole.filter_map(|place| Some((*place, OVERHANG * thickness[*place as usize]?))), longest)
}

/// Returns for each joint whether it moves the head, the face or the muzzle.
pub(crate) fn are_joints_of_head(animation: &Animation) -> Vec<bool> {
    let regions = regions::of_nodes(animation);
    let is_head = |region: &Region| matches!(region, Region::Head | Region::Face | Region::Muzzle);
    animation.joints.iter().map(|joint| regions.get(joint.node as usize).is_some_and(is_head)).collect()
}

/// Returns the weights of all body parts at each welded vertex; they sum to 1.
fn parts_of_places(body: &Body<'_>, skin: &WeldedMesh, to_skin: impl Fn(Vec3) -> Vec3) -> Vec<[f32; PARTS]> {
    let mut unknown = [0.0; PARTS];
    unknown[Region::Unknown as usize] = 1.0;
    let mut parts = vec![unknown; skin.len()];
    let Some(animation) = body.animation.filter(|_| !body.mesh.skin.is_empty()) else { return parts };
    let of_nodes = regions::of_nodes(animation);
    let of_joint = |joint: u16| {
        let joint = animation.joints.get(usize::from(joint))?;
        of_nodes.get(joint.node as usize).copied()
    };
    for (place, weights) in skin.place_of.iter().zip(&body.mesh.skin) {
        let mut shares = [0.0; PARTS];
        for (joint, weight) in weights.joints.iter().zip(weights.weights) {
            shares[of_joint(*joint).unwrap_or(Region::Unknown) as usize] += weight;
        }
        // Move weight from the head to the neck: the ruff begins behind the cheeks, but the head's weights fade far
        // down the neck.
        let [head, neck] = [Region::Head, Region::Neck].map(|r| shares[r as usize]);
        if head > 0.0 && neck > 0.0 {
            let given = head * neck / (head + neck);
            shares[Region::Head as usize] -= given;
            shares[Region::Neck as usize] += given;
        }
        parts[*place as usize] = shares;
    }
    if !has_specific_parts(&parts) {
        return vec![unknown; skin.len()];
    }
    if let Some(joint) = head_joint(animation, &of_nodes) {
        split_muzzle(skin, to_skin(joint), &mut parts);
    }
    parts
}

/// Returns the position at rest, metres, of the first joint of the head.
fn head_joint(animation: &Animation, regions: &[Region]) -> Option<Vec3> {
    let is_root = |node: &usize| {
        let parent = animation.nodes[*node].parent.and_then(|p| regions.get(p as usize));
        regions[*node] == Region::Head && parent != Some(&Region::Head)
    };
    let head = (0..animation.nodes.len()).find(is_root)?;
    RestPose::pose(animation).nodes.get(head).map(|node| node.w_axis.truncate())
}

/// Whether any welded vertex belongs mostly to a part that identifies its location on the body.
fn has_specific_parts(parts: &[[f32; PARTS]]) -> bool {
    let told = |p: &[f32; PARTS]| Region::ALL.iter().any(|r| r.is_specific() && p[*r as usize] > 0.5);
    parts.iter().any(told)
}

/// Separates the muzzle from the head, because few rigs have a joint for it. The muzzle is the part in front of the
/// head's centre, seen from the head's joint. Heads that are upright on their joint, such as human ones, have no
/// muzzle.
fn split_muzzle(skin: &WeldedMesh, joint: Vec3, parts: &mut [[f32; PARTS]]) {
    let head = Region::Head as usize;
    if parts.iter().any(|p| p[Region::Muzzle as usize] > 0.5) {
        return;
    }
    let weights: Vec<f32> = parts.iter().map(|p| p[head]).collect();
    let Some(HeadAxis { middle, forward }) = HeadAxis::new(skin, joint, &weights) else { return };
    let along: Vec<f32> = skin.positions.iter().map(|p| (*p - middle).dot(forward)).collect();
    let of_head: Vec<Option<f32>> = along.iter().zip(&*parts).map(|(a, p)| (p[head] > 0.5).then_some(*a)).collect();
    let Some(tip) = skin.quantile(&of_head, 0.98).filter(|tip| *tip > 0.0) else { return };
    for (parts, along) in parts.iter_mut().zip(along) {
        let share = smooth_step(0.2, 0.7, along / tip) * parts[head];
        parts[head] -= share;
        parts[Region::Muzzle as usize] += share;
    }
}

/// Line through a head that has a muzzle.
struct HeadAxis {
    /// Centre of the head's surface.
    middle: Vec3,
    /// Unit direction towards the muzzle, horizontal or falling.
    forward: Vec3,
}

impl HeadAxis {
    /// Returns the axis of a head; `None` if the head is upright on `joint`.
    ///
    /// * `weights`: share of the head at each welded vertex
    fn new(skin: &WeldedMesh, joint: Vec3, weights: &[f32]) -> Option<Self> {
        let weighed = || weights.iter().zip(&skin.areas).map(|(weight, area)| weight * area);
        let total: f32 = weighed().sum();
        if total <= 0.0 {
            return None;
        }
        let middle = weighed().zip(&skin.positions).map(|(w, p)| *p * w).fold(Vec3::ZERO, |sum, p| sum + p) / total;
        let way = middle - joint;
        let flat = Vec3::new(way.x, way.y.min(0.0), way.z);
        let forward = flat.try_normalize().filter(|_| flat.length() >= 0.4 * way.length())?;
        Some(Self { middle, forward })
    }
}

/// Returns the groom of a mixture of body parts.
///
/// * `thick`: relative thickness of the body, 0..=1
/// * `parts`: weight of each part
fn mixed_groom(thick: f32, parts: &[f32; PARTS]) -> PartGroom {
    let mut sum = PartGroom { length: 0.0, lean: 0.0, density: 0.0, by_thickness: 0.0 };
    for region in Region::ALL {
        let (weight, here) = (parts[region as usize], region.groom());
        let thin = here.by_thickness * (1.0 - thick);
        sum.length += weight * here.length * (1.0 - thin * (1.0 - SHORTEST));
        sum.lean += weight * here.lean.max(thin * THIN_LEAN);
        sum.density += weight * here.density.max(1.0 + thin * (THIN_DENSITY - 1.0));
    }
    sum
}

/// Returns the total weight of the parts of the trunk.
fn trunk_weight(parts: &[f32; PARTS]) -> f32 {
    Region::ALL.iter().filter(|r| r.is_trunk()).map(|r| parts[*r as usize]).sum()
}

/// Returns how far a normal points down, 0..=1, with a smooth transition.
fn underside_weight(normal: Vec3) -> f32 {
    smooth_step(0.2, 0.8, -normal.y)
}

/// Returns the body parts found, with the mean of `length` on each.
fn reported_parts(
    skin: &WeldedMesh,
    furred: &[bool],
    parts: &[[f32; PARTS]],
    thick: &[f32],
    bare: &[f32],
    length: &[f32],
) -> Vec<(&'static str, f32)> {
    let mean = |name: &'static str, weight: &dyn Fn(usize) -> f32| {
        let (mut sum, mut total, mut all) = (0.0, 0.0, 0.0);
        for place in (0..skin.len()).filter(|place| furred[*place]) {
            let area = f64::from(skin.areas[place]);
            let weighed = area * f64::from(weight(place));
            sum += weighed * f64::from(length[place]);
            total += weighed;
            all += area;
        }
        (total > MIN_REPORTED_SHARE * all).then_some((name, (sum / total) as f32))
    };
    let near_bare = mean("near bare parts", &|p| if bare[p] > 0.5 { 1.0 } else { 0.0 });
    if !has_specific_parts(parts) {
        let where_thick = |is: fn(f32) -> bool| move |p: usize| if is(thick[p]) && bare[p] < 0.1 { 1.0 } else { 0.0 };
        let found = [
            mean("thick parts", &where_thick(|t| t > REPORTED_THICKNESS[0])),
            mean("thin parts", &where_thick(|t| t < REPORTED_THICKNESS[1])),
            near_bare,
        ];
        return found.into_iter().flatten().collect();
    }
    let of = |regions: &'static [Region]| move |p: usize| regions.iter().map(|r| parts[p][*r as usize]).sum::<f32>();
    let found = [
        mean("neck", &of(&[Region::Neck, Region::Mane])),
        mean("back", &|p| trunk_weight(&parts[p]) * (skin.normals[p].y).max(0.0)),
        mean("belly", &|p| trunk_weight(&parts[p]) * underside_weight(skin.normals[p])),
        mean("legs", &of(&[Region::UpperLeg, Region::LowerLeg])),
        mean("feet", &of(&[Region::Foot])),
        mean("head", &of(&[Region::Head, Region::Face])),
        mean("ears", &of(&[Region::Ear])),
        mean("muzzle", &of(&[Region::Muzzle])),
        mean("tail", &of(&[Region::Tail])),
        mean("wings", &of(&[Region::Wing])),
        near_bare,
    ];
    found.into_iter().flatten().collect()
}

#[cfg(test)]
mod tests;
