//! Results on stdout, progress and notes on stderr.

use super::exit::{Exit, Failure};
use super::work::{Herald, Work};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use pelage_bake::steps::Steps;
use pelage_import::BakeError;
use serde::Serialize;
use std::fmt;
use std::io::{self, IsTerminal as _, Write as _};
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Where a subcommand's words go.
#[derive(Debug)]
pub struct Output {
    quiet: bool,
    json: bool,
    /// A whole result was written: then a later failure must not add a second JSON object.
    done: bool,
    /// What is being done.
    work: Arc<Mutex<Work>>,
    /// Where stages count their steps.
    steps: Arc<Steps>,
    /// Who shows the work.
    shown: Option<Shown>,
    /// What was said since somebody listens.
    said: Mutex<Option<Said>>,
}

/// What a command has said, for who keeps it.
#[derive(Clone, Debug, Default)]
pub struct Said {
    /// Its result, for people and for scripts.
    pub result: Option<(String, serde_json::Value)>,
    /// Its notes, also where it was quiet.
    pub notes: Vec<String>,
}

#[derive(Debug)]
enum Shown {
    /// A terminal; with the template that the bar has.
    Bar(ProgressBar, &'static str),
    /// Lines on what is no terminal.
    Lines(#[expect(dead_code, reason = "it tells until it is dropped")] Herald),
}

/// Templates of the progress: of work that counts nothing or by itself, and of steps that the command counts.
const DOING: &str = "{spinner} {msg} {elapsed}{left}";
const STEPS: &str = "{bar:30} {msg} {elapsed}{left}";

impl Output {
    /// `quiet` silences everything but errors and JSON, `json` makes stdout one JSON object.
    pub fn new(quiet: bool, json: bool) -> Self {
        let steps = Arc::new(Steps::new());
        let work = Arc::new(Mutex::new(Work::new(steps.clone())));
        Self { quiet, json, done: false, work, steps, shown: None, said: Mutex::default() }
    }

    /// Whether stdout is one JSON object.
    pub fn is_json(&self) -> bool {
        self.json
    }

    /// Prints the result: `result` as JSON with `--json`, else the lines of `text` unless quiet.
    pub fn result(&mut self, text: &str, result: &impl Serialize) -> Result<(), Failure> {
        self.end_progress();
        let json = serde_json::to_value(result).map_err(|error| BakeError::Internal(error.to_string()))?;
        let mut bytes = match (self.json, self.quiet) {
            (true, _) => format!("{json:#}"),
            (false, true) => String::new(),
            (false, false) => text.to_owned(),
        };
        // Of no lines there is none.
        if !bytes.is_empty() && !bytes.ends_with('\n') {
            bytes.push('\n');
        }
        self.done = true;
        if let Some(said) = &mut *self.heard() {
            said.result = Some((text.to_owned(), json));
        }
        let mut stdout = io::stdout().lock();
        stdout.write_all(bytes.as_bytes()).and_then(|()| stdout.flush()).map_err(Failure::Stdout)
    }

    /// Says something on stderr, unless quiet.
    pub fn note(&self, text: &str) {
        if let Some(said) = &mut *self.heard() {
            said.notes.push(text.to_owned());
        }
        if !self.quiet {
            let line = || to_stderr(&format!("{text}\n"));
            match &self.shown {
                Some(Shown::Bar(bar, _)) => bar.suspend(line),
                _ => line(),
            }
        }
    }

    /// From now on what is said is kept.
    pub fn listen(&self) {
        *self.heard() = Some(Said::default());
    }

    /// What was said since [`Self::listen`].
    pub fn said(&self) -> Said {
        self.heard().clone().unwrap_or_default()
    }

    fn heard(&self) -> MutexGuard<'_, Option<Said>> {
        self.said.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Where stages count their steps, so that [`Self::progress`] shows how far they are.
    pub fn steps(&self) -> Arc<Steps> {
        self.steps.clone()
    }

    /// Shows what is being done: on a terminal as it goes, else a line now and then.
    pub fn progress(&mut self, doing: &str) {
        self.work().begin(doing);
        self.show(doing, DOING, None);
    }

    /// As [`Self::progress`], that `done` of `total` steps are over, and how long the others may take: as long as those since the first call.
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
                return Shown::Lines(Herald::new(work.clone(), to_stderr));
            }
            let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
            bar.enable_steady_tick(Duration::from_millis(100));
            Shown::Bar(bar, "")
        });
        let Shown::Bar(bar, shown) = shown else { return };
        if let Some((done, total)) = steps {
            bar.set_length(total);
            bar.set_position(done);
        }
        if *shown != template {
            *shown = template;
            // The templates are constants; should indicatif refuse one, its default will do.
            let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_spinner());
            let work = work.clone();
            let left = move |_: &ProgressState, out: &mut dyn fmt::Write| {
                let left = work.lock().unwrap_or_else(PoisonError::into_inner).left(Instant::now());
                // Onto the display's own buffer, which takes all.
                let _ = out.write_str(&left);
            };
            bar.set_style(style.with_key("left", left));
        }
        bar.set_message(doing.to_owned());
    }

    /// Ends the progress, as [`Self::result`] does: nothing of it stays on a terminal.
    pub fn end_progress(&mut self) {
        if let Some(Shown::Bar(bar, _)) = self.shown.take() {
            bar.finish_and_clear();
        }
    }

    /// Reports a failure: on stderr, and with `--json` as the one object on stdout.
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
        // The failure is being reported already; a stdout that fails as well changes nothing.
        let _ = self.result("", &ErrorResult { error });
    }
}

