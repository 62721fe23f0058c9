//! Steps, and the order and threads in which they run.

use super::input::BakeInput;
use super::outputs::{Output, Outputs};
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
    /// Fails with the errors of [`bake`](super::bake()); [`BakeError::Internal`] if an input is missing or the output
    /// already exists.
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

/// Receiver of the events of a bake. Any thread may call it, one at a time. It must not run work on the threads of the
/// bake, which may wait for it.
pub type OnStep<'a> = dyn FnMut(StepEvent) + Send + 'a;

/// Runs `steps`, which are in order. Each begins when its inputs are made. If several fail, the error is that of the
/// first in order, as if the steps had run one after another.
pub(super) fn run<'a>(
    input: &BakeInput<'a>,
    outputs: &Outputs<'a>,
    steps: &[&'static Step],
    on_step: &mut OnStep<'_>,
) -> Result<(), BakeError> {
    input.progress.reset();
    let progress = Progress { states: vec![StepState::Waits; steps.len()], error: None, on_step };
    let schedule = Schedule { input, outputs, steps, progress: Mutex::new(progress) };
    rayon::scope_fifo(|scope| schedule.spawn_ready(scope));
    let progress = schedule.progress.into_inner().unwrap_or_else(PoisonError::into_inner);
    progress.error.map_or(Ok(()), |(_, error)| Err(error))
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum StepState {
    /// Waits for its inputs.
    Waits,
    /// Waits for a thread.
    Ready,
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

    /// Hands the waiting steps whose inputs are made to the threads. An input that no step makes is left to the step,
    /// which reports it.
    fn spawn_ready<'s>(&'s self, scope: &ScopeFifo<'s>) {
        let mut progress = self.lock();
        for (i, step) in self.steps.iter().enumerate() {
            let mut unfinished =
                self.steps.iter().zip(&progress.states).filter(|(_, state)| **state != StepState::Done);
            if progress.states[i] != StepState::Waits || unfinished.any(|(other, _)| step.reads.contains(&other.makes))
            {
                continue;
            }
            progress.states[i] = StepState::Ready;
            scope.spawn_fifo(move |scope| self.run_step(i, scope));
        }
    }

    /// Runs a step, and hands on the steps that waited for it. After a failure, only steps that come before the failed
    /// one run.
    fn run_step<'s>(&'s self, i: usize, scope: &ScopeFifo<'s>) {
        let step = self.steps[i];
        let mut progress = self.lock();
        if progress.error.as_ref().is_some_and(|(failed, _)| *failed < i) {
            return;
        }
        progress.states[i] = StepState::Runs;
        (progress.on_step)(StepEvent::Begins(step));
        drop(progress);
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
        self.spawn_ready(scope);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recipe::Recipe;
    use crate::stages::groom::MapImages;
    use std::thread::sleep;
    use std::time::Duration;

    const fn step(makes: Output, reads: &'static [Output], run: fn(&BakeInput<'_>, &Outputs<'_>) -> Failing) -> Step {
        Step { stage: "test", makes, reads, tables: &[], run }
    }

    type Failing = Result<(), BakeError>;

    fn fails(what: &str) -> Failing {
        Err(BakeError::Internal(what.to_owned()))
    }

    #[test]
    fn error_of_the_first_step_in_order_is_returned() {
        static SLOW: Step = step(Output::Hair, &[], |_, _| {
            sleep(Duration::from_millis(50));
            fails("slow")
        });
        static QUICK: Step = step(Output::Shells, &[], |_, _| fails("quick"));
        static NEVER: Step = step(Output::Fins, &[Output::Hair], |_, _| panic!("begins without its input"));
        let (recipe, images) = (Recipe::default(), MapImages::default());
        for threads in [1, 4] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
            let (mut begun, mut ended) = (0, 0);
            let error = pool.install(|| {
                let input = BakeInput::new("m", "m", &recipe, &images);
                let count = &mut |event| match event {
                    StepEvent::Begins(_) => begun += 1,
                    StepEvent::Ends(_) => ended += 1,
                };
                run(&input, &Outputs::default(), &[&SLOW, &QUICK, &NEVER], count).expect_err("two steps fail")
            });
            assert!(error.to_string().contains("slow"), "{threads} threads: {error}");
            assert!(begun == ended && (1..=2).contains(&begun), "{threads} threads: {begun} begun, {ended} ended");
        }
    }
}
