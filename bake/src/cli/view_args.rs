//! What `render` and `bench` share: the picture, the camera, the light and what is drawn.

use super::ink_args::InkArgs;
use super::words::{Background, Switch};
use clap::ValueEnum;
use glam::Vec3;
use pelage_bake::recipe::{CameraView, parse_vec3};
use pelage_runtime::StyleKind;
use std::str::FromStr;

/// Options of `render` and `bench`.
#[derive(Clone, Debug, clap::Args)]
pub struct ViewArgs {
    /// Size of the picture, pixels [default: 834x424, the size in Fang 2006]
    #[arg(long, value_name = "WxH")]
    pub size: Option<Size>,
    /// How the model is drawn [default: fur]
    #[arg(long, value_enum)]
    pub style: Option<StyleArg>,
    /// Eye and target in metres, height of the view in degrees: ex,ey,ez/tx,ty,tz/fov
    ///
    /// Without it the camera frames the model from the front left.
    #[arg(long, value_name = "EYE/TARGET/FOV", allow_hyphen_values = true)]
    pub camera: Option<CameraView>,
    /// Direction towards a distant light: x,y,z of any length
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, conflicts_with = "point_light")]
    pub light: Option<Direction>,
    /// Place of a point light, metres: x,y,z
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub point_light: Option<Position>,
    /// Time in the clip, seconds
    #[arg(long, value_name = "S", default_value_t = 0.0, value_parser = parse_seconds, allow_hyphen_values = true)]
    pub time: f32,
    /// Clip of the animation, by name; without it the model stands at rest
    #[arg(long, value_name = "NAME")]
    pub clip: Option<String>,
    /// Shell layers to draw, 1 to the package's own count, which is the default
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub layers: Option<u32>,
    /// How much of the fur is drawn: full, auto (the package's levels of detail, by the fur's height on screen), or a level, from 0,
    /// with a fraction for the cross-fade to the next; --layers goes before it
    #[arg(long, value_name = "full|auto|LEVEL", default_value = "full")]
    pub detail: DetailArg,
    /// Copies of the model, side by side on a grid
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub crowd: u32,
    /// Another light, without shadow: direction towards it x,y,z, and its strength (default 1); may be given again
    #[arg(long, value_name = "X,Y,Z[/S]", allow_hyphen_values = true)]
    pub fill_light: Vec<FillLight>,
    /// Hair shadows hair, by layer-wise shadow maps
    #[arg(long, value_enum, value_name = "on|off", default_value = "on")]
    pub self_shadow: Switch,
    /// Soft shadows, by a shadow-width map
    #[arg(long, value_enum, value_name = "on|off", default_value = "on")]
    pub soft_shadow: Switch,
    /// Width of a soft shadow's edge over the distance from what throws it, 0 to 2; 0 is a hard shadow
    #[arg(long, value_name = "W", default_value_t = 0.15, value_parser = |text: &str| parse_up_to(text, 2.0))]
    pub penumbra: f32,
    /// Where a soft shadow's edge lies
    #[arg(long, value_enum, default_value_t = Penumbra::Centred)]
    pub penumbra_form: Penumbra,
    /// How far the shadow-width map is shrunk before it is stretched again
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u32).range(2..=32))]
    pub shadow_shrink: u32,
    /// Width and height of the shadow maps, texels
    #[arg(long, value_name = "N", default_value_t = 512, value_parser = clap::value_parser!(u32).range(16..=8192))]
    pub shadow_map: u32,
    /// Layers of the layer-wise shadow maps, skin counted; by default as many as are drawn
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=256))]
    pub shadow_layers: Option<u32>,
    /// Share of the layers' optical depth that the key light meets, 0 to 4
    #[arg(long, value_name = "D", default_value_t = 1.0, value_parser = |text: &str| parse_up_to(text, 4.0))]
    pub shadow_density: f32,
    /// What the light's slant does to the opacity of a layer: with its longer way, or as printed in Yang 2006
    #[arg(long, value_enum, default_value_t = Slant::Corrected)]
    pub slant: Slant,
    /// What the slant of the look does to the opacity of a layer: with the longer way through it, or nothing, as printed
    #[arg(long, value_enum, default_value_t = Slant::Corrected)]
    pub view_slant: Slant,
    /// Ambient light fades towards the skin
    #[arg(long, value_enum, value_name = "on|off", default_value = "on")]
    pub ambient_attenuation: Switch,
    /// The light ends behind the body
    #[arg(long, value_enum, value_name = "on|off", default_value = "on")]
    pub back_attenuation: Switch,
    /// Fins along the silhouette; on where the package has them
    #[arg(long, value_enum, value_name = "on|off")]
    pub fins: Option<Switch>,
    /// Where hair is lit
    #[arg(long, value_enum, default_value_t = LightingArg::Pixel)]
    pub lighting: LightingArg,
    /// Frames: numbered pictures of `render`, timed frames of `bench`
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub frames: Option<u32>,
    /// What is behind the model: transparent, or sRGB red,green,blue of 0..=255 [default: transparent; in ink, paper]
    #[arg(long, value_name = "transparent|R,G,B")]
    pub background: Option<Background>,
    #[command(flatten)]
    pub ink: InkArgs,
}

