//! Progress of a long stage. The code that does the work counts its steps, and any other thread may read the counter.
//! No clock is used.

use std::sync::{Mutex, MutexGuard, PoisonError};

/// Step counter of the running work. Stages that run at the same time share it.
#[derive(Debug, Default)]
pub struct StageProgress {
    count: Mutex<StepCount>,
}

/// Steps announced since all earlier ones were completed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StepCount {
    /// Completed steps.
    pub done: u64,
    /// All steps.
    pub total: u64,
    /// How often counting began again.
    pub round: u64,
}

impl StageProgress {
    /// Creates a counter without any work.
    pub const fn new() -> Self {
        Self { count: Mutex::new(StepCount { done: 0, total: 0, round: 0 }) }
    }

    /// Returns a counter for callers that do not report progress.
    pub fn ignored() -> &'static Self {
        static UNSEEN: StageProgress = StageProgress::new();
        &UNSEEN
    }

    fn lock(&self) -> MutexGuard<'_, StepCount> {
        self.count.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Forgets all steps.
    pub fn reset(&self) {
        *self.lock() = StepCount::default();
    }

    /// Announces `steps` steps of about equal duration. If all earlier ones are completed, counting begins again.
    pub fn add(&self, steps: u64) {
        let mut count = self.lock();
        if count.done >= count.total {
            *count = StepCount { done: 0, total: 0, round: count.round + 1 };
        }
        count.total += steps;
    }

    /// Counts one completed step.
    pub fn step(&self) {
        let mut count = self.lock();
        count.done = (count.done + 1).min(count.total);
    }

    /// Returns the count; `done` equals `total` if no step is left.
    pub fn get(&self) -> StepCount {
        *self.lock()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stages_that_overlap_are_counted_together() {
        let steps = StageProgress::new();
        let count = |done, total, round| StepCount { done, total, round };
        assert_eq!(steps.get(), StepCount::default());
        steps.add(2);
        assert_eq!(steps.get(), count(0, 2, 1));
        steps.step();
        steps.add(3);
        assert_eq!(steps.get(), count(1, 5, 1));
        (0..5).for_each(|_| steps.step());
        assert_eq!(steps.get(), count(5, 5, 1), "never more than all");
        steps.add(1);
        assert_eq!(steps.get(), count(0, 1, 2));
        steps.reset();
        assert_eq!(steps.get(), StepCount::default());
    }
}
