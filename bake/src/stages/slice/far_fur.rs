//! Far fur: all layers merged into one, with their mean lighting.
//!
//! Where the layers are too small on screen to be distinguished, a renderer draws the mesh surface with this texture,
//! raised slightly. Quantities that differ between layers (ambient light by height, key light through the hair above)
//! become one number each. This number is the mean over the visible hair, weighted by luminance, so that the mean
//! brightness is preserved.

use super::splat::Sums;
use pelage_formats::{FarLayerInfo, meaning};
use rayon::prelude::*;

/// Maximum path length of light through a layer, as a multiple of the layer's thickness; equals the limit of the
/// runtime's `slanted_path`.
const SLANTED: f32 = 4.0;

/// Factor on the optical depth above a height for a view along the silhouette, where the view enters and leaves the fur
/// at a slant. The factor was measured: the mesh surface at the far fur's height then covers as much as all layers and
/// fins of hare, knot and torus.
const OUTLINE: f64 = 5.0;

/// Statistics of the far fur and of the layers from which it was made.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FarFurStats {
    /// Data for the package.
    pub info: FarLayerInfo,
    /// Mean opacity of each layer, from layer 1 outwards. It equals the layer's last mip level.
    pub opacities: Vec<f32>,
}

/// Accumulated appearance of the layers, beginning with the outermost.
pub(super) struct FarFurSums {
    /// Sums per texel: opacity, colour times opacity, direction times opacity, 1, and visibility times opacity.
    pub(super) sums: Vec<Sums>,
    /// Transmittance of the layers so far, per texel, as seen in the far view.
    through: Vec<f32>,
    /// Luminance that the last layer added to the mean colour.
    added: f64,
    layers: Vec<LayerShare>,
}

/// Contribution of one layer.
struct LayerShare {
    /// Luminance added to the mean colour.
    luminance: f64,
    /// Mean transmittance of the layers above this one; `through` includes the layer itself.
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
            // The transmittance is squared: averaged over the visible part of a round body, the view passes through
            // twice the thickness of a layer. The far fur thus shows the layers as seen at 60°. Seen from straight
            // above, more of the dark roots would be visible.
            let blocked = *through * (1.0 - (1.0 - opacity) * (1.0 - opacity));
            *through -= blocked;
            sum[0] += blocked;
            for i in [1..7, 8..12].into_iter().flatten() {
                sum[i] += blocked * s[i] / s[0];
            }
            meaning::luminance([1, 2, 3].map(|i| f64::from(blocked * s[i] / s[0])).into())
        });
        // Values are summed in the order of the texels, so that the result does not depend on the number of threads.
        self.added = luminance.collect::<Vec<f64>>().iter().sum::<f64>() / layer.len().max(1) as f64;
    }

    /// Records the contribution of the layer that [`Self::gather`] added. `above` and `through` are the mean
    /// transmittances above the layer and through it, as seen from straight above.
    pub(super) fn close(&mut self, above: f32, through: f32) {
        self.layers.push(LayerShare { luminance: self.added, above: above.into(), through: through.into() });
    }

    /// Returns the means over the gathered layers, which are ordered from the outermost down to layer 1.
    pub(super) fn finish(&self) -> FarFurStats {
        let count = self.layers.len().max(1) as f64;
        let total: f64 = self.layers.iter().map(|l| l.luminance).sum();
        let mean = |of: &dyn Fn(usize, &LayerShare) -> f64, empty: f64| {
            let sum: f64 = self.layers.iter().enumerate().map(|(i, l)| l.luminance * of(i, l)).sum();
            if total > 0.0 { (sum / total) as f32 } else { empty as f32 }
        };
        // Light reaches the hair of a layer through the layers above and, on average, through half of the layer itself.
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
