//! Steps, and the order and threads in which they run.

use super::outputs::{BakeInput, Output, Outputs};
use pelage_import::BakeError;
use rayon::ScopeFifo;
use std::fmt;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Step of a stage. Each step makes one output.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// Stage that contains the step, one of [`STAGES`](super::STAGES).
    pub stage: &'static str,
    /// Output that the step makes.
    pub makes: Output,
    /// Required inputs.
    pub reads: &'static [Output],
    /// Recipe tables or single keys that affect the output directly. Those that affect only the inputs are not
    /// repeated.
    pub tables: &'static [&'static str],
    pub(super) run: for<'a> fn(&BakeInput<'a>, &Outputs<'a>) -> Result<(), BakeError>,
}

impl Step {
    /// Runs the step and stores its output.
    ///
    /// Fails with the errors of [`bake`](super::bake()).
    pub fn run<'a>(&self, input: &BakeInput<'a>, outputs: &Outputs<'a>) -> Result<(), BakeError> {
        (self.run)(input, outputs)
    }
}

/// Beginning or end of a step.
#[derive(Clone, Copy, Debug)]
pub enum StepEvent {
    /// The step begins.
    Begins(&'static Step),
    /// The step ends, also by failing.
    Ends(&'static Step),
}

/// Receiver of the events of a bake. Any thread may call it, one at a time.
pub type OnStep<'a> = dyn FnMut(StepEvent) + Send + 'a;

/// Runs `steps`, which are in order. Each begins when its inputs are made. If several fail, the error is that of the
/// first in order, as if the steps had run one after another.
pub(super) fn run<'a>(
    input: &BakeInput<'a>,
    outputs: &Outputs<'a>,
    steps: &[&'static Step],
    on_step: &mut OnStep<'_>,
) -> Result<(), BakeError> {
    input.steps.reset();
    let progress = Progress { states: vec![StepState::Waits; steps.len()], error: None, on_step };
    let schedule = Schedule { input, outputs, steps, progress: Mutex::new(progress) };
    rayon::scope_fifo(|scope| schedule.begin_ready(scope));
    let progress = schedule.progress.into_inner().unwrap_or_else(PoisonError::into_inner);
    progress.error.map_or(Ok(()), |(_, error)| Err(error))
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum StepState {
    Waits,
    Runs,
    Done,
}

struct Schedule<'r, 'a> {
    input: &'r BakeInput<'a>,
    outputs: &'r Outputs<'a>,
    steps: &'r [&'static Step],
    progress: Mutex<Progress<'r>>,
}

struct Progress<'r> {
    /// State of each step.
    states: Vec<StepState>,
    /// First failed step in order, with its error.
    error: Option<(usize, BakeError)>,
    on_step: &'r mut OnStep<'r>,
}

impl fmt::Debug for Progress<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Progress").field("states", &self.states).field("error", &self.error).finish_non_exhaustive()
    }
}

impl<'r> Schedule<'r, '_> {
    fn lock(&self) -> MutexGuard<'_, Progress<'r>> {
        self.progress.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Begins the waiting steps whose inputs are made. An input that no step makes is left to the step, which reports
    /// it. After a failure, only steps that come before the failed one begin.
    fn begin_ready<'s>(&'s self, scope: &ScopeFifo<'s>) {
        let mut progress = self.lock();
        let end = progress.error.as_ref().map_or(self.steps.len(), |(failed, _)| *failed);
        for (i, step) in self.steps[..end].iter().enumerate() {
            let mut unfinished =
                self.steps.iter().zip(&progress.states).filter(|(_, state)| **state != StepState::Done);
            if progress.states[i] != StepState::Waits || unfinished.any(|(other, _)| step.reads.contains(&other.makes))
            {
                continue;
            }
            (progress.on_step)(StepEvent::Begins(step));
            progress.states[i] = StepState::Runs;
            scope.spawn_fifo(move |scope| self.run_step(i, scope));
        }
    }

    fn run_step<'s>(&'s self, i: usize, scope: &ScopeFifo<'s>) {
        let step = self.steps[i];
        let result = step.run(self.input, self.outputs);
        let mut progress = self.lock();
        match result {
            Ok(()) => progress.states[i] = StepState::Done,
            Err(error) if progress.error.as_ref().is_none_or(|(first, _)| i < *first) => {
                progress.error = Some((i, error));
            }
            Err(_) => {}
        }
        (progress.on_step)(StepEvent::Ends(step));
        drop(progress);
        self.begin_ready(scope);
    }
}
