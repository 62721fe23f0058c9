//! What is set once and what is set per frame.

use crate::{Camera, Detail, InkParams, Light, RuntimeError, ShadowParams, SlantForm};
use glam::Vec3;
use pelage_formats::Shading;

/// Set once: what the application's render pass looks like. It must match the pass that [`crate::Frame::draw`] records into.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RendererOptions {
    /// Format of the one colour target (default `Rgba8UnormSrgb`). The shaders write linear light with premultiplied opacity;
    /// an sRGB format encodes it.
    pub color_format: wgpu::TextureFormat,
    /// Format of the depth buffer (default `Depth32Float`).
    pub depth_format: wgpu::TextureFormat,
    /// Samples per pixel of both (default 1).
    pub sample_count: u32,
    /// Near is 1 and far is 0 (default false): the pass clears depth to 0, nearer is greater.
    pub reversed_depth: bool,
    /// Anisotropy of the base-colour texture's sampler, 1..=16 (default 1). Hair textures are always read with 1.
    pub anisotropy: u16,
}

impl Default for RendererOptions {
    fn default() -> Self {
        Self {
            color_format: wgpu::TextureFormat::Rgba8UnormSrgb,
            depth_format: wgpu::TextureFormat::Depth32Float,
            sample_count: 1,
            reversed_depth: false,
            anisotropy: 1,
        }
    }
}

impl RendererOptions {
    pub(crate) fn check(&self, device: &wgpu::Device) -> Result<(), RuntimeError> {
        let fail = |field, found: String, expected| Err(RuntimeError::Options { field, found, expected });
        let color = self.color_format.guaranteed_format_features(device.features());
        let drawable = color.allowed_usages.contains(wgpu::TextureUsages::RENDER_ATTACHMENT)
            && color.flags.contains(wgpu::TextureFormatFeatureFlags::BLENDABLE);
        if !drawable {
            return fail(
                "color_format",
                format!("{:?}", self.color_format),
                "a format that this device can draw to with blending",
            );
        }
        if !self.depth_format.has_depth_aspect() {
            return fail("depth_format", format!("{:?}", self.depth_format), "a depth format");
        }
        let specific = device.features().contains(wgpu::Features::TEXTURE_ADAPTER_SPECIFIC_FORMAT_FEATURES);
        let supported =
            color.flags.sample_count_supported(self.sample_count) || (specific && self.sample_count.is_power_of_two());
        if !supported {
            return fail(
                "sample_count",
                self.sample_count.to_string(),
                "1, 4, or what the adapter offers for this format",
            );
        }
        if !(1..=16).contains(&self.anisotropy) {
            return fail("anisotropy", self.anisotropy.to_string(), "1..=16");
        }
        Ok(())
    }
}

/// How a model is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Style {
    /// With its fur.
    #[default]
    Fur,
    /// The skin alone, in its base colour.
    Bare,
    /// As an ink-wash painting, as [`FrameParams::ink`] says; for packages that have the style. There is no light in it: lights, shadows,
    /// casters, layers and levels of detail have no effect. The paper is that of the first instance.
    Ink,
}

/// Where the key light's diffuse and specular factors, Yang 2006, eq. (1), are computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Lighting {
    /// At every pixel, with the direction of its hair.
    #[default]
    Pixel,
    /// At the vertices, with the mean direction of a layer's hairs, and interpolated, as in Lengyel 2001: the baseline that light per
    /// pixel is held against. Shadows, Attenu_Back and fill lights stay per pixel.
    Vertex,
}

