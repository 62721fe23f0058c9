//! Ninja, as a process.

use super::finish::Ran;
use super::on_disk::Herd;
use super::paths::io_error;
use crate::cli::exit::Failure;
use crate::cli::output::{Output, human_bytes};
use pelage_bake::BakeError;
use pelage_bake::herd::Kind;
use pelage_bake::herd::ninja::THREADS;
use std::collections::BTreeSet;
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
    let mut ran = Ran::default();
    ninja(herd, &file, jobs, &mut ran, output)?;
    // What is tried once fails once.
    let timed = herd.timed();
    if !timed.is_empty() {
        ninja(herd, &herd.write_timed(&timed, memory_bytes)?, 1, &mut ran, output)?;
    }
    Ok(ran)
}

/// The names of commands that would run now. Those that hang on one of them are among them: whether it comes out the same, nobody knows before.
pub fn due(herd: &Herd, file: &str) -> Result<BTreeSet<String>, Failure> {
    let mut due = dry_run(herd, file)?;
    let timed = herd.timed();
    if !timed.is_empty() {
        due.extend(dry_run(herd, &herd.write_timed(&timed, u64::MAX)?)?);
    }
    let makers = herd.plan.makers();
    for task in herd.plan.tasks.iter().filter(|task| task.kind == Kind::Bench) {
        let made = |input: &String| makers.get(input.as_str()).is_some_and(|i| due.contains(&herd.plan.tasks[*i].name));
        if task.inputs.iter().any(made) {
            due.insert(task.name.clone());
        }
    }
    Ok(due)
}

fn dry_run(herd: &Herd, file: &str) -> Result<BTreeSet<String>, Failure> {
    let said = command(herd, file).arg("-n").env("NINJA_STATUS", STATUS).output().map_err(cannot_run)?;
    if !said.status.success() {
        let why = String::from_utf8_lossy(&said.stderr).trim().to_owned();
        return Err(io_error(&herd.path(file), "run ninja on", io::Error::other(why)));
    }
    let text = String::from_utf8_lossy(&said.stdout);
    Ok(text.lines().filter_map(status).map(|(.., task)| task.to_owned()).collect())
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

/// How Ninja begins a line about a command: how many are over of how many.
const STATUS: &str = "[%f/%t] ";

fn ninja(herd: &Herd, file: &str, jobs: u32, ran: &mut Ran, output: &mut Output) -> Result<(), Failure> {
    let mut command = command(herd, file);
    // It goes on after failures.
    command.args(["-k", "0", "-j", &jobs.to_string()]).env("NINJA_STATUS", STATUS);
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().map_err(cannot_run)?;
    let errors = child.stderr.take();
    let errors = std::thread::spawn(move || errors.and_then(|errors| io::read_to_string(errors).ok()));
    let mut faults = Vec::new();
    for line in BufReader::new(child.stdout.take().ok_or_else(|| BakeError::Internal("ninja without stdout".into()))?)
        .split(b'\n')
    {
        let line = line.map_err(|source| io_error(Path::new("ninja"), "read from", source))?;
        let line = String::from_utf8_lossy(&line);
        ran.failed.hear(&line);
        if let Some((done, total, task)) = status(&line) {
            ran.tasks.insert(task.to_owned());
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
    Ok(())
}

/// What Ninja says of commands that failed.
#[derive(Clone, Debug, Default)]
pub struct Failed {
    /// The files that each would have made, and the last lines that it wrote.
    all: Vec<(String, Vec<String>)>,
    /// Whether the last of them is being heard.
    open: bool,
}

impl Failed {
    /// Last lines that are kept of each.
    const LINES: usize = 3;

    /// Hears a line of Ninja's. It names the files of a command that failed, then the command, and then what that wrote.
    pub fn hear(&mut self, line: &str) {
        if let Some(files) = line.strip_prefix("FAILED: ") {
            self.all.push((files.to_owned(), Vec::new()));
            self.open = true;
        } else if status(line).is_some() || line.starts_with("ninja: ") {
            self.open = false;
        } else if let Some((_, lines)) = self.all.last_mut().filter(|_| self.open && !line.trim().is_empty()) {
            // The command itself stays, that no more than the rest goes.
            if lines.len() > Self::LINES {
                lines.remove(1);
            }
            lines.push(line.trim().to_owned());
        }
    }

    /// The last words of the command that would have made that file, where it failed: empty where it had none.
    pub fn last_words(&self, file: &str) -> Option<String> {
        let (_, lines) = self.all.iter().rev().find(|(files, _)| files.contains(file))?;
        Some(lines.get(1..).unwrap_or_default().join("; "))
    }
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
    fn what_failed_is_heard() {
        let mut failed = Failed::default();
        let lines = [
            "[1/3] bake a",
            "FAILED: a.pelage r/a.json ",
            "pelage bake a",
            "FAILED: [code=137] b.pelage r/b.json ",
            "pelage bake b",
            "one",
            "two",
            "",
            "three",
            "four",
            "[2/3] bake c",
            "of c",
            "ninja: build stopped: subcommands failed.",
        ];
        lines.iter().for_each(|line| failed.hear(line));
        assert_eq!(failed.last_words("r/a.json").as_deref(), Some(""));
        assert_eq!(failed.last_words("r/b.json").as_deref(), Some("two; three; four"));
        assert_eq!(failed.last_words("r/c.json"), None);
    }

    #[test]
    fn what_ninja_says_is_understood() {
        assert_eq!(status("[3/10] bake a] b"), Some((3, 10, "bake a] b")));
        assert!(["FAILED: a", "[x/2] a", "ninja: no work to do.", ""].iter().all(|line| status(line).is_none()));
    }
}
