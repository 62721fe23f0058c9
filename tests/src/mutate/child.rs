//! Runs the real binary with a time limit, and measures its peak memory.

use crate::binary::pelage;
use std::fs::File;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Result of a process.
#[derive(Clone, Debug)]
pub struct ProcessResult {
    /// Exit code; `None` if the process was ended by a signal or killed at the time limit.
    pub code: Option<i32>,
    /// Whether the run exceeded the time limit and was killed.
    pub too_long: bool,
    /// Complete stdout.
    pub stdout: String,
    /// Complete stderr.
    pub stderr: String,
    /// Duration, seconds.
    pub seconds: f64,
    /// Peak memory, bytes; 0 if the system does not report it.
    pub peak: u64,
}

/// Polling interval of the peak memory. It is far shorter than the tenth of a second that it takes to fill a gigabyte.
const LOOK: Duration = Duration::from_millis(2);

/// Runs `pelage` in a folder, for at most `limit`. Its output goes to files in `notes`, because a pipe could fill up.
///
/// # Errors
///
/// If the process cannot be started, or those files cannot be created or read.
pub fn run(args: &[String], folder: &Path, notes: &Path, limit: Duration) -> std::io::Result<ProcessResult> {
    let [out, err] = ["stdout", "stderr"].map(|name| notes.join(name));
    let mut command = Command::new(pelage());
    command.args(args).current_dir(folder).stdin(Stdio::null());
    command.stdout(File::create(&out)?).stderr(File::create(&err)?);
    // If the variable is unset, Mesa prints lines to stderr.
    command.env("XDG_RUNTIME_DIR", notes);
    let begun = Instant::now();
    let mut child = command.spawn()?;
    let mut peak = 0;
    let (status, too_long) = loop {
        peak = peak.max(peak_memory(&child));
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
    Ok(ProcessResult { code: status.code(), too_long, stdout: text(&out)?, stderr: text(&err)?, seconds, peak })
}

/// Returns the peak memory of a running process, bytes; 0 on systems other than Linux.
fn peak_memory(child: &Child) -> u64 {
    let status = std::fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap_or_default();
    // Before `exec`, the child is a copy of this process and has its memory size.
    if !status.starts_with("Name:\tpelage\n") {
        return 0;
    }
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kib = line.and_then(|line| line.trim().strip_suffix(" kB")?.trim().parse::<u64>().ok());
    kib.unwrap_or(0) * 1024
}
