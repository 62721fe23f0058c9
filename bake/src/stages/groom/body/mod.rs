//! How long, flat and dense hair is by the body that it grows on, where a recipe says nothing: short and flat on legs, ears and muzzle and round
//! eyes, long on neck, belly and tail.
//!
//! * `parts`, `words`, `regions`: the part of the body that each joint moves, by its name and by what it hangs on
//! * `thickness`: how thick the body is under each place, which alone tells limbs from trunk where there are no names
//! * `bare`: how far each place is from eyes, nose and mouth
//! * `skin`: places, neighbours, ways along the skin, and the spreading that leaves no edges
//!
//! Nothing here is exact: photographs of animals agree in little more than the order of lengths. What counts is that nothing jumps, that shapes
//! without limbs keep an even coat, and that the longest hair is as long as it was.

mod bare;
mod parts;
mod regions;
mod skin;
mod subject;
mod thickness;
mod words;

use crate::decision::{Decision, metres_in_words};
use crate::noise::smooth_step;
pub(super) use bare::furred_faces;
use glam::Vec3;
use parts::{Growth, Region};
use pelage_formats::Pose;
pub(super) use skin::Skin;
pub use subject::Body;

/// How far values spread over the skin, radii of the body.
const SPREAD: f32 = 0.05;
/// Thickness over that of thick parts from which hair is as short as on the thinnest, and from which it is as long as on the thickest.
const THIN: [f32; 2] = [0.15, 0.65];
/// Length of hair on the thinnest parts over that on the thickest.
const SHORTEST: f32 = 0.25;
/// Lean and density on the thinnest parts.
const THIN_LEAN: f32 = 0.5;
const THIN_DENSITY: f32 = 1.7;
/// The same beside bare parts, with the length over that far from them.
const BARE: Growth = Growth { length: 0.15, lean: 0.5, density: 1.8, by_thickness: 0.0 };
/// Length on the underside of a trunk over that on its back.
const UNDERSIDE: f32 = 1.1;
/// Least difference between the longest and the shortest hair: what varies by less has no parts to tell apart.
const LEAST_SPREAD: f32 = 0.1;
/// What is thicker counts as thick, what is thinner as thin, where there are only those to speak of.
const SPOKEN: [f32; 2] = [0.9, 0.45];
/// Share of the skin below which a part is not spoken of.
const LEAST_SPOKEN: f64 = 0.002;
/// Number of parts.
const PARTS: usize = Region::Unknown as usize + 1;

/// What a body says of the hair on it, one value per vertex of its mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BodyGroom {
    /// Length over that of the longest hair, 0..=1; 1 is reached.
    pub length: Vec<f32>,
    /// Extra lean, 0..=1.
    pub lean: Vec<f32>,
    /// Hairs per area over those on the back, 0.25..=4; `None` where that is not to vary.
    pub density: Option<Vec<f32>>,
    /// Parts of the body that there are, in words, with the mean of `length` on them.
    pub parts: Vec<(&'static str, f32)>,
}

