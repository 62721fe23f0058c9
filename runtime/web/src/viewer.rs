//! Viewer of a package on a canvas, with camera, light, clip and look.

use crate::canvas::{OpenedDevice, Screen};
use crate::js_error::{invalid_argument, pelage_error, stage_error};
use crate::player::Player;
use crate::report::{self, object};
use glam::{Vec2, Vec3};
use pelage_runtime::SealImage;
use pelage_runtime::{FrameParams, Light};
use pelage_stage::sky::environment_from_toml;
use pelage_stage::{
    Cast, Framing, Gpu, Look, LookStyle, NamedPackage, Navigator, Size, SkyKind, SkySource, Stage, Viewpoint,
    find_clip, find_morph,
};
use std::sync::Arc;
use wasm_bindgen::prelude::*;

/// Change of the clip time, in seconds, above which it counts as a jump and hair motion restarts.
const JUMP_S: f32 = 0.25;

/// Arbitrary view for use before a package is loaded, when nothing is visible.
const INITIAL_VIEW: Viewpoint = Viewpoint { eye: Vec3::Z, target: Vec3::ZERO, fov_deg: 30.0 };

/// Loaded package. Its bytes are kept, because a new stage must be created for a new device or a different number of
/// samples per pixel.
struct LoadedPackage {
    file: NamedPackage<'static>,
    has_ink: bool,
    has_fibres: bool,
    stage: Stage,
}

/// Viewer of a package on a canvas.
///
/// If a method fails, the state is the same as before the call.
#[wasm_bindgen]
pub struct Viewer {
    gpu: Gpu,
    screen: Screen,
    loaded: Option<LoadedPackage>,
    look: Look,
    /// Colour of the key light; 1 is full light.
    light_color: Vec3,
    navigator: Navigator,
    player: Player,
    /// Time of the hair simulation, seconds.
    clock_s: f64,
    /// Whether hair moved by itself in the last frame drawn.
    hair_moves: bool,
}

#[wasm_bindgen]
impl Viewer {
    /// Creates a viewer with an empty canvas of that size in pixels.
    ///
    /// Fails with an error of kind `asked` for a size out of range.
    #[wasm_bindgen(constructor)]
    pub fn new(opened: OpenedDevice, width: u32, height: u32) -> Result<Self, JsValue> {
        let (gpu, screen) = device_and_screen(opened)?;
        let mut viewer = Self {
            gpu,
            screen,
            loaded: None,
            look: Look::of_picture(),
            light_color: Vec3::ONE,
            navigator: Navigator::new(INITIAL_VIEW),
            player: Player::at_rest(),
            clock_s: 0.0,
            hair_moves: false,
        };
        viewer.resize(width, height)?;
        Ok(viewer)
    }

    /// Loads a package and shows it at rest, with a camera that frames it. `name` is its name in messages.
    ///
    /// Fails with an error of kind `package` with section and offset; `asked` if the package does not support the look;
    /// `no-adapter` if the device cannot hold the package.
    pub fn load(&mut self, name: &str, bytes: Vec<u8>) -> Result<JsValue, JsValue> {
        let file = NamedPackage::new(name, bytes);
        let package = file.open().map_err(stage_error)?;
        let has_ink = package.ink().map_err(|error| stage_error(file.fault(error)))?.is_some();
        if !has_ink && self.look.picture.style == LookStyle::Ink {
            return Err(no_ink_error(&file.name));
        }
        let (stage, view) = self.create_stage(&file)?;
        self.navigator.frame(view);
        self.player = Player::at_rest();
        let info = report::package(name, file.bytes.len(), stage.model(), has_ink);
        let has_fibres = package.fibres().map_err(|error| stage_error(file.fault(error)))?.is_some();
        self.loaded = Some(LoadedPackage { file, has_ink, has_fibres, stage });
        self.screen.discard_image();
        Ok(info)
    }

    /// Continues with another device after the loss of the previous one. The package is loaded again; everything else
    /// is unchanged.
    ///
    /// Fails like [`Self::load`].
    pub fn reopen(&mut self, opened: OpenedDevice) -> Result<(), JsValue> {
        (self.gpu, self.screen) = device_and_screen(opened)?;
        self.screen.resize(&self.gpu, self.look.picture().size);
        self.rebuild()
    }

