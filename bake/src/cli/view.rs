//! How a package or a scene is looked at: what the arguments of `render` and `bench` come to.

use super::exit::Failure;
use super::view_args::ViewArgs;
use glam::Vec3;
use pelage_formats::Package;
use pelage_stage::{Look, NamedPackage, Size, StageError, Viewpoint, framing, rest_points};

/// How a package is looked at; what the arguments that `render` and `bench` share come to.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// Picture, light and style.
    pub look: Look,
    /// From where; `None` frames the model from its front left.
    pub camera: Option<Viewpoint>,
    /// Name of the clip; `None` shows the rest pose.
    pub clip: Option<String>,
    /// Moment of the clip, seconds; clips loop.
    pub time_s: f32,
    /// Copies of the model, at least 1.
    pub crowd: u32,
}

impl Default for View {
    fn default() -> Self {
        Self { look: Look::default(), camera: None, clip: None, time_s: 0.0, crowd: 1 }
    }
}

impl View {
    /// What the arguments say over `look`.
    ///
    /// # Errors
    ///
    /// A look file that cannot be read or says something wrong.
    pub fn new(args: &ViewArgs, mut look: Look) -> Result<Self, Failure> {
        args.look.apply(&mut look)?;
        Ok(Self { look, camera: args.camera, clip: args.clip.clone(), time_s: args.time, crowd: args.crowd })
    }

    /// The same with changes to its look.
    pub fn with(mut self, change: impl FnOnce(&mut Look)) -> Self {
        change(&mut self.look);
        self
    }

    /// The default view in a picture of that size, pixels.
    pub fn sized((width, height): (u32, u32)) -> Self {
        Self::default().with(|look| look.picture.size = Size { width, height })
    }

    /// Width and height of the picture, pixels.
    pub fn size(&self) -> (u32, u32) {
        (self.look.picture.size.width, self.look.picture.size.height)
    }

    /// The view's own camera, or one that frames `rest_points` with hair of `height_m`.
    pub fn viewpoint(&self, rest_points: &[Vec3], height_m: f32) -> Viewpoint {
        let margin_m = if self.look.has_fur() { height_m } else { 0.0 };
        let framed = || framing::frame(rest_points, margin_m, self.look.aspect(), framing::TOWARDS_CAMERA);
        self.camera.unwrap_or_else(framed)
    }

    /// The view's own camera, or one that frames the model of a package at rest; `package` is `file` opened.
    pub fn viewpoint_of(&self, file: &NamedPackage<'_>, package: &Package<'_>) -> Result<Viewpoint, StageError> {
        let points = if self.camera.is_none() { rest_points(file, package)? } else { Vec::new() };
        Ok(self.viewpoint(&points, package.manifest().fur.height_m))
    }
}
