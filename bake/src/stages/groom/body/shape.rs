//! Detection of a head by shape, on bodies without joints: an extremity whose tip is the nose, with a pair of ears or
//! horns above and behind it.
//!
//! A wrong head is worse than a missed one, so all cues must agree: the pair is thin, small, equally large and level,
//! the nose is midway between the two, and the head is symmetric.

use super::HeadAxis;
use super::thickness::thickness;
use super::tips::tips;
use super::welded_mesh::WeldedMesh;
use crate::stages::cells::{TriangleGrid, closest_barycentric};
use crate::stages::groom::geodesic::geodesic_distances;
use glam::Vec3;

/// Maximum thickness of ears and horns, relative to the trunk.
const THIN: f32 = 0.35;
/// Minimum and maximum area of an ear or horn, as a share of the body's area.
const EAR: [f32; 2] = [0.002, 0.05];
/// Minimum height of an ear's lowest point above that of the body, in body radii.
const ABOVE_GROUND: f32 = 0.2;
/// Maximum relative difference in area between left and right.
const ALIKE: f32 = 0.25;
/// Maximum slope of the line between left and right.
const LEVEL: f32 = 0.3;
/// Maximum distance from ear to ear, and from ears to nose, relative to the trunk's thickness. Hands and a tail are
/// farther apart.
const LARGEST: f32 = 1.6;
/// Range of the distance from nose to ears, divided by the distance between the ears.
const LENGTH: [f32; 2] = [0.5, 2.2];
/// Minimum height of the ears above the nose, minimum horizontal distance, and maximum offset of the nose to one side.
/// They are divided by the distance from nose to ears.
const HIGHER: f32 = 0.2;
const AHEAD: f32 = 0.4;
const ASIDE: f32 = 0.15;
/// Minimum share of the head's area whose mirror image is on the surface, and the tolerance, divided by the head's
/// length.
const SYMMETRIC: f32 = 0.9;
const TOLERANCE: f32 = 0.1;

/// Head of a body without joints.
pub(super) struct ShapedHead {
    /// Share of the head without ears and horns at each welded vertex, 0 or 1.
    pub skull: Vec<f32>,
    /// Share of the head at each welded vertex, 0 or 1.
    pub head: Vec<f32>,
    pub axis: HeadAxis,
}

/// Connected thin part of the surface.
struct ThinPart {
    /// Welded vertices in ascending order.
    places: Vec<u32>,
    center: Vec3,
    area: f32,
}

impl ShapedHead {
    /// Finds the only head of a body; `None` if there is none, or if several places look like one.
    pub(super) fn find(skin: &WeldedMesh) -> Option<Self> {
        let thickness = thickness(skin);
        let thickest = skin.quantile(&thickness, 0.9)?;
        let ears = ears(skin, &thickness, THIN * thickest);
        if ears.len() < 2 {
            return None;
        }
        let largest = LARGEST * thickest;
        let mut found = tips(skin, &thickness).into_iter().filter_map(|nose| Self::of_nose(skin, &ears, nose, largest));
        found.next().filter(|_| found.next().is_none())
    }

    /// Returns the head with the tip of its nose at a vertex; `None` if a cue is missing.
    fn of_nose(skin: &WeldedMesh, ears: &[ThinPart], nose: u32, largest: f32) -> Option<Self> {
        let at = skin.positions[nose as usize];
        let pairs = (0..ears.len()).flat_map(|b| (0..b).map(move |a| [&ears[a], &ears[b]]));
        let pair =
            pairs.filter(|pair| are_ears_of(pair, at, largest)).max_by(|a, b| a[0].area.total_cmp(&b[0].area))?;
        let distances = geodesic_distances(skin, &[(nose, 0.0)], f32::INFINITY);
        let length = pair.iter().filter_map(|ear| far_side(skin, ear, &distances)).reduce(f32::max)?;
        let mut skull: Vec<f32> = distances.iter().map(|d| if *d <= length { 1.0 } else { 0.0 }).collect();
        let mut head = skull.clone();
        // A thin snout is no ear.
        let touches_head = |ear: &&ThinPart| {
            !ear.places.contains(&nose) && ear.places.iter().any(|place| distances[*place as usize] <= length)
        };
        for ear in ears.iter().filter(touches_head) {
            ear.places.iter().for_each(|place| (skull[*place as usize], head[*place as usize]) = (0.0, 1.0));
        }
        let [a, b] = pair.map(|ear| ear.center);
        let (middle, across) = ((a + b) / 2.0, (b - a).normalize());
        if !is_symmetric(skin, &skull, middle, across, TOLERANCE * length) {
            return None;
        }
        let forward = (at - middle) * Vec3::new(1.0, 0.0, 1.0);
        Some(Self { skull, head, axis: HeadAxis { middle, forward: forward.try_normalize()? } })
    }
}

