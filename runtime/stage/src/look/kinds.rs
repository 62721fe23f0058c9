//! Types of the look's knobs: keywords, and values that can be written as short text.

use glam::Vec3;
use pelage_formats::meaning::environment::Environment;
use pelage_formats::meaning::seal::SealImage;
use pelage_params::{Control, Field, Item, Range, Raw, hex, words};
use std::sync::Arc;

words! {
    /// Rendering style.
    LookStyle {
        /// Fur of the models.
        #[default]
        Fur = "fur",
        /// Ink-wash painting.
        Ink = "ink",
        /// Bare mesh surface.
        Bare = "bare",
    }
}

words! {
    /// Sheet that a painting is on.
    LookSheet {
        /// Raw paper: water spreads, and edges feather.
        #[default]
        Raw = "raw",
        /// Paper sized with alum: water stays where the brush left it.
        Sized = "sized",
        /// Silk: a warm tone, with threads that show through.
        Silk = "silk",
    }
}

words! {
    /// Geometry by which hair is drawn.
    LookHair {
        /// Single strands if the package has them and they are wide enough to be visible, otherwise layers.
        #[default]
        Auto = "auto",
        /// Layers only.
        Shells = "shells",
        /// Single strands wherever the package has them, except where the far fur layer is drawn.
        Strands = "strands",
    }
}

words! {
    /// Rendering of the edges of strands.
    LookStrandEdges {
        /// Opaque ribbons, antialiased by the samples of the picture.
        #[default]
        Samples = "samples",
        /// Each pixel blends its eight nearest strands by their coverage.
        Blended = "blended",
    }
}

words! {
    /// Method for the self-shadow of hair.
    LookSelfShadow {
        /// Baked visibility if the package has it, otherwise shadow maps with a value per layer.
        #[default]
        Auto = "auto" was "on" or true,
        /// Baked visibility, for all lights. No self-shadow if the package has none.
        Baked = "baked",
        /// Shadow maps of the key light with a value per layer (Yang 2006).
        Maps = "maps",
        /// No self-shadow.
        Off = "off" or false,
    }
}

words! {
    /// Scattering model of hair, for packages with fibre data.
    LookScattering {
        /// Fibre tables, with multiple scattering between hairs.
        #[default]
        Multiple = "multiple",
        /// Fibre tables, without multiple scattering.
        Single = "single",
        /// Kajiya-Kay lobes, as for packages without fibre data.
        Off = "off" or false,
    }
}

words! {
    /// Output of a fur frame.
    LookFurShow {
        /// Lit picture.
        #[default]
        Picture = "picture",
        /// Kind of geometry by colour: skin grey, far fur layer violet, shells green, fins yellow, single strands red.
        Geometry = "geometry",
        /// Number of overlapping hair layers; each adds brightness.
        Overdraw = "overdraw",
    }
}

words! {
    /// Light of a look that names none.
    LookStudio {
        /// Built-in studio for fur with fibre data, if the look names neither a light nor an environment map.
        #[default]
        Auto = "auto",
        /// Key light and uniform ambient light.
        Old = "old",
    }
}

words! {
    /// Tone mapping.
    LookToneMapping {
        /// `filmic` in the built-in studio, otherwise `off`.
        #[default]
        Auto = "auto",
        /// Filmic shoulder: channels above 0.7, linear, are compressed below 1.
        Filmic = "filmic",
        /// None: light above 1 is cut off.
        Off = "off" or false,
    }
}

words! {
    /// Form of ink lines and washes.
    LookLines {
        /// Lines found in the pixels of the picture, and an even wash (Fang 2006).
        Pixels = "pixels",
        /// Brush strokes, attached to the surface.
        #[default]
        Strokes = "strokes",
    }
}

words! {
    /// Output of an ink frame.
    LookShow {
        /// Finished painting.
        #[default]
        Painting = "painting",
        /// Lines, black on white.
        Lines = "lines",
        /// Feature pixels, through which lines run, black on white.
        Features = "features",
        /// Wash only.
        Wash = "wash",
    }
}

