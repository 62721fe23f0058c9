//! The far coat: all layers seen from above as one, and what light does in it on average.
//!
//! Where the layers are too small on screen to be told apart, a renderer draws the skin with this texture, a little above its place. What the
//! layers get one by one (ambient light by height, the key light through the hair above) is here one number each: the mean over the hair
//! that is seen, each with the weight of its luminance, so that the mean brightness stays.

use super::splat::Sums;
use pelage_formats::CoatInfo;
use rayon::prelude::*;

/// Longest way through a layer over its thickness that light takes: the runtime's `slanted_path` ends there.
const SLANTED: f32 = 4.0;

/// How many times what is above a height hides what is behind it, for a look along the outline. Going in and coming out it would be twice,
/// but beside fins shells have a fifth to all of their opacity there; measured so that the skin at the coat's height covers what hare,
/// knot and torus do with all their layers and fins.
const OUTLINE: f64 = 0.7;

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
    /// Per texel: opacity, colour and direction times opacity, as `weigh` leaves them, and 1.
    pub(super) sums: Vec<Sums>,
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
        let mut empty = [0.0; 8];
        empty[7] = 1.0;
        Self { sums: vec![empty; texels as usize * texels as usize], layers: Vec::new() }
    }

    /// Adds a weighed layer.
    pub(super) fn gather(&mut self, layer: &[Sums]) {
        self.sums.par_iter_mut().zip(layer).with_min_len(1024).for_each(|(sum, s)| {
            for (sum, value) in sum[..7].iter_mut().zip(&s[..7]) {
                *sum += value;
            }
            // What `weigh` adds for hidden hair must not make more than the whole.
            if sum[0] > 1.0 {
                let scale = 1.0 / sum[0];
                sum[..7].iter_mut().for_each(|value| *value *= scale);
            }
        });
    }

    /// Notes what [`Self::gather`] added, between those mean transmittances.
    pub(super) fn close(&mut self, layer: &[Sums], above: f32, through: f32) {
        let luminance = |s: &Sums| 0.2126 * f64::from(s[1]) + 0.7152 * f64::from(s[2]) + 0.0722 * f64::from(s[3]);
        let mean = layer.iter().map(luminance).sum::<f64>() / layer.len().max(1) as f64;
        self.layers.push(LayerShare { luminance: mean, above: above.into(), through: through.into() });
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
                (l.above * own.sqrt()).powf(path)
            };
            mean(&|_, l| share(l), 1.0).clamp(0.0, 1.0)
        };
        let light_straight = light(1.0);
        let outline: f64 = self.layers.iter().map(|l| (1.0 - l.through.powf(OUTLINE)) / count).sum();
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
