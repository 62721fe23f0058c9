//! Guided hair: root and guides of each hair, and the positions of its points on a posed mesh.
//!
//! A package stores the guides of a group, and the group's parameters ([`HairGroup`]). These and a seed determine the
//! hairs, in the runtime as in the path-traced reference. A guide's points are stored relative to its root in the frame
//! of the root's triangle, so that the group moves with the surface.

mod follow;
mod point_grid;
mod smooth;

pub use crate::sections::hair::TrianglePoint;
pub use follow::{GUIDES_PER_HAIR, GuideInterpolator, GuideWeights};
pub use point_grid::PointGrid;
pub use smooth::smoothed;

use crate::meaning::srgb_to_linear;
use crate::sections::hair::HairGroup;
use glam::{Mat3, Vec3};

/// Number of different colours of the hairs in a group.
pub const HAIR_COLORS: u32 = 32;

/// Share of the hairs that stray.
const STRAY_SHARE: f32 = 0.08;
/// Lateral offset of a hair that does not stray, divided by the offset of a stray hair.
const ORDERLY_STRAY: f32 = 0.12;

/// Hair of a group, generated from the guides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hair {
    /// Root.
    pub root: TrianglePoint,
    /// Guides that the hair follows.
    pub follow: GuideWeights,
    /// Length as a share of the guides' length, above 0 and at most 1.
    pub length: f32,
    /// Lateral offset of the tip from the interpolated guides, in the frame of the root's triangle, metres.
    pub tip_offset: Vec3,
    /// Colour index, less than [`HAIR_COLORS`].
    pub color: u32,
}

/// Guides and generated hairs of a group, on the mesh for which the group was baked.
#[derive(Clone, Debug, Default)]
pub struct GrownGroup {
    /// Triangle of each guide's root.
    pub guide_triangles: Vec<u32>,
    /// Points of each guide, relative to its root in the frame of the root's triangle, metres. All guides have the same
    /// number of points.
    pub guides: Vec<Vec<Vec3>>,
    /// Hairs; any prefix is an even sample of all.
    pub hairs: Vec<Hair>,
}

/// Returns the first `count` hair roots of a group. They are distributed over the scalp according to its density, and
/// any prefix is as even as the whole.
///
/// * `corners`: corner positions of a triangle
pub fn roots(group: &HairGroup, count: u32, corners: &impl Fn(u32) -> [Vec3; 3]) -> Vec<TrianglePoint> {
    let scalp = Scalp::new(group, corners);
    (0..count).filter_map(|number| scalp.root(group.seed, number)).collect()
}

/// Returns the frame of a triangle: its first edge, the perpendicular in its plane, and its normal. For a triangle
/// without area, such as hidden surface, returns zero, so that its hair has no length.
pub fn triangle_frame(corners: [Vec3; 3]) -> Mat3 {
    let [a, b, c] = corners;
    let (along, normal) = ((b - a).try_normalize(), (b - a).cross(c - a).try_normalize());
    match (along, normal) {
        (Some(x), Some(z)) => Mat3::from_cols(x, z.cross(x), z),
        _ => Mat3::ZERO,
    }
}