/// Implements a knob type whose values have a text form. Arguments: `expected` describes the values, `read` reads from
/// TOML, `write` writes to TOML.
macro_rules! text_field {
    ($ty:ty, expected $expected:expr, control $control:expr, read $read:expr, write $write:expr) => {
        impl Field for $ty {
            type Range = ();

            fn expected((): &()) -> String {
                $expected.into()
            }

            fn control((): &()) -> Control {
                $control
            }

            fn from_raw(raw: &Raw) -> Option<Self> {
                let read: fn(&Raw) -> Option<Self> = $read;
                read(raw)
            }

            fn in_range(&self, (): &()) -> bool {
                // A value that cannot be written as text is invalid.
                self.to_toml().is_some_and(|text| Self::from_raw(&Raw::from_word(&text)).is_some())
            }

            fn to_toml(&self) -> Option<String> {
                let write: fn(&Self) -> String = $write;
                Some(write(self))
            }
        }
    };
}

fn string(raw: &Raw) -> Option<&str> {
    match raw {
        Raw::String(text) => Some(text),
        _ => None,
    }
}

/// Maximum width and height, pixels. Every adapter with WebGPU's default limits supports it.
const MAX_SIZE: u32 = 8192;

/// Width and height of a picture, pixels, 1..=8192 each. As text `834x424`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
}

text_field!(
    Size,
    expected format!("WIDTHxHEIGHT in pixels, each from 1 to {MAX_SIZE}, such as \"834x424\""),
    control Control::Text,
    read |raw| {
        let (width, height) = string(raw)?.split_once(['x', 'X'])?;
        let size = Size { width: width.trim().parse().ok()?, height: height.trim().parse().ok()? };
        [size.width, size.height].iter().all(|side| (1..=MAX_SIZE).contains(side)).then_some(size)
    },
    write |size| format!("\"{}x{}\"", size.width, size.height)
);

impl std::str::FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::read(&Raw::String(text.to_owned()), &())
    }
}

/// Samples per pixel: 1 or 4.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Samples(pub u32);

text_field!(
    Samples,
    expected "1 or 4",
    control Control::PowerOfTwo { least: 1, most: 4 },
    read |raw| match raw {
        Raw::Integer(1) => Some(Samples(1)),
        Raw::Integer(4) => Some(Samples(4)),
        _ => None,
    },
    write |samples| samples.0.to_string()
);

/// Colour in sRGB, one byte per channel. As text `10,20,255` or `#0a14ff`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rgb(pub [u8; 3]);

impl Rgb {
    fn of_text(text: &str) -> Option<Self> {
        if text.starts_with('#') {
            return hex(text).map(Self);
        }
        let numbers: Option<Vec<u8>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
        numbers.and_then(|n| <[u8; 3]>::try_from(n).ok()).map(Self)
    }

    fn text(self) -> String {
        let [r, g, b] = self.0;
        format!("#{r:02x}{g:02x}{b:02x}")
    }
}

text_field!(
    Rgb,
    expected "\"#rrggbb\" or \"red,green,blue\" with numbers 0..=255",
    control Control::Color,
    read |raw| Rgb::of_text(string(raw)?),
    write |rgb| format!("{:?}", rgb.text())
);

/// Background of the picture. As text `transparent`, `sky`, `studio` or a colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Background {
    /// Transparent background.
    Transparent,
    /// Environment map; only in pictures and videos that are written to files.
    Sky,
    /// Neutral floor and wall of a studio, with the models' soft shadow.
    Studio,
    /// Colour in sRGB. With the style `ink`, it is the colour of the paper.
    Color(Rgb),
}

impl Background {
    /// Returns the colour, sRGB-encoded. `None` for transparent, and for backgrounds without a single colour.
    pub fn color(self) -> Option<[u8; 3]> {
        match self {
            Self::Transparent | Self::Sky | Self::Studio => None,
            Self::Color(rgb) => Some(rgb.0),
        }
    }
}

