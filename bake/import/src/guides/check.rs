//! Checks of a file's strands: single bad strands are left out, and strands that were not separated are reported.

use super::Guides;
use crate::error::BakeError;
use glam::Vec3;

/// Length of a piece divided by the longest other piece, above which the piece is an error.
const FAR_RATIO: f32 = 8.0;
/// The same for a strand without another piece to compare with.
const FAR_RATIO_ALONE: f32 = 20.0;
/// The same for a piece that ends at the origin, where programs write missing points.
const ORIGIN_RATIO: f32 = 4.0;
/// Length of a piece divided by the median, above which it is a jump to another strand.
const JUMP_RATIO: f32 = 2.0;
/// The same for the only long piece of a strand.
const SINGLE_JUMP_RATIO: f32 = 4.0;
/// Minimum number of pieces of a strand that is searched for jumps.
const JUMP_PIECES: usize = 5;

/// Piece of a strand that may be too long.
#[derive(Clone, Copy)]
struct Suspect {
    strand: usize,
    /// Index in the strand of the point that the piece leads to.
    point: usize,
    /// Length of the piece, or of the shorter piece at an inner point.
    length: f32,
    /// Longest piece that does not touch the point; 0 without one.
    rest: f32,
    /// Longest piece of the strand.
    longest: f32,
    at_origin: bool,
    is_last: bool,
}

impl Suspect {
    /// Returns the point whose removal shortens a strand most, relative to its other pieces.
    fn of(strand: usize, points: &[Vec3]) -> Self {
        let lengths: Vec<f32> = points.windows(2).map(|ends| ends[0].distance(ends[1])).collect();
        let longest = lengths.iter().copied().fold(0.0, f32::max);
        let piece = lengths.iter().position(|length| *length == longest).unwrap_or_default();
        let of_point = |point: usize| {
            let touches = |piece: usize| piece == point || piece + 1 == point;
            let both = lengths.iter().enumerate().filter(|(piece, _)| touches(*piece));
            let others = lengths.iter().enumerate().filter(|(piece, _)| !touches(*piece));
            Self {
                strand,
                point,
                length: both.map(|(_, length)| *length).fold(f32::INFINITY, f32::min),
                rest: others.map(|(_, length)| *length).fold(0.0, f32::max),
                longest,
                at_origin: points[point] == Vec3::ZERO,
                is_last: point + 1 == points.len(),
            }
        };
        // A jump between two inner points: neither end is far from both of its neighbours.
        let jump = || {
            let others = lengths.iter().enumerate().filter(|(other, _)| *other != piece);
            let rest = others.map(|(_, length)| *length).fold(0.0, f32::max);
            Self { length: longest, rest, at_origin: false, is_last: false, ..of_point(piece + 1) }
        };
        let [a, b] = [of_point(piece), of_point(piece + 1)];
        let excess = |suspect: &Self| suspect.length - suspect.rest;
        let prefers_first = excess(&a) > excess(&b) || (excess(&a) == excess(&b) && a.at_origin);
        let end = if prefers_first { a } else { b };
        if end.length == longest || end.length > ORIGIN_RATIO * end.rest { end } else { jump() }
    }

    /// Returns whether the piece is an error.
    ///
    /// * `usual`: median over the strands of the longest piece
    /// * `usual_rest`: the same without the piece in question
    fn is_far(&self, usual: f32, usual_rest: f32) -> bool {
        let rest = self.rest.max(usual_rest);
        if self.at_origin && rest > 0.0 && self.length > ORIGIN_RATIO * rest {
            return true;
        }
        let ratio = if self.rest > 0.0 { FAR_RATIO } else { FAR_RATIO_ALONE };
        self.length > ratio * self.rest.max(usual)
    }
}