/// Failure of a command: with `--json` this is printed to stdout, beside the message on stderr.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ErrorResult {
    error: ErrorObject,
}

/// Reason of a failure.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct ErrorObject {
    #[cfg_attr(feature = "schema", schemars(range(min = 1, max = 5)))]
    exit_code: u8,
    message: String,
}

/// Writes to stderr; nobody is left to tell when that fails.
pub fn to_stderr(text: &str) {
    let _ = io::stderr().lock().write_all(text.as_bytes());
}

/// Fails early where the folder that `file` shall be written into does not exist.
pub fn require_parent(file: &Path) -> Result<(), Failure> {
    let parent = file.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if parent.is_dir() {
        return Ok(());
    }
    let (kind, text) = if parent.exists() {
        (io::ErrorKind::NotADirectory, "it is no folder")
    } else {
        (io::ErrorKind::NotFound, "there is no such folder; create it first")
    };
    let source = io::Error::new(kind, text);
    Err(BakeError::Io { path: parent.to_owned(), action: "write into", source }.into())
}

/// Makes a folder that results are put in, with those above it, unless it is there.
pub fn make_folder(folder: &Path) -> Result<(), Failure> {
    let fail = |source| BakeError::Io { path: folder.to_owned(), action: "create", source };
    std::fs::create_dir_all(folder).map_err(|source| fail(source).into())
}

/// Bytes for people: `1.5 MiB`.
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
    fn sizes_are_readable() {
        assert_eq!(human_bytes(0), "0 B");
        assert_eq!(human_bytes(1023), "1023 B");
        assert_eq!(human_bytes(1536), "1.5 KiB");
        assert_eq!(human_bytes(5 << 30), "5.0 GiB");
    }

    #[test]
    fn the_progress_is_understood() {
        assert!([DOING, STEPS].iter().all(|template| ProgressStyle::with_template(template).is_ok()));
    }

    #[test]
    fn a_missing_folder_is_named() {
        let error = require_parent(Path::new("no-such-folder/a.pelage")).map_err(|e| e.to_string());
        assert!(error.as_ref().is_err_and(|e| e.starts_with("no-such-folder: cannot write into")), "{error:?}");
        assert!(require_parent(Path::new("a.pelage")).is_ok());
    }
}