/// Largest width and height; every adapter of WebGPU's default limits can draw it.
const MAX_SIZE: u32 = 8192;

/// Size of a picture, pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
}

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text.split_once(['x', 'X']).and_then(|(w, h)| Some((w.parse().ok()?, h.parse().ok()?)));
        let (width, height): (u32, u32) = parts.ok_or("expected WIDTHxHEIGHT in pixels, such as 834x424".to_owned())?;
        if !(1..=MAX_SIZE).contains(&width) || !(1..=MAX_SIZE).contains(&height) {
            return Err(format!("expected a width and a height of 1 to {MAX_SIZE} pixels"));
        }
        Ok(Self { width, height })
    }
}

/// `--style`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum StyleArg {
    /// With its fur
    Fur,
    /// As an ink-wash painting
    Ink,
    /// The skin alone
    Bare,
}

impl StyleArg {
    /// The runtime's word for it.
    pub fn style(self) -> StyleKind {
        match self {
            Self::Fur => StyleKind::Fur,
            Self::Ink => StyleKind::Ink,
            Self::Bare => StyleKind::Bare,
        }
    }
}

/// `--detail`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DetailArg {
    /// All of the fur, whatever its size.
    Full,
    /// By its size on screen.
    Auto,
    /// A level, and how far it has faded to the next.
    Level(f32),
}

impl FromStr for DetailArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "full" => Ok(Self::Full),
            "auto" => Ok(Self::Auto),
            _ => parse_up_to(text, 32.0).map(Self::Level).map_err(|e| format!("expected full, auto or a level: {e}")),
        }
    }
}

/// `--lighting`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum LightingArg {
    /// At every pixel, with the direction texture
    Pixel,
    /// At the vertices
    Vertex,
}

/// `--slant`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Slant {
    /// The light's way through a layer grows with its slant
    Corrected,
    /// A layer takes the same at every angle
    Printed,
}

/// `--penumbra-form`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Penumbra {
    /// On both sides of the hard edge
    Centred,
    /// Inside the hard edge
    Inner,
}

/// `--fill-light`: a direction of length 1, and a strength.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FillLight {
    /// Towards the light.
    pub direction: Vec3,
    /// 1 is as strong as the key light.
    pub strength: f32,
}

impl FromStr for FillLight {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (direction, strength) = text.split_once('/').unwrap_or((text, "1"));
        let strength = parse_up_to(strength, 1000.0).map_err(|e| format!("strength: {e}"))?;
        Ok(Self { direction: direction.parse::<Direction>()?.0, strength })
    }
}

fn parse_up_to(text: &str, most: f32) -> Result<f32, String> {
    let number = text.trim().parse().ok().filter(|x| (0.0..=most).contains(x));
    number.ok_or_else(|| format!("expected a number from 0 to {most}"))
}

/// A finite number.
pub fn parse_seconds(text: &str) -> Result<f32, String> {
    text.parse().ok().filter(|s: &f32| s.is_finite()).ok_or("expected a number of seconds".into())
}

/// `--light`: a direction of length 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Direction(pub Vec3);

impl FromStr for Direction {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let direction = parse_vec3(text)?.try_normalize();
        direction.map(Self).ok_or("it has no length, expected a direction such as 1,2,1".into())
    }
}

/// `--point-light`: a point, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Position(pub Vec3);

