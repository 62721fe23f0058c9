//! Pictures of a stage at successive times.

use super::backdrop::lay_over_sky;
use super::exit::Failure;
use super::journal::Key;
use super::output::Output;
use super::stages::{self, FurDetail, detail};
use super::svg;
use super::view::PictureView;
use glam::{DVec3, Quat, Vec3};
use image::RgbaImage;
use pelage_bake::io;
use pelage_bake::picture::encode_png;
use pelage_formats::meaning::{hair_motion, linear_to_srgb, luminance, srgb_to_linear};
use pelage_runtime::{Camera, Environment, Frame, Light, PassReport, Projection, Style};
use pelage_stage::{CameraTrack, Stage, Viewpoint};
use pelage_truth::{Lens, TrueCamera};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Minimum rate at which moving hair is advanced, per second. It equals the step rate of the simulation, so that 12,
/// 24, 30 and 60 pictures per second show the same motion.
const MIN_SIMULATION_RATE: u32 = hair_motion::STEPS_PER_S as u32;

/// Measurements of a picture.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Picture {
    /// Number of pixels with nonzero opacity.
    pub covered_pixels: u64,
    /// Mean luminance of the covered pixels, linear, 0..=1; 0 without covered pixels.
    pub mean_luminance: f64,
    /// Reports of the frame's passes. In a sequence, only the first picture has them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub passes: Vec<PassRun>,
    /// Level of detail of the fur of each copy. In a sequence, only the first picture has it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub detail: Vec<FurDetail>,
}

/// Report of a render pass of a frame.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct PassRun {
    name: String,
    ran: bool,
    /// Reason why the pass ran, or did not run.
    reason: String,
}

/// Scene, and the times of the pictures to draw of it.
pub struct PictureSeries {
    /// Stage with the scene, and its device.
    pub scene: Stage,
    /// View of the scene.
    pub view: PictureView,
    /// Camera, before the rotation of `auto_rotate`.
    pub shot: CameraTrack,
    /// Key light, before the rotation of `turn_light`.
    pub light: Light,
    /// Environment, before the rotation of `turn_light`.
    pub environment: Option<Environment>,
    /// Whether the light and the environment make one full turn over the sequence.
    pub turn_light: bool,
    /// Whether the camera makes one full turn around the vertical axis through its target over the sequence.
    pub auto_rotate: bool,
    /// Whether the pictures show one painting, of which each has more strokes.
    pub paint: bool,
    /// Index of the first picture to draw, whose passes and detail are reported.
    pub first: usize,
    /// Number of pictures in the whole sequence.
    pub count: usize,
    /// Pictures per second.
    pub fps: u32,
    /// Index of the last moment to which hair was simulated; `None` before the simulation starts.
    pub lived: Option<i64>,
}

impl PictureSeries {
    /// Returns the width and height, pixels.
    pub fn size(&self) -> (u32, u32) {
        self.view.size()
    }

    /// Returns the background, sRGB-encoded; `None` for transparency.
    pub fn background(&self) -> Option<[u8; 3]> {
        self.view.look.background()
    }

    /// Draws the picture `index`, counted from 0.
    pub fn picture(&mut self, index: usize, output: &mut Output) -> Result<(Picture, RgbaImage), Failure> {
        if self.count > 1 {
            output.progress_of(index, self.count, "pictures");
        } else {
            output.progress("drawing");
        }
        let time_s = self.time_s(index as i64 * self.moments());
        if self.paint {
            self.scene.set_time(time_s);
            if let Style::Ink(ink) = &mut self.scene.params.style {
                ink.brush.progress = (index + 1) as f32 / self.count as f32;
            }
        } else if self.count > 1 {
            self.advance_to(index)?;
        } else {
            self.scene.set_time(time_s);
        }
        let angle_rad = std::f32::consts::TAU * index as f32 / self.count as f32;
        if self.auto_rotate {
            self.scene.look_from(self.view_of(index).0);
        }
        let turn_deg = if self.turn_light { angle_rad.to_degrees() } else { 0.0 };
        if self.turn_light {
            self.scene.params.light = turned(self.light, angle_rad);
            self.scene.params.environment = self.environment.as_ref().map(|sky| sky.turned(turn_deg));
        }
        let (drawn, mut pixels) = picture(&mut self.scene)?;
        if let Some(camera) = of_frame(&self.scene.params.camera) {
            lay_over_sky(&self.view.look, self.view.sky.as_deref(), &mut pixels, &camera, turn_deg);
        }
        // Passes and detail of every picture would fill memory and journal in a long sequence with a large crowd, and
        // are never shown.
        let told =
            if index == self.first { drawn } else { Picture { passes: Vec::new(), detail: Vec::new(), ..drawn } };
        Ok((told, pixels))
    }

    /// Draws the first picture with curves: its measurements, and its strokes as SVG.
    ///
    /// Fails if the picture is not painted with strokes.
    pub fn curves(&mut self, output: &mut Output) -> Result<(Picture, String), Failure> {
        output.progress("drawing");
        self.scene.set_time(self.time_s(0));
        let frame = self.scene.draw()?;
        let pixels = stages::pixels(&self.scene)?;
        let strokes = self.scene.strokes(&frame)?;
        let Some(ink) = self.scene.params.style.ink().filter(|_| !frame.stroke_buffers().is_empty()) else {
            return Err(Failure::Usage(
                "-o *.svg: the picture has no strokes, expected --style ink, --ink-lines strokes (the default), and a \
                 package baked by this version"
                    .into(),
            ));
        };
        let bytes = |color: Vec3| color.to_array().map(linear_to_srgb);
        let text = svg::svg(&strokes, self.size(), bytes(ink.paper), bytes(ink.ink));
        Ok((measured(&frame, &pixels), text))
    }

