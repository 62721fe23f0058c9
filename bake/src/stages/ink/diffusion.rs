//! Simulation of wet ink on a repeating tile of paper until the ink is dry.
//!
//! A small version of the fluid layers of watercolour simulation (Curtis et al. 1997, §4; Chu and Tai 2005). Water
//! seeps from wet texels into their neighbours, as far as the paper permits, and carries its ink along. Dry paper holds
//! the water back, which frays the border. The border dries faster, so that more water flows there from the middle. The
//! ink of this water stays as a dark rim, a tide mark.

use super::plane::Plane;
use std::ops::Range;

/// Number of steps until a layer is dry. Fronts advance by about the square root of this number, texels.
const STEPS: usize = 72;
/// Water below which a texel counts as dry.
const DRY: f32 = 0.02;
/// Water that evaporates from a texel per step; [`EDGE_EVAPORATION`] is added for each dry neighbour.
const EVAPORATION: f32 = 0.004;
const EDGE_EVAPORATION: f32 = 0.018;
/// Share of the difference in ink that diffuses between wet neighbours per step, even if no water flows.
const WANDERING: f32 = 0.025;
/// Share of the ink in the water that settles on the fibres per step.
const SETTLING: f32 = 0.004;

/// Paper under the ink.
#[derive(Clone, Copy, Debug)]
pub(super) struct Paper<'a> {
    /// Permeability to water, 0..=1 per texel.
    pub permeability: &'a Plane,
    /// Amount of water that is needed to wet the next texel, 0..=1.
    pub threshold: &'a Plane,
}

/// Water and ink of the texels, or their flows from each texel to a neighbour.
#[derive(Clone)]
struct WaterAndInk {
    water: Vec<f32>,
    ink: Vec<f32>,
}

/// Consecutive texels of a row.
#[derive(Clone, Copy)]
struct Texels<'a> {
    water: &'a [f32],
    ink: &'a [f32],
    permeability: &'a [f32],
    threshold: &'a [f32],
}

impl WaterAndInk {
    fn texels<'a>(&'a self, paper: Paper<'a>, range: Range<usize>) -> Texels<'a> {
        Texels {
            water: &self.water[range.clone()],
            ink: &self.ink[range.clone()],
            permeability: &paper.permeability.values[range.clone()],
            threshold: &paper.threshold.values[range],
        }
    }

    /// Stores what flows from the texels `a` to the texels `b`, beginning at the index `at`. Without branches, so that
    /// the compiler vectorises it.
    fn exchange<'b>(&mut self, at: usize, a: Texels<'b>, b: Texels<'b>) {
        let n = a.water.len();
        let (water, ink) = (&mut self.water[at..at + n], &mut self.ink[at..at + n]);
        let cut = |t: &Texels<'b>| [&t.water[..n], &t.ink[..n], &t.permeability[..n], &t.threshold[..n]];
        let ([a_water, a_ink, a_pass, a_least], [b_water, b_ink, b_pass, b_least]) = (cut(&a), cut(&b));
        for i in 0..n {
            let forward = a_water[i] > b_water[i];
            let select = |a: f32, b: f32| if forward { (a, b) } else { (b, a) };
            let (from_water, to_water) = select(a_water[i], b_water[i]);
            let (from_ink, to_ink) = select(a_ink[i], b_ink[i]);
            let least = if forward { b_least[i] } else { a_least[i] };
            // Between two dry texels, nothing flows.
            let flows = (from_water >= DRY) & ((to_water >= DRY) | (from_water >= least));
            let pass = 0.12 * (a_pass[i] + b_pass[i]);
            let flow = pass * (from_water - to_water);
            let wandering = if to_water >= DRY { WANDERING * (from_ink - to_ink) } else { 0.0 };
            let carried = flow * from_ink / from_water.max(1e-6) + wandering;
            let sign = if forward { 1.0 } else { -1.0 };
            let sign = if flows { sign } else { 0.0 };
            water[i] = sign * flow;
            ink[i] = sign * carried;
        }
    }
}

