//! Runs commands on Slurm, through its command-line programs.

use super::args::RunArgs;
use super::ninja_output::NinjaOutput;
use super::on_disk::Herd;
use super::paths::io_error;
use super::result::HerdResult;
use super::{engine, finish, saved_state};
use crate::exit::Failure;
use crate::output::{Output, make_folder};
use pelage_bake::io;
use pelage_herd::slurm::{Script, Shard, Stage, TIMED, demand, shards_by_task, stages};
use pelage_herd::{Task, ninja};
use pelage_import::BakeError;
use std::collections::BTreeSet;
use std::io::{Error, ErrorKind};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

/// Polling interval of the job queue.
const ASKED_EVERY: Duration = Duration::from_secs(2);
/// Size limit of an array job if Slurm does not report one.
const ARRAY: usize = 1000;

/// Submits the commands that are not up to date, and waits for them. With `--detach`, returns `None` without waiting.
pub fn run(herd: &Herd, args: &RunArgs, output: &mut Output) -> Result<Option<NinjaOutput>, Failure> {
    let files = format!("{}/slurm", herd.internal_folder());
    make_folder(&herd.path(&files))?;
    let shards_file = herd.path(&format!("{files}/shards.json"));
    let stages = stages(&herd.plan, args.shard_seconds, &saved_state::read(&shards_file));
    saved_state::write(&shards_file, &shards_by_task(&herd.plan, &stages))?;
    let open = open_shards(herd, &files, &stages, output)?;
    if open.iter().any(|open| !open.is_empty()) {
        finish::mark_report_outdated(herd)?;
    }
    let mut ids: Vec<String> = Vec::new();
    let (mut shards, mut logs) = (Vec::new(), Vec::new());
    let most = array_size();
    let mut before: Vec<String> = Vec::new();
    for (stage, open) in stages.iter().zip(&open) {
        if open.is_empty() {
            continue;
        }
        let script = Script {
            stage: stage.name,
            folder: &herd.folder.display().to_string(),
            files: &files,
            retries: args.retries,
            options: &args.sbatch,
            demand: demand(&herd.plan, stage),
            exclusive: stage.name == TIMED,
        };
        let name = format!("{files}/{}.sh", stage.name);
        io::write_atomic(&herd.path(&name), script.text().as_bytes())?;
        let mut jobs = Vec::new();
        for array in open.chunks(most) {
            let job = submit(herd, &name, stage.name, array, &before)?;
            logs.push(format!("{}-{job}_", stage.name));
            jobs.push(job);
        }
        shards.extend(open.iter().map(|shard| format!("{files}/{}-{}.done", stage.name, shard.number)));
        // Each stage waits until the jobs before it have ended. By then, its inputs exist, or could not be made.
        before.clone_from(&jobs);
        ids.extend(jobs);
    }
    saved_state::write(&logs_file(herd), &logs)?;
    if args.detach {
        let tasks: usize = open.iter().flatten().map(|shard| shard.tasks.len()).sum();
        let text = format!("submitted jobs: {}; shards: {}; job numbers: {}", ids.len(), shards.len(), ids.join(" "));
        output.result(&text, &HerdResult::Submitted { jobs_submitted: ids, shards: shards.len(), tasks })?;
        return Ok(None);
    }
    if !ids.is_empty() {
        output.note(&format!("submitted jobs {0}; `scancel {0}` ends them", ids.join(" ")));
    }
    wait(herd, &ids, &shards, output)?;
    Ok(Some(read_logs(herd)))
}

/// Returns the file with the name prefixes of the logs of the latest submission.
fn logs_file(herd: &Herd) -> PathBuf {
    herd.path(&format!("{}/slurm/logs.json", herd.internal_folder()))
}

/// Parses Ninja's output from the logs of the latest submission; skips logs that cannot be read.
pub fn read_logs(herd: &Herd) -> NinjaOutput {
    let logs: Vec<String> = saved_state::read(&logs_file(herd));
    let mut ran = NinjaOutput::default();
    for entry in
        std::fs::read_dir(herd.path(&format!("{}/slurm", herd.internal_folder()))).into_iter().flatten().flatten()
    {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        if logs.iter().any(|log| name.starts_with(log.as_str())) {
            ran.parse(&std::fs::read(entry.path()).unwrap_or_default());
        }
    }
    ran
}

