//! Grid for finding triangles near a point.

use glam::{DVec3, IVec3, Vec3};
use std::collections::HashMap;

/// Returns the barycentric coordinates of the point of a triangle that is closest to `p` (Ericson, *Real-Time Collision
/// Detection*, 5.1.5).
pub(crate) fn closest_barycentric(p: Vec3, [a, b, c]: [Vec3; 3]) -> Vec3 {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return Vec3::X;
    }
    let (d3, d4) = (ab.dot(p - b), ac.dot(p - b));
    if d3 >= 0.0 && d4 <= d3 {
        return Vec3::Y;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let v = d1 / (d1 - d3);
        return Vec3::new(1.0 - v, v, 0.0);
    }
    let (d5, d6) = (ab.dot(p - c), ac.dot(p - c));
    if d6 >= 0.0 && d5 <= d6 {
        return Vec3::Z;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let w = d2 / (d2 - d6);
        return Vec3::new(1.0 - w, 0.0, w);
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        let w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return Vec3::new(0.0, 1.0 - w, w);
    }
    let sum = (va + vb + vc).recip();
    Vec3::new(va * sum, vb * sum, vc * sum)
}

/// Triangles by the grid cells that their bounding boxes overlap.
pub(crate) struct TriangleGrid {
    size: f32,
    of_cell: HashMap<IVec3, Vec<u32>>,
}

/// Maximum mean number of cells per triangle. Cells are enlarged if a few triangles are far larger than the rest.
const MOST_CELLS: f64 = 64.0;

impl TriangleGrid {
    /// Builds the grid with cells of at least `size`. Triangles with non-finite corners are ignored.
    pub(crate) fn new(triangles: &[[u32; 3]], place: &dyn Fn(u32) -> Vec3, size: f32) -> Self {
        let corners_of = |corners: &[u32; 3]| {
            let [a, b, c] = corners.map(place);
            (a.min(b).min(c), a.max(b).max(c))
        };
        let is_finite = |(low, high): &(Vec3, Vec3)| low.is_finite() && high.is_finite();
        let extents: Vec<DVec3> = triangles
            .iter()
            .map(corners_of)
            .filter(is_finite)
            .map(|(low, high)| high.as_dvec3() - low.as_dvec3())
            .collect();
        let mut size = size;
        let met = |size: f32| extents.iter().map(|e| (e / f64::from(size) + 1.0).element_product()).sum::<f64>();
        while met(size) > MOST_CELLS * extents.len() as f64 {
            size *= 2.0;
        }
        let mut of_cell: HashMap<IVec3, Vec<u32>> = HashMap::new();
        for (number, ends) in (0..).zip(triangles.iter().map(corners_of)) {
            if !is_finite(&ends) {
                continue;
            }
            let [low, high] = [ends.0, ends.1].map(|p| (p / size).floor().as_ivec3());
            for x in low.x..=high.x {
                for y in low.y..=high.y {
                    for z in low.z..=high.z {
                        of_cell.entry(IVec3::new(x, y, z)).or_default().push(number);
                    }
                }
            }
        }
        Self { size, of_cell }
    }

    /// Returns the triangles that may be within `reach` of a point, in any order and possibly more than once.
    pub(crate) fn within(&self, p: Vec3, reach: f32) -> Box<dyn Iterator<Item = u32> + '_> {
        let [low, high] = [p - reach, p + reach].map(|p| (p / self.size).floor().as_ivec3());
        let count = ((high.as_dvec3() - low.as_dvec3()) + 1.0).element_product();
        if count > self.of_cell.len() as f64 {
            // For a large reach, iterating over the occupied cells is faster.
            let is_within = move |cell: &IVec3| cell.cmpge(low).all() && cell.cmple(high).all();
            let cells = self.of_cell.iter().filter(move |(cell, _)| is_within(cell));
            return Box::new(cells.flat_map(|(_, triangles)| triangles).copied());
        }
        let cells = (low.x..=high.x).flat_map(move |x| (low.y..=high.y).map(move |y| (x, y)));
        let cells = cells.flat_map(move |(x, y)| (low.z..=high.z).map(move |z| IVec3::new(x, y, z)));
        Box::new(cells.filter_map(|cell| self.of_cell.get(&cell)).flatten().copied())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_triangle_among_small_ones_fills_few_cells() {
        // The grid has a thousand triangles of a millimetre, one of a hundred metres, and one with non-finite corners.
        let mut places: Vec<Vec3> = (0..3000).map(|i| Vec3::new(i as f32, (i % 3) as f32, 0.0) * 1e-3).collect();
        places.extend([Vec3::ZERO, Vec3::X * 100.0, Vec3::ONE * 100.0, Vec3::ZERO, Vec3::X, Vec3::splat(f32::NAN)]);
        let triangles: Vec<[u32; 3]> = (0..1002).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let place = |v: u32| places[v as usize];
        let cells = TriangleGrid::new(&triangles, &place, 1e-3);
        let met: usize = cells.of_cell.values().map(Vec::len).sum();
        assert!(met <= 64 * 1001 && cells.size > 0.1, "{met} cells of {} m", cells.size);
        // Some queries are near the triangles. Others are far away, with a reach for which iterating over all occupied
        // cells is faster.
        for (p, reach, expected) in [(Vec3::X * 0.5, 0.1, 166), (Vec3::NEG_X * 1e6, 1.1e6, 7), (Vec3::Y * 1e30, 1.0, 0)]
        {
            let found: std::collections::BTreeSet<u32> = cells.within(p, reach).collect();
            let missed = (0..1001u32).find(|t| {
                let corners = triangles[*t as usize].map(place);
                let w = closest_barycentric(p, corners);
                let at = corners[0] * w.x + corners[1] * w.y + corners[2] * w.z;
                at.distance(p) <= 0.99 * reach && !found.contains(t)
            });
            assert_eq!(missed, None, "from {p}");
            assert!(found.len() >= expected && !found.contains(&1001), "from {p}: {} triangles", found.len());
        }
    }
}
