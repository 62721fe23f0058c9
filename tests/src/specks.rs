//! Measures how much of a drawing's ink is in specks instead of strokes.

use pelage_lab::mask::Mask;

/// Returns the 8-connected components of a mask as pixel indices, row by row from the top.
pub fn components(mask: &Mask) -> Vec<Vec<usize>> {
    let (width, height) = (mask.width as usize, mask.height as usize);
    let mut seen = vec![false; mask.pixels.len()];
    let mut parts = Vec::new();
    for first in (0..mask.pixels.len()).filter(|i| mask.pixels[*i]) {
        if std::mem::replace(&mut seen[first], true) {
            continue;
        }
        let (mut part, mut next) = (vec![first], 0);
        while let Some(i) = part.get(next).copied() {
            next += 1;
            let (x, y) = (i % width, i / width);
            for y in y.saturating_sub(1)..=(y + 1).min(height - 1) {
                for x in x.saturating_sub(1)..=(x + 1).min(width - 1) {
                    let i = y * width + x;
                    if mask.pixels[i] && !std::mem::replace(&mut seen[i], true) {
                        part.push(i);
                    }
                }
            }
        }
        part.sort_unstable();
        parts.push(part);
    }
    parts
}

/// Ink of a drawing, and the part of it that is in specks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Specks {
    /// Number of ink pixels.
    pub ink: usize,
    /// Number of ink pixels in specks: components whose bounding box has a diagonal below the limit.
    pub short: usize,
    /// Number of specks.
    pub count: usize,
}

impl Specks {
    /// Returns the number of speck pixels per thousand ink pixels.
    pub fn per_mille(&self) -> f64 {
        1000.0 * self.short as f64 / self.ink.max(1) as f64
    }

    /// Adds the counts of two drawings.
    #[must_use]
    pub fn sum(self, other: Self) -> Self {
        Self { ink: self.ink + other.ink, short: self.short + other.short, count: self.count + other.count }
    }
}

/// Counts the ink, and the ink in components whose diagonal is below `shorter_than_px`, pixels.
pub fn specks(ink: &Mask, shorter_than_px: f64) -> Specks {
    let width = ink.width as usize;
    let parts = components(ink);
    let mut found = Specks { ink: ink.count(), ..Specks::default() };
    for part in parts {
        let extent = |of: fn(usize, usize) -> usize| {
            let places = || part.iter().map(|i| of(*i, width));
            (places().max().unwrap_or(0) - places().min().unwrap_or(0) + 1) as f64
        };
        if extent(|i, width| i % width).hypot(extent(|i, width| i / width)) < shorter_than_px {
            (found.short, found.count) = (found.short + part.len(), found.count + 1);
        }
    }
    found
}

/// Returns the number of ink pixels in components that touch no pixel of the body.
pub fn detached_px(ink: &Mask, body: &Mask) -> usize {
    let touches = |part: &Vec<usize>| {
        part.iter().any(|i| {
            let (x, y) = ((i % ink.width as usize) as i64, (i / ink.width as usize) as i64);
            (-1..=1).any(|dy| (-1..=1).any(|dx| body.contains(x + dx, y + dy)))
        })
    };
    components(ink).iter().filter(|part| !touches(part)).map(Vec::len).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(rows: &[&str]) -> Mask {
        let cells: Vec<Vec<char>> = rows.iter().map(|row| row.chars().collect()).collect();
        Mask::from_fn(cells[0].len() as u32, cells.len() as u32, |x, y| cells[y as usize][x as usize] == '#')
    }

    #[test]
    fn connected_parts_include_diagonal_neighbours() {
        let mask = drawn(&["#..#", ".#..", "...#", "...#"]);
        assert_eq!(components(&mask), [vec![0, 5], vec![3], vec![11, 15]]);
        assert!(components(&Mask::empty(3, 0)).is_empty());
    }

    #[test]
    fn specks_are_short_parts_and_detached_pixels_touch_no_body() {
        let mask = drawn(&["########", "........", "..##....", "........", ".#......"]);
        // The bounding boxes have diagonals of 8.06 (long line), 2.24 (dash) and 1.41 (dot) pixels.
        let found = specks(&mask, 2.0);
        assert_eq!((found.ink, found.short, found.count), (11, 1, 1));
        assert_eq!(specks(&mask, 3.0).short, 3);
        assert_eq!(specks(&mask, 9.0).short, 11);
        assert!((specks(&mask, 3.0).per_mille() - 3000.0 / 11.0).abs() < 1e-9);
        let body = drawn(&["........", "#.......", "........", "........", "........"]);
        assert_eq!(detached_px(&mask, &body), 3);
        assert_eq!(detached_px(&mask, &mask), 0);
    }
}
