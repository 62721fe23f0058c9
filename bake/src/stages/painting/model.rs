//! Model to be painted.

use crate::stages::groom::{Colors, HeadShape};
use crate::stages::surface::Surface;
use pelage_formats::{Bounds, HairGroup, InkVertex};
use pelage_import::mesh::Material;

/// Model to be painted.
#[derive(Clone, Copy, Debug)]
pub struct PaintedModel<'a> {
    /// Mesh with combing directions.
    pub surface: &'a Surface,
    /// Colours of the mesh.
    pub colors: &'a Colors,
    /// Bounds at rest.
    pub bounds: &'a Bounds,
    /// Materials of the model.
    pub materials: &'a [Material],
    /// Whether hair grows on each material.
    pub furred: &'a [bool],
    /// Length of the hair at each vertex, metres.
    pub hair_m: &'a [f32],
    /// Head with a snout; `None` if none is known.
    pub head: Option<&'a HeadShape>,
    /// Ink of each vertex of the mesh by the recipe: amount of wash, full ink; empty for a wash everywhere.
    pub ink: &'a [InkVertex],
    /// Guided hair.
    pub groups: &'a [HairGroup],
    /// Seed of all irregularities.
    pub seed: u64,
}
