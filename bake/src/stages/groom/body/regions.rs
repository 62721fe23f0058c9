//! Assignment of joints to body parts.

use super::parts::Region;
use super::words::{number, region, words};
use pelage_formats::Animation;

/// Returns the body part that each node moves, according to the node's own name or else its parent's part.
pub(super) fn of_nodes(animation: &Animation) -> Vec<Region> {
    let named: Vec<Option<Region>> = animation.nodes.iter().map(|node| region(&node.name)).collect();
    let spine: Vec<Option<u32>> = animation.nodes.iter().map(|node| number_in_spine(&node.name)).collect();
    // In Rigify, the numbers of a human spine extend to the head: 4 and 5 are the neck, 6 is the head.
    let is_numbered = spine.iter().flatten().max() == Some(&6)
        && !named.iter().flatten().any(|r| matches!(r, Region::Head | Region::Neck));
    let mut regions: Vec<Region> = Vec::with_capacity(animation.nodes.len());
    for ((node, named), spine) in animation.nodes.iter().zip(named).zip(spine) {
        let parent = node.parent.and_then(|p| regions.get(p as usize)).copied().unwrap_or(Region::Unknown);
        regions.push(match (named, spine.filter(|_| is_numbered)) {
            (_, Some(4 | 5)) => Region::Neck,
            (_, Some(6)) => Region::Head,
            // A limb below an upper or lower leg is a lower leg: "LeftUpLeg" has the child "LeftLeg", and "leg01" has
            // the child "leg02".
            (Some(Region::Limb), _) if matches!(parent, Region::UpperLeg | Region::LowerLeg) => Region::LowerLeg,
            (Some(Region::Limb), _) => Region::UpperLeg,
            (Some(found), _) => found,
            (None, _) => parent,
        });
    }
    regions
}

/// Returns the number of a spine joint; `None` for other joints.
fn number_in_spine(name: &str) -> Option<u32> {
    words(name).iter().any(|word| word == "spine").then(|| number(name)).flatten()
}
