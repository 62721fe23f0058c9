//! Edits of the look's and the recipe's knobs, and undo.

use super::state::App;
use crate::knobs::{Edits, Knobs};
use pelage_stage::{Look, LookStyle};

fn nothing_to_undo(changed_outside: bool) -> &'static str {
    if changed_outside {
        "nothing to undo here: the recipe's file was changed outside this window; undo that where it was changed"
    } else {
        "nothing to undo: no key was changed since the files were opened or saved"
    }
}

impl App {
    /// Returns the look with all edits.
    pub fn look_now(&self) -> Look {
        let mut look = self.look_base.clone();
        for assignment in self.look_edits.assignments() {
            // Each assignment was accepted before, so none can fail.
            let _ = look.set(&assignment);
        }
        // Errors in the file are reported when the user selects it.
        let _ = self.lights.apply_to(&mut look);
        look
    }

    /// Applies the look after a change.
    pub fn look_changed(&mut self) {
        self.recipe_last = false;
        self.changed_outside = false;
        let look = self.look_now();
        let refused = self.refused_look_edits();
        if let Err(error) = self.show.set_look(look, self.area) {
            return self.fail(error.to_string());
        }
        match refused {
            Some(reason) => self.fail(reason),
            None => self.clear_failure(),
        }
        if let Err(reason) = self.lights.apply_to(&mut self.look_now()) {
            self.fail(format!("environment.sky: {reason}"));
        }
        self.changed();
    }

    fn refused_look_edits(&self) -> Option<String> {
        let mut look = self.look_base.clone();
        let refuse = |edit: String| look.set(&edit).err().map(|error| format!("look: {error}"));
        self.look_edits.assignments().into_iter().find_map(refuse)
    }

    /// Returns whether the subject is baked with a recipe.
    pub fn has_recipe(&self) -> bool {
        self.recipe_base.is_some()
    }

    /// Returns the recipe with all edits.
    pub fn recipe_now(&self) -> Option<Box<dyn Knobs>> {
        let mut recipe = self.recipe_base.as_ref()?.boxed();
        for assignment in self.recipe_edits.assignments() {
            // The bake reports an invalid edit.
            let _ = recipe.set(&assignment);
        }
        Some(recipe)
    }

    /// Rebakes the model after a change of the recipe.
    pub fn recipe_changed(&mut self) {
        self.recipe_last = true;
        self.changed_outside = false;
        self.workers.make(self.recipe_edits.assignments());
    }

    /// Undoes the last change; says why if there is none.
    pub fn undo(&mut self) {
        if !self.step(Edits::undo) {
            self.say(nothing_to_undo(self.changed_outside).into());
        }
    }

    /// Redoes the last undone change; says so if there is none.
    pub fn redo(&mut self) {
        if !self.step(Edits::redo) {
            self.say("nothing to redo".into());
        }
    }

    fn step(&mut self, step: fn(&mut Edits) -> bool) -> bool {
        let recipe_first = self.recipe_last;
        for of_recipe in [recipe_first, !recipe_first] {
            let edits = if of_recipe { &mut self.recipe_edits } else { &mut self.look_edits };
            if step(edits) {
                if of_recipe {
                    self.recipe_changed();
                } else {
                    self.look_changed();
                }
                return true;
            }
        }
        false
    }

    /// Changes the rendering style.
    pub fn set_style(&mut self, style: LookStyle) {
        self.look_edits.set("picture.style", format!("{:?}", style.word()), false);
        self.look_edits.released();
        self.look_changed();
    }

    /// Changes the style of ink to a built-in look, as one undo step.
    pub fn set_ink_style(&mut self, name: &str) {
        let now = self.look_now();
        let mut styled = now.clone();
        if styled.set_ink_style(name) {
            self.look_edits.set_all(&now, &styled);
            self.look_changed();
        }
    }
}
