//! Strands as curves in world space: polylines with a radius.

use glam::{DVec3, Vec3};

/// A point of a strand.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CurvePoint {
    /// World space, metres.
    pub position_ws: Vec3,
    /// Metres.
    pub radius_m: f32,
    /// Linear RGB.
    pub color: Vec3,
    /// Share of the fur's height: 0 on the skin, 1 where the outermost layer lies.
    pub height: f32,
    /// Unit normal of the skin under it.
    pub normal_ws: Vec3,
}

/// Many strands.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curves {
    /// Points of all strands, each root first.
    pub points: Vec<CurvePoint>,
    /// Strand `i` is `offsets[i]..offsets[i + 1]`; one entry more than strands, or none.
    pub offsets: Vec<u32>,
    /// One per strand: whether it is wet.
    pub wet: Vec<bool>,
}

impl Curves {
    /// Number of strands.
    pub fn len(&self) -> usize {
        self.wet.len()
    }

    /// Whether there is no strand.
    pub fn is_empty(&self) -> bool {
        self.wet.is_empty()
    }

    /// Number of straight pieces.
    pub fn segments(&self) -> usize {
        self.points.len() - self.len()
    }

    /// Points of a strand, root first.
    pub fn strand(&self, index: usize) -> &[CurvePoint] {
        &self.points[self.offsets[index] as usize..self.offsets[index + 1] as usize]
    }

    /// Adds a strand; one of fewer than two points is left out.
    pub fn push(&mut self, points: &[CurvePoint], wet: bool) {
        if points.len() < 2 {
            return;
        }
        if self.offsets.is_empty() {
            self.offsets.push(0);
        }
        self.points.extend_from_slice(points);
        self.offsets.push(self.points.len() as u32);
        self.wet.push(wet);
    }

    /// Every `step`-th strand, the first of them first; `step` 0 counts as 1.
    pub fn every(&self, step: usize) -> Self {
        let mut out = Self::default();
        (0..self.len()).step_by(step.max(1)).for_each(|i| out.push(self.strand(i), self.wet[i]));
        out
    }

    /// Adds all strands of another list.
    pub fn append(&mut self, other: &Self) {
        (0..other.len()).for_each(|i| self.push(other.strand(i), other.wet[i]));
    }
}

/// Leaves out points that lie on the line between those that stay, within `tolerance` of the strand's radius there (Ramer 1972; Douglas and
/// Peucker 1973). The ends stay.
pub fn simplified(points: &[CurvePoint], tolerance: f64) -> Vec<CurvePoint> {
    let Some(last) = points.len().checked_sub(1) else { return Vec::new() };
    let mut stays = vec![false; points.len()];
    (stays[0], stays[last]) = (true, true);
    let mut open = vec![(0, last)];
    while let Some((from, to)) = open.pop() {
        let (a, b) = (points[from].position_ws.as_dvec3(), points[to].position_ws.as_dvec3());
        let mut farthest = (1.0, None);
        for (i, point) in points.iter().enumerate().take(to).skip(from + 1) {
            // A tip may end in a point: there the radius at the chord's thicker end counts.
            let radius = points[from].radius_m.max(points[to].radius_m);
            let excess = distance_to_segment(point.position_ws.as_dvec3(), a, b) / (tolerance * f64::from(radius));
            if excess > farthest.0 {
                farthest = (excess, Some(i));
            }
        }
        if let Some(middle) = farthest.1 {
            stays[middle] = true;
            open.extend([(from, middle), (middle, to)]);
        }
    }
    points.iter().zip(stays).filter(|(_, stays)| *stays).map(|(point, _)| *point).collect()
}

fn distance_to_segment(p: DVec3, a: DVec3, b: DVec3) -> f64 {
    let along = b - a;
    let share = (p - a).dot(along) / along.length_squared();
    p.distance(a + along * if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.0 })
}
