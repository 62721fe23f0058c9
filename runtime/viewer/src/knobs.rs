//! Knobs as a window shows them: whatever set they belong to, with what was changed by hand and can be undone.

use pelage_params::{Knob, TableInfo, Tables as _};
use pelage_stage::Look;

/// A set of knobs of which a window knows the declarations alone: a look, a recipe.
pub trait Knobs: Send {
    /// The tables, in order.
    fn tables(&self) -> &'static [TableInfo];

    /// The value of a knob as TOML, or `None` where it is left out.
    fn value(&self, knob: &Knob) -> Option<String>;

    /// The value that it has where nobody says one.
    fn default_value(&self, knob: &Knob) -> Option<String>;

    /// Sets one: `fur.layers=8`.
    ///
    /// # Errors
    ///
    /// What was found and what was expected; nothing is changed then.
    fn set(&mut self, assignment: &str) -> Result<(), String>;

    /// The same set again.
    fn boxed(&self) -> Box<dyn Knobs>;
}

impl Knobs for Look {
    fn tables(&self) -> &'static [TableInfo] {
        Self::TABLES
    }

    fn value(&self, knob: &Knob) -> Option<String> {
        knob.value(self)
    }

    fn default_value(&self, knob: &Knob) -> Option<String> {
        knob.value(&Self::of_picture())
    }

    fn set(&mut self, assignment: &str) -> Result<(), String> {
        Self::set(self, assignment).map_err(|error| error.reason)
    }

    fn boxed(&self) -> Box<dyn Knobs> {
        Box::new(self.clone())
    }
}

/// A change by hand: a knob and the value that it was given, as TOML.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Edit {
    /// `table.key`.
    pub key: &'static str,
    /// As TOML.
    pub value: String,
}

impl Edit {
    /// As [`Knobs::set`] takes it.
    pub fn assignment(&self) -> String {
        format!("{}={}", self.key, self.value)
    }
}

/// What was changed by hand over what files say. Of each key there is one edit, the last.
#[derive(Clone, Debug, Default)]
pub struct Edits {
    now: Vec<Edit>,
    past: Vec<Vec<Edit>>,
    future: Vec<Vec<Edit>>,
    /// The key that is being dragged: all of the drag is one step to undo.
    dragged: Option<&'static str>,
}

impl Edits {
    /// The edits, in the order in which their keys were first touched.
    pub fn all(&self) -> &[Edit] {
        &self.now
    }

    /// As [`Knobs::set`] takes them.
    pub fn assignments(&self) -> Vec<String> {
        self.now.iter().map(Edit::assignment).collect()
    }

    /// Whether a key was changed.
    pub fn has(&self, key: &str) -> bool {
        self.now.iter().any(|edit| edit.key == key)
    }

    /// Gives a key another value. `dragging` says that more of the same change will follow, until [`Self::released`].
    pub fn set(&mut self, key: &'static str, value: String, dragging: bool) {
        if self.dragged != Some(key) {
            self.remember();
        }
        self.dragged = dragging.then_some(key);
        match self.now.iter_mut().find(|edit| edit.key == key) {
            Some(edit) => edit.value = value,
            None => self.now.push(Edit { key, value }),
        }
    }

    /// The hand let go of what it dragged.
    pub fn released(&mut self) {
        self.dragged = None;
    }

    /// Gives a key the value back that files say.
    pub fn reset(&mut self, key: &str) {
        if self.has(key) {
            self.remember();
            self.now.retain(|edit| edit.key != key);
        }
    }

    /// Drops all edits, as one step to undo.
    pub fn reset_all(&mut self) {
        if !self.now.is_empty() {
            self.remember();
            self.now.clear();
        }
    }

    /// Takes the last step back; says whether there was one.
    pub fn undo(&mut self) -> bool {
        Self::step(&mut self.past, &mut self.now, &mut self.future)
    }

    /// Takes the last step that was taken back again.
    pub fn redo(&mut self) -> bool {
        Self::step(&mut self.future, &mut self.now, &mut self.past)
    }

    /// Begins anew over other files.
    pub fn forget(&mut self) {
        *self = Self::default();
    }

    fn step(from: &mut Vec<Vec<Edit>>, now: &mut Vec<Edit>, to: &mut Vec<Vec<Edit>>) -> bool {
        let Some(state) = from.pop() else { return false };
        to.push(std::mem::replace(now, state));
        true
    }

    fn remember(&mut self) {
        self.dragged = None;
        self.past.push(self.now.clone());
        self.future.clear();
    }
}

/// What is sought among knobs.
#[derive(Clone, Debug, Default)]
pub struct Search {
    /// Part of a name or of what it means.
    pub text: String,
    /// Whether knobs that have their default are left out.
    pub only_changed: bool,
}

/// The word of a string in TOML, as a text field shows it; anything else as it stands.
pub fn shown(toml: &str) -> String {
    match toml.strip_prefix('"').and_then(|text| text.strip_suffix('"')) {
        Some(word) if !word.contains(['"', '\\']) => word.to_owned(),
        _ => toml.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
    use super::*;

    fn state(edits: &Edits) -> String {
        edits.assignments().join(" ")
    }

    #[test]
    fn a_drag_is_one_step_and_steps_go_both_ways() {
        let mut edits = Edits::default();
        edits.set("a.b", "1".into(), true);
        edits.set("a.b", "2".into(), true);
        edits.released();
        edits.set("a.c", "3".into(), false);
        edits.reset("a.b");
        assert_eq!(state(&edits), "a.c=3");
        assert!(edits.undo());
        assert_eq!(state(&edits), "a.b=2 a.c=3");
        assert!(edits.undo() && edits.undo());
        assert_eq!(state(&edits), "", "the whole drag");
        assert!(!edits.undo());
        assert!(edits.redo() && edits.redo() && edits.redo() && !edits.redo());
        assert_eq!(state(&edits), "a.c=3");
        edits.undo();
        edits.set("a.d", "4".into(), false);
        assert!(!edits.redo(), "what was undone is gone once something else is done");
    }

    #[test]
    fn every_knob_of_a_look_can_be_written_and_set_again() {
        let look = Look::default();
        let knobs: &dyn Knobs = &look;
        let mut other = knobs.boxed();
        let mut set = 0;
        for knob in knobs.tables().iter().flat_map(|table| table.knobs) {
            if let Some(value) = knobs.value(knob) {
                other.set(&format!("{}={value}", knob.name)).unwrap();
                assert_eq!(other.value(knob).unwrap(), value);
                set += 1;
            }
        }
        assert!(set > 20);
        assert!(other.set("fur.layers=0").unwrap_err().contains("1..=1024"));
    }

    #[test]
    fn words_are_shown_without_quotes() {
        assert_eq!(["\"fur\"", "0.5", "[1, 2]", "\"a\\\"b\""].map(shown), ["fur", "0.5", "[1, 2]", "\"a\\\"b\""]);
    }
}
