//! The knobs of a look.

use super::kinds::{
    Background, FillLight, Interval, LookDetail, LookFurShow, LookHair, LookScattering, LookSelfShadow, LookShow,
    LookStrandEdges, LookStyle, LookWidth, PLACE, Rgb, Samples, Size, SkyOf, SkySource, Towards,
};
use super::short::in_laboratory;
#[cfg(feature = "study")]
use super::study::LookStudy;
use crate::framing::TOWARDS_LIGHT;
use glam::Vec3;
use pelage_formats::meaning::environment::Environment;
use pelage_formats::meaning::srgb_to_linear;
use pelage_params::{ParamError, params, tables};
use std::path::Path;
use std::sync::Arc;

params! {
    /// `[picture]`: the picture itself.
    LookPicture in picture {
        /// Size of the picture, pixels. The default is the size in Fang 2006.
        size: Size = Size { width: 834, height: 424 };
        /// How models are drawn.
        style: LookStyle = LookStyle::Fur;
        /// Samples per pixel: 4 smooths edges and thin hair, 1 costs less than half as much.
        samples: Samples = Samples(1);
        /// What is behind the models, sRGB. `auto` is transparent, and paper in ink; `sky` is the environment, in pictures and videos that are written.
        background: Option<Background> = None, or "auto";
    }
}

params! {
    /// `[light]`: the lights. The key light throws shadows, fill lights do not.
    LookLight in light {
        /// Direction towards a distant key light, x,y,z of any length; takes the place of `position_m`.
        direction: [f32; 3] = TOWARDS_LIGHT.to_array(), in PLACE, as Towards, clears position_m;
        /// Place of a key light nearby, x,y,z in metres; takes the place of `direction`.
        position_m: Option<[f32; 3]> = None, in PLACE, or "none";
        /// Strength of the key light. `auto` is 1, and 0 where an environment lights the scene: its sun then is the key light, where it has one.
        strength: Option<f32> = None, in 0.0..=1000.0, or "auto";
        /// Lights without shadow, each with the direction towards it, x,y,z, and a strength of 0 to 1000 (default 1).
        fill: Vec<FillLight> = Vec::new();
    }
}

params! {
    /// `[environment]`: light from all around, a sky or a room. It takes the place of ambient light.
    LookEnvironment in environment {
        /// Where it comes from: a panorama (.hdr, .exr: equirectangular, linear radiance), lights in TOML that were fitted to one (.toml), a colour r,g,b, or
        /// two, above/below; with `:` and degrees behind it turned about the vertical.
        sky: Option<SkySource> = None, or "none";
        /// How many times as bright it is.
        strength: f32 = 1.0, in 0.0..=1000.0;
        /// Colour of a level ground, sRGB, that sends back what comes from above: it takes the place of all that comes from below.
        ground: Option<Rgb> = None, or "none";
        /// How many lights spread about a direction a panorama is taken for; a sun, and what is even, come on top.
        lobes: u32 = 16, in 1..=32;
    }
}

impl LookEnvironment {
    /// Share of light that the ground sends back, linear RGB; `None` without one.
    pub fn ground_color(&self) -> Option<[f32; 3]> {
        self.ground.map(|color| color.0.map(srgb_to_linear))
    }

    /// Light that is said in colours, neither turned nor brightened: what comes from below is what the ground sends back, where there is one. `None` for a file.
    pub fn said(&self) -> Option<Environment> {
        let (above, lights) = match &self.sky.as_ref()?.of {
            SkyOf::File(_) => return None,
            SkyOf::Even(radiance) => (radiance, Environment::constant(*radiance)),
            SkyOf::Gradient(above, below) => (above, Environment::gradient(*above, *below)),
        };
        let Some(ground) = self.ground_color() else { return Some(lights) };
        let comes = lights.onto_ground().as_vec3().to_array();
        Some(Environment::gradient(*above, std::array::from_fn(|i| ground[i] * comes[i])))
    }
}

params! {
    /// `[shadow]`: the shadows of the key light.
    LookShadow in shadow {
        /// How hair shadows hair.
        self_shadow: LookSelfShadow = LookSelfShadow::Auto;
        /// Whether things throw soft shadows, by a shadow-width map.
        soft_shadow: bool = true;
        /// Width of a soft shadow's edge over the distance from what throws it; 0 is a hard shadow.
        penumbra: f32 = 0.15, in 0.0..=2.0;
        /// How far the shadow-width map is shrunk before it is stretched again: more allows wider edges and loses thin things.
        shrink: u32 = 4, in 2..=32;
        /// Width and height of the shadow maps, texels.
        map_texels: u32 = 512, in 16..=8192;
        /// Layers of the layer-wise shadow maps, skin counted; by default as many as are drawn.
        map_layers: Option<u32> = None, in 2..=256, or "drawn";
        /// Share of the layers' optical depth that the key light meets.
        density: f32 = 1.0, in 0.0..=4.0;
    }
}

