//! Strands as curves in world space: polylines with a radius.

use glam::{DVec3, Vec2, Vec3};
use std::ops::Range;

/// Name of the group that the tile's strands make.
pub const COAT: &str = "coat";
/// Name of a group that nobody named.
const UNNAMED: &str = "strands";

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

/// Strands that follow each other and have a name in common.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CurveGroup {
    /// Name, as [`Curves::begin_group`] got it.
    pub name: String,
    /// Its strands.
    pub strands: Range<u32>,
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
    /// One per strand: the skin's own texture coordinates at its root, as glTF counts them, v downwards from the image's first row.
    pub root_uv: Vec<Vec2>,
    /// Each begins where the one before it ends; only the last may be empty.
    groups: Vec<CurveGroup>,
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

    /// Points of all strands of a group.
    pub fn points_of(&self, group: &CurveGroup) -> &[CurvePoint] {
        &self.points
            [self.offsets[group.strands.start as usize] as usize..self.offsets[group.strands.end as usize] as usize]
    }

    /// The named groups: none is empty, each begins where the one before it ends, and together they are all strands.
    pub fn groups(&self) -> &[CurveGroup] {
        match self.groups.split_last() {
            Some((last, before)) if last.strands.is_empty() => before,
            _ => &self.groups,
        }
    }

    /// Strands that are added from now on belong to a group of that name: to the last one where it has that name, else to a new one. A group that
    /// gets no strand vanishes. Without a call strands are in a group named `strands`.
    pub fn begin_group(&mut self, name: &str) {
        let end = self.len() as u32;
        self.groups.truncate(self.groups().len());
        if self.groups.last().is_none_or(|last| last.name != name) {
            self.groups.push(CurveGroup { name: name.to_owned(), strands: end..end });
        }
    }

    /// Adds a strand; one of fewer than two points is left out.
    ///
    /// * `root_uv`: as [`Curves::root_uv`] has it
    pub fn push(&mut self, points: &[CurvePoint], wet: bool, root_uv: Vec2) {
        if points.len() < 2 {
            return;
        }
        if self.offsets.is_empty() {
            self.offsets.push(0);
        }
        if self.groups.is_empty() {
            self.begin_group(UNNAMED);
        }
        self.points.extend_from_slice(points);
        self.offsets.push(self.points.len() as u32);
        self.wet.push(wet);
        self.root_uv.push(root_uv);
        if let Some(group) = self.groups.last_mut() {
            group.strands.end = self.wet.len() as u32;
        }
    }

    /// Every `step`-th strand, the first of them first; `step` 0 counts as 1. Strands keep their groups.
    pub fn every(&self, step: usize) -> Self {
        self.chosen(&mut |_, i| i.is_multiple_of(step.max(1)))
    }

    /// The groups of those names, with all their strands.
    pub fn only(&self, names: &[&str]) -> Self {
        self.chosen(&mut |group, _| names.contains(&group.name.as_str()))
    }

    fn chosen(&self, is_chosen: &mut dyn FnMut(&CurveGroup, usize) -> bool) -> Self {
        let mut out = Self::default();
        for group in self.groups() {
            out.begin_group(&group.name);
            for i in group.strands.start as usize..group.strands.end as usize {
                if is_chosen(group, i) {
                    out.push(self.strand(i), self.wet[i], self.root_uv[i]);
                }
            }
        }
        out.groups.truncate(out.groups().len());
        out
    }

    /// Adds all strands of another list with their groups; its first group goes on with our last one where both have the same name.
    pub fn append(&mut self, other: &Self) {
        for group in other.groups() {
            self.begin_group(&group.name);
            for i in group.strands.start as usize..group.strands.end as usize {
                self.push(other.strand(i), other.wet[i], other.root_uv[i]);
            }
        }
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

#[cfg(test)]
#[path = "curves_tests.rs"]
mod tests;
