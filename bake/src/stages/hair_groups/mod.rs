//! `groom`, guided hair: converts `[[strands.group]]` and `[[strands.tuft]]` to the form that a package stores.
//!
//! The package contains a group's scalp, guides and parameters. The hairs are derived from them when the package is
//! loaded ([`pelage_formats::meaning::hair_groups`]).

mod body;
mod file_guides;
mod ground;
mod grow;
mod rest_guides;
mod tuft;

#[cfg(test)]
mod tests;

pub use ground::GroomTarget;
pub use rest_guides::{GuidesAtRest, RestMesh, StoredOffsets};

use crate::recipe::{HairGroupParams, ScalarMap, StrandParams};
use crate::stages::groom::scalar_at;
use crate::stages::simulate::StyleForces;
use body::SurfaceIndex;
use file_guides::read_guides;
use glam::Vec3;
use ground::{GroupError, bytes, parts_of};
use grow::Growth;
use pelage_formats::meaning::hair_groups::{PointGrid, roots};
use pelage_formats::{HairGroup, TrianglePoint};
use pelage_import::BakeError;
use pelage_import::mesh::MeshPart;
use rayon::prelude::*;
use tuft::tuft_of;

/// Density below which no hair grows.
const MIN_DENSITY: f32 = 0.01;

/// Guided hair.
#[derive(Clone, Debug, Default)]
pub struct GuidedHair {
    /// Groups of the recipe, then its tufts.
    pub groups: Vec<HairGroup>,
    /// Freedom of motion of each guide in each group, as in [`pelage_formats::HairMotion::freedom`].
    pub freedom: Vec<Vec<u8>>,
    /// Messages about repaired or skipped input.
    pub warnings: Vec<String>,
}

/// Makes the hair groups of a recipe.
///
/// Fails with [`BakeError::Input`] naming the recipe table if nothing can grow: the material does not exist, no
/// triangle is left, or no guide touches the scalp.
pub fn groups(params: &StrandParams, ground: &GroomTarget<'_>) -> Result<GuidedHair, BakeError> {
    let mut hair = GuidedHair::default();
    if params.group.is_empty() && params.tuft.is_empty() {
        return Ok(hair);
    }
    let body = SurfaceIndex::new(&ground.mesh.triangles, &ground.rest.positions, &ground.rest.normals);
    for (number, group) in params.group.iter().enumerate() {
        let fail = |reason: GroupError| match reason {
            GroupError::Here(reason) => input_error(ground, "group", number, &group.name, reason),
            GroupError::Elsewhere(error) => error,
        };
        let made = group_of(group, ground, &body, &mut hair.warnings).map_err(fail)?;
        hair.freedom.push(freedom(group, &made, ground)?);
        hair.groups.push(made);
    }
    for (number, tuft) in params.tuft.iter().enumerate() {
        let fail = |reason| input_error(ground, "tuft", number, &tuft.name, reason);
        hair.groups.push(tuft_of(tuft, ground, &body, &mut hair.warnings).map_err(fail)?);
        hair.freedom.push(Vec::new());
    }
    Ok(hair)
}

fn input_error(ground: &GroomTarget<'_>, table: &str, number: usize, name: &str, reason: String) -> BakeError {
    BakeError::Input {
        file: ground.file.to_owned(),
        place: format!("strands.{table}, table {number} {name:?}"),
        reason,
    }
}

fn group_of(
    params: &HairGroupParams,
    ground: &GroomTarget<'_>,
    body: &SurfaceIndex<'_>,
    warnings: &mut Vec<String>,
) -> Result<HairGroup, GroupError> {
    let scalp = scalp(params, ground)?;
    let length_m = params.length_m.unwrap_or(ground.radius_m / 6.0);
    let forces = StyleForces::of(params.style()).guides;
    let guide_points = params.guide_points.unwrap_or(forces.points);
    let root_radius_m = params.root_radius_m();
    let mut group = HairGroup {
        name: params.name.clone(),
        hairs: params.hairs(),
        points: params.points(),
        guide_points,
        seed: params.seed(),
        root_radius_m,
        tip_radius_m: params.tip_radius_m.unwrap_or(root_radius_m / 3.0).min(root_radius_m),
        root_color: bytes(params.root_color()),
        tip_color: bytes(params.tip_color()),
        color_variation: params.color_variation(),
        length_variation: params.length_variation(),
        clump: params.clump(),
        lock_hairs: params.lock_hairs(),
        stray: params.stray(),
        scalp,
        ..HairGroup::default()
    };
    let guides = match &params.file {
        Some(path) => {
            let strands = ground.files.strands.get(&path.0);
            let missing = || BakeError::Internal(format!("the strands {:?} were not read", path.0));
            let guides = read_guides(params, &group, strands.ok_or_else(missing)?, ground, body, warnings)?;
            group.scalp = scalp_near_guides(&group.scalp, &guides, body);
            guides
        }
        None => {
            let fall = Vec3::from(params.fall()).try_normalize();
            let growth = Growth {
                forces,
                fall: fall.ok_or_else(|| GroupError::Here("fall is [0, 0, 0], expected a direction".into()))?,
                comb: Vec3::from(params.comb()).normalize_or_zero(),
                parting_m: params.parting_m,
                rise: params.rise(),
                length_m,
                stiffness: params.stiffness(),
                lift: params.lift(),
                guide_points: guide_points as usize,
            };
            grown_guides(&group, params.guides(), &growth, body)
        }
    };
    group.set_guides(&body.in_frames(&guides));
    Ok(group)
}

