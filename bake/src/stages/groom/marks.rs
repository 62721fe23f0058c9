//! What the recipe's comb marks say of length, density, lean and colour, spread over the skin.
//!
//! A mark counts by the way over the skin, from the point that is nearest to it: in full nearby, not at all from its reach on. Where two pieces of skin
//! or the corners of a coarse mesh break that off, it is spread a little as heat spreads.

use super::body::{Body, Skin, furred_faces};
use super::ways::ways;
use crate::decision::metres_in_words;
use crate::recipe::CombMarkParams;
use crate::stages::cells::closest;
use crate::stages::reach::{self, Said};
use glam::Vec3;
use pelage_formats::meaning::srgb_value_to_linear;
use pelage_import::mesh::DrawnComb;

/// How far shares are spread, of a mark's reach.
const SPREAD: f32 = 0.1;
/// Farther from the skin than that a mark is taken for misplaced, radii of the body.
const FAR: f32 = 0.1;
/// Places of a drawn line that are looked at.
const LOOKED_AT: usize = 9;

/// What marks say, one entry per vertex of the model: how much they count there, 0..=1, and what they say together. Empty where none says it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MarkValues {
    /// Share of the hair's length.
    pub length: Vec<(f32, f32)>,
    /// Hairs per area relative to the rest of the coat.
    pub density: Vec<(f32, f32)>,
    /// Extra lean.
    pub lean: Vec<(f32, f32)>,
    /// Linear RGB.
    pub color: Vec<(f32, Vec3)>,
}

impl MarkValues {
    /// Spreads marks over a body. Marks and lines far from its furred skin are reported in `warnings`, with how far.
    pub fn new(marks: &[CombMarkParams], drawn: &[DrawnComb], body: &Body<'_>, warnings: &mut Vec<String>) -> Self {
        let radius_m = body.bounds.radius;
        if marks.is_empty() && drawn.is_empty() || !(radius_m > 0.0 && radius_m.is_finite()) {
            return Self::default();
        }
        let center = Vec3::from(body.bounds.center);
        let ground = Ground { skin: Skin::new(body.mesh, body.rest, center, radius_m), furred: furred_faces(body) };
        let to_skin = |p: Vec3| (p - center) / radius_m;
        let mut far = |key: &str, name: &str, away: f32| {
            if away > FAR {
                let metres = metres_in_words(away * radius_m);
                warnings
                    .push(format!("{key}: {name:?} is {metres} away from the nearest skin with hair; it counts there"));
            }
        };
        for line in drawn {
            let step = line.places.len().div_ceil(LOOKED_AT).max(1);
            let places = line.places.iter().step_by(step).filter_map(|(at, _)| ground.nearest(to_skin(*at)));
            let away = places.map(|found| found.away).reduce(f32::min);
            far("comb lines of the model", &line.name, away.unwrap_or(0.0));
        }
        let mut said = SaidValues::of(marks, ground.skin.len());
        for mark in marks.iter().flat_map(CombMarkParams::with_likeness) {
            let Some(found) = mark.at.and_then(|at| ground.nearest(to_skin(at.into()))) else { continue };
            far("surface.comb_marks", &mark.name, found.away);
            if [mark.length, mark.density, mark.lean].iter().any(Option::is_some) || mark.color.is_some() {
                let reach = mark.reach_m.unwrap_or(reach::chosen_m(radius_m)) / radius_m;
                said.add(&ground.shares(&found, reach), &mark);
            }
        }
        said.of_vertices(&ground.skin.place_of)
    }

    /// Whether a mark says a colour.
    pub fn has_color(&self) -> bool {
        !self.color.is_empty()
    }
}

/// `elsewhere` at a vertex of the model, as far as marks leave it.
pub(super) fn mixed(values: &[(f32, f32)], vertex: usize, elsewhere: f32) -> f32 {
    match values.get(vertex) {
        // By the difference, so that where none counts, the value elsewhere comes out to the last bit.
        Some((share, value)) if *share > 0.0 => elsewhere + share * (value - elsewhere),
        _ => elsewhere,
    }
}

