//! Hair guides, read from files of other programs: the few strands that define the shape of hair on a scalp.

mod check;
pub mod lines;
pub mod read;

use glam::Vec3;
use std::fmt;

/// Strands of a file, each a polyline that begins at the root.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Guides {
    /// Points of all strands, in the file's space and unit.
    pub points: Vec<Vec3>,
    /// Radius of each point, in the file's unit; empty if the file has none.
    pub radii: Vec<f32>,
    /// Colour of each point, linear RGB; empty if the file has none.
    pub colors: Vec<Vec3>,
    /// Offsets into the points: strand `i` has the points `offsets[i]..offsets[i + 1]`. The list has one entry more
    /// than there are strands, and is empty without strands.
    pub offsets: Vec<u32>,
    /// Strands that were left out.
    pub left_out: LeftOut,
    /// Warnings: other parts of the file that were ignored or guessed.
    pub warnings: Vec<String>,
}

/// Numbers of strands that were left out of a file, by reason.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LeftOut {
    /// Strands with one point or no length.
    pub no_length: usize,
    /// Strands with a coordinate that is not a finite number.
    pub not_finite: usize,
    /// Strands with a piece many times longer than the others.
    pub far_point: usize,
}

impl LeftOut {
    /// Returns the number of strands that were left out.
    pub fn total(&self) -> usize {
        self.no_length + self.not_finite + self.far_point
    }
}

/// Lists the reasons, each with its number of strands.
impl fmt::Display for LeftOut {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let reasons = [
            (self.no_length, "without length"),
            (self.not_finite, "with a coordinate that is not a finite number"),
            (self.far_point, "with a piece many times longer than the others"),
        ];
        let parts = reasons.iter().filter(|(count, _)| *count > 0).map(|(count, reason)| format!("{count} {reason}"));
        f.write_str(&parts.collect::<Vec<_>>().join(", "))
    }
}

impl Guides {
    /// Returns the number of strands.
    pub fn len(&self) -> usize {
        self.offsets.len().saturating_sub(1)
    }

    /// Returns whether there are no strands.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the points of a strand, root first.
    pub fn strand(&self, index: usize) -> &[Vec3] {
        &self.points[self.offsets[index] as usize..self.offsets[index + 1] as usize]
    }

    /// Adds a strand. If it has no length or a point that is not finite, drops it and counts it in `left_out`. Points
    /// equal to their predecessor are dropped.
    pub fn push(&mut self, points: &[Vec3], radii: &[f32], colors: &[Vec3]) {
        if !points.iter().all(|point| point.is_finite()) {
            self.left_out.not_finite += 1;
            return;
        }
        let [first, first_radius, first_color] = [self.points.len(), self.radii.len(), self.colors.len()];
        for (i, point) in points.iter().enumerate() {
            if i > 0 && self.points[first..].last() == Some(point) {
                continue;
            }
            self.points.push(*point);
            self.radii.extend(radii.get(i));
            self.colors.extend(colors.get(i));
        }
        if self.points.len() - first < 2 {
            self.points.truncate(first);
            self.radii.truncate(first_radius);
            self.colors.truncate(first_color);
            self.left_out.no_length += 1;
            return;
        }
        if self.offsets.is_empty() {
            self.offsets.push(0);
        }
        self.offsets.push(self.points.len() as u32);
    }
}
