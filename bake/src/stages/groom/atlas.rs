//! One texture for all furred skin: charts packed side by side, painted, and painted on past their borders.
//!
//! Charts are packed on shelves, the highest first. Around each lies a gutter, in which the triangle at its border is continued, so that
//! bilinear filtering and the coarser mips find there what the chart would go on with.

use super::charts::{Spacing, barycentric, bounds, charts};
use crate::BakeError;
use crate::mesh::Image;
use crate::stages::surface::Surface;
use glam::{Vec2, Vec3, Vec4};
use pelage_formats::meaning::linear_to_srgb;
use rayon::prelude::*;

/// Texels between a chart and the border of its place in the texture: enough that bilinear filtering of mip level 2 finds nothing of
/// another chart. Less where so many charts leave no room.
const GUTTERS: [u32; 4] = [8, 4, 2, 1];

/// A texture that all furred skin is laid out in.
#[derive(Clone, Debug)]
pub struct Atlas {
    /// Width and height, texels.
    pub(super) side: u32,
    /// Gutter round each chart, texels.
    pub(super) gutter: u32,
    /// One per vertex of the surface; where there is none, the vertex has no furred triangle.
    pub(super) uvs: Vec<Option<Vec2>>,
    /// For each texel the triangle that paints it, `u32::MAX` for none.
    owner: Vec<u32>,
}

/// A point of the skin, as a texel sees it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spot {
    /// Triangle of the surface's mesh.
    pub(super) triangle: usize,
    /// Barycentric coordinates; in gutters one of them is below 0.
    pub(super) weights: Vec3,
}

/// Where a chart lies in the texture.
#[derive(Clone, Copy, Debug, Default)]
struct Place {
    /// Upper left corner with the gutter, texels.
    at: (u32, u32),
    /// Lowest tile coordinate.
    min: Vec2,
    /// Whether u and v are swapped.
    turned: bool,
}

impl Atlas {
    /// Packs the furred triangles of `surface` into a texture of `side` texels each way. Vertices that belong to several charts, or to a
    /// chart and a bare part, are copied.
    ///
    /// # Errors
    /// [`BakeError::Params`] naming `color.pattern_texels` where the charts do not fit.
    pub fn new(surface: &mut Surface, side: u32) -> Result<Self, BakeError> {
        let spacing = spacing(surface, side);
        let places = &surface.rest.positions;
        let chart_of = charts(&surface.mesh, &surface.patch_of_triangle, places, &surface.tile_uvs, &spacing);
        let count = chart_of.iter().filter(|c| **c != u32::MAX).max().map_or(0, |c| *c as usize + 1);
        let chart_of_vertex = part_vertices(surface, &chart_of);
        let mut boxes = vec![(Vec2::splat(f32::INFINITY), Vec2::splat(f32::NEG_INFINITY)); count];
        for (t, chart) in chart_of.iter().enumerate().filter(|(_, c)| **c != u32::MAX) {
            let (min, max) = bounds(&surface.mesh.triangles[t].map(|v| surface.tile_uvs[v as usize]));
            let found = &mut boxes[*chart as usize];
            *found = (found.0.min(min), found.1.max(max));
        }
        // A triangle without sound coordinates keeps one texel.
        boxes.iter_mut().filter(|(min, max)| !(*max - *min).is_finite()).for_each(|b| *b = (Vec2::ZERO, Vec2::ZERO));
        let Some((scale, gutter, places)) = pack(&boxes, side) else {
            return Err(BakeError::Params {
                what: "color.pattern_texels",
                reason: format!("{side} texels each way are too few for {count} charts; expected more"),
            });
        };
        let uv = |(v, chart): (usize, &u32)| {
            let place = places.get(*chart as usize)?;
            let p = (surface.tile_uvs[v] - place.min) * scale;
            let p = if place.turned { Vec2::new(p.y, p.x) } else { p };
            let p = if p.is_finite() { p } else { Vec2::ZERO };
            let corner = Vec2::new(place.at.0 as f32, place.at.1 as f32) + gutter as f32 + 0.5;
            Some((corner + p) / side as f32)
        };
        let uvs = chart_of_vertex.iter().enumerate().map(uv).collect();
        let mut atlas = Self { side, gutter, uvs, owner: vec![u32::MAX; (side * side) as usize] };
        for t in (0..chart_of.len()).filter(|t| chart_of[*t] != u32::MAX) {
            atlas.draw(surface, t);
        }
        atlas.dilate();
        Ok(atlas)
    }

