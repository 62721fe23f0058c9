//! `pelage bake`: bakes a model into a package.

use super::anatomy::Anatomy;
use super::exit::{Exit, Failure};
use super::guard::OutputFile;
use super::job::Job;
use super::limits::{TrialFigures, choose};
use super::output::{Output, human_bytes, require_parent};
use super::picture_args::{PictureArgs, positive};
use super::progress::span;
use super::shell_judge::Baker;
use super::stage_times::{StageTime, StageTimes};
use super::threads;
use super::write_recipe::{self, RecipeChoices};
use pelage_bake::decision::Decision;
use pelage_bake::io::{self, Reach};
use pelage_bake::io_trace;
use pelage_bake::pipeline::{self, BakeInput, Baked, StepEvent};
use pelage_bake::progress::StageProgress;
use pelage_bake::recipe::{Recipe, SliceParams};
use pelage_bake::reslice::Slicer;
use pelage_bake::stages::detail::has_far_layer;
use pelage_bake::stages::groom::{self, MapImages};
use pelage_bake::stages::metric::{self, TileRecipe};
use pelage_bake::stages::pack;
use pelage_bake::stages::slice::shell_bytes;
use pelage_bake::stages::surface::Measures;
use pelage_formats::{Choice, FormatError, InputRecord, Limits as FormatLimits, Package};
use pelage_import::mesh::{Mesh, RestPose};
use pelage_import::{BakeError, ImportOptions, input_record};
use pelage_stage::NamedPackage;
use pelage_truth::decide::Limits;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

/// Bake a glTF or OBJ model into a package
#[derive(Clone, Debug, clap::Args)]
pub struct BakeArgs {
    /// Model: .glb, .gltf or .obj
    #[arg(value_name = "MODEL")]
    model: PathBuf,
    /// Package to write
    #[arg(long, short, value_name = "PKG")]
    output: OutputFile,
    #[command(flatten)]
    recipe: RecipeArgs,
    /// Threads to use; does not change the package [default: one per core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    #[command(flatten)]
    pictures: PictureArgs,
    #[command(flatten)]
    limits: LimitArgs,
    /// Write the full recipe of this bake, with comments and all chosen values, as a starting point. Baking the same
    /// model with it gives the same package, byte for byte. So the package does not record how values were chosen for
    /// limits
    #[arg(long, value_name = "R.toml")]
    write_recipe: Option<OutputFile>,
}

impl BakeArgs {
    /// Returns the description of the bake for the cache. `None` if it is not cached: a bake with limits depends on
    /// measurements, which vary, and a written recipe names images relative to its own folder.
    pub fn job(&self) -> Option<Job> {
        if !self.limits.limits().is_empty() || self.write_recipe.is_some() {
            return None;
        }
        let args = Self { output: Job::name(&self.output), threads: None, ..self.clone() };
        Some(Job::new("bake", &args, &[&self.output]))
    }
}

/// Limits of a bake. If any is given, layers, tile and fins are chosen by measurement, and the recipe's values for them
/// are ignored.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
struct LimitArgs {
    /// Choose the cheapest layers, tile and fins whose error against the reference images is at most this. The error
    /// combines mean FLIP, lost outline and lost contrast; for a picture with all its hair it is about the mean FLIP.
    /// Useful values: 0.01 to 0.1
    #[arg(long, value_name = "E", value_parser = positive, allow_hyphen_values = true)]
    max_error: Option<f64>,
    /// Choose among settings whose frame takes at most this time on this machine's adapter, milliseconds
    #[arg(long, value_name = "MS", value_parser = positive, allow_hyphen_values = true)]
    max_frame_ms: Option<f64>,
    /// Choose among settings whose package has at most this size, bytes
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    max_bytes: Option<u64>,
    /// Measure every setting instead of only the promising ones; slow, to verify the choice
    #[arg(long)]
    exhaustive: bool,
}

impl LimitArgs {
    fn limits(&self) -> Limits {
        Limits { max_error: self.max_error, max_frame_ms: self.max_frame_ms, max_bytes: self.max_bytes }
    }
}

/// Recipe options of the command line.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct RecipeArgs {
    /// Recipe file; missing keys have their defaults
    #[arg(long, value_name = "R.toml")]
    pub recipe: Option<PathBuf>,
    /// Change one key of the recipe, such as hair.length_m=0.02; may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    /// Allow the model to reference files outside its own folder, such as ../textures/fox.png. Without this option no
    /// such file is opened, whether named by the model or reached through links in its folder
    #[arg(long)]
    pub allow_outside: bool,
}

