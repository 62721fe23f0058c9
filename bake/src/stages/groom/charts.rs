//! Charts: parts of the surface whose tile coordinates do not overlap, so that each can be laid out flat in a texture.
//!
//! The patches of the parameterization are nearly isometric, which suits a texture, but a patch may wind around and
//! overlap itself. So charts are grown over edges within a patch. A chart accepts a triangle only if the triangle
//! overlaps none of the chart. Also, the triangle must not be close in the tile to one that is far away on the surface,
//! because filtering would mix the two.

use glam::{Vec2, Vec3};
use pelage_import::mesh::Mesh;
use std::collections::{BTreeMap, VecDeque};

/// Tolerance for rounding. Triangles that overlap by less than this share of their size only touch.
const TOUCH: f32 = 1e-3;

/// Triangle in the tile and on the surface.
#[derive(Clone, Copy)]
struct ChartTriangle {
    uv: [Vec2; 3],
    /// Corners on the surface, in units of a tile.
    places: [Vec3; 3],
}

impl ChartTriangle {
    /// Returns the position on the plane of the triangle for a point of the tile.
    fn position_on_plane(&self, p: Vec2) -> Vec3 {
        let w = barycentric(&self.uv, p).unwrap_or(Vec3::X);
        self.places[0] * w.x + self.places[1] * w.y + self.places[2] * w.z
    }

    /// Returns the distance between a point of the tile and the triangle, tiles.
    fn distance(&self, p: Vec2) -> f32 {
        if barycentric(&self.uv, p).is_some_and(|w| w.min_element() >= 0.0) {
            return 0.0;
        }
        let to_edge = |k: usize| {
            let (a, edge) = (self.uv[k], self.uv[(k + 1) % 3] - self.uv[k]);
            let along = ((p - a).dot(edge) / edge.length_squared().max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
            p.distance(a + edge * along)
        };
        to_edge(0).min(to_edge(1)).min(to_edge(2))
    }
}

/// Spacing within a chart, and size of a tile on the surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spacing {
    /// Minimum distance in the tile between triangles that are not neighbours on the surface, tiles.
    pub(super) margin: f32,
    /// Width of a tile on the surface, metres.
    pub(super) tile_m: f32,
}

/// Returns the chart of each triangle, numbered from 0; `u32::MAX` where `patch_of_triangle` is `u32::MAX`. The result
/// is deterministic: each chart grows from the first triangle that has no chart yet.
///
/// `positions` (metres) and `uvs` (tile coordinates) have one entry per vertex. Triangles with two vertices in common
/// are neighbours; `same` maps each vertex to the one that represents it.
pub(super) fn charts(
    mesh: &Mesh,
    patch_of_triangle: &[u32],
    same: impl Fn(u32) -> u32,
    positions: &[Vec3],
    uvs: &[Vec2],
    spacing: &Spacing,
) -> Vec<u32> {
    let neighbors = neighbors(mesh, patch_of_triangle, same);
    let piece = |t: usize| {
        let corners = mesh.triangles[t].map(|v| v as usize);
        ChartTriangle { uv: corners.map(|v| uvs[v]), places: corners.map(|v| positions[v] / spacing.tile_m) }
    };
    let mut chart_of = vec![u32::MAX; mesh.triangles.len()];
    let mut count = 0;
    for start in 0..mesh.triangles.len() {
        if chart_of[start] != u32::MAX || patch_of_triangle[start] == u32::MAX {
            continue;
        }
        let mut grid = Grid::new(piece(start).uv, spacing.margin);
        let mut queue = VecDeque::from([start]);
        while let Some(t) = queue.pop_front() {
            if chart_of[t] != u32::MAX || !grid.insert(piece(t)) {
                continue;
            }
            chart_of[t] = count;
            queue.extend(neighbors[t].iter().flatten().map(|n| *n as usize).filter(|n| chart_of[*n] == u32::MAX));
        }
        if chart_of[start] == u32::MAX {
            // The first triangle of a chart overlaps nothing, so the grid rejects it only if its coordinates are not
            // finite or too large. It then forms a separate chart.
            chart_of[start] = count;
        }
        count += 1;
    }
    chart_of
}

