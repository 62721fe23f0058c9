//! Axis ranges and ticks for plots.

use std::ops::Range;

/// Range of an axis. It is logarithmic if the values span more than one decade, else linear from zero.
#[derive(Clone, Debug, PartialEq)]
pub struct Scale {
    /// Whether the axis is logarithmic.
    pub log: bool,
    /// Values at the two ends of the axis.
    pub range: Range<f64>,
}

/// Ticks of an axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ticks {
    /// Ticks with a line and a number.
    pub major: Vec<f64>,
    /// Ticks with a fainter line and no number, at the other values within a decade.
    pub minor: Vec<f64>,
}

impl Scale {
    /// Returns the scale for `values`, ignoring those that are negative or not finite.
    pub fn of(values: impl Iterator<Item = f64>) -> Self {
        let (mut low, mut high) = (f64::INFINITY, 0.0_f64);
        for value in values.filter(|v| v.is_finite() && *v >= 0.0) {
            low = low.min(value);
            high = high.max(value);
        }
        if low > 0.0 && high > 10.0 * low {
            return Self { log: true, range: low / 1.4..high * 1.4 };
        }
        Self { log: false, range: 0.0..if high > 0.0 { 1.08 * high } else { 1.0 } }
    }

    /// Returns the position of a value along the axis, 0..=1.
    pub fn position(&self, value: f64) -> f64 {
        let (a, b) = (self.range.start, self.range.end);
        if self.log { (value / a).ln() / (b / a).ln() } else { (value - a) / (b - a) }
    }

    /// Returns the ticks. A logarithmic axis has ticks at 1, 2 and 5 times each power of ten, or only at the powers if
    /// its range is wide. A linear axis has ticks in round steps.
    pub fn ticks(&self) -> Ticks {
        let (a, b) = (self.range.start, self.range.end);
        if !self.log {
            let raw = (b - a) / 6.0;
            let decade = 10_f64.powf(raw.log10().floor());
            let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * decade).into_iter().find(|s| *s >= raw).unwrap_or(raw);
            return Ticks { major: (0..=(b / step) as u32).map(|i| f64::from(i) * step).collect(), minor: Vec::new() };
        }
        let decades = a.log10().floor() as i32..=b.log10().ceil() as i32;
        let of = |digits: &[f64]| -> Vec<f64> {
            let all = decades.clone().flat_map(|d| digits.iter().map(move |m| m * 10_f64.powi(d)));
            all.filter(|x| (a..=b).contains(x)).collect()
        };
        let major = of(if b > 300.0 * a { &[1.0] } else { &[1.0, 2.0, 5.0] });
        let minor = if b > 1e6 * a { Vec::new() } else { of(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]) };
        let minor = minor.into_iter().filter(|x| !major.contains(x)).collect();
        Ticks { major, minor }
    }
}

/// Formats the number at a tick: three significant digits, with the suffixes k for thousands and M for millions.
pub fn label(value: f64) -> String {
    let digits = |x: f64| format!("{x:.2e}").parse::<f64>().unwrap_or(x).to_string();
    match value.abs() {
        x if x >= 1e6 => digits(value / 1e6) + "M",
        x if x >= 1e4 => digits(value / 1e3) + "k",
        _ => digits(value),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axis_scales_contain_their_values_and_ticks() {
        for values in
            [&[0.0, 3.0][..], &[1.0, 2.0, 5.0], &[0.001, 0.5], &[1e-9, 1e6], &[0.0], &[], &[f64::INFINITY, 2.0]]
        {
            let scale = Scale::of(values.iter().copied());
            let held = values.iter().filter(|v| v.is_finite());
            assert!(held.into_iter().all(|v| (-1e-9..=1.0).contains(&scale.position(*v))), "{values:?}");
            let Ticks { major, minor } = scale.ticks();
            assert!((2..=20).contains(&major.len()), "{values:?}: {major:?}");
            assert!(
                major.iter().chain(&minor).all(|t| (-1e-9..=1.0 + 1e-9).contains(&scale.position(*t))),
                "{values:?}"
            );
            assert!(minor.iter().all(|t| !major.contains(t)), "{values:?}");
        }
    }

    #[test]
    fn axis_labels_are_short() {
        for (value, text) in [
            (0.0, "0"),
            (0.0005, "0.0005"),
            (0.30000000000000004, "0.3"),
            (2000.0, "2000"),
            (10_000.0, "10k"),
            (2.5e6, "2.5M"),
        ] {
            assert_eq!(label(value), text);
        }
    }
}
