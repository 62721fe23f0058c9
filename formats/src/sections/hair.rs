//! The `HAIR` section: groups of guided hair. Layout in `FORMAT.md`, "HAIR".

use super::kind::Kind;
use crate::encoding::{decode_section, encode_section};
use crate::error::FormatError;
use crate::package::Package;
use crate::tag::Tag;
use crate::writer::PackageWriter;
use glam::Vec3;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

impl Tag {
    /// Guided hair, since version 3. At most one.
    pub const HAIR: Self = Self(*b"HAIR");
}

pub(crate) const KIND: Kind =
    Kind::optional(Tag::HAIR, 3, "[guided hair](#hair-guided-hair)", |package, _| package.hair_groups().map(drop));

/// Maximum number of groups in a package.
const MOST_GROUPS: usize = 256;
/// Maximum number of guides in a group.
const MOST_GUIDES: usize = 1 << 16;
/// Maximum number of points of a hair, and of a stored guide.
const MOST_POINTS: u32 = 65;

/// Point on a triangle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TrianglePoint {
    /// Index of the triangle.
    pub triangle: u32,
    /// Weights of the triangle's corners, with sum 1.
    pub weights: [f32; 3],
}

impl TrianglePoint {
    /// Returns the position for given corners of the triangle.
    pub fn position(&self, corners: [Vec3; 3]) -> Vec3 {
        corners[0] * self.weights[0] + corners[1] * self.weights[1] + corners[2] * self.weights[2]
    }

    /// Returns the weights of the second and third corner, as stored in [`HairGroup::guide_roots`].
    pub fn stored_weights(&self) -> [u16; 2] {
        let [_, b, c] = self.weights.map(|w| (w.clamp(0.0, 1.0) * 65535.0).round() as u16);
        [b, c.min(65535 - b)]
    }
}

/// Group of hair: a mane, a tail, whiskers, a head of hair.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HairGroup {
    /// Name in the recipe.
    pub name: String,
    /// Number of hairs that follow the guides; 0 if the guides are the hairs.
    pub hairs: u32,
    /// Points of a hair, 2..=65.
    pub points: u32,
    /// Points of a stored guide, 2..=65; [`crate::meaning::hair_groups::smoothed`] interpolates between them.
    pub guide_points: u32,
    /// Seed of all random variation.
    pub seed: u32,
    /// Radius from the root to the middle, metres.
    pub root_radius_m: f32,
    /// Radius at the tip, metres.
    pub tip_radius_m: f32,
    /// Colour at the root, sRGB.
    pub root_color: [u8; 3],
    /// Colour at the tip, sRGB.
    pub tip_color: [u8; 3],
    /// Variation of the brightness of single hairs about these colours, 0..=1.
    pub color_variation: f32,
    /// Variation of the hairs' length, 0..=0.95: the shortest hair is shorter than its guides by this share of their
    /// length.
    pub length_variation: f32,
    /// Strength with which the tips of a lock's hairs are drawn together, 0..=1.
    pub clump: f32,
    /// Number of hairs of a lock, 1 or more.
    pub lock_hairs: u32,
    /// Lateral offset of the tips of stray hairs, as a share of their length, 0..=1.
    pub stray: f32,
    /// Triangles with hair, each with its relative hair density, above 0 and at most 65535.
    pub scalp: Vec<(u32, u16)>,
    /// For each guide, the triangle of its root, and the weights of its second and third corner, in units of 1/65535.
    pub guide_roots: Vec<(u32, [u16; 2])>,
    /// Length represented by the largest value of a stored coordinate, metres.
    pub reach_m: f32,
    /// For each guide, all points but the root, relative to the root in the frame of its triangle, in units of
    /// `reach_m` / 32767.
    pub guide_offsets: Vec<[i16; 3]>,
}

impl HairGroup {
    /// Maximum of [`HairGroup::reach_m`].
    pub const MOST_REACH_M: f32 = 1e6;

