//! From a mesh to hair-tile coordinates and tile frames: the `surface` stage.
//!
//! The mesh is repaired, never rejected, a comb field is laid over it, and the tile's coordinates come from lapped
//! patches that follow the field, or from the model's own texture coordinates. What comes out: vertices joined where nothing
//! tells them apart and split where two sides disagree; per vertex a tile coordinate, a tangent (+u) and a handedness; normals
//! that agree across seams, so that the shells do not gape; and the measures of the parameterization.

mod comb;
mod emit;
mod field;
mod frames;
mod grow;
mod lapped;
mod measure;
mod repair;
mod solve;
mod topology;
mod weld;

pub use comb::{Comb, Guide};
pub use measure::Measures;

use crate::BakeError;
use crate::mesh::{Mesh, Model, RestPose};
use crate::recipe;
use glam::{DVec2, DVec3, Vec2, Vec3, Vec4};
use solve::FaceFrame;
use topology::{NONE, Topology};

/// Where hair grows, how large its tile is and how it lies.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceParams {
    /// Width of a tile on the skin, metres, greater than 0: the reciprocal of tiles per metre.
    pub tile_size_m: f32,
    /// One per material: whether hair grows on it. The shorter list counts as bare at its end.
    pub furred: Vec<bool>,
    /// Where tile coordinates come from.
    pub source: Source,
    /// Where hair is combed to.
    pub comb: Comb,
    /// How far neighbours are asked where the comb is weak or broken, tiles, greater than 0 (default 0.5).
    pub comb_smoothing: f32,
    /// Hairs per area against the recipe's, one per vertex of the input mesh, greater than 0; `None` for 1 everywhere. With the
    /// model's own coordinates it has no effect.
    pub density: Option<Vec<f32>>,
}

/// A recipe's, with tiles of 0.1 m and no furred material.
impl Default for SurfaceParams {
    fn default() -> Self {
        Self::from_recipe(&recipe::SurfaceParams::default(), 0.1, Vec::new())
    }
}

/// Where tile coordinates come from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Source {
    /// Lapped patches over any surface (Lengyel et al. 2001).
    Patches(PatchParams),
    /// The model's own texture coordinates, scaled.
    Model,
}

/// How far lapped patches go. Larger patches have fewer seams and more distortion. [`recipe::SurfaceParams`] has the ranges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatchParams {
    /// How far a patch may grow from its seed, tiles (default 2).
    pub size: f32,
    /// Largest angle between a patch's v direction and the comb, degrees (default 25).
    pub turn_deg: f32,
    /// Largest stretch of a triangle in any direction, and the inverse of the least (default 1.5).
    pub stretch: f32,
    /// 1 follows the comb, 0 turns each triangle to what distorts least (default 0.5).
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

/// What a recipe with these patches says; all else at its default.
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

/// A recipe's.
impl Default for PatchParams {
    fn default() -> Self {
        Self::from(&recipe::SurfaceParams::default())
    }
}

/// A mesh with hair-tile coordinates.
#[derive(Clone, Debug)]
pub struct Surface {
    /// The mesh: vertices renumbered, faulty triangles gone, the others and the parts in the order of the input.
    pub mesh: Mesh,
    /// Its rest pose, renumbered alike.
    pub rest: RestPose,
    /// For each vertex the vertex of the input that it came from.
    pub input_vertex: Vec<u32>,
    /// One per vertex; 1 is one tile.
    pub tile_uvs: Vec<Vec2>,
    /// One per vertex: unit tangent along +u in the mesh's own space; fourth component ±1, bitangent = w · normal × tangent.
    pub tangents: Vec<Vec4>,
    /// For each triangle the patch in which its tile coordinates are continuous, from 0 without gaps; `u32::MAX` on bare parts.
    pub patch_of_triangle: Vec<u32>,
    /// Where the comb field has no direction: place at rest, metres, and index (1 source, sink or whorl, −1 saddle).
    pub singularities: Vec<(Vec3, i32)>,
    /// Quality of the parameterization on the furred parts.
    pub measures: Measures,
    /// What was repaired, guessed or left out.
    pub warnings: Vec<String>,
}

