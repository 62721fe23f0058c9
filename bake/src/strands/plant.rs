//! Planting of a package's individual strands on its mesh surface.
//!
//! The strands are grown again from the recipe in the package and are identical to those that were sliced. Each strand
//! of the periodic tile occurs wherever its root is in a furred triangle. From there it follows the mesh surface, as
//! [`pelage_formats::meaning::planting`] describes. A point at the share s of the fur's height H is displaced as
//! FORMAT.md defines for the layers. It moves by s · H along the normal and by s² · l · H along the comb, where l is
//! the lean. Both are interpolated between the corners of the triangle. So the reference fills the same volume as the
//! layers.
//!
//! * The radius of a strand is that of the tile in metres, whatever the value of the length map.
//! * The colour of a strand is its own colour times that of the mesh surface at its root.
//! * If the groom grows only a share of the hair, each strand occurs with that probability. If the hair is partly wet,
//!   each strand is wet with that probability.

use super::curves::{CurvePoint, Curves, simplified};
use super::skin::{PosedMesh, mix};
use crate::noise::{hash, uniform};
use crate::recipe::Recipe;
use crate::stages::groom::{FurWetness, Lengths};
use crate::stages::simulate::{Strands, TileHair};
use glam::DVec3;
use pelage_formats::Manifest;
use pelage_formats::meaning::hair_offset;
use pelage_formats::meaning::planting::{Roots, SurfaceWalk, WalkEvents, WalkPosition};
use pelage_import::BakeError;
use rayon::prelude::*;
use serde::Serialize;
use std::collections::BTreeSet;

/// Tolerance for removing points near the line between their neighbours, in radii of the strand. So simplification
/// moves an outline by at most a tenth of the radius, which is far less than a pixel.
pub(super) const SIMPLIFICATION: f64 = 0.1;
/// Maximum number of strands in a scene, about 12 GiB of memory.
const MAX_STRANDS: f64 = 2e7;

/// Statistics of the tile's strands planted on a mesh surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct GroomReport {
    /// Number of strands on the mesh surface.
    #[serde(skip)]
    pub strands: u64,
    /// Number of straight segments after simplification.
    #[serde(skip)]
    pub segments: u64,
    /// Number of points of all strands before simplification, which removes points on a straight line.
    #[serde(rename = "points_before_simplification")]
    pub points_before: u64,
    /// Number of strands that cross a border of patches.
    pub crossed_patch_border: u64,
    /// Number of strands that extend beyond the mesh or its furred part.
    pub crossed_mesh_border: u64,
    /// Number of strands that slide along a border of patches, because both sides lead towards it.
    pub slid_along_border: u64,
    /// Number of strands that left the mesh surface because they crossed too many edges in one step, for example around
    /// a corner that all patches lead to.
    pub lost: u64,
    /// Number of roots where the mesh surface is cut away.
    #[serde(rename = "dropped_cut_out")]
    pub dropped_cut: u64,
    /// Number of roots where the hair has no length.
    #[serde(rename = "dropped_no_length")]
    pub dropped_bare: u64,
    /// Number of roots removed because the groom thins out the hair.
    #[serde(rename = "dropped_thinned_out")]
    pub dropped_thinned: u64,
    /// Number of furred triangles whose tile coordinates have no extent, so that no hair can have its root there.
    pub triangles_without_coordinates: u64,
}

impl std::ops::AddAssign for GroomReport {
    fn add_assign(&mut self, other: Self) {
        self.strands += other.strands;
        self.segments += other.segments;
        self.points_before += other.points_before;
        self.crossed_patch_border += other.crossed_patch_border;
        self.crossed_mesh_border += other.crossed_mesh_border;
        self.slid_along_border += other.slid_along_border;
        self.lost += other.lost;
        self.dropped_cut += other.dropped_cut;
        self.dropped_bare += other.dropped_bare;
        self.dropped_thinned += other.dropped_thinned;
        self.triangles_without_coordinates += other.triangles_without_coordinates;
    }
}

