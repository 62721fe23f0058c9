//! Pools of texture sets that frames reuse: each concurrent use gets its own set.

use std::sync::Arc;

/// Number of frames after which an unused set is freed.
const FREED_AFTER: u64 = 32;

/// Pool of sets `T`. A frame holds references to the sets that it draws from.
#[derive(Debug)]
pub(crate) struct Pool<T> {
    /// Sets, each with the last frame that used it.
    sets: Vec<(Arc<T>, u64)>,
    frame: u64,
}

impl<T> Default for Pool<T> {
    fn default() -> Self {
        Self { sets: Vec::new(), frame: 0 }
    }
}

impl<T> Pool<T> {
    /// Frees sets that have not been used for long.
    pub(crate) fn next_frame(&mut self) {
        self.frame += 1;
        let oldest = self.frame.saturating_sub(FREED_AFTER);
        self.sets.retain(|(_, last)| *last >= oldest);
    }

    /// Returns a set that matches `wanted`, for shared read-only use.
    pub(crate) fn share(&mut self, wanted: impl Fn(&T) -> bool) -> Option<Arc<T>> {
        let (set, last) = self.sets.iter_mut().find(|(set, _)| wanted(set))?;
        *last = self.frame;
        Some(set.clone())
    }

    /// Removes a set that no frame holds, so that it can be overwritten. If several fit, the least recently used is
    /// removed.
    pub(crate) fn take(&mut self, fits: impl Fn(&T) -> bool) -> Option<T> {
        let free = self.sets.iter().enumerate().filter(|(_, (set, _))| Arc::strong_count(set) == 1 && fits(set));
        let (index, _) = free.min_by_key(|(_, (_, last))| *last)?;
        let (set, last) = self.sets.swap_remove(index);
        Arc::try_unwrap(set).map_err(|held| self.sets.push((held, last))).ok()
    }

    /// Stores a set for this frame and later ones.
    pub(crate) fn put(&mut self, set: T) -> Arc<T> {
        let set = Arc::new(set);
        self.sets.push((set.clone(), self.frame));
        set
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn buffer_sets_are_reused_once_released() {
        let mut shelf = Pool::default();
        let held = shelf.put(1);
        drop(shelf.put(2));
        assert_eq!(shelf.take(|n| *n == 1), None, "a frame holds it");
        assert_eq!(shelf.take(|_| true), Some(2));
        assert_eq!(shelf.share(|n| *n == 1), Some(held.clone()));
        drop(held);
        shelf.next_frame();
        drop(shelf.put(3));
        assert_eq!(shelf.take(|_| true), Some(1), "the least recently used one");
        (0..FREED_AFTER).for_each(|_| shelf.next_frame());
        assert!(shelf.share(|n| *n == 3).is_some());
        (0..=FREED_AFTER).for_each(|_| shelf.next_frame());
        assert!(shelf.take(|_| true).is_none());
    }
}