/// Returns the neighbours of each triangle within its patch, one per edge. If more than two triangles share an edge,
/// they are paired.
fn neighbors(mesh: &Mesh, patch_of_triangle: &[u32], same: impl Fn(u32) -> u32) -> Vec<[Option<u32>; 3]> {
    let mut edges = Vec::new();
    for (t, triangle) in mesh.triangles.iter().enumerate().filter(|(t, _)| patch_of_triangle[*t] != u32::MAX) {
        for k in 0..3 {
            let (a, b) = (same(triangle[k]), same(triangle[(k + 1) % 3]));
            edges.push((patch_of_triangle[t], a.min(b), a.max(b), t as u32, k));
        }
    }
    edges.sort_unstable();
    let mut neighbors = vec![[None; 3]; mesh.triangles.len()];
    for pair in edges.windows(2) {
        let [(patch, a, b, t, k), (other_patch, c, d, other, l)] = pair else { continue };
        if (patch, a, b) == (other_patch, c, d) {
            neighbors[*t as usize][*k] = Some(*other);
            neighbors[*other as usize][*l] = Some(*t);
        }
    }
    neighbors
}

/// Triangles in the plane, indexed by a grid.
struct Grid {
    cell: f32,
    margin: f32,
    triangles: Vec<ChartTriangle>,
    cells: BTreeMap<(i32, i32), Vec<u32>>,
}

impl Grid {
    /// Creates an empty grid with cells that suit triangles of the size of `like`.
    fn new(like: [Vec2; 3], margin: f32) -> Self {
        let (min, max) = bounds(&like);
        let cell = (max - min).max_element().max(margin);
        let cell = if cell.is_finite() && cell > 1e-12 { 2.0 * cell } else { 1.0 };
        Self { cell, margin, triangles: Vec::new(), cells: BTreeMap::new() }
    }

    /// Inserts a triangle unless it conflicts with one in the grid, is too large for the grid, or has invalid
    /// coordinates. Returns whether it was inserted.
    fn insert(&mut self, piece: ChartTriangle) -> bool {
        let (min, max) = bounds(&piece.uv);
        let (low, high) = (((min - self.margin) / self.cell).floor(), ((max + self.margin) / self.cell).floor());
        // Beyond these limits, cell indices are inexact in a float, or the number of cells is too large.
        let small = (high - low).max_element() < 4096.0 && low.abs().max(high.abs()).max_element() < 1e6;
        if !(piece.uv.iter().all(|p| p.is_finite()) && small) {
            return false;
        }
        let range = || (low.y as i32..=high.y as i32).flat_map(|y| (low.x as i32..=high.x as i32).map(move |x| (x, y)));
        let there = range().filter_map(|cell| self.cells.get(&cell)).flatten();
        if there.map(|t| &self.triangles[*t as usize]).any(|other| self.conflicts(&piece, other)) {
            return false;
        }
        let index = self.triangles.len() as u32;
        range().for_each(|cell| self.cells.entry(cell).or_default().push(index));
        self.triangles.push(piece);
        true
    }

    /// Whether two triangles overlap. Also true if they are so near in the tile that filtering mixes them, although
    /// they are apart on the surface.
    fn conflicts(&self, a: &ChartTriangle, b: &ChartTriangle) -> bool {
        let elsewhere = |a: &ChartTriangle, b: &ChartTriangle| {
            let near = b.uv.iter().zip(&b.places).filter(|(uv, _)| a.distance(**uv) < self.margin);
            near.map(|(uv, place)| a.position_on_plane(*uv).distance(*place)).any(|gap| gap > self.margin)
        };
        overlap(&a.uv, &b.uv, 0.0) || (overlap(&a.uv, &b.uv, self.margin) && (elsewhere(a, b) || elsewhere(b, a)))
    }
}

pub(super) fn bounds(points: &[Vec2]) -> (Vec2, Vec2) {
    let extend = |(min, max): (Vec2, Vec2), p: &Vec2| (min.min(*p), max.max(*p));
    points.iter().fold((Vec2::splat(f32::INFINITY), Vec2::splat(f32::NEG_INFINITY)), extend)
}

/// Whether the interiors of two triangles overlap or come closer than `margin`. This is the case if no edge of either
/// separates them (separating axis theorem).
fn overlap(a: &[Vec2; 3], b: &[Vec2; 3], margin: f32) -> bool {
    let axes = (0..6).map(|k| {
        let t = if k < 3 { a } else { b };
        (t[(k + 1) % 3] - t[k % 3]).perp().normalize_or_zero()
    });
    axes.filter(|axis| *axis != Vec2::ZERO).all(|axis| {
        let span = |t: &[Vec2; 3]| {
            let d = t.map(|p| p.dot(axis));
            (d[0].min(d[1]).min(d[2]), d[0].max(d[1]).max(d[2]))
        };
        let ((a0, a1), (b0, b1)) = (span(a), span(b));
        let allowed = if margin > 0.0 { -margin } else { TOUCH * (a1 - a0).min(b1 - b0) };
        a1.min(b1) - a0.max(b0) > allowed
    })
}