impl BodyGroom {
    /// Looks a body over.
    ///
    /// * `share`: how much counts of what it says, 0..=1
    ///
    /// `None` where it says nothing: no hair grows on it, or all parts of it are alike.
    pub fn of(body: &Body<'_>, share: f32) -> Option<Self> {
        let radius_m = body.bounds.radius;
        if share <= 0.0 || !(radius_m > 0.0 && radius_m.is_finite()) {
            return None;
        }
        let center = Vec3::from(body.bounds.center);
        let skin = Skin::new(body.mesh, body.rest, center, radius_m);
        let furred = bare::furred_places(body, &skin);
        if !furred.contains(&true) {
            return None;
        }
        let thick = relative_thickness(&skin, &furred);
        let parts = parts_of_places(body, &skin, |p| (p - center) / radius_m);
        let bare = bare::nearness(body, &skin);

        let grown: Vec<Growth> = thick.iter().zip(&parts).map(|(thick, parts)| growth(*thick, parts)).collect();
        let channel = |value: fn(&Growth) -> f32| skin.spread(&grown.iter().map(value).collect::<Vec<_>>(), SPREAD);
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
        // After that, since a ball has an underside as well. It needs no spreading: normals are as smooth as the skin.
        let has_names = tells(&parts);
        for (place, length) in length.iter_mut().enumerate() {
            let trunk = if has_names { trunk(&parts[place]) } else { thick[place] };
            *length *= 1.0 + (UNDERSIDE - 1.0) * trunk * (1.0 - bare[place]) * underside(skin.normals[place]);
        }
        let (_, longest) = of_furred(&length);
        length.iter_mut().for_each(|v| *v = 1.0 + share * ((*v / longest).min(1.0) - 1.0));
        lean.iter_mut().for_each(|v| *v *= share);
        density.iter_mut().for_each(|v| *v = (1.0 + share * (*v - 1.0)).clamp(0.25, 4.0));

        let spoken = spoken(&skin, &furred, &parts, &thick, &bare, &length);
        let of_vertices = |values: &[f32]| skin.place_of.iter().map(|place| values[*place as usize]).collect();
        Some(Self {
            length: of_vertices(&length),
            lean: of_vertices(&lean),
            density: Some(of_vertices(&density)),
            parts: spoken,
        })
    }

    /// What was chosen for hair of that length at the longest.
    pub fn decision(&self, share: f32, length_m: f32) -> Decision {
        let parts: Vec<String> =
            self.parts.iter().map(|(part, length)| format!("{part} {}", metres_in_words(length * length_m))).collect();
        Decision {
            what: "length of hair by the body",
            chosen: format!("{} at the longest: {}", metres_in_words(length_m), parts.join(", ")),
            line: format!("groom.by_body = {share}"),
        }
    }
}

/// How much of the way from thin to thick the body is at each place: 0 as legs, 1 as the trunk.
fn relative_thickness(skin: &Skin, furred: &[bool]) -> Vec<f32> {
    let thickness = thickness::thickness(skin);
    let on_fur: Vec<Option<f32>> = thickness.iter().zip(furred).map(|(t, furred)| t.filter(|_| *furred)).collect();
    // Not the thickest: a few rays along the trunk go far.
    let Some(thickest) = skin.quantile(&on_fur, 0.9).filter(|t| *t > 0.0) else { return vec![1.0; skin.len()] };
    // By ratios: a leg is to a trunk what an ear is to a leg.
    let place = |t: f32| libm::logf((t / thickest).max(1e-6));
    let [low, high] = THIN.map(libm::logf);
    thickness.into_iter().map(|t| t.map_or(1.0, |t| smooth_step(low, high, place(t)))).collect()
}

/// Of each place how much of it is which part; the shares sum to 1.
fn parts_of_places(body: &Body<'_>, skin: &Skin, to_skin: impl Fn(Vec3) -> Vec3) -> Vec<[f32; PARTS]> {
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
        // The ruff begins behind the cheeks, while weights of the head fade far down the neck.
        let [head, neck] = [Region::Head, Region::Neck].map(|r| shares[r as usize]);
        if head > 0.0 && neck > 0.0 {
            let given = head * neck / (head + neck);
            shares[Region::Head as usize] -= given;
            shares[Region::Neck as usize] += given;
        }
        parts[*place as usize] = shares;
    }
    if !tells(&parts) {
        return vec![unknown; skin.len()];
    }
    let is_root = |node: &usize| {
        let parent = animation.nodes[*node].parent.and_then(|p| of_nodes.get(p as usize));
        of_nodes[*node] == Region::Head && parent != Some(&Region::Head)
    };
    if let Some(head) = (0..animation.nodes.len()).find(is_root) {
        let mut pose = Pose::default();
        pose.sample(animation, None, 0.0);
        let joint = pose.nodes.get(head).map(|node| to_skin(node.w_axis.truncate()));
        joint.into_iter().for_each(|joint| part_muzzle(skin, joint, &mut parts));
    }
    parts
}