/// Returns the thin parts that may be ears or horns: small and above the ground.
fn ears(skin: &WeldedMesh, thickness: &[Option<f32>], thin: f32) -> Vec<ThinPart> {
    let mut is_open: Vec<bool> = thickness.iter().map(|t| t.is_some_and(|t| t < thin)).collect();
    let lowest = skin.positions.iter().map(|p| p.y).fold(f32::INFINITY, f32::min);
    let whole: f32 = skin.areas.iter().sum();
    let mut found = Vec::new();
    for first in 0..skin.len() as u32 {
        let mut places: Vec<u32> =
            Some(first).filter(|_| std::mem::take(&mut is_open[first as usize])).into_iter().collect();
        let mut next = 0;
        while let Some(place) = places.get(next) {
            places.extend(
                skin.neighbors_of(*place).filter(|n| std::mem::take(&mut is_open[*n as usize])).collect::<Vec<_>>(),
            );
            next += 1;
        }
        let at = |place: &u32| (skin.positions[*place as usize], skin.areas[*place as usize]);
        let (sum, area) = places.iter().map(at).fold((Vec3::ZERO, 0.0), |(sum, all), (p, a)| (sum + p * a, all + a));
        let is_high = places.iter().all(|place| at(place).0.y > lowest + ABOVE_GROUND);
        places.sort_unstable();
        if is_high && area >= EAR[0] * whole && area <= EAR[1] * whole {
            found.push(ThinPart { places, center: sum / area, area });
        }
    }
    found
}

/// Whether two parts can be the ears or horns of the head with the given tip of the nose.
///
/// * `largest`: maximum distance from ear to ear, and from the ears to the nose
fn are_ears_of([a, b]: &[&ThinPart; 2], nose: Vec3, largest: f32) -> bool {
    let (apart, way) = (b.center - a.center, nose - (a.center + b.center) / 2.0);
    let (width, length) = (apart.length(), way.length());
    (a.area - b.area).abs() <= ALIKE * a.area.max(b.area)
        && apart.y.abs() <= LEVEL * width
        && length.max(width) <= largest
        && length >= LENGTH[0] * width
        && length <= LENGTH[1] * width
        && way.y <= -HIGHER * length
        && libm::hypotf(way.x, way.z) >= AHEAD * length
        && way.dot(apart).abs() <= ASIDE * length * width
}

/// Returns the greatest distance along the border of a part; `None` if the part has no border.
fn far_side(skin: &WeldedMesh, ear: &ThinPart, distances: &[f32]) -> Option<f32> {
    let around = ear.places.iter().flat_map(|place| skin.neighbors_of(*place));
    let border = around.filter(|place| ear.places.binary_search(place).is_err()).map(|place| distances[place as usize]);
    border.filter(|distance| distance.is_finite()).reduce(f32::max)
}

/// Whether most of a part of the surface has its mirror image within `tolerance` of the surface.
///
/// * `share`: share of the part at each welded vertex
/// * `middle`, `across`: point on the plane of symmetry, and its normal
fn is_symmetric(skin: &WeldedMesh, share: &[f32], middle: Vec3, across: Vec3, tolerance: f32) -> bool {
    let place = |p: u32| skin.positions[p as usize];
    let cells = TriangleGrid::new(&skin.faces, &place, tolerance);
    let (mut mirrored, mut all) = (0.0, 0.0);
    for (position, weight) in skin.positions.iter().zip(skin.areas.iter().zip(share).map(|(area, share)| area * share))
    {
        let image = *position - across * (2.0 * (*position - middle).dot(across));
        let is_near = |face: u32| {
            let corners = skin.faces[face as usize].map(place);
            let w = closest_barycentric(image, corners);
            image.distance(corners[0] * w.x + corners[1] * w.y + corners[2] * w.z) <= tolerance
        };
        all += weight;
        if weight > 0.0 && cells.within(image, tolerance).any(is_near) {
            mirrored += weight;
        }
    }
    mirrored >= SYMMETRIC * all
}
