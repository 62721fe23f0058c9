//! Values for single joints (`[[groom.joint]]` in the recipe), spread over the mesh by its skinning weights.

use crate::recipe::JointGroom;
use pelage_formats::{Animation, SkinVertex};
use pelage_params::glob;

/// Groom values from the tables for joints. They apply to the surface that follows each joint.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JointValues {
    /// Values of each joint. For each key, the value is that of the joint itself, or of the nearest ancestor for which
    /// a table sets the key. The field `name` is empty.
    joints: Vec<JointGroom>,
}

impl JointValues {
    /// Resolves the values of every joint. For each key, the last table that matches the joint applies. If no such
    /// table has the key, the joint inherits the value of its parent node.
    ///
    /// Tables that match no joint are reported in `warnings`, with the names of the existing joints.
    pub fn new(tables: &[JointGroom], animation: Option<&Animation>, warnings: &mut Vec<String>) -> Self {
        let Some(animation) = animation.filter(|_| !tables.is_empty()) else {
            if !tables.is_empty() {
                warnings.push("groom.joint: the model has no skeleton, so its tables have no effect".into());
            }
            return Self::default();
        };
        let mut nodes: Vec<JointGroom> = Vec::with_capacity(animation.nodes.len());
        // Indices of the tables that match each node.
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

    /// Whether any joint has a value for that key.
    pub fn has_key(&self, key: fn(&JointGroom) -> Option<f32>) -> bool {
        self.joints.iter().any(|joint| key(joint).is_some())
    }

    /// Returns the mean over the joints of a vertex by their weights. Joints without a value count as `elsewhere`.
    pub fn blend(&self, skin: Option<&SkinVertex>, key: fn(&JointGroom) -> Option<f32>, elsewhere: f32) -> f32 {
        let Some(skin) = skin else { return elsewhere };
        // Add weighted differences, so that without any joint value the result is exactly `elsewhere`.
        let differences = skin.joints.iter().zip(skin.weights).filter_map(|(joint, weight)| {
            let value = self.joints.get(usize::from(*joint)).and_then(key)?;
            (weight > 0.0).then_some(weight * (value - elsewhere))
        });
        let sum = differences.fold(elsewhere, |sum, difference| sum + difference);
        // Rounding must not lead out of the range of the joints' values: a length just below 0 is invalid.
        let values = || skin.joints.iter().filter_map(|joint| self.joints.get(usize::from(*joint)).and_then(key));
        sum.clamp(values().fold(elsewhere, f32::min), values().fold(elsewhere, f32::max))
    }
}

#[cfg(test)]
#[path = "joints_tests.rs"]
mod tests;
