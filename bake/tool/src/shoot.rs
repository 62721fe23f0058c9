//! Pictures of a stage, one moment after another.

use super::backdrop::lay_over_sky;
use super::exit::Failure;
use super::journal::Key;
use super::output::Output;
use super::staged::{self, FurDetail, detail};
use super::view::View;
use glam::Quat;
use image::RgbaImage;
use pelage_bake::io;
use pelage_bake::picture::encode_png;
use pelage_formats::meaning::{hair_motion, srgb_to_linear};
use pelage_runtime::{Camera, Frame, Light, PassReport, Projection};
use pelage_stage::{Shot, Stage};
use pelage_truth::{Lens, TrueCamera};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Moments a second that what swings lives through at least: as many as it takes steps, so that 12, 24, 30 and 60 pictures a second see the same.
const LIVED_PER_S: u32 = hair_motion::STEPS_PER_S as u32;

/// What a picture turned out to be.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Picture {
    /// Pixels with any opacity.
    pub covered_pixels: u64,
    /// Mean luminance of the covered pixels, linear, 0..=1; 0 where none is.
    pub mean_luminance: f64,
    /// The report of the frame that it was drawn from; of a sequence, that of the first alone.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub passes: Vec<PassRun>,
    /// What is drawn of each copy's fur; of a sequence, that of the first alone.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub detail: Vec<FurDetail>,
}

/// Report of a pass of a frame.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct PassRun {
    name: String,
    ran: bool,
    /// Reason why it ran or not.
    reason: String,
}

/// A scene, and the moments at which pictures are taken of it.
pub struct Shoot {
    /// With its device.
    pub scene: Stage,
    /// How it is looked at.
    pub view: View,
    /// From where, before the camera goes around.
    pub shot: Shot,
    /// The key light as it stands.
    pub light: Light,
    /// The light, and the environment with it, goes once around while the pictures last.
    pub turn_light: bool,
    /// The camera goes once around the vertical axis through its target while the pictures last.
    pub auto_rotate: bool,
    /// The first picture that is drawn, of which more is told.
    pub first: usize,
    /// Pictures of the whole.
    pub count: usize,
    /// Of them a second.
    pub fps: u32,
    /// The last moment that hair lived through; `None` where it has lived through none.
    pub lived: Option<i64>,
}

impl Shoot {
    /// Width and height, pixels.
    pub fn size(&self) -> (u32, u32) {
        self.view.size()
    }

    /// What is behind everything, sRGB-encoded; `None` for nothing.
    pub fn background(&self) -> Option<[u8; 3]> {
        self.view.look.background()
    }

    /// Draws picture `index`, from 0.
    pub fn picture(&mut self, index: usize, output: &mut Output) -> Result<(Picture, RgbaImage), Failure> {
        if self.count > 1 {
            output.progress_of(index, self.count, "pictures");
        } else {
            output.progress("drawing");
        }
        let time_s = self.time_s(index as i64 * self.moments());
        if self.count > 1 {
            self.live_until(index)?;
        } else {
            self.scene.set_time(time_s);
        }
        let angle_rad = std::f32::consts::TAU * index as f32 / self.count as f32;
        if self.auto_rotate {
            self.scene.look_from(self.shot.at(time_s).turned(angle_rad));
        }
        let turn_deg = if self.turn_light { angle_rad.to_degrees() } else { 0.0 };
        if self.turn_light {
            self.scene.params.light = turned(self.light, angle_rad);
            let sky = self.view.sky.as_ref().map(|sky| sky.environment().turned(turn_deg));
            if sky.is_some() {
                self.scene.params.environment = sky;
            }
        }
        let (drawn, mut pixels) = picture(&mut self.scene)?;
        if let Some(camera) = of_frame(&self.scene.params.camera) {
            lay_over_sky(&self.view.look, self.view.sky.as_deref(), &mut pixels, &camera, turn_deg);
        }
        // A long sequence of a large crowd would fill memory and journal with what nobody is told.
        let told =
            if index == self.first { drawn } else { Picture { passes: Vec::new(), detail: Vec::new(), ..drawn } };
        Ok((told, pixels))
    }

    /// Moments from one picture to the next: what swings lives through [`LIVED_PER_S`] and more, however few pictures there are.
    fn moments(&self) -> i64 {
        i64::from(LIVED_PER_S.div_ceil(self.fps))
    }

