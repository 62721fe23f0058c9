//! Runs Ninja as a child process.

use super::finish;
use super::lock::RunLock;
use super::ninja_output::NinjaOutput;
use super::on_disk::Herd;
use super::paths::io_error;
use crate::exit::Failure;
use crate::output::{Output, human_bytes};
use pelage_herd::ninja::{STATUS, THREADS};
use pelage_import::BakeError;
use std::collections::BTreeSet;
use std::io::{self, BufRead as _, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};

/// Installation advice for Ninja.
const HELP: &str =
    "it is not installed: apt-get install ninja-build, dnf install ninja-build, pacman -S ninja, brew install ninja";

/// Runs the commands that are not up to date on this machine. Benchmarks run one by one at the end, all others
/// concurrently.
pub fn run(
    herd: &Herd,
    lock: &mut RunLock,
    jobs: u32,
    memory_bytes: u64,
    output: &mut Output,
) -> Result<NinjaOutput, Failure> {
    let (file, room) = herd.write_ninja(jobs, memory_bytes)?;
    if room.too_large > 0 {
        let (needs, has) = (human_bytes(room.too_large), human_bytes(memory_bytes));
        output.note(&format!(
            "note: one command is expected to need {needs}, but only {has} are available for all commands"
        ));
    }
    let mut ran = NinjaOutput::default();
    ninja(herd, lock, &file, jobs, &mut ran, output)?;
    // Only packages that exist are timed, so a failed bake is not repeated for its benchmark.
    let timed = herd.timed();
    if !timed.is_empty() {
        ninja(herd, lock, &herd.write_timed(&timed, memory_bytes)?, 1, &mut ran, output)?;
    }
    Ok(ran)
}

/// Returns the names of the commands that this machine would run now. Includes commands that depend on these, although
/// their inputs may come out unchanged.
pub fn due(herd: &Herd, file: &str) -> Result<BTreeSet<String>, Failure> {
    let mut named = dry_run(herd, file)?;
    let timed = herd.timed();
    if !timed.is_empty() {
        named.extend(dry_run(herd, &herd.write_timed(&timed, u64::MAX)?)?);
    }
    // Failed commands are retried, even if Ninja considers their files up to date.
    let failed: BTreeSet<String> = finish::failed_before(herd).into_iter().collect();
    let makers = herd.plan.makers();
    let mut due = BTreeSet::new();
    for task in &herd.plan.tasks {
        let is_made =
            |input: &String| makers.get(input.as_str()).is_some_and(|i| due.contains(&herd.plan.tasks[*i].name));
        if named.contains(&task.name) || failed.contains(&task.record) || task.inputs.iter().any(is_made) {
            due.insert(task.name.clone());
        }
    }
    Ok(due)
}

fn dry_run(herd: &Herd, file: &str) -> Result<BTreeSet<String>, Failure> {
    let said = command(herd, file).arg("-n").output().map_err(cannot_run)?;
    if !said.status.success() {
        let why = String::from_utf8_lossy(&said.stderr).trim().to_owned();
        return Err(io_error(&herd.path(file), "run ninja on", io::Error::other(why)));
    }
    Ok(NinjaOutput::of(&said.stdout).tasks)
}

/// Returns a Ninja command that runs in the herd's folder.
pub fn command(herd: &Herd, file: &str) -> Command {
    let mut command = Command::new("ninja");
    command.current_dir(&herd.folder).args(["-f", file]);
    // Ninja's output is parsed, so its format is fixed and has no colours.
    command.env("NINJA_STATUS", STATUS).env_remove("CLICOLOR_FORCE");
    for threads in THREADS {
        if std::env::var_os(threads).is_none() {
            command.env(threads, "1");
        }
    }
    command
}

/// Returns the error for a process that cannot be started.
pub fn cannot_run(source: io::Error) -> Failure {
    let source = if source.kind() == io::ErrorKind::NotFound { io::Error::new(source.kind(), HELP) } else { source };
    io_error(Path::new("ninja"), "run", source)
}

fn ninja(
    herd: &Herd,
    lock: &mut RunLock,
    file: &str,
    jobs: u32,
    ran: &mut NinjaOutput,
    output: &mut Output,
) -> Result<(), Failure> {
    let mut command = command(herd, file);
    // Ninja continues after failures.
    command.args(["-k", "0", "-j", &jobs.to_string()]);
    command.stdin(lock.to_stdin()?).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().map_err(cannot_run)?;
    lock.set_owner(child.id())?;
    let errors = child.stderr.take();
    let errors = std::thread::spawn(move || errors.and_then(|errors| io::read_to_string(errors).ok()));
    let mut faults = Vec::new();
    for line in
        BufReader::new(child.stdout.take().ok_or_else(|| BakeError::Internal("ninja has no standard output".into()))?)
            .split(b'\n')
    {
        let line = line.map_err(|source| io_error(Path::new("ninja"), "read from", source))?;
        let line = String::from_utf8_lossy(&line);
        let begins = ran.tasks.is_empty();
        if let Some((done, total, task)) = ran.parse_line(&line) {
            if begins {
                finish::mark_report_outdated(herd)?;
            }
            output.progress_of(done, total, task);
        } else if line.starts_with("ninja: error:") || line.starts_with("ninja: fatal:") {
            faults.push(line.into_owned());
        }
    }
    let status = child.wait().map_err(|source| io_error(Path::new("ninja"), "run", source))?;
    lock.set_owner(std::process::id())?;
    let errors = errors.join().ok().flatten().unwrap_or_default();
    faults.extend(errors.lines().filter(|line| line.starts_with("ninja: ")).map(str::to_owned));
    // Failed commands are reported by their own records. Only errors of Ninja itself are reported here.
    if status.code() != Some(0) && !faults.is_empty() {
        return Err(io_error(&herd.path(file), "run ninja on", io::Error::other(faults.join("; "))));
    }
    Ok(())
}
