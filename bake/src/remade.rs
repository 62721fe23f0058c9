//! A result that is kept with what it was made of.

use std::convert::Infallible;

/// The last result of something that is dear to make: asked for the same again, it is there already.
#[derive(Clone, Debug)]
pub struct Remade<I, O>(Option<(I, O)>);

impl<I, O> Default for Remade<I, O> {
    fn default() -> Self {
        Self(None)
    }
}

impl<I: PartialEq, O: Clone> Remade<I, O> {
    /// What `make` makes of `input`, which must decide about all of it.
    ///
    /// # Errors
    ///
    /// Those of `make`; what was kept before still is.
    pub fn make<E>(&mut self, input: I, make: impl FnOnce(&I) -> Result<O, E>) -> Result<O, E> {
        if let Some((_, made)) = self.0.as_ref().filter(|(of, _)| *of == input) {
            return Ok(made.clone());
        }
        let made = make(&input)?;
        self.0 = Some((input, made.clone()));
        Ok(made)
    }

    /// As [`Self::make`], for what cannot fail.
    pub fn of(&mut self, input: I, make: impl FnOnce(&I) -> O) -> O {
        let Ok(made) = self.make(input, |input| Ok::<_, Infallible>(make(input)));
        made
    }
}
