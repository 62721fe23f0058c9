//! Content of the window, loaded from files: packages, baked models, and scenes with their packages.

use super::baking::{BakeThread, Timed};
use super::judge::Tracer;
use super::recipe_file;
use super::recipe_knobs::RecipeKnobs;
use crate::bake::RecipeArgs;
use crate::exit::Failure;
use crate::package_file;
use crate::scene::{Scene, is_scene};
use pelage_bake::io;
use pelage_formats::MAGIC;
use pelage_import::{BakeError, ImportOptions};
use pelage_stage::NamedPackage;
use pelage_viewer::{Outcome, Progress, ReferenceSource, Stamp, Subject, WindowContent, Workshop, stamp};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Kind of an input file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Package.
    Package,
    /// Model to bake.
    Model,
    /// Scene.
    Scene,
    /// Recipe for the open model.
    Recipe,
}

/// Loader of the window's content.
pub struct Studio {
    recipe: RecipeArgs,
    opened: Option<(PathBuf, Kind)>,
    baking: Option<ImportedModel>,
    /// Files that the open content was made from, including those that are missing.
    files: Vec<PathBuf>,
}

/// Imported model, and the files that it was read from.
struct ImportedModel {
    baking: BakeThread,
    model: Stamps,
    unit_m: f32,
    images: Stamps,
}

/// Files, each with its stamp at the time of reading.
type Stamps = Vec<(PathBuf, Stamp)>;

fn stamps(files: &[PathBuf]) -> Stamps {
    files.iter().map(|file| (file.clone(), stamp(file))).collect()
}

/// Returns true if none of the files has changed.
fn is_unchanged(before: &Stamps) -> bool {
    before.iter().all(|(file, then)| stamp(file) == *then)
}

impl Studio {
    /// Creates a loader without content; `recipe` is used for the first model.
    pub fn new(recipe: RecipeArgs) -> Self {
        Self { recipe, opened: None, baking: None, files: Vec::new() }
    }

    /// Returns the kind of a file from its name and first bytes.
    pub fn kind_of(&self, path: &Path) -> Result<Kind, BakeError> {
        let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        let bytes = io::read_file(path)?;
        Ok(match extension.as_str() {
            _ if bytes.starts_with(&MAGIC) => Kind::Package,
            _ if is_scene(&bytes) => Kind::Scene,
            "toml" => Kind::Recipe,
            "glb" | "gltf" | "obj" => Kind::Model,
            _ if bytes.starts_with(b"glTF") => Kind::Model,
            // Opening any other file as a package gives the error message.
            _ => Kind::Package,
        })
    }

    fn bake(
        &mut self,
        path: &Path,
        edits: &[String],
        progress: &mut dyn FnMut(Progress),
    ) -> Result<WindowContent, BakeError> {
        let file = path.display().to_string();
        self.files = [path.to_owned()].into_iter().chain(self.recipe.recipe.clone()).collect();
        // `base` is the recipe on disk and on the command line, before the edits made in the window.
        let (base, _) = self.recipe.read()?;
        let set = [&self.recipe.set[..], edits].concat();
        let args = RecipeArgs { set, ..self.recipe.clone() };
        let (recipe, _) = args.read()?;
        let images: Vec<PathBuf> = recipe.images().iter().map(|(_, name)| args.image_path(name)).collect();
        let strands = recipe.strand_files().into_iter().map(|(_, name)| args.image_path(name));
        let images: Vec<PathBuf> = images.into_iter().chain(strands).collect();
        self.files.extend(images.iter().cloned());
        let unit_m = recipe.model.unit_m;
        let kept = self.baking.take().filter(|kept| is_unchanged(&kept.model) && kept.unit_m == unit_m);
        let (mut kept, is_new) = match kept {
            Some(kept) => (kept, false),
            None => (self.read_model(path, unit_m, progress)?, true),
        };
        self.files.extend(kept.model.iter().map(|(file, _)| file.clone()));
        let now = stamps(&images);
        let others = if is_new || now != kept.images { Some(args.images(&recipe)?) } else { None };
        kept.images = now;
        let baked = kept.baking.bake(recipe, others, progress);
        // After an internal error the thread may have ended, so the next bake starts a new one.
        self.baking = Some(kept).filter(|_| !matches!(baked, Err(BakeError::Internal(_))));
        let (baked, stages): Timed = baked.map_err(|error| args.with_source(&file, error))?;
        let chosen = baked.decisions.iter().map(|d| format!("{}: {} ({})", d.what, d.chosen, d.line));
        let notes = baked.warnings.iter().cloned().chain(chosen).collect();
        let subject = Subject::Package(Arc::new(NamedPackage::new(file, baked.package)));
        Ok(WindowContent { subject, look: None, recipe: Some(Box::new(RecipeKnobs(base))), notes, stages })
    }

