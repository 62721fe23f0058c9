//! The `MRPH` section: morph targets, what moves their weights, and how far each vertex goes with them. The order of the fields is the order of the
//! bytes. Layout in `FORMAT.md`, "MRPH".

use super::animation::{Animation, MorphMotion};
use super::kind::{Count, Kind, Row, USES_NOTHING};
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

pub(crate) const KIND: Kind = Kind {
    tag: Tag::MORPHS,
    since: 3,
    count: Count::AtMostOne,
    check: |package, _| package.morphs().map(drop),
    check_use: USES_NOTHING,
    row: Row { what: "[morph targets](#mrph-morph-targets)", how_many: "at most one", place: "any" },
};

/// Most targets of a package.
const MOST_TARGETS: usize = 1 << 12;

/// A section's targets, and the skeleton that knows them.
type Kept = (Arc<Morphs>, Arc<Animation>);

impl Package<'_> {
    /// Morph targets; `None` for a package without. Decoded and checked once, then kept.
    ///
    /// Fails where the section is damaged, or does not fit mesh and skeleton.
    pub fn morphs(&self) -> Result<Option<Arc<Morphs>>, FormatError> {
        Ok(self.morphed_animation()?.map(|(morphs, _)| morphs))
    }

    /// Skeleton and clips, with what moves the weights of morph targets; `None` for a package without. Decoded and checked once, then kept.
    pub fn animation(&self) -> Result<Option<Arc<Animation>>, FormatError> {
        match self.morphed_animation()? {
            Some((_, animation)) => Ok(Some(animation)),
            None => self.skeleton(),
        }
    }

    fn morphed_animation(&self) -> Result<Option<Kept>, FormatError> {
        let Some((index, section)) = self.find(Tag::MORPHS, 0) else { return Ok(None) };
        let kept = self.keep(index, || {
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

/// Morph targets: shapes that the mesh goes over to, each by its weight.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Morphs {
    /// Which there are, and how clips move them.
    pub motion: MorphMotion,
    /// One per vertex, and one more: its entries of `deltas` are those from its own number up to the next one's. Rising, from 0 to how many there are.
    pub first: Vec<u32>,
    /// What targets do to vertices, vertex after vertex.
    pub deltas: Vec<MorphDelta>,
}

/// What a target of weight 1 adds to a vertex that it finds at weight 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable, Serialize, Deserialize)]
#[repr(C)]
pub struct MorphDelta {
    /// Index into [`MorphMotion::targets`].
    pub target: u32,
    /// Added to the position, in mesh space.
    pub position: [f32; 3],
    /// Added to the normal, which is then made unit length.
    pub normal: [f32; 3],
    /// Added to the direction of the tile's u axis, which is then made unit length and perpendicular to the normal.
    pub tangent: [f32; 3],
}

impl Morphs {
    /// The entries of a vertex; none for one that there is not.
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
            return Err(format!(
                "first has {found} entries, expected one for each of {vertices} vertices, and one more"
            ));
        }
        let ends = (self.first.first(), self.first.last());
        let rises = self.first.windows(2).all(|w| w[0] <= w[1]);
        if !rises || ends != (Some(&0), u32::try_from(self.deltas.len()).ok().as_ref()) {
            return Err(format!("first does not rise from 0 to {}, the number of deltas", self.deltas.len()));
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
