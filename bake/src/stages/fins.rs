//! Stage `fins`: makes a quad of hair on every edge of the furred mesh (Lengyel et al. 2001, "fin rendering").
//!
//! Silhouette edges are known only when the model is drawn. So every edge has a fin, and the runtime shows those that
//! are seen from the side.

use crate::noise;
use crate::stages::groom::VertexGroom;
use crate::stages::slice::{FIN_SLICES, fin_slice_along};
use crate::stages::surface::Surface;
use glam::{Vec2, Vec3};
use pelage_formats::Fin;
use std::collections::HashMap;

/// Fins of a surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EdgeFins {
    /// Fins, one per edge.
    pub fins: Vec<Fin>,
    /// Triangle of each fin, in ascending order. It determines the material of the fin.
    pub triangles: Vec<u32>,
    /// Depth of the hair that the densest fins show, measured across the fin, in widths of the tile. The depth is in
    /// the range of the recipe's `fins.depth`. The densest fins have opacity 1, the others less.
    pub depth: f32,
}

/// Creates a fin on every edge of the furred mesh.
///
/// * `furred`: one per material; missing entries count as bare
/// * `coat`: groom at the surface's vertices; an edge without hair at both ends has no fin
/// * `height_m`: height of the fur where `coat` does not shorten it, metres
/// * `tile_size_m`: width of the tile on the mesh surface, metres, greater than 0
///
/// Edges are joined by position, so a border between patches or a seam has one fin. Its tile frame, material and
/// colours come from the first triangle in mesh order. Boundary edges are treated like all others.
///
/// The length of a fin in the texture is the edge's length at rest. Its start in the texture is random but
/// deterministic for the mesh, so that neighbouring fins do not repeat (Lengyel et al. 2001).
///
/// A view ray along the outline crosses several fins. The more it crosses, the less hair each of them shows. Their
/// number is computed from the edge's share of the surface and from the curvature.
pub fn fins(surface: &Surface, furred: &[bool], coat: &VertexGroom, height_m: f32, tile_size_m: f32) -> EdgeFins {
    let place = |vertex: u32| surface.rest.positions[vertex as usize];
    let height_at = |vertex: u32| {
        let bare = coat.bareness[vertex as usize] >= 1.0;
        if bare { 0.0 } else { coat.length[vertex as usize] * height_m }
    };
    let edges = edges(surface, furred);
    let curvatures = curvatures(surface, &edges);
    let mut out = EdgeFins::default();
    let mut depths = Vec::new();
    for edge in &edges {
        let [a, b] = edge.ends;
        let height = 0.5 * (height_at(a) + height_at(b));
        let length = place(a).distance(place(b));
        if height <= 0.0 || length <= 0.0 {
            continue;
        }
        let curvature = 0.5 * (curvatures[edge.points[0]] + curvatures[edge.points[1]]);
        depths.push(slab_depth(edge.area / length, curvature, height));
        let along: Vec2 = surface.tile_uvs[b as usize] - surface.tile_uvs[a as usize];
        let (slab, against) = fin_slice_along(along);
        let periods = length / (tile_size_m * FIN_SLICES[slab].period());
        out.fins.push(Fin {
            a,
            b,
            start: noise::uniform(START, out.fins.len() as u64),
            length: if against { -periods } else { periods },
            slab: slab as u32,
            opacity: 1.0,
        });
        out.triangles.push(edge.triangle);
    }
    let mut sorted = depths.clone();
    sorted.sort_by(f32::total_cmp);
    let densest = sorted.get(sorted.len() * 9 / 10).copied().unwrap_or(0.0);
    out.depth = (densest / tile_size_m).clamp(1e-3, 8.0);
    for (fin, depth) in out.fins.iter_mut().zip(depths) {
        fin.opacity = if densest > 0.0 { (depth / densest).min(1.0) } else { 1.0 };
    }
    out
}