    /// Sets the size in pixels. If the camera has not been moved, it frames the model again.
    ///
    /// Fails with an error of kind `asked` for a size out of range.
    pub fn resize(&mut self, width: u32, height: u32) -> Result<(), JsValue> {
        let mut look = self.look.clone();
        look.picture.size = Size { width, height };
        look.validate().map_err(invalid_argument)?;
        self.apply_look(look)?;
        self.screen.resize(&self.gpu, (width, height));
        if self.navigator.is_home() { self.frame_all() } else { Ok(()) }
    }

    /// Draws a frame. Returns `undefined` if no package is loaded, or if the page currently has no texture to draw on.
    ///
    /// Fails with an error of kind `asked` for anything that the device cannot draw.
    pub fn draw(&mut self) -> Result<JsValue, JsValue> {
        let Some(LoadedPackage { stage, .. }) = &mut self.loaded else { return Ok(JsValue::UNDEFINED) };
        stage.look_from(self.navigator.view());
        stage.instances[0].motion = self.player.motion();
        stage.advance_hair(self.clock_s, self.look.hair_motion());
        let mut encoder = stage.encoder();
        let frame = stage.prepare(&mut encoder).map_err(stage_error)?;
        self.hair_moves = frame.report().hair_moves;
        frame.draw(&mut stage.pass(&mut encoder, "frame", true));
        let Some(texture) = self.screen.show(&self.gpu, &mut encoder, &stage.canvas) else {
            return Ok(JsValue::UNDEFINED);
        };
        self.gpu.queue.submit([encoder.finish()]);
        self.gpu.queue.present(texture);
        Ok(report::frame(&frame, stage.model().gpu_bytes() + stage.copies_bytes() + stage.shadow_bytes()))
    }

    /// Sets one key of the look, such as `shadow.penumbra=0.3`.
    ///
    /// Fails with an error of kind `asked` with what was found and expected.
    pub fn set_look(&mut self, assignment: &str) -> Result<(), JsValue> {
        let mut look = self.look.clone();
        look.set(assignment).map_err(invalid_argument)?;
        self.apply_look(reject_files(look)?)
    }

    /// Replaces the look by one from TOML; missing keys get their defaults. The size of the canvas is unchanged.
    ///
    /// Fails with an error of kind `asked` with line, key, what was found and expected.
    pub fn read_look(&mut self, text: &str) -> Result<(), JsValue> {
        let mut look = Look::of_picture();
        look.read(text).map_err(invalid_argument)?;
        look.picture.size = self.look.picture.size;
        self.apply_look(reject_files(look)?)
    }

    /// Changes the look to ink in a style of [`Self::ink_styles`].
    ///
    /// Fails with an error of kind `asked` with what was found and expected.
    pub fn set_ink_style(&mut self, name: &str) -> Result<(), JsValue> {
        let mut look = self.look.clone();
        if !look.set_ink_style(name) {
            let text = format!("ink style: found {name:?}, expected {}", Self::ink_styles().join(", "));
            return Err(pelage_error("asked", &text));
        }
        self.apply_look(look)
    }

    /// Returns the name of the look's style of ink; `None` if its knobs are no style's.
    pub fn ink_style(&self) -> Option<String> {
        self.look.ink_style().map(str::to_owned)
    }

    /// Returns the names of the styles of ink, the default first.
    pub fn ink_styles() -> Vec<String> {
        Look::ink_styles().map(|(name, _)| name.to_owned()).collect()
    }

    /// Sets an environment map, given in TOML as lights fitted to a sky. It replaces the ambient light until the key
    /// `environment.sky = "none"` removes it.
    ///
    /// Fails with an error of kind `asked` with line, key, what was found and expected.
    pub fn set_environment(&mut self, text: &str) -> Result<(), JsValue> {
        let look = with_environment(&self.look, text)?;
        self.apply_look(look)
    }