/// Grows the tile's strands of a package again from its recipe; `None` for a package without fur.
///
/// Fails with [`BakeError::Input`] if the recipe cannot be read, or if it gives other strands than those the package
/// was sliced from.
pub fn tile_hair(file: &str, manifest: &Manifest) -> Result<Option<TileHair>, BakeError> {
    let fur = &manifest.fur;
    if fur.layers == 0 {
        return Ok(None);
    }
    let fail =
        |reason: String| BakeError::Input { file: file.to_owned(), place: "the manifest's recipe".into(), reason };
    let recipe = Recipe::parse_recorded("recipe", &manifest.recipe).map_err(|error| {
        fail(format!("strands cannot be grown from it: {error}; expected the recipe that `pelage bake` writes"))
    })?;
    let (Some(length_m), Some(tile_size_m)) = (recipe.hair.length_m, recipe.surface.tile_size_m) else {
        let what = "hair.length_m or surface.tile_size_m is missing, expected both, as `pelage bake` writes them";
        return Err(fail(what.into()));
    };
    let furred: Vec<&str> = manifest.materials.iter().filter(|m| m.furred).map(|m| m.name.as_str()).collect();
    let water = FurWetness::of(&recipe.groom, &furred);
    let hair = TileHair::grow(&recipe, Lengths { length_m, tile_size_m }, water).map_err(|e| fail(e.to_string()))?;
    let height_m = hair.strands.height * tile_size_m;
    let same_height = (height_m - fur.height_m).abs() <= 1e-4 * fur.height_m.abs();
    if hair.strands.len() != fur.strands as usize || tile_size_m != fur.tile_size_m || !same_height {
        return Err(fail(format!(
            "it grows {} strands of {height_m} m on a tile of {tile_size_m} m, expected the {} strands of {} m on a \
             tile of {} m that the package was sliced from",
            hair.strands.len(),
            fur.strands,
            fur.height_m,
            fur.tile_size_m
        )));
    }
    Ok(Some(hair))
}

/// Plants the strands of a tile on a mesh.
///
/// * `tile_size_m`: width of the tile on the mesh surface, metres
///
/// Strands with the same fibre form one group, named by [`PosedMesh::fibre_group_name`]. The same arguments give the
/// same strands in the same order, whatever the number of threads.
///
/// Fails with [`BakeError::Params`] if there would be more strands than memory permits.
pub fn grow_on(skin: &PosedMesh, hair: &TileHair, tile_size_m: f64) -> Result<(Curves, GroomReport), BakeError> {
    hair.strands.validate()?;
    let ground = skin.ground();
    let walk = SurfaceWalk::new(&ground);
    let area = |t: usize| {
        let [a, b, c] = skin.corners(t).map(|c| c.tile_uv);
        0.5 * (b - a).perp_dot(c - a).abs()
    };
    let furred: Vec<usize> = (0..skin.triangles.len()).filter(|t| walk.is_furred(*t)).collect();
    let expected = furred.iter().map(|t| area(*t)).sum::<f64>() * hair.strands.len() as f64;
    if expected.is_nan() || expected > MAX_STRANDS {
        let reason = format!("about {expected:.0} strands on the whole mesh, expected at most {MAX_STRANDS:.0}");
        return Err(BakeError::Params { what: "hair.density", reason });
    }
    let roots = (0..hair.strands.len()).filter_map(|i| {
        let root = hair.strands.points.get(hair.strands.range(i).start)?;
        (!hair.strands.range(i).is_empty()).then_some((root.truncate().as_dvec2(), i as u32))
    });
    let gardener = Planter { skin, walk: &walk, hair, tile_size_m, roots: Roots::new(roots) };
    let fibre_at = |t: &usize| skin.material(*t).fibre;
    let fibres: BTreeSet<u8> = furred.iter().map(fibre_at).collect();
    let mut parts: Vec<(Curves, GroomReport)> = Vec::new();
    for fibre in fibres {
        let of: Vec<usize> = furred.iter().copied().filter(|t| fibre_at(t) == fibre).collect();
        let name = skin.fibre_group_name(fibre);
        parts.par_extend(of.par_chunks(64).map(|chunk| gardener.plant(&name, chunk.iter().copied())));
    }
    let mut curves = Curves::default();
    let mut report = GroomReport {
        triangles_without_coordinates: (0..skin.triangles.len())
            .filter(|t| skin.material(*t).furred && !walk.is_furred(*t))
            .count() as u64,
        ..GroomReport::default()
    };
    for (part, counts) in parts {
        curves.append(&part);
        report += counts;
    }
    report.segments = curves.segments() as u64;
    Ok((curves, report))
}