    fn read_model(
        &mut self,
        path: &Path,
        unit_m: f32,
        progress: &mut dyn FnMut(Progress),
    ) -> Result<ImportedModel, BakeError> {
        progress(Progress { doing: "import".into(), share: None });
        let mut named = vec![path.to_owned()];
        let options = ImportOptions { unit_m };
        let read =
            io::read_model_noting(path, &options, self.recipe.file_access(), &mut |file| named.push(file.to_owned()));
        self.files.extend(named.iter().cloned());
        // The stamps are taken so that later changes of the model's files are detected.
        let model = stamps(&named);
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let baking = BakeThread::new(path.display().to_string(), name, read?);
        Ok(ImportedModel { baking, model, unit_m, images: Stamps::new() })
    }

    fn scene(&mut self, path: &Path) -> Result<WindowContent, Failure> {
        let scene = Scene::read(path, io::read_file(path)?)?;
        let packages = scene.loaded.packages.iter().map(|package| PathBuf::from(&package.name));
        self.files = [path.to_owned()].into_iter().chain(packages).collect();
        let notes = scene.loaded.names.clone();
        let subject = Subject::Scene(Arc::new(scene.loaded));
        Ok(WindowContent { subject, look: Some(scene.look), recipe: None, notes, stages: Vec::new() })
    }

    fn package(path: &Path) -> Result<WindowContent, Failure> {
        let file = package_file::read(path)?;
        let notes = file.open()?.manifest().warnings.clone();
        let subject = Subject::Package(Arc::new(file));
        Ok(WindowContent { subject, look: None, recipe: None, notes, stages: Vec::new() })
    }
}

impl Workshop for Studio {
    fn open(&mut self, path: &Path) -> Outcome<()> {
        let kind = self.kind_of(path).map_err(|error| error.to_string())?;
        if kind == Kind::Recipe {
            if !matches!(self.opened, Some((_, Kind::Model))) {
                let file = path.display();
                return Err(format!("{file}: found a recipe, but no model is open; open a model first"));
            }
            self.recipe.recipe = Some(path.to_owned());
            return Ok(());
        }
        // The recipe of the command line applies only to the first model.
        if self.opened.is_some() {
            self.recipe = RecipeArgs { allow_outside: self.recipe.allow_outside, ..RecipeArgs::default() };
        }
        self.opened = Some((path.to_owned(), kind));
        self.baking = None;
        Ok(())
    }

    fn make(&mut self, edits: &[String], progress: &mut dyn FnMut(Progress)) -> Outcome<WindowContent> {
        let Some((path, kind)) = self.opened.clone() else { return Err("nothing is open".into()) };
        let made = match kind {
            Kind::Model => self.bake(&path, edits, progress).map_err(Failure::from),
            Kind::Scene => {
                self.files = vec![path.clone()];
                self.scene(&path)
            }
            Kind::Package | Kind::Recipe => {
                self.files = vec![path.clone()];
                Self::package(&path)
            }
        };
        made.map_err(|failure| failure.to_string())
    }

    fn files(&self) -> Vec<PathBuf> {
        self.files.clone()
    }

    fn save_recipe(&mut self, edits: &[String]) -> Outcome<PathBuf> {
        let Some((model, Kind::Model)) = &self.opened else { return Err("no model is open".into()) };
        let path = self.recipe.recipe.clone().unwrap_or_else(|| beside(model));
        // Changes from the command line affect the picture as well, so they are saved with the edits.
        let all = [&self.recipe.set[..], edits].concat();
        recipe_file::change(&path, &all).map_err(|error| error.to_string())?;
        self.recipe.recipe = Some(path.clone());
        self.recipe.set.clear();
        Ok(path)
    }

    fn reference_source(&self) -> Box<dyn ReferenceSource> {
        Box::new(Tracer::default())
    }
}

/// Returns an unused file name for a recipe beside its model.
fn beside(model: &Path) -> PathBuf {
    let stem = model.file_stem().unwrap_or_default().to_string_lossy();
    let name = |number: u32| match number {
        0 => model.with_extension("toml"),
        n => model.with_file_name(format!("{stem}-{n}.toml")),
    };
    (0..).map(name).find(|path| !path.exists()).unwrap_or_else(|| model.with_extension("toml"))
}
