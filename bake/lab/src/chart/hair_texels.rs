//! Layer texels that hold hair, with the strand points that they contain.

use glam::DVec3;
use pelage_bake::stages::simulate::Strands;
use std::collections::BTreeMap;

/// Number of points along a strand per texel width or per layer spacing, whichever of the two is shorter.
const POINTS_PER_TEXEL: f64 = 8.0;

/// Point on the axis of a strand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct StrandPoint {
    /// Position in tile widths, not wrapped into the tile.
    pub(super) at: DVec3,
    /// Index of the strand.
    pub(super) strand: u32,
    /// Surface area of the hair that the point represents, up to a common factor.
    pub(super) area: f64,
}

/// Texel of a layer.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct HairTexel {
    /// Number of times that the texel was sampled.
    pub(super) times: u32,
    /// All strand points in the texel.
    pub(super) places: Vec<StrandPoint>,
}

impl HairTexel {
    /// Returns the fraction of the hair's surface area for which `lit` holds.
    pub(super) fn lit(&self, lit: impl Fn(&StrandPoint) -> bool) -> f64 {
        let area = |places: &mut dyn Iterator<Item = &StrandPoint>| places.map(|p| p.area).sum::<f64>();
        area(&mut self.places.iter().filter(|p| lit(p))) / area(&mut self.places.iter()).max(f64::MIN_POSITIVE)
    }
}

/// Samples `count` texels in proportion to their hair surface. Keys of the result are layer · texels² + row · texels +
/// column.
///
/// A layer represents half a layer spacing above and below it, as in slicing. The lowest layer above the mesh surface
/// extends down to the surface; layer 0 has no hair.
///
/// * `texels`: number of texels along a side of the tile
/// * `layers`: number of layers of the volume, layer 0 included; two or more
pub(super) fn hair_texels(strands: &Strands, texels: u32, layers: u32, count: u32) -> BTreeMap<usize, HairTexel> {
    let n = f64::from(texels);
    let spacing = f64::from(strands.height) / f64::from(layers - 1);
    let texel_at = |p: DVec3| {
        let layer = (p.z / spacing).round().clamp(1.0, f64::from(layers - 1)) as usize;
        let [x, y] = [p.x, p.y].map(|x| (x.rem_euclid(1.0) * n).min(n - 1.0) as usize);
        (layer * texels as usize + y) * texels as usize + x
    };
    let mut area = 0.0;
    walk(strands, n, spacing, |place| area += place.area);
    let (mut sum, mut drawn) = (0.0, 0);
    let mut out = BTreeMap::<usize, HairTexel>::new();
    walk(strands, n, spacing, |place| {
        sum += place.area;
        // Number of samples due up to this point. The offset of half a sample makes both ends of the sequence equally
        // likely.
        let due = (sum / area * f64::from(count) + 0.5).min(f64::from(count)) as u32;
        if due > drawn {
            out.entry(texel_at(place.at)).or_default().times += due - drawn;
            drawn = due;
        }
    });
    // Collects points only for the sampled texels, because all points of a fine tile do not fit into memory.
    walk(strands, n, spacing, |place| {
        if let Some(texel) = out.get_mut(&texel_at(place.at)) {
            texel.places.push(place);
        }
    });
    out
}

/// Visits points along all strands, from each root to its tip.
fn walk(strands: &Strands, texels: f64, spacing: f64, mut visit: impl FnMut(StrandPoint)) {
    for strand in 0..strands.len() {
        let range = strands.range(strand);
        for i in range.start..range.end.saturating_sub(1) {
            let (a, b) = (strands.points[i].as_dvec3(), strands.points[i + 1].as_dvec3());
            let [from, to] = [strands.radii[i], strands.radii[i + 1]].map(f64::from);
            let way = b - a;
            let pieces =
                (POINTS_PER_TEXEL * (way.truncate().length() * texels).max(way.z.abs() / spacing)).ceil().max(1.0);
            for piece in 0..pieces as u32 {
                let share = (f64::from(piece) + 0.5) / pieces;
                let area = (from + (to - from) * share) * way.length() / pieces;
                visit(StrandPoint { at: a + way * share, strand: strand as u32, area });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Vec3, vec3};

    /// Checks an upright strand, and a horizontal strand twice as thick that crosses the tile's border. All samples
    /// must be on the strands, in proportion to their surface.
    #[test]
    fn texels_are_sampled_in_proportion_to_their_hair() {
        let strands = Strands {
            points: vec![vec3(0.3, 0.6, 0.0), vec3(0.3, 0.6, 0.5), vec3(0.9, 0.1, 0.3), vec3(1.4, 0.1, 0.3)],
            radii: vec![0.01, 0.01, 0.02, 0.02],
            colors: vec![Vec3::ONE; 4],
            offsets: vec![0, 2, 4],
            height: 0.5,
            root_color: Vec3::ONE,
        };
        let (n, layers, count) = (10, 6, 3000);
        let found = hair_texels(&strands, n, layers, count);
        assert_eq!(found.values().map(|t| t.times).sum::<u32>(), count);
        let times = |of: &dyn Fn(usize, usize, usize) -> bool| -> u32 {
            let place = |i: usize| (i % 10, i / 10 % 10, i / 100);
            found.iter().filter(|(i, _)| of(place(**i).0, place(**i).1, place(**i).2)).map(|(_, t)| t.times).sum()
        };
        // The upright strand has a third of the samples. The outermost layer represents half a layer spacing of the
        // strand, and layer 1 represents one and a half.
        assert!(times(&|x, y, _| (x, y) == (3, 6)).abs_diff(1000) <= 1);
        for (layer, slabs) in [(0, 0), (1, 3), (2, 2), (3, 2), (4, 2), (5, 1)] {
            assert!(times(&|x, y, k| (x, y, k) == (3, 6, layer)).abs_diff(100 * slabs) <= 1, "layer {layer}");
        }
        // The horizontal strand is only in layer 3. It extends from the last column of texels across the tile's border.
        assert!(times(&|x, y, k| y == 1 && k == 3 && (x == 9 || x < 4)).abs_diff(2000) <= 1);
        for texel in found.values() {
            assert!(!texel.places.is_empty());
            assert_eq!((texel.lit(|_| true), texel.lit(|_| false)), (1.0, 0.0));
        }
        let texel = &found[&((n * n + 60 + 3) as usize)];
        assert!(
            (texel.lit(|p| p.at.z < 0.05) - 1.0 / 3.0).abs() < 0.05,
            "layer 1 has a third of its hair in the lowest half layer spacing"
        );
    }
}
