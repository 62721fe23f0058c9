//! Length, density, lean and colour of the recipe's comb marks, spread over the mesh.
//!
//! The weight of a mark depends on the distance along the surface from the surface point nearest to the mark. It is
//! full within a quarter of the mark's reach, and zero beyond the reach. Heat diffusion smooths it slightly, across
//! gaps between connected components and corners of a coarse mesh.

use super::body::{Body, WeldedMesh, furred_faces};
use super::geodesic::geodesic_distances;
use crate::decision::metres_in_words;
use crate::recipe::CombMarkParams;
use crate::stages::cells::closest_barycentric;
use crate::stages::reach::{self, MarkBlend};
use glam::Vec3;
use pelage_formats::meaning::srgb_value_to_linear;
use pelage_import::mesh::CombLine;

/// Width of the smoothing of weights, divided by the reach of a mark.
const SPREAD: f32 = 0.1;
/// Distance from the surface above which a mark is reported as misplaced, in body radii.
const FAR: f32 = 0.1;
/// Number of points of a comb line that are tested for their distance from the surface.
const LOOKED_AT: usize = 9;

/// Combined values of all marks, one entry per vertex of the model: total weight, 0..=1, and value. A list is empty if
/// no mark sets its value.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MarkValues {
    /// Hair length, as a share of the longest.
    pub length: Vec<(f32, f32)>,
    /// Hairs per area relative to the rest of the fur.
    pub density: Vec<(f32, f32)>,
    /// Extra lean.
    pub lean: Vec<(f32, f32)>,
    /// Colour, linear RGB.
    pub color: Vec<(f32, Vec3)>,
}

impl MarkValues {
    /// Spreads marks over a body. Marks and comb lines far from the furred surface are reported in `warnings`, with
    /// their distance.
    pub fn new(marks: &[CombMarkParams], drawn: &[CombLine], body: &Body<'_>, warnings: &mut Vec<String>) -> Self {
        let radius_m = body.bounds.radius;
        if marks.is_empty() && drawn.is_empty() || !(radius_m > 0.0 && radius_m.is_finite()) {
            return Self::default();
        }
        let center = Vec3::from(body.bounds.center);
        let ground =
            MarkSurface { skin: WeldedMesh::new(body.mesh, body.rest, center, radius_m), furred: furred_faces(body) };
        let to_skin = |p: Vec3| (p - center) / radius_m;
        let mut far = |key: &str, name: &str, away: f32| {
            if away > FAR {
                let metres = metres_in_words(away * radius_m);
                warnings
                    .push(format!("{key}: {name:?} is {metres} from the nearest skin with hair; it is applied there"));
            }
        };
        for line in drawn {
            let step = line.places.len().div_ceil(LOOKED_AT).max(1);
            let places = line.places.iter().step_by(step).filter_map(|(at, _)| ground.nearest(to_skin(*at)));
            let away = places.map(|found| found.away).reduce(f32::min);
            far("comb lines of the model", &line.name, away.unwrap_or(0.0));
        }
        let mut said = MarkSums::of(marks, ground.skin.len());
        for mark in marks.iter().flat_map(CombMarkParams::with_mirror_image) {
            let Some(found) = mark.at.and_then(|at| ground.nearest(to_skin(at.into()))) else { continue };
            far("surface.comb_marks", &mark.name, found.away);
            if [mark.length, mark.density, mark.lean].iter().any(Option::is_some) || mark.color.is_some() {
                let reach = mark.reach_m.unwrap_or(reach::default_reach_m(radius_m)) / radius_m;
                said.add(&ground.weights(&found, reach), &mark);
            }
        }
        said.of_vertices(&ground.skin.place_of)
    }

    /// Whether a mark sets a colour.
    pub fn has_color(&self) -> bool {
        !self.color.is_empty()
    }
}

/// Returns the value at a vertex of the model: the value `elsewhere`, blended with the marks' value by the weight of
/// the marks.
pub(super) fn blend_marks(values: &[(f32, f32)], vertex: usize, elsewhere: f32) -> f32 {
    match values.get(vertex) {
        // Add the weighted difference, so that without any mark the result is exactly `elsewhere`.
        Some((share, value)) if *share > 0.0 => elsewhere + share * (value - elsewhere),
        _ => elsewhere,
    }
}

/// Surface on which marks are placed. Lengths are in body radii.
struct MarkSurface {
    skin: WeldedMesh,
    /// Whether hair grows on each face.
    furred: Vec<bool>,
}

/// Placement of a mark on the surface.
struct MarkPlacement {
    face: usize,
    /// Point of the surface nearest to the mark.
    on_skin: Vec3,
    /// Distance between the mark and that point.
    away: f32,
}

