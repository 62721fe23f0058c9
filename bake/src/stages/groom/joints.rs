//! Values for single joints: `[[groom.joint]]` of the recipe, spread over the skin by its weights.

use crate::recipe::JointGroom;
use pelage_formats::{Animation, SkinVertex};
use pelage_params::glob;

/// What the tables say about the skin that follows each joint.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JointValues {
    /// One per joint: what the nearest table up the skeleton says of each key; `name` is empty.
    joints: Vec<JointGroom>,
}

impl JointValues {
    /// Finds what holds for every joint: of each key what the last matching table for the joint itself says, or else what holds for the node that it
    /// hangs on.
    ///
    /// Tables that touch no joint are reported in `warnings`, with the names there are.
    pub fn new(tables: &[JointGroom], animation: Option<&Animation>, warnings: &mut Vec<String>) -> Self {
        let Some(animation) = animation.filter(|_| !tables.is_empty()) else {
            if !tables.is_empty() {
                warnings.push("groom.joint: the model has no skeleton, so that its tables have no effect".into());
            }
            return Self::default();
        };
        let mut nodes: Vec<JointGroom> = Vec::with_capacity(animation.nodes.len());
        // Which tables hold for each node.
        let mut holding: Vec<Vec<usize>> = Vec::with_capacity(animation.nodes.len());
        for node in &animation.nodes {
            let parent = node.parent.map(|parent| parent as usize);
            let mut values = parent.and_then(|p| nodes.get(p)).cloned().unwrap_or_default();
            let mut tables_here = parent.and_then(|p| holding.get(p)).cloned().unwrap_or_default();
            for (i, table) in tables.iter().enumerate().filter(|(_, table)| glob(&table.name, &node.name)) {
                values.length = table.length.or(values.length);
                values.density = table.density.or(values.density);
                values.lean = table.lean.or(values.lean);
                values.wetness = table.wetness.or(values.wetness);
                values.bare = table.bare.or(values.bare);
                tables_here.push(i);
            }
            nodes.push(values);
            holding.push(tables_here);
        }
        let of_joint = |joint: &pelage_formats::Joint| joint.node as usize;
        let holds =
            |i: usize| animation.joints.iter().any(|j| holding.get(of_joint(j)).is_some_and(|h| h.contains(&i)));
        for (_, table) in tables.iter().enumerate().filter(|(i, _)| !holds(*i)) {
            let names: Vec<_> = animation
                .joints
                .iter()
                .filter_map(|j| animation.nodes.get(of_joint(j)).map(|node| node.name.as_str()))
                .collect();
            warnings.push(format!("groom.joint: {:?} matches no joint; the model has {names:?}", table.name));
        }
        Self { joints: animation.joints.iter().map(|j| nodes.get(of_joint(j)).cloned().unwrap_or_default()).collect() }
    }

    /// Whether any joint has a value of that key.
    pub fn say(&self, key: fn(&JointGroom) -> Option<f32>) -> bool {
        self.joints.iter().any(|joint| key(joint).is_some())
    }

    /// The value at a vertex: the mean of those of its joints by their weights, `elsewhere` counting for joints without.
    pub fn mix(&self, skin: Option<&SkinVertex>, key: fn(&JointGroom) -> Option<f32>, elsewhere: f32) -> f32 {
        let Some(skin) = skin else { return elsewhere };
        // By the difference, so that where no joint has a value, the value elsewhere comes out to the last bit.
        let differences = skin.joints.iter().zip(skin.weights).filter_map(|(joint, weight)| {
            let value = self.joints.get(usize::from(*joint)).and_then(key)?;
            (weight > 0.0).then_some(weight * (value - elsewhere))
        });
        differences.fold(elsewhere, |sum, difference| sum + difference)
    }
}

#[cfg(test)]
#[path = "joints_tests.rs"]
mod tests;
