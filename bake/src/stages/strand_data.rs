//! Strands of the tile in the form that a package stores: a few points per strand. Every prefix of the list is an even
//! sample of the fur.

use crate::stages::simulate::{Strands, TileHair};
use crate::stages::visibility::{Visibility, encode_visibility};
use glam::{Vec3, Vec4};
use pelage_formats::meaning::linear_to_srgb;
use pelage_formats::{StrandPoint, StrandsData};

/// Converts the strands.
///
/// * `visible`: visibility of dry and of wet hair, if the package has it; otherwise all light reaches each point
/// * `points`: number of points per strand, 2 or more
pub fn strands(hair: &TileHair, visible: [Option<&Visibility>; 2], points: u32) -> StrandsData {
    let dry = &hair.strands;
    let order = even_order(dry);
    let root = |strand: &u32| {
        let root = dry.points[dry.range(*strand as usize).start].truncate();
        // The difference can round up to 1, which is outside of 0..1.
        (root - root.floor()).min(glam::Vec2::splat(1.0 - f32::EPSILON)).to_array()
    };
    let sets = std::iter::once(dry).chain(&hair.wet).zip(visible);
    let resampled = sets.flat_map(|(set, visible)| {
        order.iter().flat_map(move |strand| resampled(set, visible, *strand as usize, points))
    });
    StrandsData { points_per_strand: points, points: resampled.collect(), roots: order.iter().map(root).collect() }
}

/// Returns the indices of all strands that have points, ordered so that every prefix covers the tile as evenly as the
/// whole. The order is by the reversed bits of the strands' rank along a Z-order curve.
fn even_order(strands: &Strands) -> Vec<u32> {
    let place = |strand: u32| {
        let root = strands.points[strands.range(strand as usize).start];
        let [x, y] = [root.x, root.y].map(|c| (((c - c.floor()) * 65536.0) as u32).min(65535));
        (0..16).fold(0u32, |code, bit| code | (x >> bit & 1) << (2 * bit) | (y >> bit & 1) << (2 * bit + 1))
    };
    let mut along: Vec<u32> = (0..strands.len() as u32).filter(|s| strands.range(*s as usize).len() > 1).collect();
    along.sort_by_key(|strand| (place(*strand), *strand));
    let bits = along.len().next_power_of_two().trailing_zeros();
    let reversed = |i: u32| if bits == 0 { 0 } else { i.reverse_bits() >> (32 - bits) };
    (0..1u32 << bits).filter_map(|i| along.get(reversed(i) as usize).copied()).collect()
}

/// Returns evenly spaced points along a strand.
fn resampled(
    strands: &Strands,
    visible: Option<&Visibility>,
    strand: usize,
    points: u32,
) -> impl Iterator<Item = StrandPoint> {
    let range = strands.range(strand);
    let own = &strands.points[range.clone()];
    let mut along = vec![0.0f32];
    along.extend(own.windows(2).scan(0.0, |sum, pair| {
        *sum += pair[0].distance(pair[1]);
        Some(*sum)
    }));
    let length = along[along.len() - 1];
    let root = own[0];
    (0..points).map(move |k| {
        let at = length * k as f32 / (points - 1) as f32;
        let after = along.partition_point(|a| *a < at).clamp(1, along.len() - 1);
        let gap = along[after] - along[after - 1];
        let t = if gap > 0.0 { ((at - along[after - 1]) / gap).clamp(0.0, 1.0) } else { 0.0 };
        let (i, j) = (range.start + after - 1, range.start + after);
        let place = strands.points[i].lerp(strands.points[j], t);
        let color: Vec3 = strands.colors[i].lerp(strands.colors[j], t);
        let light = visible.map_or(Vec4::X, |v| v.points[i].lerp(v.points[j], t));
        StrandPoint {
            aside: (place - root).truncate().to_array(),
            height: (place.z / strands.height).clamp(0.0, 1.0),
            radius: strands.radii[i] + (strands.radii[j] - strands.radii[i]) * t,
            color: color.to_array().map(linear_to_srgb),
            visibility: encode_visibility(light),
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Makes strands on a grid of `side` by `side` roots, in rows. Each strand goes sideways and then up, and its
    /// brightness increases with height.
    fn grid(side: u32) -> TileHair {
        let mut strands = Strands { offsets: vec![0], height: 0.5, root_color: Vec3::ONE, ..Strands::default() };
        for (x, y) in (0..side).flat_map(|y| (0..side).map(move |x| (x, y))) {
            let root = Vec3::new(x as f32 + 0.5, y as f32 + 0.5, 0.0) / side as f32;
            for (step, light) in [(Vec3::ZERO, 0.0), (Vec3::new(0.3, 0.0, 0.0), 0.0), (Vec3::new(0.3, 0.0, 0.5), 1.0)] {
                strands.points.push(root + step);
                strands.radii.push(0.01 * (1.0 - light));
                strands.colors.push(Vec3::splat(light));
            }
            strands.offsets.push(strands.points.len() as u32);
        }
        TileHair { strands, ..TileHair::default() }
    }

    #[test]
    fn points_are_spaced_evenly_along_the_strand() {
        let made = strands(&grid(1), [None; 2], 5);
        assert_eq!((made.roots.as_slice(), made.points.len()), ([[0.5, 0.5]].as_slice(), 5));
        // The strand has a length of 0.8, of which 0.3 is along the surface. Points are 0.2 apart.
        let places = [[0.0, 0.0], [0.2, 0.0], [0.3, 0.2], [0.3, 0.6], [0.3, 1.0]];
        for (point, [aside, height]) in made.points.iter().zip(places) {
            assert!((point.aside[0] - aside).abs() < 1e-6 && point.aside[1] == 0.0, "{point:?}");
            assert!((point.height - height).abs() < 1e-6, "{point:?}");
            assert!((point.radius - 0.01 * (1.0 - height)).abs() < 1e-6, "{point:?}");
            assert_eq!(point.color, [linear_to_srgb(height); 3]);
            assert_eq!(point.visibility, encode_visibility(Vec4::X));
        }
    }

    #[test]
    fn every_prefix_is_an_even_sample() {
        let made = strands(&grid(8), [None; 2], 2);
        assert_eq!(made.roots.len(), 64);
        for quarter in [4, 16] {
            // The first 4 or 16 strands are spread evenly: one root in each cell of a grid with as many cells.
            let side = f64::from(quarter).sqrt() as f32;
            let mut cells = vec![0; quarter as usize];
            for [u, v] in &made.roots[..quarter as usize] {
                cells[((v * side).floor() * side + (u * side).floor()) as usize] += 1;
            }
            assert!(cells.iter().all(|n| *n == 1), "{quarter}: {cells:?}");
        }
        // Each strand occurs once, for any number of strands.
        let made = strands(&grid(7), [None; 2], 2);
        let mut roots: Vec<_> = made.roots.iter().map(|r| r.map(f32::to_bits)).collect();
        roots.sort_unstable();
        roots.dedup();
        assert_eq!(roots.len(), 49);
    }
}
