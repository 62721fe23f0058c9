//! Tables of the look's knobs.

use super::kinds::{
    Background, DirectionField, FillLight, Interval, LookDetail, LookFurShow, LookHair, LookLines, LookScattering,
    LookSelfShadow, LookSheet, LookShow, LookStrandEdges, LookStudio, LookStyle, LookToneMapping, LookWidth, PLACE,
    Rgb, Samples, SealSource, Size, SkyKind, SkySource,
};
use super::short::laboratory_hint;
#[cfg(feature = "study")]
use super::study::LookStudy;
use crate::framing::TOWARDS_LIGHT;
use crate::sky::studio;
use glam::Vec3;
use pelage_formats::meaning::environment::Environment;
use pelage_formats::meaning::seal::SealImage;
use pelage_formats::meaning::srgb_to_linear;
use pelage_params::{ParamError, params, tables};
use std::path::Path;
use std::sync::Arc;

/// Conditions of knobs ([`needs`](pelage_params::Knob::needs)) that depend on the packages or on the last picture. The
/// second text is the reason why a knob has no effect without the condition.
pub const CONDITIONS: [(&str, &str); 7] = [
    ("fur", "the package has no hair"),
    ("strands", "the package has no single strands of fur"),
    ("fins", "the package has no fins"),
    ("fibres", "the package has no fibre data"),
    ("moving hair", "no hair of the package moves"),
    ("drawn layers", "the picture shows no layers, because single strands replace them"),
    ("drawn strands", "the picture shows no single strands, because layers replace them"),
];

params! {
    /// `[picture]`: size, style and background of the picture.
    LookPicture in picture {
        /// Size of the picture, pixels. The default is the size in Fang 2006.
        size: Size = Size { width: 834, height: 424 };
        /// Rendering style.
        style: LookStyle = LookStyle::Fur;
        /// Samples per pixel: 4 smooths edges and thin hair; 1 takes less than half the time.
        samples: Samples = Samples(1);
        /// Background behind the models, sRGB. `auto` is transparent, or paper with the style `ink`. `studio` is the
        /// neutral floor and wall of a studio, with the shadow of the models. `sky` is the environment map, in pictures
        /// and videos written to files.
        background: Option<Background> = None, or "auto";
        /// Whether the models cast a soft shadow on an invisible ground below them.
        ground_shadow: bool = false, needs "picture.style!=ink";
        /// Exposure in stops: a factor of two on all light for each. The style ink is unchanged.
        exposure: f32 = 0.0, in -10.0..=10.0, needs "picture.style!=ink";
        /// Tone mapping of bright colours.
        tone_mapping: LookToneMapping = LookToneMapping::Auto, needs "picture.style!=ink";
    }
}

params! {
    /// `[light]`: the lights. The key light casts shadows, fill lights do not.
    LookLight in light {
        /// Direction towards a distant key light, x,y,z of any length. Replaces `position_m`.
        direction: [f32; 3] = TOWARDS_LIGHT.to_array(), in PLACE, as DirectionField, clears position_m;
        /// Position of a nearby key light, x,y,z in metres. Replaces `direction`.
        position_m: Option<[f32; 3]> = None, in PLACE, or "none";
        /// Strength of the key light. `auto` is 1 without an environment map. With one, `auto` is 0, and the map's sun,
        /// if any, is the key light.
        strength: Option<f32> = None, in 0.0..=1000.0, or "auto";
        /// Fill lights, which cast no shadows. Each has the direction towards it, x,y,z, and a strength of 0 to 1000
        /// (default 1).
        fill: Vec<FillLight> = Vec::new();
        /// Light of fur if the look names neither a light nor an environment map.
        studio: LookStudio = LookStudio::Auto, needs "fibres", needs "environment.sky=none";
    }
}

params! {
    /// `[environment]`: environment map, such as a sky or a room. It replaces the ambient light.
    LookEnvironment in environment {
        /// Source of the environment map. It is `studio`, which is built in, a panorama (.hdr, .exr: equirectangular,
        /// linear radiance), a file of lights fitted to one (.toml), a colour r,g,b, or two colours above/below. A
        /// suffix `:` and degrees rotates the map about the vertical axis.
        sky: Option<SkySource> = None, or "none";
        /// Factor on the map's brightness.
        strength: f32 = 1.0, in 0.0..=1000.0, needs "environment.sky!=none";
        /// Colour of a level ground, sRGB. The ground reflects the light from above and replaces all light from below.
        ground: Option<Rgb> = None, or "none", needs "environment.sky!=none";
        /// Number of lobes to fit to a panorama, in addition to its sun and uniform light.
        lobes: u32 = 16, in 1..=32, needs "environment.sky!=none";
    }
}

