//! Knobs as shown in a window, with the user's edits and undo. Works with any set of knobs.

use pelage_params::{Knob, TableInfo, Tables as _};
use pelage_stage::Look;

/// Set of knobs, such as a look or a recipe. The window knows it only by the declarations of its knobs.
pub trait Knobs: Send {
    /// Returns the tables of knobs, in order.
    fn tables(&self) -> &'static [TableInfo];

    /// Returns the value of a knob as TOML, or `None` if it is unset.
    fn value(&self, knob: &Knob) -> Option<String>;

    /// Returns the effective value of a knob while it is unset.
    fn default_value(&self, knob: &Knob) -> Option<String>;

    /// Returns the value of the knob with a full name as TOML, or `None` if it is unset.
    fn value_of(&self, name: &str) -> Option<String> {
        let knob = self.tables().iter().flat_map(|table| table.knobs).find(|knob| knob.name == name)?;
        self.value(knob)
    }

    /// Returns whether all values are equal to those of another set of the same kind.
    fn equals(&self, other: &dyn Knobs) -> bool {
        self.tables().iter().flat_map(|table| table.knobs).all(|knob| self.value(knob) == other.value(knob))
    }

    /// Sets a knob: `fur.layers=8`.
    ///
    /// Fails with the value found and the values expected. The set is then unchanged.
    fn set(&mut self, assignment: &str) -> Result<(), String>;

    /// Returns a boxed clone of the set.
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

/// User edit: a knob and its new value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Edit {
    /// Key, `table.key`.
    pub key: &'static str,
    /// Value as TOML.
    pub value: String,
}

impl Edit {
    /// Returns the edit as an argument of [`Knobs::set`].
    pub fn assignment(&self) -> String {
        format!("{}={}", self.key, self.value)
    }
}

/// User edits on top of the values in files. Only the last edit of each key is kept.
#[derive(Clone, Debug, Default)]
pub struct Edits {
    now: Vec<Edit>,
    past: Vec<Vec<Edit>>,
    future: Vec<Vec<Edit>>,
    /// Key being dragged; a whole drag is one undo step.
    dragged: Option<&'static str>,
}

impl Edits {
    /// Returns the edits, in the order in which their keys were first edited.
    pub fn all(&self) -> &[Edit] {
        &self.now
    }

    /// Returns the edits as arguments of [`Knobs::set`].
    pub fn assignments(&self) -> Vec<String> {
        self.now.iter().map(Edit::assignment).collect()
    }

    /// Returns true if a key has an edit.
    pub fn has(&self, key: &str) -> bool {
        self.now.iter().any(|edit| edit.key == key)
    }

    /// Sets a key to a value. If `dragging`, more changes of the same drag follow, until [`Self::released`].
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

    /// Sets the values of all knobs of `to` that differ from `now`, as one undo step.
    pub fn set_all(&mut self, now: &dyn Knobs, to: &dyn Knobs) {
        let knobs = to.tables().iter().flat_map(|table| table.knobs);
        let edit = |knob: &'static Knob| {
            let value = to.value(knob).or_else(|| to.default_value(knob)).unwrap_or_default();
            (now.value(knob) != to.value(knob)).then_some(Edit { key: knob.name, value })
        };
        let edits: Vec<Edit> = knobs.filter_map(edit).collect();
        if !edits.is_empty() {
            self.remember();
            self.now.retain(|old| edits.iter().all(|edit| edit.key != old.key));
            self.now.extend(edits);
        }
    }

    /// Ends a drag.
    pub fn released(&mut self) {
        self.dragged = None;
    }

    /// Resets a key to its value in the files.
    pub fn reset(&mut self, key: &str) {
        if self.has(key) {
            self.remember();
            self.now.retain(|edit| edit.key != key);
        }
    }

    /// Drops all edits, as one undo step.
    pub fn reset_all(&mut self) {
        if !self.now.is_empty() {
            self.remember();
            self.now.clear();
        }
    }

    /// Undoes the last step; returns whether there was one.
    pub fn undo(&mut self) -> bool {
        Self::step(&mut self.past, &mut self.now, &mut self.future)
    }

    /// Redoes the last undone step; returns whether there was one.
    pub fn redo(&mut self) -> bool {
        Self::step(&mut self.future, &mut self.now, &mut self.past)
    }

    /// Clears edits and history when other files are opened.
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

/// Search among knobs.
#[derive(Clone, Debug, Default)]
pub struct Search {
    /// Text to find in the name or meaning of a knob.
    pub text: String,
    /// Whether to hide knobs with their default value.
    pub only_changed: bool,
}

/// Returns a TOML string without its quotes, for a text field. Returns other values unchanged.
pub fn shown(toml: &str) -> String {
    match toml.strip_prefix('"').and_then(|text| text.strip_suffix('"')) {
        Some(word) if !word.contains(['"', '\\']) => word.to_owned(),
        _ => toml.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state(edits: &Edits) -> String {
        edits.assignments().join(" ")
    }

    #[test]
    fn drag_is_one_undo_step_and_can_be_redone() {
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
        assert_eq!(state(&edits), "", "undo must revert the whole drag");
        assert!(!edits.undo());
        assert!(edits.redo() && edits.redo() && edits.redo() && !edits.redo());
        assert_eq!(state(&edits), "a.c=3");
        edits.undo();
        edits.set("a.d", "4".into(), false);
        assert!(!edits.redo(), "a new change must clear the undone ones");
    }

    #[test]
    fn ink_style_is_one_undo_step() {
        let mut edits = Edits::default();
        edits.set("brush.wash", "0.5".into(), false);
        let look = |edits: &Edits| {
            let mut look = Look::default();
            edits.assignments().iter().for_each(|edit| look.set(edit).unwrap());
            look
        };
        for style in ["gongbi", "xieyi", pelage_stage::DEFAULT_INK] {
            let now = look(&edits);
            let mut to = now.clone();
            assert!(to.set_ink_style(style));
            edits.set_all(&now, &to);
            assert_eq!(look(&edits), to, "{style}");
        }
        assert!(edits.undo() && edits.undo() && edits.undo());
        assert_eq!(state(&edits), "brush.wash=0.5");
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
    fn sets_are_equal_if_all_values_are() {
        let look = Look::default();
        let mut other = Knobs::boxed(&look);
        assert!(look.equals(&*other));
        other.set("ink.tone=0.5").unwrap();
        assert!(!look.equals(&*other));
    }

    #[test]
    fn words_are_shown_without_quotes() {
        assert_eq!(["\"fur\"", "0.5", "[1, 2]", "\"a\\\"b\""].map(shown), ["fur", "0.5", "[1, 2]", "\"a\\\"b\""]);
    }
}
