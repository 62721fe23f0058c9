//! Fur strokes: the strands of the tile as drawn with a brush, in four nested densities.
//!
//! A brush draws few hairs, each separately. It is pressed down near the root and lifted towards the tip, and its
//! bristles part where it runs dry. So only some of the strands become strokes, spread evenly over the tile. The first
//! strokes are the broadest; later ones fill the gaps. Each density has a share of the tile that its strokes ink, and
//! includes the strokes of all sparser ones.

use super::noise::Gradient;
use super::plane::Plane;
use crate::noise::{hash, smooth_step, uniform};
use crate::stages::simulate::Strands;
use glam::{UVec2, Vec2, Vec3};
use rayon::prelude::*;

/// Inked share of the tile at each density, seen from above. [`SIDE_DENSITIES`] is the inked share seen from the side,
/// where hairs overlap.
const TOP_DENSITIES: [f32; 4] = [0.07, 0.17, 0.34, 0.58];
const SIDE_DENSITIES: [f32; 4] = [0.12, 0.26, 0.44, 0.64];
/// Maximum number of strokes. The tile is filled earlier unless strokes are thinner than a texel.
const MOST_STROKES: usize = 2400;
/// Number of candidate strands for each stroke.
const CANDIDATES: u64 = 12;
/// Half width of the first strokes, divided by their length. [`FINE`] is the same ratio for the last strokes.
const BROAD: f32 = 0.042;
const FINE: f32 = 0.022;
/// Length of a stroke seen from above, divided by the length of its strand. The brush draws a lock, and the strand is
/// one hair of it.
const REACH: f32 = 1.9;
/// Share of a strand's lateral offset that remains in its stroke when seen from the side.
const ASIDE: f32 = 0.3;
/// Minimum length of a stroke, in tile widths.
const SHORTEST: f32 = 0.05;
/// Minimum half width of a stroke, texels; thinner strokes break up.
const THINNEST_TEXELS: f32 = 0.8;

/// Stroke: its path from root to tip in tile widths, and its maximum half width.
struct Stroke {
    path: Vec<Vec2>,
    half_width: f32,
    /// Random position of the bristles in their noise.
    shift: f32,
    bristles: Gradient,
}

/// Parameters of one view of the strokes.
struct TileView {
    side: usize,
    /// Texels per tile width.
    scale: Vec2,
    periodic_v: bool,
    densities: [f32; 4],
    path: PathOf,
}

/// Function that makes the path of a stroke. Arguments: points of the strand, root first; unit direction of the mean
/// lean in the tile, or zero; seed.
type PathOf = fn(&[Vec3], Vec2, u64) -> Vec<Vec2>;

/// Draws the two array layers. Each has one plane of ink (0..=1) per density, from sparse to dense.
///
/// * `side`: texels per side
///
/// The first layer shows the tile from above and is periodic along both axes. The second shows it from the side, along
/// v, like the fin texture for the default lean direction. It is periodic in u; row 0 is the mesh surface, and the last
/// row is at the height [`Strands::height`].
pub fn fur(strands: &Strands, side: u32, seed: u64) -> [[Plane; 4]; 2] {
    let side = side as usize;
    let height = strands.height.max(1e-6);
    let scale = side as f32;
    let looks = [
        TileView { side, scale: Vec2::splat(scale), periodic_v: true, densities: TOP_DENSITIES, path: path_from_above },
        TileView {
            side,
            scale: Vec2::new(scale, scale / height),
            periodic_v: false,
            densities: SIDE_DENSITIES,
            path: path_from_side,
        },
    ];
    let lean = mean_lean(strands);
    let drawn: Vec<_> = looks.par_iter().map(|view| draw(strands, view, lean, seed)).collect();
    // Cannot fail: two views give two layers.
    <[_; 2]>::try_from(drawn).unwrap_or_else(|_| std::array::from_fn(|_| std::array::from_fn(|_| Plane::empty(side))))
}

/// Returns the mean lean direction of the strands: a unit vector, or zero if the directions cancel out.
fn mean_lean(strands: &Strands) -> Vec2 {
    let ends = (0..strands.len()).filter_map(|i| {
        let points = &strands.points[strands.range(i)];
        Some((*points.last()? - *points.first()?).truncate())
    });
    ends.sum::<Vec2>().normalize_or_zero()
}

/// Indices of at most [`MOST_STROKES`] strands in drawing order. Each strand is the random candidate farthest from the
/// strands before it.
struct DrawingOrder {
    seed: u64,
    roots: Vec<Vec2>,
    order: Vec<usize>,
    taken: Vec<bool>,
}