impl RecipeArgs {
    /// Reads the recipe, applies the changes of `--set`, and returns it with the input record of its file.
    pub fn read(&self) -> Result<(Recipe, Option<InputRecord>), BakeError> {
        let mut input = None;
        let mut recipe = match &self.recipe {
            Some(path) => {
                let file = path.display().to_string();
                let text = io::read_text(path, "a recipe in TOML")?;
                input = Some(input_record("recipe", &file, text.as_bytes()));
                Recipe::parse(&file, &text)?
            }
            None => Recipe::default(),
        };
        self.apply_to(&mut recipe)?;
        Ok((recipe, input))
    }

    /// Reads the images of the recipe's maps. Paths are relative to the recipe's folder; those of `--set` may also be
    /// relative to the working directory.
    pub fn images(&self, recipe: &Recipe) -> Result<MapImages, BakeError> {
        let file = self.recipe.as_ref().map_or("--set".to_owned(), |path| path.display().to_string());
        io::read_map_images(&file, &|name| self.image_path(name), recipe)
    }

    /// Returns the path of an image from its name in the recipe.
    pub fn image_path(&self, name: &str) -> PathBuf {
        let folder = self.recipe.as_deref().and_then(Path::parent).unwrap_or(Path::new(""));
        let beside = folder.join(name);
        let mut given =
            self.set.iter().filter_map(|assignment| ImageAssignment::of(assignment)).filter(|n| n.name == name);
        match given.find(|named| named.is_absolute() || !io_trace::exists(&beside)) {
            Some(named) if named.path.exists() || named.is_absolute() => named.path.to_owned(),
            _ => beside,
        }
    }

    /// Adds the source of the value to an error of a stage, which names only the recipe key. The source is the recipe
    /// file or `--set`. Without both, it is the model.
    pub fn with_source(&self, model: &str, error: BakeError) -> BakeError {
        let BakeError::Params { what, reason } = error else { return error };
        let set = self.set.iter().any(|assignment| assignment.split('=').next().is_some_and(|key| key.trim() == what));
        let file = match &self.recipe {
            Some(path) if !set => path.display().to_string(),
            None if self.set.is_empty() => model.to_owned(),
            _ => "--set".to_owned(),
        };
        BakeError::Input { file, place: what.to_owned(), reason }
    }

    /// Returns which files the model may reference.
    pub fn file_access(&self) -> Reach {
        if self.allow_outside { Reach::Anywhere } else { Reach::OwnFolder }
    }

    /// Returns the error message if an assignment of `--set` is invalid.
    pub fn refusal(assignment: &str) -> Option<String> {
        let args = Self { recipe: None, set: vec![assignment.to_owned()], allow_outside: false };
        args.apply_to(&mut Recipe::default()).err().map(|error| match error {
            BakeError::Input { reason, .. } => reason,
            other => other.to_string(),
        })
    }

    /// Applies the assignments of `--set` to a recipe.
    pub fn apply_to(&self, recipe: &mut Recipe) -> Result<(), BakeError> {
        self.set.iter().try_for_each(|assignment| {
            let Some(named) = ImageAssignment::of(assignment).filter(ImageAssignment::is_absolute) else {
                return recipe.set(assignment);
            };
            let mut changed = recipe.clone();
            let known = |recipe: &Recipe| recipe.images().iter().any(|(_, name)| *name == named.name);
            if changed.set(&named.by_name()).is_err() || !known(&changed) {
                // The key does not require an image, so the assignment is applied directly.
                return recipe.set(assignment);
            }
            if known(recipe) {
                let reason =
                    format!("the recipe already names another image {:?}; expected a different file name", named.name);
                return Err(BakeError::Input { file: "--set".into(), place: named.key.into(), reason });
            }
            *recipe = changed;
            Ok(())
        })
    }
}

/// Parts of an assignment that may name an image: `--set key=PATH#channel`.
struct ImageAssignment<'a> {
    key: &'a str,
    path: &'a Path,
    channel: &'a str,
    /// Name in the recipe. An absolute path is reduced to its file name, so that the package does not depend on this
    /// machine.
    name: &'a str,
}

impl<'a> ImageAssignment<'a> {
    fn of(assignment: &'a str) -> Option<Self> {
        let (key, word) = assignment.split_once('=')?;
        let (key, word) = (key.trim(), word.trim());
        let (path, channel) = word.split_at(word.rfind('#').unwrap_or(word.len()));
        let named = Path::new(path);
        let name = if named.is_absolute() { named.file_name()?.to_str()? } else { path };
        (!name.is_empty()).then_some(Self { key, path: named, channel, name })
    }