/// Whether any place is known to be more than trunk.
fn tells(parts: &[[f32; PARTS]]) -> bool {
    let told = |p: &[f32; PARTS]| Region::ALL.iter().any(|r| r.tells() && p[*r as usize] > 0.5);
    parts.iter().any(told)
}

/// Parts the muzzle from the head, which few rigs have a joint for: it is what lies before the middle of the head, as seen from the joint that
/// the head hangs on. Heads that stand upright on their joint, as ours do, have none.
fn part_muzzle(skin: &Skin, joint: Vec3, parts: &mut [[f32; PARTS]]) {
    let head = Region::Head as usize;
    if parts.iter().any(|p| p[Region::Muzzle as usize] > 0.5) {
        return;
    }
    let weights = || parts.iter().zip(&skin.areas).map(|(p, area)| p[head] * area);
    let total: f32 = weights().sum();
    if total <= 0.0 {
        return;
    }
    let middle = weights().zip(&skin.positions).map(|(w, p)| *p * w).fold(Vec3::ZERO, |sum, p| sum + p) / total;
    let way = middle - joint;
    let flat = Vec3::new(way.x, way.y.min(0.0), way.z);
    if flat.length() < 0.4 * way.length() {
        return;
    }
    let Some(forward) = flat.try_normalize() else { return };
    let along: Vec<f32> = skin.positions.iter().map(|p| (*p - middle).dot(forward)).collect();
    let of_head: Vec<Option<f32>> = along.iter().zip(&*parts).map(|(a, p)| (p[head] > 0.5).then_some(*a)).collect();
    let Some(tip) = skin.quantile(&of_head, 0.98).filter(|tip| *tip > 0.0) else { return };
    for (parts, along) in parts.iter_mut().zip(along) {
        let share = smooth_step(0.2, 0.7, along / tip) * parts[head];
        parts[head] -= share;
        parts[Region::Muzzle as usize] += share;
    }
}

/// How hair grows on a place of those parts.
fn growth(thick: f32, parts: &[f32; PARTS]) -> Growth {
    let mut sum = Growth { length: 0.0, lean: 0.0, density: 0.0, by_thickness: 0.0 };
    for region in Region::ALL {
        let (weight, here) = (parts[region as usize], region.growth());
        let thin = here.by_thickness * (1.0 - thick);
        sum.length += weight * here.length * (1.0 - thin * (1.0 - SHORTEST));
        sum.lean += weight * here.lean.max(thin * THIN_LEAN);
        sum.density += weight * here.density.max(1.0 + thin * (THIN_DENSITY - 1.0));
    }
    sum
}

/// How much of a place is trunk.
fn trunk(parts: &[f32; PARTS]) -> f32 {
    Region::ALL.iter().filter(|r| r.is_trunk()).map(|r| parts[*r as usize]).sum()
}

/// How much skin of that normal looks down.
fn underside(normal: Vec3) -> f32 {
    smooth_step(0.2, 0.8, -normal.y)
}

/// The parts that there are, with the mean of `length` on them.
fn spoken(
    skin: &Skin,
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
        (total > LEAST_SPOKEN * all).then_some((name, (sum / total) as f32))
    };
    let near_bare = mean("near bare parts", &|p| if bare[p] > 0.5 { 1.0 } else { 0.0 });
    if !tells(parts) {
        let where_thick = |is: fn(f32) -> bool| move |p: usize| if is(thick[p]) && bare[p] < 0.1 { 1.0 } else { 0.0 };
        let found = [
            mean("thick parts", &where_thick(|t| t > SPOKEN[0])),
            mean("thin parts", &where_thick(|t| t < SPOKEN[1])),
            near_bare,
        ];
        return found.into_iter().flatten().collect();
    }
    let of = |regions: &'static [Region]| move |p: usize| regions.iter().map(|r| parts[p][*r as usize]).sum::<f32>();
    let found = [
        mean("neck", &of(&[Region::Neck, Region::Mane])),
        mean("back", &|p| trunk(&parts[p]) * (skin.normals[p].y).max(0.0)),
        mean("belly", &|p| trunk(&parts[p]) * underside(skin.normals[p])),
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
