//! Where hair grows, how long, and what varies over the model: the `groom` stage. Lengths are metres in the posed rest state.

mod atlas;
mod charts;
mod colors;
mod maps;
mod pattern;

pub use atlas::Atlas;
pub use colors::{Colors, MaterialColor, colors, is_colored};
pub use maps::{Coat, GroomTextures, Lay, MapImages, Maps, Water};
pub(crate) use maps::{average, last, report_unmatched, scalar_at};
pub use pattern::Pattern;

use crate::decision::Decision;
use crate::mesh::{Material, RestPose};
use crate::recipe::Recipe;
use pelage_formats::Bounds;
use pelage_params::glob;

/// Length of the hair where the recipe gives none, as a share of the bounding sphere's radius: a short-haired animal's coat.
const LENGTH_PER_RADIUS: f32 = 0.045;
/// Width of the tile where the recipe gives none, as a share of the radius.
const TILE_PER_RADIUS: f32 = 0.3;

/// Lengths that the recipe may leave open, resolved for one model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lengths {
    /// Length of the longest strand, metres.
    pub length_m: f32,
    /// Width of the hair tile on the skin, metres.
    pub tile_size_m: f32,
}

impl Lengths {
    /// Takes what the recipe gives and derives the rest from the model's size.
    ///
    /// Models are modelled in all units, whatever glTF says, so only a length relative to the model suits them all.
    pub fn resolve(length_m: Option<f32>, tile_size_m: Option<f32>, bounds: &Bounds) -> Self {
        // A model of one point has no size to go by; any positive number keeps the stages defined.
        let radius = if bounds.radius > 0.0 { bounds.radius } else { 1.0 };
        Self {
            length_m: length_m.unwrap_or(LENGTH_PER_RADIUS * radius),
            tile_size_m: tile_size_m.unwrap_or(TILE_PER_RADIUS * radius),
        }
    }

    /// What of it the recipe left open.
    pub fn decisions(&self, recipe: &Recipe) -> Vec<Decision> {
        let mut decisions = Vec::new();
        if recipe.hair.length_m.is_none() {
            decisions.push(Decision::of_length("length of hair", "hair.length_m", self.length_m));
        }
        if recipe.surface.tile_size_m.is_none() {
            decisions.push(Decision::of_length("width of tile", "surface.tile_size_m", self.tile_size_m));
        }
        decisions
    }
}

/// Box and sphere about the skin at rest.
pub fn bounds(rest: &RestPose) -> Bounds {
    let mut points = rest.positions.iter().copied();
    let Some(first) = points.next() else { return Bounds::default() };
    let (min, max) = points.fold((first, first), |(min, max), p| (min.min(p), max.max(p)));
    let center = (min + max) / 2.0;
    let radius = rest.positions.iter().map(|p| p.distance(center)).fold(0.0, f32::max);
    Bounds { min: min.into(), max: max.into(), center: center.into(), radius }
}

/// One per material: whether hair grows on it.
///
/// `bare` holds names, in which `*` stands for any run of characters and `?` for one; case does not matter. A pattern that matches no material
/// is reported in `warnings`, with the names there are.
pub fn furred_materials(materials: &[Material], bare: &[String], warnings: &mut Vec<String>) -> Vec<bool> {
    for pattern in bare.iter().filter(|p| !materials.iter().any(|m| glob(p, &m.name))) {
        let names: Vec<_> = materials.iter().map(|m| m.name.as_str()).collect();
        warnings.push(format!("model.bare: {pattern:?} matches no material; the model has {names:?}"));
    }
    materials.iter().map(|m| !bare.iter().any(|p| glob(p, &m.name))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn bounds_hold_every_point() {
        let positions = vec![Vec3::new(1., 2., 3.), Vec3::new(-1., 0., 5.), Vec3::new(0., 1., 4.)];
        let b = bounds(&RestPose { normals: vec![Vec3::Z; 3], positions: positions.clone() });
        assert_eq!((b.min, b.max), ([-1., 0., 3.], [1., 2., 5.]));
        for p in positions {
            assert!(p.distance(b.center.into()) <= b.radius * 1.000001);
        }
    }
}