/// The skin that marks stand on; lengths are radii of the body.
struct Ground {
    skin: Skin,
    /// One per face.
    furred: Vec<bool>,
}

/// Where a mark stands.
struct Found {
    face: usize,
    /// The nearest point of the skin.
    on_skin: Vec3,
    /// How far it is.
    away: f32,
}

impl Ground {
    /// The nearest point of skin with hair; of several that of the first face.
    fn nearest(&self, at: Vec3) -> Option<Found> {
        let mut best: Option<Found> = None;
        for (face, places) in self.skin.faces.iter().enumerate().filter(|(face, _)| self.furred[*face]) {
            let corners = places.map(|p| self.skin.positions[p as usize]);
            let weights = closest(at, corners);
            let on_skin = corners[0] * weights.x + corners[1] * weights.y + corners[2] * weights.z;
            let away = at.distance(on_skin);
            if away.is_finite() && best.as_ref().is_none_or(|best| away < best.away) {
                best = Some(Found { face, on_skin, away });
            }
        }
        best
    }

    /// One per place: how much a mark that stands there counts.
    fn shares(&self, found: &Found, reach: f32) -> Vec<f32> {
        let skin = &self.skin;
        let straight = |place: u32| skin.positions[place as usize].distance(found.on_skin);
        let corners = skin.faces[found.face];
        // However coarse the mesh is, a mark counts in full somewhere.
        let least = corners.iter().map(|p| straight(*p)).fold(f32::INFINITY, f32::min);
        let shift = (least - reach::FULL * reach).max(0.0);
        let mut ways = ways(skin, &corners.map(|p| (p, straight(p) - shift)), reach);
        // A piece apart, such as an ear that is put into the head, is as far as it looks.
        let piece = skin.pieces[corners[0] as usize];
        for (place, way) in ways.iter_mut().enumerate().filter(|(place, _)| skin.pieces[*place] != piece) {
            *way = straight(place as u32);
        }
        let shares: Vec<f32> = ways.into_iter().map(|way| reach::share(way, reach)).collect();
        let spread = skin.spread(&shares, SPREAD * reach);
        let most = spread.iter().copied().fold(0.0, f32::max);
        // What the solver leaves far away is nothing.
        let scaled = |share: f32| if share > 1e-3 * most { (share / most).min(1.0) } else { 0.0 };
        spread.into_iter().map(scaled).collect()
    }
}

/// What marks say of each place; empty lists where none says it.
#[derive(Default)]
struct SaidValues {
    length: Vec<Said<f32>>,
    density: Vec<Said<f32>>,
    lean: Vec<Said<f32>>,
    color: Vec<Said<Vec3>>,
}

impl SaidValues {
    fn of(marks: &[CombMarkParams], places: usize) -> Self {
        let number = |key: fn(&CombMarkParams) -> Option<f32>| {
            let said = marks.iter().any(|mark| key(mark).is_some());
            vec![Said::default(); if said { places } else { 0 }]
        };
        let has_color = marks.iter().any(|mark| mark.color.is_some());
        Self {
            length: number(|mark| mark.length),
            density: number(|mark| mark.density),
            lean: number(|mark| mark.lean),
            color: vec![Said::default(); if has_color { places } else { 0 }],
        }
    }

    fn add(&mut self, shares: &[f32], mark: &CombMarkParams) {
        let add = |said: &mut Vec<Said<f32>>, value: Option<f32>| {
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
        fn each<T>(said: &[Said<T>], place_of: &[u32]) -> Vec<(f32, T)>
        where
            T: Copy + Default + std::ops::Add<Output = T> + std::ops::Mul<f32, Output = T>,
        {
            let of = |place: &u32| said[*place as usize].together().unwrap_or_default();
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
