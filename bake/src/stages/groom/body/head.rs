//! Comb direction of a head: from the tip of the nose over brow, cheeks and jaw to the neck.
//!
//! A single direction for the whole body is along the normal somewhere on the face, and hair would radiate from there.
//! Distances along the surface grow from the tip of the nose, so their gradient vanishes only at the tip, at the tips
//! of the ears, and behind the ears.
//!
//! Names of joints tell which part is the head. Without them, a narrow place between two thick ones is a neck.

use super::input::Body;
use super::parts::Region;
use super::welded_mesh::WeldedMesh;
use super::{HeadAxis, PARTS, bare, head_joint, parts_of_places, regions};
use crate::noise::smooth_step;
use crate::stages::groom::geodesic::geodesic_distances;
use glam::Vec3;

/// Foremost share of the head's length whose centre is in line with the tip of the nose.
const FOREMOST: f32 = 0.1;
/// Radius around the tip of the nose within which distances are straight, divided by the head's length.
const TIP: f32 = 0.06;
/// Width of the transition from the head to the rest of the body, divided by the head's length.
const TRANSITION: f32 = 0.3;
/// Maximum distance over which directions are smoothed on the head, divided by its length. With more, the tip of the
/// nose would not be where hair radiates from.
const SMOOTHING: f32 = 0.1;
/// Greatest distance from the tip of the nose, divided by the head's length.
const REACH: f32 = 4.0;
/// Number of intervals of the distance from the tip of the nose in which the girth is measured.
const INTERVALS: usize = 48;
/// Maximum girth of a neck, relative to the head before it.
const NECK: f32 = 0.85;
/// Range of a trunk's girth relative to the head's. The mouth of a jug is narrower, and a fish has no neck.
const TRUNK: [f32; 2] = [1.05, 3.5];
/// Range of a head's share of the whole area.
const SHARE: [f32; 2] = [0.03, 0.5];
/// Greatest distance of a nose from the middle plane of a body without names, and below its middle, in body radii.
const ASIDE: f32 = 0.1;

/// Returns the wanted comb direction of each vertex of the mesh, at rest: on the head away from the tip of the nose,
/// and `elsewhere` on the rest of the body. Lengths are weights: 1 on the body, and more on the head. Returns `None` if
/// the body has no head with a snout.
///
/// * `elsewhere`: unit vector
/// * `smoothing_m`: distance over which directions of weight 1 are smoothed, metres, above 0
pub(crate) fn comb_of_head(body: &Body<'_>, elsewhere: Vec3, smoothing_m: f32) -> Option<Vec<Vec3>> {
    let radius_m = body.bounds.radius;
    if !(radius_m > 0.0 && radius_m.is_finite()) {
        return None;
    }
    let center = Vec3::from(body.bounds.center);
    let to_skin = |p: Vec3| (p - center) / radius_m;
    let skin = WeldedMesh::new(body.mesh, body.rest, center, radius_m);
    let furred = bare::furred_places(body, &skin);
    let animation = body.animation.filter(|_| !body.mesh.skin.is_empty());
    let head = match animation.and_then(|animation| head_joint(animation, &regions::of_nodes(animation))) {
        Some(joint) => Head::of_rig(&skin, &furred, to_skin(joint), &parts_of_places(body, &skin, to_skin)),
        None => Head::of_shape(&skin, &furred, elsewhere),
    }?;
    let away = directions_away(&skin, &head.nose);
    let share = skin.spread(&head.share, TRANSITION * head.nose.head_length);
    let finer = smoothing_m / (SMOOTHING * head.nose.head_length * radius_m);
    let weight = (finer * finer).max(1.0);
    let wish = |place: usize| elsewhere.lerp(away[place], share[place]) * (1.0 + share[place] * (weight - 1.0));
    Some(skin.place_of.iter().map(|place| wish(*place as usize)).collect())
}

/// Head with a snout.
struct Head {
    /// Share of the head at each welded vertex, 0..=1.
    share: Vec<f32>,
    nose: Nose,
}