/// Lays the hair's tile on a model.
///
/// # Errors
/// [`BakeError::Params`] for a parameter outside its range. [`BakeError::Input`], naming the primitive, where a furred part lacks the
/// texture coordinates that [`Source::Model`] or [`Comb::Tangents`] needs.
pub fn parameterize(file: &str, model: &Model, params: &SurfaceParams) -> Result<Surface, BakeError> {
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
    repair::report(&mesh, &repaired.faults, &mut warnings);
    emit::keep_sound_triangles(&mut mesh, model.animation.as_ref(), &repaired);
    let furred_triangles = params.furred_triangles(&mesh);
    weld::smooth_normals_over_seams(&mut mesh, &repaired.topology.faces, &furred_triangles);

    let skin = Skin::new(repaired.topology, &furred_triangles);
    let wishes = comb::wishes(&skin, &mesh, &input_vertex, &params.comb, &mut warnings);
    let smoothing_m = f64::from(params.comb_smoothing) * f64::from(params.tile_size_m);
    let field = field::comb_field(&skin.topology, &wishes, smoothing_m);
    let frames = face_frames(&skin, &mesh, &input_vertex, &field, params);
    let combed = params.comb != Comb::None;
    let singularities = if combed { field::singularities(&skin.topology, &field) } else { Vec::new() };

    let emitted = match &params.source {
        Source::Patches(patches) => {
            let lapped = lapped::lapped_patches(&skin.topology, &frames, &patches.lapped(combed));
            if lapped.unsolved > 0 {
                warnings.push(format!(
                    "surface: {} patches were parted because their equations had no trustworthy solution (slivers)",
                    lapped.unsolved
                ));
            }
            emit::patches(&mut mesh, &mut input_vertex, &skin, &lapped, combed.then_some(&field[..]))
        }
        Source::Model => {
            let tile_m = params.tile_size_m;
            emit::model_uvs(&mut mesh, &mut input_vertex, &rest, &furred_triangles, tile_m, &mut warnings)
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
    /// Copies vertex `v` to the end of all streams and returns the copy's number.
    pub fn copy_vertex(&mut self, v: u32) -> u32 {
        let at = v as usize;
        self.rest.positions.push(self.rest.positions[at]);
        self.rest.normals.push(self.rest.normals[at]);
        self.input_vertex.push(self.input_vertex[at]);
        self.tile_uvs.push(self.tile_uvs[at]);
        self.tangents.push(self.tangents[at]);
        emit::copy_vertex(&mut self.mesh, at)
    }
}

impl SurfaceParams {
    /// What a recipe says, with the tile's width resolved for the model and `furred` for its materials.
    pub fn from_recipe(recipe: &recipe::SurfaceParams, tile_size_m: f32, furred: Vec<bool>) -> Self {
        let guide =
            |g: &recipe::GuideParams| Guide { name: g.name.clone(), at: g.at.into(), direction: g.direction.into() };
        Self {
            tile_size_m,
            furred,
            source: match recipe.source {
                recipe::SurfaceSource::Model => Source::Model,
                recipe::SurfaceSource::Patches => Source::Patches(recipe.into()),
            },
            comb: match recipe.comb {
                recipe::CombSource::Direction => Comb::Direction(recipe.comb_direction.into()),
                recipe::CombSource::Gravity => Comb::Gravity,
                recipe::CombSource::Tangents => Comb::Tangents,
                recipe::CombSource::Guides => Comb::Guides(recipe.guides.iter().map(guide).collect()),
                recipe::CombSource::None => Comb::None,
            },
            comb_smoothing: recipe.comb_smoothing,
            density: None,
        }
    }

    fn check(&self) -> Result<(), BakeError> {
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
            Comb::Guides(guides) if guides.is_empty() => {
                return fail(
                    "surface.guides",
                    "there are none, expected at least one for surface.comb = \"guides\"".into(),
                );
            }
            _ => {}
        }
        if let Some(bad) = self.density.iter().flatten().find(|v| !positive(**v)) {
            return fail("groom.density", format!("{bad}, expected numbers greater than 0"));
        }
        if let Source::Patches(p) = &self.source {
            // The recipe's declaration is the one place that says how far patches may go.
            recipe::SurfaceParams::from(p).validate()?;
        }
        Ok(())
    }

    fn is_furred(&self, material: usize) -> bool {
        self.furred.get(material).copied().unwrap_or(false)
    }

    fn furred_triangles(&self, mesh: &Mesh) -> Vec<bool> {
        let mut out = vec![false; mesh.triangles.len()];
        for part in mesh.parts.iter().filter(|p| self.is_furred(p.material)) {
            out[part.first_triangle..part.first_triangle + part.triangle_count].fill(true);
        }
        out
    }
}

impl PatchParams {
    fn lapped(&self, combed: bool) -> lapped::LappedParams {
        lapped::LappedParams {
            reach: grow::Reach { tiles: f64::from(self.size), turn_rad: f64::to_radians(120.0), combed },
            bounds: lapped::Bounds {
                least_cosine: if combed { f64::from(self.turn_deg).to_radians().cos() } else { -1.0 },
                stretch: f64::from(self.stretch),
            },
            comb_weight: if combed { f64::from(self.comb_weight) } else { 0.0 },
        }
    }
}

fn require_uvs(file: &str, model: &Model, params: &SurfaceParams) -> Result<(), BakeError> {
    let (key, what) = match (&params.source, &params.comb) {
        (Source::Model, _) => {
            ("surface.source = \"model\" lays the hair by", "or let surface.source = \"patches\" do without")
        }
        (_, Comb::Tangents) => ("surface.comb = \"tangents\" combs the hair by", "or choose another surface.comb"),
        _ => return Ok(()),
    };
    let lacking = |p: &&crate::mesh::MeshPart| params.is_furred(p.material) && !p.has_uvs;
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

/// The furred part of a repaired mesh.
struct Skin {
    topology: Topology,
    /// For each face its triangle in the mesh.
    triangles: Vec<u32>,
}

impl Skin {
    fn new(whole: Topology, furred: &[bool]) -> Self {
        let triangles: Vec<u32> = (0..furred.len() as u32).filter(|t| furred[*t as usize]).collect();
        if triangles.len() == furred.len() {
            return Self { topology: whole, triangles };
        }
        let mut face_of = vec![NONE; furred.len()];
        triangles.iter().enumerate().for_each(|(f, t)| face_of[*t as usize] = f as u32);
        let twin = |h: u32| match whole.twins[h as usize] {
            NONE => NONE,
            twin if face_of[twin as usize / 3] == NONE => NONE,
            twin => 3 * face_of[twin as usize / 3] + twin % 3,
        };
        let faces = triangles.iter().map(|t| whole.faces[*t as usize]).collect();
        let twins = triangles.iter().flat_map(|t| (3 * t..3 * t + 3).map(twin)).collect();
        Self { topology: Topology::new(whole.points, faces, twins), triangles }
    }
}

fn face_frames(
    skin: &Skin,
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
