//! Simulation of wet ink on a repeating tile of paper until the ink is dry.
//!
//! A small version of the fluid layers of watercolour simulation (Curtis et al. 1997, §4; Chu and Tai 2005). Water
//! seeps from wet texels into their neighbours, as far as the paper permits, and carries its ink along. Dry paper holds
//! the water back, which frays the border. The border dries faster, so that more water flows there from the middle. The
//! ink of this water stays as a dark rim, a tide mark.

use super::plane::Plane;

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

/// Simulates one layer of wash and returns the dried ink.
///
/// * `water`: initial water, 0..=1 per texel; equals the initial ink where `strength` is 1
/// * `edges`: how much faster the border dries, 0..=1; 0 leaves no rim
pub(super) fn simulate_drying(paper: Paper<'_>, water: &Plane, strength: &Plane, edges: f32) -> Plane {
    let n = water.side;
    let mut water = water.values.clone();
    let mut ink: Vec<f32> = water.iter().zip(&strength.values).map(|(w, s)| w * s).collect();
    let mut stain = vec![0.0f32; n * n];
    let mut next = (water.clone(), ink.clone());
    for _ in 0..STEPS {
        next.0.copy_from_slice(&water);
        next.1.copy_from_slice(&ink);
        for y in 0..n {
            let below = if y + 1 == n { 0 } else { y + 1 } * n;
            for x in 0..n {
                let i = y * n + x;
                let right = y * n + if x + 1 == n { 0 } else { x + 1 };
                for j in [right, below + x] {
                    // Between two dry texels, nothing flows.
                    if water[i].max(water[j]) < DRY {
                        continue;
                    }
                    let (from, to) = if water[i] > water[j] { (i, j) } else { (j, i) };
                    if water[to] < DRY && water[from] < paper.threshold.values[to] {
                        continue;
                    }
                    let pass = 0.12 * (paper.permeability.values[i] + paper.permeability.values[j]);
                    let flow = pass * (water[from] - water[to]);
                    let mut carried = flow * ink[from] / water[from].max(1e-6);
                    if water[to] >= DRY {
                        carried += WANDERING * (ink[from] - ink[to]);
                    }
                    next.0[from] -= flow;
                    next.0[to] += flow;
                    next.1[from] -= carried;
                    next.1[to] += carried;
                }
            }
        }
        std::mem::swap(&mut water, &mut next.0);
        std::mem::swap(&mut ink, &mut next.1);
        for y in 0..n {
            let (above, below) = (if y == 0 { n - 1 } else { y - 1 } * n, if y + 1 == n { 0 } else { y + 1 } * n);
            for x in 0..n {
                let i = y * n + x;
                if next.0[i].max(water[i]) <= 0.0 {
                    continue;
                }
                let (left, right) = (if x == 0 { n - 1 } else { x - 1 }, if x + 1 == n { 0 } else { x + 1 });
                let wet = |j: usize| f32::from(u8::from(water[j] >= DRY));
                let dry_sides = 4.0 - wet(y * n + left) - wet(y * n + right) - wet(above + x) - wet(below + x);
                let loss = EVAPORATION + EDGE_EVAPORATION * edges * dry_sides;
                water[i] = (water[i] - loss).max(0.0);
                // All ink settles when the last of the water is gone.
                let share = if water[i] < DRY { 1.0 } else { SETTLING };
                let settled = share * ink[i];
                stain[i] += settled;
                ink[i] -= settled;
            }
        }
    }
    stain.iter_mut().zip(&ink).for_each(|(s, rest)| *s += rest);
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