    /// Sets the seal on ink paintings, until the key `ink.seal = "none"` removes it.
    ///
    /// * `width`, `height`, `rgba`: size of an image in pixels, and its rows of sRGB-encoded red, green, blue and
    ///   straight alpha
    /// * `place`: no numbers, or three as in the look's `ink.seal`
    ///
    /// Fails with an error of kind `asked` with what was found and expected.
    pub fn set_seal(&mut self, width: u32, height: u32, rgba: Vec<u8>, place: &[f32]) -> Result<(), JsValue> {
        let image =
            SealImage::new([width, height], rgba).map_err(|reason| invalid_argument(&format!("seal: {reason}")))?;
        let mut look = self.look.clone();
        let numbers: Vec<String> = place.iter().map(f32::to_string).collect();
        let at = if numbers.is_empty() { String::new() } else { format!(":{}", numbers.join(",")) };
        look.set(&format!("ink.seal=seal.png{at}")).map_err(invalid_argument)?;
        if let Some(seal) = &mut look.ink.seal {
            seal.image = Some(Arc::new(image));
        }
        self.apply_look(look)
    }

    /// Returns the look as TOML, with every key that has a value.
    pub fn look(&self) -> String {
        self.look.to_toml()
    }

    /// Sets the colour of the key light, linear red, green and blue; 1 is full light.
    ///
    /// Fails with an error of kind `asked` for a channel that is not finite or below 0.
    pub fn set_light_color(&mut self, red: f32, green: f32, blue: f32) -> Result<(), JsValue> {
        let color = Vec3::new(red, green, blue);
        if !(color.is_finite() && color.min_element() >= 0.0) {
            return Err(invalid_argument(format!(
                "light color: found {red}, {green}, {blue}, expected three numbers of at least 0"
            )));
        }
        self.light_color = color;
        self.apply_look(self.look.clone())
    }

    /// Selects the clip named `name`, at its start and paused; `undefined` puts the model at rest.
    ///
    /// Fails with an error of kind `asked` for a clip that does not exist, with the available names.
    pub fn set_clip(&mut self, name: Option<String>) -> Result<(), JsValue> {
        let clip = match &self.loaded {
            None if name.is_some() => {
                return Err(invalid_argument("clip: found no package, expected one to be loaded first"));
            }
            None => None,
            Some(loaded) => {
                let package = loaded.file.open().map_err(stage_error)?;
                find_clip(&loaded.file, &package, name.as_deref()).map_err(stage_error)?
            }
        };
        self.player = Player { clip, time_s: 0.0, playing: false, ..self.player };
        Ok(())
    }

    /// Fixes the weight of the morph target named `name`, whatever the clip does. With weight `undefined`, the clip
    /// drives it again.
    ///
    /// Fails with an error of kind `asked` for a target that does not exist, with the available names, and for a weight
    /// that is not finite.
    pub fn set_morph(&mut self, name: &str, weight: Option<f32>) -> Result<(), JsValue> {
        let Some(loaded) = &mut self.loaded else {
            return Err(invalid_argument("morph: found no package, expected one to be loaded first"));
        };
        if weight.is_some_and(|weight| !weight.is_finite()) {
            return Err(invalid_argument(
                "morph: found a weight that is infinite or not a number, expected a finite one",
            ));
        }
        let package = loaded.file.open().map_err(stage_error)?;
        let index = find_morph(&loaded.file, &package, name).map_err(stage_error)?;
        let morphs = &mut loaded.stage.instances[0].morphs;
        morphs.retain(|(other, _)| *other != index);
        morphs.extend(weight.map(|weight| (index, weight)));
        Ok(())
    }

    /// Plays or pauses the clip.
    pub fn set_playing(&mut self, playing: bool) {
        self.player.playing = playing && self.player.clip.is_some();
    }

    /// Sets the playback speed, clip seconds per second; below 0 the clip runs backwards.
    pub fn set_speed(&mut self, speed: f32) {
        if speed.is_finite() {
            self.player.speed = speed;
        }
    }

    /// Moves to time `time_s` of the clip, seconds; clips loop.
    pub fn seek(&mut self, time_s: f32) {
        if !time_s.is_finite() {
            return;
        }
        let before_s = self.player.time_s;
        self.player.seek(time_s);
        if (self.player.time_s - before_s).abs() > JUMP_S
            && let Some(loaded) = &mut self.loaded
        {
            loaded.stage.reset_hair();
        }
    }

