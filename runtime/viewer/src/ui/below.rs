//! Panel below the picture: clip and its time, style, and statistics of the last frame.

use crate::app::App;
use egui::{ComboBox, DragValue, RichText, Slider, Ui};
use pelage_stage::{Look, LookStyle};
use std::path::Path;

/// Draws the panel.
pub fn show(ui: &mut Ui, app: &mut App) {
    ui.add_space(3.0);
    ui.horizontal(|ui| {
        styles(ui, app);
        ui.separator();
        clip(ui, app);
    });
    ui.horizontal_wrapped(|ui| figures(ui, app));
    if let Some(times) = &app.times {
        ui.horizontal_wrapped(|ui| {
            ui.label(RichText::new(format!("frame {:.1} ms:", times.frame)).strong());
            for (pass, ms) in times.passes.iter().filter(|(_, ms)| *ms > 0.0) {
                ui.label(format!("{} {ms:.1}", pass.name()));
            }
        });
    }
    ui.add_space(2.0);
}

fn styles(ui: &mut Ui, app: &mut App) {
    let look = app.look_now();
    let now = look.picture.style;
    for (style, word) in [(LookStyle::Fur, "Fur"), (LookStyle::Ink, "Ink"), (LookStyle::Bare, "Bare")] {
        if ui.selectable_label(now == style, word).clicked() {
            app.set_style(style);
        }
    }
    if now == LookStyle::Ink {
        ink_styles(ui, app, look.ink_style());
    }
}

/// Draws the choice of a style of ink. `now` is its name, `None` for knobs that are no style's.
fn ink_styles(ui: &mut Ui, app: &mut App, now: Option<&str>) {
    let mut chosen = None;
    let choice = ComboBox::from_id_salt("ink style").selected_text(now.unwrap_or("own")).width(80.0);
    choice.show_ui(ui, |ui| {
        for (name, about) in Look::ink_styles() {
            if ui.selectable_label(now == Some(name), name).on_hover_text(about).clicked() {
                chosen = Some(name);
            }
        }
    });
    if let Some(name) = chosen {
        app.set_ink_style(name);
    }
}

fn clip(ui: &mut Ui, app: &mut App) {
    let clips: Vec<String> = app.show.clips().iter().map(|clip| clip.name.clone()).collect();
    let now = app.show.clip().cloned();
    if !clips.is_empty() {
        let word = now.as_ref().map_or("at rest", |clip| clip.name.as_str());
        let mut chosen = None;
        ComboBox::from_id_salt("clip").selected_text(word).width(130.0).show_ui(ui, |ui| {
            if ui.selectable_label(now.is_none(), "at rest").clicked() {
                chosen = Some(None);
            }
            for (i, name) in clips.iter().enumerate() {
                if ui.selectable_label(now.as_ref().is_some_and(|clip| clip.name == *name), name).clicked() {
                    chosen = Some(Some(i));
                }
            }
        });
        if let Some(clip) = chosen {
            app.play_clip(clip);
        }
    }
    let Some(length_s) = app.length_s() else {
        ui.weak("no animation");
        return;
    };
    if ui.button(if app.playing { "Stop" } else { "Play" }).on_hover_text("Space").clicked() {
        app.toggle_playing();
    }
    let mut time_s = app.moment_s();
    ui.spacing_mut().slider_width = (ui.available_width() - 220.0).max(60.0);
    let slider = Slider::new(&mut time_s, 0.0..=length_s.max(1e-3)).fixed_decimals(2).suffix(" s");
    if ui.add(slider).changed() {
        app.go_to(time_s);
    }
    ui.label("speed");
    ui.add(DragValue::new(&mut app.speed).range(-4.0..=4.0).speed(0.01).max_decimals(2).suffix("×"));
}

fn figures(ui: &mut Ui, app: &mut App) {
    let weak = |ui: &mut Ui, text: String| ui.label(RichText::new(text).weak().small());
    if let Some(subject) = app.show.subject() {
        let file = Path::new(subject.name()).file_name().unwrap_or_default().to_string_lossy();
        let answer = weak(ui, format!("{file}  {:.1} MiB", subject.bytes() as f64 / f64::from(1 << 20)));
        answer.on_hover_text(subject.name());
    }
    if let Some(last) = app.show.last() {
        let ms = 1e3 * last.took.as_secs_f64();
        weak(ui, format!("{}×{}  {ms:.1} ms  {:.1} MiB on the device", last.size.0, last.size.1, app.gpu_mib()));
        if let Some(detail) = last.report.instances.first() {
            let share = |share: f32| format!("{:.0} %", 100.0 * share);
            weak(
                ui,
                format!(
                    "layers {} of {}  strands {}  far layer {}  fins {}  level {}",
                    detail.layers,
                    detail.of_layers,
                    share(detail.strands),
                    share(detail.coat),
                    share(detail.fins),
                    detail.level
                ),
            );
        }
    }
    if !app.stages.is_empty() {
        let all: f64 = app.stages.iter().map(|(_, seconds)| seconds).sum();
        let names: Vec<String> = app.stages.iter().map(|(name, seconds)| format!("{name} {seconds:.2}")).collect();
        weak(ui, format!("baked in {all:.2} s ({})", names.join(", ")));
    }
    weak(ui, app.adapter.clone());
    if !app.notes.is_empty() {
        weak(ui, format!("{} notes", app.notes.len())).on_hover_ui(|ui| {
            ui.set_max_width(460.0);
            app.notes.iter().for_each(|note| drop(ui.label(note)));
        });
    }
    weak(ui, "H: keys".into());
}