/// Writes the build files of all shards. Returns the shards of each stage that are not up to date.
fn open_shards<'a>(
    herd: &Herd,
    files: &str,
    stages: &'a [Stage],
    output: &mut Output,
) -> Result<Vec<Vec<&'a Shard>>, Failure> {
    let all: usize = stages.iter().map(|stage| stage.shards.len()).sum();
    let mut looked = 0;
    let mut made: BTreeSet<&str> = BTreeSet::new();
    let mut open = Vec::new();
    for stage in stages {
        let mut of_stage = Vec::new();
        for shard in &stage.shards {
            output.progress_of(looked, all, "checking which shards are done");
            looked += 1;
            let name = format!("{files}/{}-{}", stage.name, shard.number);
            let own = format!("{name}.log");
            make_folder(&herd.path(&own))?;
            let tasks: Vec<&Task> = shard.tasks.iter().map(|i| &herd.plan.tasks[*i]).collect();
            // Each shard runs one command at a time, because Slurm allocates cores and memory.
            let room = ninja::ConcurrencyLimits::of(&tasks, 1, u64::MAX);
            herd.write_build(&format!("{name}.ninja"), &own, &tasks, room)?;
            let waits = tasks.iter().any(|task| task.inputs.iter().any(|input| made.contains(input.as_str())));
            if waits || !is_done(herd, &format!("{name}.ninja"))? {
                let _ = std::fs::remove_file(herd.path(&format!("{name}.done")));
                made.extend(tasks.iter().flat_map(|task| task.outputs.iter().map(String::as_str)));
                of_stage.push(shard);
            }
        }
        open.push(of_stage);
    }
    Ok(open)
}

/// Returns true if Ninja has nothing to do in a shard.
fn is_done(herd: &Herd, file: &str) -> Result<bool, Failure> {
    let said = engine::command(herd, file).arg("-n").output().map_err(engine::cannot_run)?;
    Ok(said.status.success() && String::from_utf8_lossy(&said.stdout).contains("no work to do"))
}

/// Submits an array job with one task for each of `shards`; returns the job number.
fn submit(herd: &Herd, script: &str, stage: &str, shards: &[&Shard], before: &[String]) -> Result<String, Failure> {
    let mut command = Command::new("sbatch");
    command.current_dir(&herd.folder).args(["--parsable", &format!("--array=0-{}", shards.len() - 1)]);
    command.arg(format!("--output={}/slurm/{stage}-%A_%a.log", herd.internal_folder()));
    if !before.is_empty() {
        command.arg(format!("--dependency=afterany:{}", before.join(":")));
    }
    let list = shards.iter().map(|shard| shard.number.to_string()).collect::<Vec<_>>().join(",");
    let said = answer(command.arg(script).arg(list))?;
    // On several clusters, Slurm prints the cluster's name after a semicolon.
    Ok(said.trim().split(';').next().unwrap_or_default().to_owned())
}

/// Runs a Slurm command and returns its output.
fn answer(command: &mut Command) -> Result<String, Failure> {
    let name = command.get_program().to_string_lossy().into_owned();
    let fail = |source| io_error(Path::new(&name), "run", source);
    let said = command.output().map_err(|source| match source.kind() {
        ErrorKind::NotFound => fail(Error::new(ErrorKind::NotFound, "not found, expected a machine with Slurm")),
        _ => fail(source),
    })?;
    if said.status.success() {
        Ok(String::from_utf8_lossy(&said.stdout).into_owned())
    } else {
        Err(fail(Error::other(String::from_utf8_lossy(&said.stderr).trim().to_owned())))
    }
}

/// Returns the size limit of array jobs on this cluster.
fn array_size() -> usize {
    let config = answer(Command::new("scontrol").args(["show", "config"])).unwrap_or_default();
    let line = config.lines().find_map(|line| line.trim().strip_prefix("MaxArraySize"));
    let most = line.and_then(|line| line.trim().strip_prefix('=')?.trim().parse::<usize>().ok());
    // Slurm's limit is exclusive: it applies to the task numbers, which begin at 0.
    most.map_or(ARRAY, |most| most.saturating_sub(1).max(1))
}

/// Waits until none of the jobs is in the queue.
fn wait(herd: &Herd, ids: &[String], shards: &[String], output: &mut Output) -> Result<(), Failure> {
    let mut failed = 0;
    while !ids.is_empty() {
        let done = shards.iter().filter(|shard| herd.path(shard).exists()).count();
        output.progress_of(done, shards.len(), "shards on the cluster");
        let queue = answer(Command::new("squeue").args(["--noheader", "--format=%i", "--jobs", &ids.join(",")]));
        match queue {
            Ok(queue) if queue.trim().is_empty() => break,
            Ok(_) => failed = 0,
            // Slurm forgets jobs that ended long ago.
            Err(Failure::Bake(BakeError::Io { source, .. })) if source.to_string().contains("Invalid job id") => break,
            // The Slurm controller may be temporarily unavailable.
            Err(error) => {
                failed += 1;
                if failed > 30 {
                    return Err(error);
                }
            }
        }
        std::thread::sleep(ASKED_EVERY);
    }
    Ok(())
}