impl FromStr for Position {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        parse_vec3(text).map(Self)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
    use super::super::view::View;
    use super::*;
    use clap::Parser;
    use pelage_runtime::{InkParams, LineWidth};

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        view: ViewArgs,
    }

    fn parse(line: &str) -> Result<ViewArgs, String> {
        let words = ["pelage"].into_iter().chain(line.split_whitespace());
        Line::try_parse_from(words).map(|l| l.view).map_err(|e| e.to_string())
    }

    #[test]
    fn defaults_are_those_of_the_manual() {
        let view = parse("").unwrap();
        let default = View::try_from(&view).unwrap();
        assert_eq!((default.size, default.style, default.background), ((834, 424), StyleKind::Fur, None));
        assert_eq!(default, View::default());
        assert_eq!(view.lighting, LightingArg::Pixel);
        assert!(view.camera.is_none() && view.light.is_none() && view.point_light.is_none() && view.clip.is_none());
        assert_eq!((view.time, view.layers, view.frames), (0.0, None, None));
        assert_eq!((view.detail, view.crowd), (DetailArg::Full, 1));
    }

    #[test]
    fn every_option_is_read() {
        let view = parse(
            "--size 64X32 --style bare --camera -1,2,3.5/0,0,-1/45 --light 0,3,4 --time 0.25 --clip Walk --layers 8 \
             --self-shadow off --soft-shadow off --fins off --frames 3 --background 10,20,255 \
             --penumbra 0.5 --penumbra-form inner --slant printed --shadow-map 256 --shadow-layers 4 --shadow-shrink 16 \
             --fill-light -2,0,0/0.25 --fill-light 0,1,0 --lighting vertex",
        )
        .unwrap();
        assert_eq!(view.lighting, LightingArg::Vertex);
        assert_eq!(view.size, Some(Size { width: 64, height: 32 }));
        let camera = view.camera.unwrap();
        assert_eq!(
            (camera.eye, camera.target, camera.fov_deg),
            (Vec3::new(-1.0, 2.0, 3.5), Vec3::new(0.0, 0.0, -1.0), 45.0)
        );
        assert_eq!(view.light.unwrap().0, Vec3::new(0.0, 0.6, 0.8));
        assert_eq!((view.time, view.clip.as_deref(), view.layers, view.frames), (0.25, Some("Walk"), Some(8), Some(3)));
        assert_eq!((view.self_shadow, view.soft_shadow, view.fins), (Switch::Off, Switch::Off, Some(Switch::Off)));
        assert_eq!((view.penumbra, view.penumbra_form, view.slant), (0.5, Penumbra::Inner, Slant::Printed));
        assert_eq!((view.shadow_map, view.shadow_layers, view.shadow_shrink), (256, Some(4), 16));
        let fills: Vec<_> = view.fill_light.iter().map(|f| (f.direction, f.strength)).collect();
        assert_eq!(fills, [(Vec3::NEG_X, 0.25), (Vec3::Y, 1.0)]);
        assert_eq!((view.style, view.background), (Some(StyleArg::Bare), Some(Background::Color([10, 20, 255]))));
        let detail = parse("--detail 1.5 --crowd 100").unwrap();
        assert_eq!((detail.detail, detail.crowd), (DetailArg::Level(1.5), 100));
        assert_eq!(parse("--detail auto").unwrap().detail, DetailArg::Auto);
        assert_eq!(parse("--point-light -1,0,2").unwrap().point_light.unwrap().0, Vec3::new(-1.0, 0.0, 2.0));
    }

    #[test]
    fn what_is_wrong_is_said() {
        for (line, message) in [
            ("--size 0x0", "1 to 8192 pixels"),
            ("--size 834", "WIDTHxHEIGHT"),
            ("--size 9000x10", "1 to 8192 pixels"),
            ("--size -1x10", "unexpected argument"),
            ("--camera 0,0,0/0,0,0/40", "same point"),
            ("--camera 0,0,1/0,0,0", "ex,ey,ez/tx,ty,tz/fov_deg"),
            ("--camera 0,0/0,0,0/40", "eye: expected three numbers"),
            ("--camera 0,0,1/0,0,0/180", "1 to 170 degrees"),
            ("--light 0,0,0", "no length"),
            ("--light NaN,0,1", "three numbers"),
            ("--light 0,1,0 --point-light 0,1,0", "cannot be used with"),
            ("--layers 0", "0 is not in 1.."),
            ("--shadow-density 5", "0 to 4"),
            ("--penumbra=-1", "0 to 2"),
            ("--penumbra=NaN", "0 to 2"),
            ("--shadow-map 8", "16..=8192"),
            ("--shadow-layers 1", "2..=256"),
            ("--shadow-shrink 64", "2..=32"),
            ("--fill-light 0,0,0", "no length"),
            ("--fill-light 0,1,0/-1", "0 to 1000"),
            ("--frames 0", "0 is not in 1.."),
            ("--time inf", "number of seconds"),
            ("--background 1,2,300", "0 to 255"),
            ("--background red", "transparent"),
            ("--style fluffy", "fur, ink, bare"),
            ("--fins maybe", "on, off"),
            ("--detail coarse", "full, auto or a level"),
            ("--detail -1", "unexpected argument"),
            ("--crowd 0", "0 is not in 1..=10000"),
        ] {
            let error = parse(line).unwrap_err();
            assert!(error.contains(message), "{line}: {error}");
        }
    }

    #[test]
    fn ink_has_its_own_options() {
        let view = View::try_from(&parse("--style ink --ink-width 0.02m --background 255,255,255").unwrap()).unwrap();
        let ink = view.ink.params();
        assert_eq!((view.style, ink.width, ink.paper), (StyleKind::Ink, LineWidth::Metres(0.02), Vec3::ONE));
        let default = View::try_from(&parse("--style ink").unwrap()).unwrap();
        assert_eq!(default.ink.params(), InkParams::default());
        for line in ["--ink-width 7", "--ink-width 40px", "--ink-threshold 0.1", "--ink-mist 5,2", "--ink-tone nan"] {
            assert!(parse(line).unwrap_err().contains("expected"), "{line}");
        }
    }
}
