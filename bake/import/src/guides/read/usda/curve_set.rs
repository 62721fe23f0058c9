//! Contents of a prim of type `BasisCurves`, and their conversion to strands.

use super::curves::{Basis, CurveKind, Value, Wrap};
use crate::guides::Guides;
use glam::{DMat4, Vec3};

/// Maximum number of points of all strands.
const MOST_POINTS: usize = 1 << 25;

/// Curves of a prim, as in the file.
#[derive(Default)]
pub(super) struct CurveSet<'a> {
    pub(super) name: &'a str,
    /// Number of points of each curve.
    pub(super) counts: Vec<u32>,
    /// Coordinates of the points, three per point.
    pub(super) points: Vec<f32>,
    /// Diameters: one for all, or one per curve, end of a segment, or point.
    pub(super) widths: Vec<f32>,
    /// Linear RGB, three numbers each, spread like the widths.
    pub(super) colors: Vec<f32>,
    pub(super) has_palette: bool,
    kind: Option<&'a str>,
    basis: Option<&'a str>,
    wrap: Option<&'a str>,
}

struct Curve {
    /// Index of the curve in its prim.
    number: usize,
    kind: CurveKind,
    segments: usize,
    /// Control points of the curve.
    points: std::ops::Range<usize>,
    /// Index of the first value that is given at the ends of segments.
    first_end: usize,
}

impl<'a> CurveSet<'a> {
    pub(super) fn new(name: &'a str) -> Self {
        Self { name, ..Self::default() }
    }

    pub(super) fn set_token(&mut self, name: &str, text: &'a str) {
        match name {
            "type" => self.kind = Some(text),
            "basis" => self.basis = Some(text),
            "wrap" => self.wrap = Some(text),
            _ => {}
        }
    }

    /// Returns the kind of the curves, and a warning about an unknown one.
    fn kind(&self) -> (CurveKind, Option<String>) {
        let wrap = match self.wrap {
            Some("periodic") => Wrap::Periodic,
            Some("pinned") => Wrap::Pinned,
            _ => Wrap::Nonperiodic,
        };
        let basis = match (self.kind.unwrap_or("cubic"), self.basis.unwrap_or("bezier")) {
            ("linear", _) => Some(Basis::Linear),
            ("cubic", "bezier") => Some(Basis::Bezier),
            ("cubic", "bspline") => Some(Basis::BSpline),
            ("cubic", "catmullRom") => Some(Basis::CatmullRom),
            _ => None,
        };
        let warning = basis.is_none().then(|| {
            let [kind, basis] = [self.kind, self.basis].map(Option::unwrap_or_default);
            format!("prim {:?}: type {kind:?} with basis {basis:?} is read as straight lines", self.name)
        });
        (CurveKind { basis: basis.unwrap_or(Basis::Linear), wrap }, warning)
    }

    /// Adds the curves to `guides`, transformed by `matrix`.
    ///
    /// Fails with the reason, if the numbers of points disagree, or if there are too many.
    pub(super) fn push_to(&self, guides: &mut Guides, matrix: &DMat4) -> Result<(), String> {
        let (kind, warning) = self.kind();
        guides.warnings.extend(warning);
        let points = triples(&self.points);
        let sum: u64 = self.counts.iter().copied().map(u64::from).sum();
        if sum != points.len() as u64 {
            return Err(format!("{} points, expected {sum}, the sum of curveVertexCounts", points.len()));
        }
        let (mut curves, mut first, mut first_end, mut unsuited) = (Vec::new(), 0, 0, 0_usize);
        let mut count = guides.points.len();
        for (number, points) in self.counts.iter().map(|count| *count as usize).enumerate() {
            let straight = CurveKind { basis: Basis::Linear, wrap: Wrap::Nonperiodic };
            let (kind, segments) = match kind.segments(points) {
                Some(segments) => (kind, segments),
                None => {
                    unsuited += usize::from(points > 1);
                    (straight, points.saturating_sub(1))
                }
            };
            count = count.saturating_add(kind.polyline_points(segments));
            curves.push(Curve { number, kind, segments, points: first..first + points, first_end });
            first += points;
            first_end += segments + usize::from(kind.wrap != Wrap::Periodic);
        }
        if count > MOST_POINTS {
            return Err(format!("{count} points on all curves, expected at most {MOST_POINTS}"));
        }
        let places: Vec<Vec3> = points.iter().map(|p| matrix.transform_point3(p.as_dvec3()).as_vec3()).collect();
        let scale = libm::cbrt(matrix.determinant().abs()) as f32;
        let radii: Vec<f32> = self.widths.iter().map(|width| 0.5 * scale * width).collect();
        let colors = if self.has_palette { Vec::new() } else { triples(&self.colors) };
        let layout = Layout { curves: self.counts.len(), points: points.len(), ends: first_end };
        for curve in &curves {
            if curve.segments == 0 {
                guides.push(&places[curve.points.clone()], &[], &[]);
                continue;
            }
            let strand = curve.kind.polyline(&places[curve.points.clone()], curve.segments);
            guides.push(&strand, &layout.along(curve, &radii), &layout.along(curve, &colors));
        }
        if unsuited > 0 {
            guides.warnings.push(format!(
                "prim {:?}: {unsuited} curves have numbers of points that do not suit their basis, and are read as \
                 straight lines between their points",
                self.name
            ));
        }
        Ok(())
    }
}

/// Numbers of items of a prim. They determine how a list of values is spread.
struct Layout {
    curves: usize,
    points: usize,
    /// Number of ends of segments.
    ends: usize,
}

impl Layout {
    /// Returns the values along a curve's polyline; empty if their number suits nothing.
    fn along<T: Value>(&self, curve: &Curve, values: &[T]) -> Vec<T> {
        let count = curve.kind.polyline_points(curve.segments);
        match values.len() {
            0 => Vec::new(),
            n if n == self.points => curve.kind.polyline(&values[curve.points.clone()], curve.segments),
            n if n == self.ends => {
                let ends = curve.segments + usize::from(curve.kind.wrap != Wrap::Periodic);
                curve.kind.varying(&values[curve.first_end..curve.first_end + ends], curve.segments)
            }
            n if n == self.curves => vec![values[curve.number]; count],
            1 => vec![values[0]; count],
            _ => Vec::new(),
        }
    }
}

fn triples(numbers: &[f32]) -> Vec<Vec3> {
    numbers.chunks_exact(3).map(|n| Vec3::new(n[0], n[1], n[2])).collect()
}
