//! Application of short forms to a look.

use super::short::ShortForm;
use super::tables::Look;
use pelage_params::{Knob, ParamError, knobs};

impl ShortForm {
    /// Returns the knob that this flag sets. `None` for a published form of a formula in a build without the feature
    /// `study`.
    pub fn knob(&self) -> Option<&'static Knob> {
        knobs::<Look>().find(|knob| knob.name == self.key)
    }

    /// Sets the flag's knob in `look`, or appends to it if the flag is repeatable.
    ///
    /// Fails with the value found and the value expected; the look is then unchanged.
    pub fn apply(&self, look: &mut Look, word: &str) -> Result<(), ParamError> {
        if !self.repeats {
            return pelage_params::set_word(look, self.key, word);
        }
        let mut added = Look::default();
        pelage_params::set_word(&mut added, self.key, word)?;
        look.light.fill.append(&mut added.light.fill);
        Ok(())
    }
}