/// Simulates one layer of wash and returns the dried ink.
///
/// * `water`: initial water, 0..=1 per texel; equals the initial ink where `strength` is 1
/// * `edges`: how much faster the border dries, 0..=1; 0 leaves no rim
pub(super) fn simulate_drying(paper: Paper<'_>, water: &Plane, strength: &Plane, edges: f32) -> Plane {
    let n = water.side;
    let ink = water.values.iter().zip(&strength.values).map(|(w, s)| w * s).collect();
    let mut wet = WaterAndInk { water: water.values.clone(), ink };
    // Flows to the right and down.
    let (mut right, mut down) = (wet.clone(), wet.clone());
    let mut stain = vec![0.0f32; n * n];
    let mut dry = vec![0.0f32; n * n];
    for _ in 0..STEPS {
        for y in 0..n {
            let (row, below) = (y * n, (y + 1) % n * n);
            let texels = |range| wet.texels(paper, range);
            right.exchange(row, texels(row..row + n - 1), texels(row + 1..row + n));
            right.exchange(row + n - 1, texels(row + n - 1..row + n), texels(row..row + 1));
            down.exchange(row, texels(row..row + n), texels(below..below + n));
        }
        for y in 0..n {
            let (row, above) = (y * n, (y + n - 1) % n * n);
            let move_along = |moved: &mut [f32], right: &[f32], down: &[f32]| {
                let (here, out) = (&mut moved[row..row + n], &right[row..row + n]);
                let (falls, arrives) = (&down[row..row + n], &down[above..above + n]);
                for x in 0..n {
                    here[x] += arrives[x] - out[x] - falls[x];
                }
                here[0] += out[n - 1];
                for x in 1..n {
                    here[x] += out[x - 1];
                }
            };
            move_along(&mut wet.water, &right.water, &down.water);
            move_along(&mut wet.ink, &right.ink, &down.ink);
        }
        dry.iter_mut().zip(&wet.water).for_each(|(dry, water)| *dry = if *water < DRY { 1.0 } else { 0.0 });
        for y in 0..n {
            let (row, above, below) = (y * n, (y + n - 1) % n * n, (y + 1) % n * n);
            let rows = [row, above, below].map(|from| &dry[from..from + n]);
            let (water, ink) = (&mut wet.water[row..row + n], &mut wet.ink[row..row + n]);
            let stain = &mut stain[row..row + n];
            for x in 0..n {
                let beside = rows[0][if x == 0 { n - 1 } else { x - 1 }] + rows[0][if x + 1 == n { 0 } else { x + 1 }];
                let dry_sides = beside + rows[1][x] + rows[2][x];
                let loss = EVAPORATION + EDGE_EVAPORATION * edges * dry_sides;
                water[x] = (water[x] - loss).max(0.0);
                // All ink settles when the last of the water is gone.
                let share = if water[x] < DRY { 1.0 } else { SETTLING };
                let settled = share * ink[x];
                stain[x] += settled;
                ink[x] -= settled;
            }
        }
    }
    stain.iter_mut().zip(&wet.ink).for_each(|(s, rest)| *s += rest);
    Plane { side: n, values: stain }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;

    #[test]
    fn diffusion_conserves_ink_and_darkens_the_border() {
        let n = 64;
        let flat = |value: f32| Plane::from_fn(n, |_| value);
        let disc = Plane::from_fn(n, |uv| f32::from(u8::from(uv.distance(Vec2::splat(0.5)) < 0.3)));
        let (permeability, threshold) = (flat(0.8), flat(0.3));
        let paper = Paper { permeability: &permeability, threshold: &threshold };
        let stain = simulate_drying(paper, &disc, &flat(1.0), 1.0);
        assert!((stain.mean() - disc.mean()).abs() < 1e-4, "{} of {}", stain.mean(), disc.mean());
        // Profile from the middle outwards: the rim is the last texel with ink, and the ink just inside of it is paler.
        let rim = |stain: &Plane| {
            let row: Vec<f32> = (32..64).map(|x| stain.at(x, 32)).collect();
            let last = row.iter().rposition(|ink| *ink > 0.02).unwrap_or(0);
            assert!((8..=24).contains(&last), "the border runs away or dries up at {last}: {row:?}");
            let most = row[last.saturating_sub(2)..=last].iter().copied().fold(0.0, f32::max);
            most / row[last.saturating_sub(7)..last - 2].iter().copied().fold(f32::INFINITY, f32::min)
        };
        let soft = simulate_drying(paper, &disc, &flat(1.0), 0.0);
        assert!(rim(&stain) > 1.6, "{}", rim(&stain));
        assert!(rim(&soft) < 1.3, "{}", rim(&soft));
    }
}
