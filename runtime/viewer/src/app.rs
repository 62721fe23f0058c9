//! What a window is about: what is shown, how, and what hands changed. It draws nothing of its own.

use crate::knobs::{Edits, Knobs, Search};
use crate::save;
use crate::script::{Events, Style};
use crate::show::Show;
use crate::subject::Subject;
use crate::truth::TruthBeside;
use crate::worker::{Told, Workers};
use crate::workshop::{Made, Progress, TruthAsked};
use egui::{Context, Rect};
use glam::{Quat, Vec2, Vec3};
use pelage_stage::{FrameTimes, KeyLight, Look, Meter, Navigator, StageError, within};
use serde_json::json;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// So long after the last movement pictures of a software device stay small.
const SETTLES: Duration = Duration::from_millis(220);
/// So long something that was said stands there.
const SAID: Duration = Duration::from_secs(6);
/// Pictures a second of a sequence that is saved.
const FPS: f32 = 24.0;

/// Everything but the window itself.
pub struct App {
    /// What is shown.
    pub show: Show,
    workers: Workers,
    /// Of scripts and tests.
    pub events: Events,
    /// Where pictures are saved.
    folder: PathBuf,
    /// The file that was opened last.
    opened: Option<PathBuf>,
    look_base: Look,
    /// Changes of the look.
    pub look_edits: Edits,
    pub look_search: Search,
    recipe_base: Option<Box<dyn Knobs>>,
    /// Changes of the recipe.
    pub recipe_edits: Edits,
    pub recipe_search: Search,
    /// Whether the recipe's edits were the last to be changed: what an undo is about.
    recipe_last: bool,
    /// What is being made.
    pub working: Option<Progress>,
    /// What is wrong; it stands there until it is mended.
    pub failure: Option<String>,
    /// What the bake had to say.
    pub notes: Vec<String>,
    /// Stages of the last bake with their seconds.
    pub stages: Vec<(String, f64)>,
    /// Passes of the view as it was measured, until it changes.
    pub times: Option<FrameTimes>,
    /// The device, in words.
    pub adapter: String,
    said: Option<(String, Instant)>,
    pub playing: bool,
    /// Seconds of the clip in a second.
    pub speed: f32,
    played_at: Option<Instant>,
    moved_at: Option<Instant>,
    pub truth: TruthBeside,
    pub panels: bool,
    pub help: bool,
    /// The picture in the window, physical pixels.
    area: (u32, u32),
    /// The area was another one a frame ago: a picture of it may be of no use in the next.
    settles: bool,
    sequence: Option<Sequence>,
    /// The window is to be saved with the next frame.
    wants_window: bool,
}

/// Files that a step to the next one stops at.
const OPENED: [&str; 4] = ["pelage", "glb", "gltf", "obj"];

fn is_named(path: &Path, extensions: &[&str]) -> bool {
    let own = path.extension().unwrap_or_default();
    extensions.iter().any(|extension| own.eq_ignore_ascii_case(extension))
}

/// The text of a file that speaks of a look: a table of its own that recipes have not.
fn look_in(path: &Path) -> Option<String> {
    let text = std::fs::read_to_string(path).ok().filter(|_| is_named(path, &["toml"]))?;
    let speaks = ["[picture]", "[light]", "[shadow]", "[fur]"]
        .iter()
        .any(|table| text.lines().any(|line| line.trim() == *table));
    speaks.then_some(text)
}

/// What a frame came to.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// Whether the picture is another one.
    pub drew: bool,
    /// How long nothing will change by itself; `None` for until somebody does something.
    pub wait: Option<Duration>,
}

/// Pictures that are being saved, one with each frame of the window.
struct Sequence {
    stem: String,
    next: u32,
    count: u32,
    /// Where the time was before.
    time_s: f32,
}

impl App {
    /// Nothing is shown yet.
    pub fn new(show: Show, workers: Workers, events: Events, folder: PathBuf, look: Look) -> Self {
        Self {
            adapter: String::new(),
            show,
            workers,
            events,
            folder,
            opened: None,
            look_base: look,
            look_edits: Edits::default(),
            look_search: Search::default(),
            recipe_base: None,
            recipe_edits: Edits::default(),
            recipe_search: Search::default(),
            recipe_last: false,
            working: None,
            failure: None,
            notes: Vec::new(),
            stages: Vec::new(),
            times: None,
            said: None,
            playing: false,
            speed: 1.0,
            played_at: None,
            moved_at: None,
            truth: TruthBeside::default(),
            panels: true,
            help: false,
            area: (1, 1),
            settles: false,
            sequence: None,
            wants_window: false,
        }
    }

