//! Lines and empty nodes in a model that define the comb direction of its hair.
//!
//! In Blender these are curves converted to meshes, or empties displayed as single arrows. Blender's exporter turns
//! local z, along which the arrow points, into the node's y; an empty node therefore points along its own +y.

use super::elements::REAL;
use super::json::JsonNode;
use super::lines::strands_of;
use super::memory::MeshMemory;
use super::primitive::{are_lines, indices_of, vectors};
use super::scene::Tree;
use super::skin::Joints;
use super::source::Source;
use super::weights;
use crate::BakeError;
use crate::mesh::CombLine;
use glam::{Mat4, Vec3};

/// Prefix of the names of nodes and meshes that define the comb direction. Case is ignored.
const COMB: &str = "comb";

/// Returns whether a node or mesh with this name defines the comb direction by its lines.
pub(super) fn is_comb_name(name: &str) -> bool {
    name.get(..COMB.len()).is_some_and(|begin| begin.eq_ignore_ascii_case(COMB))
}

/// Returns whether an empty node with this name defines the comb direction. Stricter than `is_comb_name`, because the
/// name of a joint in a cock's comb may begin with the same word.
fn is_comb_marker_name(name: &str) -> bool {
    is_comb_name(name) && name.chars().nth(COMB.len()).is_none_or(|next| matches!(next, '_' | '.' | '-' | ' '))
}

/// Reads the comb lines and empty comb nodes of a document, in world space at rest.
///
/// * `world`: transforms of all nodes at rest
pub(super) fn read_comb_lines<'a>(
    source: &mut Source<'a, '_>,
    memory: &mut MeshMemory,
    tree: &Tree<'a>,
    world: &[Mat4],
    root: Mat4,
    joints: &mut Joints,
) -> Result<Vec<CombLine>, BakeError> {
    let mut found = Vec::new();
    if tree.nodes.is_empty() {
        // In a document without nodes every mesh is shown without a transform, as in the rest of the import.
        let meshes = source.root.get("meshes").map(|meshes| meshes.entries()).transpose()?;
        for mesh in meshes.into_iter().flatten().filter(|mesh| is_comb_name(mesh.name())) {
            let place = |_: usize, p: Vec3| Some(root.transform_point3(p));
            for at in line_primitives(&mesh)? {
                read_lines(source, memory, &at, mesh.name(), &mut found, place)?;
            }
        }
        return Ok(found);
    }
    let are_joints = joint_nodes(source, tree);
    for node in tree.shown() {
        let at = &tree.nodes[node].at;
        let Some(reference) = at.get("mesh") else {
            if is_comb_marker_name(at.name()) && !are_joints[node] && at.get("camera").is_none() {
                read_empty(source, at, world[node], &mut found);
            }
            continue;
        };
        // The import of meshes warns of references to no mesh.
        let Ok((_, mesh)) = source.root.follow("meshes", &reference) else { continue };
        let Some(name) = [at.name(), mesh.name()].into_iter().find(|name| is_comb_name(name)) else { continue };
        let skin = at.get("skin").map(|reference| joints.skin(source, &reference)).transpose()?;
        for at in line_primitives(&mesh)? {
            let bound = match skin {
                Some(skin) => rest_matrices(source, &at, name, world, &joints.binds(skin))?,
                None => None,
            };
            let place = |v: usize, p: Vec3| match &bound {
                Some(matrices) => matrices.get(v).map(|matrix| matrix.transform_point3(p)),
                None => Some(world[node].transform_point3(p)),
            };
            read_lines(source, memory, &at, name, &mut found, place)?;
        }
    }
    Ok(found)
}

/// Returns for each node whether it is a joint of a skin. Faults are ignored, because the skin may be unused.
fn joint_nodes<'a>(source: &Source<'a, '_>, tree: &Tree<'a>) -> Vec<bool> {
    let mut are = vec![false; tree.nodes.len()];
    let skins = source.root.get("skins").and_then(|skins| skins.entries().ok());
    let joints = skins.into_iter().flatten().filter_map(|skin| skin.get("joints")?.entries().ok());
    for (joint, _) in joints.flatten().filter_map(|reference| source.root.follow("nodes", &reference).ok()) {
        are[joint] = true;
    }
    are
}

fn read_empty(source: &mut Source<'_, '_>, at: &JsonNode<'_>, world: Mat4, found: &mut Vec<CombLine>) {
    let (place, direction) = (world.w_axis.truncate(), world.y_axis.truncate());
    match direction.try_normalize().filter(|_| place.is_finite()) {
        Some(direction) => found.push(CombLine { name: at.name().to_owned(), places: vec![(place, direction)] }),
        None => source.warn(format!("{}: {:?} has no direction; left out of the comb", at.place, at.name())),
    }
}

/// Returns the primitives of a mesh that hold lines and have positions.
fn line_primitives<'a>(mesh: &JsonNode<'a>) -> Result<Vec<JsonNode<'a>>, BakeError> {
    let mut found = Vec::new();
    for at in mesh.require("primitives")?.entries()? {
        let has_places = at.get("attributes").is_some_and(|attributes| attributes.get("POSITION").is_some());
        if are_lines(at.unsigned_or("mode", 4)?) && has_places {
            found.push(at);
        }
    }
    Ok(found)
}