impl GrownGroup {
    /// Generates the hairs of a group.
    ///
    /// * `positions`: vertices in the measured pose ([`crate::meaning::measured_pose`]), metres
    /// * `most`: maximum number of hairs; if there are more, only the first ones are generated
    pub fn new(group: &HairGroup, positions: &[Vec3], triangles: &[[u32; 3]], most: u32) -> Self {
        let corners = |triangle: u32| triangles[triangle as usize].map(|v| positions[v as usize]);
        let roots: Vec<TrianglePoint> = group.roots().collect();
        let guides: Vec<Vec<Vec3>> =
            (0..roots.len()).map(|guide| smoothed(&group.guide(guide), group.points as usize)).collect();
        let shapes = roots.iter().zip(&guides).map(|(root, points)| {
            let (at, frame) = (root.position(corners(root.triangle)), triangle_frame(corners(root.triangle)));
            points.iter().map(|p| at + frame * *p).collect()
        });
        let followed = GuideInterpolator::new(shapes.collect());
        let guide_triangles = roots.iter().map(|root| root.triangle).collect();
        let mut out = Self { guide_triangles, guides, hairs: Vec::new() };
        if group.hairs == 0 {
            // If the group has no hairs, the guides are the hairs.
            out.hairs = roots.iter().zip(0..most).map(|(root, number)| out.guide_hair(group, *root, number)).collect();
            return out;
        }
        let places = self::roots(group, group.hairs.min(most), &corners);
        let at = |root: &TrianglePoint| root.position(corners(root.triangle));
        // The first hairs are distributed evenly over the scalp, so they serve as the centres of locks.
        let locks = (group.hairs / group.lock_hairs.max(1)).clamp(1, places.len().max(1) as u32) as usize;
        let middles = PointGrid::new(places.iter().take(locks).map(at).collect());
        let grow = |(root, number): (&TrianglePoint, u32)| {
            let place = at(root);
            let follow = followed.follow(place)?;
            let frame = triangle_frame(corners(root.triangle));
            let middle = places[middles.nearest::<1>(place)[0].1 as usize];
            let gathered = group.clump * (at(&middle) - place);
            let length =
                follow.guides.iter().zip(&follow.weights).map(|(g, w)| w * length_of(&out.guides[*g as usize]));
            let hair = Hair { root: *root, follow, ..out.random_variation(group, number, length.sum()) };
            Some(Hair { tip_offset: hair.tip_offset + frame.transpose() * gathered, ..hair })
        };
        out.hairs = places.iter().zip(0..).filter_map(grow).collect();
        out
    }

    fn guide_hair(&self, group: &HairGroup, root: TrianglePoint, number: u32) -> Hair {
        let mut follow = GuideWeights::default();
        (follow.guides[0], follow.weights[0]) = (number, 1.0);
        Hair { root, follow, ..self.random_variation(group, number, length_of(&self.guides[number as usize])) }
    }

    /// Returns the random variation of a hair; `length_m` is the length of the guides that it follows.
    fn random_variation(&self, group: &HairGroup, number: u32, length_m: f32) -> Hair {
        let draw = |what: u32| hash_unit([group.seed, number, what]);
        let strays = if draw(1) < STRAY_SHARE { 1.0 } else { ORDERLY_STRAY };
        let way = Vec3::new(draw(2), draw(3), draw(4)) * 2.0 - 1.0;
        Hair {
            root: TrianglePoint::default(),
            follow: GuideWeights::default(),
            length: 1.0 - group.length_variation * draw(0),
            tip_offset: way * (strays * group.stray * length_m),
            color: number % HAIR_COLORS,
        }
    }

    /// Returns the points of each guide on a posed mesh, relative to its root.
    pub fn posed_guides(&self, corners: impl Fn(u32) -> [Vec3; 3]) -> Vec<Vec<Vec3>> {
        let posed = |(triangle, points): (&u32, &Vec<Vec3>)| {
            let frame = triangle_frame(corners(*triangle));
            points.iter().map(|p| frame * *p).collect()
        };
        self.guide_triangles.iter().zip(&self.guides).map(posed).collect()
    }
}

impl Hair {
    /// Returns the hair's points, root first, on a posed mesh. `corners` are those of the root's triangle; `guides`
    /// comes from [`GrownGroup::posed_guides`] for the same pose.
    pub fn points(&self, corners: [Vec3; 3], guides: &[Vec<Vec3>]) -> impl ExactSizeIterator<Item = Vec3> {
        let root = self.root.position(corners);
        let frame = triangle_frame(corners);
        let (aside, shown) = (frame * self.tip_offset, frame != Mat3::ZERO);
        let count = guides.first().map_or(0, Vec::len);
        (0..count).map(move |k| {
            let share = k as f32 / (count - 1) as f32;
            let along = self.length * k as f32;
            let (low, t) = (along.floor() as usize, along.fract());
            let at = |guide: usize| guides[guide][low].lerp(guides[guide][(low + 1).min(count - 1)], t);
            root + if shown { self.follow.mix(at) } else { Vec3::ZERO } + aside * (share * share)
        })
    }
}