    fn is_absolute(&self) -> bool {
        self.path.is_absolute()
    }

    /// Returns the assignment with [`Self::name`] instead of the path.
    fn by_name(&self) -> String {
        format!("{}={}{}", self.key, self.name, self.channel)
    }
}

/// A finished bake.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct BakeResult<'a> {
    output: String,
    bytes: usize,
    seconds: f64,
    stages: &'a [StageTime],
    warnings: &'a [String],
    decisions: &'a [Decision],
    /// Recipe written by `--write-recipe`; null without that option.
    recipe: Option<String>,
    #[serde(flatten)]
    measures: &'a Measures,
    model: &'a Anatomy,
    /// Settings chosen for the limits, as in the package's manifest; null without limits.
    choice: Option<&'a Choice>,
    /// Figures of each trial in `choice` that the package does not store; null without limits.
    judged: Option<&'a [TrialFigures]>,
}

/// Runs the subcommand.
pub fn run(args: &BakeArgs, output: &mut Output) -> Result<Exit, Failure> {
    let start = Instant::now();
    require_parent(&args.output)?;
    if let Some(path) = &args.write_recipe {
        require_parent(path)?;
    }
    let pool = threads::pool(args.threads)?;
    let limits = args.limits.limits();
    if args.limits.exhaustive && limits.is_empty() {
        return Err(Failure::Usage("--exhaustive needs a limit: --max-error, --max-frame-ms or --max-bytes".into()));
    }
    let done = pool.install(|| bake_file(args, &limits, output))?;
    let recipe = args.write_recipe.as_deref().zip(done.recipe.as_ref().map(String::as_bytes));
    let files: Vec<(&Path, &[u8])> = [(&*args.output, &*done.baked.package)].into_iter().chain(recipe).collect();
    io::write_all_atomic(&files)?;
    report(output, args, &done, start.elapsed().as_secs_f64())?;
    Ok(Exit::Done)
}

/// Finished bake, and what the command reports about it.
struct FinishedBake {
    baked: Baked,
    stages: Vec<StageTime>,
    /// Choice made for the limits: evidence for the manifest, figures for scripts, and text for people.
    choice: Option<(Choice, Vec<TrialFigures>, String)>,
    /// Whether the note about a large package was already printed before the bake.
    told_size: bool,
    /// Text of the recipe for `--write-recipe`.
    recipe: Option<String>,
}

fn bake_file(args: &BakeArgs, limits: &Limits, output: &mut Output) -> Result<FinishedBake, Failure> {
    let (mut recipe, recipe_input) = args.recipe.read()?;
    let mut watch = StageWatch::new(output);
    watch.begin("import");
    let images = args.recipe.images(&recipe)?;
    if let Some(path) = &args.write_recipe {
        write_recipe::require_files(path, &recipe, &images)?;
    }
    let mut model =
        io::read_model(&args.model, &ImportOptions { unit_m: recipe.model.unit_m }, args.recipe.file_access())?;
    large_model(&model.mesh).iter().for_each(|note| watch.output.note(note));
    let inputs = model.inputs.clone();
    model.inputs.extend(recipe_input);
    let file = args.model.display().to_string();
    let name = args.model.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let asked = recipe.clone();
    let placed = |error| args.recipe.with_source(&file, error);
    // Tile parameters that were chosen before the bake.
    let mut tile = TileRecipe::default();
    let mut choice: Option<(Choice, Vec<TrialFigures>, String)> = None;
    if !limits.is_empty() {
        watch.begin("choose");
        // The trials vary the texels of the tile but not its size, so it is computed once.
        tile = metric::to_tile_units(&recipe, &groom::bounds(&RestPose::of(&model.mesh, model.animation.as_ref())))
            .map_err(placed)?;
        let recipe_of_tile = tile.recipe.clone();
        let chosen = {
            let slicer = Slicer::new(BakeInput::new(&file, &name, &recipe_of_tile, &images), &model).map_err(placed)?;
            let baker: Baker<'_> =
                Box::new(|recipe| Ok(NamedPackage { name: name.clone(), bytes: slicer.slice(recipe)?.into() }));
            choose(&file, baker, &recipe_of_tile, limits, args.limits.exhaustive, watch.output())?
        };
        recipe = chosen.recipe;
        choice = Some((chosen.choice, chosen.judged, chosen.text));
    }
    if !args.pictures.is_empty() {
        watch.begin("choose");
        tile =
            args.pictures.fit(BakeInput::new(&file, &name, &recipe, &images), &model).map_err(
                |failure| match failure {
                    Failure::Bake(error) => Failure::Bake(placed(error)),
                    other => other,
                },
            )?;
        recipe = tile.recipe.clone();
        watch.output.note(&args.pictures.description(&recipe.slice));
    }
    let steps = watch.steps();
    let told = BakeInput { progress: &steps, ..BakeInput::new(&file, &name, &recipe, &images) };
    let large = large_layers(&recipe);
    large.iter().for_each(|note| watch.output.note(note));
    let mut baked = pipeline::bake(&told, &model, &mut |event| watch.on_event(event)).map_err(placed)?;
    baked.decisions.extend(tile.decisions);
    baked.warnings.extend(tile.warnings);
    let written = args.write_recipe.as_ref().map(|path| {
        let options = write_recipe::options(limits, &args.pictures);
        let chosen = RecipeChoices { model: &name, asked: &asked, recipe: &recipe, options: &options };
        chosen.put_into(&mut baked, path, inputs, &images)
    });
    let written = written.transpose()?;
    if let Some((choice, ..)) = choice.as_ref().filter(|_| written.is_none()) {
        baked.package = pack::with_choice(&baked.package, choice.clone())?;
    }
    let bytes = baked.package.len() as u64;
    if let Some(limit) = limits.max_bytes.filter(|limit| bytes > *limit) {
        let text =
            format!("the package takes {bytes} bytes with the record of the bake, more than --max-bytes {limit}");
        return Err(BakeError::Internal(text).into());
    }
    Ok(FinishedBake { baked, stages: watch.finish(), choice, told_size: large.is_some(), recipe: written })
}