impl LookEnvironment {
    /// Returns the albedo of the ground, linear RGB; `None` without a ground.
    pub fn ground_color(&self) -> Option<[f32; 3]> {
        self.ground.map(|color| color.0.map(srgb_to_linear))
    }

    /// Returns the environment map if it is not a file, neither rotated nor scaled. A ground, if set, replaces the
    /// light from below by the light that it reflects. `None` for a file.
    pub fn built_in(&self) -> Option<Environment> {
        let (above, lights) = match &self.sky.as_ref()?.kind {
            SkyKind::File(_) => return None,
            SkyKind::Studio => return Some(studio(self.ground_color())),
            SkyKind::Even(radiance) => (radiance, Environment::constant(*radiance)),
            SkyKind::Gradient(above, below) => (above, Environment::gradient(*above, *below)),
        };
        let Some(ground) = self.ground_color() else { return Some(lights) };
        let comes = lights.ground_irradiance().as_vec3().to_array();
        Some(Environment::gradient(*above, std::array::from_fn(|i| ground[i] * comes[i])))
    }
}

params! {
    /// `[shadow]`: the shadows of the key light.
    LookShadow in shadow, needs "picture.style!=ink" {
        /// Method for the self-shadow of hair.
        self_shadow: LookSelfShadow = LookSelfShadow::Auto, needs "picture.style=fur", needs "fur";
        /// Whether shadows of objects are soft, by means of a shadow-width map.
        soft_shadow: bool = true;
        /// Penumbra width divided by the distance between caster and receiver; 0 gives hard shadows.
        penumbra: f32 = 0.15, in 0.0..=2.0, needs "shadow.soft_shadow=true";
        /// Factor by which the shadow-width map is downscaled before it is upscaled again. Larger factors allow wider
        /// penumbras, but lose thin objects.
        shrink: u32 = 4, in 2..=32, needs "shadow.soft_shadow=true";
        /// Width and height of the shadow maps, texels.
        map_texels: u32 = 512, in 16..=8192;
        /// Number of layers with a shadow map, skin included. By default it is the number of layers drawn.
        map_layers: Option<u32> = None, in 2..=256, or "drawn", needs "picture.style=fur",
            needs "shadow.self_shadow!=off";
        /// Factor on the layers' optical depth as seen by the key light.
        density: f32 = 1.0, in 0.0..=4.0, needs "picture.style=fur", needs "shadow.self_shadow!=off";
    }
}

params! {
    /// `[fur]`: the rendering of fur.
    LookFur in fur, needs "picture.style=fur", needs "fur" {
        /// Number of shell layers, by default that of the package. Fewer take less time, but show as steps at the
        /// outline.
        layers: Option<u32> = None, in 1..=1024, or "all";
        /// Level of detail: `full`, `auto`, or a level number. `auto` uses the package's levels by the fur's height on
        /// the screen. The fractional part of a number is the cross-fade to the next level. `layers` overrides this
        /// key.
        detail: LookDetail = LookDetail::Auto, needs "fur.layers=all";
        /// Whether fins along the silhouette are drawn, if the package has them.
        fins: bool = true, needs "fins", needs "drawn layers";
        /// Geometry by which hair is drawn.
        hair: LookHair = LookHair::Auto, needs "strands";
        /// Rendering of the edges of strands.
        strand_edges: LookStrandEdges = LookStrandEdges::Blended, needs "drawn strands";
        /// Scattering model of hair, for packages with fibre data. Other hair is always lit as with `off`.
        scattering: LookScattering = LookScattering::Multiple, needs "fibres";
        /// Output: the picture, or false colours for its geometry or overdraw.
        show: LookFurShow = LookFurShow::Picture;
    }
}

params! {
    /// `[motion]`: motion of fur and guide hair over time, if the package enables it.
    LookMotion in motion, needs "moving hair" {
        /// Whether hair moves in sequences and wherever else time passes.
        hair: bool = true;
        /// Strength of the fur's lean in wind and motion; 0 disables it.
        fur: f32 = 1.0, in 0.0..=4.0, needs "motion.hair=true";
        /// Wind velocity, x,y,z in metres per second.
        wind: [f32; 3] = [0.0; 3], in -100.0..=100.0, needs "motion.hair=true";
        /// Strength of gusts, relative to the wind.
        gust: f32 = 0.4, in 0.0..=10.0, needs "motion.hair=true", needs "motion.wind!=[0.0, 0.0, 0.0]";
        /// Time between gusts, seconds.
        gust_s: f32 = 3.0, in 0.01..=1000.0, needs "motion.hair=true", needs "motion.wind!=[0.0, 0.0, 0.0]";
        /// Relative variation of the wind with position.
        turbulence: f32 = 0.3, in 0.0..=10.0, needs "motion.hair=true", needs "motion.wind!=[0.0, 0.0, 0.0]";
        /// Size of eddies, metres.
        eddy_m: f32 = 0.5, in 0.001..=1000.0, needs "motion.hair=true", needs "motion.wind!=[0.0, 0.0, 0.0]";
        /// Factor on the earth's gravity.
        gravity: f32 = 1.0, in 0.0..=100.0, needs "motion.hair=true";
    }
}

