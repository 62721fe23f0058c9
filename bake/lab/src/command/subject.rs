//! Subject of a chart: a model with its recipe.

use super::args::ChartArgs;
use pelage_bake::io;
use pelage_bake::pipeline::{self, BakeInput};
use pelage_bake::recipe::Recipe;
use pelage_bake::reslice::reslice;
use pelage_bake::stages::groom::{self, MapImages};
use pelage_bake::stages::import::{ImportOptions, import};
use pelage_bake::stages::metric;
use pelage_herd::shell_word;
use pelage_import::BakeError;
use pelage_import::mesh::{Model, RestPose};
use pelage_stage::NamedPackage;
use pelage_tool::built_in::HARE;
use pelage_tool::exit::Failure;
use pelage_tool::mesh_glb;
use pelage_tool::package_file;
use std::path::{Path, PathBuf};

/// Model with its recipe.
pub struct Subject {
    /// Model file as given by the user.
    pub file: String,
    /// Name of the model; for a file, without folder and extension.
    pub name: String,
    /// Imported model.
    pub model: Model,
    /// Package, if one was given instead of a model.
    pub package: Option<NamedPackage<'static>>,
    /// Recipe on which all rows are based.
    pub recipe: Recipe,
    /// Images named by the recipe.
    pub images: MapImages,
    /// Command `pelage bake` that reads model and recipe, without changes to the recipe.
    pub command: String,
    /// Changes to the recipe, as arguments of `--set`.
    pub sets: Vec<String>,
    /// Arguments of `pelage chart` that name model and recipe.
    pub arguments: String,
}

impl Subject {
    /// Bakes the model, or reslices the package, with `recipe`.
    pub fn bake(&self, recipe: &Recipe) -> Result<NamedPackage<'static>, Failure> {
        let (name, bytes) = match &self.package {
            Some(package) => (package.name.clone(), reslice(&package.name, &package.open()?, recipe)?),
            None => {
                let input = BakeInput::new(&self.file, &self.name, recipe, &self.images);
                (self.name.clone(), pipeline::bake(&input, &self.model, &mut |_| ())?.package)
            }
        };
        Ok(NamedPackage { name, bytes: bytes.into() })
    }

    /// Reads the model and recipe that the arguments name; the default is the built-in hare.
    pub fn new(args: &ChartArgs) -> Result<Self, Failure> {
        let sets = args.recipe.set.clone();
        let set_words = set_words(&sets);
        if let Some(path) = &args.model {
            if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("pelage")) {
                return Self::of_package(args, path);
            }
            let (recipe, _) = args.recipe.read()?;
            let model =
                io::read_model(path, &ImportOptions { unit_m: recipe.model.unit_m }, args.recipe.file_access())?;
            let recipe = in_tile(&recipe, &model)?;
            let mut files = format!(" {}", shell_word(&path.display().to_string()));
            if let Some(recipe) = &args.recipe.recipe {
                files += &format!(" --recipe {}", shell_word(&recipe.display().to_string()));
            }
            let (command, arguments) = (format!("pelage bake{files}"), files + &set_words);
            let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            let (file, images) = (path.display().to_string(), args.recipe.images(&recipe)?);
            return Ok(Self { file, name, model, package: None, recipe, images, command, sets, arguments });
        }
        if args.recipe.recipe.is_some() {
            return Err(Failure::Usage("--recipe needs a MODEL: the built-in hare has its own".into()));
        }
        let mut recipe = HARE.recipe()?;
        args.recipe.apply_to(&mut recipe)?;
        let command = format!("pelage bake assets/models/{0}.glb --recipe assets/recipes/{0}.toml", HARE.name);
        let (file, name, images) = (HARE.file(), HARE.name.into(), args.recipe.images(&recipe)?);
        let model = HARE.import(&recipe)?;
        let recipe = in_tile(&recipe, &model)?;
        Ok(Self {
            file,
            name,
            model,
            package: None,
            recipe,
            images,
            command,
            sets,
            arguments: set_words + &sky_words(&args.sky),
        })
    }

    /// Reads a package with its recorded recipe. The package's mesh is used as the model.
    fn of_package(args: &ChartArgs, path: &Path) -> Result<Self, Failure> {
        if args.recipe.recipe.is_some() {
            return Err(Failure::Usage("--recipe needs a MODEL: a package has its own".into()));
        }
        let package = package_file::read(path)?;
        let (file, opened) = (path.display().to_string(), package.open()?);
        let manifest = opened.manifest();
        let mut recipe = Recipe::parse_recorded(&format!("{file}, recipe"), &manifest.recipe)?;
        recipe.model.unit_m = 1.0;
        args.recipe.apply_to(&mut recipe)?;
        let mesh = opened.mesh().map_err(|error| package.fault(error))?;
        let glb = mesh.and_then(|mesh| mesh_glb::write(&mesh.to_data(), manifest)).ok_or_else(|| BakeError::Input {
            file: file.clone(),
            place: "mesh".into(),
            reason: "found no triangles, expected at least one".into(),
        })?;
        let mut no_files =
            |uri: &str, _: u64| Err(BakeError::Internal(format!("the mesh of a package refers to the file {uri}")));
        let model = import(&file, &glb, &mut no_files, &ImportOptions { unit_m: 1.0 })?;
        let (name, word) = (manifest.model.clone(), format!(" {}", shell_word(&file)));
        let sets = args.recipe.set.clone();
        let (command, arguments) = (format!("pelage bake{word}"), word + &set_words(&sets));
        let images = MapImages::default();
        Ok(Self { file, name, model, recipe, images, command, sets, arguments, package: Some(package) })
    }
}

/// Returns the recipe with its hair in units of a tile, so that hair is the same for all rows.
fn in_tile(recipe: &Recipe, model: &Model) -> Result<Recipe, BakeError> {
    let bounds = groom::bounds(&RestPose::of(&model.mesh, model.animation.as_ref()));
    Ok(metric::to_tile_units(recipe, &bounds)?.recipe)
}

/// Formats changes to a recipe as command-line options: ` --set a=1 --set b=2`.
pub fn set_words<'a>(sets: impl IntoIterator<Item = &'a String>) -> String {
    sets.into_iter().map(|set| format!(" --set {}", shell_word(set))).collect()
}

/// Formats environment maps as command-line options.
fn sky_words(files: &[PathBuf]) -> String {
    files.iter().map(|file| format!(" --sky {}", shell_word(&file.display().to_string()))).collect()
}
