//! Error statistics of values compared with their truth.

/// Sums over pairs of a value and its truth.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Errors {
    count: u64,
    sum: f64,
    squares: f64,
    off: u64,
}

/// Threshold from which an error counts as large: roughly a visible difference in shade.
pub const OFF: f64 = 0.1;

impl Errors {
    /// Sums up pairs of (value, truth).
    pub fn of(pairs: impl IntoIterator<Item = (f64, f64)>) -> Self {
        let mut errors = Self::default();
        for (value, truth) in pairs {
            let error = value - truth;
            errors.count += 1;
            errors.sum += error;
            errors.squares += error * error;
            // NaN counts as an error above the threshold.
            errors.off += u64::from(error.abs().partial_cmp(&OFF) != Some(std::cmp::Ordering::Less));
        }
        errors
    }

    /// Returns the sums over the pairs of `self` and `other`.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            count: self.count + other.count,
            sum: self.sum + other.sum,
            squares: self.squares + other.squares,
            off: self.off + other.off,
        }
    }

    /// Returns the root mean square error; `None` without pairs.
    pub fn rmse(&self) -> Option<f64> {
        self.mean_of(self.squares).map(f64::sqrt)
    }

    /// Returns the mean of value − truth.
    pub fn mean(&self) -> Option<f64> {
        self.mean_of(self.sum)
    }

    /// Returns the fraction of pairs that differ by [`OFF`] or more, 0..=1.
    pub fn large_error_fraction(&self) -> Option<f64> {
        self.mean_of(self.off as f64)
    }

    fn mean_of(&self, sum: f64) -> Option<f64> {
        (self.count > 0).then(|| sum / self.count as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_summed() {
        let errors = Errors::of([(1.0, 0.5), (0.0, 0.5)]);
        assert_eq!((errors.rmse(), errors.mean(), errors.large_error_fraction()), (Some(0.5), Some(0.0), Some(1.0)));
        let errors = errors.and(Errors::of([(0.25, 0.25), (0.25, 0.25)]));
        assert_eq!((errors.rmse(), errors.large_error_fraction()), (Some(0.125f64.sqrt()), Some(0.5)));
        assert_eq!(Errors::of([]).rmse(), None);
        let broken = Errors::of([(f64::NAN, 0.0)]);
        assert!(broken.rmse().is_some_and(f64::is_nan) && broken.large_error_fraction() == Some(1.0));
    }
}
