//! Contents of a scene file.

use glam::Vec3;
use serde::Deserialize;
use std::collections::BTreeMap;

/// Maximum absolute value of coordinates, metres, and of times, seconds.
const MAX_VALUE: f64 = 1e6;

/// Scene as written in its file. Plain data that can be inspected and changed before loading.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Look of the picture.
    pub look: Option<SceneLook>,
    /// Look of the picture as command-line flags, with `_` instead of `-`: `self_shadow = "off"`. Overridden by `look`.
    #[serde(default)]
    pub view: toml::Table,
    /// Camera. If omitted, all models are framed along their paths and over their clips.
    pub camera: Option<SceneCamera>,
    /// Key light; if omitted, the default one.
    pub light: Option<SceneLight>,
    /// Sequence of pictures.
    pub sequence: Option<SceneSequence>,
    /// Models of the scene; at least one.
    #[serde(default, rename = "model")]
    pub models: Vec<SceneModel>,
}

/// Tables of `[look]`, or the path of the file that contains them.
#[derive(Clone, Debug, Deserialize)]
#[serde(try_from = "toml::Value")]
pub enum SceneLook {
    /// Path of a look file, relative to the scene file's folder.
    File(String),
    /// Tables of a [`crate::Look`].
    Tables(toml::Table),
}

impl TryFrom<toml::Value> for SceneLook {
    type Error = String;

    fn try_from(value: toml::Value) -> Result<Self, String> {
        match value {
            toml::Value::String(path) => Ok(Self::File(path)),
            toml::Value::Table(tables) => Ok(Self::Tables(tables)),
            other => {
                let found = other.type_str();
                Err(format!("found {found}, expected the path of a look file or tables such as [look.shadow]"))
            }
        }
    }
}

/// `[camera]`: eye and target, or a path with keys of both.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneCamera {
    /// Position in metres; requires `target`.
    pub eye: Option<Point>,
    /// Target in metres, different from `eye`; requires `eye`.
    pub target: Option<Point>,
    /// Vertical field of view, degrees.
    pub fov_deg: Option<FieldOfView>,
    /// Keys of the camera over time. If present, they are used instead of the fields above.
    pub path: Option<Vec<CameraKey>>,
}

/// Key of a camera's path.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraKey {
    /// Time in seconds.
    pub time_s: Number,
    /// Position in metres.
    pub eye: Point,
    /// Target in metres; different from `eye`.
    pub target: Point,
    /// Vertical field of view, degrees.
    pub fov_deg: Option<FieldOfView>,
}

/// `[light]`: either a direction or a position.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneLight {
    /// Direction towards a distant light, of any length except 0.
    pub direction: Option<Point>,
    /// Position of a nearby light, metres.
    pub position: Option<Point>,
}

/// `[sequence]`: pictures over time.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneSequence {
    /// Number of pictures.
    pub frames: Option<Whole<100_000>>,
    /// Pictures per second.
    pub fps: Option<Whole<1000>>,
}

/// `[[model]]`: a copy of a package's model.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneModel {
    /// Name in results; if omitted, the name of the package.
    pub name: Option<String>,
    /// Path of the package, relative to the scene file's folder.
    pub package: String,
    /// Position in metres.
    pub position: Option<Point>,
    /// Heading in degrees: 0 faces +z, 90 faces +x.
    pub heading_deg: Option<Number>,
    /// Scale relative to the baked size.
    pub scale: Option<Scale>,
    /// Keys over time; replace `position` and `heading_deg`.
    pub path: Option<Vec<PlaceKey>>,
    /// Name of the clip to play; if omitted, the model is at rest.
    pub clip: Option<String>,
    /// Playback speed, seconds of the clip per second of the scene.
    pub speed: Option<Number>,
    /// Time within the clip at time 0, seconds.
    pub start_s: Option<Number>,
    /// Whether the clip restarts at its end; otherwise it holds its last pose.
    #[serde(rename = "loop")]
    pub looped: Option<bool>,
    /// Whether the model continues from where the clip has carried it when the clip restarts. Otherwise it returns to
    /// the same position.
    #[serde(default)]
    pub root_motion: bool,
    /// Weights of morph targets by name; they override those of the clip.
    #[serde(default)]
    pub morphs: BTreeMap<String, Number>,
}

/// Key of a model's path.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlaceKey {
    /// Time in seconds.
    pub time_s: Number,
    /// Position in metres.
    pub position: Point,
    /// Heading in degrees. Either all keys of a path have it or none.
    pub heading_deg: Option<Number>,
}

/// Finite number whose absolute value is limited.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(try_from = "f64")]
pub struct Number(pub f32);

impl TryFrom<f64> for Number {
    type Error = String;

    fn try_from(x: f64) -> Result<Self, String> {
        within(x, -MAX_VALUE, MAX_VALUE).map(Self)
    }
}

/// Vector of three limited numbers.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(try_from = "[f64; 3]")]
pub struct Point(pub Vec3);

impl TryFrom<[f64; 3]> for Point {
    type Error = String;

    fn try_from(xyz: [f64; 3]) -> Result<Self, String> {
        let [x, y, z] = xyz.map(|x| within(x, -MAX_VALUE, MAX_VALUE));
        Ok(Self(Vec3::new(x?, y?, z?)))
    }
}

/// Vertical field of view, degrees.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(try_from = "f64")]
pub struct FieldOfView(pub f32);

impl TryFrom<f64> for FieldOfView {
    type Error = String;

    fn try_from(x: f64) -> Result<Self, String> {
        within(x, 1.0, 170.0).map(Self)
    }
}

/// Scale relative to the baked size.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(try_from = "f64")]
pub struct Scale(pub f32);

impl TryFrom<f64> for Scale {
    type Error = String;

    fn try_from(x: f64) -> Result<Self, String> {
        within(x, 1e-4, 1e4).map(Self)
    }
}

/// Whole number from 1 to `MOST`.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(try_from = "i64")]
pub struct Whole<const MOST: u32>(pub u32);

impl<const MOST: u32> TryFrom<i64> for Whole<MOST> {
    type Error = String;

    fn try_from(n: i64) -> Result<Self, String> {
        let whole = u32::try_from(n).ok().filter(|n| (1..=MOST).contains(n));
        whole.map(Self).ok_or_else(|| format!("found {n}, expected a whole number from 1 to {MOST}"))
    }
}

fn within(x: f64, least: f64, most: f64) -> Result<f32, String> {
    // The comparison also rejects NaN.
    let inside = (least..=most).contains(&x);
    if inside { Ok(x as f32) } else { Err(format!("found {x}, expected a number from {least} to {most}")) }
}
