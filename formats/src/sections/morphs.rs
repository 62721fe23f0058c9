//! The `MRPH` section: morph targets, the animation of their weights, and the displacement of each vertex. Fields are
//! in byte order. Layout in `FORMAT.md`, "MRPH".

use super::animation::{Animation, MorphMotion};
use super::kind::Kind;
use crate::encoding::{decode_section, encode_section};
use crate::error::FormatError;
use crate::package::Package;
use crate::tag::Tag;
use crate::writer::PackageWriter;
use bytemuck::{Pod, Zeroable};
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::sync::Arc;

impl Tag {
    /// Morph targets, since version 3: bincode of [`Morphs`]. At most one.
    pub const MORPHS: Self = Self(*b"MRPH");
}

pub(crate) const KIND: Kind =
    Kind::optional(Tag::MORPHS, 3, "[morph targets](#mrph-morph-targets)", |package, _| package.morphs().map(drop));

/// Maximum number of targets in a package.
const MOST_TARGETS: usize = 1 << 12;

/// Targets of the section, and the skeleton with their animation.
type MorphedAnimation = (Arc<Morphs>, Arc<Animation>);

impl Package<'_> {
    /// Returns the morph targets; `None` if the package has none. They are decoded and checked once, then cached.
    ///
    /// Fails if the section is damaged, or is inconsistent with mesh or skeleton.
    pub fn morphs(&self) -> Result<Option<Arc<Morphs>>, FormatError> {
        Ok(self.morphed_animation()?.map(|(morphs, _)| morphs))
    }

    /// Returns skeleton and clips, including the animation of morph targets; `None` if the package has none. They are
    /// decoded and checked once, then cached.
    pub fn animation(&self) -> Result<Option<Arc<Animation>>, FormatError> {
        match self.morphed_animation()? {
            Some((_, animation)) => Ok(Some(animation)),
            None => self.skeleton(),
        }
    }

    fn morphed_animation(&self) -> Result<Option<MorphedAnimation>, FormatError> {
        let Some((index, section)) = self.find(Tag::MORPHS, 0) else { return Ok(None) };
        let kept = self.cached(index, || {
            section.check_length("morph targets length", self.limits().animation_bytes)?;
            let morphs: Morphs = decode_section(Tag::MORPHS, section.offset, self.section_bytes(index)?)?;
            let fail = |reason| FormatError::Content { tag: Tag::MORPHS, offset: section.offset, reason };
            let skeleton =
                self.skeleton()?.ok_or_else(|| fail("morph targets without a skeleton, expected one".into()))?;
            let vertices = self.mesh()?.map_or(0, |mesh| mesh.vertex_count);
            morphs.check(&skeleton, vertices as usize).map_err(fail)?;
            let animation = Animation { morphs: morphs.motion.clone(), ..(*skeleton).clone() };
            Ok((Arc::new(morphs), Arc::new(animation)))
        })?;
        Ok(Some(kept))
    }
}

impl PackageWriter<'_> {
    /// Adds morph targets.
    pub fn morphs(self, morphs: &Morphs) -> Self {
        self.encoded(Tag::MORPHS, encode_section(Tag::MORPHS, morphs))
    }
}

/// Morph targets: shapes into which the mesh is deformed, each by its weight.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Morphs {
    /// Targets, and their animation in clips.
    pub motion: MorphMotion,
    /// For each vertex, the index of its first entry in `deltas`. The entries of a vertex end where those of the next
    /// begin, so one element follows the last vertex: the number of entries. Ascending from 0.
    pub first: Vec<u32>,
    /// Displacements by targets, in the order of the vertices.
    pub deltas: Vec<MorphDelta>,
}

/// Displacement of a vertex when the weight of a target rises from 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable, Serialize, Deserialize)]
#[repr(C)]
pub struct MorphDelta {
    /// Index into [`MorphMotion::targets`].
    pub target: u32,
    /// Displacement of the position, in mesh space.
    pub position: [f32; 3],
    /// Offset that is added to the normal, which is then normalised.
    pub normal: [f32; 3],
    /// Offset that is added to the direction of the tile's u axis, which is then made unit length and perpendicular to
    /// the normal.
    pub tangent: [f32; 3],
}

impl Morphs {
    /// Returns the entries of a vertex; none for a vertex that does not exist.
    pub fn of_vertex(&self, vertex: usize) -> &[MorphDelta] {
        let at = |i: usize| self.first.get(i).map(|n| *n as usize);
        let range = at(vertex).zip(at(vertex + 1)).and_then(|(from, to)| self.deltas.get::<Range<usize>>(from..to));
        range.unwrap_or_default()
    }

    /// Checks every index, count and number. Returns the path of the fault, what was found and what was expected.
    fn check(&self, animation: &Animation, vertices: usize) -> Result<(), String> {
        let targets = self.motion.targets.len();
        if !(1..=MOST_TARGETS).contains(&targets) {
            return Err(format!("{targets} targets, expected 1 to {MOST_TARGETS}"));
        }
        let nodes = animation.nodes.len();
        for (i, target) in self.motion.targets.iter().enumerate() {
            if target.node as usize >= nodes {
                return Err(format!("targets[{i}].node is {}, expected less than {nodes}", target.node));
            }
            if !target.weight.is_finite() {
                return Err(format!("targets[{i}].weight is {}, expected a finite number", target.weight));
            }
        }
        for (i, channel) in self.motion.channels.iter().enumerate() {
            channel.check(animation, targets).map_err(|e| format!("channels[{i}]{e}"))?;
        }
        if self.first.len() != vertices + 1 {
            let found = self.first.len();
            return Err(format!("first has {found} entries, expected one for each of {vertices} vertices, plus one"));
        }
        let ends = (self.first.first(), self.first.last());
        let rises = self.first.windows(2).all(|w| w[0] <= w[1]);
        if !rises || ends != (Some(&0), u32::try_from(self.deltas.len()).ok().as_ref()) {
            return Err(format!(
                "first is invalid, expected it to ascend from 0 to {}, the number of deltas",
                self.deltas.len()
            ));
        }
        for (i, delta) in self.deltas.iter().enumerate() {
            if delta.target as usize >= targets {
                return Err(format!("deltas[{i}].target is {}, expected less than {targets}", delta.target));
            }
            if [delta.position, delta.normal, delta.tangent].iter().flatten().any(|x| !x.is_finite()) {
                return Err(format!("deltas[{i}] is {delta:?}, expected finite numbers"));
            }
        }
        Ok(())
    }
}