/// Returns the triangles that a group grows on, with their densities.
fn scalp(params: &HairGroupParams, ground: &GroomTarget<'_>) -> Result<Vec<(u32, u16)>, GroupError> {
    let (pattern, mask) = (params.material(), params.mask());
    let mut scalp = Vec::new();
    for part in parts_of(&pattern, ground).map_err(GroupError::Here)? {
        for triangle in part.first_triangle..part.first_triangle + part.triangle_count {
            let mut share = 0.0;
            for v in ground.mesh.triangles[triangle] {
                share += scalar_at(ground.files, ground.mesh, part, &mask, v as usize)?.unwrap_or(1.0) / 3.0;
            }
            if share >= MIN_DENSITY {
                scalp.push((triangle as u32, (share * 65535.0).round().clamp(1.0, 65535.0) as u16));
            }
        }
    }
    if scalp.is_empty() {
        let reason = format!("the mask excludes all triangles of {pattern:?}, expected some that are not black");
        return Err(GroupError::Here(reason));
    }
    Ok(scalp)
}

/// Returns the freedom of motion of each guide of a group, sampled at its root. The list is empty if all guides are
/// free.
fn freedom(params: &HairGroupParams, group: &HairGroup, ground: &GroomTarget<'_>) -> Result<Vec<u8>, BakeError> {
    let map = params.freedom();
    if map == ScalarMap::Constant(1.0) {
        return Ok(Vec::new());
    }
    let of_guide = |root: TrianglePoint| {
        let triangle = root.triangle as usize;
        let of_part =
            |part: &&MeshPart| (part.first_triangle..part.first_triangle + part.triangle_count).contains(&triangle);
        let Some(part) = ground.mesh.parts.iter().find(of_part) else { return Ok(u8::MAX) };
        let mut share = 0.0;
        for (v, weight) in ground.mesh.triangles[triangle].into_iter().zip(root.weights) {
            share += weight * scalar_at(ground.files, ground.mesh, part, &map, v as usize)?.unwrap_or(1.0);
        }
        Ok((share.clamp(0.0, 1.0) * 255.0).round() as u8)
    };
    group.roots().map(of_guide).collect()
}

/// Grows guides on a group's scalp, distributed like the group's hairs.
fn grown_guides(
    group: &HairGroup,
    count: u32,
    growth: &Growth,
    body: &SurfaceIndex<'_>,
) -> Vec<(TrianglePoint, Vec<Vec3>)> {
    let roots: Vec<TrianglePoint> = roots(group, count, &|triangle| body.corners(triangle));
    let grow = |(number, root): (usize, &TrianglePoint)| {
        let seed = u64::from(group.seed) << 32 | number as u64;
        (*root, growth.guide(body, root, seed))
    };
    roots.par_iter().enumerate().map(grow).collect()
}

/// Largest distance from a file's roots at which hair still grows, divided by the median distance between neighbouring
/// roots.
const MAX_SPACING_RATIO: f32 = 4.0;

/// Returns the triangles of a scalp that have guide roots on or near them. If a file has guides for one part only, no
/// hair grows on the rest.
fn scalp_near_guides(
    scalp: &[(u32, u16)],
    guides: &[(TrianglePoint, Vec<Vec3>)],
    body: &SurfaceIndex<'_>,
) -> Vec<(u32, u16)> {
    let roots: Vec<Vec3> = guides.iter().map(|(_, points)| points[0]).collect();
    let near = PointGrid::new(roots.clone());
    let mut apart: Vec<f32> = roots.iter().map(|root| near.nearest::<2>(*root)[1].0.sqrt()).collect();
    apart.sort_by(f32::total_cmp);
    let reach_m = MAX_SPACING_RATIO * apart.get(apart.len() / 2).copied().filter(|d| d.is_finite()).unwrap_or_default();
    let is_beside = |(triangle, _): &&(u32, u16)| {
        let corners = body.corners(*triangle);
        let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
        let across = corners.iter().map(|corner| corner.distance(middle)).fold(0.0, f32::max);
        near.nearest::<1>(middle)[0].0.sqrt() <= reach_m + across
    };
    let beside: Vec<(u32, u16)> = scalp.iter().filter(is_beside).copied().collect();
    // If no triangle is near a root, hair grows on the whole scalp: roots on large triangles can be far from the
    // triangles' centres.
    if beside.is_empty() { scalp.to_vec() } else { beside }
}
