//! Values over time, interpolated between keys: paths of cameras and models.
//!
//! Between two keys the curve is a cubic (Catmull and Rom 1974). Its tangents are those of a parabola through three
//! keys, so that keys need not be evenly spaced. Value and rate of change are continuous. Two consecutive keys with
//! equal values are a hold: the value is constant between them, and the curve does not overshoot them.

use glam::Vec3;
use std::ops::{Add, Mul, Sub};

/// Minimum time between two keys, seconds; a shorter time would amount to a jump.
pub const LEAST_STEP_S: f32 = 1e-3;

/// Type of a track's values; its default must be zero.
pub trait Value:
    Copy + Default + PartialEq + Add<Output = Self> + Sub<Output = Self> + Mul<f32, Output = Self>
{
}
impl<T: Copy + Default + PartialEq + Add<Output = T> + Sub<Output = T> + Mul<f32, Output = T>> Value for T {}

/// Value over time. Constant before the first key and after the last.
#[derive(Clone, Debug, PartialEq)]
pub struct Track<T> {
    /// Keys: time in seconds, and value. At least one key; times are at least [`LEAST_STEP_S`] apart.
    keys: Vec<(f32, T)>,
}

impl<T: Value> Track<T> {
    /// Creates a track with a constant value.
    pub fn fixed(value: T) -> Self {
        Self { keys: vec![(0.0, value)] }
    }

    /// Returns whether the track has more than one key.
    pub fn is_animated(&self) -> bool {
        self.keys.len() > 1
    }

    /// Creates a track through the given keys.
    ///
    /// Fails with the index, from 0, of the first key that is not at least [`LEAST_STEP_S`] after the previous one. 0
    /// if there are no keys.
    pub fn new(keys: Vec<(f32, T)>) -> Result<Self, usize> {
        if keys.is_empty() {
            return Err(0);
        }
        // Also rejects times that are NaN.
        match keys.windows(2).position(|pair| !matches!(pair[1].0 - pair[0].0, LEAST_STEP_S..)) {
            Some(before) => Err(before + 1),
            None => Ok(Self { keys }),
        }
    }

    /// Returns the times of the keys in seconds, ascending; at least one.
    pub fn times(&self) -> impl Iterator<Item = f32> {
        self.keys.iter().map(|key| key.0)
    }

    /// Returns the value at `time_s`.
    pub fn at(&self, time_s: f32) -> T {
        let after = self.keys.partition_point(|key| key.0 <= time_s);
        if after == 0 {
            return self.keys[0].1;
        }
        let (start_s, start) = self.keys[after - 1];
        let Some((end_s, end)) = self.keys.get(after).copied() else { return start };
        let h = end_s - start_s;
        let u = (time_s - start_s) / h;
        let (u2, u3) = (u * u, u * u * u);
        let way = end - start;
        // The sum starts from the first key, so that a constant value has no rounding error.
        start
            + way * (3.0 * u2 - 2.0 * u3)
            + self.tangent(after - 1) * (h * (u3 - 2.0 * u2 + u))
            + self.tangent(after) * (h * (u3 - u2))
    }

    /// Returns the change per second at key `i`.
    fn tangent(&self, i: usize) -> T {
        let slope = |k: usize| {
            let ((start_s, start), (end_s, end)) = (self.keys[k], self.keys[k + 1]);
            (end_s - start_s, (end - start) * (1.0 / (end_s - start_s)))
        };
        let (before, after) = ((i > 0).then(|| slope(i - 1)), (i + 1 < self.keys.len()).then(|| slope(i)));
        let nothing = T::default();
        match (before, after) {
            (Some((_, a)), Some((_, b))) if a == nothing || b == nothing => nothing,
            (Some((h, a)), Some((k, b))) => (a * k + b * h) * (1.0 / (h + k)),
            (Some((_, one)), None) | (None, Some((_, one))) => one,
            (None, None) => nothing,
        }
    }

    /// Returns the change per second at `u`, 0..=1, between key `i` and the next.
    fn rate(&self, i: usize, u: f32) -> T {
        let ((start_s, start), (end_s, end)) = (self.keys[i], self.keys[i + 1]);
        let way = (end - start) * (6.0 * (u - u * u) / (end_s - start_s));
        way + self.tangent(i) * (3.0 * u * u - 4.0 * u + 1.0) + self.tangent(i + 1) * (3.0 * u * u - 2.0 * u)
    }
}

