//! How a package or a scene is looked at: what the arguments of `render` and `bench` come to.

use super::exit::Failure;
use super::ink_args::InkView;
use super::view_args::{DetailArg, LightingArg, Penumbra, Slant, StyleArg, ViewArgs};
use super::words::{Background, Switch};
use glam::Vec3;
use pelage_bake::recipe::CameraView;
use pelage_runtime::{Light, Lighting, PenumbraForm, ShadowParams, SlantForm, Study, StyleKind};
use pelage_stage::{Viewpoint, framing};

/// How a package is looked at; what the arguments that `render` and `bench` share come to.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// Width and height of the picture, pixels.
    pub size: (u32, u32),
    /// Samples per pixel, 1 or 4.
    pub samples: u32,
    /// With fur or without.
    pub style: StyleKind,
    /// From where; `None` frames the model from its front left.
    pub camera: Option<Viewpoint>,
    /// The key light.
    pub light: Light,
    /// Name of the clip; `None` shows the rest pose.
    pub clip: Option<String>,
    /// Moment of the clip, seconds; clips loop.
    pub time_s: f32,
    /// Layers to draw; `None` for as many as were baked.
    pub layers: Option<u32>,
    /// How much of the fur is drawn where it is small.
    pub detail: DetailArg,
    /// Copies of the model, at least 1.
    pub crowd: u32,
    /// Whether fins are drawn where the package has them.
    pub fins: bool,
    /// Lights without shadow.
    pub fill_lights: Vec<Light>,
    /// Terms of Yang 2006, eq. (3).
    pub terms: Terms,
    /// How the key light's shadows are made.
    pub shadows: ShadowParams,
    /// sRGB-encoded, or `None` for transparent.
    pub background: Option<[u8; 3]>,
    /// How the ink style is drawn.
    pub ink: InkView,
    /// The papers' printed forms, where they are asked for; but for `terms`, and those of the ink style.
    pub study: Study,
}

/// Which terms of Yang 2006, eq. (3) are taken into account.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Terms {
    /// γ: ambient light fades towards the skin.
    pub ambient_attenuation: bool,
    /// t: hair shadows hair.
    pub self_shadow: bool,
    /// Attenu_Back: the light ends behind the body.
    pub back_attenuation: bool,
    /// Attenu_Shadow: things throw soft shadows.
    pub soft_shadow: bool,
}

impl Default for View {
    fn default() -> Self {
        Self {
            size: (834, 424),
            samples: 1,
            style: StyleKind::Fur,
            camera: None,
            light: distant(framing::TOWARDS_LIGHT, 1.0),
            clip: None,
            time_s: 0.0,
            layers: None,
            detail: DetailArg::Full,
            crowd: 1,
            fins: true,
            fill_lights: Vec::new(),
            terms: Terms { ambient_attenuation: true, self_shadow: true, back_attenuation: true, soft_shadow: true },
            shadows: ShadowParams::default(),
            background: None,
            ink: InkView::default(),
            study: Study::default(),
        }
    }
}

impl TryFrom<&ViewArgs> for View {
    type Error = Failure;

    fn try_from(args: &ViewArgs) -> Result<Self, Failure> {
        let defaults = Self::default();
        let light = match (args.light, args.point_light) {
            (Some(direction), _) => distant(direction.0, 1.0),
            (None, Some(position)) => Light::Point { position: position.0, color: Vec3::ONE },
            (None, None) => defaults.light,
        };
        Ok(Self {
            size: args.size.map_or(defaults.size, |size| (size.width, size.height)),
            style: args.style.map_or(defaults.style, StyleArg::style),
            camera: args.camera.map(viewpoint),
            light,
            clip: args.clip.clone(),
            time_s: args.time,
            layers: args.layers,
            detail: args.detail,
            crowd: args.crowd,
            fins: args.fins != Some(Switch::Off),
            fill_lights: args.fill_light.iter().map(|f| distant(f.direction, f.strength)).collect(),
            terms: Terms {
                ambient_attenuation: args.ambient_attenuation == Switch::On,
                self_shadow: args.self_shadow == Switch::On,
                back_attenuation: args.back_attenuation == Switch::On,
                soft_shadow: args.soft_shadow == Switch::On,
            },
            shadows: ShadowParams::default().with(|shadows| {
                shadows.map_size = args.shadow_map;
                shadows.map_layers = args.shadow_layers;
                shadows.density = args.shadow_density;
                shadows.penumbra = args.penumbra;
                shadows.shrink = args.shadow_shrink;
            }),
            study: study(args),
            ink: InkView { args: args.ink.clone(), background: args.background },
            background: args.background.map_or(defaults.background, Background::color),
            ..defaults
        })
    }
}

impl View {
    /// The view's own camera, or one that frames `rest_points` with hair of `height_m`.
    pub fn viewpoint(&self, rest_points: &[Vec3], height_m: f32) -> Viewpoint {
        let margin_m = if self.style == StyleKind::Fur { height_m } else { 0.0 };
        let framed = || framing::frame(rest_points, margin_m, self.aspect(), framing::TOWARDS_CAMERA);
        self.camera.unwrap_or_else(framed)
    }

    /// Width of the picture over its height.
    pub fn aspect(&self) -> f32 {
        self.size.0 as f32 / self.size.1 as f32
    }
}

/// A camera that a recipe or an argument names.
pub fn viewpoint(view: CameraView) -> Viewpoint {
    Viewpoint { eye: view.eye, target: view.target, fov_deg: view.fov_deg }
}

fn study(args: &ViewArgs) -> Study {
    Study::default().with(|study| {
        study.look_slant = slant(args.view_slant);
        study.light_slant = slant(args.slant);
        study.penumbra = match args.penumbra_form {
            Penumbra::Centred => PenumbraForm::Centred,
            Penumbra::Inner => PenumbraForm::Inner,
        };
        study.lighting = match args.lighting {
            LightingArg::Pixel => Lighting::Pixel,
            LightingArg::Vertex => Lighting::Vertex,
        };
    })
}

fn slant(slant: Slant) -> SlantForm {
    match slant {
        Slant::Corrected => SlantForm::Corrected,
        Slant::Printed => SlantForm::Printed,
    }
}

/// A white light from far away.
pub fn distant(towards_light: Vec3, strength: f32) -> Light {
    Light::Directional { towards_light, color: Vec3::splat(strength) }
}
