//! View of a package or a scene, from the arguments that `render`, `bench` and `reference` share.

use super::backdrop;
use super::camera_args::CameraArgs;
use super::environment::Sky;
use super::exit::Failure;
use super::seal;
use super::view_args::{Blend, MorphWeight, ViewArgs};
use glam::Vec3;
use pelage_formats::{ClipLayer, Package};
use pelage_runtime::FrameParams;
use pelage_stage::{
    Framing, Look, NamedPackage, Playback, Size, StageError, Viewpoint, find_clip, find_morph, no_match_error, outline,
};
use std::sync::Arc;

/// View of a package, from the arguments that `render`, `bench` and `reference` share.
#[derive(Clone, Debug, PartialEq)]
pub struct PictureView {
    /// Look: picture, light and style.
    pub look: Look,
    /// Environment map that the look names.
    pub sky: Option<Arc<Sky>>,
    /// Camera; `None` frames everything that is drawn.
    pub camera: Option<Viewpoint>,
    /// Framing options, used without a camera.
    pub framing: Framing,
    /// Name of the clip; `None` shows the rest pose.
    pub clip: Option<String>,
    /// Clip to blend to, and the amount of it.
    pub blend: Option<Blend>,
    /// Weights of individual morph targets, which override the clips.
    pub morphs: Vec<MorphWeight>,
    /// Time in the clips, seconds. Clips loop.
    pub time_s: f32,
    /// Number of copies of the model, at least 1.
    pub crowd: u32,
}

impl Default for PictureView {
    fn default() -> Self {
        Self {
            look: Look::default(),
            sky: None,
            camera: None,
            framing: Framing::default(),
            clip: None,
            blend: None,
            morphs: Vec::new(),
            time_s: 0.0,
            crowd: 1,
        }
    }
}

impl PictureView {
    /// Creates the view, and applies the look options to `look`.
    ///
    /// Fails for an unreadable or invalid look file or environment map.
    pub fn new(args: &ViewArgs, mut look: Look) -> Result<Self, Failure> {
        args.look.apply(&mut look)?;
        backdrop::check(&look)?;
        seal::read_of(&mut look)?;
        let (clip, blend, morphs) = (args.clip.clone(), args.blend.clone(), args.morph.clone());
        let sky = Sky::of(&look)?.map(Arc::new);
        let view = Self { look, sky, clip, blend, morphs, time_s: args.time, crowd: args.crowd, ..Self::default() };
        Ok(view.seen_from(&args.camera))
    }

    /// Returns the view with the camera and framing of `args`.
    pub fn seen_from(self, args: &CameraArgs) -> Self {
        Self { camera: args.camera, framing: args.framing(), ..self }
    }

    /// Returns the view with a changed look.
    pub fn with(mut self, change: impl FnOnce(&mut Look)) -> Self {
        change(&mut self.look);
        self
    }

    /// Returns the view with its look's own light, as [`Look::resolved`] does.
    pub fn resolved(&self, fibres: bool) -> Self {
        let mut view = self.clone();
        view.look = self.look.resolved(fibres);
        if view.look.environment.sky != self.look.environment.sky {
            // The studio is not a file, so it can always be read.
            view.sky = Sky::of(&view.look).ok().flatten().map(Arc::new);
        }
        view
    }

    /// Returns the default view with a picture size in pixels.
    pub fn sized((width, height): (u32, u32)) -> Self {
        Self::default().with(|look| look.picture.size = Size { width, height })
    }

    /// Returns the parameters of a frame.
    pub fn frame_params(&self) -> FrameParams {
        let mut look = self.look.clone();
        if let Some(sky) = &self.sky {
            // The lights were already read with the look, so reading cannot fail.
            let _ = look.read_environment(&mut |_, _, _| Ok(Arc::new(sky.lights())));
        }
        look.frame_params()
    }

    /// Returns the width and height of the picture, pixels.
    pub fn size(&self) -> (u32, u32) {
        (self.look.picture.size.width, self.look.picture.size.height)
    }

    /// Returns the view's camera. Without one, returns a camera that frames the points `outline` of a model with hair
    /// of length `height_m`.
    pub fn viewpoint(&self, outline: &[Vec3], height_m: f32) -> Viewpoint {
        self.camera.unwrap_or_else(|| self.framing.view(outline, height_m, self.look.aspect()))
    }

    /// Returns the clips that pose the skeleton of the model; `package` is the opened `file`.
    ///
    /// Fails for an unknown clip or a damaged package.
    pub fn layers(&self, file: &NamedPackage<'_>, package: &Package<'_>) -> Result<Vec<ClipLayer>, StageError> {
        let layer = |name: Option<&str>, share: f32| {
            let playing = Playback::named(file, package, name)?;
            Ok::<_, StageError>(playing.map(|playing| playing.layer(self.time_s, share)))
        };
        let wholly = layer(self.clip.as_deref(), 1.0)?;
        let over = self.blend.as_ref().map(|blend| layer(Some(&blend.clip), blend.share)).transpose()?;
        Ok(wholly.into_iter().chain(over.flatten()).collect())
    }

    /// Returns the weights of individual morph targets; `package` is the opened `file`.
    ///
    /// Fails for an unknown target or a damaged package.
    pub fn morph_weights(
        &self,
        file: &NamedPackage<'_>,
        package: &Package<'_>,
    ) -> Result<Vec<(usize, f32)>, StageError> {
        let found = |morph: &MorphWeight| Ok((find_morph(file, package, &morph.target)?, morph.weight));
        self.morphs.iter().map(found).collect()
    }

    /// Returns the points of a model that the camera must frame; `package` is the opened `file`.
    ///
    /// Fails for an unknown clip or part, or a damaged package.
    pub fn outline(&self, file: &NamedPackage<'_>, package: &Package<'_>) -> Result<Vec<Vec3>, StageError> {
        let (clip, part) = (find_clip(file, package, self.clip.as_deref())?, self.framing.look_at.as_deref());
        let points = outline(file, package, clip, part)?;
        match part {
            Some(part) if points.is_empty() => Err(no_match_error([(file, package)].into_iter(), part)),
            _ => Ok(points),
        }
    }
}
