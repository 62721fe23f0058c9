//! Comb directions: a wanted direction for each face, before smoothing into a field.

use super::furred_mesh::FurredMesh;
use super::marks::{self, CombMark};
use crate::recipe::{CombMarkParams, CombSource, SurfaceParams};
use crate::stages::reach;
use glam::{DVec3, Vec3};
use pelage_import::mesh::{CombLine, Mesh};

/// Distance between samples of a drawn line, as a share of its reach.
const STEP: f32 = 0.125;
/// Maximum number of samples of a drawn line.
const MOST_PLACES: usize = 256;

/// Direction in which hair is combed. Directions are in world space at rest; only the component along the mesh surface
/// counts.
#[derive(Clone, Debug, PartialEq)]
pub enum Comb {
    /// Same direction everywhere, with any length but 0.
    Direction(Vec3),
    /// Down: −y.
    Gravity,
    /// Along +v of the model's texture coordinates, which points down in a texture painted upright.
    Tangents,
    /// A vector per vertex of the input mesh; its length, up to 1, is its weight.
    PerVertex(Vec<Vec3>),
    /// A vector per vertex of the input mesh, of any length. The distance of smoothing is divided by its square root.
    Weighted(Vec<Vec3>),
    /// Directions at a few points, interpolated by distance along the mesh surface (formulas 6.1, after Praun et al.
    /// 2000).
    Marks {
        /// Marks, at least one.
        marks: Vec<CombMark>,
        /// Direction beyond the reach of all marks, if all of them have a reach; any length but 0.
        elsewhere: Vec3,
    },
    /// No direction. Patches have minimal distortion, which suits upright hair (the isotropic mode of Lengyel et al.
    /// 2001).
    None,
}

impl Comb {
    /// Returns the comb for a recipe and for lines drawn in a model with the given radius. If `surface.comb` is `auto`,
    /// a mark with a direction selects `marks`. Drawn lines also select it if `surface.comb_direction` is unchanged.
    pub fn of_recipe(recipe: &SurfaceParams, drawn: &[CombLine], radius_m: f32) -> Self {
        let of_recipe = recipe.comb_marks.iter().flat_map(CombMarkParams::with_mirror_image).filter_map(|mark| {
            Some(CombMark {
                places: vec![(mark.at?.into(), mark.direction?.into())],
                name: mark.name,
                reach_m: mark.reach_m,
            })
        });
        let mut marks: Vec<CombMark> = of_recipe.collect();
        let untouched = recipe.comb_direction == SurfaceParams::default().comb_direction;
        let has_marks = !marks.is_empty() || !drawn.is_empty() && untouched;
        let elsewhere = Vec3::from(recipe.comb_direction);
        match recipe.comb {
            CombSource::Auto if !has_marks => Self::Direction(elsewhere),
            CombSource::Direction => Self::Direction(elsewhere),
            CombSource::Gravity => Self::Gravity,
            CombSource::Tangents => Self::Tangents,
            CombSource::Auto | CombSource::Marks => {
                let reach_m = reach::default_reach_m(radius_m);
                marks.extend(drawn.iter().map(|line| CombMark {
                    name: line.name.clone(),
                    places: sample_line(&line.places, reach_m * STEP),
                    reach_m: Some(reach_m),
                }));
                Self::Marks { marks, elsewhere }
            }
            CombSource::None => Self::None,
        }
    }

    /// Returns the unit direction that applies everywhere; zero if the comb has no such direction.
    pub fn global_direction(&self) -> Vec3 {
        match self {
            Self::Direction(direction) => direction.normalize_or_zero(),
            Self::Gravity => Vec3::NEG_Y,
            Self::Tangents | Self::PerVertex(_) | Self::Weighted(_) | Self::Marks { .. } | Self::None => Vec3::ZERO,
        }
    }
}

