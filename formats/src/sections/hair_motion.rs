//! The `HMOV` section: how hair on guides moves, and what of the body it does not go into. Layout in `FORMAT.md`, "HMOV".

use super::hair::HairGroup;
use super::kind::{Count, Kind, Row, USES_NOTHING};
use crate::encoding::{decode_section, encode_section};
use crate::error::FormatError;
use crate::package::Package;
use crate::tag::Tag;
use crate::writer::PackageWriter;
use serde::{Deserialize, Serialize};
use std::ops::RangeInclusive;
use std::sync::Arc;

impl Tag {
    /// How hair on guides moves, since version 3: bincode of [`HairMotion`]. At most one.
    pub const HAIR_MOTION: Self = Self(*b"HMOV");
}

pub(crate) const KIND: Kind = Kind {
    tag: Tag::HAIR_MOTION,
    since: 3,
    count: Count::AtMostOne,
    check: |package, _| package.hair_motion().map(drop),
    check_use: USES_NOTHING,
    row: Row { what: "[how hair moves](#hmov-how-hair-moves)", how_many: "at most one", place: "any" },
};

/// Largest number of a place, metres.
const FARTHEST_M: f32 = 1e6;

/// How the hair of a package moves.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HairMotion {
    /// One for each group of the section `HAIR`, in their order.
    pub groups: Vec<GroupMotion>,
    /// For each group how freely each of its guides moves, times what [`GroupMotion::freedom`] says, 0 to 255 for 0 to 1; nothing where all are free.
    pub freedom: Vec<Vec<u8>>,
    /// What of the body hair does not go into: at most [`HairMotion::MOST_COLLIDERS`].
    pub colliders: Vec<BodyCollider>,
}

/// How the hair of a group moves.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct GroupMotion {
    /// Share of a hair from its root on that the skin holds, 0..=1; 1: it does not move of itself.
    pub held: f32,
    /// Share of a hair from its root on beyond which it is wholly free, from `held` to 1.
    pub free: f32,
    /// How fast the air takes it along, 1/s, 0..=1000.
    pub drag_per_s: f32,
    /// How often a second it swings back to where it was groomed, 0..=100; 0: it hangs.
    pub shape_hz: f32,
    /// How often a second its pieces swing back to the shape that they were groomed in, 0..=100; 0: it is limp.
    pub bend_hz: f32,
    /// Share of its speed along a collider that it loses in 1/120 s, 0..=1.
    pub friction: f32,
}

impl Default for GroupMotion {
    /// Long hair: a mane, a tail.
    fn default() -> Self {
        Self { held: 0.0, free: 0.3, drag_per_s: 2.0, shape_hz: 0.5, bend_hz: 1.2, friction: 0.2 }
    }
}

impl GroupMotion {
    /// What the skin holds wholly.
    pub const STIFF: Self = Self { held: 1.0, free: 1.0, drag_per_s: 0.0, shape_hz: 0.0, bend_hz: 0.0, friction: 0.0 };

    /// Range of `drag_per_s`.
    pub const DRAG_PER_S: RangeInclusive<f32> = 0.0..=1000.0;
    /// Range of `shape_hz` and `bend_hz`.
    pub const HZ: RangeInclusive<f32> = 0.0..=100.0;

    /// How freely a point moves at a share of its hair's length, 0..=1.
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

/// A capsule that goes with a joint; of no length it is a ball.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BodyCollider {
    /// Index into [`crate::Animation::joints`]; 0 for a package without skeleton.
    pub joint: u32,
    /// One end of its axis, mesh space.
    pub from: [f32; 3],
    /// The other.
    pub to: [f32; 3],
    /// Above 0, in the lengths of mesh space.
    pub radius: f32,
}

impl HairMotion {
    /// Colliders at most.
    pub const MOST_COLLIDERS: usize = 64;

    /// How freely a guide of a group moves beside what is said of the whole group, 0..=1.
    pub fn guide_freedom(&self, group: usize, guide: usize) -> f32 {
        let found = self.freedom.get(group).and_then(|guides| guides.get(guide));
        found.map_or(1.0, |byte| f32::from(*byte) / 255.0)
    }

    /// The first thing that is not as the specification says.
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
                return Some(format!("colliders[{i}] is {collider:?}, expected numbers within {FARTHEST_M}"));
            }
            let sane = collider.radius > 0.0 && collider.radius <= FARTHEST_M;
            (!sane).then(|| format!("colliders[{i}].radius is {}, expected above 0 and at most 1e6", collider.radius))
        })
    }
}

impl Package<'_> {
    /// How hair on guides moves; `None` for a package that says nothing of it.
    ///
    /// Fails where the section is damaged, or does not fit the groups of hair and the skeleton.
    pub fn hair_motion(&self) -> Result<Option<Arc<HairMotion>>, FormatError> {
        let Some((index, section)) = self.find(Tag::HAIR_MOTION, 0) else { return Ok(None) };
        let kept = self.keep(index, || {
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
    /// Adds how hair on guides moves.
    pub fn hair_motion(self, motion: &HairMotion) -> Self {
        self.encoded(Tag::HAIR_MOTION, encode_section(Tag::HAIR_MOTION, motion))
    }
}