/// Set per frame.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameParams {
    /// From where the scene is seen.
    pub camera: Camera,
    /// The key light: the one that throws shadows.
    pub light: Light,
    /// Other lights, without shadows: at most [`MAX_FILL_LIGHTS`] (default none). Each costs about as much as the key light.
    pub fill_lights: Vec<Light>,
    /// Where the key light is computed (default per pixel).
    pub lighting: Lighting,
    /// Light from everywhere, linear RGB, multiplies the package's ambient constant (default 1).
    pub ambient: Vec3,
    /// With fur or without.
    pub style: Style,
    /// Layers to draw, skin counted, 1..=1024; `None` (default) draws as many as were baked. The density of the fur stays the
    /// same (see [`crate::shared::opacity`]); fewer layers cost less, and show their steps at the silhouette.
    pub layers: Option<u32>,
    /// How opaque a layer is to a look that goes through it at a slant (default [`SlantForm::Corrected`]).
    pub slant: SlantForm,
    /// How much of the fur is drawn where it is small on screen (default [`Detail::Full`]).
    pub detail: Detail,
    /// Whether fins are drawn where the package has them (default true).
    pub fins: bool,
    /// Whether hair shadows hair, t of Yang 2006, eq. (2), by layer-wise shadow maps (default true).
    pub self_shadow: bool,
    /// Whether things throw soft shadows, Attenu_Shadow of Yang 2006, eq. (3), by a shadow-width map (default true): skins on fur, and
    /// what [`crate::Casters`] brings. Without it [`crate::Frame::shadow_receiver`] lights everything.
    pub soft_shadow: bool,
    /// How these shadows are made (default [`ShadowParams::default`]).
    pub shadows: ShadowParams,
    /// Whether ambient light fades towards the skin, γ of Yang 2006, eq. (2) (default true).
    pub ambient_attenuation: bool,
    /// Whether the light ends past the terminator, Attenu_Back of Yang 2006, eq. (3) (default true).
    pub back_attenuation: bool,
    /// How [`Style::Ink`] paints, which needs it (default `None`).
    pub ink: Option<InkParams>,
    /// Constants of the lighting equation instead of the package's own (default `None`).
    pub shading: Option<Shading>,
    /// Draws the shells with one texture read and no lighting: what `pelage bench` measures their cost against.
    #[doc(hidden)]
    pub yardstick: bool,
    /// Draws this layer of the shells alone, 1.. : what counting is done with.
    #[doc(hidden)]
    pub only_layer: Option<u32>,
}

impl FrameParams {
    /// A furry picture from `camera` with everything else at its default.
    pub fn new(camera: Camera) -> Self {
        Self {
            camera,
            light: Light::default(),
            fill_lights: Vec::new(),
            lighting: Lighting::Pixel,
            ambient: Vec3::ONE,
            style: Style::Fur,
            layers: None,
            slant: SlantForm::default(),
            detail: Detail::Full,
            fins: true,
            self_shadow: true,
            soft_shadow: true,
            shadows: ShadowParams::default(),
            ambient_attenuation: true,
            back_attenuation: true,
            ink: None,
            shading: None,
            yardstick: false,
            only_layer: None,
        }
    }

    pub(crate) fn check(&self, limits: &wgpu::Limits) -> Result<(), RuntimeError> {
        let fail = |field, found: String, expected: &str| {
            Err(RuntimeError::Params { field, found, expected: expected.into() })
        };
        self.shadows.check(limits)?;
        self.detail.check()?;
        if self.fill_lights.len() > MAX_FILL_LIGHTS {
            return fail("FrameParams::fill_lights", format!("{} lights", self.fill_lights.len()), "at most 32");
        }
        if let Some(layers) = self.layers
            && !(1..=MAX_LAYERS).contains(&layers)
        {
            return fail("FrameParams::layers", layers.to_string(), "1..=1024");
        }
        match &self.ink {
            Some(ink) => ink.check(limits)?,
            None if self.style == Style::Ink => {
                return fail("FrameParams::ink", "None".into(), "how the ink style paints, such as InkParams::new");
            }
            None => {}
        }
        if !self.ambient.is_finite() {
            return fail("FrameParams::ambient", self.ambient.to_string(), "finite numbers");
        }
        if let Some(s) = &self.shading {
            let colors = [s.ambient, s.diffuse, s.specular];
            let exponents = [s.diffuse_exponent, s.specular_exponent].iter().all(|e| (0.0..=10_000.0).contains(e));
            let shares = [s.ambient_floor, s.back_light_range].iter().all(|e| (0.0..=1.0).contains(e));
            if !colors.as_flattened().iter().all(|v| v.is_finite()) || !exponents || !shares {
                let expected = "finite colours, exponents 0..=10000, ambient_floor and back_light_range 0..=1";
                return fail("FrameParams::shading", format!("{s:?}"), expected);
            }
        }
        Ok(())
    }
}

/// More layers than this are a mistake.
pub(crate) const MAX_LAYERS: u32 = 1024;

/// Most lights without shadow that a frame may have.
pub const MAX_FILL_LIGHTS: usize = 32;