/// Samples a drawn line, including its ends, about every `step_m` metres and at most [`MOST_PLACES`] times.
fn sample_line(places: &[(Vec3, Vec3)], step_m: f32) -> Vec<(Vec3, Vec3)> {
    let lengths: Vec<f32> = places.windows(2).map(|ends| ends[0].0.distance(ends[1].0)).collect();
    let total: f32 = lengths.iter().sum();
    let (Some(first), Some(last)) = (places.first(), places.last()) else { return Vec::new() };
    let count = (total / step_m).ceil().clamp(1.0, MOST_PLACES as f32 - 1.0) as usize;
    if places.len() < 2 || !total.is_finite() {
        return vec![*first];
    }
    let (mut found, mut segment, mut before) = (vec![*first], 0, 0.0);
    for k in 1..count {
        let along = total * k as f32 / count as f32;
        while segment + 1 < lengths.len() && before + lengths[segment] < along {
            before += lengths[segment];
            segment += 1;
        }
        let t = ((along - before) / lengths[segment].max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
        let (a, b) = (places[segment], places[segment + 1]);
        found.push((a.0.lerp(b.0, t), a.1.lerp(b.1, t).normalize_or(a.1)));
    }
    found.push(*last);
    found
}

/// Returns the wanted direction of each furred face, with its weight as length: up to 1, except for
/// [`Comb::Weighted`].
pub(super) fn wanted_directions(
    skin: &FurredMesh,
    mesh: &Mesh,
    input_vertex: &[u32],
    comb: &Comb,
    warnings: &mut Vec<String>,
) -> Vec<DVec3> {
    match comb {
        Comb::Direction(_) | Comb::Gravity | Comb::None => {
            vec![comb.global_direction().as_dvec3().normalize_or_zero(); skin.triangles.len()]
        }
        Comb::Marks { marks, elsewhere } => marks::spread(&skin.topology, marks, *elsewhere, warnings),
        Comb::PerVertex(vectors) | Comb::Weighted(vectors) => {
            let most = if matches!(comb, Comb::PerVertex(_)) { 1.0 } else { f64::MAX };
            let at = |v: u32| vectors.get(input_vertex[v as usize] as usize).copied().unwrap_or(Vec3::ZERO).as_dvec3();
            let mean = |t: &u32| mesh.triangles[*t as usize].map(at).into_iter().sum::<DVec3>() / 3.0;
            skin.triangles
                .iter()
                .map(mean)
                .map(|w| if w.is_finite() { w.clamp_length_max(most) } else { DVec3::ZERO })
                .collect()
        }
        Comb::Tangents => (0..skin.triangles.len())
            .map(|f| {
                let uv = mesh.triangles[skin.triangles[f] as usize].map(|v| mesh.uvs[v as usize].as_dvec2());
                let p = skin.topology.corners(f);
                let (d1, d2) = (uv[1] - uv[0], uv[2] - uv[0]);
                // Derivative dP/dv; its sign is also correct for mirrored charts.
                let along_v = (p[2] - p[0]) * d1.x - (p[1] - p[0]) * d2.x;
                (along_v * d1.perp_dot(d2).signum()).normalize_or_zero()
            })
            .collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unset_comb_source_follows_from_model_and_marks() {
        let line = CombLine { name: "comb_a".into(), places: vec![(Vec3::ZERO, Vec3::X), (Vec3::X, Vec3::X)] };
        let mark = |direction| CombMarkParams { at: Some([0.0; 3]), direction, ..CombMarkParams::default() };
        let (open, drawn) = (SurfaceParams::default(), [line]);
        let marks = |recipe: &SurfaceParams, drawn: &[CombLine]| match Comb::of_recipe(recipe, drawn, 2.0) {
            Comb::Marks { marks, .. } => marks.iter().map(|mark| (mark.places.len(), mark.reach_m)).collect(),
            Comb::Direction(_) => Vec::new(),
            other => vec![(99, Some(if other == Comb::Gravity { 1.0 } else { 2.0 }))],
        };
        assert_eq!(marks(&open, &[]), []);
        // The line is one metre long with a reach of 0.6 m, so the steps are at most 75 mm.
        assert_eq!(marks(&open, &drawn), [(15, Some(0.6))]);
        let turned = SurfaceParams { comb_direction: [1.0, 0.0, 0.0], ..open.clone() };
        assert_eq!(marks(&turned, &drawn), []);
        let said = |comb| SurfaceParams { comb, ..open.clone() };
        assert_eq!(marks(&said(CombSource::Direction), &drawn), []);
        assert_eq!(marks(&said(CombSource::Gravity), &drawn), [(99, Some(1.0))]);
        let with = |direction| SurfaceParams { comb_marks: vec![mark(direction)], ..open.clone() };
        assert_eq!(marks(&with(None), &[]), [], "a mark without direction says nothing of the comb");
        assert_eq!(marks(&with(Some([0.0, 1.0, 0.0])), &drawn), [(1, None), (15, Some(0.6))]);
        assert_eq!(marks(&SurfaceParams { comb: CombSource::Marks, ..turned }, &drawn), [(15, Some(0.6))]);
    }

    #[test]
    fn line_samples_are_evenly_spaced() {
        let corner = [(Vec3::ZERO, Vec3::X), (Vec3::X, Vec3::X), (Vec3::X + Vec3::Y, Vec3::Y)];
        let found = sample_line(&corner, 0.5);
        let places: Vec<Vec3> = found.iter().map(|(at, _)| *at).collect();
        assert_eq!(places, [Vec3::ZERO, Vec3::X * 0.5, Vec3::X, Vec3::new(1.0, 0.5, 0.0), Vec3::new(1.0, 1.0, 0.0)]);
        assert!(found[3].1.x > 0.5 && found[3].1.is_normalized(), "{:?}", found[3]);
        assert_eq!(sample_line(&corner, 1e-9).len(), MOST_PLACES);
        assert_eq!((sample_line(&corner[..1], 0.5).len(), sample_line(&[], 0.5).len()), (1, 0));
    }
}
