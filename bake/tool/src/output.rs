//! Writes results to stdout, progress and notes to stderr.

use super::exit::{Exit, Failure};
use super::progress::{ProgressPrinter, Work};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use pelage_bake::progress::StageProgress;
use pelage_bake::temp_files;
use pelage_import::BakeError;
use serde::Serialize;
use std::fmt;
use std::io::{self, IsTerminal as _, Write as _};
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Output of a subcommand.
#[derive(Debug)]
pub struct Output {
    quiet: bool,
    json: bool,
    /// Whether a complete result was written. A later failure must not print a second JSON object.
    done: bool,
    work: Arc<Mutex<Work>>,
    /// Step counter that stages increment.
    steps: Arc<StageProgress>,
    shown: Option<ProgressDisplay>,
    /// Result and notes since [`Self::start_recording`].
    said: Mutex<Option<RecordedOutput>>,
}

/// Recorded output of a command.
#[derive(Clone, Debug, Default)]
pub struct RecordedOutput {
    /// Result, as text and as JSON.
    pub result: Option<(String, serde_json::Value)>,
    /// Notes, including those that `--quiet` suppressed.
    pub notes: Vec<String>,
}

#[derive(Debug)]
enum ProgressDisplay {
    /// Progress bar for a terminal, and its template.
    Bar(ProgressBar, &'static str),
    /// Progress lines, for stderr that is not a terminal.
    Lines(#[expect(dead_code, reason = "reports progress until it is dropped")] ProgressPrinter),
}

/// Progress template for work whose steps the command does not count.
const DOING: &str = "{spinner} {msg} {elapsed}{left}";
/// Progress template for work whose steps the command counts.
const STEPS: &str = "{bar:30} {msg} {elapsed}{left}";

impl Output {
    /// Creates the output. `quiet` suppresses everything but errors and JSON; `json` makes stdout one JSON object.
    pub fn new(quiet: bool, json: bool) -> Self {
        let steps = Arc::new(StageProgress::new());
        let work = Arc::new(Mutex::new(Work::new(steps.clone())));
        Self { quiet, json, done: false, work, steps, shown: None, said: Mutex::default() }
    }

    /// Returns true if stdout is one JSON object.
    pub fn is_json(&self) -> bool {
        self.json
    }

    /// Prints the result: the JSON of `result` with `--json`, otherwise `text` unless quiet.
    pub fn result(&mut self, text: &str, result: &impl Serialize) -> Result<(), Failure> {
        self.end_progress();
        let json = serde_json::to_value(result).map_err(|error| BakeError::Internal(error.to_string()))?;
        let mut bytes = match (self.json, self.quiet) {
            (true, _) => format!("{json:#}"),
            (false, true) => String::new(),
            (false, false) => text.to_owned(),
        };
        // Empty text is printed without a line end.
        if !bytes.is_empty() && !bytes.ends_with('\n') {
            bytes.push('\n');
        }
        self.done = true;
        if let Some(said) = &mut *self.lock_recording() {
            said.result = Some((text.to_owned(), json));
        }
        let mut stdout = io::stdout().lock();
        stdout.write_all(bytes.as_bytes()).and_then(|()| stdout.flush()).map_err(Failure::Stdout)
    }

    /// Prints a note to stderr, unless quiet.
    pub fn note(&self, text: &str) {
        if let Some(said) = &mut *self.lock_recording() {
            said.notes.push(text.to_owned());
        }
        if !self.quiet {
            let line = || to_stderr(&format!("{text}\n"));
            match &self.shown {
                Some(ProgressDisplay::Bar(bar, _)) => bar.suspend(line),
                _ => line(),
            }
        }
    }

    /// Starts recording the result and notes.
    pub fn start_recording(&self) {
        *self.lock_recording() = Some(RecordedOutput::default());
    }

    /// Returns the result and notes recorded since [`Self::start_recording`].
    pub fn said(&self) -> RecordedOutput {
        self.lock_recording().clone().unwrap_or_default()
    }

    fn lock_recording(&self) -> MutexGuard<'_, Option<RecordedOutput>> {
        self.said.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns the step counter that stages increment; [`Self::progress`] displays it.
    pub fn steps(&self) -> Arc<StageProgress> {
        self.steps.clone()
    }

    /// Shows `doing` as the current work, continuously on a terminal, otherwise as occasional lines.
    pub fn progress(&mut self, doing: &str) {
        self.work().begin(doing);
        self.show(doing, DOING, None);
    }

    /// Shows progress like [`Self::progress`], with `done` of `total` steps and the estimated remaining time. The
    /// estimate is based on the steps since the first call.
    pub fn progress_of(&mut self, done: usize, total: usize, doing: &str) {
        let (done, total) = (done as u64, total as u64);
        self.work().count(done, total, doing);
        self.show(doing, STEPS, Some((done, total)));
    }

    fn work(&self) -> MutexGuard<'_, Work> {
        self.work.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn show(&mut self, doing: &str, template: &'static str, steps: Option<(u64, u64)>) {
        if self.quiet {
            return;
        }
        let work = &self.work;
        let shown = self.shown.get_or_insert_with(|| {
            if !io::stderr().is_terminal() {
                return ProgressDisplay::Lines(ProgressPrinter::new(work.clone(), to_stderr));
            }
            let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
            bar.enable_steady_tick(Duration::from_millis(100));
            ProgressDisplay::Bar(bar, "")
        });
        let ProgressDisplay::Bar(bar, shown) = shown else { return };
        if let Some((done, total)) = steps {
            bar.set_length(total);
            bar.set_position(done);
        }
        if *shown != template {
            *shown = template;
            // The templates are constants. If indicatif rejects one, its default is used.
            let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_spinner());
            let work = work.clone();
            let left = move |_: &ProgressState, out: &mut dyn fmt::Write| {
                let left = work.lock().unwrap_or_else(PoisonError::into_inner).left(Instant::now());
                // Writing into the display's own buffer cannot fail.
                let _ = out.write_str(&left);
            };
            bar.set_style(style.with_key("left", left));
        }
        bar.set_message(doing.to_owned());
    }

    /// Ends the progress display, and clears it from a terminal. [`Self::result`] does this too.
    pub fn end_progress(&mut self) {
        if let Some(ProgressDisplay::Bar(bar, _)) = self.shown.take() {
            bar.finish_and_clear();
        }
    }

    /// Reports a failure on stderr, and with `--json` as the only object on stdout.
    pub fn failure(&mut self, exit: Exit, failure: &Failure) {
        self.end_progress();
        if exit == Exit::Done {
            return;
        }
        if !matches!(failure, Failure::Panicked) {
            to_stderr(&format!("error: {failure}\n"));
        }
        if self.json && !self.done {
            self.error_object(exit, &failure.to_string());
        }
    }

    /// Prints an [`ErrorResult`].
    pub fn error_object(&mut self, exit: Exit, message: &str) {
        let error = ErrorObject { exit_code: exit as u8, message: message.to_owned() };
        // A failure is already being reported, so an error of stdout is ignored.
        let _ = self.result("", &ErrorResult { error });
    }
}

/// Failure of a command. With `--json` it is printed to stdout, in addition to the message on stderr.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ErrorResult {
    error: ErrorObject,
}

