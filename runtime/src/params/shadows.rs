//! Shadow settings of the key light.

use crate::error::RuntimeError;

/// Shadow settings of the key light. [`crate::FurParams::self_shadow`] and [`crate::FrameParams::soft_shadow`] select
/// which shadows are drawn. Set per frame; a change redraws the maps. [`crate::ShadowMaps::gpu_bytes`] returns the size
/// of the maps.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ShadowParams {
    /// Width and height of every shadow map, texels, 16..=8192 (default 512, as in Yang 2006, §6). A map covers all
    /// drawn instances and [`crate::Casters::bounds`]. The width of a texel is [`crate::LightView::extent`] /
    /// `map_size`.
    pub map_size: u32,
    /// Number of layer-wise maps, skin included, 2..=256; `None` (default) for as many as there are drawn layers. Fewer
    /// maps are faster; values between two maps are interpolated.
    pub map_layers: Option<u32>,
    /// Number of slabs of the deep opacity map, by which single strands shadow each other, 1..=64 (default 4). They
    /// divide a depth range of twice the height of the highest fur, behind the first hair of each texel. More slabs are
    /// more accurate, but cost memory and time.
    pub slabs: u32,
    /// Factor on the layers' optical depth in the maps, 0..=4 (default 1, same as drawn). Baked visibility is not
    /// affected.
    pub density: f32,
    /// Penumbra width divided by the distance between caster and receiver, 0..=2 (default 0.15; 0 gives hard shadows).
    /// Equals 2 tan of the light's angular radius, and 1 / C_scale in Yang 2006, §5. For the sun, it is 0.009.
    ///
    /// `shrink` limits the width. Shadows of hair on other objects have a constant blur of `shrink` texels, whatever
    /// the distance.
    pub penumbra: f32,
    /// Factor by which the shadow-width map is downsampled before it is upsampled again, 2..=32 (default 4, as in Yang
    /// 2006, §4). With factor s, the widest penumbra is 4/3 s texels. Objects much thinner than that cast no shadow.
    pub shrink: u32,
}

impl Default for ShadowParams {
    fn default() -> Self {
        Self { map_size: 512, map_layers: None, slabs: 4, density: 1.0, penumbra: 0.15, shrink: 4 }
    }
}

impl ShadowParams {
    /// Returns the parameters with changes: `ShadowParams::default().with(|s| s.map_size = 1024)`.
    pub fn with(mut self, change: impl FnOnce(&mut Self)) -> Self {
        change(&mut self);
        self
    }

    pub(crate) fn check(&self, limits: &wgpu::Limits) -> Result<(), RuntimeError> {
        let fail = |field, found: String, expected: &str| {
            Err(RuntimeError::Params { field, found, expected: expected.into() })
        };
        if !(16..=8192).contains(&self.map_size) {
            return fail("ShadowParams::map_size", self.map_size.to_string(), "16..=8192");
        }
        if self.map_size > limits.max_texture_dimension_2d {
            return Err(RuntimeError::DeviceLimit {
                what: "ShadowParams::map_size".into(),
                found: self.map_size.into(),
                limit: "max_texture_dimension_2d",
                allowed: limits.max_texture_dimension_2d.into(),
            });
        }
        if let Some(layers) = self.map_layers
            && !(2..=256).contains(&layers)
        {
            return fail("ShadowParams::map_layers", layers.to_string(), "2..=256");
        }
        if !(1..=64).contains(&self.slabs) {
            return fail("ShadowParams::slabs", self.slabs.to_string(), "1..=64");
        }
        if !(0.0..=4.0).contains(&self.density) {
            return fail("ShadowParams::density", self.density.to_string(), "0..=4");
        }
        if !(0.0..=2.0).contains(&self.penumbra) {
            return fail("ShadowParams::penumbra", self.penumbra.to_string(), "0..=2");
        }
        if !(2..=32).contains(&self.shrink) {
            return fail("ShadowParams::shrink", self.shrink.to_string(), "2..=32");
        }
        Ok(())
    }
}
