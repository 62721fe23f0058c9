//! Lines and empty nodes that somebody drew into a model to say how its hair is combed.
//!
//! In Blender that is a curve made a mesh, or an empty with a single arrow. Its exporter turns local z, along which the arrow points, into y of the
//! node; so an empty node points along its own +y.

use super::elements::REAL;
use super::json::At;
use super::lines::{Counted, strands_of};
use super::primitive::{are_lines, indices_of, vectors};
use super::scene::Tree;
use super::skin::Joints;
use super::source::Source;
use super::weights;
use crate::BakeError;
use crate::mesh::DrawnComb;
use glam::{Mat4, Vec3};

/// What names of such nodes and meshes begin with, in any case.
const COMB: &str = "comb";

/// Whether lines of a node or mesh of that name say how hair is combed.
pub(super) fn combs(name: &str) -> bool {
    name.get(..COMB.len()).is_some_and(|begin| begin.eq_ignore_ascii_case(COMB))
}

/// Whether an empty node of that name does: what a joint of a cock's comb may be called does not.
fn points(name: &str) -> bool {
    combs(name) && name.chars().nth(COMB.len()).is_none_or(|next| matches!(next, '_' | '.' | '-' | ' '))
}

/// Reads them, in world space at rest.
///
/// * `world`: transforms of all nodes at rest
pub(super) fn drawn<'a>(
    source: &mut Source<'a, '_>,
    tree: &Tree<'a>,
    world: &[Mat4],
    root: Mat4,
    joints: &mut Joints,
) -> Result<Vec<DrawnComb>, BakeError> {
    let mut found = Vec::new();
    let mut counted = Counted::default();
    if tree.nodes.is_empty() {
        // As the rest of such a file: all meshes where they are.
        let meshes = source.root.get("meshes").map(|meshes| meshes.entries()).transpose()?;
        for mesh in meshes.into_iter().flatten().filter(|mesh| combs(mesh.name())) {
            let place = |_: usize, p: Vec3| Some(root.transform_point3(p));
            for at in line_primitives(&mesh)? {
                read_lines(source, &mut counted, &at, mesh.name(), &mut found, place)?;
            }
        }
        return Ok(found);
    }
    let are_joints = joint_nodes(source, tree)?;
    for node in tree.shown() {
        let at = &tree.nodes[node].at;
        let Some(reference) = at.get("mesh") else {
            if points(at.name()) && !are_joints[node] && at.get("camera").is_none() {
                read_empty(source, at, world[node], &mut found);
            }
            continue;
        };
        let (_, mesh) = source.root.referred("meshes", &reference)?;
        let Some(name) = [at.name(), mesh.name()].into_iter().find(|name| combs(name)) else { continue };
        let skin = at.get("skin").map(|reference| joints.skin(source, &reference)).transpose()?;
        for at in line_primitives(&mesh)? {
            let bound = match skin {
                Some(skin) => skinned(source, &at, name, world, &joints.binds(skin))?,
                None => None,
            };
            let place = |v: usize, p: Vec3| match &bound {
                Some(matrices) => matrices.get(v).map(|matrix| matrix.transform_point3(p)),
                None => Some(world[node].transform_point3(p)),
            };
            read_lines(source, &mut counted, &at, name, &mut found, place)?;
        }
    }
    Ok(found)
}

/// One per node: whether it is a joint of a skin.
fn joint_nodes<'a>(source: &Source<'a, '_>, tree: &Tree<'a>) -> Result<Vec<bool>, BakeError> {
    let mut are = vec![false; tree.nodes.len()];
    let Some(skins) = source.root.get("skins") else { return Ok(are) };
    for skin in skins.entries()? {
        let Some(joints) = skin.get("joints") else { continue };
        for reference in joints.entries()? {
            are[source.root.referred("nodes", &reference)?.0] = true;
        }
    }
    Ok(are)
}

