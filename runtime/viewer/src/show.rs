//! Content of the window: a subject on a stage, with camera and time.

use crate::subject::{ClipInfo, Features, Subject};
use image::RgbaImage;
use pelage_runtime::{FrameReport, wgpu};
use pelage_stage::{
    CameraTrack, Framing, Gpu, Look, LookHair, Navigator, Orbit, Size, Stage, StageError, Viewpoint, frame_actors,
};
use std::cell::Cell;
use std::time::{Duration, Instant};

/// Time difference above which a change of time is a jump, seconds. A jump restarts hair motion.
const LEAP_S: f32 = 0.25;

/// Subject on a stage.
pub struct Show {
    gpu: Gpu,
    stage: Option<Stage>,
    subject: Option<Subject>,
    features: Features,
    clips: Vec<ClipInfo>,
    /// Index into `clips`; `None` for the rest pose.
    clip: Option<usize>,
    /// Look; its picture size is replaced by that of the window.
    look: Look,
    /// Whether all packages of the subject have fibre data.
    fibres: bool,
    /// The subject's own camera over time, if any.
    shot: Option<CameraTrack>,
    navigator: Option<Navigator>,
    /// Cached camera that frames the whole subject in a picture of the given size. Its computation traverses the whole
    /// model.
    framed: Cell<Option<((u32, u32), Viewpoint)>>,
    /// Time of the animation, seconds.
    time_s: f32,
    /// Simulation time of hair, seconds. Continues while a clip is paused, and when it restarts.
    clock_s: f64,
    /// State in which the canvas was drawn. As long as it is unchanged, nothing is redrawn.
    drawn: Option<DrawnState>,
    last: Option<LastFrame>,
}

/// Everything on which a picture depends.
#[derive(Clone, Debug, PartialEq)]
struct DrawnState {
    /// Look, with the size of the picture.
    look: Look,
    view: Viewpoint,
    time_s: f32,
}

/// Statistics of the last frame.
#[derive(Clone, Debug, Default)]
pub struct LastFrame {
    /// Time from the start of the frame until the device finished it.
    pub took: Duration,
    /// Size, pixels.
    pub size: (u32, u32),
    /// Report of the frame's passes and of the fur drawn.
    pub report: FrameReport,
}

impl Show {
    /// Creates an empty stage on a device.
    pub fn new(gpu: Gpu) -> Self {
        Self {
            gpu,
            stage: None,
            subject: None,
            features: Features::default(),
            clips: Vec::new(),
            clip: None,
            look: Look::of_picture(),
            fibres: false,
            shot: None,
            navigator: None,
            framed: Cell::new(None),
            time_s: 0.0,
            clock_s: 0.0,
            drawn: None,
            last: None,
        }
    }

    /// Returns whether the device is a software renderer. Its pictures are smaller during movement.
    pub fn is_software(&self) -> bool {
        self.gpu.info.device_type == wgpu::DeviceType::Cpu
    }

    /// Returns the subject.
    pub fn subject(&self) -> Option<&Subject> {
        self.subject.as_ref()
    }

    /// Returns the subject's clips.
    pub fn clips(&self) -> &[ClipInfo] {
        &self.clips
    }

    /// Returns the current clip.
    pub fn clip(&self) -> Option<&ClipInfo> {
        self.clip.and_then(|clip| self.clips.get(clip))
    }

    /// Returns the last frame.
    pub fn last(&self) -> Option<&LastFrame> {
        self.last.as_ref()
    }

    /// Returns whether a condition of the look's knobs ([`pelage_stage::CONDITIONS`]) holds.
    pub fn holds(&self, condition: &str) -> bool {
        let instances = self.last.as_ref().map_or(&[][..], |last| &last.report.instances);
        let drawn = [instances.iter().any(|drawn| drawn.layers > 0), instances.iter().any(|drawn| drawn.strands > 0.0)];
        self.features.holds(condition, drawn)
    }

    /// Returns the time, seconds.
    pub fn time_s(&self) -> f32 {
        self.time_s
    }

    /// Returns the device memory of models, their copies and shadow maps, bytes.
    pub fn gpu_bytes(&self) -> u64 {
        self.stage.as_ref().map_or(0, |stage| stage.model().gpu_bytes() + stage.copies_bytes() + stage.shadow_bytes())
    }

