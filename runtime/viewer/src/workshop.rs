//! What makes the things that a window shows. The window knows no models, recipes or tracers: who opens it brings them.

use crate::knobs::Knobs;
use crate::subject::Subject;
use image::{RgbImage, RgbaImage};
use pelage_stage::{Look, NamedPackage, Viewpoint};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What something came to, or what is wrong with it: which file, where in it, what was found and what was expected.
pub type Outcome<T> = Result<T, String>;

/// How far some work is.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Progress {
    /// What is being done.
    pub doing: String,
    /// How much of it is done, 0..=1, where that is known.
    pub share: Option<f32>,
}

/// Something to look at, made of files.
pub struct Made {
    /// What is drawn.
    pub subject: Subject,
    /// How it says that it wants to be seen; of a scene.
    pub look: Option<Look>,
    /// The recipe of what was baked, as its file says it: what edits go over.
    pub recipe: Option<Box<dyn Knobs>>,
    /// What was repaired, chosen or left out.
    pub notes: Vec<String>,
    /// What was made anew, with seconds: stages of a bake.
    pub stages: Vec<(String, f64)>,
}

/// Makes what is shown. All of it is called on a thread of its own.
pub trait Workshop: Send {
    /// Opens what the user named: a package, a model, a recipe for the model that is open, a scene.
    ///
    /// # Errors
    ///
    /// For a file that is none of these; what was open stays open.
    fn open(&mut self, path: &Path) -> Outcome<()>;

    /// Makes what is open, as its files stand now and with these edits (`key=value`) of its recipe.
    ///
    /// # Errors
    ///
    /// What is wrong with a file, or with an edit.
    fn make(&mut self, edits: &[String], progress: &mut dyn FnMut(Progress)) -> Outcome<Made>;

    /// Files whose change makes another thing of it: the model, its images and buffers, the recipe, its images, the scene and its packages. Those
    /// that are missing, too.
    fn files(&self) -> Vec<PathBuf>;

    /// Writes the recipe with these edits to where it came from, or beside the model; says where.
    ///
    /// # Errors
    ///
    /// Where there is no recipe, or the file system refuses.
    fn save_recipe(&mut self, edits: &[String]) -> Outcome<PathBuf>;

    /// What traces true pictures and compares; it goes to a thread of its own.
    fn judge(&self) -> Box<dyn Judge>;
}

/// A view of a package, of which the true picture is asked.
#[derive(Clone, Debug)]
pub struct TruthAsked {
    /// The package.
    pub file: Arc<NamedPackage<'static>>,
    /// Picture, light and style.
    pub look: Look,
    /// From where.
    pub camera: Viewpoint,
    /// The clip that plays, and the moment of the scene, seconds.
    pub clip: Option<String>,
    /// Seconds.
    pub time_s: f32,
    /// What was drawn of the same view: sRGB-encoded, straight alpha.
    pub drawn: RgbaImage,
}

/// A true picture, as far as it is traced.
#[derive(Clone, Debug)]
pub struct Truth {
    /// sRGB-encoded, straight alpha.
    pub picture: RgbaImage,
    /// Samples per pixel so far.
    pub samples: u32,
    /// All that there will be.
    pub of_samples: u32,
    /// Mean FLIP of what was drawn against it, and its picture.
    pub flip: Option<(f64, RgbImage)>,
}

/// Traces and compares.
pub trait Judge: Send {
    /// Traces a true picture in ever more samples; `show` gets each, `progress` says whether to go on.
    ///
    /// # Errors
    ///
    /// What is wrong with the package, or why there is no truth of it.
    fn trace(
        &mut self,
        asked: &TruthAsked,
        show: &mut dyn FnMut(Truth),
        progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> Outcome<()>;
}
