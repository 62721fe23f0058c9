//! Herd on disk: its file, models, history and output paths.

use super::args::HerdFiles;
use super::paths::{absolute, io_error, relative_to, utf8};
use super::{models, saved_state};
use crate::bake::RecipeArgs;
use crate::exit::Failure;
use crate::output::{Output, make_folder};
use crate::reference::only_drawn;
use pelage_bake::{io, temp_files};
use pelage_herd::{ArgumentValidators, HerdFile, History, Kind, NAME, Plan, PlanInput, Task, ninja, plan};
use pelage_stage::TomlText;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Function that returns the error message if the tool rejects a command line.
pub type Refusal<'a> = dyn Fn(&[String]) -> Option<String> + 'a;

/// Herd as found on disk.
pub struct Herd {
    /// Absolute path of the herd file's folder, in which commands run.
    pub folder: PathBuf,
    /// Title of the HTML report.
    pub title: String,
    /// Planned commands.
    pub plan: Plan,
    /// Measured cost of earlier runs, by task name.
    pub history: History,
    /// Cache folder, relative to `folder`.
    pub cache: Option<String>,
    /// Absolute path of the `pelage` program.
    pub tool: String,
    /// Warnings about files that cannot be read, and about unused entries of the herd file.
    pub idle: Vec<String>,
}

impl Herd {
    /// Reads a herd file, finds its models and computes the plan.
    pub fn read(files: &HerdFiles, cache: Option<&Path>, refusal: &Refusal<'_>) -> Result<Self, Failure> {
        let name = files.herd.display().to_string();
        let text = io::read_text(&files.herd, "a herd in TOML")?;
        let only_drawn = only_drawn();
        let judge = ArgumentValidators { only_drawn: &only_drawn, refusal, recipe: &RecipeArgs::refusal };
        let source = TomlText::new(&name, &text);
        let file = HerdFile::read(source, &judge)?;
        let parent = files.herd.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let folder = absolute(parent)?;
        let out = relative_to(&folder, &absolute(&files.output)?)?;
        let cache = cache.map(|cache| relative_to(&folder, &absolute(cache)?)).transpose()?;
        let (models, left_out) = models::find(source, &file, &folder, &out)?;
        check_files(source, &file, &folder)?;
        let history = history(&folder, &out);
        let is_file = |path: &str| folder.join(path).is_file();
        let plan = plan(&PlanInput {
            source,
            file: &file,
            models: &models,
            out: &out,
            only_drawn: &only_drawn,
            history: &history,
            is_file: &is_file,
        })?;
        let idle = left_out.into_iter().chain(file.unused_entries(source, &models, &is_file)).collect();
        let title = file.title.clone().unwrap_or(name);
        let tool = std::env::current_exe().map_err(|source| io_error(Path::new("pelage"), "find", source))?;
        let tool = utf8(&tool)?.to_owned();
        Ok(Self { folder, title, plan, history, cache, tool, idle })
    }

    /// Converts a path of the plan to a path on disk.
    pub fn path(&self, path: &str) -> PathBuf {
        self.folder.join(path)
    }

    /// Returns the herd's internal folder, relative to the herd file's folder.
    pub fn internal_folder(&self) -> String {
        Plan::own_folder(&self.plan.out)
    }

    /// Creates the folders for the outputs of commands, and removes temporary files from folders that already exist.
    pub fn make_folders(&self) -> Result<(), Failure> {
        let files = self.plan.tasks.iter().flat_map(|task| {
            task.outputs.iter().chain([&task.record]).chain(&task.depfile).filter_map(|file| Path::new(file).parent())
        });
        let folders: BTreeSet<&Path> = files.collect();
        for folder in folders {
            let folder = self.folder.join(folder);
            if folder.is_dir() {
                temp_files::remove_abandoned(&folder);
            } else {
                make_folder(&folder)?;
            }
        }
        Ok(())
    }

    /// Prints [`Self::idle`].
    pub fn say_idle(&self, output: &Output) {
        self.idle.iter().for_each(|idle| output.note(&format!("note: {idle}")));
    }

    /// Returns the benchmark tasks whose packages exist. A package is missing if its bake failed.
    pub fn timed(&self) -> Vec<&Task> {
        let there =
            |task: &&Task| task.kind == Kind::Bench && task.inputs.iter().all(|input| self.path(input).is_file());
        self.plan.tasks.iter().filter(there).collect()
    }

    /// Writes the build file that runs the benchmarks one by one; returns its name.
    pub fn write_timed(&self, timed: &[&Task], memory_bytes: u64) -> Result<String, Failure> {
        let own = format!("{}/timed", self.internal_folder());
        let name = format!("{own}/build.ninja");
        make_folder(&self.path(&own))?;
        self.write_build(&name, &own, timed, ninja::ConcurrencyLimits::of(timed, 1, memory_bytes))?;
        Ok(name)
    }

    /// Writes the build file of the tasks that may run concurrently on this machine. Returns its path, relative to the
    /// herd file's folder, and its concurrency limits.
    pub fn write_ninja(&self, jobs: u32, memory_bytes: u64) -> Result<(String, ninja::ConcurrencyLimits), Failure> {
        let tasks = ninja::untimed(&self.plan);
        let room = ninja::ConcurrencyLimits::of(&tasks, jobs, memory_bytes);
        let name = format!("{}/build.ninja", self.plan.out);
        self.write_build(&name, &self.internal_folder(), &tasks, room)?;
        Ok((name, room))
    }

    /// Writes a build file for some tasks; `own` is the folder of Ninja's log.
    pub fn write_build(
        &self,
        name: &str,
        own: &str,
        tasks: &[&Task],
        room: ninja::ConcurrencyLimits,
    ) -> Result<(), Failure> {
        let settings = ninja::Settings { tool: &self.tool, cache: self.cache.as_deref(), own, room };
        io::write_atomic(&self.path(name), ninja::build_file(tasks, &settings).as_bytes())?;
        Ok(())
    }
}

/// Checks before anything runs that recipe and look files exist: an engine could not report which entry of the herd
/// file names the missing file.
fn check_files(source: TomlText<'_>, file: &HerdFile, folder: &Path) -> Result<(), Failure> {
    let recipes = file.recipe_files().filter(|(_, path, _)| !path.contains(NAME)).map(|(key, path, _)| (key, path));
    let looks = file.views.iter().enumerate();
    let looks = looks.filter_map(|(i, view)| Some((format!("view[{i}].look"), view.look.as_ref()?)));
    match recipes.chain(looks).find(|(_, path)| !folder.join(path).is_file()) {
        Some((key, path)) => {
            let reason = format!("{path:?} is not a file, expected one relative to the folder of {}", source.name);
            Err(HerdFile::fault(source, &key, reason).into())
        }
        None => Ok(()),
    }
}

/// Returns the file for the measured cost of commands, in the herd's internal folder.
pub fn history_file(own: &str) -> String {
    format!("{own}/history.json")
}

/// Reads the measured cost of earlier runs; empty before the first run.
fn history(folder: &Path, out: &str) -> History {
    saved_state::read(&folder.join(history_file(&Plan::own_folder(out))))
}
