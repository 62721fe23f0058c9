//! Parameters of the `surface` stage: furred parts, tile size, and comb of the hair.

use super::comb::Comb;
use super::grow::Reach;
use super::lapped::{Bounds, LappedParams};
use crate::recipe;
use glam::Vec3;
use pelage_import::BakeError;
use pelage_import::mesh::Mesh;

/// Parameters of the `surface` stage.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceParams {
    /// Width of a tile on the mesh surface, metres, greater than 0. It is the reciprocal of the tiles per metre.
    pub tile_size_m: f32,
    /// Whether hair grows on each material; materials beyond the end of the list are bare.
    pub furred: Vec<bool>,
    /// Source of the tile coordinates.
    pub source: Source,
    /// Direction in which hair is combed.
    pub comb: Comb,
    /// Distance over which neighbouring faces determine the direction where the comb is weak or inconsistent, tiles,
    /// greater than 0 (default 1).
    pub comb_smoothing: f32,
    /// Density of hairs relative to the recipe's, one value per vertex of the input mesh, greater than 0; `None` for 1
    /// everywhere. It has no effect with the model's own coordinates.
    pub density: Option<Vec<f32>>,
}

/// Uses the defaults of a recipe, with tiles of 0.1 m and no furred material.
impl Default for SurfaceParams {
    fn default() -> Self {
        Self::from_recipe(&recipe::SurfaceParams::default(), 0.1, Vec::new())
    }
}

/// Source of the tile coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Source {
    /// Lapped patches over any surface (Lengyel et al. 2001).
    Patches(PatchParams),
    /// Model's own texture coordinates, scaled.
    Model,
}

/// Limits of lapped patches. Larger patches have fewer seams and more distortion. Ranges: see
/// [`recipe::SurfaceParams`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatchParams {
    /// Maximum distance that a patch grows from its seed, tiles (default 4).
    pub size: f32,
    /// Maximum angle between a patch's v direction and the comb, degrees (default 25).
    pub turn_deg: f32,
    /// Maximum stretch of a triangle in any direction, and inverse of the minimum (default 1.5).
    pub stretch: f32,
    /// Weight of the comb: 1 follows it, 0 minimises each triangle's distortion (default 0.5).
    pub comb_weight: f32,
}

impl From<&recipe::SurfaceParams> for PatchParams {
    fn from(recipe: &recipe::SurfaceParams) -> Self {
        Self {
            size: recipe.patch_size,
            turn_deg: recipe.patch_turn_deg,
            stretch: recipe.patch_stretch,
            comb_weight: recipe.comb_weight,
        }
    }
}

/// Converts the patch parameters to a recipe in which everything else has its default.
impl From<&PatchParams> for recipe::SurfaceParams {
    fn from(patches: &PatchParams) -> Self {
        Self {
            patch_size: patches.size,
            patch_turn_deg: patches.turn_deg,
            patch_stretch: patches.stretch,
            comb_weight: patches.comb_weight,
            ..Self::default()
        }
    }
}

/// Uses the defaults of a recipe.
impl Default for PatchParams {
    fn default() -> Self {
        Self::from(&recipe::SurfaceParams::default())
    }
}

impl SurfaceParams {
    /// Converts a recipe's parameters. `tile_size_m` is the tile's width resolved for the model, and `furred` has one
    /// entry per material. Lines drawn in a model are added by [`Comb::of_recipe`].
    pub fn from_recipe(recipe: &recipe::SurfaceParams, tile_size_m: f32, furred: Vec<bool>) -> Self {
        Self {
            tile_size_m,
            furred,
            source: match recipe.source {
                recipe::SurfaceSource::Model => Source::Model,
                recipe::SurfaceSource::Patches => Source::Patches(recipe.into()),
            },
            comb: Comb::of_recipe(recipe, &[], 1.0),
            comb_smoothing: recipe.comb_smoothing,
            density: None,
        }
    }

    pub(super) fn check(&self) -> Result<(), BakeError> {
        let fail = |what: &'static str, reason: String| Err(BakeError::Params { what, reason });
        let positive = |v: f32| v > 0.0 && v.is_finite();
        if !positive(self.tile_size_m) {
            return fail(
                "surface.tile_size_m",
                format!("{} metres, expected a number greater than 0", self.tile_size_m),
            );
        }
        if !positive(self.comb_smoothing) {
            return fail(
                "surface.comb_smoothing",
                format!("{} tiles, expected a number greater than 0", self.comb_smoothing),
            );
        }
        match &self.comb {
            Comb::Direction(d) if !d.is_finite() || *d == Vec3::ZERO => {
                return fail("surface.comb_direction", format!("{d}, expected three finite numbers, not all 0"));
            }
            Comb::Marks { marks, .. } if marks.is_empty() => {
                return fail(
                    "surface.comb_marks",
                    "found no mark with a direction, expected at least one for surface.comb = \"marks\", or lines \
                     named comb_… in the model"
                        .into(),
                );
            }
            Comb::Marks { marks, elsewhere } => {
                let is_direction = |d: &Vec3| d.is_finite() && *d != Vec3::ZERO;
                let places = || marks.iter().flat_map(|mark| &mark.places);
                if let Some((_, bad)) = places().find(|(at, d)| !at.is_finite() || !is_direction(d)) {
                    return fail("surface.comb_marks", format!("{bad}, expected three finite numbers, not all 0"));
                }
                if !is_direction(elsewhere) {
                    let reason = format!("{elsewhere}, expected three finite numbers, not all 0");
                    return fail("surface.comb_direction", reason);
                }
            }
            _ => {}
        }
        if let Some(bad) = self.density.iter().flatten().find(|v| !positive(**v)) {
            return fail("groom.density", format!("{bad}, expected numbers greater than 0"));
        }
        if let Source::Patches(p) = &self.source {
            // Ranges are only defined in the declaration of the recipe.
            recipe::SurfaceParams::from(p).validate()?;
        }
        Ok(())
    }

    pub(super) fn is_furred(&self, material: usize) -> bool {
        self.furred.get(material).copied().unwrap_or(false)
    }

    pub(super) fn furred_triangles(&self, mesh: &Mesh) -> Vec<bool> {
        let mut out = vec![false; mesh.triangles.len()];
        for part in mesh.parts.iter().filter(|p| self.is_furred(p.material)) {
            out[part.first_triangle..part.first_triangle + part.triangle_count].fill(true);
        }
        out
    }
}

impl PatchParams {
    pub(super) fn lapped(&self, combed: bool) -> LappedParams {
        LappedParams {
            reach: Reach { tiles: f64::from(self.size), turn_rad: f64::to_radians(120.0), combed },
            bounds: Bounds {
                least_cosine: if combed { libm::cos(f64::from(self.turn_deg).to_radians()) } else { -1.0 },
                stretch: f64::from(self.stretch),
            },
            comb_weight: if combed { f64::from(self.comb_weight) } else { 0.0 },
        }
    }
}
