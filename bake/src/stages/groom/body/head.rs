//! Comb direction of a head: from the tip of the nose over brow, cheeks and jaw to the neck.
//!
//! A single direction for the whole body is along the normal somewhere on the face, and hair would radiate from there.
//! Distances along the surface grow from the tip of the nose, so their gradient vanishes only at the tip, at the tips
//! of the ears, and behind the ears.
//!
//! Names of joints tell which part is the head, and on bodies without joints, its shape does ([`super::shape`]). Bodies
//! without a head found in this way keep a single direction.

use super::input::Body;
use super::parts::Region;
use super::shape::ShapedHead;
use super::welded_mesh::WeldedMesh;
use super::{HeadAxis, bare, head_joint, parts_of_places, regions};
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

/// Head with a snout that is named by a joint or found by shape.
pub(crate) struct BodyHead {
    skin: WeldedMesh,
    head: Head,
    axis: HeadAxis,
    /// Tip of the nose, furred or bare.
    tip: Vec3,
    /// Whether the body has no joints, so that only the head tells its direction.
    is_shaped: bool,
    center_m: Vec3,
    radius_m: f32,
}

/// Position and size of a head with a snout at rest.
#[derive(Clone, Debug, PartialEq)]
pub struct HeadShape {
    /// Share of the head, ears included, at each vertex of the mesh, 0..=1.
    pub share: Vec<f32>,
    /// Tip of the nose, metres.
    pub nose_m: Vec3,
    /// Centre of the surface of the head without ears, metres.
    pub middle_m: Vec3,
    /// Horizontal or falling unit direction in the plane of symmetry, from the centre to the snout.
    pub forward: Vec3,
}

impl BodyHead {
    /// Finds the head of a body; `None` if no joint names it and its shape does not show it, or if it is bare or has no
    /// snout.
    pub(crate) fn find(body: &Body<'_>) -> Option<Self> {
        let radius_m = body.bounds.radius;
        if !(radius_m > 0.0 && radius_m.is_finite()) {
            return None;
        }
        let center_m = Vec3::from(body.bounds.center);
        let to_skin = |p: Vec3| (p - center_m) / radius_m;
        let skin = WeldedMesh::new(body.mesh, body.rest, center_m, radius_m);
        let furred = bare::furred_places(body, &skin);
        let animation = body.animation.filter(|_| !body.mesh.skin.is_empty());
        let all = vec![true; skin.len()];
        let (head, axis, tip) = match animation {
            Some(animation) => {
                let joint = to_skin(head_joint(animation, &regions::of_nodes(animation))?);
                let parts = parts_of_places(body, &skin, to_skin);
                let share = |regions: &[Region]| -> Vec<f32> {
                    parts.iter().map(|parts| regions.iter().map(|r| parts[*r as usize]).sum()).collect()
                };
                // Ears stand above the head and would make its axis steeper.
                let skull = share(&[Region::Head, Region::Face, Region::Muzzle]);
                let axis = HeadAxis::new(&skin, joint, &skull)?;
                let nose = Nose::new(&skin, &furred, &skull, &axis)?;
                let tip = Nose::new(&skin, &all, &skull, &axis)?.at;
                let share = share(&[Region::Head, Region::Face, Region::Muzzle, Region::Ear]);
                (Head { share, nose }, axis, tip)
            }
            None => {
                let ShapedHead { skull, head, axis } = ShapedHead::find(&skin)?;
                let nose = Nose::new(&skin, &furred, &skull, &axis)?;
                let tip = Nose::new(&skin, &all, &skull, &axis)?.at;
                (Head { share: head, nose }, axis, tip)
            }
        };
        Some(Self { skin, head, axis, tip, is_shaped: animation.is_none(), center_m, radius_m })
    }

    /// Returns the wanted comb direction of each vertex of the mesh, at rest: on the head away from the tip of the
    /// nose, and on the rest of the body the direction that is returned with them. Lengths are weights: 1 on the body,
    /// and more on the head.
    ///
    /// On a body without joints, the direction of the rest is turned by quarter turns to point away from the head.
    ///
    /// * `elsewhere`: unit vector
    /// * `smoothing_m`: distance over which directions of weight 1 are smoothed, metres, above 0
    pub(crate) fn comb(&self, elsewhere: Vec3, smoothing_m: f32) -> (Vec<Vec3>, Vec3) {
        let Self { skin, head, axis, .. } = self;
        let elsewhere = if self.is_shaped { turned_away(elsewhere, axis.forward) } else { elsewhere };
        let away = directions_away(skin, &head.nose);
        let share = skin.spread(&head.share, TRANSITION * head.nose.head_length);
        let finer = smoothing_m / (SMOOTHING * head.nose.head_length * self.radius_m);
        let weight = (finer * finer).max(1.0);
        let wish = |place: usize| elsewhere.lerp(away[place], share[place]) * (1.0 + share[place] * (weight - 1.0));
        (skin.place_of.iter().map(|place| wish(*place as usize)).collect(), elsewhere)
    }

    /// Returns position and size of the head.
    pub(crate) fn shape(&self) -> HeadShape {
        let Self { skin, head, axis, tip, .. } = self;
        let metres = |p: Vec3| p * self.radius_m + self.center_m;
        HeadShape {
            share: skin.place_of.iter().map(|place| head.share[*place as usize].clamp(0.0, 1.0)).collect(),
            nose_m: metres(*tip),
            middle_m: metres(axis.middle),
            forward: axis.forward,
        }
    }
}

/// Turns a direction about y by quarter turns until it points most away from `forward`.
fn turned_away(direction: Vec3, forward: Vec3) -> Vec3 {
    let quarter = |v: &Vec3| Vec3::new(v.z, v.y, -v.x);
    let turns = std::iter::successors(Some(direction), |v| Some(quarter(v))).take(4);
    turns.min_by(|a, b| a.dot(forward).total_cmp(&b.dot(forward))).unwrap_or(direction)
}

/// Head with a snout.
struct Head {
    /// Share of the head at each welded vertex, 0..=1.
    share: Vec<f32>,
    nose: Nose,
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
