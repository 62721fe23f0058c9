//! Distance between drawn lines and true lines.
//!
//! Precision is the fraction of drawn pixels near a true line. Recall is the fraction of the true lines' pixels near a
//! drawn one (Rijsbergen 1979). Near means within a number of pixels, measured exactly from centre to centre. A drawn
//! line is represented by its centre pixels: pass the detected features if known, else [`Mask::core`] of the ink.
//! Otherwise, a stroke that is meant to be wide would have an error of half its width.

use crate::mask::{Mask, Stroke};
use crate::truth::{LineKind, VisibleLines};
use pelage_import::BakeError;

/// Largest distance at which a drawn line still matches a true one, pixels.
pub const NEAR_PX: f64 = 2.0;

/// Agreement of drawn lines with the true lines.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LineFigures {
    /// Fraction of the drawn pixels that are near a true line, 0..=1; `None` if nothing is drawn.
    pub precision: Option<f64>,
    /// Fraction of the true lines' pixels that are near a drawn one, 0..=1; `None` without true lines.
    pub recall: Option<f64>,
    /// Number of drawn pixels.
    pub drawn: usize,
    /// Number of pixels of true lines.
    pub truth: usize,
}

impl LineFigures {
    /// Returns the harmonic mean of precision and recall, 0..=1: 0 if either is 0 or missing, 1 if both are missing.
    pub fn f1(&self) -> f64 {
        match (self.precision, self.recall) {
            (Some(p), Some(r)) if p + r > 0.0 => 2.0 * p * r / (p + r),
            (None, None) => 1.0,
            _ => 0.0,
        }
    }
}

/// Compares drawn lines with true ones. Pixels at most `near_px` apart are near; [`NEAR_PX`] is the usual value.
///
/// # Errors
///
/// [`BakeError::Params`] if the sizes differ, or `near_px` is negative or NaN.
pub fn compare_lines(drawn: &Mask, truth: &Mask, near_px: f64) -> Result<LineFigures, BakeError> {
    drawn.same_size(truth)?;
    if near_px.is_nan() || near_px < 0.0 {
        return Err(BakeError::Params { what: "near_px", reason: format!("is {near_px}, expected 0 or more pixels") });
    }
    let (precision, drawn_pixels) = share_near(drawn, truth, near_px);
    let (recall, true_pixels) = share_near(truth, drawn, near_px);
    Ok(LineFigures { precision, recall, drawn: drawn_pixels, truth: true_pixels })
}

/// Measures of a drawing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LineMeasures {
    /// Comparison with all true lines, within [`NEAR_PX`].
    pub lines: LineFigures,
    /// Recall of each kind of line, in the order of [`LineKind::ALL`]; `None` for kinds that the truth lacks.
    pub recall: [Option<f64>; 4],
    /// Widest stroke.
    pub stroke: Stroke,
}

/// Measures a drawing against the lines of its model.
///
/// * `features`: pixels where the drawing found lines, of any width; their [`Mask::core`] is compared
/// * `ink`: pixels that are drawn as ink
///
/// # Errors
///
/// [`BakeError::Params`] if the sizes differ.
pub fn measure_lines(features: &Mask, ink: &Mask, truth: &VisibleLines) -> Result<LineMeasures, BakeError> {
    features.same_size(ink)?;
    let core = features.core();
    let lines = compare_lines(&core, &truth.mask(&LineKind::ALL), NEAR_PX)?;
    let mut recall = [None; 4];
    for (recall, kind) in recall.iter_mut().zip(LineKind::ALL) {
        *recall = share_near(&truth.mask(&[kind]), &core, NEAR_PX).0;
    }
    Ok(LineMeasures { lines, recall, stroke: ink.widest_stroke() })
}

