//! How far a long stage is: counted where the work is done, read by whoever waits. It knows no clock.

use std::sync::atomic::{AtomicU64, Ordering};

/// Steps of the work that runs.
#[derive(Debug, Default)]
pub struct Steps {
    done: AtomicU64,
    total: AtomicU64,
}

impl Steps {
    /// Before any work.
    pub const fn new() -> Self {
        Self { done: AtomicU64::new(0), total: AtomicU64::new(0) }
    }

    /// A counter that nobody reads.
    pub fn unseen() -> &'static Self {
        static UNSEEN: Steps = Steps::new();
        &UNSEEN
    }

    /// Begins work of `total` steps of about the same length; 0 where nobody knows how many.
    pub fn begin(&self, total: u64) {
        self.done.store(0, Ordering::Relaxed);
        self.total.store(total, Ordering::Relaxed);
    }

    /// One step is over.
    pub fn step(&self) {
        self.done.fetch_add(1, Ordering::Relaxed);
    }

    /// Steps that are over and all of them; `None` where nobody knows how many.
    pub fn so_far(&self) -> Option<(u64, u64)> {
        let total = self.total.load(Ordering::Relaxed);
        (total > 0).then(|| (self.done.load(Ordering::Relaxed).min(total), total))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_counted_from_each_beginning() {
        let steps = Steps::new();
        assert_eq!(steps.so_far(), None);
        steps.begin(2);
        assert_eq!(steps.so_far(), Some((0, 2)));
        (0..3).for_each(|_| steps.step());
        assert_eq!(steps.so_far(), Some((2, 2)), "never more than all");
        steps.begin(0);
        assert_eq!(steps.so_far(), None);
    }
}