impl Head {
    /// Returns the head by the names of joints.
    ///
    /// * `joint`: position of the head's first joint
    /// * `parts`: weights of the body parts at each welded vertex
    fn of_rig(skin: &WeldedMesh, furred: &[bool], joint: Vec3, parts: &[[f32; PARTS]]) -> Option<Self> {
        let share = |regions: &[Region]| -> Vec<f32> {
            parts.iter().map(|parts| regions.iter().map(|r| parts[*r as usize]).sum()).collect()
        };
        // Ears stand above the head and would make its axis steeper.
        let skull = share(&[Region::Head, Region::Face, Region::Muzzle]);
        let axis = HeadAxis::new(skin, joint, &skull)?;
        let nose = Nose::new(skin, furred, &skull, &axis)?;
        let share = share(&[Region::Head, Region::Face, Region::Muzzle, Region::Ear]);
        Some(Self { share, nose })
    }

    /// Returns the head of a body without names: the part before the first narrow place behind the foremost point. It
    /// is in the upper half of the body, and not upright on its neck.
    fn of_shape(skin: &WeldedMesh, furred: &[bool], elsewhere: Vec3) -> Option<Self> {
        let forward = Vec3::new(-elsewhere.x, 0.0, -elsewhere.z).try_normalize()?;
        let whole = HeadAxis { middle: Vec3::ZERO, forward };
        let first = Nose::new(skin, furred, &vec![1.0; skin.len()], &whole)?;
        if first.at.y < -ASIDE || first.at.dot(forward.cross(Vec3::Y)).abs() > ASIDE {
            return None;
        }
        let distances = first.distances(skin, f32::INFINITY);
        let (neck, width) = neck_distance(skin, &distances)?;
        let share: Vec<f32> = distances.iter().map(|d| 1.0 - smooth_step(0.8 * neck, 1.2 * neck, *d)).collect();
        let area = |is_there: &dyn Fn(f32) -> bool| -> (f32, Vec3) {
            let there = distances.iter().zip(skin.areas.iter().zip(&skin.positions)).filter(|(d, _)| is_there(**d));
            there.fold((0.0, Vec3::ZERO), |(area, sum), (_, (a, p))| (area + a, sum + *p * *a))
        };
        let (ring, sum) = area(&|d| (d - neck).abs() <= width);
        let part = area(&|d| d < neck).0 / area(&|_| true).0;
        if !(SHARE[0]..=SHARE[1]).contains(&part) {
            return None;
        }
        let axis = HeadAxis::new(skin, sum / ring.max(f32::MIN_POSITIVE), &share)?;
        let nose = Nose::new(skin, furred, &share, &axis)?;
        Some(Self { share, nose })
    }
}

/// Returns the distance from the tip of the nose at which a neck is narrowest, and the width of the interval there.
/// `None` if no narrow place lies between a head and a thicker trunk.
fn neck_distance(skin: &WeldedMesh, distances: &[f32]) -> Option<(f32, f32)> {
    let farthest = distances.iter().copied().filter(|d| d.is_finite()).fold(0.0, f32::max);
    let width = farthest / INTERVALS as f32;
    if width <= 0.0 {
        return None;
    }
    // Area of each interval: the girth times the width. Faces are distributed over the range of their corners.
    let mut girth = [0.0; INTERVALS];
    for face in &skin.faces {
        let at = face.map(|place| distances[place as usize]);
        let (low, high) = (at.into_iter().fold(f32::INFINITY, f32::min), at.into_iter().fold(0.0, f32::max));
        if !high.is_finite() {
            continue;
        }
        let [a, b, c] = face.map(|place| skin.positions[place as usize]);
        let interval = |d: f32| ((d / width) as usize).min(INTERVALS - 1);
        let (first, last) = (interval(low), interval(high));
        let area = (b - a).cross(c - a).length() / (last - first + 1) as f32;
        girth[first..=last].iter_mut().for_each(|sum| *sum += area);
    }
    let smooth = |k: usize| {
        let at = |k: usize| girth.get(k).copied().unwrap_or(0.0);
        (at(k.wrapping_sub(1)) + 2.0 * at(k) + at(k + 1)) / 4.0
    };
    let (mut head, mut neck): (f32, Option<(f32, usize)>) = (0.0, None);
    let mut found = None;
    for k in 0..INTERVALS {
        let here = smooth(k);
        match neck {
            Some((_, narrowest)) if here > TRUNK[0] * head => found = found.or(Some(narrowest)),
            Some((least, _)) if here < least => neck = Some((here, k)),
            Some(_) => {}
            None if here < NECK * head => neck = Some((here, k)),
            None => head = head.max(here),
        }
    }
    let trunk = (0..INTERVALS).map(smooth).fold(0.0, f32::max);
    found.filter(|_| trunk <= TRUNK[1] * head).map(|k| ((k as f32 + 0.5) * width, width))
}

