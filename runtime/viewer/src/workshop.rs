//! Interfaces through which the application provides the content of a window. The window itself does not depend on
//! models, recipes or tracers.

use crate::knobs::Knobs;
use crate::subject::Subject;
use image::{RgbImage, RgbaImage};
use pelage_stage::{Look, NamedPackage, Viewpoint};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Result, or an error message with the file, the position in it, the value found and the value expected.
pub type Outcome<T> = Result<T, String>;

/// Progress of some work.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Progress {
    /// Current activity.
    pub doing: String,
    /// Finished fraction, 0..=1, if known.
    pub share: Option<f32>,
}

/// Content made from files.
pub struct WindowContent {
    /// Subject to show.
    pub subject: Subject,
    /// Look of a scene; `None` for other content.
    pub look: Option<Look>,
    /// Recipe of a baked model, as in its file; edits are based on it. `None` for other content.
    pub recipe: Option<Box<dyn Knobs>>,
    /// Notes on repairs, choices and omissions.
    pub notes: Vec<String>,
    /// Stages of the bake that were run again, with their times in seconds.
    pub stages: Vec<(String, f64)>,
}

/// Source of a window's content. All methods are called on a background thread.
pub trait Workshop: Send {
    /// Opens a file: a package, a model, a recipe for the opened model, or a scene.
    ///
    /// Fails if the file is unsupported; the previous file then stays open.
    fn open(&mut self, path: &Path) -> Outcome<()>;

    /// Makes the opened content from the current files, with edits (`key=value`) of its recipe.
    ///
    /// Fails with an error in a file or in an edit.
    fn make(&mut self, edits: &[String], progress: &mut dyn FnMut(Progress)) -> Outcome<WindowContent>;

    /// Returns the files that affect the content, including missing ones: the model with its images and buffers, the
    /// recipe with its images, and the scene with its packages.
    fn files(&self) -> Vec<PathBuf>;

    /// Writes the recipe with edits to its file, or, without one, beside the model. Returns the path.
    ///
    /// Fails if the content has no recipe, or the file system reports an error.
    fn save_recipe(&mut self, edits: &[String]) -> Outcome<PathBuf>;

    /// Creates a source of reference images, which is moved to another thread.
    fn reference_source(&self) -> Box<dyn ReferenceSource>;
}

/// Request for a reference image: a view of a package.
#[derive(Clone, Debug)]
pub struct ReferenceRequest {
    /// Package to trace.
    pub file: Arc<NamedPackage<'static>>,
    /// Look: picture, light and style.
    pub look: Look,
    /// Camera.
    pub camera: Viewpoint,
    /// Current clip; `None` is the rest pose.
    pub clip: Option<String>,
    /// Time, seconds.
    pub time_s: f32,
    /// Rendered picture of the same view: sRGB-encoded, straight alpha.
    pub drawn: RgbaImage,
}

/// Reference image; possibly unfinished.
#[derive(Clone, Debug)]
pub struct ReferencePicture {
    /// Picture: sRGB-encoded, straight alpha.
    pub picture: RgbaImage,
    /// Number of samples per pixel so far.
    pub samples: u32,
    /// Final number of samples per pixel.
    pub of_samples: u32,
    /// FLIP of the rendered picture against this one: mean and map.
    pub flip: Option<(f64, RgbImage)>,
}

/// Source of reference images.
pub trait ReferenceSource: Send {
    /// Traces a reference image. Calls `show` with each refinement, which has more samples than the previous one.
    /// `progress` returns whether to continue.
    ///
    /// Fails with an error in the package, or the reason why it has no reference image.
    fn trace(
        &mut self,
        asked: &ReferenceRequest,
        show: &mut dyn FnMut(ReferencePicture),
        progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> Outcome<()>;
}