    /// Takes what a thread tells.
    pub fn hear(&mut self, told: Told, ctx: &Context) {
        match told {
            Told::Working(progress) => self.working = Some(progress),
            Told::Made(made, took) => self.made(*made, took),
            Told::Failed(reason) => {
                self.working = None;
                self.fail(reason);
            }
            Told::Saved(saved) => {
                let saved = saved.inspect(|_| self.recipe_edits.forget());
                self.tell_saved("recipe", saved);
                // The file has them now, and is watched.
            }
            Told::Tracing(progress) => self.truth.progressed(progress),
            Told::Truth(truth) => {
                let flip = truth.flip.as_ref().map(|(mean, _)| *mean);
                let (samples, of_samples) = (truth.samples, truth.of_samples);
                self.events.tell("truth", json!({ "samples": samples, "of_samples": of_samples, "flip": flip }));
                self.truth.take(ctx, *truth);
            }
            Told::NoTruth(reason) => {
                self.events.tell("no truth", json!({ "reason": reason }));
                self.truth.failed(reason);
            }
        }
    }

    fn made(&mut self, made: Made, took: Duration) {
        let Made { subject, look, recipe, notes, stages } = made;
        self.working = None;
        let name = subject.name().to_owned();
        let is_same = self.show.subject().is_some_and(|before| before.name() == name);
        if let Some(look) = look.filter(|_| !is_same) {
            self.look_base = look;
            self.look_edits.forget();
        }
        let shown = self.show.set_look(self.look_now(), self.area).and_then(|()| self.show.show(subject, self.area));
        if let Err(error) = shown {
            return self.fail(error.to_string());
        }
        self.mended();
        (self.recipe_base, self.notes, self.stages) = (recipe, notes, stages);
        self.changed();
        let stages: Vec<_> = self.stages.iter().map(|(name, s)| json!({ "name": name, "seconds": s })).collect();
        self.events.tell("made", json!({ "name": name, "seconds": took.as_secs_f64(), "stages": stages }));
    }

    /// What is shown is another thing, or seen otherwise.
    fn changed(&mut self) {
        self.times = None;
        if self.truth.outdated() {
            self.workers.stop_tracing();
        }
    }

    fn fail(&mut self, reason: String) {
        self.events.tell("failure", json!({ "reason": reason }));
        self.failure = Some(reason);
    }

    fn mended(&mut self) {
        if self.failure.take().is_some() {
            self.events.tell("mended", json!({}));
        }
    }

    fn say(&mut self, text: String) {
        self.said = Some((text, Instant::now()));
    }

    /// What was said last, for a while.
    pub fn said(&self) -> Option<&str> {
        self.said.as_ref().filter(|(_, when)| when.elapsed() < SAID).map(|(text, _)| text.as_str())
    }

    fn tell_saved(&mut self, what: &str, saved: Result<PathBuf, String>) {
        match saved {
            Ok(path) => {
                let path = path.display().to_string();
                self.events.tell("saved", json!({ "what": what, "file": path }));
                self.say(format!("{what} saved: {path}"));
            }
            Err(reason) => {
                self.events.tell("not saved", json!({ "what": what, "reason": reason }));
                self.say(reason);
            }
        }
    }

    /// Opens what was named or dropped: a look is read here, everything else is somebody's work.
    pub fn open(&mut self, path: &Path) {
        let mut look = self.look_base.clone();
        if look_in(path).is_some_and(|text| look.read(&text).is_ok()) {
            self.look_base = look;
            self.look_edits.forget();
            self.look_changed();
            return self.say(format!("look of {}", path.display()));
        }
        if !is_named(path, &["toml"]) {
            self.recipe_edits.forget();
        }
        self.opened = Some(path.to_owned());
        self.workers.open(path.to_owned());
    }

