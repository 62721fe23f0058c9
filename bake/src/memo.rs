//! Memoisation of the last result.

use std::convert::Infallible;

/// Last result of an expensive computation with its input; returned again for an equal input.
#[derive(Clone, Debug)]
pub struct Memo<I, O>(Option<(I, O)>);

impl<I, O> Default for Memo<I, O> {
    fn default() -> Self {
        Self(None)
    }
}

impl<I: PartialEq, O: Clone> Memo<I, O> {
    /// Returns the result of `make` for `input`, which must determine it completely.
    ///
    /// Fails with the errors of `make`; the previous result is kept.
    pub fn make<E>(&mut self, input: I, make: impl FnOnce(&I) -> Result<O, E>) -> Result<O, E> {
        if let Some((_, made)) = self.0.as_ref().filter(|(of, _)| *of == input) {
            return Ok(made.clone());
        }
        let made = make(&input)?;
        self.0 = Some((input, made.clone()));
        Ok(made)
    }

    /// Returns the result like [`Self::make`] does, for a computation that cannot fail.
    pub fn of(&mut self, input: I, make: impl FnOnce(&I) -> O) -> O {
        let Ok(made) = self.make(input, |input| Ok::<_, Infallible>(make(input)));
        made
    }
}
