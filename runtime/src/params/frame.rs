//! Parameters of a frame.

use super::debug::DebugView;
use super::fur::{FurParams, SelfShadow};
use super::hair_motion::HairMotionParams;
use super::ink::InkParams;
use super::shadows::ShadowParams;
#[cfg(feature = "study")]
use super::study::Study;
use super::style::Style;
use super::tone_mapping::ToneMapping;
use crate::camera::{Camera, Light};
use crate::error::RuntimeError;
use glam::Vec3;
use pelage_formats::Shading;
use pelage_formats::meaning::environment::Environment;

/// Parameters of a frame.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct FrameParams {
    /// Camera of the frame.
    pub camera: Camera,
    /// Width and height of the part of the target that is drawn to, pixels, at least 1 each. The application's pass has
    /// a viewport of that size. For [`Style::Ink`] it starts at the target's upper left corner.
    pub viewport: [u32; 2],
    /// Time of the application's clock, seconds (default 0). It drives hair motion, which advances from one frame of an
    /// owner to the next. Frames with the same time, such as those of two cameras, show the same state. Poses are set
    /// by [`crate::Instance::motion`].
    pub time_s: f64,
    /// Motion of fur and guided hair (default `None`: all hair keeps its groomed shape).
    pub hair_motion: Option<HairMotionParams>,
    /// Key light, which casts shadows.
    pub light: Light,
    /// Fill lights, which cast no shadows: at most [`MAX_FILL_LIGHTS`] (default none). Each costs about as much as the
    /// key light.
    pub fill_lights: Vec<Light>,
    /// Uniform ambient light, linear RGB; multiplies the package's ambient constant (default 1).
    pub ambient: Vec3,
    /// Environment map that replaces the ambient light (default `None`). It does not include the sun; pass that as the
    /// key light ([`Light::sun`]).
    pub environment: Option<Environment>,
    /// Whether objects cast soft shadows by a shadow-width map, Attenu_Shadow of Yang 2006, eq. (3) (default true).
    /// Casters are mesh surfaces, which shadow the fur, and the geometry of [`crate::Casters`]. If off, the block of
    /// [`crate::Frame::shadow_receiver`] casts no shadow.
    pub soft_shadow: bool,
    /// Shadow settings of the key light (default [`ShadowParams::default`]).
    pub shadows: ShadowParams,
    /// Rendering style (default fur).
    pub style: Style,
    /// Constants of the lighting model that replace the package's own (default `None`).
    pub shading: Option<Shading>,
    /// Tone mapping (default off).
    pub tone_mapping: ToneMapping,
    /// Debug view shown instead of the picture (default: none).
    pub debug: DebugView,
    /// Forms of the papers' formulas, for studies (default: pelage's own).
    #[cfg(feature = "study")]
    pub study: Study,
}

impl FrameParams {
    /// Creates parameters for fur seen from `camera` in a viewport of that many pixels. All other values are the
    /// defaults.
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
            tone_mapping: ToneMapping::default(),
            debug: DebugView::default(),
            #[cfg(feature = "study")]
            study: Study::default(),
        }
    }

    /// Returns the parameters with changes: `FrameParams::new(camera, viewport).with(|p| p.soft_shadow = false)`.
    pub fn with(mut self, change: impl FnOnce(&mut Self)) -> Self {
        change(&mut self);
        self
    }

    /// Returns the parameters with changes to the fur; unchanged in other styles.
    pub fn with_fur(mut self, change: impl FnOnce(&mut FurParams)) -> Self {
        self.fur_mut().map(change);
        self
    }

    /// Returns the fur parameters for modification; `None` in other styles.
    pub fn fur_mut(&mut self) -> Option<&mut FurParams> {
        if let Style::Fur(fur) = &mut self.style { Some(fur) } else { None }
    }

    /// Returns the parameters with the ink style and its settings `ink`.
    pub fn with_ink(mut self, ink: InkParams) -> Self {
        self.style = Style::Ink(ink);
        self
    }

    /// Whether the key light is black and an environment map lights the frame. If so, only the direction of the key
    /// light is used.
    pub(crate) fn is_key_dark(&self) -> bool {
        self.environment.is_some() && self.light.color() == Vec3::ZERO
    }

    /// Whether hair casts shadows on hair.
    pub(crate) fn self_shadow(&self) -> bool {
        self.self_shadow_form() != SelfShadow::Off
    }

    /// Returns the method of hair self-shadow.
    pub(crate) fn self_shadow_form(&self) -> SelfShadow {
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
            let expected = "every value in its range".into();
            let found = format!("{key}: {found}");
            return Err(RuntimeError::Params { field: "FrameParams::environment", found, expected });
        }
        self.shading.iter().try_for_each(|shading| check_shading("FrameParams::shading", shading))
    }
}

/// Returns an error if constants of the lighting model are out of range. `field`: name of the parameter that holds
/// them.
pub(crate) fn check_shading(field: &'static str, s: &Shading) -> Result<(), RuntimeError> {
    let expected = "every number in its range".into();
    s.check().map_err(|found| RuntimeError::Params { field, found, expected })
}

/// Maximum number of fill lights per frame.
pub const MAX_FILL_LIGHTS: usize = 32;
