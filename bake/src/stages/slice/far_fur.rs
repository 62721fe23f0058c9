//! Far fur: all layers merged into one, with the mean lighting inside them.
//!
//! Where the layers are too small on screen to be distinguished, a renderer draws the mesh surface with this texture,
//! raised slightly. Values that each layer has of its own (ambient light by height, key light through the hair above)
//! become one number each. It is the mean over the visible hair, weighted by luminance, so that the mean brightness is
//! preserved.

use super::splat::Sums;
use pelage_formats::FarLayerInfo;
use rayon::prelude::*;

/// Maximum path of light through a layer, over the layer's thickness; limit of the runtime's `slanted_path`.
const SLANTED: f32 = 4.0;

/// Factor on the optical depth above a height, for a view along the silhouette: in and out again, each at a slant.
/// Measured so that the mesh surface at the far fur's height covers as much as all layers and fins of hare, knot and
/// torus.
const OUTLINE: f64 = 5.0;

/// Statistics of the far fur and of the layers that it was made of.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FarFurStats {
    /// Data for the package.
    pub info: FarLayerInfo,
    /// Mean opacity of each layer, equal to its last mip level, from layer 1 outwards.
    pub opacities: Vec<f32>,
}

/// Accumulated appearance of the layers, from the outermost inwards.
pub(super) struct FarFurSums {
    /// Per texel: opacity, colour and direction times opacity, 1, and visibility times opacity.
    pub(super) sums: Vec<Sums>,
    /// Per texel: transmittance of the layers so far, in the far view.
    through: Vec<f32>,
    /// Luminance that the last layer added to the mean colour.
    added: f64,
    layers: Vec<LayerShare>,
}

/// Contribution of one layer.
struct LayerShare {
    /// Luminance added to the mean colour.
    luminance: f64,
    /// Mean transmittance above the layer; `through` includes the layer itself.
    above: f64,
    through: f64,
}

impl FarFurSums {
    pub(super) fn new(texels: u32) -> Self {
        let mut empty = Sums::default();
        empty[7] = 1.0;
        let count = texels as usize * texels as usize;
        Self { sums: vec![empty; count], through: vec![1.0; count], added: 0.0, layers: Vec::new() }
    }

    /// Adds a weighted layer.
    pub(super) fn gather(&mut self, layer: &[Sums]) {
        let texels = self.sums.par_iter_mut().zip(&mut self.through).zip(layer);
        let luminance = texels.with_min_len(1024).map(|((sum, through), s)| {
            if s[0] <= 0.0 {
                return 0.0;
            }
            let opacity = (s[0] / s[7]).clamp(0.0, 1.0);
            // Squared: averaged over the visible part of a round body, the view passes through a layer over twice its
            // thickness. The far fur is the layers seen at 60°, not from straight above, where more of the dark roots
            // is visible.
            let blocked = *through * (1.0 - (1.0 - opacity) * (1.0 - opacity));
            *through -= blocked;
            sum[0] += blocked;
            for i in [1..7, 8..12].into_iter().flatten() {
                sum[i] += blocked * s[i] / s[0];
            }
            let [r, g, b] = [1, 2, 3].map(|i| f64::from(blocked * s[i] / s[0]));
            0.2126 * r + 0.7152 * g + 0.0722 * b
        });
        // Summed in the order of the texels, so that the result does not depend on the number of threads.
        self.added = luminance.collect::<Vec<f64>>().iter().sum::<f64>() / layer.len().max(1) as f64;
    }

    /// Records what [`Self::gather`] added, with the mean transmittances above and through the layer for a view from
    /// straight above.
    pub(super) fn close(&mut self, above: f32, through: f32) {
        self.layers.push(LayerShare { luminance: self.added, above: above.into(), through: through.into() });
    }

    /// Returns the means over the gathered layers, outermost layer first down to layer 1.
    pub(super) fn finish(&self) -> FarFurStats {
        let count = self.layers.len().max(1) as f64;
        let total: f64 = self.layers.iter().map(|l| l.luminance).sum();
        let mean = |of: &dyn Fn(usize, &LayerShare) -> f64, empty: f64| {
            let sum: f64 = self.layers.iter().enumerate().map(|(i, l)| l.luminance * of(i, l)).sum();
            if total > 0.0 { (sum / total) as f32 } else { empty as f32 }
        };
        // Light reaches a layer through the layers above and, on average, through half of its own.
        let light = |path: f64| {
            let share = |l: &LayerShare| {
                let own = (l.through / l.above.max(1e-6)).clamp(0.0, 1.0);
                libm::pow(l.above * own.sqrt(), path)
            };
            mean(&|_, l| share(l), 1.0).clamp(0.0, 1.0)
        };
        let light_straight = light(1.0);
        let outline: f64 = self.layers.iter().map(|l| (1.0 - libm::pow(l.through, OUTLINE)) / count).sum();
        let info = FarLayerInfo {
            height: outline.clamp(0.0, 1.0) as f32,
            ambient_height: mean(&|i, _| 1.0 - i as f64 / count, 0.0).clamp(0.0, 1.0),
            light_straight,
            light_slanted: light(f64::from(SLANTED)).min(light_straight),
        };
        let opacity = |l: &LayerShare| 1.0 - (l.through / l.above.max(1e-6)).clamp(0.0, 1.0) as f32;
        FarFurStats { info, opacities: self.layers.iter().rev().map(opacity).collect() }
    }
}
