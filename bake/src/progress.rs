//! Progress of a long stage. The code that does the work counts its steps, and any other thread may read the counter.
//! No clock is used.

use std::sync::atomic::{AtomicU64, Ordering};

/// Step counter of the running work.
#[derive(Debug, Default)]
pub struct StageProgress {
    done: AtomicU64,
    total: AtomicU64,
}

impl StageProgress {
    /// Creates a counter without any work.
    pub const fn new() -> Self {
        Self { done: AtomicU64::new(0), total: AtomicU64::new(0) }
    }

    /// Returns a counter for callers that do not report progress.
    pub fn ignored() -> &'static Self {
        static UNSEEN: StageProgress = StageProgress::new();
        &UNSEEN
    }

    /// Begins work of `total` steps of about equal duration; 0 if their number is unknown.
    pub fn begin(&self, total: u64) {
        self.done.store(0, Ordering::Relaxed);
        self.total.store(total, Ordering::Relaxed);
    }

    /// Counts one completed step.
    pub fn step(&self) {
        self.done.fetch_add(1, Ordering::Relaxed);
    }

    /// Returns the number of completed steps and the total; `None` if the total is unknown.
    pub fn get(&self) -> Option<(u64, u64)> {
        let total = self.total.load(Ordering::Relaxed);
        (total > 0).then(|| (self.done.load(Ordering::Relaxed).min(total), total))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn progress_restarts_with_each_stage() {
        let steps = StageProgress::new();
        assert_eq!(steps.get(), None);
        steps.begin(2);
        assert_eq!(steps.get(), Some((0, 2)));
        (0..3).for_each(|_| steps.step());
        assert_eq!(steps.get(), Some((2, 2)), "never more than all");
        steps.begin(0);
        assert_eq!(steps.get(), None);
    }
}