/// Number of triangles above which a model is reported as large.
const LARGE_MODEL: usize = 1_000_000;
/// Time of the surface stage per triangle of a large model, seconds (`runtime/docs/performance.md`, "Baking").
const SURFACE_S: f64 = 26e-6;

/// Returns a note to print before the surface stage of a large model: its triangles, copies among them, and the
/// expected time of the stage.
fn large_model(mesh: &Mesh) -> Option<String> {
    let triangles = mesh.triangles.len();
    if triangles <= LARGE_MODEL {
        return None;
    }
    let mut sources: BTreeMap<&str, (usize, usize)> = BTreeMap::new();
    for part in &mesh.parts {
        let (copies, of_copies) = sources.entry(&part.source).or_default();
        (*copies, *of_copies) = (*copies + 1, *of_copies + part.triangle_count);
    }
    let copied =
        sources.into_iter().filter(|(_, (copies, _))| *copies > 1).max_by_key(|(_, (_, of_copies))| *of_copies);
    let copied = copied.map_or_else(String::new, |(source, (copies, of_copies))| {
        format!(", {of_copies} of them in {copies} copies of {source}, each of which grows hair of its own")
    });
    let expected = span(triangles as f64 * SURFACE_S);
    Some(format!("note: the model has {triangles} triangles{copied}; the surface stage will take about {expected}"))
}

/// Size above which a package is reported as large, bytes. A large package loads slowly, especially on web pages.
const LARGE: u64 = 32 << 20;

/// Returns a note to print before the bake if the layers alone make the package large.
fn large_layers(recipe: &Recipe) -> Option<String> {
    let SliceParams { layers, tile_texels: n, .. } = recipe.slice;
    let bytes = shell_bytes(&recipe.slice, &recipe.pack, has_far_layer(recipe), recipe.visibility.enabled);
    (bytes > LARGE).then(|| {
        format!(
            "note: {layers} layers of {n} x {n} texels will take {} of the package and a long time to bake; \
             slice.layers and slice.tile_texels set the size",
            human_bytes(bytes)
        )
    })
}

/// Returns a note about the largest section if the package is large.
fn large_package(package: &Package<'_>) -> Result<Option<String>, FormatError> {
    let all = package.bytes().len() as u64;
    if all <= LARGE {
        return Ok(None);
    }
    let mut parts = vec![("mesh".to_owned(), package.mesh()?.map_or(0, |mesh| mesh.bytes()))];
    for (index, entry) in package.manifest().textures.iter().enumerate() {
        parts.push((format!("texture {:?}", entry.name), package.texture(index as u32)?.gpu_bytes()));
    }
    let largest = parts.into_iter().max_by_key(|(_, bytes)| *bytes).unwrap_or_default();
    Ok(Some(format!(
        "note: the package takes {}; its largest part, the {}, takes {}",
        human_bytes(all),
        largest.0,
        human_bytes(largest.1)
    )))
}