params! {
    /// `[ink]`: the style `ink`.
    LookInk in ink, needs "picture.style=ink" {
        /// Form of lines and washes. `strokes` needs a package baked since it exists; otherwise `pixels` is drawn.
        lines: LookLines = LookLines::Strokes;
        /// Threshold T1 of Fang 2006, §2: a line is drawn where the dot product of neighbouring normals is below it.
        /// The default is the cosine of 50°.
        threshold: f32 = 0.64, in 0.15..=1.0, needs "ink.lines=pixels";
        /// Difference T1 − T2. Lines between the two thresholds are thinner and paler.
        weak_difference: f32 = 0.15, in 0.0..=1.0, needs "ink.lines=pixels";
        /// Width of the widest line. `auto` is 9 px at 424 rows. A width in pixels is the same at any distance; one in
        /// metres becomes thinner with distance.
        width: LookWidth = LookWidth::Auto, needs "ink.lines=pixels";
        /// Relative depth difference above which a line is also drawn; 0 disables the depth test.
        depth_step: f32 = 0.01, in 0.0..=1e6, needs "ink.lines=pixels";
        /// Factor k of the lines' tone, k (0.5 cos + 0.5). A larger k gives lighter lines.
        tone: f32 = 0.35, in 0.0..=1.0, needs "ink.lines=pixels";
        /// Lightness added to weak lines.
        weak_lightness: f32 = 0.35, in 0.0..=1.0, needs "ink.lines=pixels";
        /// Strength with which the sphere map widens lines.
        swell: f32 = 1.5, in 0.0..=4.0, needs "ink.lines=pixels";
        /// Variation of the brush pressure: 0 is an even width, 1 swells and lifts.
        pressure: f32 = 1.0, in 0.0..=1.0;
        /// Dryness of lines.
        dryness: f32 = 0.4, in 0.0..=1.0, needs "ink.lines=pixels";
        /// Displacement of the lines' edges by the paper, pixels.
        roughness_px: f32 = 1.2, in 0.0..=8.0, needs "ink.lines=pixels";
        /// Colour of the ink, sRGB. `auto` is nearly black.
        color: Option<Rgb> = None, or "auto";
        /// Visibility of the paper's relief.
        paper_grain: f32 = 1.0, in 0.0..=1.0;
        /// Two distances in metres: where mist begins, and where only mist is visible.
        mist_m: Option<Interval> = None, or "none";
        /// Image of a seal, stamped last: its white leaves the painting as it was. `seal.png:0.9,0.88,0.1` has its
        /// centre at .9 of the width and .88 of the height, and is .1 of the picture high, which is the default place.
        seal: Option<SealSource> = None, or "none";
        /// Output: the painting, its lines or features in black on white, or the wash.
        show: LookShow = LookShow::Painting, needs "ink.lines=pixels";
    }
}

params! {
    /// `[brush]`: the brush strokes of the style `ink`.
    LookBrush in brush, needs "ink.lines=strokes" {
        /// Approximate number of strokes on an animal, without tufts of fur: 4 leaves most of the paper blank, 200
        /// models every muscle.
        strokes: f32 = 60.0, in 4.0..=200.0;
        /// Factor on the density of the washes: 0 paints only lines, spots and tufts, 2 is as dark as wet ink.
        wash: f32 = 1.0, in 0.0..=2.0;
        /// Wetness of the washes: 0 keeps each stroke apart, 1 lets them run into each other and gathers pigment at
        /// their edges.
        wetness: f32 = 0.6, in 0.0..=1.0;
        /// Dryness of the brush: 0 is full of ink to the end of a stroke, 1 breaks up early.
        dryness: f32 = 0.5, in 0.0..=1.0;
        /// Number of tufts of fur on an animal: 0 paints none and no guided hair, 10 all of that hair, 200 a shaggy
        /// coat.
        tufts: f32 = 45.0, in 0.0..=200.0;
        /// Factor on the width of lines: 0 draws no lines, 4 is a thick brush.
        line_width: f32 = 1.0, in 0.0..=4.0;
        /// Share of the contour that is left out where washes already show it: 0 draws all of it.
        omission: f32 = 1.0, in 0.0..=1.0;
        /// Density of the wash on the ground below an animal: 0 none, 1 a dark bank.
        ground: f32 = 0.5, in 0.0..=1.0;
        /// Sheet that the painting is on.
        sheet: LookSheet = LookSheet::Raw;
        /// Share of the painting that is done: strokes appear one after the other, from the washes to the fur.
        progress: f32 = 1.0, in 0.0..=1.0;
    }
}