params! {
    /// `[fur]`: how fur is drawn.
    LookFur in fur {
        /// Shell layers to draw, by default the package's own count. Fewer cost less, and show their steps at the outline.
        layers: Option<u32> = None, in 1..=1024, or "all";
        /// How much of the fur is drawn: `full`, `auto` (the package's levels of detail, by the fur's height on screen), or a level, from 0,
        /// with a fraction for the cross-fade to the next; `layers` goes before it.
        detail: LookDetail = LookDetail::Auto;
        /// Whether fins along the silhouette are drawn, where the package has them.
        fins: bool = true;
        /// What hair is drawn as.
        hair: LookHair = LookHair::Auto;
        /// How pixels are made of single strands.
        strand_edges: LookStrandEdges = LookStrandEdges::Samples;
        /// How hair scatters light, where packages know the fibres that it is made of; other hair is lit as `off`.
        scattering: LookScattering = LookScattering::Multiple;
        /// What is shown: the picture, or false colours for what it is drawn with and how much of it.
        show: LookFurShow = LookFurShow::Picture;
    }
}

params! {
    /// `[motion]`: what moves of itself while time passes: fur, and hair on guides, where packages say how.
    LookMotion in motion {
        /// Whether hair moves in sequences, and wherever else time passes.
        hair: bool = true;
        /// How far fur leans in wind and stride; 0 not at all.
        fur: f32 = 1.0, in 0.0..=4.0;
        /// The wind, x,y,z in metres a second.
        wind: [f32; 3] = [0.0; 3], in -100.0..=100.0;
        /// By how much of that the wind swells and falls.
        gust: f32 = 0.4, in 0.0..=10.0;
        /// Seconds between gusts.
        gust_s: f32 = 3.0, in 0.01..=1000.0;
        /// By how much of it the air at one place differs from that at another.
        turbulence: f32 = 0.3, in 0.0..=10.0;
        /// How large eddies are, metres.
        eddy_m: f32 = 0.5, in 0.001..=1000.0;
        /// Share of the earth's gravity.
        gravity: f32 = 1.0, in 0.0..=100.0;
    }
}

params! {
    /// `[ink]`: how the style `ink` is drawn, after Fang 2006.
    LookInk in ink {
        /// T1 of Fang 2006, §2: where neighbouring normals' dot is lower, there is a line. The default is the cosine of 50°.
        threshold: f32 = 0.64, in 0.15..=1.0;
        /// T1 − T2: lines between the two are thinner and paler.
        weak_difference: f32 = 0.15, in 0.0..=1.0;
        /// Width of the widest line: `auto` is 9 px at 424 rows, pixels are the same at any distance, metres are thinner with distance.
        width: LookWidth = LookWidth::Auto;
        /// Relative step of depth that is a line as well; 0 looks at normals alone.
        depth_step: f32 = 0.01, in 0.0..=1e6;
        /// k of the lines' tone k (0.5 cos + 0.5): lighter with k.
        tone: f32 = 0.35, in 0.0..=1.0;
        /// How far weak lines are lightened.
        weak_lightness: f32 = 0.35, in 0.0..=1.0;
        /// How much the sphere map swells lines.
        swell: f32 = 1.5, in 0.0..=4.0;
        /// How unevenly the hand presses.
        pressure: f32 = 1.0, in 0.0..=1.0;
        /// How far lines run dry.
        dryness: f32 = 0.4, in 0.0..=1.0;
        /// How far the paper moves the edge of lines, pixels.
        roughness_px: f32 = 1.2, in 0.0..=8.0;
        /// Colour of the ink, sRGB. `auto` is nearly black.
        color: Option<Rgb> = None, or "auto";
        /// How much of the paper's relief shows.
        paper_grain: f32 = 1.0, in 0.0..=1.0;
        /// Distances in metres where mist begins and where only it is left.
        mist_m: Option<Interval> = None, or "none";
        /// What is shown: the painting, its lines or features black on white, or the wash.
        show: LookShow = LookShow::Painting;
    }
}

tables! {
    /// The look of a picture. `Look::default()` is fur in soft daylight, 834 × 424 pixels.
    pub struct Look, such as "shadow.penumbra=0.3", elsewhere in_laboratory {
        /// The picture itself.
        picture: LookPicture,
        /// The lights.
        light: LookLight,
        /// Light from all around.
        environment: LookEnvironment,
        /// The shadows of the key light.
        shadow: LookShadow,
        /// How fur is drawn.
        fur: LookFur,
        /// What moves of itself.
        motion: LookMotion,
        /// How the style `ink` is drawn.
        ink: LookInk,
        /// Forms as the papers print them.
        #[cfg(feature = "study")]
        study: LookStudy,
    }
}

/// Lights that a file came to, or what is wrong with it.
pub type LightsRead = Result<Arc<Environment>, String>;

/// Reads one: told its path, how many lobes a panorama is taken for, and what a ground under it sends back ([`LookEnvironment::ground_color`]).
pub type ReadLights<'a> = dyn FnMut(&Path, u32, Option<[f32; 3]>) -> LightsRead + 'a;

impl Look {
    /// The look of a picture of which nothing is said: as the default, but in four samples a pixel, because it is looked at for longer than a frame.
    pub fn of_picture() -> Self {
        let mut look = Self::default();
        look.picture.samples = Samples(4);
        look
    }