    /// Shows another subject. If it is a new bake of the current one, by name, the camera stays.
    ///
    /// Fails like [`Stage::new`]; the previous subject stays.
    pub fn show(&mut self, subject: Subject, size: (u32, u32)) -> Result<(), StageError> {
        if let (Some(stage), Some(before)) = (&mut self.stage, &self.subject)
            && let Some(shading) = before.other_shading(&subject)
        {
            stage.set_shading(shading)?;
            (self.subject, self.drawn) = (Some(subject), None);
            return Ok(());
        }
        let is_same = self.subject.as_ref().is_some_and(|before| before.name() == subject.name());
        let clips = subject.clips();
        let named = self.clip().map(|clip| clip.name.clone()).filter(|_| is_same);
        let clip = named.and_then(|name| clips.iter().position(|clip| clip.name == name));
        self.load(&subject, clip.map(|clip| &clips[clip]), size)?;
        (self.clips, self.clip) = (clips, clip);
        self.shot = match &subject {
            Subject::Package(_) => None,
            Subject::Scene(scene) => scene.camera.clone(),
        };
        self.features = subject.features();
        self.subject = Some(subject);
        if !is_same {
            self.navigator = None;
            self.time_s = 0.0;
        }
        Ok(())
    }

    /// Plays another clip; `None` is the rest pose.
    ///
    /// Fails like [`Stage::set_cast`].
    pub fn play(&mut self, clip: Option<usize>, size: (u32, u32)) -> Result<(), StageError> {
        let Some(subject) = self.subject.clone() else { return Ok(()) };
        let info = clip.and_then(|clip| self.clips.get(clip)).cloned();
        // The camera stays, even if the bounds of the new clip differ.
        let view = self.view(size)?;
        self.load(&subject, info.as_ref(), size)?;
        if self.navigator.is_none() && self.shot.is_none() {
            self.navigator = Some(Navigator::new(view));
        }
        self.clip = clip.filter(|_| info.is_some());
        Ok(())
    }

    fn load(&mut self, subject: &Subject, clip: Option<&ClipInfo>, size: (u32, u32)) -> Result<(), StageError> {
        let look = self.sized(size);
        let cast = subject.cast(clip.map(|clip| clip.name.as_str()), None, look.aspect())?;
        let fibres = cast.has_fibres()?;
        let (look, time_s) = (look.resolved(fibres), self.time_s);
        (self.fibres, self.drawn) = (fibres, None);
        self.framed.set(None);
        match &mut self.stage {
            Some(stage) => {
                stage.set_look(&look.picture(), look.frame_params(), time_s)?;
                stage.set_cast(&cast, time_s)
            }
            None => {
                let gpu = self.gpu.clone();
                self.stage = Some(Stage::new(&cast, &look.picture(), look.frame_params(), time_s, || Ok(gpu))?);
                Ok(())
            }
        }
    }

    /// Sets the look.
    ///
    /// Fails like [`Stage::new`], if a new stage is needed; the previous look stays.
    pub fn set_look(&mut self, look: Look, size: (u32, u32)) -> Result<(), StageError> {
        if look == self.look {
            return Ok(());
        }
        let before = std::mem::replace(&mut self.look, look);
        if before.picture.samples == self.look.picture.samples {
            return Ok(());
        }
        let (stage, subject, clip) = (self.stage.take(), self.subject.clone(), self.clip().cloned());
        let loaded = subject.map_or(Ok(()), |subject| self.load(&subject, clip.as_ref(), size));
        if loaded.is_err() {
            (self.stage, self.look) = (stage, before);
        }
        loaded
    }

    /// Seeks to a time, seconds.
    pub fn set_time(&mut self, time_s: f32) {
        if (time_s - self.time_s).abs() > LEAP_S
            && let Some(stage) = &mut self.stage
        {
            stage.reset_hair();
        }
        self.time_s = time_s;
    }

    /// Advances time by `seconds`, and the clip by `speed` times as much; a paused clip has speed 0. Hair moves in any
    /// case.
    pub fn advance(&mut self, seconds: f32, speed: f32) {
        self.time_s += speed * seconds;
        self.clock_s += f64::from(seconds);
    }

    /// Returns whether hair still moves in the last picture, so that the next frame must be drawn.
    pub fn hair_moves(&self) -> bool {
        self.drawn.is_some() && self.last.as_ref().is_some_and(|last| last.report.hair_moves)
    }

    fn sized(&self, (width, height): (u32, u32)) -> Look {
        let mut look = self.look.clone();
        look.picture.size = Size { width, height };
        look
    }

    /// Returns the current camera.
    ///
    /// Fails with [`StageError::Package`] for a damaged package.
    pub fn view(&self, size: (u32, u32)) -> Result<Viewpoint, StageError> {
        match (&self.navigator, &self.shot) {
            (Some(navigator), _) => Ok(navigator.view()),
            (None, Some(shot)) => Ok(shot.at(self.time_s)),
            (None, None) => match self.framed.get().filter(|(of, _)| *of == size) {
                Some((_, view)) => Ok(view),
                None => self.framed(None, size).inspect(|view| self.framed.set(Some((size, *view)))),
            },
        }
    }

