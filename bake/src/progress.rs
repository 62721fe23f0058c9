//! Progress of a long stage. The code that does the work counts its steps, and any other thread may read the counter.
//! No clock is used.

use std::sync::{Mutex, MutexGuard, PoisonError};

/// Step counters of the running stages.
#[derive(Debug, Default)]
pub struct StageProgress {
    counts: Mutex<Vec<StepCount>>,
}

/// Step counter of a stage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StepCount {
    /// Name of the stage.
    pub stage: &'static str,
    /// Completed steps.
    pub done: u64,
    /// All steps announced so far.
    pub total: u64,
}

impl StageProgress {
    /// Creates counters without any work.
    pub const fn new() -> Self {
        Self { counts: Mutex::new(Vec::new()) }
    }

    /// Returns counters for callers that do not report progress.
    pub fn ignored() -> &'static Self {
        static UNSEEN: StageProgress = StageProgress::new();
        &UNSEEN
    }

    fn lock(&self) -> MutexGuard<'_, Vec<StepCount>> {
        self.counts.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Forgets all steps.
    pub fn reset(&self) {
        self.lock().clear();
    }

    /// Announces `steps` steps of a stage, of about equal duration, in addition to earlier ones.
    pub fn add(&self, stage: &'static str, steps: u64) {
        let mut counts = self.lock();
        match counts.iter_mut().find(|count| count.stage == stage) {
            Some(count) => count.total += steps,
            None => counts.push(StepCount { stage, done: 0, total: steps }),
        }
    }

    /// Counts one completed step of a stage.
    pub fn step(&self, stage: &'static str) {
        if let Some(count) = self.lock().iter_mut().find(|count| count.stage == stage) {
            count.done = (count.done + 1).min(count.total);
        }
    }

    /// Returns the counter of the stage that has the most steps left; `None` if no step is left.
    pub fn get(&self) -> Option<StepCount> {
        let left = |count: &StepCount| count.total - count.done;
        self.lock().iter().filter(|count| left(count) > 0).max_by_key(|count| left(count)).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stages_that_overlap_are_counted_separately() {
        let progress = StageProgress::new();
        let count = |stage, done, total| Some(StepCount { stage, done, total });
        assert_eq!(progress.get(), None);
        progress.add("ink", 2);
        assert_eq!(progress.get(), count("ink", 0, 2));
        progress.add("slice", 3);
        progress.step("ink");
        assert_eq!(progress.get(), count("slice", 0, 3));
        (0..4).for_each(|_| progress.step("slice"));
        assert_eq!(progress.get(), count("ink", 1, 2), "never more than all");
        progress.add("slice", 5);
        assert_eq!(progress.get(), count("slice", 3, 8));
        progress.reset();
        assert_eq!(progress.get(), None);
    }
}