/// Returns the fraction of the pixels of `of` that are within `near_px` of a pixel of `to`, and the number of pixels of
/// `of`.
fn share_near(of: &Mask, to: &Mask, near_px: f64) -> (Option<f64>, usize) {
    let (mut near, mut all) = (0usize, 0usize);
    for (_, distance) in of.pixels.iter().zip(to.distances()).filter(|(set, _)| **set) {
        all += 1;
        // Distances are square roots of integers; the tolerance covers the rounding of the root.
        near += usize::from(distance <= near_px + 1e-9);
    }
    ((all > 0).then(|| near as f64 / all as f64), all)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;

    fn upright(x0: u32, width: u32) -> Mask {
        Mask::from_fn(40, 30, |x, _| (x0..x0 + width).contains(&x))
    }

    #[test]
    fn lines_match_only_within_the_tolerance() {
        for (apart, expected) in [(0, 1.0), (1, 1.0), (2, 1.0), (3, 0.0)] {
            let found = compare_lines(&upright(10 + apart, 1), &upright(10, 1), NEAR_PX).unwrap();
            assert_eq!((found.precision, found.recall, found.f1()), (Some(expected), Some(expected), expected));
            assert_eq!((found.drawn, found.truth), (30, 30));
        }
        // A pixel two columns and one row away is farther than two pixels.
        let dot = |x: i64, y: i64| {
            let mut mask = Mask::empty(9, 9);
            mask.insert(x, y);
            mask
        };
        assert_eq!(compare_lines(&dot(4, 4), &dot(6, 5), NEAR_PX).unwrap().precision, Some(0.0));
        assert_eq!(compare_lines(&dot(4, 4), &dot(5, 5), NEAR_PX).unwrap().precision, Some(1.0));
    }

    #[test]
    fn surplus_lines_lower_precision_and_missing_lines_lower_recall() {
        let twice = upright(10, 1).union(&upright(30, 1)).unwrap();
        let found = compare_lines(&twice, &upright(10, 1), NEAR_PX).unwrap();
        assert_eq!((found.precision, found.recall), (Some(0.5), Some(1.0)));
        assert!((found.f1() - 2.0 / 3.0).abs() < 1e-12);
        let found = compare_lines(&upright(10, 1), &twice, NEAR_PX).unwrap();
        assert_eq!((found.precision, found.recall), (Some(1.0), Some(0.5)));
        // The core of a wide stroke matches the true line, but not all pixels of the stroke do.
        let wide = upright(7, 7);
        let core = compare_lines(&wide.core(), &upright(10, 1), NEAR_PX).unwrap();
        // The core ends a pixel or two before the stroke does.
        assert!(core.precision == Some(1.0) && core.recall.unwrap() > 0.9, "{core:?}");
        assert!(compare_lines(&wide, &upright(10, 1), NEAR_PX).unwrap().precision.unwrap() < 0.8);
    }

    #[test]
    fn line_kinds_are_measured_separately() {
        use crate::truth::LineSegment;
        use glam::DVec2;
        let upright_at = |x: f64, kind| LineSegment { from_px: DVec2::new(x, 0.5), to_px: DVec2::new(x, 29.5), kind };
        let segments = vec![upright_at(10.5, LineKind::Silhouette), upright_at(30.5, LineKind::Crease)];
        let truth = VisibleLines { width: 40, height: 30, segments };
        let found = measure_lines(&upright(10, 1), &upright(8, 5), &truth).unwrap();
        assert_eq!(found.recall, [Some(1.0), None, Some(0.0), None]);
        assert_eq!((found.lines.precision, found.lines.recall), (Some(1.0), Some(0.5)));
        assert_eq!(found.stroke.width_px, 5.0);
        assert!(measure_lines(&upright(10, 1), &Mask::empty(3, 3), &truth).is_err());
    }

    #[test]
    fn empty_masks_have_no_precision_or_recall() {
        let (none, some) = (Mask::empty(40, 30), upright(3, 1));
        let found = compare_lines(&none, &some, NEAR_PX).unwrap();
        assert_eq!((found.precision, found.recall, found.f1()), (None, Some(0.0), 0.0));
        assert_eq!(compare_lines(&some, &none, NEAR_PX).unwrap().f1(), 0.0);
        assert_eq!(compare_lines(&none, &none, NEAR_PX).unwrap().f1(), 1.0);
        assert!(compare_lines(&none, &Mask::empty(3, 3), NEAR_PX).is_err());
        for near_px in [-1.0, f64::NAN] {
            assert!(compare_lines(&none, &some, near_px).is_err_and(|e| e.to_string().contains("near_px")));
        }
    }
}