    /// What to tell of gutters that had to shrink.
    pub fn warning(&self) -> Option<String> {
        (self.gutter < GUTTERS[0]).then(|| {
            format!(
                "color.pattern_texels: {} texels leave gutters of {} between the pieces of skin instead of {}; colours may run into each \
                 other at a distance",
                self.side, self.gutter, GUTTERS[0]
            )
        })
    }

    /// Corners of a triangle, texels.
    fn corners(&self, surface: &Surface, triangle: usize) -> [Vec2; 3] {
        surface.mesh.triangles[triangle].map(|v| self.uvs[v as usize].unwrap_or_default() * self.side as f32)
    }

    /// Marks the texels whose centre a triangle covers; the first triangle wins.
    fn draw(&mut self, surface: &Surface, triangle: usize) {
        let corners = self.corners(surface, triangle);
        let (min, max) = bounds(&corners);
        let last = i64::from(self.side) - 1;
        let range = |a: f32, b: f32| (a.floor() as i64).clamp(0, last)..=(b.ceil() as i64).clamp(0, last);
        for (y, x) in range(min.y, max.y).flat_map(|y| range(min.x, max.x).map(move |x| (y, x))) {
            let inside = barycentric(&corners, Vec2::new(x as f32 + 0.5, y as f32 + 0.5))
                .is_some_and(|w| w.min_element() >= -1e-4);
            let owner = &mut self.owner[(y * (last + 1) + x) as usize];
            if inside && *owner == u32::MAX {
                *owner = triangle as u32;
            }
        }
    }

    /// Hands triangles on to free neighbours, as far as the gutter reaches.
    fn dilate(&mut self) {
        let n = self.side as usize;
        for _ in 0..self.gutter {
            let before = self.owner.clone();
            self.owner.par_chunks_mut(n).enumerate().for_each(|(y, row)| {
                for (x, owner) in row.iter_mut().enumerate().filter(|(_, o)| **o == u32::MAX) {
                    // Straight neighbours first: they are nearer.
                    let steps = [(0, -1), (-1, 0), (1, 0), (0, 1), (-1, -1), (1, -1), (-1, 1), (1, 1)];
                    let at = |(dx, dy): (isize, isize)| {
                        let (x, y) = (x.checked_add_signed(dx)?, y.checked_add_signed(dy)?);
                        (x < n && y < n).then(|| before[y * n + x]).filter(|t| *t != u32::MAX)
                    };
                    if let Some(found) = steps.into_iter().find_map(at) {
                        *owner = found;
                    }
                }
            });
        }
    }

    /// Paints the texture. `color` gives linear RGBA at a spot, `extent` is the texel's there: the difference of the barycentric
    /// coordinates over a texel to the right and one down.
    ///
    /// Texels without a triangle get the mean of all others, so that the coarsest mips keep the colour.
    pub(super) fn paint(&self, surface: &Surface, color: impl Fn(Spot, [Vec3; 2]) -> Vec4 + Sync) -> Vec<Vec4> {
        let n = self.side as usize;
        let texel = |(i, owner): (usize, &u32)| {
            let triangle = Some(*owner as usize).filter(|_| *owner != u32::MAX)?;
            let corners = self.corners(surface, triangle);
            let center = Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5);
            let weights = barycentric(&corners, center)?;
            let step = |d: Vec2| barycentric(&corners, center + d).map_or(Vec3::ZERO, |w| w - weights);
            Some(color(Spot { triangle, weights }, [step(Vec2::X), step(Vec2::Y)]))
        };
        let painted: Vec<Option<Vec4>> = self.owner.par_iter().enumerate().map(texel).collect();
        let (sum, count) = painted.iter().flatten().fold((Vec4::ZERO, 0.0), |(sum, n), c| (sum + *c, n + 1.0f32));
        let mean = sum / count.max(1.0);
        painted.into_iter().map(|c| c.unwrap_or(mean)).collect()
    }
}

/// Charts leave themselves the gutter that they leave each other. Their scale is only known once they are packed; what the areas give is
/// a little less than the size of a texel will be.
fn spacing(surface: &Surface, side: u32) -> Spacing {
    let (mut tile, mut skin) = (0.0, 0.0);
    let furred = surface.mesh.triangles.iter().zip(&surface.patch_of_triangle).filter(|(_, patch)| **patch != u32::MAX);
    for (triangle, _) in furred {
        let [a, b, c] = triangle.map(|v| surface.tile_uvs[v as usize]);
        let [p, q, r] = triangle.map(|v| surface.rest.positions[v as usize]);
        tile += (b - a).perp_dot(c - a).abs() / 2.0;
        skin += (q - p).cross(r - p).length() / 2.0;
    }
    let usable = |v: f32| v.is_finite() && v > 0.0;
    Spacing {
        margin: if usable(tile) { tile.sqrt() / side as f32 * GUTTERS[0] as f32 } else { 0.0 },
        tile_m: if usable(tile) && usable(skin) { (skin / tile).sqrt() } else { 1.0 },
    }
}

