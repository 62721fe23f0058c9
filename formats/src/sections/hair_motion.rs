//! The `HMOV` section: motion of guided hair, and its colliders. Layout in `FORMAT.md`, "HMOV".

use super::hair::HairGroup;
use super::kind::Kind;
use crate::encoding::{decode_section, encode_section};
use crate::error::FormatError;
use crate::package::Package;
use crate::tag::Tag;
use crate::writer::PackageWriter;
use serde::{Deserialize, Serialize};
use std::ops::RangeInclusive;
use std::sync::Arc;

impl Tag {
    /// Motion of guided hair, since version 3: bincode of [`HairMotion`]. At most one.
    pub const HAIR_MOTION: Self = Self(*b"HMOV");
}

pub(crate) const KIND: Kind =
    Kind::optional(Tag::HAIR_MOTION, 3, "[how hair moves](#hmov-how-hair-moves)", |package, _| {
        package.hair_motion().map(drop)
    });

/// Maximum absolute value of a coordinate, metres.
const FARTHEST_M: f32 = 1e6;

/// Motion of a package's hair.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HairMotion {
    /// Motion of each group of the section `HAIR`, in the same order.
    pub groups: Vec<GroupMotion>,
    /// For each group, the freedom of each guide, 0 to 255 for 0 to 1. It is a factor on [`GroupMotion::freedom`]. An
    /// empty list means that all guides are free.
    pub freedom: Vec<Vec<u8>>,
    /// Colliders of the body: at most [`HairMotion::MOST_COLLIDERS`].
    pub colliders: Vec<BodyCollider>,
}

/// Motion of a group's hair.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct GroupMotion {
    /// Share of a hair, from its root, that is fixed to the surface, 0..=1. With 1, the hair does not move by itself.
    pub held: f32,
    /// Share of a hair, from its root, beyond which the hair is fully free, `held`..=1.
    pub free: f32,
    /// Drag rate: how fast hair takes on the velocity of the air, 1/s, 0..=1000.
    pub drag_per_s: f32,
    /// Frequency of the spring to the groomed position, Hz, 0..=100. With 0, hair hangs.
    pub shape_hz: f32,
    /// Frequency of the spring to the groomed shape of each segment, Hz, 0..=100. With 0, hair is limp.
    pub bend_hz: f32,
    /// Share of its tangential speed that hair on a collider loses in 1/120 s, 0..=1.
    pub friction: f32,
}

impl Default for GroupMotion {
    /// Returns the motion of long hair: a mane, a tail.
    fn default() -> Self {
        Self { held: 0.0, free: 0.3, drag_per_s: 2.0, shape_hz: 0.5, bend_hz: 1.2, friction: 0.2 }
    }
}

impl GroupMotion {
    /// Hair fixed to the surface over its whole length.
    pub const STIFF: Self = Self { held: 1.0, free: 1.0, drag_per_s: 0.0, shape_hz: 0.0, bend_hz: 0.0, friction: 0.0 };

    /// Range of `drag_per_s`.
    pub const DRAG_PER_S: RangeInclusive<f32> = 0.0..=1000.0;
    /// Range of `shape_hz` and `bend_hz`.
    pub const HZ: RangeInclusive<f32> = 0.0..=100.0;

    /// Returns the freedom, 0..=1, of the point at share `share` of its hair's length.
    pub fn freedom(&self, share: f32) -> f32 {
        if share <= self.held {
            return 0.0;
        }
        let way = ((share - self.held) / (self.free - self.held).max(1e-6)).clamp(0.0, 1.0);
        way * way * (3.0 - 2.0 * way)
    }

    fn fault(&self) -> Option<String> {
        let ranges = [
            ("held", self.held, 0.0..=1.0),
            ("free", self.free, self.held..=1.0),
            ("drag_per_s", self.drag_per_s, Self::DRAG_PER_S),
            ("shape_hz", self.shape_hz, Self::HZ),
            ("bend_hz", self.bend_hz, Self::HZ),
            ("friction", self.friction, 0.0..=1.0),
        ];
        let outside = ranges.into_iter().find(|(_, found, range)| !range.contains(found));
        outside.map(|(name, found, range)| format!("{name} is {found}, expected {} to {}", range.start(), range.end()))
    }
}

