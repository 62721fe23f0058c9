//! Progress of a long stage. The code that does the work counts its steps, and any other thread may read the counter.
//! No clock is used.

use std::sync::{Mutex, MutexGuard, PoisonError};

/// Step counter of the running work. Stages that run at the same time share it.
#[derive(Debug, Default)]
pub struct StageProgress {
    /// Completed steps, and all steps announced so far.
    count: Mutex<(u64, u64)>,
}

impl StageProgress {
    /// Creates a counter without any work.
    pub const fn new() -> Self {
        Self { count: Mutex::new((0, 0)) }
    }

    /// Returns a counter for callers that do not report progress.
    pub fn ignored() -> &'static Self {
        static UNSEEN: StageProgress = StageProgress::new();
        &UNSEEN
    }

    fn lock(&self) -> MutexGuard<'_, (u64, u64)> {
        self.count.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Forgets all steps.
    pub fn reset(&self) {
        *self.lock() = (0, 0);
    }

    /// Announces `steps` steps of about equal duration, in addition to earlier ones.
    pub fn add(&self, steps: u64) {
        self.lock().1 += steps;
    }

    /// Counts one completed step.
    pub fn step(&self) {
        let mut count = self.lock();
        count.0 = (count.0 + 1).min(count.1);
    }

    /// Returns the number of completed steps.
    pub fn completed(&self) -> u64 {
        self.lock().0
    }

    /// Returns the number of completed steps and the total; `None` if no step is left.
    pub fn get(&self) -> Option<(u64, u64)> {
        let count = *self.lock();
        (count.0 < count.1).then_some(count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stages_that_overlap_are_counted_together() {
        let steps = StageProgress::new();
        assert_eq!(steps.get(), None);
        steps.add(2);
        assert_eq!(steps.get(), Some((0, 2)));
        steps.step();
        steps.add(3);
        assert_eq!(steps.get(), Some((1, 5)));
        (0..5).for_each(|_| steps.step());
        assert_eq!((steps.get(), steps.completed()), (None, 5), "never more than all");
        steps.add(1);
        assert_eq!(steps.get(), Some((5, 6)));
        steps.reset();
        assert_eq!(steps.get(), None);
    }
}