    /// Sets the guides.
    ///
    /// * `guides`: for each guide, its root, and its other points relative to the root in the frame of the root's
    ///   triangle, metres. All guides have the same number of points.
    pub fn set_guides(&mut self, guides: &[(TrianglePoint, Vec<Vec3>)]) {
        let all = || guides.iter().flat_map(|(_, points)| points);
        self.guide_points = guides.first().map_or(2, |(_, points)| points.len() as u32 + 1);
        self.reach_m = all().map(|p| p.abs().max_element()).fold(f32::MIN_POSITIVE, f32::max);
        self.guide_roots = guides.iter().map(|(root, _)| (root.triangle, root.stored_weights())).collect();
        self.guide_offsets =
            all().map(|p| (*p / self.reach_m * 32767.0).round().to_array().map(|x| x as i16)).collect();
    }

    /// Returns the roots of the guides.
    pub fn roots(&self) -> impl ExactSizeIterator<Item = TrianglePoint> + '_ {
        self.guide_roots.iter().map(|(triangle, weights)| {
            let [b, c] = weights.map(|w| f32::from(w) / 65535.0);
            TrianglePoint { triangle: *triangle, weights: [1.0 - b - c, b, c] }
        })
    }

    /// Returns the points of a stored guide relative to its root, which is the first, in the frame of the root's
    /// triangle, metres.
    pub fn guide(&self, index: usize) -> Vec<Vec3> {
        let each = self.guide_points as usize - 1;
        let offsets = &self.guide_offsets[index * each..(index + 1) * each];
        let point = |offset: &[i16; 3]| Vec3::from(offset.map(|x| f32::from(x.max(-32767)) / 32767.0)) * self.reach_m;
        std::iter::once(Vec3::ZERO).chain(offsets.iter().map(point)).collect()
    }

    /// Returns the number of hairs.
    pub fn hair_count(&self) -> u32 {
        if self.hairs == 0 { self.guide_roots.len() as u32 } else { self.hairs }
    }

    /// Returns the maximum distance of the group's hair from its roots, metres.
    pub fn reach(&self) -> f32 {
        let squared = |o: &[i16; 3]| o.iter().map(|x| f64::from(*x) * f64::from(*x)).sum::<f64>();
        let farthest = self.guide_offsets.iter().map(squared).fold(0.0, f64::max).sqrt() / 32767.0;
        // Stray and clumped hairs reach beyond their guides.
        (farthest * f64::from(self.reach_m * (1.0 + 1.8 * self.stray))) as f32
    }

    /// Returns the first violation of the specification, except for those that depend on the mesh.
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
                return Some(format!("guide_offsets has {} entries, expected {offsets}", self.guide_offsets.len()));
            }
            if self.guide_roots.is_empty() {
                return Some("no guide, expected one or more".into());
            }
            if self.guide_roots.len() > MOST_GUIDES {
                return Some(format!("{} guides, expected at most {MOST_GUIDES}", self.guide_roots.len()));
            }
            if self.hairs > 0 && self.scalp.is_empty() {
                return Some("found hairs but no triangle in scalp, expected one or more".into());
            }
            let over = |(_, [b, c]): &(u32, [u16; 2])| u32::from(*b) + u32::from(*c) > 65535;
            if let Some(at) = self.guide_roots.iter().position(over) {
                return Some(format!("guide {at}: weights sum to more than 1, expected at most 1"));
            }
            let none = self.scalp.iter().position(|(_, share)| *share == 0);
            none.map(|at| format!("triangle {at} of the scalp: density is 0, expected more"))
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
    /// Returns the groups of guided hair; empty if the package has none.
    ///
    /// Fails if the section is damaged, or names triangles that the mesh does not have.
    pub fn hair_groups(&self) -> Result<Arc<[HairGroup]>, FormatError> {
        let Some((index, section)) = self.find(Tag::HAIR, 0) else { return Ok(Arc::default()) };
        self.cached(index, || {
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
    /// Adds guided hair.
    pub fn hair_groups(self, groups: &[HairGroup]) -> Self {
        self.encoded(Tag::HAIR, encode_section(Tag::HAIR, &groups))
    }
}
