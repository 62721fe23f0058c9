//! Decides whether a case reveals a fault of pelage.

use super::assemble;
use super::case::{Case, Entry, OutputCheck, Step};
use super::child::{ProcessResult, run};
use crate::binary::files;
use pelage_runtime::{Renderer, RendererOptions, RuntimeError};
use pelage_stage::{Gpu, StageError};
use serde_json::Value;
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// Time limit of a command, seconds.
pub const SECONDS: u64 = 10;
/// Memory limit of a command, bytes.
pub const BYTES: u64 = 1 << 30;
/// Exit codes that bad input may cause: success, usage, file system, bad input, faults found.
const CODES: [i32; 5] = [0, 1, 2, 3, 7];

/// Outcome of a case.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// Number of runs for each command and exit code; the keys are like `bake 3`.
    pub exits: BTreeMap<String, u64>,
    /// Faults of pelage.
    pub faults: Vec<String>,
    /// Whether a command exceeded the time limit, which may only mean that the machine was busy.
    pub slow: bool,
    /// Duration of the longest command, seconds.
    pub seconds: f64,
    /// Peak memory of any command, bytes.
    pub peak: u64,
}

impl Outcome {
    fn fault(&mut self, step: &Step, text: impl AsRef<str>) {
        let command = step.args.first().map_or("", String::as_str);
        self.faults.push(format!("{command}: {}", text.as_ref()));
    }
}

/// Runtime that must load every package, unless `validate` finds a fault that prevents drawing.
#[derive(Debug)]
pub struct Loader {
    gpu: Gpu,
    renderer: Mutex<Renderer>,
}

impl Loader {
    /// Opens the device that wgpu prefers.
    ///
    /// # Errors
    ///
    /// If an adapter is missing.
    pub fn open() -> Result<Self, StageError> {
        let gpu = Gpu::open()?;
        let renderer = Renderer::new(&gpu.device, &gpu.queue, &RendererOptions::default());
        let renderer = renderer.map_err(|e| StageError::Params(e.to_string()))?;
        Ok(Self { gpu, renderer: Mutex::new(renderer) })
    }

    /// Loads a package. A package that exceeds a limit of the device is not faulty.
    ///
    /// # Errors
    ///
    /// The runtime's error message, or the message of a panic.
    pub fn load(&self, bytes: &[u8]) -> Result<(), String> {
        let loaded = catch_unwind(AssertUnwindSafe(|| {
            // The lock may be poisoned by an earlier panic, which was reported; the run continues.
            let renderer = self.renderer.lock().unwrap_or_else(PoisonError::into_inner);
            let loaded = renderer.load_bytes(bytes).map(drop);
            (loaded, self.gpu.wait())
        }));
        match loaded {
            Err(panic) => Err(format!("panicked: {}", panic_message(&*panic))),
            Ok((_, Err(lost))) => Err(lost.to_string()),
            Ok((Err(RuntimeError::DeviceLimit { .. }) | Ok(()), Ok(()))) => Ok(()),
            Ok((Err(error), Ok(()))) => Err(error.to_string()),
        }
    }
}

fn panic_message(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(|t| (*t).to_owned());
    text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_default()
}

/// Folder for cases, emptied before each, and a separate folder for the output of commands.
#[derive(Debug)]
pub struct CaseRunner {
    folder: tempfile::TempDir,
}

impl CaseRunner {
    /// Creates the folders.
    ///
    /// # Errors
    ///
    /// If a folder cannot be created.
    pub fn new() -> std::io::Result<Self> {
        let out = Self { folder: tempfile::tempdir()? };
        std::fs::create_dir(out.notes())?;
        Ok(out)
    }

    /// Returns the folder of the case.
    pub fn case(&self) -> PathBuf {
        self.folder.path().join("case")
    }

    fn notes(&self) -> PathBuf {
        self.folder.path().join("notes")
    }

    /// Replaces the files of the previous case with those of `case`.
    ///
    /// # Errors
    ///
    /// If a file cannot be removed or written.
    pub fn write_case(&self, case: &Case) -> std::io::Result<()> {
        case.write_into(&self.case())
    }

    /// Runs a case and judges it.
    ///
    /// # Errors
    ///
    /// If files cannot be written, or processes cannot be started.
    pub fn judge(&self, case: &Case, loader: Option<&Loader>) -> std::io::Result<Outcome> {
        self.write_case(case)?;
        let mut outcome = Outcome::default();
        let mut drawable = None;
        for step in &case.steps {
            // Without a loader there may be no adapter, so nothing is drawn.
            if step.args[0] == "render" && loader.is_none() {
                continue;
            }
            let ended = self.step(case, step, &mut outcome)?;
            if step.args[0] == "validate" {
                drawable = drawable_by(&ended);
            }
        }
        if let Some(Entry::File(_, bytes)) =
            case.package.and_then(|name| case.entries.iter().find(|entry| entry.name() == name))
        {
            let (faults, loads) = check_in_process(bytes, drawable, loader);
            outcome.faults.extend(faults);
            if let Some(loads) = loads {
                *outcome.exits.entry(if loads { "loaded" } else { "not loaded" }.to_owned()).or_default() += 1;
            }
        }
        Ok(outcome)
    }

