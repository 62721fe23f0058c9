//! The `HAIR` section: hair on guides, group for group. Layout in `FORMAT.md`, "HAIR".

use super::kind::{Count, Kind, Row, USES_NOTHING};
use crate::encoding::{decode_section, encode_section};
use crate::error::FormatError;
use crate::package::Package;
use crate::tag::Tag;
use crate::writer::PackageWriter;
use glam::Vec3;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

impl Tag {
    /// Hair on guides, since version 3. At most one.
    pub const HAIR: Self = Self(*b"HAIR");
}

pub(crate) const KIND: Kind = Kind {
    tag: Tag::HAIR,
    since: 3,
    count: Count::AtMostOne,
    check: |package, _| package.hair_groups().map(drop),
    check_use: USES_NOTHING,
    row: Row { what: "[hair on guides](#hair-hair-on-guides)", how_many: "at most one", place: "any" },
};

/// Most groups of a package.
const MOST_GROUPS: usize = 256;
/// Most guides of a group.
const MOST_GUIDES: usize = 1 << 16;
/// Most points of a hair, and of a guide as it is stored.
const MOST_POINTS: u32 = 65;

/// A place on a triangle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OnTriangle {
    /// Its index.
    pub triangle: u32,
    /// Weights of its corners, which add up to 1.
    pub weights: [f32; 3],
}

impl OnTriangle {
    /// Where it is with the corners there.
    pub fn place(&self, corners: [Vec3; 3]) -> Vec3 {
        corners[0] * self.weights[0] + corners[1] * self.weights[1] + corners[2] * self.weights[2]
    }

    /// Weights of the second and third corner in the whole numbers of [`HairGroup::guide_roots`].
    pub fn stored_weights(&self) -> [u16; 2] {
        let [_, b, c] = self.weights.map(|w| (w.clamp(0.0, 1.0) * 65535.0).round() as u16);
        [b, c.min(65535 - b)]
    }
}

/// A group of hair: a mane, a tail, whiskers, a head of hair.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HairGroup {
    /// Name in the recipe.
    pub name: String,
    /// Hairs that follow the guides; 0 where the guides are the hairs.
    pub hairs: u32,
    /// Points of a hair, 2..=65.
    pub points: u32,
    /// Points of a guide as it is stored, 2..=65; [`crate::meaning::hair_groups::smoothed`] makes the others.
    pub guide_points: u32,
    /// What all that is left to chance begins with.
    pub seed: u32,
    /// Radius from the root to the middle, metres.
    pub root_radius_m: f32,
    /// Radius at the tip, metres.
    pub tip_radius_m: f32,
    /// Colour at the root, sRGB.
    pub root_color: [u8; 3],
    /// Colour at the tip, sRGB.
    pub tip_color: [u8; 3],
    /// How much brighter or darker than that single hairs are, 0..=1.
    pub color_variation: f32,
    /// Share of the guides' length that the shortest hair lacks, 0..=0.95.
    pub length_variation: f32,
    /// How much hairs of a lock come together at their tips, 0..=1.
    pub clump: f32,
    /// Hairs of a lock, 1 or more.
    pub lock_hairs: u32,
    /// How far the tips of stray hairs are aside, over their length, 0..=1.
    pub stray: f32,
    /// Triangles that hair grows on, and the density of the hair there over that of others, above 0 and at most 65535.
    pub scalp: Vec<(u32, u16)>,
    /// Of each guide the triangle of its root, and the weights of its second and third corner, over 65535.
    pub guide_roots: Vec<(u32, [u16; 2])>,
    /// What the largest number of a point stands for, metres.
    pub reach_m: f32,
    /// Of each guide all points but the root, relative to it, in the frame of its triangle, over 32767 of `reach_m`.
    pub guide_offsets: Vec<[i16; 3]>,
}

impl HairGroup {
    /// The most that [`HairGroup::reach_m`] can be.
    pub const MOST_REACH_M: f32 = 1e6;

    /// Sets the guides.
    ///
    /// * `guides`: of each its root, and its other points relative to that in the frame of its triangle, metres: as many for each
    pub fn set_guides(&mut self, guides: &[(OnTriangle, Vec<Vec3>)]) {
        let all = || guides.iter().flat_map(|(_, points)| points);
        self.guide_points = guides.first().map_or(2, |(_, points)| points.len() as u32 + 1);
        self.reach_m = all().map(|p| p.abs().max_element()).fold(f32::MIN_POSITIVE, f32::max);
        self.guide_roots = guides.iter().map(|(root, _)| (root.triangle, root.stored_weights())).collect();
        self.guide_offsets =
            all().map(|p| (*p / self.reach_m * 32767.0).round().to_array().map(|x| x as i16)).collect();
    }

