//! Nodes that are hidden at rest by their scale, and that a clip shows.

use glam::Vec3;
use pelage_formats::{Animation, Channel, Interpolation, Pose, Property};

/// Maximum share of a node's largest scale in the clips at which the node is hidden.
const HIDDEN: f32 = 0.02;

/// Sets the scales that hide a node to zero, if the node is hidden at rest and shown by a clip.
///
/// Exporters hide props by scales such as 0.001. At zero the hair disappears with the prop. A model that is small as a
/// whole at rest is not hidden, and is left unchanged.
pub(super) fn snap_hidden_scales(animation: &mut Animation) {
    let peaks = largest_scales(animation);
    let mut hidden: Vec<Option<Vec3>> = Vec::with_capacity(peaks.len());
    let (mut below, mut any_zero) = (Vec::with_capacity(peaks.len()), false);
    for (node, peak) in animation.nodes.iter().zip(peaks) {
        let peak = peak.filter(|peak| is_hidden(node.scale.into(), *peak));
        any_zero |= peak.is_some() && node.scale.contains(&0.0);
        // Parents precede their children.
        let parent = node.parent.and_then(|parent| below.get(parent as usize)).copied().unwrap_or(false);
        below.push(peak.is_some() || parent);
        hidden.push(peak);
    }
    let of_joint = |node: u32| below.get(node as usize).copied().unwrap_or(false);
    if !any_zero && animation.joints.iter().all(|joint| of_joint(joint.node)) {
        return;
    }
    let snap = |scale: &mut f32, largest: f32| {
        if scale.abs() <= HIDDEN * largest.abs() {
            *scale = 0.0;
        }
    };
    for (node, peak) in animation.nodes.iter_mut().zip(&hidden) {
        let Some(peak) = peak else { continue };
        node.scale.iter_mut().zip(peak.to_array()).for_each(|(scale, largest)| snap(scale, largest));
    }
    for channel in animation.clips.iter_mut().flat_map(|clip| &mut clip.channels) {
        let Some(Some(peak)) = hidden.get(channel.node as usize) else { continue };
        if channel.property == Property::Scale {
            for key in key_values(channel.interpolation, channel.values.len()) {
                let scale = channel.values.get_mut(key..key + 3).unwrap_or_default();
                scale.iter_mut().zip(peak.to_array()).for_each(|(scale, largest)| snap(scale, largest));
            }
        }
    }
}

/// Returns the pose at which areas and lengths are measured: the pose at rest, except that nodes hidden by a scale of
/// zero have the largest scale that they reach in any clip.
pub(crate) fn measured_pose(animation: &Animation) -> Pose {
    let mut pose = Pose::default();
    if animation.nodes.iter().all(|node| !node.scale.contains(&0.0)) {
        pose.sample(animation, None, 0.0);
        return pose;
    }
    let (nodes, joints) = (animation.nodes.clone(), animation.joints.clone());
    let mut shown = Animation { nodes, joints, ..Animation::default() };
    for (node, peak) in shown.nodes.iter_mut().zip(largest_scales(animation)) {
        if let Some(peak) = peak.filter(|peak| is_hidden(node.scale.into(), *peak)) {
            node.scale = peak.into();
        }
    }
    pose.sample(&shown, None, 0.0);
    pose
}

/// Whether a node is hidden along at least one axis on which a clip shows it.
fn is_hidden(scale: Vec3, largest: Vec3) -> bool {
    (scale.abs().cmple(HIDDEN * largest.abs()) & largest.cmpne(Vec3::ZERO)).any()
}

/// Returns the longest scale vector of each node over the keys of all clips; `None` for a node whose scale no clip
/// animates.
fn largest_scales(animation: &Animation) -> Vec<Option<Vec3>> {
    let mut largest: Vec<Option<Vec3>> = vec![None; animation.nodes.len()];
    let of_scale = |channel: &&Channel| channel.property == Property::Scale;
    for channel in animation.clips.iter().flat_map(|clip| &clip.channels).filter(of_scale) {
        let Some(known) = largest.get_mut(channel.node as usize) else { continue };
        for key in key_values(channel.interpolation, channel.values.len()) {
            let Some(scale) = channel.values.get(key..key + 3).map(Vec3::from_slice) else { continue };
            if known.is_none_or(|known| scale.length() > known.length()) {
                *known = Some(scale);
            }
        }
    }
    largest
}

/// Returns the index of the first component of each key's vector among `count` stored numbers.
fn key_values(interpolation: Interpolation, count: usize) -> impl Iterator<Item = usize> {
    let (first, step) = if interpolation == Interpolation::Cubic { (3, 9) } else { (0, 3) };
    (first..count).step_by(step)
}