    /// Runs one command, and checks its exit code, its output and the files that it leaves.
    fn step(&self, case: &Case, step: &Step, outcome: &mut Outcome) -> std::io::Result<ProcessResult> {
        let folder = self.case();
        let before = files(&folder);
        let ended = run(&step.args, &folder, &self.notes(), Duration::from_secs(SECONDS))?;
        outcome.seconds = outcome.seconds.max(ended.seconds);
        outcome.peak = outcome.peak.max(ended.peak);
        outcome.slow |= ended.too_long;
        let code = ended.code.map_or_else(|| "signal".to_owned(), |code| code.to_string());
        *outcome.exits.entry(format!("{} {code}", step.args[0])).or_default() += 1;
        if ended.peak > BYTES {
            outcome.fault(step, format!("held {} MiB of memory", ended.peak >> 20));
        }
        if ended.too_long {
            outcome.fault(step, format!("took longer than {SECONDS} s"));
            return Ok(ended);
        }
        let said = ended.stderr.trim();
        if ended.code.is_none_or(|code| !CODES.contains(&code)) || said.contains("panicked") {
            outcome.fault(step, format!("exit code {code}: {said}"));
            return Ok(ended);
        }
        let done = ended.code == Some(0);
        if ended.code == Some(7) && step.args[0] != "validate" {
            outcome.fault(step, "exit code 7, which is that of `validate`");
        }
        if !done && if ended.code == Some(7) { ended.stdout.trim().is_empty() } else { said.is_empty() } {
            outcome.fault(step, format!("exit code {code} without a message"));
        }
        let named = |entry: &Entry| said.contains(entry.name().rsplit('/').next().unwrap_or_default());
        // The message may name a missing file by its folder. Such a file has no entry in the case, but its folder is an
        // argument.
        let below = |arg: &String| said.contains(&format!("{arg}/")) || said.contains(&format!("{arg}:"));
        if ended.code == Some(3) && !case.entries.iter().any(named) && !step.args.iter().any(below) {
            outcome.fault(step, format!("exit code 3 and no file named: {said}"));
        }
        let after = files(&folder);
        let made =
            |name: &String| step.makes.is_some_and(|output| name == output || name.starts_with(&format!("{output}/")));
        let new: Vec<&String> = after.iter().filter(|name| !(before.contains(name) || done && made(name))).collect();
        if !new.is_empty() {
            outcome.fault(step, format!("exit code {code}, and left {new:?} behind"));
        }
        if let Some(gone) = before.iter().find(|name| !after.contains(name)) {
            outcome.fault(step, format!("exit code {code}, and {gone} is gone"));
        }
        if let Some(output) = step.makes.filter(|_| done) {
            if !folder.join(output).exists() {
                outcome.fault(step, format!("exit code 0, but there is no {output}"));
            } else {
                self.check_output(case, step, output, outcome)?;
            }
        }
        Ok(ended)
    }

    /// Checks the requirement on the output of a command.
    fn check_output(
        &self,
        case: &Case,
        step: &Step,
        output: &'static str,
        outcome: &mut Outcome,
    ) -> std::io::Result<()> {
        match step.then {
            OutputCheck::Nothing => {}
            OutputCheck::Validates => {
                let found = self.step(case, &Step::reads(&["validate", output]), outcome)?;
                if found.code != Some(0) {
                    let words = if found.stdout.is_empty() { found.stderr } else { found.stdout };
                    outcome.fault(step, format!("exit code 0, but the package is not sound: {}", words.trim()));
                }
            }
            OutputCheck::PacksBack => {
                const PACKED: &str = "packed-again.pelage";
                let packed =
                    self.step(case, &Step::makes(&["pack", output, PACKED], PACKED, OutputCheck::Nothing), outcome)?;
                let folder = self.case();
                let same = || {
                    Some(std::fs::read(folder.join(PACKED)).ok()? == std::fs::read(folder.join(&step.args[1])).ok()?)
                };
                if packed.code != Some(0) || same() != Some(true) {
                    outcome.fault(
                        step,
                        format!("the unpacked folder does not pack to the same bytes: {}", packed.stderr.trim()),
                    );
                }
            }
        }
        Ok(())
    }
}

/// Returns whether `validate --json` found no fault that prevents drawing; `None` if it could not validate the package.
fn drawable_by(ended: &ProcessResult) -> Option<bool> {
    if !matches!(ended.code, Some(0 | 7)) {
        return None;
    }
    let answer: Value = serde_json::from_str(&ended.stdout).ok()?;
    Some(answer["faults"].as_array()?.iter().all(|fault| fault["stops_drawing"] == false))
}

/// Checks a package in this process. The formats crate must not panic on it. The runtime must load it if and only if
/// `drawable` is true. Returns the faults, and whether the package loads, if that was tried.
fn check_in_process(bytes: &[u8], drawable: Option<bool>, loader: Option<&Loader>) -> (Vec<String>, Option<bool>) {
    let (mut faults, mut loads) = (Vec::new(), None);
    let used = catch_unwind(|| assemble::open(bytes) && !assemble::round_trip(bytes));
    match used {
        Err(panic) => faults.push(format!("formats: panicked: {}", panic_message(&*panic))),
        Ok(true) => faults.push("formats: cannot write a valid package again".into()),
        Ok(false) => {}
    }
    if let (Some(drawable), Some(loader)) = (drawable, loader) {
        let loaded = loader.load(bytes);
        loads = Some(loaded.is_ok());
        match (drawable, loaded) {
            (true, Err(why)) => {
                faults.push(format!("runtime: `validate` found nothing that stops drawing, but: {why}"));
            }
            (false, Ok(())) => {
                faults.push("runtime: loads a package that cannot be drawn according to `validate`".into());
            }
            _ => {}
        }
    }
    (faults, loads)
}