/// Purposes of a strand's random numbers.
#[derive(Clone, Copy)]
enum RandomUse {
    Thinning = 1,
    Wetness,
}

struct Planter<'a> {
    skin: &'a PosedMesh,
    walk: &'a SurfaceWalk<'a>,
    hair: &'a TileHair,
    tile_size_m: f64,
    roots: Roots,
}

impl Planter<'_> {
    fn plant(&self, name: &str, triangles: impl Iterator<Item = usize>) -> (Curves, GroomReport) {
        let mut out = (Curves::default(), GroomReport::default());
        out.0.begin_group(name);
        for triangle in triangles {
            let corners = self.skin.corners(triangle).map(|c| c.tile_uv);
            self.roots.for_each_in(corners, |strand, weights| {
                self.plant_strand(triangle, strand, weights, &mut out);
            });
        }
        out
    }

    /// Plants one strand, unless its root is cut away, bare or thinned out.
    fn plant_strand(
        &self,
        triangle: usize,
        strand: usize,
        weights: DVec3,
        (curves, report): &mut (Curves, GroomReport),
    ) {
        let base = self.skin.hair_base(triangle, self.skin.base_color(triangle, weights));
        if self.skin.is_cut(triangle, base.w) {
            report.dropped_cut += 1;
            return;
        }
        let corners = self.skin.corners(triangle);
        if mix(weights, corners.map(|c| c.fur_height_m as f32)) <= 0.0 {
            report.dropped_bare += 1;
            return;
        }
        let groom = self.skin.groom(triangle, weights);
        let draw = |what: RandomUse| uniform(hash(triangle as u64, strand as u64), what as u64);
        if draw(RandomUse::Thinning) >= groom.x {
            report.dropped_thinned += 1;
            return;
        }
        let wet = self.hair.wet.as_ref().filter(|_| draw(RandomUse::Wetness) < groom.y);
        let strands = wet.unwrap_or(&self.hair.strands);
        let mut at = WalkPosition { triangle, weights, beyond: None };
        let mut crossed = WalkEvents::default();
        let range = strands.range(strand);
        let mut points = Vec::with_capacity(range.len());
        for i in range.clone() {
            if i > range.start {
                let by = strands.points[i].truncate() - strands.points[i - 1].truncate();
                self.walk.step(&mut at, by.as_dvec2(), &mut crossed);
            }
            points.push(self.point(strands, i, &at, base.truncate()));
        }
        report.points_before += points.len() as u64;
        let points = simplified(&points, SIMPLIFICATION);
        let root_uv = mix(weights, corners.map(|c| c.base_uv));
        curves.push(&points, wet.is_some(), root_uv);
        report.strands += 1;
        report.crossed_patch_border += u64::from(crossed.patch_border);
        report.crossed_mesh_border += u64::from(crossed.mesh_border);
        report.slid_along_border += u64::from(crossed.slid);
        report.lost += u64::from(crossed.lost);
    }

    fn point(&self, strands: &Strands, i: usize, at: &WalkPosition, tint: glam::Vec3) -> CurvePoint {
        let share = f64::from(strands.points[i].z / strands.height);
        let corners = self.skin.corners(at.triangle);
        let sum = |each: [DVec3; 3]| each[0] * at.weights.x + each[1] * at.weights.y + each[2] * at.weights.z;
        let by = self.walk.place_weights(at);
        let place = corners[0].position_ws * by.x + corners[1].position_ws * by.y + corners[2].position_ws * by.z;
        let offset = sum(corners.map(|c| hair_offset(c.normal_ws, c.bitangent_ws, c.lean, share, c.fur_height_m)));
        CurvePoint {
            position_ws: (place + offset).as_vec3(),
            radius_m: (f64::from(strands.radii[i]) * self.tile_size_m) as f32,
            color: strands.colors[i] * tint,
            height: share as f32,
            normal_ws: sum(corners.map(|c| c.normal_ws)).normalize_or(corners[0].normal_ws).as_vec3(),
        }
    }
}

#[cfg(test)]
#[path = "plant_tests.rs"]
mod tests;
