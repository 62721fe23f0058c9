//! Ninja, as a process.

use super::finish::Ran;
use super::on_disk::Herd;
use super::paths::io_error;
use crate::cli::exit::Failure;
use crate::cli::output::{Output, human_bytes, make_folder};
use pelage_bake::BakeError;
use pelage_bake::herd::ninja::{Room, THREADS};
use pelage_bake::herd::{Kind, Task};
use std::io::{self, BufRead as _, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};

/// What has to be installed.
const HELP: &str =
    "it is not installed: apt-get install ninja-build, dnf install ninja-build, pacman -S ninja, brew install ninja";

/// Runs what is not done on this machine: everything but what is timed at once, and that one after another.
pub fn run(herd: &Herd, jobs: u32, memory_bytes: u64, output: &mut Output) -> Result<Ran, Failure> {
    let (file, room) = herd.write_ninja(jobs, memory_bytes)?;
    if room.too_large > 0 {
        let (needs, has) = (human_bytes(room.too_large), human_bytes(memory_bytes));
        output.note(&format!("note: a command is expected to need {needs}, and there are {has} for all"));
    }
    let mut ran = ninja(herd, &file, jobs, output)?;
    // What could not be baked cannot be timed, and what is tried once fails once.
    let there = |task: &&Task| task.kind == Kind::Bench && task.inputs.iter().all(|input| herd.path(input).is_file());
    let timed: Vec<&Task> = herd.plan.tasks.iter().filter(there).collect();
    if !timed.is_empty() {
        let own = format!("{}/timed", herd.own());
        let file = format!("{own}/build.ninja");
        make_folder(&herd.path(&own))?;
        herd.write_build(&file, &own, &timed, Room::of(&timed, 1, memory_bytes))?;
        ran.commands += ninja(herd, &file, 1, output)?.commands;
    }
    Ok(ran)
}

/// A command of Ninja in the herd's folder.
pub fn command(herd: &Herd, file: &str) -> Command {
    let mut command = Command::new("ninja");
    command.current_dir(&herd.folder).args(["-f", file]);
    for threads in THREADS {
        if std::env::var_os(threads).is_none() {
            command.env(threads, "1");
        }
    }
    command
}

/// An error of a process that cannot be run.
pub fn cannot_run(source: io::Error) -> Failure {
    let source = if source.kind() == io::ErrorKind::NotFound { io::Error::new(source.kind(), HELP) } else { source };
    io_error(Path::new("ninja"), "run", source)
}

fn ninja(herd: &Herd, file: &str, jobs: u32, output: &mut Output) -> Result<Ran, Failure> {
    let mut command = command(herd, file);
    // It goes on after failures, and says how many commands are over of how many.
    command.args(["-k", "0", "-j", &jobs.to_string()]).env("NINJA_STATUS", "[%f/%t] ");
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().map_err(cannot_run)?;
    let errors = child.stderr.take();
    let errors = std::thread::spawn(move || errors.and_then(|errors| io::read_to_string(errors).ok()));
    let (mut ran, mut faults) = (Ran::default(), Vec::new());
    for line in BufReader::new(child.stdout.take().ok_or_else(|| BakeError::Internal("ninja without stdout".into()))?)
        .split(b'\n')
    {
        let line = line.map_err(|source| io_error(Path::new("ninja"), "read from", source))?;
        let line = String::from_utf8_lossy(&line);
        if let Some((done, total, task)) = status(&line) {
            ran.commands = ran.commands.max(done);
            output.progress_of(done, total, task);
        } else if line.starts_with("ninja: error:") || line.starts_with("ninja: fatal:") {
            faults.push(line.into_owned());
        }
    }
    let status = child.wait().map_err(|source| io_error(Path::new("ninja"), "run", source))?;
    let errors = errors.join().ok().flatten().unwrap_or_default();
    faults.extend(errors.lines().filter(|line| line.starts_with("ninja: ")).map(str::to_owned));
    // A command that failed is told by its own record; what stopped Ninja itself, nobody else tells.
    if status.code() != Some(0) && !faults.is_empty() {
        return Err(io_error(&herd.path(file), "run ninja on", io::Error::other(faults.join("; "))));
    }
    Ok(ran)
}

/// `[3/10] bake fox`: how many are over, of how many, and which.
fn status(line: &str) -> Option<(usize, usize, &str)> {
    let (count, task) = line.strip_prefix('[')?.split_once("] ")?;
    let (done, total) = count.split_once('/')?;
    Some((done.parse().ok()?, total.parse().ok()?, task))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_ninja_says_is_understood() {
        assert_eq!(status("[3/10] bake a] b"), Some((3, 10, "bake a] b")));
        assert!(["FAILED: a", "[x/2] a", "ninja: no work to do.", ""].iter().all(|line| status(line).is_none()));
    }
}