text_field!(
    Background,
    expected "\"transparent\", \"studio\", \"sky\", \"#rrggbb\" or \"red,green,blue\" with numbers 0..=255",
    control Control::Text,
    read |raw| match string(raw)? {
        "transparent" => Some(Background::Transparent),
        "sky" => Some(Background::Sky),
        "studio" => Some(Background::Studio),
        text => Rgb::of_text(text).map(Background::Color),
    },
    write |background| match background {
        Background::Transparent => "\"transparent\"".into(),
        Background::Sky => "\"sky\"".into(),
        Background::Studio => "\"studio\"".into(),
        Background::Color(rgb) => format!("{:?}", rgb.text()),
    }
);

/// Level of detail of fur that is small on the screen. As text `full`, `auto` or a level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LookDetail {
    /// Full detail at any size.
    Full,
    /// Detail by size on screen.
    Auto,
    /// Level, 0..=32. The fractional part is the fade to the next level.
    Level(f32),
}

text_field!(
    LookDetail,
    expected "\"full\", \"auto\" or a level 0..=32",
    control Control::Text,
    read |raw| match raw {
        Raw::String(word) if word == "full" => Some(LookDetail::Full),
        Raw::String(word) if word == "auto" => Some(LookDetail::Auto),
        _ => raw.number().map(|x| x as f32).filter(|x| (0.0..=32.0).contains(x)).map(LookDetail::Level),
    },
    write |detail| match detail {
        LookDetail::Full => "\"full\"".into(),
        LookDetail::Auto => "\"auto\"".into(),
        LookDetail::Level(level) => format!("{level:?}"),
    }
);

/// Width of the widest ink line. As text `auto`, `7px` or `0.01m`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LookWidth {
    /// Nine pixels in a picture of 424 rows; proportional to the number of rows.
    Auto,
    /// Width in pixels, above 0 and at most 32.
    Pixels(f32),
    /// Width in metres, above 0. Lines become thinner with distance.
    Metres(f32),
}

text_field!(
    LookWidth,
    expected "\"auto\", pixels such as \"7px\", at most 32, or metres such as \"0.01m\"",
    control Control::Text,
    read |raw| {
        let text = string(raw)?;
        let positive = |n: &str| n.trim().parse().ok().filter(|n: &f32| *n > 0.0 && n.is_finite());
        match (text, text.strip_suffix("px"), text.strip_suffix('m')) {
            ("auto", ..) => Some(LookWidth::Auto),
            (_, Some(px), _) => positive(px).filter(|px| *px <= 32.0).map(LookWidth::Pixels),
            (_, None, Some(metres)) => positive(metres).map(LookWidth::Metres),
            _ => None,
        }
    },
    write |width| match width {
        LookWidth::Auto => "\"auto\"".into(),
        LookWidth::Pixels(px) => format!("\"{px}px\""),
        LookWidth::Metres(metres) => format!("\"{metres}m\""),
    }
);

/// Source of the environment map, and its rotation about the vertical axis. As text `studio`, `sky.hdr:90`,
/// `0.2,0.3,0.5` or `0.9,1,1.2/0.1,0.1,0.1`.
#[derive(Clone, Debug, PartialEq)]
pub struct SkySource {
    /// Kind of source.
    pub kind: SkyKind,
    /// Rotation in degrees, from +x towards −z, in the direction that models turn.
    pub yaw_deg: f32,
    /// Lights read from the file by [`crate::Look::read_environment`]; not part of the text.
    pub lights: Option<Arc<Environment>>,
}

/// Kinds of environment map sources.
#[derive(Clone, Debug, PartialEq)]
pub enum SkyKind {
    /// Built-in photo studio ([`crate::sky::studio()`]).
    Studio,
    /// File: a panorama (`.hdr`, `.exr`) or fitted lights (`.toml`).
    File(String),
    /// Uniform light from all directions, linear RGB, 0 or more.
    Even([f32; 3]),
    /// Light from above and light from below, linear RGB, 0 or more.
    Gradient([f32; 3], [f32; 3]),
}