/// Reads the lines of a primitive; `place` maps a vertex (index, position) to world space.
fn read_lines<'a>(
    source: &mut Source<'a, '_>,
    memory: &mut MeshMemory,
    at: &JsonNode<'a>,
    name: &str,
    found: &mut Vec<CombLine>,
    place: impl Fn(usize, Vec3) -> Option<Vec3>,
) -> Result<(), BakeError> {
    let position = at.require("attributes")?.require("POSITION")?;
    memory.count_primitive(source, at, false)?;
    let own = vectors(&source.accessor(&position, &[3], REAL)?.to_f32s(false));
    let placed: Vec<Vec3> = own.iter().enumerate().map(|(v, p)| place(v, *p).unwrap_or(Vec3::NAN)).collect();
    if let Some(v) = placed.iter().position(|p| !p.is_finite()) {
        let reason = format!("element {v} is {}, which is {} in the scene, expected finite numbers", own[v], placed[v]);
        return Err(position.fault(reason));
    }
    let indices = indices_of(source, at, own.len())?;
    for strand in strands_of(at, at.unsigned_or("mode", 4)?, &indices, &own)? {
        let mut points: Vec<Vec3> = strand.iter().map(|v| placed[*v as usize]).collect();
        points.dedup();
        match with_directions(&points) {
            Some(places) => found.push(CombLine { name: name.to_owned(), places }),
            None => source.warn(format!("{}: a line of {name:?} has no length; left out of the comb", at.place)),
        }
    }
    Ok(())
}

/// Returns the points with the direction of the line at each, from first to last. `None` if the line has no length.
fn with_directions(points: &[Vec3]) -> Option<Vec<(Vec3, Vec3)>> {
    let last = points.len().checked_sub(1).filter(|last| *last > 0)?;
    let mut directions = (0..=last).map(|i| (points[(i + 1).min(last)] - points[i.saturating_sub(1)]).try_normalize());
    let first = directions.clone().flatten().next()?;
    // If the points before and after a point coincide, the line doubles back. The direction of the previous point is
    // used.
    let mut before = first;
    let directions: Vec<Vec3> = directions
        .by_ref()
        .map(|direction| {
            before = direction.unwrap_or(before);
            before
        })
        .collect();
    Some(points.iter().copied().zip(directions).collect())
}

/// Returns for each vertex of a primitive the blended matrix of its joints at rest. `None` if the primitive has no
/// joints and follows its node.
fn rest_matrices<'a>(
    source: &mut Source<'a, '_>,
    at: &JsonNode<'a>,
    name: &str,
    world: &[Mat4],
    binds: &[(usize, [f32; 16])],
) -> Result<Option<Vec<Mat4>>, BakeError> {
    let attributes = at.require("attributes")?;
    let count = source.accessor_count(&attributes.require("POSITION")?)? as usize;
    let Some(influences) = weights::read(source, &attributes, name, count)? else { return Ok(None) };
    let mut matrices = Vec::with_capacity(influences.len());
    for (vertex, (joints, weights)) in influences.iter().enumerate() {
        let mut sum = Mat4::ZERO;
        for (joint, weight) in joints.iter().zip(weights).filter(|(_, weight)| **weight > 0.0) {
            let Some((node, bind)) = binds.get(*joint as usize) else {
                let found = format!("vertex {vertex} follows joint {joint}, expected less than {}", binds.len());
                return Err(at.fault(format!("{found}, the joint count of its skin")));
            };
            sum += world[*node] * Mat4::from_cols_array(bind) * *weight;
        }
        matrices.push(sum);
    }
    Ok(Some(matrices))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comb_lines_and_markers_are_recognised_by_name() {
        for (name, lines, empty) in [
            ("comb_neck", true, true),
            ("Comb", true, true),
            ("COMB.001", true, true),
            ("Combed", true, false),
            ("comb1", true, false),
            ("com", false, false),
            ("honeycomb_x", false, false),
            ("kömb", false, false),
        ] {
            assert_eq!((is_comb_name(name), is_comb_marker_name(name)), (lines, empty), "{name}");
        }
    }

    #[test]
    fn directions_run_from_the_first_point_to_the_last() {
        let places = with_directions(&[Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0)]).unwrap_or_default();
        let corner = Vec3::new(1.0, 1.0, 0.0).normalize();
        let found: Vec<Vec3> = places.iter().map(|(_, direction)| *direction).collect();
        assert_eq!(found, [Vec3::X, corner, Vec3::Y]);
        assert_eq!((with_directions(&[Vec3::X]), with_directions(&[])), (None, None));
        let back = with_directions(&[Vec3::ZERO, Vec3::X, Vec3::ZERO]).unwrap_or_default();
        assert!(back.iter().all(|(_, direction)| direction.is_normalized()), "{back:?}");
    }
}
