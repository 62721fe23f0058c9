//! Transmittance through the volume of which the layers are samples (formulas 4.3, after Kajiya and Kay 1989).
//!
//! A layer represents a slab of height Δ, the layer spacing. The layer's opacity α is the fraction of light from
//! straight above that this slab absorbs. The slab's extinction is therefore −ln(1 − α)/Δ. Extinction is given at the
//! texel centres of each layer and interpolated linearly along all three axes. It is constant within half a layer
//! spacing below the lowest layer and above the outermost one. Straight down, the whole volume therefore absorbs
//! exactly as much as the product of all layers. A point on a layer has half of that layer in front of it.
//!
//! Between two grid planes, extinction is a cubic along any straight line, and two Gauss points integrate it exactly.
//! No step length has to be chosen.

use glam::DVec3;
use pelage_bake::stages::slice::ShellSet;
use pelage_import::BakeError;
use rayon::prelude::*;

/// Cap on opacities, because an opaque texel would have an infinite extinction, which cannot be interpolated.
const MOST_OPAQUE: f64 = 0.97;
/// Optical depth at which a ray ends, when one part in 10¹⁵ of the light is left.
const DARK: f64 = 35.0;
/// Number of grid cells that a ray may cross before it is assumed never to leave the fur: 16 000 tiles of 64 texels.
const MAX_CELLS: u32 = 1 << 20;

/// Extinction of one tile of fur, periodic along u and v. The unit of length is the tile's width.
#[derive(Clone, Debug, PartialEq)]
pub struct SampledVolume {
    /// Texels per side.
    texels: usize,
    /// Number of layers above layer 0, which is the opaque mesh surface and not part of the volume.
    layers: usize,
    /// Distance between two layers, tile widths.
    spacing: f64,
    /// `layers * texels * texels` values, the lowest layer first, row-major.
    extinction: Vec<f64>,
}

impl SampledVolume {
    /// Builds the volume of sliced layers.
    ///
    /// * `height`: height of the outermost layer, widths of the tile
    ///   ([`pelage_bake::stages::simulate::Strands::height`])
    ///
    /// # Errors
    ///
    /// [`BakeError::Internal`] for a set without a layer above layer 0, missing texels, or a height that is not above
    /// zero.
    pub fn new(set: &ShellSet, height: f64) -> Result<Self, BakeError> {
        let above = set.layers.get(1..).unwrap_or(&[]);
        let alpha = |texels: &Vec<u8>| texels.chunks_exact(4).map(|t| f64::from(t[3]) / 255.0).collect();
        let opacities: Vec<Vec<f64>> = above.iter().map(|l| l.color.first().map_or_else(Vec::new, alpha)).collect();
        Self::from_opacities(set.texels, height, &opacities)
    }

    /// Builds the volume from opacities (0..=1) at the texel centres of each layer above layer 0. The lowest layer is
    /// first; each has `texels * texels` values.
    ///
    /// # Errors
    ///
    /// Same as [`Self::new`], and for values outside 0..=1.
    pub fn from_opacities(texels: u32, height: f64, opacities: &[Vec<f64>]) -> Result<Self, BakeError> {
        let fail = |reason: String| Err(BakeError::Internal(format!("sampled volume: {reason}")));
        let (n, layers) = (texels as usize, opacities.len());
        if n == 0 || layers == 0 || !(height.is_finite() && height > 0.0) {
            return fail(format!(
                "found {layers} layers of {n} texels a side, {height} high, expected all three above 0"
            ));
        }
        if let Some(layer) = opacities.iter().position(|layer| layer.len() != n * n) {
            return fail(format!("layer {} has {} texels, expected {}", layer + 1, opacities[layer].len(), n * n));
        }
        if opacities.iter().flatten().any(|alpha| !(0.0..=1.0).contains(alpha)) {
            return fail("an opacity is outside 0..=1".into());
        }
        let spacing = height / layers as f64;
        let extinction = opacities.iter().flatten().map(|alpha| -(-alpha.min(MOST_OPAQUE)).ln_1p() / spacing).collect();
        Ok(Self { texels: n, layers, spacing, extinction })
    }

    /// Returns the texels per side.
    pub fn texels(&self) -> usize {
        self.texels
    }

    /// Returns the number of layers, layer 0 included. Layer 0 has no extinction.
    pub fn layers(&self) -> usize {
        self.layers + 1
    }

    /// Returns the distance between two layers, widths of the tile.
    pub fn spacing(&self) -> f64 {
        self.spacing
    }

