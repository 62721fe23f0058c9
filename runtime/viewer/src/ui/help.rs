//! Keyboard and mouse controls of the window, for input handling and for the help.

use crate::app::App;
use egui::{Grid, Key, RichText, Ui, Window};
use pelage_stage::LookStyle;

/// Action of a key on the application.
pub type Act = fn(&mut App);

/// Line of the help.
pub struct Line {
    keys: &'static str,
    does: &'static str,
    /// Key and its action. `None` for mouse input and key combinations, which are handled elsewhere.
    pub act: Option<(Key, Act)>,
}

const fn line(keys: &'static str, does: &'static str, key: Key, act: Act) -> Line {
    Line { keys, does, act: Some((key, act)) }
}

const fn help_line(keys: &'static str, does: &'static str) -> Line {
    Line { keys, does, act: None }
}

/// Lines of the help, in order.
pub const KEYS: &[Line] = &[
    help_line("drag", "orbits"),
    help_line("right drag, Shift drag", "pans"),
    help_line("wheel, pinch", "moves closer or away, towards the pointer"),
    help_line("Ctrl drag", "rotates the light"),
    help_line("Alt drag", "turns the view"),
    help_line("W A S D, Q E", "flies; faster with Shift"),
    help_line("arrows", "orbit"),
    line("F", "frames all models", Key::F, App::frame),
    line("R", "resets the camera", Key::R, App::reset_camera),
    line("Space", "plays or stops the clip", Key::Space, App::toggle_playing),
    line("T", "shows the reference image and FLIP", Key::T, App::toggle_truth),
    line("1", "fur", Key::Num1, |app| app.set_style(LookStyle::Fur)),
    line("2", "ink", Key::Num2, |app| app.set_style(LookStyle::Ink)),
    line("3", "bare skin", Key::Num3, |app| app.set_style(LookStyle::Bare)),
    line("M", "measures the passes of this view", Key::M, App::measure),
    line("Page Down", "opens the next file of the folder", Key::PageDown, |app| app.open_next(false)),
    line("Page Up", "opens the previous file", Key::PageUp, |app| app.open_next(true)),
    line("P", "saves the picture", Key::P, App::save_picture),
    line("F12", "saves a screenshot of the window", Key::F12, App::save_window),
    help_line("Ctrl S", "saves the recipe"),
    help_line("Ctrl Z, Ctrl Shift Z", "undo, redo"),
    line("N", "shows or hides the panels", Key::N, |app| app.panels = !app.panels),
    line("H, F1", "shows this list", Key::H, |app| app.help = !app.help),
    Line { keys: "", does: "", act: Some((Key::F1, |app| app.help = !app.help)) },
];

/// Shows the help in its own window.
pub fn show(ui: &mut Ui, app: &mut App) {
    let mut open = app.help;
    Window::new("Keys").open(&mut open).resizable(false).collapsible(false).show(ui, |ui| {
        Grid::new("keys").num_columns(2).spacing([16.0, 4.0]).show(ui, |ui| {
            for line in KEYS.iter().filter(|line| !line.keys.is_empty()) {
                ui.label(RichText::new(line.keys).strong());
                ui.label(line.does);
                ui.end_row();
            }
        });
        ui.separator();
        ui.label("Files can be dropped into the window: packages, models, recipes, looks, scenes.");
    });
    app.help = open;
}