    /// Advances time by `elapsed_s` seconds. Returns whether the image has changed.
    pub fn advance(&mut self, elapsed_s: f32) -> bool {
        self.clock_s += f64::from(elapsed_s);
        self.player.advance(elapsed_s) || self.hair_moves && elapsed_s > 0.0
    }

    /// Whether hair moved by itself in the last frame drawn; time must then advance even if no clip plays.
    pub fn hair_moves(&self) -> bool {
        self.hair_moves
    }

    /// Returns the clip's name and duration, the time in it, the speed, and whether it plays.
    pub fn playing(&self) -> JsValue {
        let name = self.player.clip.and_then(|(clip, _)| {
            let clips = self.loaded.as_ref()?.stage.model().clips();
            Some(JsValue::from(clips.get(clip)?.name.as_str()))
        });
        object([
            ("clip", name.unwrap_or(JsValue::NULL)),
            ("durationS", self.player.clip.map_or(0.0, |(_, duration_s)| duration_s).into()),
            ("timeS", self.player.time_s.into()),
            ("speed", self.player.speed.into()),
            ("playing", self.player.playing.into()),
        ])
    }

    /// Returns eye and target in metres, and the vertical field of view in degrees: seven numbers.
    pub fn view(&self) -> Vec<f32> {
        let Viewpoint { eye, target, fov_deg } = self.navigator.view();
        [eye.to_array(), target.to_array()].concat().into_iter().chain([fov_deg]).collect()
    }

    /// Sets the camera to a view as returned by [`Self::view`]. [`Self::reset_view`] returns to the framed view.
    ///
    /// Fails with an error of kind `asked` for an invalid view.
    pub fn set_view(&mut self, view: &[f32]) -> Result<(), JsValue> {
        let word = match view {
            [ex, ey, ez, tx, ty, tz, fov_deg] => format!("{ex},{ey},{ez}/{tx},{ty},{tz}/{fov_deg}"),
            _ => return Err(invalid_argument(format!("view: found {} numbers, expected seven", view.len()))),
        };
        let view: Viewpoint = word.parse().map_err(|error: String| invalid_argument(format!("view: {error}")))?;
        self.navigator.go_to(view);
        Ok(())
    }

    /// Frames the model as on loading.
    ///
    /// Fails with an error of kind `package` for a damaged package.
    pub fn frame_all(&mut self) -> Result<(), JsValue> {
        if let Some(loaded) = &self.loaded {
            let package = loaded.file.open().map_err(stage_error)?;
            let framing = (&Framing::default(), self.look.aspect());
            let cast = Cast::crowd(&loaded.file, package, None, 1, None, framing).map_err(stage_error)?;
            self.navigator.frame(cast.camera.at(0.0));
        }
        Ok(())
    }

    /// Returns the camera to the framed view.
    pub fn reset_view(&mut self) {
        self.navigator.reset();
    }

    /// Returns the camera's position relative to its target: azimuth from +z towards +x and elevation, in degrees, and
    /// distance in metres.
    pub fn around(&self) -> Vec<f32> {
        let (azimuth_deg, elevation_deg, distance_m) = self.navigator.spherical();
        vec![azimuth_deg, elevation_deg, distance_m]
    }

    /// Moves the camera to a position as returned by [`Self::around`].
    pub fn go_around(&mut self, azimuth_deg: f32, elevation_deg: f32, distance_m: f32) {
        self.navigator.set_spherical(azimuth_deg, elevation_deg, distance_m);
    }

    /// Orbits the camera about the target for a drag to the right and up, measured in heights of the image. The model
    /// turns with the pointer.
    pub fn orbit(&mut self, right: f32, up: f32) {
        self.navigator.orbit(Vec2::new(right, up));
    }

    /// Moves the camera sideways for a drag to the right and up, measured in heights of the image. The model moves with
    /// the pointer.
    pub fn pan(&mut self, right: f32, up: f32) {
        self.navigator.pan(Vec2::new(right, up));
    }

    /// Divides the camera's distance from its target by `factor`; the point under the pointer stays in place. `right`
    /// and `up` are the pointer position relative to the centre, in heights of the image.
    pub fn zoom(&mut self, factor: f32, right: f32, up: f32) {
        self.navigator.zoom(factor, Vec2::new(right, up));
    }
}

