//! Texture for the whole furred mesh: charts are packed side by side, painted, and extended past their borders.
//!
//! Charts are packed on shelves, the tallest first. Each has a gutter, into which the triangles at its border are
//! extended, for bilinear filtering and coarser mips. In an atlas for root colours, the gutter is as wide as the reach
//! of hair, so that roots beyond a chart's border are found. Its charts are not rotated, so that an offset in the tile
//! is the same in all of them.

use super::canvas::{Canvas, CanvasTriangle, SurfacePoint};
use super::charts::{Spacing, bounds, charts};
use crate::stages::surface::Surface;
use glam::{Vec2, Vec3, Vec4};
use pelage_formats::meaning::linear_to_srgb;
use pelage_import::BakeError;
use pelage_import::mesh::Image;
use std::collections::BTreeMap;

/// Width and height of the smallest texture for root colours, texels.
const LEAST_SIDE: u32 = 64;

/// Candidates for the gutter between a chart and the border of its cell, texels. With the first, bilinear filtering of
/// mip level 2 reads no other chart. The others are used if many charts leave too little room.
const GUTTERS: [u32; 4] = [8, 4, 2, 1];

/// Texture in which the whole furred mesh is laid out.
#[derive(Clone, Debug)]
pub struct Atlas {
    /// Width and height, texels.
    pub(super) side: u32,
    /// Gutter around each chart, texels.
    pub(super) gutter: u32,
    /// Scale: texels per width of a tile.
    pub(super) scale: f32,
    /// Texture coordinates of each vertex of the surface; `None` if the vertex is in no chart.
    pub(super) uvs: Vec<Option<Vec2>>,
    /// Texels.
    canvas: Canvas,
}

/// Error of packing: the texture has no room for the charts even with the smallest gutters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct TooManyCharts {
    /// Number of charts.
    pub(super) charts: usize,
}

/// Gutter around charts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum GutterKind {
    /// Widest gutter that fits.
    Room,
    /// Gutter of a width of `tiles` tiles, without rotation of charts. A tile is at most `most_texels` texels wide.
    Reach { tiles: f32, most_texels: f32 },
}

/// Gutter that [`GutterKind::Reach`] adds for filters and mips, texels.
const FILTER_GUTTER: u32 = 4;

/// Placement of a chart in the texture.
#[derive(Clone, Copy, Debug, Default)]
struct Placement {
    /// Upper left corner including the gutter, texels.
    at: (u32, u32),
    /// Minimum of the chart's tile coordinates.
    min: Vec2,
    /// Whether u and v are swapped, which rotates the chart.
    turned: bool,
}

impl Atlas {
    /// Packs the furred triangles of `surface` into a texture of `side` texels in width and height. Vertices shared by
    /// several charts, or by a chart and a bare part, are duplicated.
    ///
    /// Fails with [`BakeError::Params`] naming `color.pattern_texels` if the charts do not fit.
    pub fn new(surface: &mut Surface, side: u32) -> Result<Self, BakeError> {
        Self::pack(surface, side).map_err(|TooManyCharts { charts }| BakeError::Params {
            what: "color.pattern_texels",
            reason: format!("{side} texels each way are too few for {charts} charts; expected more"),
        })
    }

    /// Packs like [`Self::new`], for callers that can choose another size. Vertices are duplicated even if packing
    /// fails.
    pub(super) fn pack(surface: &mut Surface, side: u32) -> Result<Self, TooManyCharts> {
        let patches = surface.patch_of_triangle.clone();
        let margin = spacing(surface, side);
        let charted = ChartedMesh::new(surface, &patches, |v| v, &margin);
        let places = charted.places(side, GutterKind::Room).ok_or(TooManyCharts { charts: charted.boxes.len() })?;
        Ok(charted.atlas(surface, side, places))
    }

