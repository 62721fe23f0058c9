//! Conversion of a look into parameters of the runtime.

use super::kinds::{
    Background, LookDetail, LookFurShow, LookHair, LookLines, LookScattering, LookSelfShadow, LookSheet, LookShow,
    LookStrandEdges, LookStyle, LookWidth,
};
use super::tables::{KeyLight, Look};
use crate::{GroundKind, TargetSettings, Viewpoint, camera};
use glam::{Vec2, Vec3};
use pelage_formats::meaning::srgb_to_linear;
use pelage_runtime::{
    BrushParams, BrushSheet, DebugView, Detail, FrameParams, FurDebugView, FurParams, HairGeometry, HairMotionParams,
    InkBackground, InkDebugView, InkLines, InkParams, Light, LineWidth, Scattering, Seal, SelfShadow, ShadowParams,
    StrandEdges, Style, ToneMapping,
};

/// Placeholder view: a stage sets its own.
const ANY_VIEW: Viewpoint = Viewpoint { eye: Vec3::Z, target: Vec3::ZERO, fov_deg: 30.0 };

impl Look {
    /// Returns the render target settings.
    pub fn picture(&self) -> TargetSettings {
        let size = self.picture.size;
        TargetSettings {
            size: (size.width, size.height),
            samples: self.picture.samples.0,
            background: self.background(),
            ground: self.ground(),
        }
    }

    /// Returns the ground below the models. The style ink has none.
    fn ground(&self) -> GroundKind {
        match self.picture.background {
            _ if self.picture.style == LookStyle::Ink => GroundKind::None,
            Some(Background::Studio) => GroundKind::Studio,
            _ if self.picture.ground_shadow => GroundKind::Shadow,
            _ => GroundKind::None,
        }
    }

    /// Returns the frame parameters of the look. The camera is a placeholder until a [`crate::Stage`] or the
    /// application sets it.
    ///
    /// With an environment map, its sun is the key light, unless the look sets the key light's strength. Without a sun
    /// the key light is black, and its direction only serves to measure the depth of hair. If the map is a file, call
    /// [`Look::read_environment`] first, and [`Look::read_seal`] for a seal.
    pub fn frame_params(&self) -> FrameParams {
        let size = self.picture.size;
        let style = match self.picture.style {
            LookStyle::Bare => Style::Bare,
            LookStyle::Ink => Style::Ink(self.ink_params()),
            LookStyle::Fur => Style::Fur(self.fur_params()),
        };
        let exposure = self.exposure();
        let key_strength = exposure * self.key_strength();
        FrameParams::new(camera(&ANY_VIEW, 1.0), [size.width, size.height]).with(|params| {
            params.light = match self.key_light() {
                KeyLight::Distant(towards) => distant(towards, key_strength),
                KeyLight::Nearby(position) => Light::Point { position, color: Vec3::splat(key_strength) },
            };
            params.ambient *= exposure;
            params.environment = self.environment().map(|lights| lights.scaled(exposure));
            if let (Some(around), None) = (&params.environment, self.light.strength) {
                params.light =
                    around.sun.as_ref().map_or_else(|| distant(around.mean_direction().as_vec3(), 0.0), Light::sun);
            }
            params.style = style;
            let fill = self.fill_lights().map(|(towards, strength)| distant(towards, exposure * strength));
            params.fill_lights = fill.collect();
            params.tone_mapping = if self.is_tone_mapped() { ToneMapping::Filmic } else { ToneMapping::Off };
            params.soft_shadow = self.shadow.soft_shadow;
            params.shadows = self.shadow_params();
            params.debug = self.debug_view();
            #[cfg(feature = "study")]
            {
                params.study = self.study.params();
            }
        })
    }

    /// Returns the parameters of hair motion; `None` if hair stays as groomed.
    pub fn hair_motion(&self) -> Option<HairMotionParams> {
        let motion = &self.motion;
        motion.hair.then(|| {
            HairMotionParams::default().with(|params| {
                params.gravity *= motion.gravity;
                params.fur = motion.fur;
                params.wind.velocity = motion.wind.into();
                (params.wind.gust, params.wind.gust_s) = (motion.gust, motion.gust_s);
                (params.wind.turbulence, params.wind.eddy_m) = (motion.turbulence, motion.eddy_m);
            })
        })
    }

