//! `pelage herd`: thousands of models on engines that people already run.

mod args;
mod engine;
mod farm;
mod finish;
mod memory;
mod models;
mod notes;
mod on_disk;
mod paths;
mod ran;

use super::exit::{Exit, Failure};
use super::output::{Output, make_folder};
use args::{Action, Engine, HerdFiles, PlanArgs, RunArgs};
use on_disk::{Herd, Refusal};
use pelage_herd::{Kind, Row, Task, shell_line};
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;

pub use args::HerdArgs;

/// Commands of a herd (`plan`), their outcome (`run`, also of `pelage herd report`), or the jobs submitted to Slurm.
///
/// Exit code of `run`: that of the first command that failed; 7 if only comparisons exceeded their limit.
#[derive(Serialize, JsonSchema)]
#[serde(tag = "action", rename_all = "lowercase")]
pub enum HerdResult<'a> {
    /// Plan of a herd.
    Plan {
        /// Absolute path of the folder that commands run in.
        folder: String,
        /// Build file of Ninja, relative to that folder.
        ninja: String,
        /// Models, each in each of its variants.
        rows: &'a [Row],
        /// Commands, with the files that each reads and writes.
        tasks: Vec<PlannedTask<'a>>,
        /// Number and expected needs of the commands of each kind.
        kinds: Vec<KindSummary>,
        /// Commands run at once on this machine.
        jobs: u32,
        /// Commands run at once that need much memory.
        heavy_jobs: u32,
    },
    /// Outcome of a run.
    Run {
        /// Path of the report.
        report: String,
        /// Number of rows.
        models: usize,
        /// Commands that were run.
        ran: usize,
        /// Commands among them that were cache hits.
        cached: usize,
        tasks: HerdTasks,
        /// Commands that failed, then comparisons that exceeded their limit.
        failures: Vec<HerdFailure>,
    },
    /// Jobs submitted to Slurm.
    Submitted {
        /// Job numbers.
        jobs_submitted: Vec<String>,
        /// Number of array tasks.
        shards: usize,
        /// Number of commands.
        tasks: usize,
    },
}

/// A command of a plan.
#[derive(Serialize, JsonSchema)]
pub struct PlannedTask<'a> {
    #[serde(flatten)]
    task: &'a Task,
    /// Command line.
    command: Vec<String>,
}

/// Number and expected needs of the commands of a kind.
#[derive(Serialize, JsonSchema)]
pub struct KindSummary {
    kind: Kind,
    /// Number of commands.
    tasks: usize,
    /// Total time.
    seconds: f64,
    /// Peak memory of the largest command.
    peak_bytes: u64,
}

/// Number of commands in each state.
#[derive(Clone, Copy, Debug, Default, Serialize, JsonSchema)]
pub struct HerdTasks {
    all: usize,
    done: usize,
    failed: usize,
    /// Comparisons that exceeded their limit.
    differ: usize,
    /// Commands that could not run.
    missing: usize,
}

/// A command that failed, or a comparison that exceeded its limit.
#[derive(Serialize, JsonSchema)]
pub struct HerdFailure {
    /// Name of the command.
    task: String,
    exit_code: u8,
    message: String,
}

/// Runs the subcommand.
///
/// * `cache`: the one that was given for all commands
/// * `refusal`: why the tool refuses a command line
pub fn run(args: &HerdArgs, cache: Option<&Path>, refusal: &Refusal<'_>, output: &mut Output) -> Result<Exit, Failure> {
    let read = |files: &HerdFiles| Herd::read(files, cache, refusal);
    match &args.action {
        Action::Plan(args) => say_plan(&read(&args.files)?, args, output),
        Action::Run(args) => run_all(args, read, output),
        Action::Report(files) => {
            output.progress("reading what became of it");
            let herd = read(files)?;
            // What was submitted and left alone has told the farm's logs alone how it ended.
            let ran = farm::ran(&herd).failures_alone();
            finish::finish(&herd, &ran, output)
        }
    }
}

fn say_plan(herd: &Herd, args: &PlanArgs, output: &mut Output) -> Result<Exit, Failure> {
    herd.say_idle(output);
    make_folder(&herd.path(&herd.plan.out))?;
    let (name, room) = herd.write_ninja(memory::cores(), memory::free_bytes())?;
    let cache = herd.cache.as_deref();
    let due = if args.due { Some(engine::due(herd, &name)?) } else { None };
    let tasks = herd.plan.tasks.iter().filter(|task| due.as_ref().is_none_or(|due| due.contains(&task.name)));
    let tasks: Vec<&Task> = tasks.collect();
    if !output.is_json() {
        let lines: Vec<String> = tasks.iter().map(|task| shell_line(&task.command(cache))).collect();
        output.result(&lines.join("\n"), &Value::Null)?;
        return Ok(Exit::Done);
    }
    let kinds = kinds(&tasks);
    let result = HerdResult::Plan {
        folder: herd.folder.display().to_string(),
        ninja: name,
        rows: &herd.plan.rows,
        tasks: tasks.into_iter().map(|task| PlannedTask { task, command: task.command(cache) }).collect(),
        kinds,
        jobs: room.jobs,
        heavy_jobs: room.heavy,
    };
    output.result("", &result)?;
    Ok(Exit::Done)
}

/// Sums up the commands of each kind.
fn kinds(tasks: &[&Task]) -> Vec<KindSummary> {
    let mut kinds: BTreeMap<Kind, KindSummary> = BTreeMap::new();
    for task in tasks {
        let new = || KindSummary { kind: task.kind, tasks: 0, seconds: 0.0, peak_bytes: 0 };
        let sum = kinds.entry(task.kind).or_insert_with(new);
        sum.tasks += 1;
        sum.seconds += task.expected.seconds;
        sum.peak_bytes = sum.peak_bytes.max(task.expected.peak_bytes);
    }
    kinds.into_values().collect()
}

fn run_all(
    args: &RunArgs,
    read: impl Fn(&HerdFiles) -> Result<Herd, Failure>,
    output: &mut Output,
) -> Result<Exit, Failure> {
    let farm = args.engine == Engine::Slurm;
    for (name, given, slurm) in [
        ("--jobs", args.jobs.is_some(), false),
        ("--memory", args.memory.is_some(), false),
        ("--sbatch", !args.sbatch.is_empty(), true),
        ("--detach", args.detach, true),
    ] {
        if given && slurm != farm {
            let engine = if slurm { "slurm" } else { "ninja" };
            return Err(Failure::Usage(format!("{name}: it is for --engine {engine}, expected it to be left out")));
        }
    }
    output.progress("planning");
    let herd = read(&args.files)?;
    herd.say_idle(output);
    herd.make_folders()?;
    finish::forget_failures(&herd)?;
    let ran = if farm {
        let Some(ran) = farm::run(&herd, args, output)? else { return Ok(Exit::Done) };
        ran
    } else {
        let memory_bytes = args.memory.map_or_else(memory::free_bytes, |mib| mib << 20);
        engine::run(&herd, args.jobs.unwrap_or_else(memory::cores), memory_bytes, output)?
    };
    finish::finish(&herd, &ran, output)
}
