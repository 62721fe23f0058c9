//! User controls of camera, light and time.

use super::state::App;
use crate::subject::Subject;
use glam::{Quat, Vec2, Vec3};
use pelage_stage::{KeyLight, Meter, Navigator, wrap_time};
use serde_json::json;

impl App {
    /// Turns the key light about the target; `moved` is the pointer's movement right and up, in picture heights.
    pub fn turn_light(&mut self, moved: Vec2) {
        let KeyLight::Distant(towards) = self.look_now().key_light() else {
            return self.say("the light is a point light: change light.position_m instead".into());
        };
        let Ok(view) = self.show.view(self.area) else { return };
        let way = (view.target - view.eye).normalize_or(Vec3::NEG_Z);
        let right = way.cross(Vec3::Y).normalize_or(Vec3::X);
        let turn = Quat::from_rotation_y(std::f32::consts::PI * moved.x)
            * Quat::from_axis_angle(right, -std::f32::consts::PI * moved.y);
        let [x, y, z] = (turn * towards.normalize()).to_array();
        self.look_edits.set("light.direction", format!("[{x:.4}, {y:.4}, {z:.4}]"), true);
        self.moved();
        self.look_changed();
    }

    /// Moves the camera.
    pub fn move_camera(&mut self, how: impl FnOnce(&mut Navigator)) {
        if self.show.subject().is_none() {
            return;
        }
        match self.show.navigator(self.area) {
            Ok(navigator) => how(navigator),
            Err(error) => return self.fail(error.to_string()),
        }
        self.moved();
    }

    /// Frames the whole subject.
    pub fn frame(&mut self) {
        if let Err(error) = self.show.frame(self.area) {
            self.fail(error.to_string());
        }
        self.changed();
    }

    /// Resets the camera to its initial position.
    pub fn reset_camera(&mut self) {
        self.show.reset();
        self.changed();
    }

    /// Plays another clip from its beginning.
    pub fn play_clip(&mut self, clip: Option<usize>) {
        self.show.set_time(0.0);
        if let Err(error) = self.show.play(clip, self.area) {
            return self.fail(error.to_string());
        }
        self.playing = clip.is_some();
        self.changed();
    }

    /// Toggles playback. If no clip is chosen, plays the first one.
    pub fn toggle_playing(&mut self) {
        let has_clips = !self.show.clips().is_empty();
        if self.show.clip().is_none() && has_clips && !self.playing {
            return self.play_clip(Some(0));
        }
        self.playing = !self.playing && self.length_s().is_some();
    }

    /// Returns the length of the current animation, seconds; `None` if nothing moves.
    pub fn length_s(&self) -> Option<f32> {
        match self.show.subject()? {
            Subject::Package(_) => self.show.clip().map(|clip| clip.duration_s),
            // A scene has no end: its length is the current time, at least 10 s.
            Subject::Scene(_) => Some(self.show.time_s().max(10.0)),
        }
    }

    /// Returns the current time of the animation, seconds.
    pub fn moment_s(&self) -> f32 {
        let time_s = self.show.time_s();
        self.show.clip().map_or(time_s, |clip| wrap_time(time_s, clip.duration_s))
    }

    /// Seeks to a time and pauses.
    pub fn go_to(&mut self, time_s: f32) {
        self.playing = false;
        self.show.set_time(time_s);
        self.moved();
    }

    /// Shows or hides the reference image.
    pub fn toggle_truth(&mut self) {
        self.truth.toggle();
        self.workers.stop_tracing();
    }

    /// Measures the passes of the current view.
    pub fn measure(&mut self) {
        self.times = None;
        let Some(stage) = self.show.stage() else { return };
        let meter = Meter::new(&stage.gpu);
        match meter.measure(stage) {
            Ok(times) => {
                let passes: Vec<_> =
                    times.passes.iter().map(|(id, ms)| json!({ "name": id.name(), "ms": ms })).collect();
                self.events.log("measured", json!({ "frame_ms": times.frame, "passes": passes }));
                self.times = Some(times);
            }
            Err(error) => self.fail(error.to_string()),
        }
    }
}