    /// Roots of the guides.
    pub fn roots(&self) -> impl ExactSizeIterator<Item = OnTriangle> + '_ {
        self.guide_roots.iter().map(|(triangle, weights)| {
            let [b, c] = weights.map(|w| f32::from(w) / 65535.0);
            OnTriangle { triangle: *triangle, weights: [1.0 - b - c, b, c] }
        })
    }

    /// Points of a guide as it is stored, relative to its root, which is the first, in the frame of its triangle, metres.
    pub fn guide(&self, index: usize) -> Vec<Vec3> {
        let each = self.guide_points as usize - 1;
        let offsets = &self.guide_offsets[index * each..(index + 1) * each];
        let point = |offset: &[i16; 3]| Vec3::from(offset.map(|x| f32::from(x.max(-32767)) / 32767.0)) * self.reach_m;
        std::iter::once(Vec3::ZERO).chain(offsets.iter().map(point)).collect()
    }

    /// Hairs that it has.
    pub fn hair_count(&self) -> u32 {
        if self.hairs == 0 { self.guide_roots.len() as u32 } else { self.hairs }
    }

    /// How far any of it reaches from its root, metres.
    pub fn reach(&self) -> f32 {
        let squared = |o: &[i16; 3]| o.iter().map(|x| f64::from(*x) * f64::from(*x)).sum::<f64>();
        let farthest = self.guide_offsets.iter().map(squared).fold(0.0, f64::max).sqrt() / 32767.0;
        // What strays or gathers leaves its guides.
        (farthest * f64::from(self.reach_m * (1.0 + 1.8 * self.stray))) as f32
    }

    /// The first thing that is not as the specification says, but for what the mesh decides.
    fn fault(&self) -> Option<String> {
        let within = |name: &str, found: f32, least: f32, most: f32| {
            let sane = (least..=most).contains(&found);
            (!sane).then(|| format!("{name} is {found}, expected {least} to {most}"))
        };
        let count = |name: &str, found: u32, least: u32, most: u32| {
            (!(least..=most).contains(&found)).then(|| format!("{name} is {found}, expected {least} to {most}"))
        };
        let offsets = self.guide_roots.len() as u64 * u64::from(self.guide_points.max(1) - 1);
        let lists = || {
            if self.guide_offsets.len() as u64 != offsets {
                return Some(format!("{} points of guides, expected {offsets}", self.guide_offsets.len()));
            }
            if self.guide_roots.is_empty() {
                return Some("no guide, expected one or more".into());
            }
            if self.guide_roots.len() > MOST_GUIDES {
                return Some(format!("{} guides, expected at most {MOST_GUIDES}", self.guide_roots.len()));
            }
            if self.hairs > 0 && self.scalp.is_empty() {
                return Some("hairs without a triangle to grow on, expected one or more".into());
            }
            let over = |(_, [b, c]): &(u32, [u16; 2])| u32::from(*b) + u32::from(*c) > 65535;
            if let Some(at) = self.guide_roots.iter().position(over) {
                return Some(format!("guide {at}: weights above 1 together, expected at most 1"));
            }
            let none = self.scalp.iter().position(|(_, share)| *share == 0);
            none.map(|at| format!("triangle {at} of the scalp: a density of 0, expected more"))
        };
        count("points", self.points, 2, MOST_POINTS)
            .or_else(|| count("guide_points", self.guide_points, 2, MOST_POINTS))
            .or_else(|| count("lock_hairs", self.lock_hairs, 1, u32::MAX))
            .or_else(|| within("root_radius_m", self.root_radius_m, f32::MIN_POSITIVE, 1.0))
            .or_else(|| within("tip_radius_m", self.tip_radius_m, 0.0, self.root_radius_m))
            .or_else(|| within("color_variation", self.color_variation, 0.0, 1.0))
            .or_else(|| within("length_variation", self.length_variation, 0.0, 0.95))
            .or_else(|| within("clump", self.clump, 0.0, 1.0))
            .or_else(|| within("stray", self.stray, 0.0, 1.0))
            .or_else(|| within("reach_m", self.reach_m, f32::MIN_POSITIVE, Self::MOST_REACH_M))
            .or_else(lists)
    }
}

impl<'a> Package<'a> {
    /// Hair on guides, group for group; empty for a package without.
    ///
    /// Fails where the section is damaged, or names triangles that the mesh does not have.
    pub fn hair_groups(&self) -> Result<Arc<[HairGroup]>, FormatError> {
        let Some((index, section)) = self.find(Tag::HAIR, 0) else { return Ok(Arc::default()) };
        self.keep(index, || {
            let groups: Vec<HairGroup> = decode_section(Tag::HAIR, section.offset, self.section_bytes(index)?)?;
            let fail = |reason: String| FormatError::Content { tag: Tag::HAIR, offset: section.offset, reason };
            if !(1..=MOST_GROUPS).contains(&groups.len()) {
                return Err(fail(format!("{} groups, expected 1 to {MOST_GROUPS}", groups.len())));
            }
            let triangles = self.mesh()?.map_or(0, |mesh| mesh.index_count / 3);
            let mut hairs = 0u64;
            for (number, group) in groups.iter().enumerate() {
                let of = |reason: String| fail(format!("group {number} {:?}: {reason}", group.name));
                if let Some(fault) = group.fault() {
                    return Err(of(fault));
                }
                let named = group.scalp.iter().map(|(t, _)| *t).chain(group.guide_roots.iter().map(|(t, _)| *t));
                if let Some(found) = named.max().filter(|t| *t >= triangles) {
                    return Err(of(format!("triangle {found}, expected less than the mesh's {triangles}")));
                }
                hairs += u64::from(group.hair_count());
            }
            let limit = u64::from(self.limits().strands);
            if hairs > limit {
                let (offset, found) = (section.offset, hairs);
                return Err(FormatError::Limit { tag: Tag::HAIR, what: "hair count", offset, found, limit });
            }
            Ok(groups.into())
        })
    }
}

impl PackageWriter<'_> {
    /// Adds hair on guides.
    pub fn hair_groups(self, groups: &[HairGroup]) -> Self {
        self.encoded(Tag::HAIR, encode_section(Tag::HAIR, &groups))
    }
}
