//! Nodes that are hidden at rest by their scale, and that a clip shows.

use pelage_formats::meaning::{HIDDEN_SIZE, hidden_scales, key_values};
use pelage_formats::{Animation, Property};

/// Sets the scales that hide a node to zero, if the node is hidden at rest and shown by a clip.
///
/// Exporters hide props by scales such as 0.001. At zero the hair disappears with the prop. A model that is small as a
/// whole at rest is not hidden, and is left unchanged.
pub(super) fn snap_hidden_scales(animation: &mut Animation) {
    let hidden = hidden_scales(animation);
    let (mut below, mut any_zero) = (Vec::with_capacity(hidden.len()), false);
    for (node, peak) in animation.nodes.iter().zip(&hidden) {
        any_zero |= peak.is_some() && node.scale.contains(&0.0);
        // Parents precede their children.
        let parent = node.parent.and_then(|parent| below.get(parent as usize)).copied().unwrap_or(false);
        below.push(peak.is_some() || parent);
    }
    let of_joint = |node: u32| below.get(node as usize).copied().unwrap_or(false);
    if !any_zero && animation.joints.iter().all(|joint| of_joint(joint.node)) {
        return;
    }
    let snap = |scale: &mut f32, largest: f32| {
        if scale.abs() <= HIDDEN_SIZE * largest.abs() {
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
            for key in key_values(channel.interpolation, 3, channel.values.len()) {
                let scale = channel.values.get_mut(key..key + 3).unwrap_or_default();
                scale.iter_mut().zip(peak.to_array()).for_each(|(scale, largest)| snap(scale, largest));
            }
        }
    }
}
