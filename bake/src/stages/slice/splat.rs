//! Rasterisation of strands as Gaussian splats in the texels of one layer.
//!
//! Hair is a volume with an extinction. Each layer represents a slab, the range of heights around it. It receives the
//! optical depth of all segments in its slab, measured by arc length. So slanted hair appears as a connected streak and
//! not as a row of dots. [`extinction`] returns a strand's depth such that a single strand blocks as much light as an
//! opaque one. Two consequences are exact, up to the rounding of stored opacities:
//!
//! * The depths of all layers have the same sum at any number of layers: the opacity per layer follows α' = 1 − (1 −
//!   α)^(n₀/n) (formulas 4.6, 3.2).
//! * The depth of a splat has the same sum over texels of any size, wherever its centre is between them.

use crate::stages::simulate::Strands;
use crate::stages::slice::direction;
use glam::{Vec2, Vec3, Vec4};
use rayon::prelude::*;

/// Returns the density with which to draw a strand, times its radius. A strand across the ray, drawn as a Gaussian of
/// that density, blocks as much light as an opaque strand of the same radius. So the integral of 1 − exp(−depth) across
/// the strand equals its width.
///
/// * `sharpness`: radius divided by the standard deviation of the drawn Gaussian, 0..=√2. At 0, the strand is thinner
///   than a texel and its depth is small. The result is then 2/π, with which the integral of the depth itself equals
///   the width. At √2, the Gaussian has the strand's own variance. It then needs 1.8 times the density, because its
///   middle is already dark.
///
/// The function is a polynomial fit to the inverse of that integral, accurate within 2 %.
pub fn extinction(sharpness: f32) -> f32 {
    let s = sharpness.clamp(0.0, std::f32::consts::SQRT_2);
    std::f32::consts::FRAC_2_PI * (1.0 + s * (0.282 + s * (0.098 + s * 0.078)))
}

/// Cutoff of a drawn Gaussian, standard deviations. The weights are then normalised to a sum of one.
const CUTOFF: f32 = 3.0;
/// Distance between splats along a streak, standard deviations. At this distance, their sum varies by less than 10⁻⁴.
pub(super) const SPACING: f32 = 1.2;
/// Number of segments that one task converts to splats. It is fixed, because streaks are merged only within a task.
const CHUNK: usize = 4096;
/// Number of segments whose splats are in memory at once.
const BATCH: usize = 64 * CHUNK;

/// Sums over the strands at one texel: optical depth, depth times linear RGB, and depth times direction. The last
/// components are the texel's weight, and depth times the visibility coefficients.
pub(super) type Sums = [f32; 12];

/// Input for rasterisation: strands and, if known, the visibility coefficients at each of their points.
#[derive(Clone, Copy)]
pub(super) struct DrawInput<'a> {
    pub(super) strands: &'a Strands,
    pub(super) visibility: Option<&'a [Vec4]>,
}

/// Index of the segments of each layer.
pub(super) struct LayerIndex {
    /// Segments by layer, as indices of their first points. A segment that crosses several slabs is listed in each.
    segments: Vec<u32>,
    /// Ranges in `segments`: those of layer `k` are `segments[starts[k]..starts[k + 1]]`.
    starts: Vec<usize>,
    spacing: f32,
    layers: u32,
}

impl LayerIndex {
    /// Assigns the segments of `strands` to the slabs of `layers` layers. Layer 0 is the mesh surface and has no slab.
    /// The slab of layer 1 extends down to the surface, so that no segment is lost.
    pub(super) fn new(strands: &Strands, layers: u32) -> Self {
        let mut index = Self {
            segments: Vec::new(),
            starts: vec![0; layers as usize + 1],
            spacing: strands.height / (layers - 1) as f32,
            layers,
        };
        let for_each_entry = |index: &Self, visit: &mut dyn FnMut(usize, u32)| {
            for strand in 0..strands.len() {
                let range = strands.range(strand);
                for i in range.start..range.end.saturating_sub(1) {
                    let (a, b) = (strands.points[i].z, strands.points[i + 1].z);
                    for k in index.layer_at(a.min(b))..=index.layer_at(a.max(b)) {
                        visit(k, i as u32);
                    }
                }
            }
        };
        let mut counts = vec![0usize; layers as usize];
        for_each_entry(&index, &mut |k, _| counts[k] += 1);
        for (k, count) in counts.iter().enumerate() {
            index.starts[k + 1] = index.starts[k] + count;
        }
        let mut next = index.starts.clone();
        let mut segments = vec![0; index.starts[layers as usize]];
        for_each_entry(&index, &mut |k, i| {
            segments[next[k]] = i;
            next[k] += 1;
        });
        index.segments = segments;
        index
    }

