//! Evaluation of curves to polylines.
//!
//! <https://openusd.org/release/api/class_usd_geom_basis_curves.html>

use std::ops::{Add, Mul, Sub};

/// Number of pieces of the polyline per segment of a cubic curve.
const PIECES: usize = 4;

/// Polynomials that weight the control points of a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Basis {
    Linear,
    Bezier,
    BSpline,
    CatmullRom,
}

/// Continuation of a curve beyond its first and last control point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) enum Wrap {
    #[default]
    Nonperiodic,
    Periodic,
    /// The curve begins and ends at its first and last control point.
    Pinned,
}

/// Values that are interpolated along a curve.
pub(super) trait Value: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<f32, Output = Self> {}

impl<T: Copy + Add<Output = T> + Sub<Output = T> + Mul<f32, Output = T>> Value for T {}

/// Kind of the curves of a prim.
#[derive(Clone, Copy, Debug)]
pub(super) struct CurveKind {
    pub(super) basis: Basis,
    pub(super) wrap: Wrap,
}

impl CurveKind {
    /// Returns the number of segments of a curve of `count` points; `None` if the count does not suit the basis.
    pub(super) fn segments(self, count: usize) -> Option<usize> {
        let periodic = self.wrap == Wrap::Periodic;
        let segments = match self.basis {
            Basis::Linear => (count + usize::from(periodic)).saturating_sub(1),
            Basis::Bezier if periodic => count.is_multiple_of(3).then_some(count / 3)?,
            Basis::Bezier => (count % 3 == 1).then_some(count / 3)?,
            Basis::BSpline | Basis::CatmullRom => match self.wrap {
                Wrap::Nonperiodic => count.saturating_sub(3),
                Wrap::Periodic if count > 2 => count,
                Wrap::Periodic => 0,
                Wrap::Pinned => count.saturating_sub(1),
            },
        };
        (segments > 0).then_some(segments)
    }

    pub(super) fn polyline_points(self, segments: usize) -> usize {
        self.pieces() * segments + 1
    }

    fn pieces(self) -> usize {
        if self.basis == Basis::Linear { 1 } else { PIECES }
    }

    /// Evaluates a curve whose control points have these values. Their number must suit the basis.
    pub(super) fn polyline<T: Value>(self, controls: &[T], segments: usize) -> Vec<T> {
        let (step, count) = (if self.basis == Basis::Bezier { 3 } else { 1 }, controls.len());
        let is_spline = matches!(self.basis, Basis::BSpline | Basis::CatmullRom);
        let mut all = Vec::with_capacity(count + 3);
        // Pinned curves have one more control point at each end, mirrored at the end.
        let mirrored = |end: usize, inner: usize| controls[end] + (controls[end] - controls[inner]);
        let pinned = (self.wrap == Wrap::Pinned && is_spline).then(|| [mirrored(0, 1), mirrored(count - 1, count - 2)]);
        all.extend(pinned.map(|[first, _]| first));
        all.extend_from_slice(controls);
        match pinned {
            Some([_, last]) => all.push(last),
            None => all.extend(controls.iter().copied().cycle().take(3)),
        }
        let place = |i: usize| {
            let (segment, t) = self.place(i, segments);
            let at = step * segment;
            match self.weights(t) {
                None => all[at + t as usize],
                Some([a, b, c, d]) => all[at] * a + all[at + 1] * b + all[at + 2] * c + all[at + 3] * d,
            }
        };
        (0..self.polyline_points(segments)).map(place).collect()
    }

    /// Returns the segment of a point of the polyline, and the point's share of that segment.
    fn place(self, point: usize, segments: usize) -> (usize, f32) {
        let segment = (point / self.pieces()).min(segments - 1);
        (segment, (point - self.pieces() * segment) as f32 / self.pieces() as f32)
    }

    /// Returns the weights of the four control points at the share `t` of a segment; `None` for straight lines.
    fn weights(self, t: f32) -> Option<[f32; 4]> {
        let (u, t2, t3) = (1.0 - t, t * t, t * t * t);
        Some(match self.basis {
            Basis::Linear => return None,
            Basis::Bezier => [u * u * u, 3.0 * t * u * u, 3.0 * t2 * u, t3],
            Basis::BSpline => {
                let weights = [u * u * u, 3.0 * t3 - 6.0 * t2 + 4.0, 3.0 * (t + t2 - t3) + 1.0, t3];
                weights.map(|weight| weight / 6.0)
            }
            Basis::CatmullRom => {
                let weights = [2.0 * t2 - t3 - t, 3.0 * t3 - 5.0 * t2 + 2.0, 4.0 * t2 - 3.0 * t3 + t, t3 - t2];
                weights.map(|weight| weight / 2.0)
            }
        })
    }

    /// Spreads values that are given at the ends of the segments over the polyline.
    pub(super) fn varying<T: Value>(self, ends: &[T], segments: usize) -> Vec<T> {
        let place = |i: usize| {
            let (segment, t) = self.place(i, segments);
            let [from, to] = [segment, segment + 1].map(|end| ends[end % ends.len()]);
            from * (1.0 - t) + to * t
        };
        (0..self.polyline_points(segments)).map(place).collect()
    }
}
