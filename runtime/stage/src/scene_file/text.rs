//! What a scene file may say.

use glam::Vec3;
use serde::Deserialize;
use std::collections::BTreeMap;

/// Largest coordinate, metres, and largest time, seconds.
const FARTHEST: f64 = 1e6;

/// A scene as its file says it, word for word: plain data to look at and to change before it is loaded.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// How the picture looks.
    pub look: Option<SceneLook>,
    /// How the picture looks in words of the command line, with `_` for `-`: `self_shadow = "off"`. What `look` says goes before it.
    #[serde(default)]
    pub view: toml::Table,
    /// From where it is seen; left out, all models are framed, along their paths and over their clips.
    pub camera: Option<SceneCamera>,
    /// The key light; left out, the default one.
    pub light: Option<SceneLight>,
    /// Pictures over time.
    pub sequence: Option<SceneSequence>,
    /// What stands in it; at least one.
    #[serde(default, rename = "model")]
    pub models: Vec<SceneModel>,
}

/// `[look]`, or the file that it stands in.
#[derive(Clone, Debug, Deserialize)]
#[serde(try_from = "toml::Value")]
pub enum SceneLook {
    /// Path of a look file from the scene file's folder.
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

/// `[camera]`: eye and target, or a path of them.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneCamera {
    /// Metres; with `target`, or neither.
    pub eye: Option<Point>,
    /// Metres; apart from `eye`.
    pub target: Option<Point>,
    /// Height of the view, degrees.
    pub fov_deg: Option<FieldOfView>,
    /// Instead of all of them: keys over time.
    pub path: Option<Vec<CameraKey>>,
}

/// A moment of a camera's path.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraKey {
    /// Seconds.
    pub time_s: Number,
    /// Metres.
    pub eye: Point,
    /// Metres; apart from `eye`.
    pub target: Point,
    /// Height of the view, degrees.
    pub fov_deg: Option<FieldOfView>,
}

/// `[light]`: one of the two.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneLight {
    /// Towards a distant light, any length but 0.
    pub direction: Option<Point>,
    /// Place of a near light, metres.
    pub position: Option<Point>,
}

/// `[sequence]`.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneSequence {
    /// Pictures.
    pub frames: Option<Whole<100_000>>,
    /// Pictures a second.
    pub fps: Option<Whole<1000>>,
}

/// `[[model]]`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneModel {
    /// Its name in results; left out, the package's.
    pub name: Option<String>,
    /// Its package's path from the scene file's folder.
    pub package: String,
    /// Where it stands, metres.
    pub position: Option<Point>,
    /// Where to it looks: 0 along +z, 90 along +x.
    pub heading_deg: Option<Number>,
    /// Its size beside the baked one.
    pub scale: Option<Scale>,
    /// Instead of `position` and `heading_deg`: keys over time.
    pub path: Option<Vec<PlaceKey>>,
    /// What it plays, by name; left out, it stands at rest.
    pub clip: Option<String>,
    /// Seconds of the clip in a second.
    pub speed: Option<Number>,
    /// The clip's moment at time 0, seconds.
    pub start_s: Option<Number>,
    /// Whether the clip begins anew at its end, or holds there.
    #[serde(rename = "loop")]
    pub looped: Option<bool>,
    /// Whether the model goes on from where the clip has carried it when that begins anew; else it begins where it stands.
    #[serde(default)]
    pub root_motion: bool,
    /// Morph targets by name, at weights of their own whatever the clip does.
    #[serde(default)]
    pub morphs: BTreeMap<String, Number>,
}

/// A moment of a model's path.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlaceKey {
    /// Seconds.
    pub time_s: Number,
    /// Metres.
    pub position: Point,
    /// Degrees; in all keys of a path or in none.
    pub heading_deg: Option<Number>,
}

/// A number that is neither infinite nor absurd.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(try_from = "f64")]
pub struct Number(pub f32);

impl TryFrom<f64> for Number {
    type Error = String;

    fn try_from(x: f64) -> Result<Self, String> {
        within(x, -FARTHEST, FARTHEST).map(Self)
    }
}

/// Three of them.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(try_from = "[f64; 3]")]
pub struct Point(pub Vec3);

impl TryFrom<[f64; 3]> for Point {
    type Error = String;

    fn try_from(xyz: [f64; 3]) -> Result<Self, String> {
        let [x, y, z] = xyz.map(|x| within(x, -FARTHEST, FARTHEST));
        Ok(Self(Vec3::new(x?, y?, z?)))
    }
}

/// Height of a view, degrees.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(try_from = "f64")]
pub struct FieldOfView(pub f32);

impl TryFrom<f64> for FieldOfView {
    type Error = String;

    fn try_from(x: f64) -> Result<Self, String> {
        within(x, 1.0, 170.0).map(Self)
    }
}

/// A size beside the one that was baked.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(try_from = "f64")]
pub struct Scale(pub f32);

impl TryFrom<f64> for Scale {
    type Error = String;

    fn try_from(x: f64) -> Result<Self, String> {
        within(x, 1e-4, 1e4).map(Self)
    }
}

/// A whole number from 1 to `MOST`.
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
    // NaN is in no range.
    let inside = (least..=most).contains(&x);
    if inside { Ok(x as f32) } else { Err(format!("found {x}, expected a number from {least} to {most}")) }
}
