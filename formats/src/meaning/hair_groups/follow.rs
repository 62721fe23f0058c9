//! Interpolation of many hairs from few guides: each hair is a weighted mean of the guides around it, except for those
//! beyond a parting.

use super::point_grid::PointGrid;
use glam::Vec3;

/// Number of guides that a hair follows.
pub const GUIDES_PER_HAIR: usize = 4;

/// Maximum difference between the shapes of two guides that are mixed, as a share of their mean length. If the
/// difference is larger, hair parts between them.
const PARTING_THRESHOLD: f32 = 0.6;

/// Guides that a hair follows, with weights.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GuideWeights {
    /// Indices of guides, nearest first.
    pub guides: [u32; GUIDES_PER_HAIR],
    /// Weights, summing to 1; 0 for guides beyond a parting.
    pub weights: [f32; GUIDES_PER_HAIR],
}

/// Guides with equal numbers of points, for interpolating hair by root position.
#[derive(Clone, Debug)]
pub struct GuideInterpolator {
    /// Points of each guide, root first.
    shapes: Vec<Vec<Vec3>>,
    lengths: Vec<f32>,
    roots: PointGrid,
}

impl GuideInterpolator {
    /// Creates the set of guides.
    ///
    /// * `shapes`: points of each guide, root first; 2 or more, the same number for each
    pub fn new(shapes: Vec<Vec<Vec3>>) -> Self {
        let length = |shape: &Vec<Vec3>| shape.windows(2).map(|ends| ends[0].distance(ends[1])).sum();
        let roots = PointGrid::new(shapes.iter().map(|shape| shape[0]).collect());
        Self { lengths: shapes.iter().map(length).collect(), shapes, roots }
    }

    /// Returns the number of guides.
    pub fn len(&self) -> usize {
        self.shapes.len()
    }

    /// Whether there are no guides.
    pub fn is_empty(&self) -> bool {
        self.shapes.is_empty()
    }

    /// Returns the guides that hair from `root` follows; `None` if there are none.
    ///
    /// A guide's weight falls to 0 where the fifth nearest guide is equally near, so that weights change smoothly from
    /// root to root. This is a modified Shepard interpolation (Franke and Nielson 1980). Guides separated from the
    /// nearest one by a parting have weight 0.
    pub fn follow(&self, root: Vec3) -> Option<GuideWeights> {
        let near = self.roots.nearest::<{ GUIDES_PER_HAIR + 1 }>(root);
        let nearest = near[0].1 as usize;
        self.shapes.get(nearest)?;
        // If there are few guides, all are followed.
        let last = near.iter().rev().find(|(d, _)| d.is_finite())?.0.sqrt();
        let reach = if near[GUIDES_PER_HAIR].0.is_finite() { last } else { 1.5 * last };
        let mut follow = GuideWeights::default();
        for (i, (distance, index)) in near[..GUIDES_PER_HAIR].iter().enumerate() {
            if !distance.is_finite() || self.is_parted(nearest, *index as usize) {
                continue;
            }
            let d = distance.sqrt().max(1e-6 * reach);
            follow.guides[i] = *index;
            let weight = ((reach - d) / (reach * d)).max(0.0);
            follow.weights[i] = weight * weight;
        }
        let sum: f32 = follow.weights.iter().sum();
        if sum > 0.0 && sum.is_finite() {
            follow.weights.iter_mut().for_each(|w| *w /= sum);
        } else {
            follow.weights = [0.0; GUIDES_PER_HAIR];
            (follow.guides[0], follow.weights[0]) = (nearest as u32, 1.0);
        }
        Some(follow)
    }

    /// Whether hair parts between two guides: at some point, their offsets from their roots differ by more than
    /// `PARTING_THRESHOLD` of the mean length.
    pub fn is_parted(&self, a: usize, b: usize) -> bool {
        let limit = PARTING_THRESHOLD * 0.5 * (self.lengths[a] + self.lengths[b]);
        let (one, other) = (&self.shapes[a], &self.shapes[b]);
        one.iter().zip(other).any(|(p, q)| ((*p - one[0]) - (*q - other[0])).length() > limit)
    }
}