    /// Opens the next file of the same folder that can be opened, or the one before, round and round.
    pub fn open_next(&mut self, back: bool) {
        let Some(opened) = &self.opened else { return };
        let folder = opened.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let entries =
            std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| folder.join(entry.file_name()));
        let mut files: Vec<PathBuf> = entries.filter(|path| is_named(path, &OPENED) && path.is_file()).collect();
        files.sort();
        let at = files.iter().position(|path| path.file_name() == opened.file_name());
        let step = if back { files.len().saturating_sub(1) } else { 1 };
        let next = at.map_or(0, |at| (at + step) % files.len().max(1));
        if let Some(path) = files.get(next).cloned() {
            self.open(&path);
        }
    }

    /// The look with all changes.
    pub fn look_now(&self) -> Look {
        let mut look = self.look_base.clone();
        for assignment in self.look_edits.assignments() {
            // Each was taken before.
            let _ = look.set(&assignment);
        }
        look
    }

    /// A change of the look counts.
    pub fn look_changed(&mut self) {
        self.recipe_last = false;
        let look = self.look_now();
        let refused = self.refused_look_edits();
        if let Err(error) = self.show.set_look(look, self.area) {
            return self.fail(error.to_string());
        }
        match refused {
            Some(reason) => self.fail(reason),
            None => self.mended(),
        }
        self.changed();
    }

    fn refused_look_edits(&self) -> Option<String> {
        let mut look = self.look_base.clone();
        let refuse = |edit: String| look.set(&edit).err().map(|error| format!("look: {error}"));
        self.look_edits.assignments().into_iter().find_map(refuse)
    }

    /// Whether what is shown is baked by a recipe here.
    pub fn has_recipe(&self) -> bool {
        self.recipe_base.is_some()
    }

    /// The recipe with all changes.
    pub fn recipe_now(&self) -> Option<Box<dyn Knobs>> {
        let mut recipe = self.recipe_base.as_ref()?.boxed();
        for assignment in self.recipe_edits.assignments() {
            // One that is refused is told of by the bake.
            let _ = recipe.set(&assignment);
        }
        Some(recipe)
    }

    /// A change of the recipe counts: the model is baked anew.
    pub fn recipe_changed(&mut self) {
        self.recipe_last = true;
        self.workers.make(self.recipe_edits.assignments());
    }

    /// Takes the last change back.
    pub fn undo(&mut self) {
        self.step(Edits::undo);
    }

    /// Makes it again.
    pub fn redo(&mut self) {
        self.step(Edits::redo);
    }

    fn step(&mut self, step: fn(&mut Edits) -> bool) {
        let recipe_first = self.recipe_last;
        for of_recipe in [recipe_first, !recipe_first] {
            let edits = if of_recipe { &mut self.recipe_edits } else { &mut self.look_edits };
            if step(edits) {
                return if of_recipe { self.recipe_changed() } else { self.look_changed() };
            }
        }
    }

    /// Draws in another style.
    pub fn set_style(&mut self, style: Style) {
        self.look_edits.set("picture.style", format!("{:?}", style.word()), false);
        self.look_edits.released();
        self.look_changed();
    }

    /// Turns the key light about the target as a hand moves, heights of the picture right and up.
    pub fn turn_light(&mut self, moved: Vec2) {
        let KeyLight::Distant(towards) = self.look_now().key_light() else {
            return self.say("the light stands at a place: light.position_m".into());
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

    fn moved(&mut self) {
        self.moved_at = Some(Instant::now());
        self.changed();
    }

    /// Looks at all there is.
    pub fn frame(&mut self) {
        if let Err(error) = self.show.frame(self.area) {
            self.fail(error.to_string());
        }
        self.changed();
    }

    /// The camera as it was.
    pub fn reset_camera(&mut self) {
        self.show.reset();
        self.changed();
    }

    /// Plays another clip, from its beginning.
    pub fn play_clip(&mut self, clip: Option<usize>) {
        self.show.set_time(0.0);
        if let Err(error) = self.show.play(clip, self.area) {
            return self.fail(error.to_string());
        }
        self.playing = clip.is_some();
        self.changed();
    }

    /// Plays, or stops. With nothing chosen, the first clip.
    pub fn toggle_playing(&mut self) {
        let has_clips = !self.show.clips().is_empty();
        if self.show.clip().is_none() && has_clips && !self.playing {
            return self.play_clip(Some(0));
        }
        self.playing = !self.playing && self.length_s().is_some();
    }

    /// Length of what plays, seconds; `None` where nothing moves.
    pub fn length_s(&self) -> Option<f32> {
        match self.show.subject()? {
            Subject::Package(_) => self.show.clip().map(|clip| clip.duration_s),
            // As long as somebody looks.
            Subject::Scene(_) => Some(self.show.time_s().max(10.0)),
        }
    }

    /// The moment of what plays, seconds.
    pub fn moment_s(&self) -> f32 {
        let time_s = self.show.time_s();
        self.show.clip().map_or(time_s, |clip| within(time_s, clip.duration_s))
    }

    /// Goes to a moment, and stays there.
    pub fn go_to(&mut self, time_s: f32) {
        self.playing = false;
        self.show.set_time(time_s);
        self.moved();
    }

    /// Mebibytes on the device.
    pub fn gpu_mib(&self) -> f64 {
        self.show.gpu_bytes() as f64 / f64::from(1 << 20)
    }

    /// The truth beside, or not.
    pub fn toggle_truth(&mut self) {
        self.truth.toggle();
        self.workers.stop_tracing();
    }

    /// Measures the passes of the view as it stands.
    pub fn measure(&mut self) {
        self.times = None;
        let Some(stage) = self.show.stage() else { return };
        let meter = Meter::new(&stage.gpu);
        match meter.measure(stage) {
            Ok(times) => {
                let passes: Vec<_> =
                    times.passes.iter().map(|(id, ms)| json!({ "name": id.name(), "ms": ms })).collect();
                self.events.tell("measured", json!({ "frame_ms": times.frame, "passes": passes }));
                self.times = Some(times);
            }
            Err(error) => self.fail(error.to_string()),
        }
    }

    /// Saves the recipe with its changes.
    pub fn save_recipe(&mut self) {
        if self.has_recipe() {
            self.workers.save(self.recipe_edits.assignments());
        } else {
            self.say("what is shown was not baked here: there is no recipe to save".into());
        }
    }

    /// Saves the look.
    pub fn save_look(&mut self) {
        let mut look = self.look_now();
        (look.picture.size.width, look.picture.size.height) = self.area;
        let path = save::free(&self.folder, &format!("{}-look", self.stem()), "toml");
        let saved = path.and_then(|path| save::write(&path, look.to_toml().as_bytes()).map(|()| path));
        self.tell_saved("look", saved);
    }

    /// Saves the picture as it stands in the window.
    pub fn save_picture(&mut self) {
        let path = save::free(&self.folder, &self.stem(), "png");
        let saved = path.and_then(|path| self.write_picture(&path).map(|()| path));
        if saved.is_ok()
            && let Ok(view) = self.show.view(self.area)
        {
            let (width, height) = self.area;
            let view = json!({ "camera": view.to_string(), "size": format!("{width}x{height}"), "time_s": self.show.time_s() });
            self.events.tell("pictured", view);
        }
        self.tell_saved("picture", saved);
    }

    fn write_picture(&mut self, path: &Path) -> Result<(), String> {
        let picture = self.show.picture(self.area).map_err(|error| error.to_string())?;
        save::write_png(path, &picture.ok_or("nothing is shown yet")?)
    }

    fn stem(&self) -> String {
        save::stem(self.show.subject().map_or("", Subject::name))
    }

    /// Saves the clip once, picture by picture.
    pub fn save_sequence(&mut self) {
        let Some(length_s) = self.length_s() else { return self.say("nothing moves here".into()) };
        let count = (length_s * FPS).round().max(1.0) as u32;
        let stem = format!("{}-{}", self.stem(), self.show.clip().map_or("scene", |clip| clip.name.as_str()));
        let stem = stem.replace(['/', '\\', '|', ':'], "-");
        self.playing = false;
        self.sequence = Some(Sequence { stem, next: 0, count, time_s: self.show.time_s() });
    }

    fn go_on_saving(&mut self) {
        let Some(Sequence { stem, next, count, time_s }) = self.sequence.take() else { return };
        if next == count {
            self.show.set_time(time_s);
            self.working = None;
            let first = self.folder.join(format!("{stem}.0000.png"));
            return self.tell_saved("sequence", Ok(first));
        }
        self.show.set_time(next as f32 / FPS);
        let path = self.folder.join(format!("{stem}.{next:04}.png"));
        if let Err(reason) = self.write_picture(&path) {
            self.working = None;
            return self.tell_saved("sequence", Err(reason));
        }
        let share = Some((next + 1) as f32 / count as f32);
        self.working = Some(Progress { doing: format!("{} of {count} pictures", next + 1), share });
        self.sequence = Some(Sequence { stem, next: next + 1, count, time_s });
    }

    /// Saves the window with the next frame.
    pub fn save_window(&mut self) {
        self.wants_window = true;
    }

    /// Where the window is to be saved now, if it is.
    pub fn take_window(&mut self) -> Option<PathBuf> {
        if !std::mem::take(&mut self.wants_window) {
            return None;
        }
        match save::free(&self.folder, "window", "png") {
            Ok(path) => Some(path),
            Err(reason) => {
                self.say(reason);
                None
            }
        }
    }

    /// The window was saved, or not.
    pub fn window_saved(&mut self, saved: Result<PathBuf, String>) {
        self.tell_saved("window", saved);
    }

    /// Where the picture stands in the window, points, with pixels in a point.
    pub fn set_area(&mut self, rect: Rect, pixels: f32) {
        let side = |points: f32| (points * pixels).round().clamp(1.0, 8192.0) as u32;
        let area = (side(rect.width()), side(rect.height()));
        self.settles = area != self.area;
        if self.settles {
            self.area = area;
            self.changed();
        }
    }

    /// Goes on with time, and draws what is to be seen.
    ///
    /// # Errors
    ///
    /// [`StageError::Device`] for a device that is gone. A look that cannot be drawn is a failure that stands in the window.
    pub fn go_on(&mut self) -> Result<Step, StageError> {
        let now = Instant::now();
        let since = self.played_at.replace(now).map_or(Duration::ZERO, |before| now - before);
        if self.playing {
            // Whoever looks away for a minute finds the clip where it was.
            let seconds = since.as_secs_f32().min(0.25);
            self.show.set_time(self.show.time_s() + self.speed * seconds);
            self.changed();
        }
        if std::mem::take(&mut self.settles) {
            return Ok(Step { drew: false, wait: Some(Duration::ZERO) });
        }
        self.go_on_saving();
        let moves = self.playing || self.moved_at.is_some_and(|at| at.elapsed() < SETTLES);
        let small = moves && self.show.is_software() && self.sequence.is_none();
        let (width, height) = self.area;
        let size = if small { (width.div_ceil(2), height.div_ceil(2)) } else { (width, height) };
        let first = self.show.last().is_none();
        let drew = match self.show.draw(size) {
            Ok(drew) => drew,
            Err(error @ StageError::Device(_)) => return Err(error),
            Err(error) => {
                let reason = error.to_string();
                if self.failure.as_ref() != Some(&reason) {
                    self.fail(reason);
                }
                false
            }
        };
        if drew {
            let took_ms = self.show.last().map_or(0.0, |last| 1e3 * last.took.as_secs_f64());
            let event = if first { "first picture" } else { "picture" };
            self.events.tell(event, json!({ "width": size.0, "height": size.1, "took_ms": took_ms }));
        }
        if !moves && self.truth.is_due() {
            self.trace()?;
        }
        let wait = if self.playing || self.sequence.is_some() {
            Some(Duration::ZERO)
        } else if moves || self.truth.waits() {
            Some(Duration::from_millis(60))
        } else {
            self.said().map(|_| Duration::from_secs(1))
        };
        Ok(Step { drew, wait })
    }

    fn trace(&mut self) -> Result<(), StageError> {
        let Some(Subject::Package(file)) = self.show.subject().cloned() else {
            self.truth.failed("it is traced of one package; a scene has several".into());
            return Ok(());
        };
        let Some(drawn) = self.show.picture(self.area)? else { return Ok(()) };
        let mut look = self.look_now();
        (look.picture.size.width, look.picture.size.height) = self.area;
        let camera = self.show.view(self.area)?;
        let clip = self.show.clip().map(|clip| clip.name.clone());
        self.workers.trace(TruthAsked { file, look, camera, clip, time_s: self.show.time_s(), drawn });
        Ok(())
    }
}
