//! How far what is said of a place reaches over the skin, and what comes of several that reach the same.

use crate::noise::smooth_step;
use std::ops::{Add, Mul};

/// How far a mark reaches that does not say it, radii of the model.
const CHOSEN: f32 = 0.3;
/// Share of the reach within which it counts in full.
pub(crate) const FULL: f32 = 0.25;
/// Least share by which one that counts in full falls short of ruling alone, so that two at one place share it.
const SHORT: f32 = 1e-3;

/// How far a mark reaches that does not say it, on a model of that radius; metres.
pub(crate) fn chosen_m(radius_m: f32) -> f32 {
    CHOSEN * if radius_m > 0.0 { radius_m } else { 1.0 }
}

/// How much a mark counts that far from it: 1 within a quarter of its reach, 0 from there on. Both in one unit, the reach above 0.
pub(crate) fn share(way: f32, reach: f32) -> f32 {
    1.0 - smooth_step(FULL, 1.0, way / reach)
}

/// What several marks say of one place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Said<T> {
    sum: T,
    weight: f32,
    /// What they leave to what holds elsewhere.
    left: f32,
}

impl<T: Default> Default for Said<T> {
    fn default() -> Self {
        Self { sum: T::default(), weight: 0.0, left: 1.0 }
    }
}

impl<T: Copy + Add<Output = T> + Mul<f32, Output = T>> Said<T> {
    /// One says `value`, and counts by `share`. One that counts in full outweighs those that do not.
    pub(crate) fn add(&mut self, share: f32, value: T) {
        if share <= 0.0 {
            return;
        }
        let weight = share / (1.0 - share).max(SHORT);
        self.sum = self.sum + value * weight;
        self.weight += weight;
        self.left *= 1.0 - share;
    }

    /// How much they count together, above 0, and the mean of what they say; `None` where none reaches.
    pub(crate) fn together(&self) -> Option<(f32, T)> {
        (self.weight > 0.0).then(|| (1.0 - self.left, self.sum * self.weight.recip()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mark_counts_in_full_nearby_and_fades_to_nothing() {
        assert_eq!([0.0, 0.25, 1.0, 3.0].map(|way| share(way, 1.0)), [1.0, 1.0, 0.0, 0.0]);
        let shares: Vec<f32> = (0..=40).map(|k| share(0.1 * k as f32, 4.0)).collect();
        assert!(shares.windows(2).all(|s| s[1] <= s[0] && s[0] - s[1] < 0.06), "{shares:?}");
        assert_eq!((chosen_m(2.0), chosen_m(0.0)), (0.6, 0.3));
    }

    #[test]
    fn the_nearer_rules_and_what_is_left_is_elsewheres() {
        let said = |marks: &[(f32, f32)]| {
            let mut said = Said::default();
            marks.iter().for_each(|(share, value)| said.add(*share, *value));
            said.together()
        };
        assert_eq!((said(&[]), said(&[(0.0, 5.0)])), (None, None));
        assert_eq!(said(&[(0.25, 5.0)]), Some((0.25, 5.0)));
        let found = said(&[(1.0, 1.0), (0.5, 0.0)]);
        assert!(found.is_some_and(|(share, value)| share == 1.0 && value > 0.99), "{found:?}");
        assert_eq!(said(&[(1.0, 1.0), (1.0, 0.0)]), Some((1.0, 0.5)));
        assert_eq!(said(&[(0.5, 1.0), (0.5, 0.0)]), Some((0.75, 0.5)));
    }
}