tables! {
    /// Look of a picture. `Look::default()` is fur in the built-in studio, 834 × 424 pixels.
    pub struct Look, such as "shadow.penumbra=0.3", elsewhere laboratory_hint {
        /// Size, style and background of the picture.
        picture: LookPicture,
        /// Key light and fill lights.
        light: LookLight,
        /// Environment map.
        environment: LookEnvironment,
        /// Shadows of the key light.
        shadow: LookShadow,
        /// Rendering of fur.
        fur: LookFur,
        /// Motion of fur and guided hair.
        motion: LookMotion,
        /// Style `ink`.
        ink: LookInk,
        /// Brush strokes of the style `ink`.
        brush: LookBrush,
        /// Published forms of the papers' formulas.
        #[cfg(feature = "study")]
        study: LookStudy,
    }
}

/// Lights read from an environment map file, or an error message.
pub type LightsRead = Result<Arc<Environment>, String>;

/// Callback that loads an environment map. Arguments: path, number of lobes to fit, and albedo of a ground below it
/// ([`LookEnvironment::ground_color`]).
pub type ReadLights<'a> = dyn FnMut(&Path, u32, Option<[f32; 3]>) -> LightsRead + 'a;

/// Callback that loads the image of a seal.
pub type ReadSeal<'a> = dyn FnMut(&Path) -> Result<Arc<SealImage>, String> + 'a;

impl Look {
    /// Returns the default look of a still picture. It has four samples per pixel, because a still picture is viewed
    /// for longer than a frame.
    pub fn of_picture() -> Self {
        let mut look = Self::default();
        look.picture.samples = Samples(4);
        look
    }

    /// Reads a look file over this look. Keys that are missing in the file are unchanged.
    ///
    /// Fails with line and key of invalid TOML, an unknown table or key, a wrong type, or a value out of range.
    pub fn read(&mut self, text: &str) -> Result<(), ParamError> {
        pelage_params::read(self, text)
    }

    /// Sets one key: `shadow.penumbra=0.3`. Strings need no quotes.
    ///
    /// Fails like [`Look::read`], without a line. The look is then unchanged.
    pub fn set(&mut self, assignment: &str) -> Result<(), ParamError> {
        pelage_params::set(self, assignment)
    }

    /// Returns the look as TOML, with every key that has a value. Reading the text gives an equal look.
    pub fn to_toml(&self) -> String {
        pelage_params::to_toml(self)
    }

    /// Checks every value against its range.
    ///
    /// Fails with the first key that is out of range.
    pub fn validate(&self) -> Result<(), pelage_params::OutOfRange> {
        pelage_params::validate(self)
    }

    /// Returns the width of the picture divided by its height.
    pub fn aspect(&self) -> f32 {
        self.picture.size.width as f32 / self.picture.size.height as f32
    }

    /// Returns the background colour, sRGB-encoded; `None` for transparent. The style `ink` draws the paper itself.
    pub fn background(&self) -> Option<[u8; 3]> {
        self.picture.background.and_then(Background::color)
    }

    /// Returns the key light.
    pub fn key_light(&self) -> KeyLight {
        match self.light.position_m {
            Some(position) => KeyLight::Nearby(position.into()),
            // For compatibility, explicit directions are normalised here and again by the runtime, the default
            // direction only by the runtime. Normalising twice changes the last bits of some directions, and thus
            // pictures.
            None if self.light.direction == LookLight::default().direction => KeyLight::Distant(TOWARDS_LIGHT),
            None => KeyLight::Distant(unit(self.light.direction)),
        }
    }

    /// Returns the environment map, rotated and scaled. `None` without a map, or for a file that has not been read.
    pub fn environment(&self) -> Option<Environment> {
        let source = self.environment.sky.as_ref()?;
        let lights = match &source.kind {
            SkyKind::File(_) => source.lights.as_deref()?.clone(),
            _ => self.environment.built_in()?,
        };
        Some(lights.turned(source.yaw_deg).scaled(self.environment.strength))
    }

