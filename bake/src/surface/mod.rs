//! From a mesh to hair-tile coordinates and tile frames: the `surface` stage.
//!
//! The tile coordinates of this version are the model's own texture coordinates, scaled so that a tile has the recipe's size on
//! the skin. What comes out: vertices joined where nothing tells them apart and split where two charts of opposite handedness
//! meet; per vertex a tile coordinate, a tangent (+u) and a handedness; normals that agree across seams, so that the shells do
//! not gape; and the measures of the parameterization.

mod frames;
mod measure;
mod weld;

pub use measure::Measures;

use crate::BakeError;
use crate::mesh::{Mesh, Model, RestPose};
use glam::{Vec2, Vec4};

/// Where hair grows and how large its tile is.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceParams {
    /// Width of a tile on the skin, metres, greater than 0.
    pub tile_size_m: f32,
    /// One per material: whether hair grows on it. The shorter list counts as bare at its end.
    pub furred: Vec<bool>,
}

/// A mesh with hair-tile coordinates.
#[derive(Clone, Debug)]
pub struct Surface {
    /// The mesh; vertices renumbered, triangles and parts in the order of the input.
    pub mesh: Mesh,
    /// Its rest pose, renumbered alike.
    pub rest: RestPose,
    /// One per vertex; 1 is one tile.
    pub tile_uvs: Vec<Vec2>,
    /// One per vertex: unit tangent along +u in the mesh's own space; fourth component ±1, bitangent = w · normal × tangent.
    pub tangents: Vec<Vec4>,
    /// Quality of the parameterization on the furred parts.
    pub measures: Measures,
    /// What was guessed or left out.
    pub warnings: Vec<String>,
}

/// Takes the model's own texture coordinates as hair-tile coordinates.
///
/// Fails with [`BakeError::Input`], naming the primitive, where a furred part has no texture coordinates.
pub fn from_model_uvs(file: &str, model: &Model, params: &SurfaceParams) -> Result<Surface, BakeError> {
    if !(params.tile_size_m > 0.0 && params.tile_size_m.is_finite()) {
        let reason = format!("{} metres, expected a number greater than 0", params.tile_size_m);
        return Err(BakeError::Params { what: "surface.tile_size_m", reason });
    }
    let is_furred = |material: usize| params.furred.get(material).copied().unwrap_or(false);
    if let Some(part) = model.mesh.parts.iter().find(|p| is_furred(p.material) && !p.has_uvs) {
        let material = model.materials.get(part.material).map_or("", |m| m.name.as_str());
        return Err(BakeError::Input {
            file: file.into(),
            place: part.source.clone(),
            reason: format!(
                "no texture coordinates (TEXCOORD_0), which surface.source = \"model\" lays the hair by; \
                 unwrap the mesh in a modelling tool, or list its material {material:?} under model.bare"
            ),
        });
    }
    let mut warnings = Vec::new();
    let mut mesh = weld::join_equal_vertices(&model.mesh);
    let mut furred_triangles = vec![false; mesh.triangles.len()];
    for part in mesh.parts.iter().filter(|p| is_furred(p.material)) {
        furred_triangles[part.first_triangle..part.first_triangle + part.triangle_count].fill(true);
    }
    weld::smooth_normals_over_seams(&mut mesh, &furred_triangles);
    let rest = RestPose::of(&mesh, model.animation.as_ref());

    let scale = frames::tile_scale(&mesh, &rest, &furred_triangles, params.tile_size_m, &mut warnings);
    let mut tile_uvs: Vec<Vec2> = mesh.uvs.iter().map(|uv| *uv * scale).collect();
    let tangents = frames::tile_frames(&mut mesh, &rest, &mut tile_uvs, &mut warnings);
    let rest = RestPose::of(&mesh, model.animation.as_ref());
    let measures = measure::measure(&mesh, &rest, &tile_uvs, &furred_triangles);
    Ok(Surface { mesh, rest, tile_uvs, tangents, measures, warnings })
}
