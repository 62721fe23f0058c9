//! The far coat: all layers seen as one, and what light does in it on average.
//!
//! Where the layers are too small on screen to be told apart, a renderer draws the skin with this texture, a little above its place. What the
//! layers get one by one (ambient light by height, the key light through the hair above) is here one number each: the mean over the hair
//! that is seen, each with the weight of its luminance, so that the mean brightness stays.

use super::splat::Sums;
use pelage_formats::CoatInfo;
use rayon::prelude::*;

/// Longest way through a layer over its thickness that light takes: the runtime's `slanted_path` ends there.
const SLANTED: f32 = 4.0;

/// How many times what is above a height hides what is behind it, for a look along the outline: in and out again, each at a slant. Measured so
/// that the skin at the coat's height covers what hare, knot and torus do with all their layers and fins.
const OUTLINE: f64 = 5.0;

/// What there is to say of a far coat, and of the layers that it was made of.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Coat {
    /// For the package.
    pub info: CoatInfo,
    /// Mean opacity of each layer as its last mip level has it, from layer 1 outwards.
    pub opacities: Vec<f32>,
}

/// What the layers from outside in look like together.
pub(super) struct CoatSums {
    /// Per texel: opacity, colour and direction times opacity, 1, and visibility times opacity.
    pub(super) sums: Vec<Sums>,
    /// Per texel: what the layers so far let through of such a look.
    through: Vec<f32>,
    /// Luminance that the last layer added to the mean colour.
    added: f64,
    layers: Vec<LayerShare>,
}

/// One layer's part in the coat.
struct LayerShare {
    /// Luminance that it adds to the mean colour.
    luminance: f64,
    /// Mean transmittance above it, and down through it.
    above: f64,
    through: f64,
}

impl CoatSums {
    pub(super) fn new(texels: u32) -> Self {
        let mut empty = Sums::default();
        empty[7] = 1.0;
        let count = texels as usize * texels as usize;
        Self { sums: vec![empty; count], through: vec![1.0; count], added: 0.0, layers: Vec::new() }
    }

    /// Adds a weighed layer.
    pub(super) fn gather(&mut self, layer: &[Sums]) {
        let texels = self.sums.par_iter_mut().zip(&mut self.through).zip(layer);
        let luminance = texels.with_min_len(1024).map(|((sum, through), s)| {
            if s[0] <= 0.0 {
                return 0.0;
            }
            let opacity = (s[0] / s[7]).clamp(0.0, 1.0);
            // Twice: in the mean over what is seen of a round body, a look goes through a layer twice as far as it is thick. The coat is what
            // the layers look like at 60°, and not from straight above, where more of the dark roots shows.
            let blocked = *through * (1.0 - (1.0 - opacity) * (1.0 - opacity));
            *through -= blocked;
            sum[0] += blocked;
            for i in [1..7, 8..12].into_iter().flatten() {
                sum[i] += blocked * s[i] / s[0];
            }
            let [r, g, b] = [1, 2, 3].map(|i| f64::from(blocked * s[i] / s[0]));
            0.2126 * r + 0.7152 * g + 0.0722 * b
        });
        // In the order of the texels, so that the sum does not depend on the number of threads.
        self.added = luminance.collect::<Vec<f64>>().iter().sum::<f64>() / layer.len().max(1) as f64;
    }

    /// Notes what [`Self::gather`] added, between those mean transmittances of a look from straight above.
    pub(super) fn close(&mut self, above: f32, through: f32) {
        self.layers.push(LayerShare { luminance: self.added, above: above.into(), through: through.into() });
    }

    /// The means over what was gathered, outermost layer first down to layer 1.
    pub(super) fn finish(&self) -> Coat {
        let count = self.layers.len().max(1) as f64;
        let total: f64 = self.layers.iter().map(|l| l.luminance).sum();
        let mean = |of: &dyn Fn(usize, &LayerShare) -> f64, empty: f64| {
            let sum: f64 = self.layers.iter().enumerate().map(|(i, l)| l.luminance * of(i, l)).sum();
            if total > 0.0 { (sum / total) as f32 } else { empty as f32 }
        };
        // Light on a layer comes through the layers above, and on average through half of its own.
        let light = |path: f64| {
            let share = |l: &LayerShare| {
                let own = (l.through / l.above.max(1e-6)).clamp(0.0, 1.0);
                libm::pow(l.above * own.sqrt(), path)
            };
            mean(&|_, l| share(l), 1.0).clamp(0.0, 1.0)
        };
        let light_straight = light(1.0);
        let outline: f64 = self.layers.iter().map(|l| (1.0 - libm::pow(l.through, OUTLINE)) / count).sum();
        let info = CoatInfo {
            height: outline.clamp(0.0, 1.0) as f32,
            ambient_height: mean(&|i, _| 1.0 - i as f64 / count, 0.0).clamp(0.0, 1.0),
            light_straight,
            light_slanted: light(f64::from(SLANTED)).min(light_straight),
        };
        let opacity = |l: &LayerShare| 1.0 - (l.through / l.above.max(1e-6)).clamp(0.0, 1.0) as f32;
        Coat { info, opacities: self.layers.iter().rev().map(opacity).collect() }
    }
}