/// Exit code and message of a failure.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct ErrorObject {
    #[cfg_attr(feature = "schema", schemars(range(min = 1, max = 5)))]
    exit_code: u8,
    message: String,
}

/// Writes to stderr; errors are ignored, because they cannot be reported.
pub fn to_stderr(text: &str) {
    let _ = io::stderr().lock().write_all(text.as_bytes());
}

/// Fails early if the folder of `file` does not exist. Removes temporary files that killed commands have left in it.
pub fn require_parent(file: &Path) -> Result<(), Failure> {
    let parent = file.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if parent.is_dir() {
        temp_files::remove_abandoned(parent);
        return Ok(());
    }
    let (kind, text) = if parent.exists() {
        (io::ErrorKind::NotADirectory, "not a folder")
    } else {
        (io::ErrorKind::NotFound, "no such folder; create it first")
    };
    let source = io::Error::new(kind, text);
    Err(BakeError::Io { path: parent.to_owned(), action: "write into", source }.into())
}

/// Creates a folder for results, with missing parents.
pub fn make_folder(folder: &Path) -> Result<(), Failure> {
    let fail = |source| BakeError::Io { path: folder.to_owned(), action: "create", source };
    std::fs::create_dir_all(folder).map_err(|source| fail(source).into())
}

/// Formats a number of bytes with a unit, such as `1.5 MiB`.
pub fn human_bytes(bytes: u64) -> String {
    let mut value = bytes as f64;
    for unit in ["B", "KiB", "MiB"] {
        if value < 1024.0 {
            return if unit == "B" { format!("{bytes} B") } else { format!("{value:.1} {unit}") };
        }
        value /= 1024.0;
    }
    format!("{value:.1} GiB")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn byte_counts_are_human_readable() {
        assert_eq!(human_bytes(0), "0 B");
        assert_eq!(human_bytes(1023), "1023 B");
        assert_eq!(human_bytes(1536), "1.5 KiB");
        assert_eq!(human_bytes(5 << 30), "5.0 GiB");
    }

    #[test]
    fn progress_templates_are_valid() {
        assert!([DOING, STEPS].iter().all(|template| ProgressStyle::with_template(template).is_ok()));
    }

    #[test]
    fn a_missing_folder_is_named() {
        let error = require_parent(Path::new("no-such-folder/a.pelage")).map_err(|e| e.to_string());
        assert!(error.as_ref().is_err_and(|e| e.starts_with("no-such-folder: cannot write into")), "{error:?}");
        assert!(require_parent(Path::new("a.pelage")).is_ok());
    }
}