impl GuideWeights {
    /// Returns the weighted mean of the guides' positions; `at` returns the position for a guide.
    pub fn mix(&self, at: impl Fn(usize) -> Vec3) -> Vec3 {
        let of = |(guide, weight): (&u32, &f32)| if *weight > 0.0 { *weight * at(*guide as usize) } else { Vec3::ZERO };
        self.guides.iter().zip(&self.weights).map(of).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the points of the hair from `root`, relative to the root.
    fn hair(guides: &GuideInterpolator, root: Vec3) -> Vec<Vec3> {
        let follow = guides.follow(root).unwrap();
        (0..5).map(|k| follow.mix(|guide| guides.shapes[guide][k] - guides.shapes[guide][0])).collect()
    }

    /// Returns a straight guide from (x, 0, z) along `way`.
    fn straight(x: f32, z: f32, way: Vec3) -> Vec<Vec3> {
        (0..5).map(|k| Vec3::new(x, 0.0, z) + way * k as f32 / 4.0).collect()
    }

    #[test]
    fn hair_is_interpolated_between_guides() {
        // Guides on a grid with smoothly varying directions. Hair that grows between them must have the direction given
        // for its own position.
        let way = |x: f32, z: f32| Vec3::new(0.05 * x, 1.0, 0.05 * z);
        let grid = (0..6).flat_map(|i| (0..6).map(move |j| (i as f32, j as f32)));
        let guides = GuideInterpolator::new(grid.map(|(x, z)| straight(x, z, way(x, z))).collect());
        for (x, z) in [(2.5, 2.5), (1.2, 3.7), (3.0, 3.0), (2.01, 2.0)] {
            let root = Vec3::new(x, 0.0, z);
            let follow = guides.follow(root).unwrap();
            assert!((follow.weights.iter().sum::<f32>() - 1.0).abs() < 1e-5, "{follow:?}");
            let hair = hair(&guides, root);
            assert_eq!(hair[0], Vec3::ZERO);
            assert!(hair[4].distance(way(x, z)) < 0.03, "{hair:?}");
        }
        // Hairs with neighbouring roots have neighbouring tips: the tip moves smoothly with the root.
        let tip = |x: f32| hair(&guides, Vec3::new(x, 0.0, 2.3))[4];
        let jump = (0..400).map(|i| 1.0 + 0.01 * i as f32).map(|x| tip(x).distance(tip(x + 0.01))).fold(0.0, f32::max);
        assert!(jump < 0.006, "{jump}");
    }

    /// Hair falls to the left on the left of a parting, and to the right on its right. If it were interpolated across
    /// the parting, it would stand up.
    #[test]
    fn hair_parts_where_guides_part() {
        let fall = |x: f32| Vec3::new(if x < 0.0 { -1.0 } else { 1.0 }, -0.5, 0.0);
        let grid = (-3..3).flat_map(|i| (0..6).map(move |j| (i as f32 + 0.5, j as f32)));
        let guides = GuideInterpolator::new(grid.map(|(x, z)| straight(x, z, fall(x))).collect());
        assert!(guides.is_parted(0, 30) && !guides.is_parted(0, 1));
        for x in [-0.4, -0.05, 0.05, 0.4] {
            let hair = hair(&guides, Vec3::new(x, 0.0, 2.5));
            assert!(hair[4].distance(fall(x)) < 1e-5, "at {x}: {hair:?}");
        }
        // Averaging the nearest guides regardless of direction would make hair stand up and shorten at the parting.
        let near = guides.roots.nearest::<GUIDES_PER_HAIR>(Vec3::new(0.05, 0.0, 2.5));
        let naive: Vec3 = near
            .iter()
            .map(|(_, guide)| 0.25 * (guides.shapes[*guide as usize][4] - guides.shapes[*guide as usize][0]))
            .sum();
        assert!(naive.length() < 0.7 * fall(1.0).length(), "{naive}");
    }

    #[test]
    fn interpolation_works_with_few_guides() {
        assert_eq!(GuideInterpolator::new(Vec::new()).follow(Vec3::ZERO), None);
        let one = GuideInterpolator::new(vec![straight(0.0, 0.0, Vec3::Y)]);
        for root in [Vec3::ZERO, Vec3::X * 5.0] {
            assert!(hair(&one, root)[4].distance(Vec3::Y) < 1e-6);
        }
        let two =
            GuideInterpolator::new(vec![straight(0.0, 0.0, Vec3::Y), straight(1.0, 0.0, Vec3::new(0.2, 1.0, 0.0))]);
        let middle = hair(&two, Vec3::X * 0.5);
        assert!(middle[4].distance(Vec3::new(0.1, 1.0, 0.0)) < 1e-5, "{middle:?}");
        // Guides at the same position do not cause a division by zero.
        let same = GuideInterpolator::new(vec![straight(0.0, 0.0, Vec3::Y); 6]);
        assert!(hair(&same, Vec3::ZERO).iter().all(|p| p.is_finite()));
    }
}