impl Guides {
    /// Checks the strands of a whole file.
    ///
    /// * Radii or colours that some points lack, or that are not finite, are dropped.
    /// * A strand with a piece many times longer than those of the others is left out. If most strands have such a
    ///   piece and it leads to the origin, only the point at the origin is removed.
    /// * A single strand with jumps is reported.
    ///
    /// Fails with [`BakeError::Input`] if no strand is left.
    pub(crate) fn checked(mut self, file: &str) -> Result<Self, BakeError> {
        let count = self.points.len();
        if self.radii.len() != count || !self.radii.iter().all(|radius| radius.is_finite()) {
            self.radii.clear();
        }
        if self.colors.len() != count || !self.colors.iter().all(|color| color.is_finite()) {
            self.colors.clear();
        }
        self.leave_out_far_points();
        let fault = |reason| Err(BakeError::Input { file: file.to_owned(), place: "strands".into(), reason });
        if self.is_empty() {
            return fault(match self.left_out.total() {
                0 => "the file has no strands, expected at least one".to_owned(),
                _ => format!("no strand in the file can be used: {}", self.left_out),
            });
        }
        if self.len() == 1 {
            self.warnings.extend(jumps(self.strand(0)));
        }
        Ok(self)
    }

    fn leave_out_far_points(&mut self) {
        let suspects: Vec<Suspect> = (0..self.len()).map(|strand| Suspect::of(strand, self.strand(strand))).collect();
        let usual = median(suspects.iter().map(|suspect| suspect.longest));
        let usual_rest = median(suspects.iter().map(|suspect| suspect.rest).filter(|rest| *rest > 0.0));
        let mut far: Vec<&Suspect> = suspects.iter().filter(|suspect| suspect.is_far(usual, usual_rest)).collect();
        let are_most = 2 * far.len() > self.len();
        if are_most {
            far.retain(|suspect| suspect.at_origin && suspect.point > 0);
        }
        if far.is_empty() {
            return;
        }
        let total = self.len();
        let all = std::mem::take(self);
        (self.left_out, self.warnings) = (all.left_out, all.warnings.clone());
        let mut next = far.iter().peekable();
        for strand in 0..total {
            let range = all.offsets[strand] as usize..all.offsets[strand + 1] as usize;
            let radii = all.radii.get(range.clone()).unwrap_or_default();
            let colors = all.colors.get(range.clone()).unwrap_or_default();
            let points = &all.points[range];
            match next.next_if(|suspect| suspect.strand == strand) {
                None => self.push(points, radii, colors),
                Some(_) if !are_most => self.left_out.far_point += 1,
                Some(suspect) => {
                    let [points, colors] = [without(points, suspect.point), without(colors, suspect.point)];
                    self.push(&points, &without(radii, suspect.point), &colors);
                }
            }
        }
        if are_most {
            let piece = if far.iter().all(|suspect| suspect.is_last) { "last piece" } else { "piece" };
            self.warnings.push(format!(
                "{} of {total} strands have a {piece} many times longer than the others, to the origin; it is left out",
                far.len()
            ));
        }
    }
}

fn without<T: Copy>(list: &[T], index: usize) -> Vec<T> {
    list.iter().enumerate().filter(|(i, _)| *i != index).map(|(_, item)| *item).collect()
}

/// Returns the lower median, or 0 without numbers.
fn median(numbers: impl Iterator<Item = f32>) -> f32 {
    let mut numbers: Vec<f32> = numbers.collect();
    let Some(last) = numbers.len().checked_sub(1) else { return 0.0 };
    *numbers.select_nth_unstable_by(last / 2, f32::total_cmp).1
}

/// Returns a warning if a strand seems to be several strands in a row.
fn jumps(points: &[Vec3]) -> Option<String> {
    let lengths = || points.windows(2).map(|ends| ends[0].distance(ends[1]));
    let usual = median(lengths());
    let longer = |ratio: f32| lengths().filter(|length| *length > ratio * usual).count();
    let count = longer(JUMP_RATIO);
    (lengths().len() >= JUMP_PIECES && (count > 1 || longer(SINGLE_JUMP_RATIO) > 0)).then(|| {
        format!(
            "the file is one strand with jumps, {} points and {count} pieces much longer than the others; separate its \
             strands (in text: by blank lines)",
            points.len()
        )
    })
}
