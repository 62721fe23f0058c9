//! Shape in which areas and lengths of hair are measured: the shape at rest, except that surface which is hidden at
//! rest is measured where a clip shows it.

use super::skinning::{HIDDEN_SIZE, morphed, posed, skin_matrix};
use crate::error::FormatError;
use crate::package::Package;
use crate::sampling::Pose;
use crate::sections::animation::{Animation, Interpolation, Property};
use crate::sections::mesh::{GeometryVertex, MeshView};
use crate::sections::morphs::MorphDelta;
use glam::Vec3;

/// Returns the pose at which areas and lengths are measured. Joints are at rest, except that nodes hidden by a scale of
/// zero have the largest scale that they reach in any clip.
pub fn measured_pose(animation: &Animation) -> Pose {
    let mut pose = Pose::default();
    if animation.nodes.iter().all(|node| !node.scale.contains(&0.0)) {
        pose.sample(animation, None, 0.0);
        return pose;
    }
    let (nodes, joints) = (animation.nodes.clone(), animation.joints.clone());
    let mut shown = Animation { nodes, joints, ..Animation::default() };
    for (node, largest) in shown.nodes.iter_mut().zip(hidden_scales(animation)) {
        node.scale = largest.map_or(node.scale, Vec3::into);
    }
    pose.sample(&shown, None, 0.0);
    pose
}

/// Returns a stored vertex as a morph target shows it, if it is hidden at rest. Other vertices are unchanged.
///
/// The tangent of a hidden vertex is zero. The targets that show it restore the tangent, and the first of them gives
/// the shape. `shifts` come from [`largest_shifts`].
pub fn shown(vertex: &GeometryVertex, deltas: &[MorphDelta], shifts: &[f32]) -> GeometryVertex {
    let is_hidden = vertex.tangent[..3] == [0.0; 3];
    match deltas.iter().find(|delta| is_hidden && delta.tangent != [0.0; 3]) {
        Some(delta) => morphed(vertex, std::slice::from_ref(delta), shifts),
        None => *vertex,
    }
}

/// Returns the largest scale in the clips of each node that is hidden at rest along at least one axis on which a clip
/// shows it; `None` for the other nodes.
pub fn hidden_scales(animation: &Animation) -> Vec<Option<Vec3>> {
    let mut largest: Vec<Option<Vec3>> = vec![None; animation.nodes.len()];
    for channel in animation.clips.iter().flat_map(|clip| &clip.channels) {
        let Some(known) = largest.get_mut(channel.node as usize) else { continue };
        for key in key_values(channel.interpolation, 3, channel.values.len()) {
            let of_scale = channel.values.get(key..key + 3).filter(|_| channel.property == Property::Scale);
            let Some(scale) = of_scale.map(Vec3::from_slice) else { continue };
            if known.is_none_or(|known| scale.length() > known.length()) {
                *known = Some(scale);
            }
        }
    }
    let is_hidden =
        |scale: Vec3, largest: Vec3| (scale.abs().cmple(HIDDEN_SIZE * largest.abs()) & largest.cmpne(Vec3::ZERO)).any();
    let of_nodes = animation.nodes.iter().zip(largest);
    of_nodes.map(|(node, largest)| largest.filter(|largest| is_hidden(node.scale.into(), *largest))).collect()
}

/// Returns the difference of each target's weight from its value at rest, at the key of any clip where it is largest; 0
/// for targets that no clip animates.
pub fn largest_shifts(animation: &Animation) -> Vec<f32> {
    let targets = &animation.morphs.targets;
    let mut largest = vec![0.0_f32; targets.len()];
    for channel in &animation.morphs.channels {
        let count = channel.count as usize;
        for key in key_values(channel.interpolation, count, channel.values.len()) {
            let of_targets = largest.iter_mut().zip(targets).skip(channel.target as usize).take(count);
            for ((largest, target), weight) in of_targets.zip(channel.values.iter().skip(key)) {
                let shift = weight - target.weight;
                if shift.is_finite() && shift.abs() > largest.abs() {
                    *largest = shift;
                }
            }
        }
    }
    largest
}

/// Returns the index of the first number of each key's value among `stored` numbers. A value has `width` numbers.
pub fn key_values(interpolation: Interpolation, width: usize, stored: usize) -> impl Iterator<Item = usize> {
    let first = if interpolation == Interpolation::Cubic { width } else { 0 };
    (first..stored).step_by((interpolation.values_per_key() * width).max(1))
}

/// Returns the stored vertices of a package; vertices that are hidden at rest are [`shown`].
///
/// Fails with [`FormatError`] for a damaged section.
pub fn shown_vertices(package: &Package<'_>, mesh: &MeshView<'_>) -> Result<Vec<GeometryVertex>, FormatError> {
    let Some((morphs, animation)) = package.morphs()?.zip(package.animation()?) else {
        return Ok(mesh.geometry().collect());
    };
    let shifts = largest_shifts(&animation);
    Ok(mesh.geometry().enumerate().map(|(i, vertex)| shown(&vertex, morphs.of_vertex(i), &shifts)).collect())
}

/// Returns the vertices of a package in the pose at which areas and lengths are measured ([`measured_pose`]).
///
/// Fails with [`FormatError`] for a damaged section.
pub fn measured_vertices(package: &Package<'_>, mesh: &MeshView<'_>) -> Result<Vec<GeometryVertex>, FormatError> {
    let pose = package.animation()?.map(|animation| measured_pose(&animation)).unwrap_or_default();
    let mut vertices = shown_vertices(package, mesh)?;
    vertices.iter_mut().zip(mesh.skin()).for_each(|(vertex, skin)| *vertex = posed(vertex, skin_matrix(&pose, &skin)));
    Ok(vertices)
}
