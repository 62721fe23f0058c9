//! One texture for all furred skin: charts packed side by side, painted, and painted on past their borders.
//!
//! Charts are packed on shelves, the highest first. Around each lies a gutter, in which the triangle at its border is continued, so that
//! bilinear filtering and the coarser mips find there what the chart would go on with. In an atlas for hair that keeps its root's colour the gutter is as
//! wide as hair reaches, so that a root beyond the chart's border is found in it too, and no chart is turned: a way in the tile is the same
//! way in all of them.

use super::canvas::{Canvas, Piece, Spot};
use super::charts::{Spacing, bounds, charts};
use crate::stages::surface::Surface;
use glam::{Vec2, Vec3, Vec4};
use pelage_formats::meaning::linear_to_srgb;
use pelage_import::BakeError;
use pelage_import::mesh::Image;
use std::collections::BTreeMap;

/// Texels each way of the smallest texture for roots.
const LEAST_SIDE: u32 = 64;

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
    /// Texels in the width of a tile.
    pub(super) scale: f32,
    /// One per vertex of the surface; where there is none, the vertex has no triangle in it.
    pub(super) uvs: Vec<Option<Vec2>>,
    /// Its texels.
    canvas: Canvas,
}

/// Why charts could not be packed: there are so many that not even the smallest gutters leave room for them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct TooMany {
    /// Number of charts.
    pub(super) charts: usize,
}

/// What lies round the charts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Around {
    /// As wide a gutter as there is room for.
    Room,
    /// A gutter of so many tiles, and no chart is turned. A tile is at most so many texels wide.
    Reach { tiles: f32, most_texels: f32 },
}

/// Texels that a gutter of [`Around::Reach`] has besides, for filters and mips.
const BEYOND: u32 = 4;

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
        Self::pack(surface, side).map_err(|TooMany { charts }| BakeError::Params {
            what: "color.pattern_texels",
            reason: format!("{side} texels each way are too few for {charts} charts; expected more"),
        })
    }

    /// As [`Self::new`], for whoever can do with another size. Where it fails, vertices are parted all the same.
    pub(super) fn pack(surface: &mut Surface, side: u32) -> Result<Self, TooMany> {
        let patches = surface.patch_of_triangle.clone();
        let margin = spacing(surface, side);
        let charted = Charted::new(surface, &patches, |v| v, &margin);
        let places = charted.places(side, Around::Room).ok_or(TooMany { charts: charted.boxes.len() })?;
        Ok(charted.atlas(surface, side, places))
    }

    /// Packs some of the triangles, so that hair finds in the texture the skin where it roots: as [`Around::Reach`].
    ///
    /// * `patches`: one per triangle, `u32::MAX` for those that have no place in it
    /// * `reach`: of hair, tiles
    /// * `texels`: in the width of a tile that are enough
    /// * `most_side`: the texture has the least power of two texels each way that gives a tile so many, but no more than this
    ///
    /// `None` where a tile would have less than `least` texels; vertices are parted all the same.
    pub(super) fn for_roots(
        surface: &mut Surface,
        patches: &[u32],
        reach: f32,
        [least, texels]: [f32; 2],
        most_side: u32,
    ) -> Option<Self> {
        let margin = Spacing { margin: reach, ..spacing(surface, most_side) };
        // Of flat faces each has vertices of its own, and they hang together all the same.
        let same = same_in_tile(surface);
        let charted = Charted::new(surface, patches, |v| same[v as usize], &margin);
        let around = Around::Reach { tiles: reach, most_texels: texels };
        let sides = std::iter::successors(Some(LEAST_SIDE.min(most_side)), |side| Some(2 * side));
        let mut best = None;
        for side in sides.take_while(|side| *side <= most_side) {
            let places = charted.places(side, around).filter(|(scale, ..)| *scale >= least);
            let is_enough = places.as_ref().is_some_and(|(scale, ..)| *scale >= texels);
            best = places.map(|places| (side, places)).or(best);
            if is_enough {
                break;
            }
        }
        best.map(|(side, places)| charted.atlas(surface, side, places))
    }

    /// Whether every chart has the widest gutter.
    pub(super) fn is_roomy(&self) -> bool {
        self.gutter == GUTTERS[0]
    }

    /// What to tell of gutters that had to shrink.
    pub fn warning(&self) -> Option<String> {
        (!self.is_roomy()).then(|| {
            format!(
                "color.pattern_texels: {} texels leave gutters of {} between the pieces of skin instead of {}; colours may run into each \
                 other at a distance",
                self.side, self.gutter, GUTTERS[0]
            )
        })
    }

    /// Paints the texture. `color` gives linear RGBA at a spot, `extent` is the texel's there: the difference of the barycentric
    /// coordinates over a texel to the right and one down.
    ///
    /// Texels without a triangle get the mean of all others, so that the coarsest mips keep the colour.
    pub(super) fn paint(&self, color: impl Fn(Spot, [Vec3; 2]) -> Vec4 + Sync) -> Vec<Vec4> {
        self.canvas.paint(color)
    }
}

/// Triangles in charts, with vertices of their own.
struct Charted {
    /// One per triangle, `u32::MAX` for none.
    chart_of: Vec<u32>,
    /// One per vertex.
    chart_of_vertex: Vec<u32>,
    /// Least and greatest tile coordinates of each chart.
    boxes: Vec<(Vec2, Vec2)>,
}

