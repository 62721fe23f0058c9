//! Picture in the centre, its mouse and key input, and its overlay: messages, progress and the reference image.

use crate::app::App;
use egui::{
    Align2, Color32, FontId, Key, Pos2, ProgressBar, Rect, Response, RichText, Sense, TextureId, Ui, Vec2, pos2, vec2,
};

/// Colour behind a transparent picture.
const BEHIND: Color32 = Color32::from_rgb(58, 61, 66);
const BAD: Color32 = Color32::from_rgb(120, 32, 28);
/// Scroll distance that doubles the magnification, points: wheel notches or touchpad movement.
const POINTS_TO_DOUBLE: f32 = 300.0;
/// Speed of flight while a key is held, picture heights per second.
const FLIGHT: f32 = 0.6;

/// Draws the picture, and the reference image beside it if requested.
pub fn show(ui: &mut Ui, app: &mut App, drawn: Option<TextureId>) {
    let all = ui.available_rect_before_wrap();
    ui.painter().rect_filled(all, 0.0, BEHIND);
    let columns = if app.truth.is_shown() { 3.0 } else { 1.0 };
    let width = all.width() / columns;
    let column = |i: f32| Rect::from_min_size(pos2(all.left() + i * width, all.top()), vec2(width, all.height()));
    app.set_area(column(0.0), ui.ctx().pixels_per_point());
    let first = ui.interact(column(0.0), ui.scope_id().with("picture"), Sense::click_and_drag());
    mouse_input(ui, app, &first);
    if let Some(picture) = drawn {
        ui.painter().image(picture, column(0.0), whole(), Color32::WHITE);
    }
    if app.truth.is_shown() {
        truth(ui, app, [0.0, 1.0, 2.0].map(column));
    }
    if app.show.subject().is_none() && app.failure.is_none() && app.working.is_none() {
        let text = "Drop a package (.pelage), a model (.glb, .gltf, .obj) or a scene (.toml) here";
        ui.painter().text(all.center(), Align2::CENTER_CENTER, text, FontId::proportional(18.0), Color32::GRAY);
    }
    overlay(ui, app, all);
}

fn whole() -> Rect {
    Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0))
}

/// Draws the reference image, and the FLIP map of the rendered picture against it.
fn truth(ui: &mut Ui, app: &mut App, [drawn, traced, flip]: [Rect; 3]) {
    let tag = |ui: &Ui, rect: Rect, text: &str| {
        let at = rect.left_top() + vec2(8.0, 6.0);
        ui.painter().text(at, Align2::LEFT_TOP, text, FontId::proportional(14.0), Color32::WHITE);
    };
    let painter = ui.painter().clone();
    let truth = &app.truth;
    if let Some((picture, map)) = truth.textures() {
        painter.image(picture, traced, whole(), Color32::WHITE);
        if let Some(map) = map {
            painter.image(map, flip, whole(), Color32::WHITE);
        }
    }
    tag(ui, drawn, "drawn");
    tag(ui, traced, &truth.status_text());
    tag(ui, flip, &truth.flip_text());
    for x in [traced.left(), flip.left()] {
        painter.vline(x, traced.y_range(), ui.visuals().widgets.noninteractive.bg_stroke);
    }
}

fn mouse_input(ui: &mut Ui, app: &mut App, picture: &Response) {
    let rect = picture.rect;
    let height = rect.height().max(1.0);
    let (moved, modifiers) = (picture.drag_delta(), ui.input(|input| input.modifiers));
    // The picture's y axis points up, the screen's down.
    let moved = glam::Vec2::new(moved.x, -moved.y) / height;
    if picture.dragged() && moved != glam::Vec2::ZERO {
        let sideways = picture.dragged_by(egui::PointerButton::Secondary)
            || picture.dragged_by(egui::PointerButton::Middle)
            || modifiers.shift;
        if modifiers.command {
            app.turn_light(moved);
        } else if modifiers.alt {
            app.move_camera(|camera| camera.turn(moved));
        } else if sideways {
            app.move_camera(|camera| camera.pan(moved));
        } else {
            app.move_camera(|camera| camera.orbit(moved));
        }
    }
    if let Some(at) = picture.hover_pos() {
        let from_middle = at - rect.center();
        let at = glam::Vec2::new(from_middle.x, -from_middle.y) / height;
        let (scroll, pinch) = ui.input(|input| (input.smooth_scroll_delta, input.zoom_delta()));
        if modifiers.shift && scroll != Vec2::ZERO {
            app.move_camera(|camera| camera.pan(glam::Vec2::new(scroll.x, -scroll.y) / height));
        } else if pinch != 1.0 {
            app.move_camera(|camera| camera.zoom(pinch, at));
        } else if scroll.y != 0.0 {
            app.move_camera(|camera| camera.zoom((scroll.y / POINTS_TO_DOUBLE).exp2(), at));
        }
    }
    if picture.double_clicked() {
        app.frame();
    }
    if !ui.ctx().egui_wants_keyboard_input() {
        flight(ui, app);
    }
}

/// Handles keys that move the camera while they are held.
fn flight(ui: &mut Ui, app: &mut App) {
    let (held, seconds, fast) = ui.input(|input| {
        let down = |key| f32::from(u8::from(input.key_down(key)));
        let along = |more, less| down(more) - down(less);
        let fly = [along(Key::D, Key::A), along(Key::E, Key::Q), along(Key::W, Key::S)];
        let go = [along(Key::ArrowRight, Key::ArrowLeft), along(Key::ArrowUp, Key::ArrowDown)];
        let command = input.modifiers.command;
        ((if command { [0.0; 3] } else { fly }, go), input.stable_dt.min(0.1), input.modifiers.shift)
    });
    let (fly, go) = held;
    if fly != [0.0; 3] {
        let way = FLIGHT * seconds * if fast { 5.0 } else { 1.0 };
        app.move_camera(|camera| {
            let [right, up, ahead] = fly.map(|way_on| way_on * way * camera.height_m());
            camera.fly(right, up, ahead);
        });
    }
    if go != [0.0; 2] {
        // The camera moves in the direction of the arrow key, so the subject appears to turn the opposite way.
        let turn = -glam::Vec2::from(go) * 0.4 * seconds;
        app.move_camera(|camera| camera.orbit(turn));
    }
    if fly != [0.0; 3] || go != [0.0; 2] {
        ui.ctx().request_repaint();
    }
}

/// Draws the overlay on the picture.
fn overlay(ui: &mut Ui, app: &mut App, all: Rect) {
    let at = Rect::from_min_max(all.left_bottom() - vec2(-10.0, 120.0), all.right_bottom() - vec2(10.0, 8.0));
    ui.scope_builder(egui::UiBuilder::new().max_rect(at).layout(egui::Layout::bottom_up(egui::Align::LEFT)), |ui| {
        if let Some(failure) = &app.failure {
            let text = RichText::new(failure.trim()).color(Color32::WHITE);
            egui::Frame::popup(ui.style())
                .fill(BAD)
                .show(ui, |ui| ui.add(egui::Label::new(text).wrap().selectable(true)));
        }
        if let Some(working) = &app.working {
            let bar = match working.share {
                Some(share) => ProgressBar::new(share).text(&working.doing),
                None => ProgressBar::new(0.0).animate(true).text(&working.doing),
            };
            ui.add(bar.desired_width(260.0));
        }
        if let Some(said) = app.said() {
            ui.label(RichText::new(said).color(Color32::WHITE));
        }
    });
}
