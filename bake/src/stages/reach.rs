//! Influence of marks by distance along the mesh surface, and blending of several marks that reach the same point.

use crate::noise::smooth_step;
use std::ops::{Add, Mul};

/// Default reach of a mark, as a share of the model's radius.
const DEFAULT_REACH: f32 = 0.3;
/// Share of the reach within which a mark has full weight.
pub(crate) const FULL: f32 = 0.25;
/// Lower limit of 1 − influence in a mark's weight, so that two marks with full influence at one point get equal
/// weights.
const MIN_REMAINDER: f32 = 1e-3;

pub(crate) fn default_reach_m(radius_m: f32) -> f32 {
    DEFAULT_REACH * if radius_m > 0.0 { radius_m } else { 1.0 }
}

/// Returns the influence of a mark at distance `way`: 1 within a quarter of its reach, falling to 0 at its reach. `way`
/// and `reach` have the same unit; `reach` is above 0.
pub(crate) fn influence(way: f32, reach: f32) -> f32 {
    1.0 - smooth_step(FULL, 1.0, way / reach)
}

/// Weighted sum of the values of several marks at one point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MarkBlend<T> {
    sum: T,
    weight: f32,
    /// Share that remains for the value without marks, 0..=1.
    left: f32,
}

impl<T: Default> Default for MarkBlend<T> {
    fn default() -> Self {
        Self { sum: T::default(), weight: 0.0, left: 1.0 }
    }
}

impl<T: Copy + Add<Output = T> + Mul<f32, Output = T>> MarkBlend<T> {
    /// Adds a mark with `value` and influence `share`, 0..=1. A mark with full influence outweighs all marks with less
    /// influence.
    pub(crate) fn add(&mut self, share: f32, value: T) {
        if share <= 0.0 {
            return;
        }
        let weight = share / (1.0 - share).max(MIN_REMAINDER);
        self.sum = self.sum + value * weight;
        self.weight += weight;
        self.left *= 1.0 - share;
    }

    /// Returns the marks' joint influence, above 0, and their weighted mean; `None` if no mark reaches the point.
    pub(crate) fn finish(&self) -> Option<(f32, T)> {
        (self.weight > 0.0).then(|| (1.0 - self.left, self.sum * self.weight.recip()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mark_influence_is_full_nearby_and_fades_to_zero() {
        assert_eq!([0.0, 0.25, 1.0, 3.0].map(|way| influence(way, 1.0)), [1.0, 1.0, 0.0, 0.0]);
        let shares: Vec<f32> = (0..=40).map(|k| influence(0.1 * k as f32, 4.0)).collect();
        assert!(shares.windows(2).all(|s| s[1] <= s[0] && s[0] - s[1] < 0.06), "{shares:?}");
        assert_eq!((default_reach_m(2.0), default_reach_m(0.0)), (0.6, 0.3));
    }

    #[test]
    fn nearer_marks_dominate_and_the_rest_keeps_the_default() {
        let said = |marks: &[(f32, f32)]| {
            let mut said = MarkBlend::default();
            marks.iter().for_each(|(share, value)| said.add(*share, *value));
            said.finish()
        };
        assert_eq!((said(&[]), said(&[(0.0, 5.0)])), (None, None));
        assert_eq!(said(&[(0.25, 5.0)]), Some((0.25, 5.0)));
        let found = said(&[(1.0, 1.0), (0.5, 0.0)]);
        assert!(found.is_some_and(|(share, value)| share == 1.0 && value > 0.99), "{found:?}");
        assert_eq!(said(&[(1.0, 1.0), (1.0, 0.0)]), Some((1.0, 0.5)));
        assert_eq!(said(&[(0.5, 1.0), (0.5, 0.0)]), Some((0.75, 0.5)));
    }
}
