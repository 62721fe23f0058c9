//! Atlas that depends on the model alone: texture coordinates for images, independent of the recipe, so that painted
//! images remain valid.
//!
//! Patches with the least distortion are grown over the whole mesh, bare parts included, and packed as charts. Sizes
//! are derived from the model's, and all constants are defined here, because a changed default of a recipe must not
//! move painted images.

use super::atlas::{Atlas, TooManyCharts};
use super::flow::image_axes;
use crate::stages::surface::{Comb, PatchParams, Source, Surface, SurfaceParams, parameterize};
use glam::{Vec2, Vec3};
use pelage_import::BakeError;
use pelage_import::mesh::{Mesh, Model, RestPose};
use std::collections::BTreeMap;

/// Maximum distance of a patch's border from its seed, as a share of the diagonal of the model's bounding box.
const PATCH_PER_DIAGONAL: f32 = 0.5;
/// Largest stretch of a triangle in any direction; the smallest is its reciprocal.
const STRETCH: f32 = 1.6;
/// Texture sizes to try for packing the charts, texels. The first size at which every chart has the widest gutter is
/// used. The image itself may have any size.
const SIDES: [u32; 4] = [1024, 2048, 4096, 8192];

/// Identity of a model's vertex: material, position, joints and weights. It stays the same when the mesh is cut or
/// welded.
type Key = (usize, [u32; 3], [u16; 4], [u32; 4]);

/// Atlas of a model.
#[derive(Clone, Debug)]
pub struct ModelAtlas {
    /// Valid triangles of the model, in order, with the atlas as texture coordinates. Vertices are duplicated at the
    /// borders of charts.
    pub mesh: Mesh,
    /// Rest pose of the mesh.
    pub rest: RestPose,
    /// Width and height for which the atlas was packed, texels.
    pub side: u32,
    /// Gutter around each chart, texels of a texture of width `side`.
    pub gutter: u32,
    /// Vertices of `mesh` that correspond to each vertex of the model, one per distinct texture coordinate.
    standing_for: BTreeMap<Key, Vec<u32>>,
    /// Unit directions on the surface that point right and up on the atlas, per vertex of `mesh`.
    axes: Vec<[Vec3; 2]>,
}

impl ModelAtlas {
    /// Lays out a whole model.
    ///
    /// * `file`: the model as the user named it, for messages
    ///
    /// Fails with [`BakeError::Input`] if no triangle has an area, or if there are more separate charts than any
    /// texture can hold.
    pub fn new(file: &str, model: &Model) -> Result<Self, BakeError> {
        let diagonal_m = diagonal(&RestPose::of(&model.mesh, model.animation.as_ref()).positions);
        let patches = PatchParams { size: 1.0, turn_deg: 60.0, stretch: STRETCH, comb_weight: 0.0 };
        let params = SurfaceParams {
            tile_size_m: (PATCH_PER_DIAGONAL * diagonal_m).max(f32::MIN_POSITIVE),
            furred: vec![true; model.materials.len()],
            source: Source::Patches(patches),
            comb: Comb::None,
            comb_smoothing: 0.5,
            density: None,
        };
        let uncut = parameterize(file, model, &params)?;
        let (surface, atlas) = packed(uncut).map_err(|TooManyCharts { charts }| BakeError::Input {
            file: file.to_owned(),
            place: "whole model".to_owned(),
            reason: format!(
                "its skin consists of {charts} pieces, which are too many for an atlas; expected fewer: merge \
                 vertices that share a position, or unwrap it in a modelling tool and keep groom.coordinates = \
                 \"model\""
            ),
        })?;
        let Surface { mut mesh, rest, .. } = surface;
        mesh.uvs = atlas.uvs.iter().map(|uv| uv.unwrap_or_default()).collect();
        mesh.parts.iter_mut().for_each(|part| part.has_uvs = true);
        let axes = image_axes(&mesh, &rest);
        let standing_for = by_key(&mesh);
        Ok(Self { mesh, rest, side: atlas.side, gutter: atlas.gutter, standing_for, axes })
    }

