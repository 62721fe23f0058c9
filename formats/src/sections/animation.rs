//! The `ANIM` section: node tree, joints and clips. Fields are in byte order.

use super::kind::Kind;
use crate::encoding::{decode_section, encode_section};
use crate::error::FormatError;
use crate::package::Package;
use crate::tag::Tag;
use crate::writer::PackageWriter;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

impl Tag {
    /// Skeleton and clips: bincode of [`Animation`]. At most one.
    pub const ANIMATION: Self = Self(*b"ANIM");
}

pub(crate) const KIND: Kind =
    Kind::optional(Tag::ANIMATION, 1, "[skeleton and clips](#anim-skeleton-and-clips)", |package, _| {
        package.skeleton().map(drop)
    });

impl Package<'_> {
    /// Returns the contents of the section `ANIM`, without the animation of morph targets.
    pub(super) fn skeleton(&self) -> Result<Option<Arc<Animation>>, FormatError> {
        let Some((index, section)) = self.find(Tag::ANIMATION, 0) else { return Ok(None) };
        let kept = self.cached(index, || {
            section.check_length("animation length", self.limits().animation_bytes)?;
            let animation: Animation = decode_section(Tag::ANIMATION, section.offset, self.section_bytes(index)?)?;
            let fail = |reason| FormatError::Content { tag: Tag::ANIMATION, offset: section.offset, reason };
            animation.check().map_err(fail)?;
            Ok(Arc::new(animation))
        });
        kept.map(Some)
    }
}

impl PackageWriter<'_> {
    /// Adds skeleton and clips. The animation of morph targets is in a section of its own: [`PackageWriter::morphs`].
    pub fn animation(self, animation: &Animation) -> Self {
        self.encoded(Tag::ANIMATION, encode_section(Tag::ANIMATION, animation))
    }
}

/// Skeleton and clips of a model.
///
/// In a package with this section, every vertex is skinned to up to four joints. Rigid parts are included: they follow
/// their node.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Animation {
    /// Nodes, each after its parent.
    pub nodes: Vec<Node>,
    /// Joints; [`crate::SkinVertex::joints`] holds indices into this list.
    pub joints: Vec<Joint>,
    /// Named motions.
    pub clips: Vec<Clip>,
    /// Morph targets and the animation of their weights; from the section `MRPH`, not part of `ANIM`.
    #[serde(skip)]
    pub morphs: MorphMotion,
}

/// Node of the tree with its transform at rest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Node {
    /// Name in the model, may be empty.
    pub name: String,
    /// Index of the parent, less than the node's own index; `None` for roots.
    pub parent: Option<u32>,
    /// Translation, in the parent's units.
    pub translation: [f32; 3],
    /// Unit quaternion x, y, z, w.
    pub rotation: [f32; 4],
    /// Scale along the node's axes; zero and negative allowed.
    pub scale: [f32; 3],
}

/// Joint: a node, with the transform from the space of the stored vertices to the node's space.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Joint {
    /// Index into [`Animation::nodes`].
    pub node: u32,
    /// Transform from mesh space to node space at bind time, column-major.
    pub inverse_bind: [f32; 16],
}

/// Named motion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Clip {
    /// Name in the model, or `clip_<index>` if it has none.
    pub name: String,
    /// Time of the last key of all channels, seconds.
    pub duration_s: f32,
    /// Curves; a property without a curve keeps its value at rest.
    pub channels: Vec<Channel>,
}

/// Part of a node's transform that a channel drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Property {
    /// Translation, three numbers per key.
    Translation,
    /// Rotation, four numbers per key: quaternion x, y, z, w.
    Rotation,
    /// Scale, three numbers per key.
    Scale,
}

/// Morph targets and the animation of their weights.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MorphMotion {
    /// Targets; those of one node are consecutive.
    pub targets: Vec<MorphTarget>,
    /// Curves of weights; targets without a curve keep their weight at rest.
    pub channels: Vec<MorphChannel>,
}

/// Morph target.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MorphTarget {
    /// Name in the model, may be empty.
    pub name: String,
    /// Index into [`Animation::nodes`] of the node whose mesh has the target.
    pub node: u32,
    /// Weight at rest. The vertices of the package are stored with all targets at these weights.
    pub weight: f32,
}

/// Curve of the weights of consecutive targets.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MorphChannel {
    /// Index into [`Animation::clips`].
    pub clip: u32,
    /// Index of the first target whose weight the curve drives.
    pub target: u32,
    /// Number of targets whose weights the curve drives, at least one.
    pub count: u32,
    /// Interpolation between keys.
    pub interpolation: Interpolation,
    /// Key times, seconds, strictly increasing, at least one.
    pub times: Vec<f32>,
    /// `times.len() * count` weights; three times as many for [`Interpolation::Cubic`]. Each cubic key holds the
    /// in-tangents of all targets, then their values, then their out-tangents.
    pub values: Vec<f32>,
}

impl Property {
    /// Returns the number of components of a value.
    pub fn components(self) -> usize {
        match self {
            Self::Rotation => 4,
            Self::Translation | Self::Scale => 3,
        }
    }
}