    /// Returns a camera that frames the whole subject from the direction `orbit`.
    fn framed(&self, orbit: Option<Orbit>, size: (u32, u32)) -> Result<Viewpoint, StageError> {
        let Some(subject) = &self.subject else {
            return Ok(Framing::default().view(&[], 0.0, 1.0));
        };
        let aspect = self.sized(size).aspect();
        let cast = subject.cast(self.clip().map(|clip| clip.name.as_str()), None, aspect)?;
        frame_actors(&cast.packages, &cast.actors, aspect, &Framing { orbit, ..Framing::default() })
    }

    /// Returns the camera for user control. It starts at the position of the current camera.
    ///
    /// Fails like [`Self::view`].
    pub fn navigator(&mut self, size: (u32, u32)) -> Result<&mut Navigator, StageError> {
        if self.navigator.is_none() {
            self.navigator = Some(Navigator::new(self.view(size)?));
        }
        // The code above has set it, so the fallback is never used.
        Ok(self.navigator.get_or_insert_with(|| Navigator::new(Framing::default().view(&[], 0.0, 1.0))))
    }

    /// Frames the whole subject from the same side as before.
    ///
    /// Fails like [`Self::view`].
    pub fn frame(&mut self, size: (u32, u32)) -> Result<(), StageError> {
        let (azimuth_deg, elevation_deg, _) = self.navigator(size)?.spherical();
        let view = self.framed(Some(Orbit { azimuth_deg, elevation_deg, zoom: 1.0 }), size)?;
        self.navigator = Some(Navigator::new(view));
        Ok(())
    }

    /// Resets the camera to that of the subject, or else to the default one.
    pub fn reset(&mut self) {
        self.navigator = None;
    }

    /// Draws to the canvas if anything changed. Returns whether it has drawn. A draft shows fur as layers, for pictures
    /// during movement.
    ///
    /// Fails with [`StageError::Params`] for a look that the device or the package does not support.
    /// [`StageError::Device`] if the device is lost.
    pub fn draw(&mut self, size: (u32, u32), draft: bool) -> Result<bool, StageError> {
        let mut look = self.sized(size).resolved(self.fibres);
        if draft {
            // Strands cost the same at any size, but layers a quarter at half the size.
            look.fur.hair = LookHair::Shells;
        }
        let wanted = DrawnState { look, view: self.view(size)?, time_s: self.time_s };
        if self.drawn.as_ref() == Some(&wanted) && !self.hair_moves() {
            return Ok(false);
        }
        let (look, time_s) = (&wanted.look, self.time_s);
        let Some(stage) = &mut self.stage else { return Ok(false) };
        let began = Instant::now();
        let looks_otherwise = self.drawn.as_ref().is_none_or(|drawn| drawn.look != *look);
        if looks_otherwise {
            stage.set_look(&look.picture(), look.frame_params(), time_s)?;
        }
        stage.play(time_s);
        stage.look_from(wanted.view);
        stage.advance_hair(self.clock_s, look.hair_motion());
        let frame = stage.draw()?;
        self.last = Some(LastFrame { took: began.elapsed(), size, report: frame.report().clone() });
        self.drawn = Some(wanted);
        Ok(true)
    }

    /// Returns the last picture, for display.
    pub fn picture_view(&self) -> Option<wgpu::TextureView> {
        Some(self.stage.as_ref()?.canvas.encoded())
    }

    /// Returns whether the last picture covers no pixel; false for one with an opaque background.
    ///
    /// Fails with [`StageError::Device`] if the device is lost.
    pub fn is_empty(&self) -> Result<bool, StageError> {
        let Some(stage) = self.stage.as_ref().filter(|_| self.drawn.is_some()) else { return Ok(false) };
        Ok(stage.canvas.read(&stage.gpu)?.chunks_exact(4).all(|pixel| pixel[3] == 0))
    }

    /// Draws the picture in the given size, as `pelage render` does: sRGB-encoded, straight alpha.
    ///
    /// Fails like [`Self::draw`].
    pub fn picture(&mut self, size: (u32, u32)) -> Result<Option<RgbaImage>, StageError> {
        self.draw(size, false)?;
        let Some(stage) = &self.stage else { return Ok(None) };
        let pixels = stage.canvas.read(&stage.gpu)?;
        Ok(RgbaImage::from_raw(size.0, size.1, pixels))
    }

    /// Returns the stage for measurements. The picture is redrawn afterwards.
    pub fn stage(&mut self) -> Option<&mut Stage> {
        self.drawn = None;
        self.stage.as_mut()
    }
}