    /// Returns the vertices of the atlas that correspond to vertex `v` of `mesh`, the model's mesh after cutting or
    /// welding. There is one per texture coordinate, and none if the vertex's triangles have no area.
    pub(super) fn standing_for(&self, mesh: &Mesh, material: usize, v: usize) -> &[u32] {
        self.standing_for.get(&key(mesh, material, v)).map_or(&[], Vec::as_slice)
    }

    /// Returns the texture coordinate of a vertex of the atlas.
    pub(super) fn uv(&self, vertex: u32) -> Vec2 {
        self.mesh.uvs[vertex as usize]
    }

    /// Returns the directions on the surface, at rest, that point right and up on the atlas at one of its vertices.
    pub(super) fn axes(&self, vertex: u32) -> [Vec3; 2] {
        self.axes[vertex as usize]
    }

    /// Returns two lists. The first has the number of the model's vertex at each corner of each triangle. The second
    /// has the texture coordinates of each numbered vertex.
    pub fn corner_coordinates(&self) -> (Vec<[u32; 3]>, Vec<Vec<Vec2>>) {
        let mut number_of = vec![0; self.mesh.positions.len()];
        let mut coordinates = Vec::new();
        let keys: BTreeMap<&Key, u32> = self.standing_for.keys().zip(0..).collect();
        for vertices in self.standing_for.values() {
            coordinates.push(vertices.iter().map(|v| self.uv(*v)).collect());
        }
        for (material, v) in corners(&self.mesh) {
            number_of[v] = keys.get(&key(&self.mesh, material, v)).copied().unwrap_or_default();
        }
        (self.mesh.triangles.iter().map(|t| t.map(|v| number_of[v as usize])).collect(), coordinates)
    }
}

/// Returns the diagonal of the bounding box.
fn diagonal(points: &[Vec3]) -> f32 {
    let box_of = |(min, max): (Vec3, Vec3), p: &Vec3| (min.min(*p), max.max(*p));
    let (min, max) = points.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), box_of);
    if points.is_empty() { 0.0 } else { min.distance(max) }
}

/// Packs the charts at the smallest of [`SIDES`] at which every chart has the widest gutter. If there is none, packs
/// them at the largest.
fn packed(uncut: Surface) -> Result<(Surface, Atlas), TooManyCharts> {
    let mut found = Err(TooManyCharts { charts: 0 });
    for side in SIDES {
        let mut surface = uncut.clone();
        found = Atlas::pack(&mut surface, side).map(|atlas| (surface, atlas));
        if found.as_ref().is_ok_and(|(_, atlas)| atlas.is_roomy()) {
            break;
        }
    }
    found
}

fn key(mesh: &Mesh, material: usize, v: usize) -> Key {
    // Adding zero turns -0 into +0.
    let bits = |x: f32| (x + 0.0).to_bits();
    let (joints, weights) = mesh.skin.get(v).map_or(([0; 4], [0.0; 4]), |skin| (skin.joints, skin.weights));
    (material, mesh.positions[v].to_array().map(bits), joints, weights.map(bits))
}

/// Returns material and vertex of every corner of every triangle.
fn corners(mesh: &Mesh) -> impl Iterator<Item = (usize, usize)> {
    mesh.parts.iter().flat_map(|part| {
        let triangles = &mesh.triangles[part.first_triangle..part.first_triangle + part.triangle_count];
        triangles.iter().flatten().map(|v| (part.material, *v as usize))
    })
}

/// Returns the vertices of each key, one per distinct texture coordinate.
fn by_key(mesh: &Mesh) -> BTreeMap<Key, Vec<u32>> {
    let mut found: BTreeMap<Key, Vec<u32>> = BTreeMap::new();
    for (material, v) in corners(mesh) {
        let known = found.entry(key(mesh, material, v)).or_default();
        if known.iter().all(|k| mesh.uvs[*k as usize] != mesh.uvs[v]) {
            known.push(v as u32);
        }
    }
    found
}

#[cfg(test)]
#[path = "model_atlas_tests.rs"]
mod tests;