/// Returns the linear colour of a hair at a point. `color` is the hair's colour index; `share` is the distance from the
/// root divided by the hair's length.
pub fn hair_color(group: &HairGroup, color: u32, share: f32) -> Vec3 {
    let linear = |c: [u8; 3]| Vec3::from(c.map(srgb_to_linear));
    // Gives hairs with consecutive indices different colours.
    let varied = 2.0 * radical_inverse(2, color) - 1.0 + 1.0 / HAIR_COLORS as f32;
    linear(group.root_color).lerp(linear(group.tip_color), share) * (1.0 + group.color_variation * varied)
}

/// Returns the radius of a hair at a point, metres. `share` is the distance from the root divided by the hair's length.
/// The radius is constant up to the middle, then tapers.
pub fn hair_radius(group: &HairGroup, share: f32) -> f32 {
    let tapered = (2.0 * share - 1.0).max(0.0);
    group.root_radius_m + (group.tip_radius_m - group.root_radius_m) * tapered * tapered
}

fn length_of(points: &[Vec3]) -> f32 {
    points.windows(2).map(|ends| ends[0].distance(ends[1])).sum()
}

/// Area in which hairs have their roots.
struct Scalp {
    /// Triangles with hair, in order, each with the sum of area times density over all triangles up to and including
    /// it.
    triangles: Vec<(u32, f64)>,
}

impl Scalp {
    fn new(group: &HairGroup, corners: &impl Fn(u32) -> [Vec3; 3]) -> Self {
        let mut sum = 0.0;
        let triangles = group.scalp.iter().map(|(triangle, share)| {
            let [a, b, c] = corners(*triangle).map(Vec3::as_dvec3);
            sum += (b - a).cross(c - a).length() * f64::from(*share);
            (*triangle, sum)
        });
        Self { triangles: triangles.collect() }
    }

    /// Returns the root of hair `number`: its triangle and position. Both come from radical inverses (Halton 1960), so
    /// that the first few hairs are spread evenly.
    fn root(&self, seed: u32, number: u32) -> Option<TrianglePoint> {
        let whole = self.triangles.last()?.1;
        let at = |base: u32| (radical_inverse(base, number + 1) + hash_unit([seed, base, 0])).fract();
        let along = f64::from(at(2)) * whole;
        let found = self.triangles.partition_point(|(_, sum)| *sum <= along);
        let (triangle, _) = *self.triangles.get(found)?;
        let (u, v) = (at(3).sqrt(), at(5));
        Some(TrianglePoint { triangle, weights: [1.0 - u, u * (1.0 - v), u * v] })
    }
}

/// Returns the radical inverse of `number`: its digits in base `base`, mirrored at the radix point.
fn radical_inverse(base: u32, mut number: u32) -> f32 {
    let (mut sum, mut scale) = (0.0f64, 1.0 / f64::from(base));
    while number > 0 {
        sum += f64::from(number % base) * scale;
        number /= base;
        scale /= f64::from(base);
    }
    sum as f32
}

/// Returns a deterministic hash of the integers in `number`, uniform in 0..1 (Mueller's 32-bit hash).
pub fn hash_unit<const N: usize>(number: [u32; N]) -> f32 {
    let mixed = number.into_iter().fold(0u32, |sum, part| {
        let x = sum.wrapping_mul(0x9e37_79b9) ^ part;
        let x = (x ^ (x >> 16)).wrapping_mul(0x045d_9f3b);
        let x = (x ^ (x >> 16)).wrapping_mul(0x045d_9f3b);
        x ^ (x >> 16)
    });
    (mixed >> 8) as f32 / (1 << 24) as f32
}

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