/// Interpolation between keys, as in glTF 2.0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Interpolation {
    /// Value of the preceding key.
    Step,
    /// Linear; spherical for rotations.
    Linear,
    /// Cubic Hermite; each key holds in-tangent, value and out-tangent.
    Cubic,
}

impl Interpolation {
    pub(crate) fn values_per_key(self) -> usize {
        match self {
            Self::Cubic => 3,
            Self::Step | Self::Linear => 1,
        }
    }
}

/// Curve of one node's property.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Channel {
    /// Index into [`Animation::nodes`].
    pub node: u32,
    /// Property that the curve drives.
    pub property: Property,
    /// Interpolation between keys.
    pub interpolation: Interpolation,
    /// Key times, seconds, strictly increasing, at least one.
    pub times: Vec<f32>,
    /// `times.len() * property.components()` numbers, three times as many for [`Interpolation::Cubic`].
    pub values: Vec<f32>,
}

impl MorphChannel {
    /// Returns the required length of `values` for the number of keys; `None` if it is too large to represent.
    pub(crate) fn expected_values(&self) -> Option<usize> {
        let width = self.interpolation.values_per_key().checked_mul(self.count as usize)?;
        self.times.len().checked_mul(width)
    }

    pub(super) fn check(&self, animation: &Animation, targets: usize) -> Result<(), String> {
        let clips = animation.clips.len();
        if self.clip as usize >= clips {
            return Err(format!(".clip is {}, expected less than {clips}", self.clip));
        }
        let end = u64::from(self.target) + u64::from(self.count);
        if self.count == 0 || end > targets as u64 {
            let (first, count) = (self.target, self.count);
            return Err(format!(
                " animates {count} targets from {first} on, expected at least one, all among the \
                 {targets} targets"
            ));
        }
        check_keys(&self.times, &self.values, self.expected_values())
    }
}

impl Animation {
    /// Checks every index, count and number, so that [`crate::Pose`] can rely on them. Returns the path of the fault,
    /// what was found and what was expected.
    fn check(&self) -> Result<(), String> {
        let finite = |values: &[f32]| values.iter().all(|v| v.is_finite());
        for (i, node) in self.nodes.iter().enumerate() {
            if node.parent.is_some_and(|p| p as usize >= i) {
                return Err(format!("nodes[{i}].parent is {:?}, expected less than {i}", node.parent));
            }
            if !finite(&node.translation) || !finite(&node.rotation) || !finite(&node.scale) {
                return Err(format!("nodes[{i}] is {node:?}, expected finite numbers"));
            }
        }
        if self.joints.len() > 1 << 16 {
            return Err(format!("{} joints, expected at most 65536", self.joints.len()));
        }
        for (i, joint) in self.joints.iter().enumerate() {
            if joint.node as usize >= self.nodes.len() {
                let n = self.nodes.len();
                return Err(format!("joints[{i}].node is {}, expected less than {n}", joint.node));
            }
            if !finite(&joint.inverse_bind) {
                return Err(format!("joints[{i}].inverse_bind holds a number that is not finite"));
            }
        }
        for (i, clip) in self.clips.iter().enumerate() {
            if !clip.duration_s.is_finite() || clip.duration_s < 0.0 {
                return Err(format!("clips[{i}].duration_s is {}, expected >= 0", clip.duration_s));
            }
            for (k, channel) in clip.channels.iter().enumerate() {
                channel.check(self.nodes.len()).map_err(|e| format!("clips[{i}].channels[{k}]{e}"))?;
            }
        }
        Ok(())
    }
}

impl Channel {
    /// Returns the required length of `values` for the number of keys; `None` if there are no keys, or if it is too
    /// large to represent.
    pub(crate) fn expected_values(&self) -> Option<usize> {
        let keys = Some(self.times.len()).filter(|keys| *keys > 0)?;
        keys.checked_mul(self.property.components() * self.interpolation.values_per_key())
    }

    fn check(&self, nodes: usize) -> Result<(), String> {
        if self.node as usize >= nodes {
            return Err(format!(".node is {}, expected less than {nodes}", self.node));
        }
        check_keys(&self.times, &self.values, self.expected_values())
    }
}

/// Checks that a curve has ascending keys and `expected` finite numbers for them. Returns a description of the fault,
/// to be appended to the curve's path.
pub(super) fn check_keys(times: &[f32], values: &[f32], expected: Option<usize>) -> Result<(), String> {
    let expected = expected.unwrap_or(0);
    if times.is_empty() || values.len() != expected {
        let (k, v) = (times.len(), values.len());
        return Err(format!(" has {k} keys and {v} numbers, expected at least one key and {expected} numbers"));
    }
    for (what, numbers) in [("times", times), ("values", values)] {
        if let Some(k) = numbers.iter().position(|v| !v.is_finite()) {
            return Err(format!(".{what}[{k}] is {}, expected a finite number", numbers[k]));
        }
    }
    match times.windows(2).position(|w| w[0] >= w[1]) {
        Some(k) => {
            let (a, b) = (times[k], times[k + 1]);
            Err(format!(".times[{}] is {b}, expected more than the previous key, {a}", k + 1))
        }
        None => Ok(()),
    }
}