impl Charted {
    fn new(surface: &mut Surface, patches: &[u32], same: impl Fn(u32) -> u32, spacing: &Spacing) -> Self {
        let places = &surface.rest.positions;
        let chart_of = charts(&surface.mesh, patches, same, places, &surface.tile_uvs, spacing);
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
        Self { chart_of, chart_of_vertex, boxes }
    }

    /// Places of the charts in a texture, as [`pack`] gives them.
    fn places(&self, side: u32, around: Around) -> Option<(f32, u32, Vec<Place>)> {
        pack(&self.boxes, side, around)
    }

    fn atlas(&self, surface: &Surface, side: u32, (scale, gutter, places): (f32, u32, Vec<Place>)) -> Atlas {
        let uv = |(v, chart): (usize, &u32)| {
            let place = places.get(*chart as usize)?;
            let p = (surface.tile_uvs[v] - place.min) * scale;
            let p = if place.turned { Vec2::new(p.y, p.x) } else { p };
            let p = if p.is_finite() { p } else { Vec2::ZERO };
            let corner = Vec2::new(place.at.0 as f32, place.at.1 as f32) + gutter as f32 + 0.5;
            Some((corner + p) / side as f32)
        };
        let uvs: Vec<Option<Vec2>> = self.chart_of_vertex.iter().enumerate().map(uv).collect();
        let corners = |t: usize| surface.mesh.triangles[t].map(|v| uvs[v as usize].unwrap_or_default() * side as f32);
        let charted = (0..self.chart_of.len()).filter(|t| self.chart_of[*t] != u32::MAX);
        let pieces = charted.map(|t| Piece { triangle: t as u32, corners: corners(t) }).collect();
        Atlas { side, gutter, scale, canvas: Canvas::new(side, pieces, gutter), uvs }
    }
}

/// For each vertex the first at the same place of the skin and of the tile.
fn same_in_tile(surface: &Surface) -> Vec<u32> {
    let mut first_at = BTreeMap::new();
    let places = surface.mesh.positions.iter().zip(&surface.tile_uvs).zip(0..);
    // Adding zero turns -0 into +0.
    let bits = |x: f32| (x + 0.0).to_bits();
    let same =
        places.map(|((p, uv), v)| *first_at.entry((p.to_array().map(bits), uv.to_array().map(bits))).or_insert(v));
    same.collect()
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
pub(crate) fn linear_image(side: u32, texels: &[Vec4]) -> Image {
    let byte = |share: f32| (255.0 * share.clamp(0.0, 1.0)).round() as u8;
    Image { width: side, height: side, rgba: texels.iter().flat_map(|t| t.to_array().map(byte)).collect() }
}

/// The chart of each vertex, `u32::MAX` for none, after vertices of several were copied.
fn part_vertices(surface: &mut Surface, chart_of: &[u32]) -> Vec<u32> {
    const UNUSED: u32 = u32::MAX - 1;
    let mut chart_of_vertex = vec![UNUSED; surface.mesh.positions.len()];
    let mut copies = BTreeMap::new();
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
fn pack(boxes: &[(Vec2, Vec2)], side: u32, around: Around) -> Option<(f32, u32, Vec<Place>)> {
    let sizes: Vec<Vec2> = boxes.iter().map(|(min, max)| *max - *min).collect();
    let area: f32 = sizes.iter().map(|s| s.x * s.y).sum();
    let widest = sizes.iter().map(|s| s.max_element()).fold(0.0, f32::max);
    // As large as the area allows at best; then smaller and smaller.
    let full = (side as f32 / area.max(1e-12).sqrt()).min(side as f32 / widest.max(1e-6));
    let scales = |full: f32| std::iter::successors(Some(full), |scale| Some(0.96 * scale)).take(80);
    let fit = |scale: f32, gutter: u32, turned: bool| {
        shelves(boxes, &sizes, scale, gutter, side, turned).map(|places| (scale, gutter, places))
    };
    match around {
        Around::Room => GUTTERS.into_iter().find_map(|gutter| scales(full).find_map(|scale| fit(scale, gutter, true))),
        Around::Reach { tiles, most_texels } => {
            let gutter = |scale: f32| (tiles * scale).ceil() as u32 + BEYOND;
            scales(full.min(most_texels)).find_map(|scale| fit(scale, gutter(scale), false))
        }
    }
}

/// Shelf packing: boxes lie, those that may be `turned` on their longer side, the highest first, row after row.
fn shelves(
    boxes: &[(Vec2, Vec2)],
    sizes: &[Vec2],
    scale: f32,
    gutter: u32,
    side: u32,
    turned: bool,
) -> Option<Vec<Place>> {
    let turns = |size: Vec2| turned && size.y > size.x;
    let cell = |size: Vec2| {
        let texels = |x: f32| (x * scale).ceil() as u32 + 1 + 2 * gutter;
        if turns(size) { (texels(size.y), texels(size.x)) } else { (texels(size.x), texels(size.y)) }
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
        places[i] = Place { at: (x, y), min: boxes[i].0, turned: turns(sizes[i]) };
        x += width;
        row = row.max(height);
    }
    Some(places)
}

#[cfg(test)]
#[path = "atlas_tests.rs"]
mod tests;
