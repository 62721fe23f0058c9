//! Guides: the few strands that say how hair on a scalp lies, as files of other programs have them.

pub mod lines;
pub mod read;

use glam::Vec3;

/// Strands as a file has them: polylines, root first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Guides {
    /// Points of all, in the file's space and unit.
    pub points: Vec<Vec3>,
    /// Of each point, in the file's unit; empty where the file says none.
    pub radii: Vec<f32>,
    /// Of each point, linear RGB; empty where the file says none.
    pub colors: Vec<Vec3>,
    /// Strand `i` is `offsets[i]..offsets[i + 1]`; one entry more than strands, or none.
    pub offsets: Vec<u32>,
    /// Strands of the file that were left out: of one point, or without length.
    pub left_out: usize,
    /// What else was left out of the file, or guessed.
    pub warnings: Vec<String>,
}

impl Guides {
    /// Number of strands.
    pub fn len(&self) -> usize {
        self.offsets.len().saturating_sub(1)
    }

    /// Whether there is no strand.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Points of a strand, root first.
    pub fn strand(&self, index: usize) -> &[Vec3] {
        &self.points[self.offsets[index] as usize..self.offsets[index + 1] as usize]
    }

    /// Adds a strand, or counts it as left out where it has no length. Points that stand where the one before does are dropped.
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