impl MarkSurface {
    /// Returns the point of the furred surface nearest to `at`. If it is on several faces, the first face is returned.
    fn nearest(&self, at: Vec3) -> Option<MarkPlacement> {
        let mut best: Option<MarkPlacement> = None;
        for (face, places) in self.skin.faces.iter().enumerate().filter(|(face, _)| self.furred[*face]) {
            let corners = places.map(|p| self.skin.positions[p as usize]);
            let weights = closest_barycentric(at, corners);
            let on_skin = corners[0] * weights.x + corners[1] * weights.y + corners[2] * weights.z;
            let away = at.distance(on_skin);
            if away.is_finite() && best.as_ref().is_none_or(|best| away < best.away) {
                best = Some(MarkPlacement { face, on_skin, away });
            }
        }
        best
    }

    /// Returns the weight of a mark at each welded vertex.
    ///
    /// * `found`: placement of the mark
    /// * `reach`: reach of the mark
    fn weights(&self, found: &MarkPlacement, reach: f32) -> Vec<f32> {
        let skin = &self.skin;
        let straight = |place: u32| skin.positions[place as usize].distance(found.on_skin);
        let corners = skin.faces[found.face];
        // The shift gives the nearest corner full weight, even if the mesh is coarse.
        let least = corners.iter().map(|p| straight(*p)).fold(f32::INFINITY, f32::min);
        let shift = (least - reach::FULL * reach).max(0.0);
        let mut ways = geodesic_distances(skin, &corners.map(|p| (p, straight(p) - shift)), reach);
        // Vertices of other connected components, such as an ear inserted into the head, use the straight distance.
        let piece = skin.pieces[corners[0] as usize];
        for (place, way) in ways.iter_mut().enumerate().filter(|(place, _)| skin.pieces[*place] != piece) {
            *way = straight(place as u32);
        }
        let shares: Vec<f32> = ways.into_iter().map(|way| reach::influence(way, reach)).collect();
        let spread = skin.spread(&shares, SPREAD * reach);
        let most = spread.iter().copied().fold(0.0, f32::max);
        // Set tiny weights to zero; the diffusion solver leaves them far away from the mark.
        let scaled = |share: f32| if share > 1e-3 * most { (share / most).min(1.0) } else { 0.0 };
        spread.into_iter().map(scaled).collect()
    }
}

/// Sums of the marks' values per welded vertex. A list is empty if no mark sets its value.
#[derive(Default)]
struct MarkSums {
    length: Vec<MarkBlend<f32>>,
    density: Vec<MarkBlend<f32>>,
    lean: Vec<MarkBlend<f32>>,
    color: Vec<MarkBlend<Vec3>>,
}

impl MarkSums {
    fn of(marks: &[CombMarkParams], places: usize) -> Self {
        let number = |key: fn(&CombMarkParams) -> Option<f32>| {
            let said = marks.iter().any(|mark| key(mark).is_some());
            vec![MarkBlend::default(); if said { places } else { 0 }]
        };
        let has_color = marks.iter().any(|mark| mark.color.is_some());
        Self {
            length: number(|mark| mark.length),
            density: number(|mark| mark.density),
            lean: number(|mark| mark.lean),
            color: vec![MarkBlend::default(); if has_color { places } else { 0 }],
        }
    }

    fn add(&mut self, shares: &[f32], mark: &CombMarkParams) {
        let add = |said: &mut Vec<MarkBlend<f32>>, value: Option<f32>| {
            let Some(value) = value else { return };
            said.iter_mut().zip(shares).for_each(|(said, share)| said.add(*share, value));
        };
        add(&mut self.length, mark.length);
        add(&mut self.density, mark.density);
        add(&mut self.lean, mark.lean);
        if let Some(color) = mark.color {
            let linear = Vec3::from(color.0.map(srgb_value_to_linear));
            self.color.iter_mut().zip(shares).for_each(|(said, share)| said.add(*share, linear));
        }
    }

    fn of_vertices(&self, place_of: &[u32]) -> MarkValues {
        fn each<T>(said: &[MarkBlend<T>], place_of: &[u32]) -> Vec<(f32, T)>
        where
            T: Copy + Default + std::ops::Add<Output = T> + std::ops::Mul<f32, Output = T>,
        {
            let of = |place: &u32| said[*place as usize].finish().unwrap_or_default();
            if said.is_empty() { Vec::new() } else { place_of.iter().map(of).collect() }
        }
        MarkValues {
            length: each(&self.length, place_of),
            density: each(&self.density, place_of),
            lean: each(&self.lean, place_of),
            color: each(&self.color, place_of),
        }
    }
}

#[cfg(test)]
#[path = "marks_tests.rs"]
mod tests;
