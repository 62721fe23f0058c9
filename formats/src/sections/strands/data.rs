//! Strands in physical units, and in the integers that a package stores.

/// Point of a strand, in physical units.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StrandPoint {
    /// Offset from the root along u and v, widths of the tile.
    pub aside: [f32; 2],
    /// Height, as a share of the fur's height, 0..=1.
    pub height: f32,
    /// Radius, widths of the tile.
    pub radius: f32,
    /// Colour, sRGB, by which the surface colour at the root is multiplied.
    pub color: [u8; 3],
    /// Visibility of light, as in a texel of [`crate::VisibilityInfo`].
    pub visibility: [u8; 4],
}

/// Strands to be written.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StrandsData {
    /// Points of each strand, 2..=33, equally spaced along it.
    pub points_per_strand: u32,
    /// Position of each root in the tile, 0..1. Any prefix is an even sample of all.
    pub roots: Vec<[f32; 2]>,
    /// Points of each strand, root first. If dry and wet hair are blended, the points of the same strands when wet
    /// follow.
    pub points: Vec<StrandPoint>,
}

/// Values that the largest integers of a stored point represent.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StrandScale {
    /// Offset along u or v, widths of the tile; above 0.
    pub reach: f32,
    /// Radius, widths of the tile; above 0.
    pub radius: f32,
}

/// Point of a strand in the integers of the section.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StoredStrandPoint {
    /// Offset in units of [`StrandScale::reach`] / 32767; −32768 counts as −32767.
    pub aside: [i16; 2],
    /// Height in units of the fur's height / 65535.
    pub height: u16,
    /// Radius in units of [`StrandScale::radius`] / 65535.
    pub radius: u16,
    /// Colour, as [`StrandPoint::color`].
    pub color: [u8; 3],
    /// Visibility of light, as [`StrandPoint::visibility`].
    pub visibility: [u8; 4],
}

/// Strands of a section as stored, for programs that unpack packages and pack them again.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StoredStrands {
    /// Points of each strand, as [`StrandsData::points_per_strand`].
    pub points_per_strand: u32,
    /// Scale of the points' integers.
    pub scale: StrandScale,
    /// Roots, as [`StrandsData::roots`], in units of 1/65536. Each represents the middle of its interval.
    pub roots: Vec<[u16; 2]>,
    /// Points, as [`StrandsData::points`].
    pub points: Vec<StoredStrandPoint>,
}

/// Returns the position of a stored root, 0..1: the middle of its interval.
pub fn strand_root(stored: [u16; 2]) -> [f32; 2] {
    stored.map(|x| (f32::from(x) + 0.5) / 65536.0)
}

impl StrandPoint {
    /// Rounds the point to the integers of the section; values out of range are clamped.
    pub fn stored(&self, scale: StrandScale) -> StoredStrandPoint {
        let unorm = |x: f32| (x * 65535.0 + 0.5) as u16;
        StoredStrandPoint {
            aside: self.aside.map(|x| (x / scale.reach * 32767.0).round() as i16),
            height: unorm(self.height),
            radius: unorm(self.radius / scale.radius),
            color: self.color,
            visibility: self.visibility,
        }
    }
}

impl StoredStrandPoint {
    /// Decodes the integers.
    pub fn decoded(&self, scale: StrandScale) -> StrandPoint {
        StrandPoint {
            aside: self.aside.map(|x| f32::from(x.max(-32767)) / 32767.0 * scale.reach),
            height: f32::from(self.height) / 65535.0,
            radius: f32::from(self.radius) / 65535.0 * scale.radius,
            color: self.color,
            visibility: self.visibility,
        }
    }
}

impl StoredStrands {
    /// Converts strands to integers, with the smallest scale that can represent all of them. Fails if a number is out
    /// of range.
    pub(super) fn of(data: &StrandsData) -> Result<Self, String> {
        let sane = data.points.iter().all(|p| {
            p.aside.iter().all(|x| x.is_finite())
                && (0.0..=1.0).contains(&p.height)
                && p.radius.is_finite()
                && p.radius >= 0.0
        });
        if !sane || !data.roots.iter().flatten().all(|x| (0.0..1.0).contains(x)) {
            return Err("a root is outside the tile, or a point is not finite or outside the fur".into());
        }
        let most = |of: &dyn Fn(&StrandPoint) -> f32| data.points.iter().map(of).fold(0.0, f32::max);
        let scale = StrandScale {
            reach: most(&|p| p.aside[0].abs().max(p.aside[1].abs())).max(f32::MIN_POSITIVE),
            radius: most(&|p| p.radius).max(f32::MIN_POSITIVE),
        };
        Ok(Self {
            points_per_strand: data.points_per_strand,
            scale,
            roots: data.roots.iter().map(|root| root.map(|x| ((x * 65536.0) as u32).min(65535) as u16)).collect(),
            points: data.points.iter().map(|point| point.stored(scale)).collect(),
        })
    }
}