impl Track<Vec3> {
    /// Returns the horizontal unit direction of movement at `time_s`. During a hold it is the direction before, or else
    /// the one after. `None` for a track that only moves vertically or not at all.
    pub fn direction(&self, time_s: f32) -> Option<Vec3> {
        let segments = self.keys.len() - 1;
        let level = |(i, u)| (self.rate(i, u) * Vec3::new(1.0, 0.0, 1.0)).try_normalize();
        // The speed at the end of a segment may be 0, so the direction is taken just inside it.
        let (in_, out) = (1e-3, 1.0 - 1e-3);
        let here = self.keys.partition_point(|key| key.0 <= time_s).saturating_sub(1);
        let now = (here < segments).then(|| {
            let (start_s, end_s) = (self.keys[here].0, self.keys[here + 1].0);
            let u = ((time_s - start_s) / (end_s - start_s)).clamp(0.0, 1.0);
            [(here, u), (here, u.clamp(in_, out))]
        });
        let came = (0..here).rev().map(|i| (i, out));
        let leaves = (here..segments).map(|i| (i, in_));
        now.into_iter().flatten().chain(came).chain(leaves).find_map(level)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn track(keys: &[(f32, f32)]) -> Track<f32> {
        Track::new(keys.to_vec()).unwrap()
    }

    fn walk(keys: &[(f32, [f32; 3])]) -> Track<Vec3> {
        Track::new(keys.iter().map(|(t, p)| (*t, Vec3::from(*p))).collect()).unwrap()
    }

    #[test]
    fn track_passes_through_its_keys_and_holds_beyond_them() {
        let keys = [(-1.0, 3.0), (0.5, 7.0), (0.75, -2.0), (4.0, 5.5)];
        let track = track(&keys);
        assert!(keys.iter().all(|(t, x)| track.at(*t) == *x));
        assert_eq!((track.at(-9.0), track.at(99.0)), (3.0, 5.5));
        assert_eq!(Track::fixed(2.0).at(7.0), 2.0);
    }

    #[test]
    fn evenly_spaced_keys_give_catmull_roms_curve() {
        // Polynomial between the two middle keys, from the basis matrix of Catmull and Rom.
        let [a, b, c, d] = [1.0_f32, 4.0, -2.0, 0.5];
        let track = track(&[(0.0, a), (2.0, b), (4.0, c), (6.0, d)]);
        for u in [0.1_f32, 0.25, 0.5, 0.9] {
            let expected = 0.5
                * (2.0 * b
                    + (c - a) * u
                    + (2.0 * a - 5.0 * b + 4.0 * c - d) * u * u
                    + (3.0 * b - a - 3.0 * c + d) * u * u * u);
            assert!((track.at(2.0 + 2.0 * u) - expected).abs() < 1e-5, "{u}");
        }
    }

    #[test]
    fn unevenly_spaced_keys_reproduce_a_parabola() {
        let parabola = |t: f32| 1.0 - 2.0 * t + 0.75 * t * t;
        let track = track(&[-1.0, 0.0, 0.5, 2.0, 3.0].map(|t| (t, parabola(t))));
        // The outermost segments are skipped: at their outer ends the tangent has no third key.
        for t in [0.1, 0.4, 0.7, 1.2, 1.9] {
            assert!((track.at(t) - parabola(t)).abs() < 1e-5, "{t}: {}", track.at(t));
        }
    }

    #[test]
    fn track_speed_is_continuous() {
        let track = track(&[(0.0, 0.0), (1.0, 3.0), (1.5, 2.0), (4.0, 2.5)]);
        for t in [1.0_f32, 1.5] {
            let (before, after) = (track.at(t) - track.at(t - 1e-3), track.at(t + 1e-3) - track.at(t));
            assert!((before - after).abs() < 3e-5, "{t}: {before} and {after}");
        }
        let i = (0..3).map(|i| (track.rate(i, 1.0), track.rate((i + 1).min(2), 0.0))).collect::<Vec<_>>();
        assert!(i[..2].iter().all(|(end, start)| (end - start).abs() < 1e-5), "{i:?}");
    }

    #[test]
    fn keys_with_equal_values_hold_the_value() {
        let track = track(&[(0.0, 0.0), (1.0, 5.0), (2.0, 5.0), (3.0, 9.0)]);
        let all = |from: f32, to: f32, holds: &dyn Fn(f32) -> bool| {
            (0..=100).all(|i| holds(track.at(from + (to - from) * i as f32 / 100.0)))
        };
        assert!(all(1.0, 2.0, &|x| x == 5.0), "the held value must be constant to the last bit");
        assert!(
            all(0.0, 1.0, &|x| x <= 5.0) && all(2.0, 3.0, &|x| x >= 5.0),
            "the curve must not overshoot the held value"
        );
    }

    #[test]
    fn key_times_must_ascend() {
        let new = |times: &[f32]| Track::new(times.iter().map(|t| (*t, 0.0)).collect()).map(|_| ());
        assert_eq!(new(&[]), Err(0));
        assert_eq!(new(&[5.0]), Ok(()));
        assert_eq!(new(&[0.0, 1.0, 0.5, 2.0]), Err(2));
        assert_eq!(new(&[0.0, 0.0]), Err(1));
        assert_eq!(new(&[0.0, f32::NAN, 1.0]), Err(1));
    }

    #[test]
    fn track_direction_follows_the_path() {
        let l = walk(&[(0.0, [0.0, 0.0, 0.0]), (1.0, [0.0, 0.0, 2.0]), (2.0, [0.0, 0.5, 2.0]), (3.0, [4.0, 0.0, 2.0])]);
        let near = |t: f32, expected: Vec3| {
            let found = l.direction(t).unwrap();
            assert!(found.distance(expected) < 1e-2, "{t}: {found}");
        };
        near(-5.0, Vec3::Z);
        near(0.0, Vec3::Z);
        near(0.5, Vec3::Z);
        near(2.9, Vec3::X);
        near(50.0, Vec3::X);
        let stops = walk(&[(0.0, [0.0; 3]), (1.0, [0.0; 3]), (2.0, [1.0, 0.0, 0.0]), (3.0, [1.0, 0.0, 0.0])]);
        // The track moves along x before and after the hold.
        for t in [0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 9.0] {
            assert!(stops.direction(t).unwrap().distance(Vec3::X) < 1e-6, "{t}");
        }
        assert_eq!(walk(&[(0.0, [0.0; 3]), (1.0, [0.0, 3.0, 0.0])]).direction(0.5), None);
        assert_eq!(Track::fixed(Vec3::ONE).direction(0.0), None);
    }
}