    fn layer_at(&self, h: f32) -> usize {
        ((h / self.spacing + 0.5) as u32).clamp(1, self.layers - 1) as usize
    }

    /// Returns the lower and upper end of a layer's slab. The first slab has no lower limit, the last one no upper
    /// limit.
    fn slab(&self, layer: usize) -> (f32, f32) {
        let below = if layer <= 1 { f32::NEG_INFINITY } else { (layer as f32 - 0.5) * self.spacing };
        let above = if layer + 1 >= self.layers as usize { f32::INFINITY } else { (layer as f32 + 0.5) * self.spacing };
        (below, above)
    }

    /// Fills `sums`, `texels * texels` row-major, with the hair of one layer. The result does not depend on the number
    /// of threads.
    pub(super) fn draw(&self, drawn: DrawInput<'_>, layer: usize, texels: u32, filter_width: f32, sums: &mut [Sums]) {
        sums.par_iter_mut().with_min_len(4096).for_each(|s| *s = Sums::default());
        let entries = &self.segments[self.starts[layer]..self.starts[layer + 1]];
        for batch in entries.chunks(BATCH) {
            add(&self.splats(drawn, batch, layer, texels, filter_width), texels, sums);
        }
    }

    /// Returns the splats of a range of a layer's segments, in order.
    fn splats(
        &self,
        drawn: DrawInput<'_>,
        entries: &[u32],
        layer: usize,
        texels: u32,
        filter_width: f32,
    ) -> Vec<Splat> {
        let slab = self.slab(layer);
        let parts: Vec<Vec<Splat>> = entries
            .par_chunks(CHUNK)
            .map(|chunk| {
                let mut streak = Streak { splats: Vec::new(), open: None, filter_width };
                for (n, &i) in chunk.iter().enumerate() {
                    if n == 0 || chunk[n - 1].wrapping_add(1) != i {
                        streak.close();
                    }
                    streak.add(drawn, i as usize, slab, texels as f32);
                }
                streak.close();
                streak.splats
            })
            .collect();
        parts.concat()
    }
}

/// Gaussian splat of hair in one layer. Units are texels; texel centres are at half integers.
#[derive(Clone, Copy, Debug)]
struct Splat {
    center: Vec2,
    /// Variance, in texels².
    variance: f32,
    /// Sum of the optical depth over all texels.
    depth: f32,
    color: Vec3,
    direction: Vec3,
    visibility: Vec4,
}

/// Segments of one strand being converted to splats: short neighbouring segments are drawn as one.
struct Streak {
    splats: Vec<Splat>,
    /// Pending splat with depth-weighted sums, and its horizontal extent.
    open: Option<(Splat, f32)>,
    filter_width: f32,
}

impl Streak {
    fn close(&mut self) {
        if let Some((sum, _)) = self.open.take().filter(|(s, _)| s.depth > 0.0) {
            let w = 1.0 / sum.depth;
            self.splats.push(Splat {
                center: sum.center * w,
                variance: sum.variance * w,
                depth: sum.depth,
                color: sum.color * w,
                direction: sum.direction * w,
                visibility: sum.visibility * w,
            });
        }
    }

    /// Adds the part of segment `i` between the heights of `slab`.
    fn add(&mut self, DrawInput { strands, visibility }: DrawInput<'_>, i: usize, slab: (f32, f32), texels: f32) {
        let (p, q) = (strands.points[i], strands.points[i + 1]);
        let rise = q.z - p.z;
        let at = |h: f32| ((h - p.z) / rise).clamp(0.0, 1.0);
        let (from, to) = match rise {
            r if r > 0.0 => (at(slab.0), at(slab.1)),
            r if r < 0.0 => (at(slab.1), at(slab.0)),
            _ => (0.0, 1.0),
        };
        let share = to - from;
        let Some(tangent) = (q - p).try_normalize().filter(|_| share > 0.0) else { return };
        let length = (q - p).length() * share;
        let middle = from + 0.5 * share;
        let radius = strands.radii[i] + (strands.radii[i + 1] - strands.radii[i]) * middle;
        // A disc of uniform density and a Gaussian of variance r²/2 have the same integral if the depth at their
        // centres is equal.
        let variance = radius * radius * 0.5 * texels * texels + self.filter_width * self.filter_width;
        let density = extinction(radius * texels / variance.sqrt());
        let depth = density * std::f32::consts::PI * radius * length * texels * texels;
        let color = strands.colors[i].lerp(strands.colors[i + 1], middle);
        let direction = direction::upward(tangent);
        let visibility = visibility.map_or(Vec4::ZERO, |at| at[i].lerp(at[i + 1], middle));
        let (a, b) = (p.lerp(q, from).truncate() * texels, p.lerp(q, to).truncate() * texels);
        let extent = (b - a).length();
        let spacing = SPACING * variance.sqrt();
        let pieces = (extent / spacing).ceil().max(1.0);
        if self.open.is_some_and(|(_, open)| open + extent > spacing) {
            self.close();
        }
        for n in 0..pieces as u32 {
            let depth = depth / pieces;
            let center = a + (b - a) * ((n as f32 + 0.5) / pieces);
            let (sum, open) = self.open.get_or_insert((
                Splat {
                    center: Vec2::ZERO,
                    variance: 0.0,
                    depth: 0.0,
                    color: Vec3::ZERO,
                    direction: Vec3::ZERO,
                    visibility: Vec4::ZERO,
                },
                0.0,
            ));
            sum.center += center * depth;
            sum.variance += variance * depth;
            sum.depth += depth;
            sum.color += color * depth;
            sum.direction += direction * depth;
            sum.visibility += visibility * depth;
            *open += extent;
            if pieces > 1.0 {
                self.close();
            }
        }
    }
}

