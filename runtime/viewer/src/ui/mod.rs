//! Layout of the window: the picture between panels of knobs, and the time line below.

mod below;
mod help;
mod knob;
mod panel;
mod picture;

use crate::app::App;
use egui::{CentralPanel, Frame, Key, Modifiers, Panel, TextureId, Ui};

/// Lays out the window around the drawn picture, and handles input.
pub fn lay_out(ui: &mut Ui, app: &mut App, drawn: Option<TextureId>) {
    keys(ui, app);
    if app.panels {
        Panel::left("look").resizable(true).default_size(290.0).show(ui, |ui| panel::look(ui, app));
        if app.has_recipe() {
            Panel::right("recipe").resizable(true).default_size(310.0).show(ui, |ui| panel::recipe(ui, app));
        }
        Panel::bottom("time").show(ui, |ui| below::show(ui, app));
    }
    CentralPanel::default().frame(Frame::NONE).show(ui, |ui| picture::show(ui, app, drawn));
    if app.help {
        help::show(ui, app);
    }
}

/// Handles keys that work wherever the pointer is. Keys that move the camera are handled by the picture.
fn keys(ui: &mut Ui, app: &mut App) {
    if ui.ctx().egui_wants_keyboard_input() {
        return;
    }
    let pressed = |key| ui.input_mut(|input| input.consume_key(Modifiers::NONE, key));
    let held = |key| ui.input_mut(|input| input.consume_key(Modifiers::COMMAND, key));
    let shifted = |key| ui.input_mut(|input| input.consume_key(Modifiers::COMMAND | Modifiers::SHIFT, key));
    // Shortcuts with Shift are tested first, because those without Shift also match when it is held.
    if shifted(Key::Z) {
        app.redo();
    }
    if held(Key::Z) {
        app.undo();
    }
    if held(Key::S) {
        app.save_recipe();
    }
    for (key, act) in help::KEYS.iter().filter_map(|line| line.act) {
        if pressed(key) {
            act(app);
        }
    }
}