/// Tip of the nose. Lengths are in mesh radii.
struct Nose {
    at: Vec3,
    /// Furred vertex nearest to the tip.
    place: u32,
    /// Length of the head along its axis.
    head_length: f32,
}

impl Nose {
    /// Finds the tip of the nose: the foremost point of the furred surface of the head, in line with the centre of the
    /// snout's end. `None` if no hair grows on the head.
    ///
    /// * `skull`: share of the head at each welded vertex
    fn new(skin: &WeldedMesh, furred: &[bool], skull: &[f32], axis: &HeadAxis) -> Option<Self> {
        let places = || (0..skin.len()).filter(|place| furred[*place] && skull[*place] > 0.5);
        let along = |place: usize| (skin.positions[place] - axis.middle).dot(axis.forward);
        let (back, front) =
            places().map(along).fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), a| (low.min(a), high.max(a)));
        let head_length = front - back;
        if !(head_length > 0.0 && head_length.is_finite()) {
            return None;
        }
        let foremost = || places().filter(|place| along(*place) > front - FOREMOST * head_length);
        let area: f32 = foremost().map(|place| skin.areas[place]).sum();
        let sum = foremost().map(|place| skin.positions[place] * skin.areas[place]).fold(Vec3::ZERO, |sum, p| sum + p);
        let end = sum / area.max(f32::MIN_POSITIVE);
        let off_axis = |place: usize| (skin.positions[place] - end).reject_from_normalized(axis.forward).length();
        let score = |place: &usize| along(*place) - 2.0 * off_axis(*place);
        let place = places().max_by(|a, b| score(a).total_cmp(&score(b)))?;
        let at = end + axis.forward * (along(place) - (end - axis.middle).dot(axis.forward));
        Some(Self { at, place: place as u32, head_length })
    }

    /// Returns the distance of each welded vertex from the tip along the surface; infinite beyond `reach` and on other
    /// connected components.
    fn distances(&self, skin: &WeldedMesh, reach: f32) -> Vec<f32> {
        let piece = skin.pieces[self.place as usize];
        let straight = |place: u32| skin.positions[place as usize].distance(self.at);
        let is_near = |place: &u32| {
            skin.pieces[*place as usize] == piece && straight(*place) <= TIP * self.head_length || *place == self.place
        };
        let seeds: Vec<(u32, f32)> = (0..skin.len() as u32).filter(is_near).map(|p| (p, straight(p))).collect();
        geodesic_distances(skin, &seeds, reach)
    }
}

/// Returns the direction away from the tip of the nose along the surface at each welded vertex, with a length of up to
/// 1. On other connected components, it is straight through space.
fn directions_away(skin: &WeldedMesh, nose: &Nose) -> Vec<Vec3> {
    let distances = nose.distances(skin, REACH * nose.head_length);
    let mut sums = vec![(Vec3::ZERO, 0.0); skin.len()];
    for face in &skin.faces {
        let [a, b, c] = face.map(|place| skin.positions[place as usize]);
        let [at_a, at_b, at_c] = face.map(|place| distances[place as usize]);
        let across = (b - a).cross(c - a);
        let area = across.length();
        if !((at_a + at_b + at_c).is_finite() && area > 0.0) {
            continue;
        }
        // Gradient of the distance, which is linear over the face, times twice the area.
        let rise = (across / area).cross((c - a) * (at_a - at_b) + (b - a) * (at_c - at_a));
        for place in face {
            let (sum, total) = &mut sums[*place as usize];
            *sum += rise;
            *total += area;
        }
    }
    let away = |place: usize| match sums[place] {
        (sum, total) if total > 0.0 => (sum / total).clamp_length_max(1.0),
        _ => (skin.positions[place] - nose.at).normalize_or_zero(),
    };
    (0..skin.len()).map(away).collect()
}