/// Returns the number of rows that one task draws.
fn band_rows(texels: usize) -> usize {
    (texels / 16).clamp(4, 64)
}

/// Adds splats to `texels * texels` sums, row-major, wrapping at the tile's borders.
///
/// In each texel the splats are added in their order, so the sums do not depend on the number of threads.
fn add(splats: &[Splat], texels: u32, sums: &mut [Sums]) {
    let n = texels as usize;
    let rows = band_rows(n);
    let bands = n.div_ceil(rows);
    let mut lists = vec![Vec::new(); bands];
    for (i, splat) in splats.iter().enumerate() {
        let (first, count) = span(splat.center.y, splat.variance);
        let mut row = wrap(first, n);
        let mut left = count.min(n + rows);
        // Advance from band to band. A splat taller than the tile returns once to its first band.
        loop {
            let band = row / rows;
            if lists[band].last().is_none_or(|&l| l != i as u32) {
                lists[band].push(i as u32);
            }
            let step = (rows - row % rows).min(n - row);
            if left <= step {
                break;
            }
            left -= step;
            row = (row + step) % n;
        }
    }
    sums.par_chunks_mut(rows * n).enumerate().for_each(|(band, sums)| {
        let (mut wx, mut wy) = (Vec::new(), Vec::new());
        for &i in &lists[band] {
            let splat = &splats[i as usize];
            let (x0, y0) =
                (weights(splat.center.x, splat.variance, &mut wx), weights(splat.center.y, splat.variance, &mut wy));
            let values = [
                1.0,
                splat.color.x,
                splat.color.y,
                splat.color.z,
                splat.direction.x,
                splat.direction.y,
                splat.direction.z,
                0.0,
                splat.visibility.x,
                splat.visibility.y,
                splat.visibility.z,
                splat.visibility.w,
            ];
            for (j, wy) in wy.iter().enumerate() {
                let row = wrap(y0 + j as i64, n);
                let Some(row) = row.checked_sub(band * rows).filter(|r| (r + 1) * n <= sums.len()) else { continue };
                let depth = splat.depth * wy;
                let values = values.map(|v| v * depth);
                let row = &mut sums[row * n..(row + 1) * n];
                let mut x = wrap(x0, n);
                let mut weights = wx.as_slice();
                while !weights.is_empty() {
                    let (run, rest) = weights.split_at(weights.len().min(n - x));
                    for (sum, w) in row[x..].iter_mut().zip(run) {
                        for (s, v) in sum.iter_mut().zip(values) {
                            *s += v * w;
                        }
                    }
                    weights = rest;
                    x = 0;
                }
            }
        }
    });
}

/// Returns the first texel and the number of texels that a Gaussian reaches along one axis.
fn span(center: f32, variance: f32) -> (i64, usize) {
    let reach = CUTOFF * variance.sqrt();
    let (first, last) = ((center - reach).floor(), (center + reach).floor());
    (first as i64, (last - first) as usize + 1)
}

/// Fills `out` with the Gaussian at the texel centres, normalised to a sum of one. Returns the index of the first
/// texel.
pub(crate) fn weights(center: f32, variance: f32, out: &mut Vec<f32>) -> i64 {
    let (first, count) = span(center, variance);
    out.clear();
    let scale = -0.5 / variance;
    out.extend((0..count).map(|i| {
        let d = first as f32 + i as f32 + 0.5 - center;
        libm::expf(scale * d * d)
    }));
    let norm = 1.0 / out.iter().sum::<f32>();
    out.iter_mut().for_each(|w| *w *= norm);
    first
}

fn wrap(texel: i64, n: usize) -> usize {
    texel.rem_euclid(n as i64) as usize
}