    /// The time of a moment; those before the first picture are below 0.
    fn time_s(&self, moment: i64) -> f32 {
        self.view.time_s + moment as f32 / (self.moments() as f32 * self.fps as f32)
    }

    /// Goes to picture `index`: hair lives through a second before the first, and through all that come before this one, also where those are drawn already.
    fn live_until(&mut self, index: usize) -> Result<(), Failure> {
        let motion = self.view.look.hair_motion().filter(|motion| self.scene.may_move_hair(motion));
        let begins_s = f64::from(self.view.time_s);
        let fps = (self.moments() * i64::from(self.fps)) as f64;
        let clock_s = move |moment: i64| begins_s + moment as f64 / fps;
        let now = index as i64 * self.moments();
        if motion.is_some() {
            let first = self.lived.map_or(-self.moments() * i64::from(self.fps), |last| last + 1);
            for earlier in first..now {
                self.scene.advance(self.time_s(earlier), clock_s(earlier), motion);
                self.scene.pass_by()?;
            }
        }
        self.scene.advance(self.time_s(now), clock_s(now), motion);
        self.lived = Some(now);
        Ok(())
    }

    /// Stands for everything that a picture depends on beside its number and what is drawn.
    pub fn key(&self) -> Key {
        let key =
            Key::of_build().and(self.scene.gpu.in_words()).and(format!("{:?}", self.view)).and(self.fps.to_le_bytes());
        match (self.turn_light, self.auto_rotate) {
            (false, false) => key,
            (light, camera) => key.and(self.count.to_le_bytes()).and([u8::from(light), u8::from(camera)]),
        }
    }
}

/// The camera of a frame for what is reckoned pixel by pixel; a stage makes none that has no lens.
fn of_frame(camera: &Camera) -> Option<TrueCamera> {
    let lens = match camera.projection {
        Projection::Perspective { fov_y_rad, .. } => Lens::Perspective { fov_y_rad },
        Projection::Orthographic { height_m, .. } => Lens::Orthographic { height_m },
        Projection::Custom(_) => return None,
    };
    Some(TrueCamera::from_view(camera.view_from_world, lens))
}

/// Draws the scene as it stands into a PNG file.
pub fn draw(scene: &mut Stage, path: &Path) -> Result<Picture, Failure> {
    let (picture, pixels) = picture(scene)?;
    write_png(path, &pixels)?;
    Ok(picture)
}

/// Writes a picture, and returns the bytes of the file.
pub fn write_png(path: &Path, pixels: &RgbaImage) -> Result<Vec<u8>, Failure> {
    let bytes = encode_png(pixels)?;
    io::write_atomic(path, &bytes)?;
    Ok(bytes)
}

/// Draws the scene as it stands: what it turned out to be, and its pixels, sRGB-encoded with straight alpha.
fn picture(scene: &mut Stage) -> Result<(Picture, RgbaImage), Failure> {
    let frame = scene.draw()?;
    let pixels = staged::pixels(scene)?;
    let picture = Picture {
        covered_pixels: pixels.pixels().filter(|p| p.0[3] > 0).count() as u64,
        mean_luminance: mean_luminance(&pixels),
        passes: passes(&frame),
        detail: detail(&frame),
    };
    Ok((picture, pixels))
}

/// A light carried around the world's vertical axis.
fn turned(light: Light, angle_rad: f32) -> Light {
    let turn = Quat::from_rotation_y(angle_rad);
    match light {
        Light::Directional { towards_light, color } => {
            Light::Directional { towards_light: turn * towards_light, color }
        }
        Light::Point { position, color } => Light::Point { position: turn * position, color },
    }
}

/// Mean luminance (Rec. 709) of the pixels with any opacity.
fn mean_luminance(pixels: &RgbaImage) -> f64 {
    let covered = || pixels.pixels().filter(|p| p.0[3] > 0);
    let of = |p: &image::Rgba<u8>| {
        let [r, g, b, _] = p.0.map(|byte| f64::from(srgb_to_linear(byte)));
        0.2126 * r + 0.7152 * g + 0.0722 * b
    };
    covered().map(of).sum::<f64>() / covered().count().max(1) as f64
}

/// Returns the report of each pass of a frame.
fn passes(frame: &Frame) -> Vec<PassRun> {
    let of = |p: &PassReport| PassRun { name: p.name.into(), ran: p.ran, reason: p.reason.clone() };
    frame.report().passes.iter().map(of).collect()
}
