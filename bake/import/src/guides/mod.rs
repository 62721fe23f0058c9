//! Hair guides, read from files of other programs: the few strands that define the shape of hair on a scalp.

pub mod lines;
pub mod read;

use glam::Vec3;

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
    /// Number of strands dropped because they have one point or no length.
    pub left_out: usize,
    /// Warnings: other parts of the file that were ignored or guessed.
    pub warnings: Vec<String>,
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

    /// Adds a strand. If it has no length, drops it and counts it in `left_out`. Points equal to their predecessor are
    /// dropped.
    pub fn push(&mut self, points: &[Vec3], radii: &[f32], colors: &[Vec3]) {
        let first = self.points.len();
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
            self.radii.truncate(first);
            self.colors.truncate(first);
            self.left_out += 1;
            return;
        }
        if self.offsets.is_empty() {
            self.offsets.push(0);
        }
        self.offsets.push(self.points.len() as u32);
    }
}
