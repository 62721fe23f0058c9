//! Stage `groom`: determines where hair grows on the model, how long it is and how it varies. Lengths are metres in the
//! posed rest state.

mod at_root;
mod atlas;
mod bare;
mod bleed;
mod body;
pub(crate) mod canvas;
mod charts;
mod colors;
mod components;
mod cornea;
mod features;
mod flow;
mod geodesic;
mod gloss;
mod image_coordinates;
mod joints;
mod maps;
mod margin;
mod marks;
mod model_atlas;
mod names;
mod pairs;
mod patches;
mod pattern;
mod projection;
mod words;

pub use at_root::{RootAtlas, RootColorInput};
pub use atlas::Atlas;
pub(crate) use atlas::linear_image;
pub use bare::{FurredMaterials, find_furred_materials};
pub use body::{Body, BodyGroom, HeadShape};
pub(crate) use body::{BodyHead, WeldedMesh, are_joints_of_head, thickness};
pub use colors::{Colors, MaterialColor, colors, is_colored};
pub use cornea::cornea_normals;
pub(crate) use features::{split_features, split_listed};
pub use gloss::gloss;
pub use image_coordinates::{ImageCoordinates, Vertices};
pub use joints::JointValues;
pub use maps::{FurWetness, GroomTextures, LayoutMaps, MapImages, Maps, VertexGroom};
pub(crate) use maps::{average, last, names_of, report_unmatched, scalar_at};
pub use margin::{BareDistances, chosen_margin_m, margin_decision};
pub use marks::MarkValues;
pub use model_atlas::ModelAtlas;
pub(crate) use names::name_of_eyes;
pub use pattern::Pattern;

use crate::decision::Decision;
use crate::recipe::Recipe;
use pelage_formats::Bounds;
use pelage_import::mesh::RestPose;

/// Lengths that the recipe may leave open, with their values for one model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lengths {
    /// Length of the longest strand, metres.
    pub length_m: f32,
    /// Width of the hair tile on the mesh surface, metres.
    pub tile_size_m: f32,
}

impl Lengths {
    /// Returns the lengths in the recipe, and derives the missing ones from the model's size.
    ///
    /// Models use all kinds of units, although glTF specifies metres, so only lengths relative to the model suit them
    /// all.
    pub fn resolve(recipe: &Recipe, bounds: &Bounds) -> Self {
        let Recipe { hair, surface, .. } = recipe;
        // A model of a single point has no size. Any positive number keeps the stages well-defined.
        let radius = if bounds.radius > 0.0 { bounds.radius } else { 1.0 };
        Self {
            length_m: hair.length_m.unwrap_or(hair.length_per_radius * radius),
            tile_size_m: surface.tile_size_m.unwrap_or(surface.tile_size_per_radius * radius),
        }
    }

    /// Returns the lengths that were chosen because the recipe left them open.
    pub fn decisions(&self, recipe: &Recipe) -> Vec<Decision> {
        let mut decisions = Vec::new();
        if recipe.hair.length_m.is_none() {
            decisions.push(Decision::length("length of hair", "hair.length_m", self.length_m));
        }
        if recipe.surface.tile_size_m.is_none() {
            decisions.push(Decision::length("width of tile", "surface.tile_size_m", self.tile_size_m));
        }
        decisions
    }
}

/// Returns the bounding box and bounding sphere of the mesh at rest.
pub fn bounds(rest: &RestPose) -> Bounds {
    let mut points = rest.positions.iter().copied();
    let Some(first) = points.next() else { return Bounds::default() };
    let (min, max) = points.fold((first, first), |(min, max), p| (min.min(p), max.max(p)));
    let center = (min + max) / 2.0;
    let radius = rest.positions.iter().map(|p| p.distance(center)).fold(0.0, f32::max);
    Bounds { min: min.into(), max: max.into(), center: center.into(), radius }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn bounds_contain_every_point() {
        let positions = vec![Vec3::new(1., 2., 3.), Vec3::new(-1., 0., 5.), Vec3::new(0., 1., 4.)];
        let b = bounds(&RestPose { normals: vec![Vec3::Z; 3], positions: positions.clone() });
        assert_eq!((b.min, b.max), ([-1., 0., 3.], [1., 2., 5.]));
        for p in positions {
            assert!(p.distance(b.center.into()) <= b.radius * 1.000001);
        }
    }
}