    /// Packs some of the triangles with [`GutterKind::Reach`], so that the texture contains the surface at the hair's
    /// roots.
    ///
    /// * `patches`: one per triangle, `u32::MAX` for triangles to exclude
    /// * `reach`: largest displacement of hair, tiles
    /// * `texels`: minimum and sufficient number of texels per width of a tile
    /// * `most_side`: maximum width and height. Up to this limit, the smallest power of two that gives the sufficient
    ///   number is used
    ///
    /// Returns `None` if a tile would have fewer texels than the minimum. Vertices are duplicated even then.
    pub(super) fn for_roots(
        surface: &mut Surface,
        patches: &[u32],
        reach: f32,
        [least, texels]: [f32; 2],
        most_side: u32,
    ) -> Option<Self> {
        let margin = Spacing { margin: reach, ..spacing(surface, most_side) };
        // Compare vertices by position and tile coordinates: with flat shading, adjacent triangles share no vertices.
        let same = same_in_tile(surface);
        let charted = ChartedMesh::new(surface, patches, |v| same[v as usize], &margin);
        let around = GutterKind::Reach { tiles: reach, most_texels: texels };
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

    /// Returns a warning if the gutters had to shrink.
    pub fn warning(&self) -> Option<String> {
        (!self.is_roomy()).then(|| {
            format!(
                "color.pattern_texels: with {} texels, gutters between atlas charts are {} texels wide instead of {}; \
                 colours may bleed into each other at a distance",
                self.side, self.gutter, GUTTERS[0]
            )
        })
    }

    /// Paints the texture. `color` returns linear RGBA at a point. Its second argument is the size of the texel there:
    /// the change of the barycentric coordinates over one texel to the right and one texel down.
    ///
    /// Texels without a triangle get the mean of all others, so that the coarsest mips keep the colour.
    pub(super) fn paint(&self, color: impl Fn(SurfacePoint, [Vec3; 2]) -> Vec4 + Sync) -> Vec<Vec4> {
        self.canvas.paint(color)
    }
}

/// Mesh whose triangles are divided into charts that share no vertices.
struct ChartedMesh {
    /// Chart of each triangle, `u32::MAX` for none.
    chart_of: Vec<u32>,
    /// Chart of each vertex.
    chart_of_vertex: Vec<u32>,
    /// Minimum and maximum tile coordinates of each chart.
    boxes: Vec<(Vec2, Vec2)>,
}

impl ChartedMesh {
    fn new(surface: &mut Surface, patches: &[u32], same: impl Fn(u32) -> u32, spacing: &Spacing) -> Self {
        let places = &surface.rest.positions;
        let chart_of = charts(&surface.mesh, patches, same, places, &surface.tile_uvs, spacing);
        let count = chart_of.iter().filter(|c| **c != u32::MAX).max().map_or(0, |c| *c as usize + 1);
        let chart_of_vertex = split_vertices(surface, &chart_of);
        let mut boxes = vec![(Vec2::splat(f32::INFINITY), Vec2::splat(f32::NEG_INFINITY)); count];
        for (t, chart) in chart_of.iter().enumerate().filter(|(_, c)| **c != u32::MAX) {
            let (min, max) = bounds(&surface.mesh.triangles[t].map(|v| surface.tile_uvs[v as usize]));
            let found = &mut boxes[*chart as usize];
            *found = (found.0.min(min), found.1.max(max));
        }
        // A chart with invalid coordinates gets one texel.
        boxes.iter_mut().filter(|(min, max)| !(*max - *min).is_finite()).for_each(|b| *b = (Vec2::ZERO, Vec2::ZERO));
        Self { chart_of, chart_of_vertex, boxes }
    }

    /// Places the charts in a texture and returns the result of [`pack`].
    fn places(&self, side: u32, around: GutterKind) -> Option<(f32, u32, Vec<Placement>)> {
        pack(&self.boxes, side, around)
    }