impl SkySource {
    fn of_text(text: &str) -> Option<Self> {
        let turned = text.rsplit_once(':').and_then(|(of, yaw)| Some((of, yaw.trim().parse::<f32>().ok()?)));
        let (of, yaw_deg) = turned.unwrap_or((text, 0.0));
        let colour = |text: &str| {
            let numbers: Option<Vec<f32>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
            let colour = numbers.and_then(|n| <[f32; 3]>::try_from(n).ok());
            colour.filter(|colour| colour.iter().all(|x| (0.0..=1e6).contains(x)))
        };
        let end = of.rsplit_once('.').map(|(_, end)| end.to_ascii_lowercase());
        let of = match (of.split_once('/'), end.as_deref()) {
            _ if of == "studio" => SkyKind::Studio,
            (Some((above, below)), _) if colour(above).is_some() => SkyKind::Gradient(colour(above)?, colour(below)?),
            _ if colour(of).is_some() => SkyKind::Even(colour(of)?),
            (_, Some("hdr" | "exr" | "toml")) => SkyKind::File(of.to_owned()),
            _ => return None,
        };
        yaw_deg.is_finite().then_some(Self { kind: of, yaw_deg, lights: None })
    }

    fn text(&self) -> String {
        let colour = |[r, g, b]: [f32; 3]| format!("{r:?},{g:?},{b:?}");
        let of = match &self.kind {
            SkyKind::Studio => "studio".into(),
            SkyKind::File(path) => path.clone(),
            SkyKind::Even(rgb) => colour(*rgb),
            SkyKind::Gradient(above, below) => format!("{}/{}", colour(*above), colour(*below)),
        };
        if self.yaw_deg == 0.0 { of } else { format!("{of}:{:?}", self.yaw_deg) }
    }
}

text_field!(
    SkySource,
    expected "\"studio\", the path of a .hdr, .exr or .toml file, a colour such as \"0.2,0.3,0.5\", or two colours \
         \"above/below\"; append \":90\" to rotate the sky by 90 degrees",
    control Control::Text,
    read |raw| SkySource::of_text(string(raw)?),
    write |source| toml::Value::String(source.text()).to_string()
);

/// Seal on a painting: the file of its image, and its place. As text `seal.png` or `seal.png:0.9,0.88,0.1`.
#[derive(Clone, Debug, PartialEq)]
pub struct SealSource {
    /// Path of the image.
    pub file: String,
    /// Centre as shares of the picture's width and height from the upper left corner, and height as a share of the
    /// picture's height.
    pub place: [f32; 3],
    /// Image read from the file by [`crate::Look::read_seal`]; not part of the text.
    pub image: Option<Arc<SealImage>>,
}

impl SealSource {
    /// Place of a seal that names none.
    pub const PLACE: [f32; 3] = [0.9, 0.88, 0.1];

    fn of_text(text: &str) -> Option<Self> {
        let numbers = |text: &str| text.split(',').map(|n| n.trim().parse().ok()).collect::<Option<Vec<f32>>>();
        let placed =
            text.rsplit_once(':').and_then(|(file, at)| Some((file, <[f32; 3]>::try_from(numbers(at)?).ok()?)));
        let (file, place) = placed.unwrap_or((text, Self::PLACE));
        let is_image = ["png", "jpg", "jpeg"]
            .iter()
            .any(|end| file.len() > end.len() + 1 && file.to_ascii_lowercase().ends_with(&format!(".{end}")));
        let [x, y, height] = place;
        let is_placed = [x, y].iter().all(|share| (0.0..=1.0).contains(share)) && (0.001..=1.0).contains(&height);
        (is_image && is_placed).then(|| Self { file: file.into(), place, image: None })
    }

    fn text(&self) -> String {
        let [x, y, height] = self.place;
        if self.place == Self::PLACE { self.file.clone() } else { format!("{}:{x:?},{y:?},{height:?}", self.file) }
    }
}

text_field!(
    SealSource,
    expected "the path of a .png or .jpg file; append \":X,Y,HEIGHT\" to place it, with shares of the picture 0..=1",
    control Control::Text,
    read |raw| SealSource::of_text(string(raw)?),
    write |seal| toml::Value::String(seal.text()).to_string()
);

/// Two distances, metres, the second greater. As text `10,60`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval(pub [f32; 2]);

impl Interval {
    fn rising(from: f32, to: f32) -> Option<Self> {
        (from.is_finite() && to.is_finite() && from < to).then_some(Self([from, to]))
    }
}