    pub(crate) fn fur_params(&self) -> FurParams {
        FurParams::default().with(|fur| {
            fur.layers = self.fur.layers;
            fur.detail = match self.fur.detail {
                LookDetail::Full => Detail::Full,
                LookDetail::Auto => Detail::Auto { bias: 1.0 },
                LookDetail::Level(level) => Detail::Level(level),
            };
            fur.fins = self.fur.fins;
            fur.hair = same!(self.fur.hair, LookHair => HairGeometry: Auto, Shells, Strands);
            fur.strand_edges = same!(self.fur.strand_edges, LookStrandEdges => StrandEdges: Samples, Blended);
            fur.scattering = same!(self.fur.scattering, LookScattering => Scattering: Multiple, Single, Off);
            fur.self_shadow = same!(self.shadow.self_shadow, LookSelfShadow => SelfShadow: Auto, Baked, Maps, Off);
        })
    }

    /// Returns the shadow parameters of the key light.
    pub(crate) fn shadow_params(&self) -> ShadowParams {
        ShadowParams::default().with(|shadows| {
            shadows.map_size = self.shadow.map_texels;
            shadows.map_layers = self.shadow.map_layers;
            shadows.density = self.shadow.density;
            shadows.penumbra = self.shadow.penumbra;
            shadows.shrink = self.shadow.shrink;
        })
    }

    fn brush_params(&self) -> BrushParams {
        let look = &self.brush;
        BrushParams::default().with(|brush| {
            brush.strokes = look.strokes;
            brush.wash = look.wash;
            brush.wetness = look.wetness;
            brush.dryness = look.dryness;
            brush.tufts = look.tufts;
            brush.line_width = look.line_width;
            brush.omission = look.omission;
            brush.ground = look.ground;
            brush.sheet = same!(look.sheet, LookSheet => BrushSheet: Raw, Sized, Silk);
            brush.progress = look.progress;
        })
    }

    /// Returns the parameters of the style `ink`.
    pub(crate) fn ink_params(&self) -> InkParams {
        let linear = |rgb: [u8; 3]| Vec3::from(rgb.map(srgb_to_linear));
        let look = &self.ink;
        InkParams::default().with(|ink| {
            ink.lines = same!(look.lines, LookLines => InkLines: Pixels, Strokes);
            ink.brush = self.brush_params();
            ink.threshold = look.threshold;
            ink.weak_difference = look.weak_difference;
            ink.width = match look.width {
                LookWidth::Auto => LineWidth::Auto,
                LookWidth::Pixels(px) => LineWidth::Pixels(px),
                LookWidth::Metres(metres) => LineWidth::Metres(metres),
            };
            ink.fins = self.fur.fins;
            ink.depth_step = look.depth_step;
            ink.tone = look.tone;
            ink.weak_lightness = look.weak_lightness;
            ink.swell = look.swell;
            ink.pressure = look.pressure;
            ink.dryness = look.dryness;
            ink.roughness_px = look.roughness_px;
            ink.ink = look.color.map_or(ink.ink, |rgb| linear(rgb.0));
            ink.paper = self.background().map_or(ink.paper, linear);
            ink.paper_grain = look.paper_grain;
            ink.mist_m = look.mist_m.map(|mist| mist.0);
            ink.seal = look.seal.as_ref().and_then(|seal| {
                let [x, y, height] = seal.place;
                Some(Seal::new(seal.image.clone()?).at(Vec2::new(x, y), height))
            });
            ink.background = match self.picture.background {
                Some(Background::Transparent | Background::Sky | Background::Studio) => InkBackground::Picture,
                Some(Background::Color(_)) | None => InkBackground::Paper,
            };
        })
    }

    pub(crate) fn debug_view(&self) -> DebugView {
        let mut view = DebugView::default();
        view.fur = same!(self.fur.show, LookFurShow => FurDebugView: Picture, Geometry, Overdraw);
        view.ink = same!(self.ink.show, LookShow => InkDebugView: Painting, Lines, Features, Wash);
        view
    }
}

fn distant(towards_light: Vec3, strength: f32) -> Light {
    Light::Directional { towards_light, color: Vec3::splat(strength) }
}