/// Measures the durations of stages, and shows those that are running.
#[derive(Debug)]
pub struct StageWatch<'a> {
    output: &'a mut Output,
    times: StageTimes,
}

impl<'a> StageWatch<'a> {
    /// Creates the timer before the first stage.
    pub fn new(output: &'a mut Output) -> Self {
        Self { output, times: StageTimes::default() }
    }

    /// Returns the step counter that stages increment for the progress display.
    pub fn steps(&self) -> Arc<StageProgress> {
        self.output.steps()
    }

    /// Returns the output, for a stage that shows its own progress.
    pub fn output(&mut self) -> &mut Output {
        self.output
    }

    /// Begins a stage before the bake itself.
    pub fn begin(&mut self, stage: &'static str) {
        self.times.begin(stage);
        self.output.progress(stage);
    }

    /// Records an event of a bake.
    pub fn on_event(&mut self, event: StepEvent) {
        let before = self.times.running();
        self.times.on_event(event);
        let running = self.times.running();
        if running != before && !running.is_empty() {
            self.output.progress(&running.join(", "));
        }
    }

    /// Returns the times of all stages.
    pub fn finish(self) -> Vec<StageTime> {
        self.times.finish()
    }
}

fn report(output: &mut Output, args: &BakeArgs, done: &FinishedBake, seconds: f64) -> Result<(), Failure> {
    let FinishedBake { baked, stages, choice, told_size, .. } = done;
    let path = &args.output;
    for warning in &baked.warnings {
        output.note(&format!("warning: {warning}"));
    }
    let fault = |fault| BakeError::Internal(format!("cannot read back the baked package: {fault}"));
    let package = Package::open(&baked.package, &FormatLimits::default()).map_err(fault)?;
    let anatomy = Anatomy::of(&package).map_err(fault)?;
    if !told_size {
        large_package(&package).map_err(fault)?.iter().for_each(|note| output.note(note));
    }
    let result = BakeResult {
        output: path.display().to_string(),
        bytes: baked.package.len(),
        seconds,
        stages,
        warnings: &baked.warnings,
        decisions: &baked.decisions,
        recipe: args.write_recipe.as_ref().map(|path| path.display().to_string()),
        measures: &baked.measures,
        model: &anatomy,
        choice: choice.as_ref().map(|(choice, ..)| choice),
        judged: choice.as_ref().map(|(_, judged, _)| judged.as_slice()),
    };
    let size = human_bytes(baked.package.len() as u64);
    let mut text = format!("{}: {size} in {seconds:.2} s", path.display());
    let mut said = |key: &str, value: String| text += &format!("\n{key:<14} {value}");
    anatomy.rows(&mut said);
    for decision in &baked.decisions {
        said("chosen", format!("{}: {}  ({})", decision.what, decision.chosen, decision.line));
    }
    if let Some(path) = &args.write_recipe {
        said("recipe", path.display().to_string());
    }
    if let Some((.., why)) = choice {
        text += &format!("\n{why}");
    }
    output.result(&text, &result)
}

#[cfg(test)]
mod tests {
    use super::*;
    use pelage_import::mesh::MeshPart;

    #[test]
    fn large_models_are_announced_with_copies_and_time() {
        let mesh = |sources: &[&str], each: usize| {
            let part =
                |source: &&str| MeshPart { source: (*source).into(), triangle_count: each, ..MeshPart::default() };
            let triangles = vec![[0; 3]; each * sources.len()];
            Mesh { triangles, parts: sources.iter().map(part).collect(), ..Mesh::default() }
        };
        assert_eq!(large_model(&mesh(&["mesh 0"; 4], 250_000)), None);
        let (ground, pot) = ("mesh 0, primitive 0", "mesh 1 \"Pot\", primitive 0");
        assert_eq!(
            large_model(&mesh(&[ground, pot, pot, pot], 1_000_000)).as_deref(),
            Some(
                "note: the model has 4000000 triangles, 3000000 of them in 3 copies of mesh 1 \"Pot\", primitive 0, \
                 each of which grows hair of its own; the surface stage will take about 104 s"
            )
        );
        assert!(large_model(&mesh(&[ground], 1_000_001)).is_some_and(|note| note.ends_with("about 26 s")));
    }
}
