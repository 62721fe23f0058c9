//! Memoisation of the last result.

use std::convert::Infallible;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Last result of an expensive computation with its input; returned again for an equal input.
#[derive(Debug)]
pub struct Memo<I, O>(Mutex<Option<(I, O)>>);

impl<I, O> Default for Memo<I, O> {
    fn default() -> Self {
        Self(Mutex::new(None))
    }
}

impl<I: Clone, O: Clone> Clone for Memo<I, O> {
    fn clone(&self) -> Self {
        Self(Mutex::new(self.lock().clone()))
    }
}

impl<I, O> Memo<I, O> {
    fn lock(&self) -> MutexGuard<'_, Option<(I, O)>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<I: PartialEq, O: Clone> Memo<I, O> {
    /// Returns the result of `make` for `input`, which must determine it completely.
    ///
    /// Fails with the errors of `make`; the previous result is kept.
    pub fn make<E>(&self, input: I, make: impl FnOnce(&I) -> Result<O, E>) -> Result<O, E> {
        if let Some((_, made)) = self.lock().as_ref().filter(|(of, _)| *of == input) {
            return Ok(made.clone());
        }
        // Not locked meanwhile: a thread that waits for a part of `make` may run other work that asks this memo.
        let made = make(&input)?;
        *self.lock() = Some((input, made.clone()));
        Ok(made)
    }

    /// Returns the result like [`Self::make`] does, for a computation that cannot fail.
    pub fn of(&self, input: I, make: impl FnOnce(&I) -> O) -> O {
        let Ok(made) = self.make(input, |input| Ok::<_, Infallible>(make(input)));
        made
    }
}