impl DrawingOrder {
    fn new(strands: &Strands, seed: u64) -> Self {
        let root = |i| strands.points.get(strands.range(i).start).copied().unwrap_or_default().truncate();
        let roots: Vec<Vec2> = (0..strands.len()).map(root).collect();
        Self { seed: hash(seed, 1), order: Vec::new(), taken: vec![false; roots.len()], roots }
    }

    /// Returns the distance between two roots, squared; the tile repeats.
    fn distance(&self, a: usize, b: usize) -> f32 {
        let d = (self.roots[a] - self.roots[b]).abs();
        d.min(1.0 - d).length_squared()
    }
}

impl Iterator for DrawingOrder {
    type Item = usize;

    fn next(&mut self) -> Option<usize> {
        let (n, count) = (self.order.len(), self.roots.len());
        if n >= count.min(MOST_STROKES) {
            return None;
        }
        // The last few hundred strands represent the coverage of the tile well enough.
        let recent = &self.order[n.saturating_sub(400)..];
        let mut best: Option<(f32, usize)> = None;
        for candidate in 0..CANDIDATES {
            let first = (hash(self.seed, (n as u64) << 8 | candidate) % count as u64) as usize;
            // In a small tile, most strands are already taken late in the process. The next strand that is not taken is
            // used.
            let i = (first..count).chain(0..first).find(|i| !self.taken[*i])?;
            let away = recent.iter().map(|other| self.distance(*other, i)).fold(f32::INFINITY, f32::min);
            if best.is_none_or(|(most, _)| away > most) {
                best = Some((away, i));
            }
        }
        let (_, strand) = best?;
        self.taken[strand] = true;
        self.order.push(strand);
        Some(strand)
    }
}

/// Returns a strand's path seen from above, extended to [`REACH`] times the strand's length. The extension continues
/// the strand's own direction; for nearly upright strands it follows the tile's mean lean, or a random direction if
/// there is none.
fn path_from_above(points: &[Vec3], lean: Vec2, seed: u64) -> Vec<Vec2> {
    let Some(root) = points.first() else { return Vec::new() };
    let length: f32 = points.windows(2).map(|w| w[0].distance(w[1])).sum();
    let seen: f32 = points.windows(2).map(|w| w[0].truncate().distance(w[1].truncate())).sum();
    let wanted = (REACH * length).max(SHORTEST);
    let missing = (wanted - seen).max(0.0);
    let turn = std::f32::consts::TAU * uniform(seed, 2);
    let somewhere = Vec2::new(libm::cosf(turn), libm::sinf(turn));
    let own = points.last().map_or(Vec2::ZERO, |tip| (*tip - *root).truncate()).normalize_or_zero();
    // Hand-drawn hairs are never quite parallel.
    let to = (own + 0.6 * lean + 0.12 * somewhere).try_normalize().unwrap_or(somewhere);
    let bend = to.perp() * (0.24 * (uniform(seed, 6) - 0.5));
    let mut gone = 0.0;
    let mut path = vec![root.truncate()];
    for w in points.windows(2) {
        gone += w[0].distance(w[1]) / length.max(1e-6);
        path.push(w[1].truncate() + (to * gone + bend * gone * gone) * missing);
    }
    path
}

/// Returns a strand's path seen from the side, along v. The lateral offset is scaled by [`ASIDE`]. A fin shows only a
/// section of this image. Strands that lean into the section from outside would have no root there. The lean is shown
/// by the fin, which leans itself.
fn path_from_side(points: &[Vec3], _: Vec2, _: u64) -> Vec<Vec2> {
    let root = points.first().map_or(0.0, |p| p.y);
    points.iter().map(|p| Vec2::new(root + ASIDE * (p.y - root), p.z)).collect()
}

/// Draws strokes until each density has inked its share of the tile. Denser planes include the ink of sparser ones.
fn draw(strands: &Strands, view: &TileView, lean: Vec2, seed: u64) -> [Plane; 4] {
    let mut order = DrawingOrder::new(strands, seed);
    let mut ink = Plane::empty(view.side);
    let mut touched = Stamp { ink: Plane::empty(view.side), texels: Vec::new() };
    let mut sum = 0.0f64;
    let all = (view.side * view.side) as f64;
    std::array::from_fn(|density| {
        let share = density as f32 / 3.0;
        while sum < f64::from(view.densities[density]) * all
            && let Some(strand) = order.next()
        {
            let seed = hash(seed, 0x10000 + strand as u64);
            let path = (view.path)(&strands.points[strands.range(strand)], lean, seed);
            let long: f32 = path.windows(2).map(|w| w[0].distance(w[1])).sum();
            let wide = (BROAD + (FINE - BROAD) * share) * (0.7 + 0.6 * uniform(seed, 3)) * long.max(SHORTEST);
            let thinnest = THINNEST_TEXELS / view.scale.x;
            let (shift, bristles) = (uniform(seed, 4), Gradient::new(hash(seed, 5), UVec2::new(16, 5)));
            touched.stroke(view, &Stroke { path, half_width: wide.max(thinnest), shift, bristles });
            for i in touched.texels.drain(..) {
                let new = std::mem::take(&mut touched.ink.values[i]);
                let old = &mut ink.values[i];
                sum += f64::from((1.0 - *old) * new);
                *old += (1.0 - *old) * new;
            }
        }
        ink.clone()
    })
}