/// Linear RGBA as an image, sRGB-encoded.
pub(super) fn srgb_image(side: u32, texels: &[Vec4]) -> Image {
    let byte = |share: f32| (255.0 * share.clamp(0.0, 1.0)).round() as u8;
    let rgba = texels.iter().flat_map(|t| [linear_to_srgb(t.x), linear_to_srgb(t.y), linear_to_srgb(t.z), byte(t.w)]);
    Image { width: side, height: side, rgba: rgba.collect() }
}

/// Linear values as an image.
pub(super) fn linear_image(side: u32, texels: &[Vec4]) -> Image {
    let byte = |share: f32| (255.0 * share.clamp(0.0, 1.0)).round() as u8;
    Image { width: side, height: side, rgba: texels.iter().flat_map(|t| t.to_array().map(byte)).collect() }
}

/// The chart of each vertex, `u32::MAX` for none, after vertices of several were copied.
fn part_vertices(surface: &mut Surface, chart_of: &[u32]) -> Vec<u32> {
    const UNUSED: u32 = u32::MAX - 1;
    let mut chart_of_vertex = vec![UNUSED; surface.mesh.positions.len()];
    let mut copies = std::collections::BTreeMap::new();
    for (t, chart) in chart_of.iter().enumerate() {
        for k in 0..3 {
            let v = surface.mesh.triangles[t][k];
            let own = &mut chart_of_vertex[v as usize];
            if *own == UNUSED {
                *own = *chart;
            } else if *own != *chart {
                surface.mesh.triangles[t][k] = *copies.entry((v, *chart)).or_insert_with(|| {
                    chart_of_vertex.push(*chart);
                    surface.copy_vertex(v)
                });
            }
        }
    }
    chart_of_vertex
}

/// Places boxes of tile coordinates in a texture: texels per tile, gutter and one place for each; `None` where they do not fit.
fn pack(boxes: &[(Vec2, Vec2)], side: u32) -> Option<(f32, u32, Vec<Place>)> {
    let sizes: Vec<Vec2> = boxes.iter().map(|(min, max)| *max - *min).collect();
    let area: f32 = sizes.iter().map(|s| s.x * s.y).sum();
    let widest = sizes.iter().map(|s| s.max_element()).fold(0.0, f32::max);
    // As large as the area allows at best; then smaller and smaller.
    let full = (side as f32 / area.max(1e-12).sqrt()).min(side as f32 / widest.max(1e-6));
    for gutter in GUTTERS {
        let mut scale = full;
        for _ in 0..80 {
            if let Some(places) = shelves(boxes, &sizes, scale, gutter, side) {
                return Some((scale, gutter, places));
            }
            scale *= 0.96;
        }
    }
    None
}

/// Shelf packing: boxes lie on their longer side, the highest first, row after row.
fn shelves(boxes: &[(Vec2, Vec2)], sizes: &[Vec2], scale: f32, gutter: u32, side: u32) -> Option<Vec<Place>> {
    let cell = |size: Vec2| {
        let texels = |x: f32| (x * scale).ceil() as u32 + 1 + 2 * gutter;
        (texels(size.max_element()), texels(size.min_element()))
    };
    let mut order: Vec<usize> = (0..boxes.len()).collect();
    order.sort_by_key(|i| (std::cmp::Reverse(cell(sizes[*i]).1), *i));
    let mut places = vec![Place::default(); boxes.len()];
    let (mut x, mut y, mut row) = (0, 0, 0);
    for i in order {
        let (width, height) = cell(sizes[i]);
        if x + width > side {
            (x, y, row) = (0, y + row, 0);
        }
        if x + width > side || y + height > side {
            return None;
        }
        places[i] = Place { at: (x, y), min: boxes[i].0, turned: sizes[i].y > sizes[i].x };
        x += width;
        row = row.max(height);
    }
    Some(places)
}

#[cfg(test)]
#[path = "atlas_tests.rs"]
mod tests;