/// Capsule collider attached to a joint; a sphere if its length is 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BodyCollider {
    /// Index into [`crate::Animation::joints`]; 0 for a package without skeleton.
    pub joint: u32,
    /// First end of the axis, mesh space.
    pub from: [f32; 3],
    /// Second end of the axis, mesh space.
    pub to: [f32; 3],
    /// Radius, above 0, in units of mesh space.
    pub radius: f32,
}

impl HairMotion {
    /// Maximum number of colliders.
    pub const MOST_COLLIDERS: usize = 64;

    /// Returns the freedom of a guide, 0..=1. Multiply it by the freedom of a point ([`GroupMotion::freedom`]).
    pub fn guide_freedom(&self, group: usize, guide: usize) -> f32 {
        let found = self.freedom.get(group).and_then(|guides| guides.get(guide));
        found.map_or(1.0, |byte| f32::from(*byte) / 255.0)
    }

    /// Returns the first violation of the specification.
    fn fault(&self, groups: &[HairGroup], joints: usize) -> Option<String> {
        for (name, found) in [("groups", self.groups.len()), ("lists of freedom", self.freedom.len())] {
            if found != groups.len() {
                return Some(format!("{found} {name}, expected the {} of the section HAIR", groups.len()));
            }
        }
        for (i, (freedom, group)) in self.freedom.iter().zip(groups).enumerate() {
            if ![0, group.guide_roots.len()].contains(&freedom.len()) {
                let (found, guides) = (freedom.len(), group.guide_roots.len());
                return Some(format!(
                    "freedom[{i}] has {found} values, expected none, or one for each of {guides} guides"
                ));
            }
        }
        if let Some((i, fault)) = self.groups.iter().enumerate().find_map(|(i, g)| Some((i, g.fault()?))) {
            return Some(format!("groups[{i}].{fault}"));
        }
        if self.colliders.len() > Self::MOST_COLLIDERS {
            return Some(format!("{} colliders, expected at most {}", self.colliders.len(), Self::MOST_COLLIDERS));
        }
        self.colliders.iter().enumerate().find_map(|(i, collider)| {
            let near = |x: &f32| (-FARTHEST_M..=FARTHEST_M).contains(x);
            if collider.joint as usize >= joints.max(1) {
                return Some(format!(
                    "colliders[{i}].joint is {}, expected less than {}",
                    collider.joint,
                    joints.max(1)
                ));
            }
            if !collider.from.iter().chain(&collider.to).all(near) {
                return Some(format!("colliders[{i}] is {collider:?}, expected absolute values up to {FARTHEST_M}"));
            }
            let sane = collider.radius > 0.0 && collider.radius <= FARTHEST_M;
            (!sane).then(|| format!("colliders[{i}].radius is {}, expected above 0 and at most 1e6", collider.radius))
        })
    }
}

impl Package<'_> {
    /// Returns the motion of guided hair; `None` if the package has no such section.
    ///
    /// Fails if the section is damaged, or is inconsistent with the hair groups or the skeleton.
    pub fn hair_motion(&self) -> Result<Option<Arc<HairMotion>>, FormatError> {
        let Some((index, section)) = self.find(Tag::HAIR_MOTION, 0) else { return Ok(None) };
        let kept = self.cached(index, || {
            let motion: HairMotion = decode_section(Tag::HAIR_MOTION, section.offset, self.section_bytes(index)?)?;
            let joints = self.animation()?.map_or(0, |animation| animation.joints.len());
            match motion.fault(&self.hair_groups()?, joints) {
                Some(reason) => Err(FormatError::Content { tag: Tag::HAIR_MOTION, offset: section.offset, reason }),
                None => Ok(Arc::new(motion)),
            }
        });
        kept.map(Some)
    }
}

impl PackageWriter<'_> {
    /// Adds the motion of guided hair.
    pub fn hair_motion(self, motion: &HairMotion) -> Self {
        self.encoded(Tag::HAIR_MOTION, encode_section(Tag::HAIR_MOTION, motion))
    }
}