fn read_empty(source: &mut Source<'_, '_>, at: &At<'_>, world: Mat4, found: &mut Vec<DrawnComb>) {
    let (place, direction) = (world.w_axis.truncate(), world.y_axis.truncate());
    match direction.try_normalize().filter(|_| place.is_finite()) {
        Some(direction) => found.push(DrawnComb { name: at.name().to_owned(), places: vec![(place, direction)] }),
        None => source.warn(format!("{}: {:?} points nowhere; left out of the comb", at.place, at.name())),
    }
}

/// The primitives of a mesh that hold lines and have places.
fn line_primitives<'a>(mesh: &At<'a>) -> Result<Vec<At<'a>>, BakeError> {
    let mut found = Vec::new();
    for at in mesh.require("primitives")?.entries()? {
        let has_places = at.get("attributes").is_some_and(|attributes| attributes.get("POSITION").is_some());
        if are_lines(at.unsigned_or("mode", 4)?) && has_places {
            found.push(at);
        }
    }
    Ok(found)
}

/// Reads the lines of a primitive; `place` puts a vertex, by its number and its position, into the world.
fn read_lines<'a>(
    source: &mut Source<'a, '_>,
    counted: &mut Counted,
    at: &At<'a>,
    name: &str,
    found: &mut Vec<DrawnComb>,
    place: impl Fn(usize, Vec3) -> Option<Vec3>,
) -> Result<(), BakeError> {
    let position = at.require("attributes")?.require("POSITION")?;
    counted.charge(source, at, &position)?;
    let own = vectors(&source.accessor(&position, &[3], REAL)?.reals(false));
    let placed: Vec<Vec3> = own.iter().enumerate().map(|(v, p)| place(v, *p).unwrap_or(Vec3::NAN)).collect();
    if let Some(v) = placed.iter().position(|p| !p.is_finite()) {
        let reason = format!("element {v} is {}, {} in the scene, expected finite numbers", own[v], placed[v]);
        return Err(position.fault(reason));
    }
    let indices = indices_of(source, at, own.len())?;
    for strand in strands_of(at, at.unsigned_or("mode", 4)?, &indices, &own)? {
        let mut points: Vec<Vec3> = strand.iter().map(|v| placed[*v as usize]).collect();
        points.dedup();
        match along(&points) {
            Some(places) => found.push(DrawnComb { name: name.to_owned(), places }),
            None => source.warn(format!("{}: a line of {name:?} has no length; left out of the comb", at.place)),
        }
    }
    Ok(())
}

/// Points with the direction of the line at each, from its first point to its last; `None` where it has none.
fn along(points: &[Vec3]) -> Option<Vec<(Vec3, Vec3)>> {
    let last = points.len().checked_sub(1).filter(|last| *last > 0)?;
    let mut directions = (0..=last).map(|i| (points[(i + 1).min(last)] - points[i.saturating_sub(1)]).try_normalize());
    let first = directions.clone().flatten().next()?;
    // Where a line turns back on itself it goes on as it went.
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

/// For each vertex of a primitive the matrix that its joints move it by at rest; `None` where it has no joints and follows its node.
fn skinned<'a>(
    source: &mut Source<'a, '_>,
    at: &At<'a>,
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
                return Err(at.fault(format!("{found}, the joints of its skin")));
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
    fn names_that_comb() {
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
            assert_eq!((combs(name), points(name)), (lines, empty), "{name}");
        }
    }

    #[test]
    fn directions_run_from_the_first_point_to_the_last() {
        let places = along(&[Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0)]).unwrap_or_default();
        let corner = Vec3::new(1.0, 1.0, 0.0).normalize();
        let found: Vec<Vec3> = places.iter().map(|(_, direction)| *direction).collect();
        assert_eq!(found, [Vec3::X, corner, Vec3::Y]);
        assert_eq!((along(&[Vec3::X]), along(&[])), (None, None));
        let back = along(&[Vec3::ZERO, Vec3::X, Vec3::ZERO]).unwrap_or_default();
        assert!(back.iter().all(|(_, direction)| direction.is_normalized()), "{back:?}");
    }
}