    fn atlas(&self, surface: &Surface, side: u32, (scale, gutter, places): (f32, u32, Vec<Placement>)) -> Atlas {
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
        let pieces = charted.map(|t| CanvasTriangle { triangle: t as u32, corners: corners(t) }).collect();
        Atlas { side, gutter, scale, canvas: Canvas::new(side, pieces, gutter), uvs }
    }
}

/// Returns for each vertex the first vertex with the same position and tile coordinates.
fn same_in_tile(surface: &Surface) -> Vec<u32> {
    let mut first_at = BTreeMap::new();
    let places = surface.mesh.positions.iter().zip(&surface.tile_uvs).zip(0..);
    // Adding zero turns −0 into +0, so that both have the same bits.
    let bits = |x: f32| (x + 0.0).to_bits();
    let same =
        places.map(|((p, uv), v)| *first_at.entry((p.to_array().map(bits), uv.to_array().map(bits))).or_insert(v));
    same.collect()
}

/// Returns the spacing within charts, equal to the gutter between them. The scale of the charts is only known after
/// packing, so it is estimated from the areas. A texel of the estimate is slightly smaller than the final texel.
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

/// Encodes linear RGBA as an sRGB image.
pub(super) fn srgb_image(side: u32, texels: &[Vec4]) -> Image {
    let byte = |share: f32| (255.0 * share.clamp(0.0, 1.0)).round() as u8;
    let rgba = texels.iter().flat_map(|t| [linear_to_srgb(t.x), linear_to_srgb(t.y), linear_to_srgb(t.z), byte(t.w)]);
    Image { width: side, height: side, rgba: rgba.collect() }
}

/// Stores linear values as an image.
pub(crate) fn linear_image(side: u32, texels: &[Vec4]) -> Image {
    let byte = |share: f32| (255.0 * share.clamp(0.0, 1.0)).round() as u8;
    Image { width: side, height: side, rgba: texels.iter().flat_map(|t| t.to_array().map(byte)).collect() }
}

/// Duplicates vertices shared by several charts and returns the chart of each vertex, `u32::MAX` for no chart.
fn split_vertices(surface: &mut Surface, chart_of: &[u32]) -> Vec<u32> {
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

/// Packs boxes of tile coordinates into a texture. Returns the texels per tile, the gutter and the placements; `None`
/// if the boxes do not fit.
fn pack(boxes: &[(Vec2, Vec2)], side: u32, around: GutterKind) -> Option<(f32, u32, Vec<Placement>)> {
    let sizes: Vec<Vec2> = boxes.iter().map(|(min, max)| *max - *min).collect();
    let area: f32 = sizes.iter().map(|s| s.x * s.y).sum();
    let widest = sizes.iter().map(|s| s.max_element()).fold(0.0, f32::max);
    // Start with the scale allowed by the area, then reduce it step by step.
    let full = (side as f32 / area.max(1e-12).sqrt()).min(side as f32 / widest.max(1e-6));
    let scales = |full: f32| std::iter::successors(Some(full), |scale| Some(0.96 * scale)).take(80);
    let fit = |scale: f32, gutter: u32, turned: bool| {
        shelves(boxes, &sizes, scale, gutter, side, turned).map(|places| (scale, gutter, places))
    };
    match around {
        GutterKind::Room => {
            GUTTERS.into_iter().find_map(|gutter| scales(full).find_map(|scale| fit(scale, gutter, true)))
        }
        GutterKind::Reach { tiles, most_texels } => {
            let gutter = |scale: f32| (tiles * scale).ceil() as u32 + FILTER_GUTTER;
            scales(full.min(most_texels)).find_map(|scale| fit(scale, gutter(scale), false))
        }
    }
}

/// Packs boxes on shelves, the tallest first, row after row. With `turned`, boxes are rotated so that their longer side
/// is horizontal.
fn shelves(
    boxes: &[(Vec2, Vec2)],
    sizes: &[Vec2],
    scale: f32,
    gutter: u32,
    side: u32,
    turned: bool,
) -> Option<Vec<Placement>> {
    let turns = |size: Vec2| turned && size.y > size.x;
    let cell = |size: Vec2| {
        let texels = |x: f32| (x * scale).ceil() as u32 + 1 + 2 * gutter;
        if turns(size) { (texels(size.y), texels(size.x)) } else { (texels(size.x), texels(size.y)) }
    };
    let mut order: Vec<usize> = (0..boxes.len()).collect();
    order.sort_by_key(|i| (std::cmp::Reverse(cell(sizes[*i]).1), *i));
    let mut places = vec![Placement::default(); boxes.len()];
    let (mut x, mut y, mut row) = (0, 0, 0);
    for i in order {
        let (width, height) = cell(sizes[i]);
        if x + width > side {
            (x, y, row) = (0, y + row, 0);
        }
        if x + width > side || y + height > side {
            return None;
        }
        places[i] = Placement { at: (x, y), min: boxes[i].0, turned: turns(sizes[i]) };
        x += width;
        row = row.max(height);
    }
    Some(places)
}

#[cfg(test)]
#[path = "atlas_tests.rs"]
mod tests;
