//! `surface` stage: computes hair-tile coordinates and tile frames for a mesh.
//!
//! The mesh is repaired, never rejected. A comb field is computed on it. Tile coordinates come from lapped patches that
//! follow the field, or from the model's own texture coordinates. The results are:
//!
//! * vertices, joined if nothing distinguishes them, and split where two sides differ;
//! * a tile coordinate, a tangent (+u) and a handedness for each vertex;
//! * normals that agree across seams, so that the shells have no gaps;
//! * measures of the parameterization.

mod comb;
mod field;
mod frames;
mod furred_mesh;
mod grow;
mod lapped;
mod marks;
mod measure;
mod params;
mod repair;
mod solve;
mod sparse;
mod topology;
mod vertex_data;
mod weld;

pub use comb::Comb;
pub use marks::CombMark;
pub use measure::Measures;
pub use params::{PatchParams, Source, SurfaceParams};

use crate::progress::StageProgress;
use furred_mesh::FurredMesh;
use glam::{DVec2, DVec3, Vec2, Vec3, Vec4};
use pelage_import::BakeError;
use pelage_import::mesh::{Mesh, Model, RestPose};
use solve::FaceFrame;

/// Mesh with hair-tile coordinates.
#[derive(Clone, Debug)]
pub struct Surface {
    /// Mesh with renumbered vertices and without faulty triangles. The other triangles and the parts keep the input's
    /// order.
    pub mesh: Mesh,
    /// Rest pose of `mesh`.
    pub rest: RestPose,
    /// Index of the input vertex that each vertex was copied from.
    pub input_vertex: Vec<u32>,
    /// Tile coordinates per vertex; 1 is one tile.
    pub tile_uvs: Vec<Vec2>,
    /// Unit tangent of each vertex along +u, in the mesh's own space. The fourth component w is ±1: bitangent = w ·
    /// normal × tangent.
    pub tangents: Vec<Vec4>,
    /// Patch of each triangle, from 0 without gaps; `u32::MAX` on bare parts. Tile coordinates are continuous within a
    /// patch.
    pub patch_of_triangle: Vec<u32>,
    /// Points where the comb field has no direction: position at rest, metres, and index (1 for a source, sink or
    /// whorl, −1 for a saddle).
    pub singularities: Vec<(Vec3, i32)>,
    /// Quality of the parameterization on the furred parts.
    pub measures: Measures,
    /// Warnings about repairs, guesses and omissions.
    pub warnings: Vec<String>,
}

/// Computes hair-tile coordinates for a model.
///
/// Fails with [`BakeError::Params`] for a parameter outside its range. [`BakeError::Input`], naming the primitive, if a
/// furred part lacks the texture coordinates that [`Source::Model`] or [`Comb::Tangents`] needs.
pub fn parameterize(file: &str, model: &Model, params: &SurfaceParams) -> Result<Surface, BakeError> {
    parameterize_with_progress(file, model, params, StageProgress::ignored())
}

