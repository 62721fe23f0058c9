//! Strands as curves in world space: polylines with a radius.

use glam::{DVec3, Vec2, Vec3};
use std::ops::Range;

/// Name of the group for the strands of the tile.
pub const TILE_GROUP: &str = "coat";
/// Name of a group if none was begun.
const UNNAMED: &str = "strands";

/// Point of a strand.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CurvePoint {
    /// Position, world space, metres.
    pub position_ws: Vec3,
    /// Radius, metres.
    pub radius_m: f32,
    /// Colour, linear RGB.
    pub color: Vec3,
    /// Height as a share of the fur's height: 0 on the mesh surface, 1 at the outermost layer.
    pub height: f32,
    /// Unit normal of the mesh surface under the point.
    pub normal_ws: Vec3,
}

/// Consecutive strands in a named group.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CurveGroup {
    /// Name, as passed to [`Curves::begin_group`].
    pub name: String,
    /// Range of the strands in the group.
    pub strands: Range<u32>,
}

/// List of strands.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curves {
    /// Points of all strands, each from the root.
    pub points: Vec<CurvePoint>,
    /// Ranges of points: strand `i` is `offsets[i]..offsets[i + 1]`. There is one more entry than there are strands;
    /// without strands, the list may be empty.
    pub offsets: Vec<u32>,
    /// Whether each strand is wet.
    pub wet: Vec<bool>,
    /// Texture coordinates of the mesh surface at each strand's root, as in glTF: v points down from the first row of
    /// the image.
    pub root_uv: Vec<Vec2>,
    /// Groups, each starting where the previous one ends. Only the last group may be empty.
    groups: Vec<CurveGroup>,
}

impl Curves {
    /// Returns the number of strands.
    pub fn len(&self) -> usize {
        self.wet.len()
    }

    /// Returns whether there are no strands.
    pub fn is_empty(&self) -> bool {
        self.wet.is_empty()
    }

    /// Returns the number of straight segments.
    pub fn segments(&self) -> usize {
        self.points.len() - self.len()
    }

    /// Returns the points of a strand, root first.
    pub fn strand(&self, index: usize) -> &[CurvePoint] {
        &self.points[self.offsets[index] as usize..self.offsets[index + 1] as usize]
    }

    /// Returns the points of all strands of a group.
    pub fn points_of(&self, group: &CurveGroup) -> &[CurvePoint] {
        &self.points
            [self.offsets[group.strands.start as usize] as usize..self.offsets[group.strands.end as usize] as usize]
    }

    /// Returns the named groups. None is empty, each starts where the previous one ends, and together they contain all
    /// strands.
    pub fn groups(&self) -> &[CurveGroup] {
        match self.groups.split_last() {
            Some((last, before)) if last.strands.is_empty() => before,
            _ => &self.groups,
        }
    }

    /// Begins a group for all strands added from now on, or continues the last group if it has the same name. A group
    /// without strands is removed. If this method is not called, strands are in a group named `strands`.
    pub fn begin_group(&mut self, name: &str) {
        let end = self.len() as u32;
        self.groups.truncate(self.groups().len());
        if self.groups.last().is_none_or(|last| last.name != name) {
            self.groups.push(CurveGroup { name: name.to_owned(), strands: end..end });
        }
    }

    /// Adds a strand. Strands of fewer than two points are omitted.
    ///
    /// * `root_uv`: as in [`Curves::root_uv`]
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

    /// Returns every `step`-th strand, starting with the first; a `step` of 0 counts as 1. Strands keep their groups.
    pub fn every_nth(&self, step: usize) -> Self {
        self.chosen(&mut |_, i| i.is_multiple_of(step.max(1)))
    }

    /// Returns the groups with the given names, including their strands.
    pub fn only_groups(&self, names: &[&str]) -> Self {
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

    /// Appends all strands of another list with their groups. Its first group continues the last group of this list if
    /// both have the same name.
    pub fn append(&mut self, other: &Self) {
        for group in other.groups() {
            self.begin_group(&group.name);
            for i in group.strands.start as usize..group.strands.end as usize {
                self.push(other.strand(i), other.wet[i], other.root_uv[i]);
            }
        }
    }
}

/// Removes points that are on the line between the remaining ones, with a tolerance of `tolerance` times the strand's
/// radius there (Ramer 1972; Douglas and Peucker 1973). The ends are kept.
pub fn simplified(points: &[CurvePoint], tolerance: f64) -> Vec<CurvePoint> {
    let Some(last) = points.len().checked_sub(1) else { return Vec::new() };
    let mut stays = vec![false; points.len()];
    (stays[0], stays[last]) = (true, true);
    let mut open = vec![(0, last)];
    while let Some((from, to)) = open.pop() {
        let (a, b) = (points[from].position_ws.as_dvec3(), points[to].position_ws.as_dvec3());
        let mut farthest = (1.0, None);
        for (i, point) in points.iter().enumerate().take(to).skip(from + 1) {
            // The radius may be 0 at a tip, so the radius at the thicker end of the chord is used.
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
