//! Thinning: T. Y. Zhang, C. Y. Suen, *A fast parallel algorithm for thinning digital patterns*, CACM 27 (1984).

use super::Mask;

/// Offsets to the neighbours of a pixel, clockwise from above.
const NEIGHBOUR_OFFSETS: [(i64, i64); 8] = [(0, -1), (1, -1), (1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1)];

impl Mask {
    /// Thins the set to centre lines one pixel wide (Zhang and Suen 1984). Connected parts stay connected, and lines
    /// one pixel wide are unchanged.
    #[must_use]
    pub fn core(&self) -> Self {
        thinned(self)
    }
}

/// Removes border pixels of parts wider than one pixel, alternately from the lower right and the upper left, until none
/// can be removed.
///
/// All pixels of a pass are selected at once, which keeps the line in the middle. Each is checked again before removal.
/// Without this check (as published), a slanted line two pixels wide would vanish, because all its pixels are border
/// pixels.
fn thinned(mask: &Mask) -> Mask {
    let mut out = mask.clone();
    let mut candidates: Vec<usize> = (0..out.pixels.len()).filter(|i| out.pixels[*i]).collect();
    loop {
        let before = candidates.len();
        for turn in 0..2 {
            let gone: Vec<usize> =
                candidates.iter().copied().filter(|i| is_removable_in_pass(&out, *i, turn)).collect();
            for i in gone {
                if is_removable(&neighbours(&out, i)) {
                    out.pixels[i] = false;
                }
            }
            candidates.retain(|i| out.pixels[*i]);
        }
        if candidates.len() == before {
            return out;
        }
    }
}

fn neighbours(mask: &Mask, i: usize) -> [bool; 8] {
    let (x, y) = ((i % mask.width as usize) as i64, (i / mask.width as usize) as i64);
    NEIGHBOUR_OFFSETS.map(|(dx, dy)| mask.contains(x + dx, y + dy))
}

/// Whether a pixel can be removed: it is neither the end of a line nor the connection between two parts.
fn is_removable(n: &[bool; 8]) -> bool {
    let count = n.iter().filter(|set| **set).count();
    let begins = (0..8).filter(|k| !n[*k] && n[(k + 1) % 8]).count();
    (2..=6).contains(&count) && begins == 1
}

/// Whether a pixel can be removed, and is on the side from which this pass removes pixels: the lower right if `turn` is
/// 0, otherwise the upper left.
fn is_removable_in_pass(mask: &Mask, i: usize, turn: u32) -> bool {
    let n = neighbours(mask, i);
    let [above, _, right, _, below, _, left, _] = n;
    let kept = if turn == 0 { right && below && (above || left) } else { above && left && (right || below) };
    !kept && is_removable(&n)
}
