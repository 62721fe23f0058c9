//! Panels of knobs for look and recipe.

use super::knob;
use crate::app::App;
use crate::knobs::{Edits, Knobs, Search};
use egui::{CollapsingHeader, Grid, RichText, ScrollArea, TextEdit, Ui};

/// Knob of the look that is hidden, because the window determines the size itself.
const OF_THE_WINDOW: &str = "picture.size";

/// Draws the panel of the look.
pub fn look(ui: &mut Ui, app: &mut App) {
    ui.add_space(4.0);
    ui.horizontal(|ui| {
        ui.heading("Look");
        ui.weak("how the model is drawn");
    });
    ui.horizontal(|ui| {
        if ui.button("Save look").on_hover_text("writes all keys of the look, for `render --look`").clicked() {
            app.save_look();
        }
        if ui.button("Save picture").on_hover_text("same pixels as `pelage render` (P)").clicked() {
            app.save_picture();
        }
        if ui.button("Save sequence").on_hover_text("one cycle of the clip at 24 pictures per second").clicked() {
            app.save_sequence();
        }
    });
    let now = app.look_now();
    let mut edits = std::mem::take(&mut app.look_edits);
    let holds = |condition: &str| app.show.holds(condition);
    let mut search = std::mem::take(&mut app.look_search);
    let changed = tables(ui, &now, &mut edits, &mut search, &["picture", "light"], &holds);
    app.look_search = search;
    app.look_edits = edits;
    if changed {
        app.look_changed();
    }
}

/// Draws the panel of the recipe.
pub fn recipe(ui: &mut Ui, app: &mut App) {
    ui.add_space(4.0);
    ui.horizontal(|ui| {
        ui.heading("Recipe");
        ui.weak("how the model is baked");
    });
    ui.horizontal(|ui| {
        let save = ui
            .button("Save recipe")
            .on_hover_text("to the recipe file, keeping its comments, or to a new file next to the model (Ctrl S)");
        if save.clicked() {
            app.save_recipe();
        }
        if ui.button("Undo all").clicked() {
            app.recipe_edits.reset_all();
            app.recipe_changed();
        }
    });
    let Some(now) = app.recipe_now() else { return };
    let mut edits = std::mem::take(&mut app.recipe_edits);
    let changed = tables(ui, &*now, &mut edits, &mut app.recipe_search, &["hair"], &|_| true);
    app.recipe_edits = edits;
    if changed {
        app.recipe_changed();
    }
}

/// Draws all tables of a set of knobs. Returns whether the user changed anything.
///
/// * `search`: filters the knobs
/// * `open`: names of the tables that are expanded initially
/// * `holds`: whether a condition of the application holds
fn tables(
    ui: &mut Ui,
    now: &dyn Knobs,
    edits: &mut Edits,
    search: &mut Search,
    open: &[&str],
    holds: &dyn Fn(&str) -> bool,
) -> bool {
    ui.horizontal(|ui| {
        ui.add(TextEdit::singleline(&mut search.text).hint_text("find a key").desired_width(150.0));
        ui.checkbox(&mut search.only_changed, "only changed keys")
            .on_hover_text("only keys that differ from the default");
    });
    ui.separator();
    let mut changed = false;
    ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
        for table in now.tables() {
            let sought = |knob: &&'static pelage_params::Knob| {
                let text = search.text.to_lowercase();
                if knob.name == OF_THE_WINDOW {
                    return false;
                }
                let found = knob.name.contains(&text) || knob.doc.to_lowercase().contains(&text);
                found && (!search.only_changed || now.value(knob) != now.default_value(knob))
            };
            let knobs: Vec<_> = table.knobs.iter().filter(sought).collect();
            if knobs.is_empty() {
                continue;
            }
            let seeks = search.only_changed || !search.text.is_empty();
            let header = CollapsingHeader::new(RichText::new(title(table.name)).strong());
            let header = header.id_salt((table.name, seeks)).default_open(seeks || open.contains(&table.name));
            let answer = header.show(ui, |ui| {
                Grid::new(table.name).num_columns(2).spacing([8.0, 4.0]).show(ui, |ui| {
                    for knob in knobs {
                        changed |= knob::row(ui, (table, knob), now, edits, holds);
                    }
                });
            });
            answer.header_response.on_hover_text(table.doc.trim());
        }
    });
    if ui.input(|input| input.pointer.any_released()) {
        edits.released();
    }
    changed
}

fn title(name: &str) -> String {
    let mut letters = name.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}