text_field!(
    Interval,
    expected "two distances in metres, the second greater, such as [10, 60]",
    control Control::Text,
    read |raw| match raw {
        Raw::Array(items) => match items.as_slice() {
            [from, to] => Interval::rising(from.number()? as f32, to.number()? as f32),
            _ => None,
        },
        _ => {
            let (from, to) = string(raw)?.split_once(',')?;
            Interval::rising(from.trim().parse().ok()?, to.trim().parse().ok()?)
        }
    },
    write |Interval([from, to])| format!("[{from:?}, {to:?}]")
);

/// Direction of any length except 0; validates knobs that are directions.
#[derive(Clone, Copy)]
pub(super) struct DirectionField(pub [f32; 3]);

impl Field for DirectionField {
    type Range = Range<f32>;

    fn expected(range: &Self::Range) -> String {
        format!("a direction that is not zero, such as [1, 2, 1], numbers {}..={}", range.start(), range.end())
    }

    fn control(range: &Self::Range) -> Control {
        <[f32; 3]>::control(range)
    }

    fn from_raw(raw: &Raw) -> Option<Self> {
        // The table [view] of a scene file, and the short form of a fill light, write a direction as text.
        match raw {
            Raw::String(text) => <[f32; 3]>::from_raw(&<[f32; 3]>::parse_word(text)),
            raw => <[f32; 3]>::from_raw(raw),
        }
        .map(Self)
    }

    fn in_range(&self, range: &Self::Range) -> bool {
        self.0.in_range(range) && Vec3::from(self.0).try_normalize().is_some()
    }

    fn to_toml(&self) -> Option<String> {
        self.0.to_toml()
    }

    fn parse_word(word: &str) -> Raw {
        <[f32; 3]>::parse_word(word)
    }
}

/// Distant fill light, which casts no shadow. As text `x,y,z` or `x,y,z/strength`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FillLight {
    /// Direction towards the light, of any length except 0.
    pub direction: [f32; 3],
    /// Strength, 0..=1000. At 1 it is as strong as the key light.
    pub strength: f32,
}

const STRENGTH: Range<f32> = 0.0..=1000.0;
/// Range of coordinates.
pub(super) const PLACE: Range<f32> = -1e6..=1e6;

impl FillLight {
    fn of(direction: Option<&Raw>, strength: Option<&Raw>) -> Result<Self, String> {
        let direction = direction.ok_or("direction is missing")?;
        let direction = DirectionField::read(direction, &PLACE).map_err(|reason| format!("direction: {reason}"))?.0;
        let strength = strength.map_or(Ok(1.0), |raw| f32::read(raw, &STRENGTH));
        Ok(Self { direction, strength: strength.map_err(|reason| format!("strength: {reason}"))? })
    }
}

impl Item for FillLight {
    const ALLOW_SINGLE: bool = true;

    fn expected_list() -> String {
        "a list of lights such as { direction = [1, 2, 1], strength = 0.5 } or \"1,2,1/0.5\"".into()
    }

    fn read(raw: &Raw) -> Result<Self, Option<String>> {
        match raw {
            Raw::String(text) => {
                let (direction, strength) = text.split_once('/').map_or((text.as_str(), None), |(d, s)| (d, Some(s)));
                let strength = strength.map(f32::parse_word);
                Self::of(Some(&DirectionField::parse_word(direction)), strength.as_ref()).map_err(Some)
            }
            Raw::Table(table) => {
                if let Some((key, _)) = table.iter().find(|(key, _)| key != "direction" && key != "strength") {
                    return Err(Some(format!("unknown key {key:?}, expected direction or strength")));
                }
                let at = |key: &str| table.iter().find(|(name, _)| name == key).map(|(_, raw)| raw);
                Self::of(at("direction"), at("strength")).map_err(Some)
            }
            _ => Err(None),
        }
    }

    fn in_range(&self) -> bool {
        DirectionField(self.direction).in_range(&PLACE) && self.strength.in_range(&STRENGTH)
    }

    fn to_toml(&self) -> String {
        let [x, y, z] = self.direction;
        format!("{{ direction = [{x:?}, {y:?}, {z:?}], strength = {:?} }}", self.strength)
    }
}
