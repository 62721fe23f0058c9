//! One run of the real binary under a clock, with the memory that it took.

use crate::binary::pelage;
use std::fs::File;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// How a run ended.
#[derive(Clone, Debug)]
pub struct Ended {
    /// Exit code; `None` where a signal ended the process, also that of the clock.
    pub code: Option<i32>,
    /// It was ended because it took longer than the limit.
    pub too_long: bool,
    /// All of stdout.
    pub stdout: String,
    /// All of stderr.
    pub stderr: String,
    /// Seconds from start to end.
    pub seconds: f64,
    /// The most memory that it held at a time, bytes; 0 where the system does not say.
    pub peak: u64,
}

/// How often a process is looked at. Memory grows slower than that: a gigabyte takes a tenth of a second to be written to.
const LOOK: Duration = Duration::from_millis(2);

/// Runs `pelage` in a folder, for at most so long. What it says goes through files in `notes`, so that no pipe can fill up.
///
/// # Errors
///
/// Where the system refuses to start it, or to make or read those files.
pub fn run(args: &[String], folder: &Path, notes: &Path, limit: Duration) -> std::io::Result<Ended> {
    let [out, err] = ["stdout", "stderr"].map(|name| notes.join(name));
    let mut command = Command::new(pelage());
    command.args(args).current_dir(folder).stdin(Stdio::null());
    command.stdout(File::create(&out)?).stderr(File::create(&err)?);
    // Mesa looks there for a display, and complains on stderr where there is none.
    command.env("XDG_RUNTIME_DIR", notes);
    let begun = Instant::now();
    let mut child = command.spawn()?;
    let mut peak = 0;
    let (status, too_long) = loop {
        peak = peak.max(held(&child));
        if let Some(status) = child.try_wait()? {
            break (status, false);
        }
        if begun.elapsed() > limit {
            child.kill()?;
            break (child.wait()?, true);
        }
        std::thread::sleep(LOOK);
    };
    let seconds = begun.elapsed().as_secs_f64();
    let text = |path| Ok::<_, std::io::Error>(String::from_utf8_lossy(&std::fs::read(path)?).into_owned());
    Ok(Ended { code: status.code(), too_long, stdout: text(&out)?, stderr: text(&err)?, seconds, peak })
}

/// The most memory that a process has held so far, bytes: Linux says it, other systems do not.
fn held(child: &Child) -> u64 {
    let status = std::fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap_or_default();
    // Until it is replaced, a new process is this one, with all its memory.
    if !status.starts_with("Name:\tpelage\n") {
        return 0;
    }
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kib = line.and_then(|line| line.trim().strip_suffix(" kB")?.trim().parse::<u64>().ok());
    kib.unwrap_or(0) * 1024
}