    /// Returns exp(−∫ extinction) along the straight ray from a point to a distant light, until the ray leaves the fur;
    /// 0..=1.
    ///
    /// * `u`, `v`: position in the tile, tile widths; any value, because the tile repeats
    /// * `z`: height above the mesh surface, tile widths; negative values count as 0
    /// * `light_ts`: direction towards the light, of any length, in the frame of the tile: u, v, and away from the mesh
    ///   surface
    ///
    /// The result is 0 if the light is not above the mesh surface, which is opaque.
    pub fn transmittance(&self, u: f64, v: f64, z: f64, light_ts: DVec3) -> f64 {
        let Some(light) = light_ts.try_normalize().filter(|l| l.z > 0.0) else { return 0.0 };
        // Units below: a texel along u and v, and a layer along z. Texel centres and layers have integer coordinates.
        let n = self.texels as f64;
        let start = DVec3::new(u.rem_euclid(1.0) * n - 0.5, v.rem_euclid(1.0) * n - 0.5, z.max(0.0) / self.spacing);
        let way = DVec3::new(light.x * n, light.y * n, light.z / self.spacing);
        let (bottom, top) = (0.5, self.layers as f64 + 0.5);
        let enter = ((bottom - start.z) / way.z).max(0.0);
        let length = (top - start.z) / way.z - enter;
        if length <= 0.0 {
            return 1.0;
        }
        (-self.optical_depth(start + way * enter, way, length)).exp()
    }

    /// Returns [`Self::transmittance`] at every texel centre of a layer: `texels * texels` values, row-major. Layer 0
    /// is the mesh surface.
    pub fn layer_transmittances(&self, layer: usize, light_ts: DVec3) -> Vec<f64> {
        let n = self.texels;
        let at = |i: usize| (i as f64 + 0.5) / n as f64;
        let z = layer as f64 * self.spacing;
        (0..n * n).into_par_iter().map(|i| self.transmittance(at(i % n), at(i / n), z, light_ts)).collect()
    }

    /// Returns the integral of extinction from `start` to `start` + `length` · `way`, with lengths in tile widths.
    /// Infinite for a ray that never leaves.
    fn optical_depth(&self, start: DVec3, way: DVec3, length: f64) -> f64 {
        // For each axis: the distance along the ray to the next grid plane, and the distance between planes.
        let mut planes = [0, 1, 2].map(|axis| {
            let (p, d) = (start[axis], way[axis]);
            let first = if d > 0.0 { p.floor() + 1.0 } else { p.ceil() - 1.0 };
            if d == 0.0 { (f64::INFINITY, 0.0) } else { ((first - p) / d, 1.0 / d.abs()) }
        });
        let (mut from, mut depth) = (0.0, 0.0);
        for _ in 0..MAX_CELLS {
            let to = planes.iter().fold(length, |to, (next, _)| to.min(*next));
            if to > from {
                depth += self.cell(start, way, from, to);
                from = to;
            }
            if from >= length || depth > DARK {
                return depth;
            }
            for (next, step) in &mut planes {
                if *next <= from {
                    *next += *step;
                }
            }
        }
        f64::INFINITY
    }

    /// Returns the integral over a part of the ray that crosses no grid plane.
    fn cell(&self, start: DVec3, way: DVec3, from: f64, to: f64) -> f64 {
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        let corner = (start + way * middle).floor();
        let n = self.texels as i64;
        let wrap = |x: f64, step: i64| (x as i64 + step).rem_euclid(n) as usize;
        let columns = [wrap(corner.x, 0), wrap(corner.x, 1)];
        let rows = [wrap(corner.y, 0), wrap(corner.y, 1)].map(|row| row * self.texels);
        let layers = [0, 1].map(|step| (corner.z as i64 + step).clamp(1, self.layers as i64) as usize - 1);
        let slabs = layers.map(|layer| layer * self.texels * self.texels);
        let values = slabs.map(|slab| rows.map(|row| columns.map(|column| self.extinction[slab + row + column])));
        let mix = |pair: [f64; 2], f: f64| pair[0] + (pair[1] - pair[0]) * f;
        let at = |t: f64| {
            let f = start + way * t - corner;
            mix(values.map(|slab| mix(slab.map(|row| mix(row, f.x)), f.y)), f.z)
        };
        let gauss = half / 3f64.sqrt();
        half * (at(middle - gauss) + at(middle + gauss))
    }
}

#[cfg(test)]
#[path = "volume_tests.rs"]
mod tests;