/// Does the same as [`parameterize`], and counts the patches in `progress`: each when it is laid out, and each union of
/// two that is tried.
///
/// Fails like [`parameterize`].
pub fn parameterize_with_progress(
    file: &str,
    model: &Model,
    params: &SurfaceParams,
    progress: &StageProgress,
) -> Result<Surface, BakeError> {
    params.check()?;
    require_uvs(file, model, params)?;
    let mut warnings = Vec::new();
    let (mut mesh, mut input_vertex) = weld::join_equal_vertices(&model.mesh);
    let isolated = model.mesh.positions.len() - weld::used_vertices(&model.mesh);
    if isolated > 0 {
        warnings.push(format!("{isolated} vertices belong to no triangle and were removed"));
    }
    let rest = RestPose::of(&mesh, model.animation.as_ref());
    let positions: Vec<DVec3> = rest.positions.iter().map(|p| p.as_dvec3()).collect();
    let repaired = repair::repair(&positions, &mesh.triangles);
    if repaired.triangles.is_empty() {
        return Err(BakeError::Input {
            file: file.into(),
            place: "whole model".into(),
            reason: format!(
                "none of its {} triangles has an area at rest, expected at least one that does",
                mesh.triangles.len()
            ),
        });
    }
    repair::report(&mesh, &repaired.faults, &mut warnings);
    vertex_data::apply_repair(&mut mesh, model.animation.as_ref(), &repaired);
    let furred_triangles = params.furred_triangles(&mesh);
    weld::smooth_normals_over_seams(&mut mesh, &repaired.topology.faces, &furred_triangles);

    let skin = FurredMesh::new(repaired.topology, &furred_triangles);
    let wishes = comb::wanted_directions(&skin, &mesh, &input_vertex, &params.comb, &mut warnings);
    let smoothing_m = f64::from(params.comb_smoothing) * f64::from(params.tile_size_m);
    let field = field::comb_field(&skin.topology, &wishes, smoothing_m);
    let frames = face_frames(&skin, &mesh, &input_vertex, &field, params);
    let combed = params.comb != Comb::None;
    let singularities = if combed { field::singularities(&skin.topology, &field) } else { Vec::new() };

    let emitted = match &params.source {
        Source::Patches(patches) => {
            let lapped = lapped::lapped_patches(&skin.topology, &frames, &patches.lapped(combed), progress);
            if lapped.unsolved > 0 {
                warnings.push(format!(
                    "surface: {} patches were split because their equations had no reliable solution (slivers)",
                    lapped.unsolved
                ));
            }
            vertex_data::patches(&mut mesh, &mut input_vertex, &skin, &lapped, combed.then_some(&field[..]))
        }
        Source::Model => {
            let tile_m = params.tile_size_m;
            vertex_data::model_uvs(&mut mesh, &mut input_vertex, &rest, &furred_triangles, tile_m, &mut warnings)
        }
    };
    let rest = RestPose::of(&mesh, model.animation.as_ref());
    let corners = |f: usize| mesh.triangles[skin.triangles[f] as usize].map(|v| emitted.tile_uvs[v as usize]);
    let corners: Vec<[DVec2; 3]> = (0..skin.triangles.len()).map(|f| corners(f).map(Vec2::as_dvec2)).collect();
    let (measures, patch_of) = measure::measure(&skin.topology, &frames, &corners, combed, singularities.len());
    let mut patch_of_triangle = vec![u32::MAX; mesh.triangles.len()];
    skin.triangles.iter().zip(patch_of).for_each(|(t, patch)| patch_of_triangle[*t as usize] = patch);
    let places = singularities.iter().map(|(p, index)| (skin.topology.points[*p as usize].as_vec3(), *index)).collect();
    Ok(Surface {
        mesh,
        rest,
        input_vertex,
        tile_uvs: emitted.tile_uvs,
        tangents: emitted.tangents,
        patch_of_triangle,
        singularities: places,
        measures,
        warnings,
    })
}

impl Surface {
    /// Appends a copy of vertex `v` to all streams and returns the index of the copy.
    pub fn copy_vertex(&mut self, v: u32) -> u32 {
        let at = v as usize;
        self.rest.positions.push(self.rest.positions[at]);
        self.rest.normals.push(self.rest.normals[at]);
        self.input_vertex.push(self.input_vertex[at]);
        self.tile_uvs.push(self.tile_uvs[at]);
        self.tangents.push(self.tangents[at]);
        self.mesh.copy_vertex(at)
    }
}

fn require_uvs(file: &str, model: &Model, params: &SurfaceParams) -> Result<(), BakeError> {
    let (key, what) = match (&params.source, &params.comb) {
        (Source::Model, _) => (
            "surface.source = \"model\" needs to lay the hair",
            "or set surface.source = \"patches\", which needs none",
        ),
        (_, Comb::Tangents) => {
            ("surface.comb = \"tangents\" needs to comb the hair", "or choose a different surface.comb")
        }
        _ => return Ok(()),
    };
    let lacking = |p: &&pelage_import::mesh::MeshPart| params.is_furred(p.material) && !p.has_uvs;
    let Some(part) = model.mesh.parts.iter().find(lacking) else { return Ok(()) };
    let material = model.materials.get(part.material).map_or("", |m| m.name.as_str());
    Err(BakeError::Input {
        file: file.into(),
        place: part.source.clone(),
        reason: format!(
            "no texture coordinates (TEXCOORD_0), which {key}; unwrap the mesh in a modelling tool, list its material \
             {material:?} under model.bare, {what}"
        ),
    })
}

fn face_frames(
    skin: &FurredMesh,
    mesh: &Mesh,
    input_vertex: &[u32],
    field: &[DVec3],
    params: &SurfaceParams,
) -> Vec<FaceFrame> {
    let density = |f: usize| {
        let Some(density) = &params.density else { return 1.0 };
        let corners = mesh.triangles[skin.triangles[f] as usize];
        corners.iter().map(|v| density.get(input_vertex[*v as usize] as usize).copied().unwrap_or(1.0)).sum::<f32>()
            / 3.0
    };
    let tile_m = f64::from(params.tile_size_m);
    let frame = |(f, t): (usize, &DVec3)| FaceFrame {
        s: t.cross(skin.topology.normals[f]),
        t: *t,
        tile_m: tile_m / f64::from(density(f)).sqrt(),
    };
    field.iter().enumerate().map(frame).collect()
}