/// Returns barycentric coordinates; `None` for a triangle without area.
pub(super) fn barycentric([a, b, c]: &[Vec2; 3], p: Vec2) -> Option<Vec3> {
    let area = (*b - *a).perp_dot(*c - *a);
    if area == 0.0 || !area.is_finite() {
        return None;
    }
    let (wb, wc) = ((p - *a).perp_dot(*c - *a) / area, (*b - *a).perp_dot(p - *a) / area);
    Some(Vec3::new(1.0 - wb - wc, wb, wc))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Builds a strip of quads whose uv bends around by `turns` turns.
    fn strip(quads: usize, turns: f32) -> (Mesh, Vec<Vec2>) {
        let mut mesh = Mesh::default();
        let mut uvs = Vec::new();
        for i in 0..=quads {
            let angle = i as f32 / quads as f32 * turns * std::f32::consts::TAU;
            uvs.extend([1.0, 1.5].map(|r| Vec2::from_angle(angle) * r));
            if i < quads {
                let a = 2 * i as u32;
                mesh.triangles.extend([[a, a + 1, a + 3], [a, a + 3, a + 2]]);
            }
        }
        (mesh, uvs)
    }

    /// Returns the charts of a flat mesh whose positions equal its tile coordinates.
    fn in_plane(mesh: &Mesh, patches: &[u32], uvs: &[Vec2]) -> Vec<u32> {
        let positions: Vec<Vec3> = uvs.iter().map(|uv| uv.extend(0.0)).collect();
        charts(mesh, patches, |v| v, &positions, uvs, &Spacing { margin: 0.05, tile_m: 1.0 })
    }

    #[test]
    fn charts_split_where_tile_neighbours_are_far_apart_on_the_surface() {
        // On the surface, the strip climbs like a spiral staircase. Its ends are far apart there, but a hundredth of a
        // turn apart in the tile.
        let (mesh, uvs) = strip(60, 0.995);
        assert_eq!(in_plane(&mesh, &vec![0; mesh.triangles.len()], &uvs).iter().max(), Some(&0));
        let stair: Vec<Vec3> = uvs.iter().enumerate().map(|(i, uv)| uv.extend(i as f32 / 40.0)).collect();
        let parted =
            charts(&mesh, &vec![0; mesh.triangles.len()], |v| v, &stair, &uvs, &Spacing { margin: 0.05, tile_m: 1.0 });
        assert_eq!(parted.iter().max(), Some(&1));
        assert!(parted.iter().filter(|c| **c == 1).count() < 20, "{parted:?}");
    }

    #[test]
    fn self_overlapping_patches_are_split() {
        for (turns, expected) in [(0.4, 1), (0.95, 1), (1.5, 2), (2.5, 3)] {
            let (mesh, uvs) = strip(60, turns);
            let charts = in_plane(&mesh, &vec![0; mesh.triangles.len()], &uvs);
            assert_eq!(charts.iter().max(), Some(&(expected - 1)), "{turns} turns");
            let corners = |t: usize| mesh.triangles[t].map(|v| uvs[v as usize]);
            for (t, o) in (0..charts.len()).flat_map(|t| (0..t).map(move |o| (t, o))) {
                assert!(charts[t] != charts[o] || !overlap(&corners(t), &corners(o), 0.0), "{t} lies on {o}");
            }
        }
    }

    #[test]
    fn patches_have_separate_charts_and_bare_triangles_none() {
        let (mesh, uvs) = strip(4, 0.4);
        let charts = in_plane(&mesh, &[0, 0, 1, 1, u32::MAX, 1, 1, 1], &uvs);
        assert_eq!(charts, [0, 0, 1, 1, u32::MAX, 2, 2, 2]);
    }

    #[test]
    fn degenerate_triangles_are_charts_of_their_own() {
        let (mesh, mut uvs) = strip(2, 0.3);
        uvs[0] = Vec2::NAN;
        let charts = in_plane(&mesh, &[0; 4], &uvs);
        assert_eq!(charts, [0, 1, 2, 2]);
    }
}
