//! Paper texture: a tile of xuan paper, with long soft fibres in a cloudy sheet.

use super::noise::Octaves;
use super::plane::Plane;
use crate::noise::{hash, smooth_step, uniform};
use crate::recipe::InkParams;
use glam::{UVec2, Vec2};
use std::f32::consts::TAU;

/// Number of fibres in the tile at the maximum setting.
const FIBRES: f32 = 2600.0;
/// Segments per fibre; the fibre may turn a little at each.
const PIECES: u32 = 40;
/// Number of ribs in the tile, left by the screen on which the sheet was made.
const SCREEN_RIBS: f32 = 44.0;

/// Tile that lines are drawn into.
struct Canvas {
    plane: Plane,
}

impl Canvas {
    /// Raises texels within `radius` texels of `at` to `height`, with a soft border. Coordinates wrap around the tile.
    fn dab(&mut self, at: Vec2, radius: f32, height: f32) {
        let n = self.plane.side as i64;
        let reach = radius + 0.8;
        let range = |c: f32| (c - reach).floor() as i64..=(c + reach).floor() as i64;
        for y in range(at.y) {
            for x in range(at.x) {
                let d = Vec2::new(x as f32 + 0.5, y as f32 + 0.5).distance(at) / reach;
                let i = (y.rem_euclid(n) * n + x.rem_euclid(n)) as usize;
                let value = height * (1.0 - d * d).max(0.0);
                self.plane.values[i] = self.plane.values[i].max(value);
            }
        }
    }
}

/// Draws fibres as a soft relief, 0..1. Fibres are long curves, each on top of the earlier ones.
fn fibres(side: usize, seed: u64, count: u32, (length, width): (f32, f32)) -> Plane {
    let mut canvas = Canvas { plane: Plane::empty(side) };
    for fibre in 0..u64::from(count) {
        let random = |n: u64| uniform(seed, fibre << 8 | n);
        let mut at = Vec2::new(random(1), random(2)) * side as f32;
        // The vat is shaken back and forth, so more fibres are along u than across it.
        let mut turn = TAU * random(3);
        turn -= 0.3 * libm::sinf(2.0 * turn);
        let bend = (random(4) - 0.5) * 0.07;
        let sway = (random(5) - 0.5) * 0.1;
        let long = length * (0.35 + 1.3 * random(6) * random(6)) * side as f32 / PIECES as f32;
        let thick = width * (0.5 + random(7)) * side as f32;
        // Most fibres are deep in the sheet.
        let high = 0.1 + 0.65 * random(8) * random(8) * random(10);
        for piece in 0..PIECES {
            let t = (piece as f32 + 0.5) / PIECES as f32;
            turn += bend + sway * libm::sinf(TAU * (1.5 * t + random(9)));
            let end = smooth_step(0.0, 0.15, t) * smooth_step(0.0, 0.15, 1.0 - t);
            let dabs = (long / (0.7 * (thick + 0.6))).ceil().max(1.0);
            for _ in 0..dabs as u32 {
                at += Vec2::new(libm::cosf(turn), libm::sinf(turn)) * (long / dabs);
                canvas.dab(at, thick, high * end);
            }
        }
    }
    canvas.plane
}

/// Makes the channels of the paper:
///
/// * red: relief, 0.5 on average
/// * green: absorbency, 0.5 on average; high values draw ink in
/// * blue: tone; 1 is the colour of the paper, and darker flecks and fibres are lower
/// * alpha: threshold of a dry brush, with all values equally frequent; low where ink takes first, on raised fibres
pub fn paper(params: &InkParams) -> [Plane; 4] {
    let side = params.paper_texels as usize;
    let seed = hash(params.seed, 0x9a9e);
    let noise = |kind: u64, cells: u32, count: u32| Octaves::new(hash(seed, kind), UVec2::splat(cells), count, 0.6);
    let count = FIBRES * params.paper_fibres;
    let bast = fibres(side, hash(seed, 1), (0.3 * count) as u32, (0.36, 0.0008));
    let straw = fibres(side, hash(seed, 2), count as u32, (0.13, 0.0004));
    let fibres_all = bast.with(&straw, |bast, straw| bast.max(0.75 * straw));
    // The sheet looks cloudy against the light, because its thickness varies.
    let cloud = noise(3, 6, 5).plane(side);
    let tooth = noise(4, (params.paper_texels / 10).max(4), 3).plane(side);
    let waver = noise(5, 3, 2);
    let ribs = Plane::from_fn(side, |uv| 0.5 * libm::cosf(TAU * SCREEN_RIBS * (uv.y + 0.004 * waver.at(uv))));
    let felt = tooth.with(&cloud, |tooth, cloud| 0.35 * tooth + 0.3 * cloud).with(&ribs, |a, ribs| a + 0.12 * ribs);
    let relief = felt.with(&fibres_all, |felt, fibre| felt + 1.9 * fibre);
    let absorbency = cloud.with(&tooth, |cloud, tooth| cloud + 0.25 * tooth).with(&fibres_all, |a, f| a - 1.1 * f);
    let spread = 0.04 + 0.24 * params.paper_absorbency;

    // Some fibres have another colour, and a few bits of bark remain.
    let dark = fibres(side, hash(seed, 6), (0.05 * count) as u32, (0.2, 0.0009));
    let bark = fibres(side, hash(seed, 7), (0.012 * count) as u32, (0.018, 0.0022));
    let tone =
        dark.with(&bark, |dark, bark| 0.45 * dark + 0.8 * bark).with(&cloud, |fleck, c| fleck + 0.05 * c.max(0.0));
    let tone = tone.with(&fibres_all, |fleck, fibre| 1.0 - params.paper_tone * (fleck + 0.06 * fibre).clamp(0.0, 1.0));

    let hollow = relief.with(&relief.blurred(side as f32 / 40.0), |all, coarse| coarse - all);
    let threshold = hollow.with(&tooth, |hollow, tooth| hollow - 0.45 * tooth).equalised();
    [relief.balanced(0.17), absorbency.balanced(spread), tone, threshold]
}