/// Mask of a single stroke, so that overlapping segments do not darken it.
struct Stamp {
    ink: Plane,
    texels: Vec<usize>,
}

impl Stamp {
    fn stroke(&mut self, view: &TileView, stroke: &Stroke) {
        let long: f32 = stroke.path.windows(2).map(|w| w[0].distance(w[1])).sum();
        let mut gone = 0.0;
        for w in stroke.path.windows(2) {
            let piece = w[0].distance(w[1]);
            self.piece(view, stroke, (w[0], w[1]), (gone / long.max(1e-9), (gone + piece) / long.max(1e-9)));
            gone += piece;
        }
    }

    /// Inks the texels near a straight segment. `part` gives the beginning and end of the segment as shares of the
    /// stroke's length.
    fn piece(&mut self, view: &TileView, stroke: &Stroke, (a, b): (Vec2, Vec2), part: (f32, f32)) {
        let n = view.side as i64;
        let along = b - a;
        // Seen from the side, texels are not square, so half a texel is measured across the stroke.
        let across = Vec2::new(-along.y, along.x).normalize_or(Vec2::X);
        let soft = 0.5 * (across / view.scale).length().max(1e-9);
        let reach = (stroke.half_width + 2.0 * soft) * view.scale;
        let (low, high) = (a.min(b) * view.scale - reach, a.max(b) * view.scale + reach);
        for y in low.y.floor() as i64..=high.y.floor() as i64 {
            if !view.periodic_v && !(0..n).contains(&y) {
                continue;
            }
            for x in low.x.floor() as i64..=high.x.floor() as i64 {
                let at = Vec2::new(x as f32 + 0.5, y as f32 + 0.5) / view.scale;
                let t = ((at - a).dot(along) / along.length_squared().max(1e-12)).clamp(0.0, 1.0);
                let away = at - (a + along * t);
                // Offset across the bristles. It differs from the distance to the path at the ends of a segment.
                let side = along.perp_dot(at - a) / along.length().max(1e-12);
                let ink = brush(stroke, part.0 + (part.1 - part.0) * t, (away.length(), side), soft);
                if ink <= 0.0 {
                    continue;
                }
                let i = (y.rem_euclid(n) * n + x.rem_euclid(n)) as usize;
                let texel = &mut self.ink.values[i];
                if *texel == 0.0 {
                    self.texels.push(i);
                }
                *texel = texel.max(ink);
            }
        }
    }
}

/// Returns x to the power of 3/4.
fn three_quarters(x: f32) -> f32 {
    let root = x.sqrt();
    root * root.sqrt()
}

/// Returns the ink at share `t` of the stroke's length, 0..=1. `away` is the distance from the stroke's path, `side`
/// the offset of the bristle to the left of it, and `soft` half a texel.
fn brush(stroke: &Stroke, t: f32, (away, side): (f32, f32), soft: f32) -> f32 {
    if away >= stroke.half_width + soft {
        return 0.0;
    }
    // The pressure rises quickly and falls slowly.
    let press = smooth_step(-0.08, 0.24, t) * three_quarters((1.0 - t).max(0.0));
    let half = stroke.half_width * press;
    let covered = ((half + soft - away) / (2.0 * soft)).clamp(0.0, 1.0) * (half / soft).min(1.0);
    if covered <= 0.0 {
        return 0.0;
    }
    // Bristles run along the stroke and part as the ink runs out. The effect fades where the stroke has too few texels
    // to show separate bristles.
    let at = Vec2::new(0.11 * t, 0.5 + 0.5 * side / stroke.half_width) + stroke.shift;
    let bristle = stroke.bristles.at(at);
    let dry = smooth_step(0.05, 0.6, 0.8 * bristle + 0.9 * t - 0.35) * smooth_step(1.0, 5.0, stroke.half_width / soft);
    covered * (1.0 - 0.85 * dry) * (0.92 - 0.25 * t)
}