    /// Returns the camera of the picture `index`, and its time in seconds.
    pub fn view_of(&self, index: usize) -> (Viewpoint, f32) {
        let time_s = self.time_s(index as i64 * self.moments());
        let angle_rad = std::f32::consts::TAU * index as f32 / self.count as f32;
        let camera = self.shot.at(time_s);
        (if self.auto_rotate { camera.turned(angle_rad) } else { camera }, time_s)
    }

    /// Returns the number of simulated moments per picture, which gives at least [`MIN_SIMULATION_RATE`] moments per
    /// second.
    fn moments(&self) -> i64 {
        i64::from(MIN_SIMULATION_RATE.div_ceil(self.fps))
    }

    /// Returns the time of a moment, seconds. Moments before the first picture are negative.
    fn time_s(&self, moment: i64) -> f32 {
        let moment = if self.paint { 0 } else { moment };
        self.view.time_s + moment as f32 / (self.moments() as f32 * self.fps as f32)
    }

    /// Advances to the picture `index`. Hair is simulated from one second before the first picture, and through all
    /// earlier pictures even if they are already drawn.
    fn advance_to(&mut self, index: usize) -> Result<(), Failure> {
        let motion = self.view.look.hair_motion().filter(|motion| self.scene.may_move_hair(motion));
        let begins_s = f64::from(self.view.time_s);
        let fps = (self.moments() * i64::from(self.fps)) as f64;
        let clock_s = move |moment: i64| begins_s + moment as f64 / fps;
        let now = index as i64 * self.moments();
        if motion.is_some() {
            let first = self.lived.map_or(-self.moments() * i64::from(self.fps), |last| last + 1);
            for earlier in first..now {
                self.scene.advance(self.time_s(earlier), clock_s(earlier), motion);
                self.scene.simulate_frame()?;
            }
        }
        self.scene.advance(self.time_s(now), clock_s(now), motion);
        self.lived = Some(now);
        Ok(())
    }

    /// Returns a key of everything that a picture depends on, except its index and the subject.
    pub fn key(&self) -> Key {
        let key = Key::of_build()
            .with(self.scene.gpu.description())
            .with(format!("{:?}", self.view))
            .with(self.fps.to_le_bytes());
        match [self.turn_light, self.auto_rotate, self.paint] {
            [false, false, false] => key,
            changes => key.with(self.count.to_le_bytes()).with(changes.map(u8::from)),
        }
    }
}

/// Converts the camera of a frame, for per-pixel computations. Cameras of a stage always have a perspective lens.
fn of_frame(camera: &Camera) -> Option<TrueCamera> {
    let lens = match camera.projection {
        Projection::Perspective { fov_y_rad, .. } => Lens::Perspective { fov_y_rad },
        Projection::Orthographic { height_m, .. } => Lens::Orthographic { height_m },
        Projection::Custom(_) => return None,
    };
    Some(TrueCamera::from_view(camera.view_from_world, lens))
}

/// Draws the scene in its current state into a PNG file.
pub fn draw(scene: &mut Stage, path: &Path) -> Result<Picture, Failure> {
    let (picture, pixels) = picture(scene)?;
    write_png(path, &pixels)?;
    Ok(picture)
}

/// Writes a picture; returns the contents of the file.
pub fn write_png(path: &Path, pixels: &RgbaImage) -> Result<Vec<u8>, Failure> {
    let bytes = encode_png(pixels)?;
    io::write_atomic(path, &bytes)?;
    Ok(bytes)
}

/// Draws the scene in its current state. Returns measurements and pixels; the latter are sRGB-encoded, with straight
/// alpha.
fn picture(scene: &mut Stage) -> Result<(Picture, RgbaImage), Failure> {
    let frame = scene.draw()?;
    let pixels = stages::pixels(scene)?;
    Ok((measured(&frame, &pixels), pixels))
}

fn measured(frame: &Frame, pixels: &RgbaImage) -> Picture {
    Picture {
        covered_pixels: pixels.pixels().filter(|p| p.0[3] > 0).count() as u64,
        mean_luminance: mean_luminance(pixels),
        passes: passes(frame),
        detail: detail(frame),
    }
}

/// Rotates a light around the world's vertical axis.
fn turned(light: Light, angle_rad: f32) -> Light {
    let turn = Quat::from_rotation_y(angle_rad);
    match light {
        Light::Directional { towards_light, color } => {
            Light::Directional { towards_light: turn * towards_light, color }
        }
        Light::Point { position, color } => Light::Point { position: turn * position, color },
    }
}

/// Returns the mean linear luminance (Rec. 709) of the pixels with nonzero opacity.
fn mean_luminance(pixels: &RgbaImage) -> f64 {
    let covered = || pixels.pixels().filter(|p| p.0[3] > 0);
    let of = |p: &image::Rgba<u8>| {
        let [r, g, b, _] = p.0.map(|byte| f64::from(srgb_to_linear(byte)));
        luminance(DVec3::new(r, g, b))
    };
    covered().map(of).sum::<f64>() / covered().count().max(1) as f64
}

fn passes(frame: &Frame) -> Vec<PassRun> {
    let of = |p: &PassReport| PassRun { name: p.name.into(), ran: p.ran, reason: p.reason.clone() };
    frame.report().passes.iter().map(of).collect()
}
