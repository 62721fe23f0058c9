//! What is set per frame.

use super::fur::{FurParams, SelfShadow};
use super::hair_motion::HairMotionParams;
use super::ink::InkParams;
use super::shadows::ShadowParams;
#[cfg(feature = "study")]
use super::study::Study;
use super::style::Style;
use crate::camera::{Camera, Light};
use crate::error::RuntimeError;
use glam::Vec3;
use pelage_formats::Shading;
use pelage_formats::meaning::environment::Environment;

/// Set per frame.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct FrameParams {
    /// From where the scene is seen.
    pub camera: Camera,
    /// Width and height of the part of the target that the frame is drawn to, pixels, at least 1 each. The application's pass has a
    /// viewport of that size; for [`Style::Ink`] it begins at the target's upper left corner.
    pub viewport: [u32; 2],
    /// The moment by the application's clock, seconds (default 0). What moves of itself, which is hair, lives from the moment of one frame of an
    /// owner to that of the next; frames of one moment, for two cameras say, have the same. Poses are set by [`crate::Instance::motion`].
    pub time_s: f64,
    /// What moves hair on guides (default `None`: it stays as it was groomed).
    pub hair_motion: Option<HairMotionParams>,
    /// The key light: the one that throws shadows.
    pub light: Light,
    /// Other lights, without shadows: at most [`MAX_FILL_LIGHTS`] (default none). Each costs about as much as the key light.
    pub fill_lights: Vec<Light>,
    /// Light from everywhere, linear RGB, multiplies the package's ambient constant (default 1).
    pub ambient: Vec3,
    /// Light from all around, in place of ambient light (default `None`). Its sun is no light of the frame: give it as key light ([`Light::sun`]).
    pub environment: Option<Environment>,
    /// Whether things throw soft shadows, Attenu_Shadow of Yang 2006, eq. (3), by a shadow-width map (default true): skins on fur, and
    /// what [`crate::Casters`] brings. Without it [`crate::Frame::shadow_receiver`] lights everything.
    pub soft_shadow: bool,
    /// How the key light's shadows are made (default [`ShadowParams::default`]).
    pub shadows: ShadowParams,
    /// How models are drawn (default fur).
    pub style: Style,
    /// Constants of the lighting equation instead of the package's own (default `None`).
    pub shading: Option<Shading>,
    /// The papers' printed forms, and what is measured (default: ours, and nothing).
    #[cfg(feature = "study")]
    pub study: Study,
}

impl FrameParams {
    /// A furry picture of that many pixels from `camera`, with everything else at its default.
    pub fn new(camera: Camera, viewport: [u32; 2]) -> Self {
        Self {
            camera,
            viewport,
            time_s: 0.0,
            hair_motion: None,
            light: Light::default(),
            fill_lights: Vec::new(),
            ambient: Vec3::ONE,
            environment: None,
            soft_shadow: true,
            shadows: ShadowParams::default(),
            style: Style::default(),
            shading: None,
            #[cfg(feature = "study")]
            study: Study::default(),
        }
    }

    /// The same with changes: `FrameParams::new(camera, viewport).with(|p| p.soft_shadow = false)`.
    pub fn with(mut self, change: impl FnOnce(&mut Self)) -> Self {
        change(&mut self);
        self
    }

    /// The same with changes to how fur is drawn; in another style as it is.
    pub fn with_fur(mut self, change: impl FnOnce(&mut FurParams)) -> Self {
        self.fur_mut().map(change);
        self
    }

    /// How fur is drawn, to be changed; `None` in another style.
    pub fn fur_mut(&mut self) -> Option<&mut FurParams> {
        if let Style::Fur(fur) = &mut self.style { Some(fur) } else { None }
    }

    /// The same in ink.
    pub fn with_ink(mut self, ink: InkParams) -> Self {
        self.style = Style::Ink(ink);
        self
    }

    /// Whether no light comes from the key light beside an environment: only where it would shine from is looked at then.
    pub(crate) fn is_key_dark(&self) -> bool {
        self.environment.is_some() && self.light.color() == Vec3::ZERO
    }

    /// Whether hair shadows hair.
    pub(crate) fn self_shadow(&self) -> bool {
        self.form_of_self_shadow() != SelfShadow::Off
    }

    /// How hair shadows hair.
    pub(crate) fn form_of_self_shadow(&self) -> SelfShadow {
        self.style.fur().map_or(SelfShadow::Off, |fur| fur.self_shadow)
    }

    pub(crate) fn check(&self, limits: &wgpu::Limits) -> Result<(), RuntimeError> {
        let fail = |field, found: String, expected: &str| {
            Err(RuntimeError::Params { field, found, expected: expected.into() })
        };
        let most = limits.max_texture_dimension_2d;
        if !self.viewport.iter().all(|side| (1..=most).contains(side)) {
            let [width, height] = self.viewport;
            return fail("FrameParams::viewport", format!("{width}x{height}"), &format!("1..={most} pixels a side"));
        }
        if !self.time_s.is_finite() {
            return fail("FrameParams::time_s", self.time_s.to_string(), "a finite number");
        }
        self.hair_motion.iter().try_for_each(HairMotionParams::check)?;
        self.shadows.check(limits)?;
        match &self.style {
            Style::Fur(fur) => fur.check()?,
            Style::Bare => {}
            Style::Ink(ink) => ink.check()?,
        }
        if self.fill_lights.len() > MAX_FILL_LIGHTS {
            return fail("FrameParams::fill_lights", format!("{} lights", self.fill_lights.len()), "at most 32");
        }
        if !self.ambient.is_finite() {
            return fail("FrameParams::ambient", self.ambient.to_string(), "finite numbers");
        }
        if let Some((key, found)) = self.environment.as_ref().and_then(Environment::fault) {
            let expected = "an environment that Environment::fault finds nothing wrong with".into();
            let found = format!("{key}: {found}");
            return Err(RuntimeError::Params { field: "FrameParams::environment", found, expected });
        }
        self.shading.iter().try_for_each(|shading| check_shading("FrameParams::shading", shading))
    }
}

/// Fails for constants of the lighting equation outside their ranges; `field` is where they stand.
pub(crate) fn check_shading(field: &'static str, s: &Shading) -> Result<(), RuntimeError> {
    let expected = "every number in its range".into();
    s.check().map_err(|found| RuntimeError::Params { field, found, expected })
}

/// Most lights without shadow that a frame may have.
pub const MAX_FILL_LIGHTS: usize = 32;