/// Returns the depth of the hair that a fin shows, metres.
///
/// * `strip_m`: width of the strip of surface that the fin represents, metres
/// * `curvature`: curvature of the surface, 1 / metres
/// * `height_m`: height of the fur, metres
///
/// At a surface of radius R, a tangential view ray passes through 2 √((R + H)² − R²) of fur of height H. The number of
/// fins that it crosses is proportional to this length divided by the strip's width. Together, these fins should show
/// as much hair as the layers that the ray crosses. The number of layers is the same for any R, so this amount of hair
/// grows on a length of surface proportional to H.
fn slab_depth(strip_m: f32, curvature: f32, height_m: f32) -> f32 {
    DENSITY * strip_m / (1.0 + 2.0 / (curvature * height_m).max(1e-3)).sqrt()
}

/// Depth of the hair divided by the width of the strip, in the limit of high curvature. Measured by
/// `stability/silhouette.rs`.
const DENSITY: f32 = 0.6;
/// Number of the random stream for the starts of fins in the texture.
const START: u64 = 0x66_696e;

/// Edge of the furred mesh, whose triangles are joined by position.
struct Edge {
    /// Vertices of the first triangle at the edge, in the triangle's order.
    ends: [u32; 2],
    /// Indices of the distinct positions of the two ends.
    points: [usize; 2],
    /// First triangle at the edge.
    triangle: u32,
    /// Sum of a third of the area of each triangle at the edge, square metres at rest.
    area: f32,
}

/// Returns the edges in the order of their first triangles.
fn edges(surface: &Surface, furred: &[bool]) -> Vec<Edge> {
    let mesh = &surface.mesh;
    let place = |vertex: u32| surface.rest.positions[vertex as usize];
    let mut points: HashMap<[u32; 3], usize> = HashMap::new();
    let mut numbers: HashMap<[usize; 2], usize> = HashMap::new();
    let mut out: Vec<Edge> = Vec::new();
    for part in mesh.parts.iter().filter(|p| furred.get(p.material).copied().unwrap_or(false)) {
        for index in part.first_triangle..part.first_triangle + part.triangle_count {
            let corners = mesh.triangles[index];
            let [p, q, r] = corners.map(place);
            let third = (q - p).cross(r - p).length() / 6.0;
            let [i, j, k] = corners.map(|vertex| {
                // Adding zero turns −0 into +0, so that both have the same bits.
                let key = (mesh.positions[vertex as usize] + Vec3::ZERO).to_array().map(f32::to_bits);
                let next = points.len();
                *points.entry(key).or_insert(next)
            });
            for (ends, points) in [
                ([corners[0], corners[1]], [i, j]),
                ([corners[1], corners[2]], [j, k]),
                ([corners[2], corners[0]], [k, i]),
            ] {
                if points[0] == points[1] {
                    continue;
                }
                let key = [points[0].min(points[1]), points[0].max(points[1])];
                let next = out.len();
                let number = *numbers.entry(key).or_insert(next);
                if number == next {
                    out.push(Edge { ends, points, triangle: index as u32, area: 0.0 });
                }
                out[number].area += third;
            }
        }
    }
    out
}

/// Returns the mean absolute curvature along the edges at each position, 1 / metres. The curvature along an edge is the
/// change of the normal divided by the length.
fn curvatures(surface: &Surface, edges: &[Edge]) -> Vec<f32> {
    let count = edges.iter().flat_map(|e| e.points).max().map_or(0, |last| last + 1);
    let mut sums = vec![(0f32, 0f32); count];
    for edge in edges {
        let [a, b] = edge.ends.map(|v| v as usize);
        let step = surface.rest.positions[b] - surface.rest.positions[a];
        let turn = (surface.rest.normals[b] - surface.rest.normals[a]).dot(step).abs();
        let length_squared = step.length_squared();
        if length_squared > 0.0 {
            for point in edge.points {
                sums[point].0 += turn / length_squared;
                sums[point].1 += 1.0;
            }
        }
    }
    sums.into_iter().map(|(sum, n)| if n > 0.0 { sum / n } else { 0.0 }).collect()
}