impl Viewer {
    /// Creates a stage that shows the package `file`, and returns it with the camera that frames the package.
    fn create_stage(&self, file: &NamedPackage<'static>) -> Result<(Stage, Viewpoint), JsValue> {
        let picture = self.look.picture();
        let package = file.open().map_err(stage_error)?;
        let framing = Framing::default();
        let cast = Cast::crowd(file, package, None, 1, None, (&framing, picture.aspect())).map_err(stage_error)?;
        let gpu = self.gpu.clone();
        let look = self.look.resolved(cast.has_fibres().map_err(stage_error)?);
        let stage =
            Stage::new(&cast, &picture, frame_params(&look, self.light_color), 0.0, || Ok(gpu)).map_err(stage_error)?;
        Ok((stage, cast.camera.at(0.0)))
    }

    /// Creates the stage again, from the package already loaded.
    fn rebuild(&mut self) -> Result<(), JsValue> {
        if let Some(loaded) = &self.loaded {
            let (stage, _) = self.create_stage(&loaded.file)?;
            if let Some(loaded) = &mut self.loaded {
                loaded.stage = stage;
            }
        }
        self.screen.discard_image();
        Ok(())
    }

    fn apply_look(&mut self, look: Look) -> Result<(), JsValue> {
        let (before, picture) = (self.look.picture(), look.picture());
        let fibres = self.loaded.as_ref().is_some_and(|loaded| loaded.has_fibres);
        let params = frame_params(&look.resolved(fibres), self.light_color);
        if let Some(loaded) = &mut self.loaded {
            if look.picture.style == LookStyle::Ink && !loaded.has_ink {
                return Err(no_ink_error(&loaded.file.name));
            }
            if picture.samples == before.samples {
                loaded.stage.set_look(&picture, params, 0.0).map_err(stage_error)?;
            }
        }
        let look_before = std::mem::replace(&mut self.look, look);
        if picture.samples != before.samples {
            // A different number of samples requires a new stage.
            if let Err(error) = self.rebuild() {
                self.look = look_before;
                return Err(error);
            }
        } else if picture.size != before.size {
            self.screen.discard_image();
        }
        Ok(())
    }
}

/// Returns a device and the canvas that it was opened for.
fn device_and_screen(opened: OpenedDevice) -> Result<(Gpu, Screen), JsValue> {
    let screen = opened
        .screen
        .ok_or_else(|| invalid_argument("opened: found a device without a canvas, expected the result of open()"))?;
    Ok((opened.gpu, screen))
}

/// Returns the look with the environment lights read from TOML.
pub(crate) fn with_environment(look: &Look, text: &str) -> Result<Look, JsValue> {
    let lights = environment_from_toml("environment", text).map_err(invalid_argument)?;
    let mut look = look.clone();
    let kind = SkyKind::File("environment.toml".into());
    look.environment.sky = Some(SkySource { kind, yaw_deg: 0.0, lights: Some(Arc::new(lights)) });
    Ok(look)
}

/// Rejects a look that refers to a file, which a page cannot read.
pub(crate) fn reject_files(look: Look) -> Result<Look, JsValue> {
    let unread =
        look.environment.sky.as_ref().is_some_and(|sky| matches!(sky.kind, SkyKind::File(_)) && sky.lights.is_none());
    if unread {
        return Err(invalid_argument(
            "environment.sky: found a file, expected a colour or two; setEnvironment takes lights as text",
        ));
    }
    if look.ink.seal.as_ref().is_some_and(|seal| seal.image.is_none()) {
        return Err(invalid_argument("ink.seal: found a file, expected none; setSeal takes an image"));
    }
    Ok(look)
}

/// Returns the frame parameters for a look, with the key light multiplied by `light_color`, linear.
pub(crate) fn frame_params(look: &Look, light_color: Vec3) -> FrameParams {
    look.frame_params().with(|params| {
        let (Light::Directional { color, .. } | Light::Point { color, .. }) = &mut params.light;
        *color *= light_color;
    })
}

fn no_ink_error(file: &str) -> JsValue {
    pelage_error(
        "asked",
        &format!(
            "{file}: style ink: found no ink data, expected a package baked with ink.enabled = true in its recipe"
        ),
    )
}
