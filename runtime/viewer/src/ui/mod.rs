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

#[cfg(test)]
mod tests {
    use crate::knobs::Knobs as _;
    use egui::FontId;
    use egui::epaint::text::{FontDefinitions, Fonts, TextOptions};
    use pelage_stage::{CONDITIONS, Look};
    use std::path::Path;

    fn read_all(folder: &Path, text: &mut String) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                read_all(&path, text);
            } else {
                text.push_str(&std::fs::read_to_string(&path).unwrap());
            }
        }
    }

    #[test]
    fn fonts_have_every_character_of_the_windows_texts() {
        let manifest = Path::new(env!("CARGO_MANIFEST_DIR"));
        let mut text = String::new();
        read_all(&manifest.join("src"), &mut text);
        // The recipe's meanings are shown as well; the window knows them only at run time.
        text.push_str(&std::fs::read_to_string(manifest.join("../../bake/docs/recipe.md")).unwrap());
        for table in Look::default().tables() {
            text.push_str(table.doc);
            table.knobs.iter().for_each(|knob| text.extend([knob.doc.to_owned(), (knob.expected)()]));
        }
        text.extend(CONDITIONS.map(|(_, reason)| reason));
        // Characters that the sources write as escapes.
        let escaped: Vec<&str> = text.split("\\u{").skip(1).filter_map(|rest| rest.split('}').next()).collect();
        let escaped = escaped.iter().filter_map(|hex| char::from_u32(u32::from_str_radix(hex, 16).ok()?));
        let all: std::collections::BTreeSet<char> =
            text.chars().chain(escaped).filter(|c| !c.is_ascii_control()).collect();
        let mut fonts = Fonts::new(TextOptions::default(), FontDefinitions::default());
        let mut fonts = fonts.with_pixels_per_point(1.0);
        let mut has = |c: char| fonts.has_glyph(&FontId::proportional(14.0), c);
        assert!(!has('\u{27f2}'), "the test finds no missing character");
        let missing: Vec<char> = all.into_iter().filter(|c| *c != '\u{27f2}' && !has(*c)).collect();
        assert!(missing.is_empty(), "no font of the window has {missing:?}");
    }
}