    /// Reads a look file over this look: what it leaves out stays as it is.
    ///
    /// # Errors
    /// Line and key of broken TOML, an unknown table or key, a wrong type or a value outside its range.
    pub fn read(&mut self, text: &str) -> Result<(), ParamError> {
        pelage_params::read(self, text)
    }

    /// Sets one key: `shadow.penumbra=0.3`. Strings need no quotes.
    ///
    /// # Errors
    /// As [`Look::read`], without a line; nothing is changed then.
    pub fn set(&mut self, assignment: &str) -> Result<(), ParamError> {
        pelage_params::set(self, assignment)
    }

    /// The look as TOML with every key that has a value. Reading it gives an equal look.
    pub fn to_toml(&self) -> String {
        pelage_params::to_toml(self)
    }

    /// Checks every value against its range.
    ///
    /// # Errors
    /// The first key that is outside.
    pub fn validate(&self) -> Result<(), pelage_params::OutOfRange> {
        pelage_params::validate(self)
    }

    /// Width of the picture over its height.
    pub fn aspect(&self) -> f32 {
        self.picture.size.width as f32 / self.picture.size.height as f32
    }

    /// What is behind everything, sRGB-encoded; `None` for transparent. Paper is the style's own matter.
    pub fn background(&self) -> Option<[u8; 3]> {
        self.picture.background.and_then(Background::color)
    }

    /// The key light.
    pub fn key_light(&self) -> KeyLight {
        match self.light.position_m {
            Some(position) => KeyLight::Nearby(position.into()),
            // Directions that are written down were always normalised here and again by the runtime, the default one by the runtime
            // alone: both stay as they are, because to normalise twice moves the last bits of some, and pictures with them.
            None if self.light.direction == LookLight::default().direction => KeyLight::Distant(TOWARDS_LIGHT),
            None => KeyLight::Distant(unit(self.light.direction)),
        }
    }

    /// The light from all around, turned and as bright as it is said; `None` where there is none, and for a file that was not read yet.
    pub fn light_around(&self) -> Option<Environment> {
        let source = self.environment.sky.as_ref()?;
        let lights = match &source.of {
            SkyOf::File(_) => source.lights.as_deref()?.clone(),
            _ => self.environment.said()?,
        };
        Some(lights.turned(source.yaw_deg).times(self.environment.strength))
    }

    /// Has the file of the environment read, where there is one and it was not yet: `read` is told of it.
    ///
    /// # Errors
    /// What `read` says.
    pub fn take_lights(&mut self, read: &mut ReadLights<'_>) -> Result<(), String> {
        let (lobes, ground) = (self.environment.lobes, self.environment.ground_color());
        if let Some(SkySource { of: SkyOf::File(path), lights: lights @ None, .. }) = &mut self.environment.sky {
            *lights = Some(read(Path::new(path), lobes, ground)?);
        }
        Ok(())
    }

    /// Strength of the key light: none beside an environment, but where it is said.
    pub fn key_strength(&self) -> f32 {
        self.light.strength.unwrap_or(if self.environment.sky.is_some() { 0.0 } else { 1.0 })
    }

    /// Lets the file of the environment be looked for in that folder, where its path is not a whole one.
    pub fn files_in(&mut self, folder: &Path) {
        if let Some(SkySource { of: SkyOf::File(path), .. }) = &mut self.environment.sky {
            *path = folder.join(&*path).display().to_string();
        }
    }

    /// As [`Look::read`], of a look file in that folder: files that it names are looked for there.
    ///
    /// # Errors
    /// As [`Look::read`].
    pub fn read_in(&mut self, folder: &Path, text: &str) -> Result<(), ParamError> {
        let before = self.environment.sky.take();
        let read = self.read(text);
        match &self.environment.sky {
            Some(_) => self.files_in(folder),
            None => self.environment.sky = before,
        }
        read
    }

    /// Whether ambient light fades towards the skin, and whether the key light ends behind the body: false in a printed
    /// form alone.
    pub fn attenuations(&self) -> [bool; 2] {
        #[cfg(feature = "study")]
        return [self.study.ambient_attenuation, self.study.back_attenuation];
        #[cfg(not(feature = "study"))]
        [true; 2]
    }

    /// The lights without shadow: towards each, length 1, and its strength.
    pub fn fill_lights(&self) -> impl Iterator<Item = (Vec3, f32)> {
        self.light.fill.iter().map(|fill| (unit(fill.direction), fill.strength))
    }

    /// Makes the key light distant, in that direction.
    pub(crate) fn light_from(&mut self, direction: Vec3) {
        self.light.direction = direction.to_array();
        self.light.position_m = None;
    }
}

/// Where the key light is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum KeyLight {
    /// Far away, in this direction.
    Distant(Vec3),
    /// At this place, metres.
    Nearby(Vec3),
}

fn unit(direction: [f32; 3]) -> Vec3 {
    let direction = Vec3::from(direction);
    direction.try_normalize().unwrap_or(direction)
}
