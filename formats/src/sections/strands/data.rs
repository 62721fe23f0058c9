//! Strands as numbers of their unit, and as the whole numbers that a package stores.

/// A point of a strand as a package stores it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StrandPoint {
    /// Way from the root along u and v, widths of the tile.
    pub aside: [f32; 2],
    /// Share of the fur's height, 0..=1.
    pub height: f32,
    /// Widths of the tile.
    pub radius: f32,
    /// sRGB, times the skin's colour at the root.
    pub color: [u8; 3],
    /// How much light reaches it, as in a texel of [`crate::VisibilityInfo`].
    pub visibility: [u8; 4],
}

/// Strands to be written.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StrandsData {
    /// Points of each strand, 2..=33, equally far from each other along it.
    pub points_per_strand: u32,
    /// Place of each root in the tile, 0..1. The first few are an even sample of all, however many.
    pub roots: Vec<[f32; 2]>,
    /// Of each strand, root first; then those of the same strands when they are wet, where dry and wet hair mix.
    pub points: Vec<StrandPoint>,
}

/// What the largest numbers of a stored point stand for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StrandScale {
    /// Way along u or v, widths of the tile; above 0.
    pub reach: f32,
    /// Radius, widths of the tile; above 0.
    pub radius: f32,
}

/// A point of a strand in the whole numbers of the section.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StoredStrandPoint {
    /// Over 32767 of [`StrandScale::reach`]; −32768 counts as −32767.
    pub aside: [i16; 2],
    /// Over 65535 of the fur's height.
    pub height: u16,
    /// Over 65535 of [`StrandScale::radius`].
    pub radius: u16,
    /// As [`StrandPoint::color`].
    pub color: [u8; 3],
    /// As [`StrandPoint::visibility`].
    pub visibility: [u8; 4],
}

/// The strands of a section as its bytes have them, for programs that take packages apart and put them together again.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StoredStrands {
    /// As [`StrandsData::points_per_strand`].
    pub points_per_strand: u32,
    /// What the numbers of points stand for.
    pub scale: StrandScale,
    /// As [`StrandsData::roots`]: the middle of what each number stands for, over 65536.
    pub roots: Vec<[u16; 2]>,
    /// As [`StrandsData::points`].
    pub points: Vec<StoredStrandPoint>,
}

/// The middle of what the numbers of a root stand for, 0..1.
pub fn strand_root(stored: [u16; 2]) -> [f32; 2] {
    stored.map(|x| (f32::from(x) + 0.5) / 65536.0)
}

impl StrandPoint {
    /// The nearest numbers of the section; what is beyond their range becomes the end of it.
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
    /// What the numbers stand for.
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
    /// The numbers that strands are stored as, with the least scale that holds all of them. Says what is wrong where counts do not fit each other, or a
    /// number is out of its range.
    pub(super) fn of(data: &StrandsData) -> Result<Self, String> {
        let sane = data.points.iter().all(|p| {
            p.aside.iter().all(|x| x.is_finite())
                && (0.0..=1.0).contains(&p.height)
                && p.radius.is_finite()
                && p.radius >= 0.0
        });
        if !sane || !data.roots.iter().flatten().all(|x| (0.0..1.0).contains(x)) {
            return Err("a root outside the tile, or a point that is not finite or outside the fur".into());
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
