//! Interfaces that provide the content of a window. The window knows no models, recipes or tracers; the application
//! provides them.

use crate::knobs::Knobs;
use crate::subject::Subject;
use image::{RgbImage, RgbaImage};
use pelage_stage::{Look, NamedPackage, Viewpoint};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Result, or an error message: which file, where in it, what was found and what was expected.
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
    /// Subject to draw.
    pub subject: Subject,
    /// Look of a scene.
    pub look: Option<Look>,
    /// Recipe of a baked model as in its file, the base of edits.
    pub recipe: Option<Box<dyn Knobs>>,
    /// Notes on repairs, choices and omissions.
    pub notes: Vec<String>,
    /// Stages of the bake that ran again, with seconds.
    pub stages: Vec<(String, f64)>,
}

/// Source of a window's content. All methods are called on a separate thread.
pub trait Workshop: Send {
    /// Opens a file: a package, a model, a recipe for the open model, or a scene.
    ///
    /// # Errors
    ///
    /// Unsupported file; what was open stays open.
    fn open(&mut self, path: &Path) -> Outcome<()>;

    /// Makes the open content from the current files, with edits (`key=value`) of its recipe.
    ///
    /// # Errors
    ///
    /// Error in a file, or in an edit.
    fn make(&mut self, edits: &[String], progress: &mut dyn FnMut(Progress)) -> Outcome<WindowContent>;

    /// Returns the files that affect the content, including missing ones: the model, its images and buffers, the
    /// recipe, its images, the scene and its packages.
    fn files(&self) -> Vec<PathBuf>;

    /// Writes the recipe with edits to its file, or beside the model; returns the path.
    ///
    /// # Errors
    ///
    /// No recipe, or an error of the file system.
    fn save_recipe(&mut self, edits: &[String]) -> Outcome<PathBuf>;

    /// Creates a tracer of reference pictures; it is moved to another thread.
    fn judge(&self) -> Box<dyn ReferenceSource>;
}

/// View of a package for which a reference picture is requested.
#[derive(Clone, Debug)]
pub struct ReferenceRequest {
    /// Package.
    pub file: Arc<NamedPackage<'static>>,
    /// Picture, light and style.
    pub look: Look,
    /// Camera.
    pub camera: Viewpoint,
    /// Current clip; `None` is the rest pose.
    pub clip: Option<String>,
    /// Time, seconds.
    pub time_s: f32,
    /// Drawn picture of the same view: sRGB-encoded, straight alpha.
    pub drawn: RgbaImage,
}

/// Reference picture, as far as it is traced.
#[derive(Clone, Debug)]
pub struct ReferencePicture {
    /// Picture: sRGB-encoded, straight alpha.
    pub picture: RgbaImage,
    /// Samples per pixel so far.
    pub samples: u32,
    /// Final number of samples per pixel.
    pub of_samples: u32,
    /// Mean FLIP of the drawn picture against this one, and its map.
    pub flip: Option<(f64, RgbImage)>,
}

/// Tracer of reference pictures.
pub trait ReferenceSource: Send {
    /// Traces a reference picture with increasing numbers of samples; `show` receives each, `progress` returns whether
    /// to continue.
    ///
    /// # Errors
    ///
    /// Error in the package, or the reason that it has no reference picture.
    fn trace(
        &mut self,
        asked: &ReferenceRequest,
        show: &mut dyn FnMut(ReferencePicture),
        progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> Outcome<()>;
}
