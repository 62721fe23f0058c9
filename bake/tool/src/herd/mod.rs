//! `pelage herd`: processes many models with Ninja or Slurm.

mod args;
mod engine;
mod finish;
mod lock;
mod memory;
mod models;
mod ninja_output;
mod on_disk;
mod paths;
mod result;
mod saved_state;
mod slurm;

use super::exit::{Exit, Failure};
use super::output::{Output, make_folder};
use args::{Action, Engine, HerdFiles, PlanArgs, RunArgs};
use lock::RunLock;
use on_disk::{Herd, Refusal};
use pelage_herd::{Kind, Task, shell_line};
use result::{KindSummary, PlannedTask};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;

pub use args::HerdArgs;
pub use result::HerdResult;

/// Runs the subcommand.
///
/// * `cache`: cache folder for all commands
/// * `refusal`: returns the error message if the tool rejects a command line
pub fn run(args: &HerdArgs, cache: Option<&Path>, refusal: &Refusal<'_>, output: &mut Output) -> Result<Exit, Failure> {
    let read = |files: &HerdFiles| Herd::read(files, cache, refusal);
    match &args.action {
        Action::Plan(args) => say_plan(&read(&args.files)?, args, output),
        Action::Run(args) => run_all(args, read, output),
        Action::Report(files) => {
            output.progress("reading the results");
            let herd = read(files)?;
            // Only the cluster's logs contain the outcome of a detached submission.
            let ran = slurm::read_logs(&herd).failures_alone();
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

/// Returns the number and expected cost of the commands of each kind.
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
            return Err(Failure::Usage(format!(
                "{name}: it applies to --engine {engine} only, expected it to be left out"
            )));
        }
    }
    output.progress("planning");
    let herd = read(&args.files)?;
    herd.say_idle(output);
    let mut lock = RunLock::new(&herd)?;
    herd.make_folders()?;
    finish::forget_failures(&herd)?;
    let ran = if farm {
        let Some(ran) = slurm::run(&herd, args, output)? else { return Ok(Exit::Done) };
        ran
    } else {
        let memory_bytes = args.memory.map_or_else(memory::free_bytes, |mib| mib << 20);
        engine::run(&herd, &mut lock, args.jobs.unwrap_or_else(memory::cores), memory_bytes, output)?
    };
    finish::finish(&herd, &ran, output)
}