    /// Reads the environment map file with `read`, unless it has been read already or there is none.
    ///
    /// Fails with the error of `read`.
    pub fn read_environment(&mut self, read: &mut ReadLights<'_>) -> Result<(), String> {
        let (lobes, ground) = (self.environment.lobes, self.environment.ground_color());
        if let Some(SkySource { kind: SkyKind::File(path), lights: lights @ None, .. }) = &mut self.environment.sky {
            *lights = Some(read(Path::new(path), lobes, ground)?);
        }
        Ok(())
    }

    /// Reads the image of the seal with `read`, unless it has been read already or there is none.
    ///
    /// Fails with the error of `read`.
    pub fn read_seal(&mut self, read: &mut ReadSeal<'_>) -> Result<(), String> {
        if let Some(SealSource { file, image: image @ None, .. }) = &mut self.ink.seal {
            *image = Some(read(Path::new(file))?);
        }
        Ok(())
    }

    /// Returns the look with the built-in studio as its environment map, if it names neither a light nor a map
    /// ([`LookStudio::Auto`]). The style must be fur with scattering.
    ///
    /// * `fibres`: whether all packages of the picture have fibre data
    pub fn resolved(&self, fibres: bool) -> Self {
        let mut look = self.clone();
        let unlit = look.environment.sky.is_none() && look.light == LookLight::default();
        let scatters = look.picture.style == LookStyle::Fur && look.fur.scattering != LookScattering::Off;
        if fibres && unlit && scatters {
            look.environment.sky = Some(SkySource { kind: SkyKind::Studio, yaw_deg: 0.0, lights: None });
        }
        look
    }

    /// Returns the factor on all light that the exposure stands for.
    pub fn exposure(&self) -> f32 {
        self.picture.exposure.exp2()
    }

    /// Returns whether bright colours are tone-mapped. [`LookToneMapping::Auto`] maps them in the built-in studio.
    pub fn is_tone_mapped(&self) -> bool {
        match self.picture.tone_mapping {
            LookToneMapping::Auto => self.environment.sky.as_ref().is_some_and(|sky| sky.kind == SkyKind::Studio),
            LookToneMapping::Filmic => true,
            LookToneMapping::Off => false,
        }
    }

    /// Returns the strength of the key light. With an environment map it is 0 unless the look sets it.
    pub fn key_strength(&self) -> f32 {
        self.light.strength.unwrap_or(if self.environment.sky.is_some() { 0.0 } else { 1.0 })
    }

    /// Resolves relative paths of the environment map file and the seal against `folder`.
    pub fn resolve_files(&mut self, folder: &Path) {
        if let Some(SkySource { kind: SkyKind::File(path), .. }) = &mut self.environment.sky {
            *path = folder.join(&*path).display().to_string();
        }
        if let Some(seal) = &mut self.ink.seal {
            seal.file = folder.join(&seal.file).display().to_string();
        }
    }

    /// Reads a look file as [`Look::read`] does. Resolves relative paths in it against `folder`.
    ///
    /// Fails like [`Look::read`].
    pub fn read_in(&mut self, folder: &Path, text: &str) -> Result<(), ParamError> {
        let (sky, seal) = (self.environment.sky.take(), self.ink.seal.take());
        let read = self.read(text);
        self.resolve_files(folder);
        self.environment.sky = self.environment.sky.take().or(sky);
        self.ink.seal = self.ink.seal.take().or(seal);
        read
    }

    /// Returns whether ambient light fades towards the surface, and whether the key light fades behind the body. Only
    /// published forms can set them to false.
    pub fn attenuations(&self) -> [bool; 2] {
        #[cfg(feature = "study")]
        return [self.study.ambient_attenuation, self.study.back_attenuation];
        #[cfg(not(feature = "study"))]
        [true; 2]
    }

    /// Returns the fill lights: unit direction towards each, and its strength.
    pub fn fill_lights(&self) -> impl Iterator<Item = (Vec3, f32)> {
        self.light.fill.iter().map(|fill| (unit(fill.direction), fill.strength))
    }

    /// Replaces the key light by a distant one in this direction.
    pub(crate) fn set_light_direction(&mut self, direction: Vec3) {
        self.light.direction = direction.to_array();
        self.light.position_m = None;
    }
}

/// Placement of the key light: a direction or a position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum KeyLight {
    /// Distant light; direction towards it.
    Distant(Vec3),
    /// Nearby light; its position, metres.
    Nearby(Vec3),
}

fn unit(direction: [f32; 3]) -> Vec3 {
    let direction = Vec3::from(direction);
    direction.try_normalize().unwrap_or(direction)
}
